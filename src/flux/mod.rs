//! The flux of energy of waves in a linear waveguide, and what they lose on the way.
//!
//! Of one wave half of the energy is kinetic, and its group velocity carries all of it. From velocities, a mass per length and
//! the dispersion that the same records show follows how much power passes each site, both ways, at each frequency.

mod band;
mod law;
mod sheet;

use std::f64::consts::{LN_10, PI, TAU};
use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex;
use rayon::prelude::*;

use crate::analyze::Dispersion;
use crate::error::{Error, Result};
use crate::estimates::realisations::{FILLED, Realisations, Shots, TOGETHER, steadiness_of_field};
use crate::estimates::{
    Averaging, Independence, SIGNIFICANCE, Tapers, check_significance, first_of,
};
use crate::field::{Axis, Field, Quantity};
use crate::measure::{Length, LinearDensity, Measure, Time, size};
use crate::numeric::{student_two_sided, sum_of};
use crate::observer::Observer;
use crate::prepare::{Detrend, Gaps, Window};
use crate::ridges::{RidgePoint, Ridges, RidgesRequest, ridges};
use crate::sheet::Units;
use crate::system::check_memory;
use crate::system::memory::half_of_free_memory;
use crate::system::threads::in_pool;
use crate::transform::{Travelling, fold, frequencies};
use crate::unit::{compose, square};
use band::{Band, Found, GROUPS, Numbers, Row, error_without};

/// Frequencies of a band at least, where there are as many.
const LEAST_ROWS: usize = 8;
/// Points of ridges that the search of a band starts from.
const STARTS: usize = 5;
/// Share of the power of the strongest ridge above which another is a second wave.
const SECOND: f64 = 0.05;
/// Wavenumbers that differ by more than so many resolutions are those of two waves.
const APART: f64 = 2.0;
/// Power of the waves over that of the noise in as many unknowns, at least.
const OVER_NOISE: f64 = 2.0;
/// Phase, or logarithm of the amplitude, to which a wave is known over all sites at least: beyond it errors are none of a linear fit.
const KNOWN: f64 = 0.5;
/// Share of itself to which the group velocity is known at least.
const VELOCITY_KNOWN: f64 = 0.3;
/// Share of the shapes of the two waves that is not the same at least.
const TOLD_APART: f64 = 0.2;

/// Where the group velocity comes from.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum GroupVelocity {
    /// The slope of the wavenumbers that the waves have.
    #[default]
    Measured,
    /// This one, in units of length over units of time.
    Stated(f64),
    /// The slope of a relation, whose wavenumbers the waves have.
    Of(Dispersion),
}

/// All choices of [`flux`].
#[derive(Debug, Clone, PartialEq)]
pub struct FluxRequest {
    /// Mass of a unit of length, in SI units where the field has units; `None`: the flux is that of one unit of it.
    pub mass_per_length: Option<Measure<LinearDensity>>,
    pub group_velocity: GroupVelocity,
    /// Waves that there are: [`Travelling::Anywhere`] for both ways.
    pub towards: Travelling,
    /// Frequencies from and to, in cycles; `None`: those at which waves are found.
    pub band: Option<(f64, f64)>,
    /// Parts of the band with a number each, at most.
    pub bands: usize,
    /// Taper of the whole records; `None`: none for transients, [`Window::USUAL`] for steady records.
    pub window: Option<Window>,
    pub gaps: Gaps,
    /// Intervals hold with probability `1 - alpha`.
    pub alpha: f64,
    /// Worker threads; `None`: one a core.
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    pub memory: Option<u64>,
}

impl Default for FluxRequest {
    fn default() -> Self {
        FluxRequest {
            mass_per_length: None,
            group_velocity: GroupVelocity::Measured,
            towards: Travelling::Anywhere,
            band: None,
            bands: 24,
            window: None,
            gaps: Gaps::Refuse,
            alpha: SIGNIFICANCE,
            threads: None,
            memory: None,
        }
    }
}

/// Why no flux is stated of a band.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoFlux {
    /// Nothing stands above the noise.
    NoWave,
    /// Waves of several branches, or none of the stated relation.
    SeveralWaves,
    /// The wave decays within its length.
    Evanescent,
    /// The array is too short to tell both directions apart.
    Directions,
    /// The wavenumbers do not tell the group velocity.
    Velocity,
    /// Shots of other amplitudes have other wavenumbers.
    Amplitude,
}

/// A number with half of its interval; NaN where none is stated.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Known {
    pub value: f64,
    pub half: f64,
}

/// What a band of frequencies says.
#[derive(Debug, Clone)]
pub struct FluxBand {
    /// Ends, and the mean by power, in cycles.
    pub from: f64,
    pub to: f64,
    pub frequency: f64,
    pub reason: Option<NoFlux>,
    /// In rad; its sign is that of the wave whose energy goes towards later sites.
    pub wavenumber: Known,
    pub group_velocity: Known,
    /// Loss of amplitude in Np per unit of length.
    pub attenuation: Known,
    pub loss_factor: Known,
    pub quality_factor: Known,
    /// Found per site, of which the powers at all sites follow.
    found: Option<Found>,
}

/// What [`flux`] finds.
#[derive(Debug, Clone)]
pub struct Flux {
    pub time: Axis,
    pub space: Axis,
    pub n_sites: usize,
    /// Unit of the samples.
    pub unit: Option<String>,
    pub quantity: Quantity,
    /// The waves that were found: of them each band's search starts.
    pub scan: Ridges,
    /// Unit of power (energy).
    pub power_unit: String,
    /// Whether the flux is energy that passed, of a transient, and not power.
    pub is_transient: bool,
    pub alpha: f64,
    pub bands: Vec<FluxBand>,
    /// `[towards +x, towards -x, net]` of each band and site: power (energy) per unit of frequency.
    pub density: [Array2<f64>; 3],
    /// Half of their intervals.
    pub density_half: [Array2<f64>; 3],
    /// The same of all bands that are stated, summed over frequencies: of each site.
    pub total: [Vec<Known>; 3],
    /// Decibels per unit of length by which the larger of both totals falls.
    pub loss: Known,
    /// Share of the mean square of all samples, less their mean, that lies in bands with a flux.
    pub stated: f64,
}

impl Flux {
    /// Whether more goes towards -x.
    fn is_backward(&self) -> bool {
        let largest = |way: &[Known]| way.iter().fold(0.0, |m: f64, p| m.max(p.value));
        largest(&self.total[1]) > largest(&self.total[0])
    }
}

/// Flux of energy of the waves of one branch, and their loss.
///
/// # Equation
/// In a band of frequencies the spectra of each record are those of two waves and of noise,
///
/// ```text
/// X(f, x) = A(f) exp(-(a + i k(f)) x) + B(f) exp(+(a + i k(f)) x),
/// ```
///
/// with one loss `a` and a wavenumber `k` that is a parabola in f, by least squares over all frequencies of the band, in which
/// the amplitudes of each are free. Then
///
/// ```text
/// v_g = 2 pi df/dk,    P(f, x) = m v_g |A|^2 exp(-2 a x) towards +x, and with B towards -x,
/// loss factor = a v_g / (pi f) = 1 / Q,
/// ```
///
/// `|A|^2` as a one-sided power (energy) spectral density of velocity, without what noise adds. The cross terms of both waves, a share
/// `a / k` of the larger flux, change sign within half a wavelength and are left out.
///
/// Intervals are by the jackknife over groups of sites (noise, gains) and of frequencies; powers of steady records have their random
/// spread beside it, those of several shots the spread of these. Sources: B. Efron, "The Jackknife" (1982); G. H. Golub,
/// V. Pereyra, SIAM J. Numer. Anal. 10, 413 (1973), for the elimination of amplitudes; L. Cremer, M. Heckl, B. Petersson,
/// "Structure-Borne Sound" (2005), for the flux of waves and loss factors.
///
/// # Shapes and units
/// Each field is one record of every site (a shot). P in W per cycle, J of a transient, where mass and field have units; else
/// in those of the samples' square times a velocity.
///
/// # Errors
/// [`Error::Request`] for samples that are no motion, fewer than 8 sites, and choices that do not fit; those of
/// [`ridges`].
pub fn flux(fields: &[&Field], request: &FluxRequest, observer: &dyn Observer) -> Result<Flux> {
    check_significance(request.alpha)?;
    Error::require(request.bands > 0, "bands", "at least one", 0)?;
    if let GroupVelocity::Stated(velocity) = request.group_velocity {
        let expected = "a velocity above 0";
        Error::require(velocity > 0.0, "group-velocity", expected, velocity)?;
    }
    if let Some(mass) = request.mass_per_length {
        Error::require(
            mass.value > 0.0,
            "mass-per-length",
            "a mass above 0",
            mass.value,
        )?;
    }
    let first = first_of(fields)?;
    let is_transient = is_transient(fields, request.threads)?;
    let ridges_request = RidgesRequest {
        // A transient is seen best whole.
        segment: is_transient.then_some(first.n_times()),
        gaps: request.gaps,
        threads: request.threads,
        memory: request.memory,
        ..RidgesRequest::default()
    };
    let found = ridges(fields, &ridges_request, observer)?;
    if first.quantity == Quantity::Force {
        let expected = "velocities, displacements, accelerations or strain rates";
        return Err(Error::request("quantity", expected, first.quantity.name()));
    }
    in_pool(request.threads, || {
        Search::new(fields, request, (&found, is_transient), observer)?.run()
    })
}

/// Whether the first field is a transient.
///
/// # Errors
/// [`Error::Threads`].
fn is_transient(fields: &[&Field], threads: Option<usize>) -> Result<bool> {
    let (first, n) = (fields[0], fields[0].n_sites());
    in_pool(threads, || {
        let blocks = (0..n)
            .step_by(TOGETHER)
            .map(|from| from..n.min(from + TOGETHER));
        let steadiness = steadiness_of_field(first, blocks, FILLED);
        let number = [fields.len(), 1, 1];
        Ok(Independence::new(number, 1.0, steadiness, first.n_times()).is_transient())
    })
}

/// What is searched in.
struct Search<'a> {
    request: &'a FluxRequest,
    first: &'a Field,
    shots: usize,
    ridges: &'a Ridges,
    is_transient: bool,
    /// Whether sites are taken from the last one on, since all waves come from there.
    is_turned: bool,
    /// Of the power of one unit of mass per length, in units of the field, and its unit.
    power: (f64, String),
    /// `[shot, bin][site]`.
    spectra: Vec<Vec<Complex<f64>>>,
    frequency: Vec<f64>,
    /// Bins that a line has, by its power.
    shared: f64,
}

impl<'a> Search<'a> {
    fn new(
        fields: &'a [&'a Field],
        request: &'a FluxRequest,
        (ridges, is_transient): (&'a Ridges, bool),
        observer: &'a dyn Observer,
    ) -> Result<Self> {
        let first = fields[0];
        let usual = if is_transient {
            Window::None
        } else {
            Window::USUAL
        };
        let (window, times) = (request.window.unwrap_or(usual), first.n_times());
        let averaging = Averaging {
            segment: Some(times),
            overlap: None,
            tapers: Tapers::Window(window),
            detrend: if is_transient {
                Detrend::None
            } else {
                Detrend::Mean
            },
        };
        let realisations = Realisations::new(&averaging, times)?;
        let shots = Shots::new(fields, request.gaps, request.memory, times, observer)?;
        let (bins, n_sites) = (realisations.bins(), first.n_sites());
        let held = 32 * (bins * n_sites.next_multiple_of(TOGETHER) * shots.count()) as u64;
        let what = "the spectra of all sites, which are held,";
        check_memory(
            what,
            held,
            Some(request.memory.unwrap_or_else(half_of_free_memory)),
        )?;
        let mut tiles: Vec<Vec<Complex<f64>>> = vec![Vec::new(); shots.tiles()];
        shots.each(shots.block(what, held)?, |shot| {
            shot.each_tile("spectra", &mut tiles, |scratch, _, records, tile| {
                realisations.each(records, scratch, |_, spectra| {
                    tile.extend_from_slice(spectra)
                });
            })
        })?;
        let is_turned = request.towards == Travelling::TowardMinusX;
        let row = |row: usize| {
            let of_tile = |(t, tile): (usize, &Vec<Complex<f64>>)| {
                let width = TOGETHER.min(n_sites - t * TOGETHER);
                tile[row * width..(row + 1) * width].to_vec()
            };
            let mut sites: Vec<Complex<f64>> = tiles.iter().enumerate().flat_map(of_tile).collect();
            if is_turned {
                sites.reverse();
            }
            sites
        };
        let taper = &realisations.tapers[0];
        Ok(Search {
            request,
            first,
            shots: fields.len(),
            ridges,
            is_transient,
            is_turned,
            power: power_unit(first, request.mass_per_length, is_transient)?,
            spectra: (0..shots.count() * bins).map(row).collect(),
            frequency: frequencies(times, first.time.step),
            shared: times as f64 * sum_of(taper.iter().map(|w| w.powi(4))),
        })
    }

    fn run(&self) -> Result<Flux> {
        let law = match &self.request.group_velocity {
            GroupVelocity::Of(law) => Some(law::Waves::of(law, &self.ridges.analysis.axes)?),
            _ => None,
        };
        let bins = self.bands(law.as_ref())?;
        let starts = |bins: &Range<usize>| match &law {
            Some(_) => Ok(Vec::new()),
            None => self.starts(self.ends(bins)),
        };
        let first = |bins: &Range<usize>| self.band(bins, starts(bins), law.as_ref());
        let mut bands: Vec<FluxBand> = bins.par_iter().map(first).collect();
        // What is found of a band leads to its neighbours.
        while law.is_none() {
            let again = |b: usize| {
                let start = Self::start_beside(&bands, b)?;
                let band = self.band(&bins[b], Ok(vec![start]), None);
                band.found.is_some().then_some((b, band))
            };
            let better: Vec<_> = (0..bands.len()).into_par_iter().filter_map(again).collect();
            if better.is_empty() {
                break;
            }
            better.into_iter().for_each(|(b, band)| bands[b] = band);
        }
        Ok(self.summed(bands))
    }

    /// Wavenumber and group velocity in the middle of a band in which no wave was found, as a neighbour has them.
    fn start_beside(bands: &[FluxBand], b: usize) -> Option<[f64; 2]> {
        let (own, beside) = (&bands[b], [b.checked_sub(1), Some(b + 1)]);
        if own.found.is_some() || own.reason == Some(NoFlux::SeveralWaves) {
            return None;
        }
        let mut beside = beside.into_iter().flatten().filter_map(|b| bands.get(b));
        let known = beside.find(|band| band.found.is_some())?;
        let (velocity, away) = (known.group_velocity.value, own.frequency - known.frequency);
        Some([known.wavenumber.value + TAU * away / velocity, velocity])
    }

    /// The ends of a band in cycles.
    fn ends(&self, bins: &Range<usize>) -> [f64; 2] {
        [bins.start, bins.end].map(|bin| (bin as f64 - 0.5) * self.frequency[1])
    }

    /// Bins of each band.
    fn bands(&self, law: Option<&law::Waves>) -> Result<Vec<Range<usize>>> {
        let width = self.frequency[1];
        let (mut low, mut high) = match (self.request.band, law) {
            (Some(band), _) => band,
            (None, Some(law)) => (0.0, law.highest()),
            (None, None) => {
                let points = self.ridges.points().map(|point| point.frequency);
                let all: Vec<f64> = points.collect();
                let low = all.iter().copied().fold(f64::INFINITY, f64::min);
                let half = 0.5 * self.ridges.bins[0];
                (low - half, all.into_iter().fold(0.0, f64::max) + half)
            }
        };
        // Without a direction: the mean, but of waves that are stated to go one way, and the Nyquist frequency.
        let is_both = self.request.towards == Travelling::Anywhere;
        low = low.max(if is_both || law.is_none() { width } else { 0.0 });
        high = high.min(width * (self.first.n_times().div_ceil(2) - 1) as f64);
        let bin = |frequency: f64| (frequency / width).round().max(0.0) as usize;
        if low > high {
            return Ok(Vec::new());
        }
        let (from, to) = (bin(low), bin(high) + 1);
        let count = ((to - from) / LEAST_ROWS).clamp(1, self.request.bands);
        let edge = |n: usize| from + n * (to - from) / count;
        Ok((0..count).map(|n| edge(n)..edge(n + 1)).collect())
    }

    /// The flux of a band.
    fn band(
        &self,
        bins: &Range<usize>,
        starts: Result<Vec<[f64; 2]>, NoFlux>,
        law: Option<&law::Waves>,
    ) -> FluxBand {
        let [from, to] = self.ends(bins);
        let mut band = FluxBand {
            from: from.max(0.0),
            to,
            frequency: 0.5 * (from + to),
            reason: None,
            wavenumber: Known::NONE,
            group_velocity: Known::NONE,
            attenuation: Known::NONE,
            loss_factor: Known::NONE,
            quality_factor: Known::NONE,
            found: None,
        };
        match starts.and_then(|starts| self.found(bins, &starts, law)) {
            Ok(found) => self.fill(&mut band, found),
            Err(reason) => band.reason = Some(reason),
        }
        band
    }

    fn found(
        &self,
        bins: &Range<usize>,
        starts: &[[f64; 2]],
        law: Option<&law::Waves>,
    ) -> Result<Found, NoFlux> {
        let ([from, to], site) = (self.ends(bins), self.first.space.step);
        let stated = match self.request.group_velocity {
            GroupVelocity::Stated(velocity) => Some(velocity),
            _ => None,
        };
        let mut rows = Vec::new();
        for bin in bins.clone() {
            let frequency = self.frequency[bin];
            let of_law = law.map(|law| law.at(frequency).ok_or(NoFlux::SeveralWaves));
            let of_law = of_law.transpose()?;
            let velocity = of_law.map(|[_, velocity]| velocity).or(stated);
            for shot in 0..self.shots {
                rows.push(Row {
                    spectrum: &self.spectra[shot * self.frequency.len() + bin],
                    frequency,
                    wavenumber: of_law.map_or(0.0, |[wavenumber, _]| wavenumber * site),
                    velocity: velocity.map(|velocity| velocity / site),
                    weight: self.weight(bin),
                });
            }
        }
        let is_both = self.request.towards == Travelling::Anywhere;
        let band = Band {
            rows,
            shots: self.shots,
            starts: starts
                .iter()
                .map(|[k, velocity]| [k * site, velocity / site])
                .collect(),
            is_strain: self.first.quantity == Quantity::StrainRate,
            is_both,
            middle: 0.5 * (from + to),
            half: 0.5 * (to - from),
        };
        let found = band.found();
        let span = (self.first.n_sites() - 1) as f64;
        let error = |of: fn(&Numbers) -> f64| found.errors(of)[0].hypot(found.errors(of)[1]);
        let is_known = |of: fn(&Numbers) -> f64| error(of) * span < KNOWN;
        let Numbers {
            loss,
            wavenumber,
            velocity,
            ..
        } = found.numbers;
        let is_wave =
            found.over_noise > OVER_NOISE && is_known(|n| n.loss) && is_known(|n| n.wavenumber);
        if !is_wave {
            Err(NoFlux::NoWave)
        } else if loss.abs() > wavenumber.abs() / TAU && wavenumber != 0.0 {
            Err(NoFlux::Evanescent)
        } else if is_both && found.apart < TOLD_APART {
            Err(NoFlux::Directions)
        } else if !(velocity > 0.0 && error(|n| n.velocity) < VELOCITY_KNOWN * velocity) {
            Err(NoFlux::Velocity)
        } else if found.follows_amplitude {
            Err(NoFlux::Amplitude)
        } else {
            Ok(found)
        }
    }

    /// Wavenumbers in the middle of a band and group velocities of its strongest ridge points, with the sign of a wave whose
    /// energy goes to +x.
    fn starts(&self, [from, to]: [f64; 2]) -> Result<Vec<[f64; 2]>, NoFlux> {
        let [resolution, apart] = self.ridges.resolution;
        let is_near = |p: &&RidgePoint| {
            (from - resolution..=to + resolution).contains(&p.frequency)
                && p.group_velocity.is_finite()
        };
        let mut near: Vec<&RidgePoint> = self.ridges.points().filter(is_near).collect();
        near.sort_by(|a, b| b.power.total_cmp(&a.power));
        let strongest = near.first().ok_or(NoFlux::NoWave)?;
        let at = |p: &RidgePoint, f: f64| {
            let k = p.wavenumber * p.group_velocity.signum();
            k + TAU * (f - p.frequency) / p.group_velocity.abs()
        };
        let is_other = |p: &&RidgePoint| {
            p.power > SECOND * strongest.power
                && (p.frequency - strongest.frequency).abs() <= resolution
                && (at(p, p.frequency) - at(strongest, p.frequency)).abs() > APART * apart
        };
        if near.iter().any(is_other) {
            return Err(NoFlux::SeveralWaves);
        }
        near.truncate(STARTS);
        let start = |p: &&RidgePoint| [at(p, 0.5 * (from + to)), p.group_velocity.abs()];
        Ok(near.iter().map(start).collect())
    }

    /// What the square of an amplitude at a bin is multiplied by to be a part of the power (energy) that passes, over the group
    /// velocity.
    fn weight(&self, bin: usize) -> f64 {
        let (times, step) = (self.first.n_times(), self.first.time.step);
        let omega = TAU * self.frequency[bin];
        let of_velocity = match self.first.quantity {
            Quantity::Displacement => omega,
            Quantity::Acceleration => 1.0 / omega,
            // Per site, divided by the wavenumber of the wave.
            Quantity::StrainRate => self.first.space.step,
            Quantity::Velocity | Quantity::Force => 1.0,
        };
        let measure = if self.is_transient {
            step
        } else {
            1.0 / times as f64
        };
        self.power.0 * self.first.space.step * measure * fold(bin, times) * of_velocity.powi(2)
            / self.shots as f64
    }

    /// Half of an interval by the errors of sites, rows and shots, and a random spread, with the degrees of freedom of their sum
    /// (Welch and Satterthwaite).
    fn half(&self, [sites, rows, shots]: [f64; 3], spread: f64) -> f64 {
        let groups = GROUPS as f64 - 1.0;
        let parts = [
            (sites, groups),
            (rows, groups),
            (shots, self.shots as f64 - 1.0),
        ];
        let parts = parts.iter().filter(|(error, _)| *error > 0.0);
        let uncertain: f64 = parts.map(|(error, degrees)| error.powi(4) / degrees).sum();
        let variance = sites * sites + rows * rows + shots * shots + spread;
        match uncertain > 0.0 {
            true => {
                variance.sqrt()
                    * student_two_sided(self.request.alpha, variance * variance / uncertain)
            }
            false => 0.0,
        }
    }

    fn known(&self, found: &Found, of: impl Fn(&Numbers) -> f64) -> Known {
        Known {
            value: of(&found.numbers),
            half: self.half(found.errors(of), 0.0),
        }
    }

    fn fill(&self, band: &mut FluxBand, found: Found) {
        let site = self.first.space.step;
        let frequency = found.numbers.frequency;
        let factor = move |n: &Numbers| n.loss * n.velocity / (PI * frequency);
        band.frequency = frequency;
        band.wavenumber = self.known(&found, |n| n.wavenumber / site);
        band.group_velocity = self.known(&found, |n| n.velocity * site);
        band.attenuation = self.known(&found, |n| n.loss / site);
        band.loss_factor = self.known(&found, factor);
        let Known { value, half } = band.loss_factor;
        // An interval of the loss factor that holds 0 has no quality factor.
        if value - half > 0.0 {
            band.quality_factor = Known {
                value: 1.0 / value,
                half: half / (value * value),
            };
        }
        band.found = Some(found);
    }

    /// Powers at all sites, and their totals.
    fn summed(&self, bands: Vec<FluxBand>) -> Flux {
        let n = self.first.n_sites();
        // Of a band at a site: towards +x, towards -x, net.
        let at = |numbers: &Numbers, site: usize| {
            let decay = |sites: usize| (-2.0 * numbers.loss * sites as f64).exp();
            let (to_later, to_earlier) = (decay(site), decay(n - 1 - site));
            let [plus, minus] = match self.is_turned {
                true => [0.0, numbers.flux[0] * to_earlier],
                false => [numbers.flux[0] * to_later, numbers.flux[1] * to_earlier],
            };
            [plus, minus, plus - minus]
        };
        // The random spread of powers as a variance: of shots, or of a steady record's bins.
        let spread = |found: &Found, site: usize| -> [f64; 3] {
            let powers = at(&found.numbers, site);
            let relative = |wave: usize| match self.is_transient
                || self.shots > 1
                || found.numbers.flux[wave] == 0.0
            {
                true => 0.0,
                false => self.shared * found.squares[wave] / found.numbers.flux[wave].powi(2),
            };
            let [plus, minus] = if self.is_turned { [1, 0] } else { [0, 1] };
            let plus = relative(plus) * powers[0].powi(2);
            let minus = relative(minus) * powers[1].powi(2);
            [plus, minus, plus + minus]
        };
        let zeros = || [(); 3].map(|()| Array2::from_elem((bands.len(), n), f64::NAN));
        let (mut density, mut density_half) = (zeros(), zeros());
        for (b, band) in bands.iter().enumerate() {
            let Some(found) = &band.found else { continue };
            for site in 0..n {
                let (values, spread) = (at(&found.numbers, site), spread(found, site));
                for way in 0..3 {
                    let errors = found.errors(|numbers| at(numbers, site)[way]);
                    let half = self.half(errors, spread[way]);
                    density[way][[b, site]] = values[way] / (band.to - band.from);
                    density_half[way][[b, site]] = half / (band.to - band.from);
                }
            }
        }
        let stated: Vec<&Found> = bands
            .iter()
            .filter_map(|band| band.found.as_ref())
            .collect();
        let total = |of: &dyn Fn(&Numbers, usize) -> f64, way: usize, site: usize| {
            let value: f64 = stated.iter().map(|found| of(&found.numbers, site)).sum();
            let errors = self.errors_of_all(&stated, &|numbers| of(numbers, site));
            let spread: f64 = stated.iter().map(|found| spread(found, site)[way]).sum();
            Known {
                value,
                half: self.half(errors, spread),
            }
        };
        let totals = [0, 1, 2].map(|way| {
            let of = move |numbers: &Numbers, site: usize| at(numbers, site)[way];
            (0..n)
                .map(|site| total(&of, way, site))
                .collect::<Vec<Known>>()
        });
        let power = |rows: &mut dyn Iterator<Item = usize>| -> f64 {
            let row = |row: usize| {
                let squares = self.spectra[row].iter().map(Complex::norm_sqr);
                fold(row % self.frequency.len(), self.first.n_times()) * squares.sum::<f64>()
            };
            rows.map(row).sum()
        };
        let bins = self.frequency.len();
        let is_stated = |row: &usize| {
            let frequency = self.frequency[row % bins];
            let within = |band: &FluxBand| (band.from..band.to).contains(&frequency);
            bands
                .iter()
                .any(|band| band.found.is_some() && within(band))
        };
        let share = power(&mut (0..self.spectra.len()).filter(is_stated));
        let all = power(&mut (0..self.spectra.len()).filter(|row| row % bins > 0));
        let mut flux = Flux {
            time: self.first.time.clone(),
            space: self.first.space.clone(),
            n_sites: n,
            unit: self.first.unit.clone(),
            quantity: self.first.quantity,
            scan: self.ridges.clone(),
            power_unit: self.power.1.clone(),
            is_transient: self.is_transient,
            alpha: self.request.alpha,
            density,
            density_half,
            total: totals,
            loss: Known::NONE,
            stated: share / all,
            bands: Vec::new(),
        };
        flux.loss = self.loss(&stated, usize::from(flux.is_backward()), &at);
        flux.bands = bands;
        flux
    }

    /// Standard errors of the sum over bands of a quantity: sites and shots are left out of all at once, rows of each.
    fn errors_of_all(&self, stated: &[&Found], of: &dyn Fn(&Numbers) -> f64) -> [f64; 3] {
        let sums = |list: usize| {
            let groups = stated.first().map_or(0, |found| found.without[list].len());
            let without = |g: usize| stated.iter().map(|found| of(&found.without[list][g])).sum();
            error_without(&(0..groups).map(without).collect::<Vec<f64>>())
        };
        let rows = stated.iter().map(|found| found.errors(of)[1].powi(2));
        [sums(0), rows.sum::<f64>().sqrt(), sums(2)]
    }

    /// Decibels per unit of length that the total of a direction loses over all sites.
    fn loss(
        &self,
        stated: &[&Found],
        way: usize,
        at: &dyn Fn(&Numbers, usize) -> [f64; 3],
    ) -> Known {
        let last = self.first.n_sites() - 1;
        let length = last as f64 * self.first.space.step;
        let sum = |site: usize| {
            stated
                .iter()
                .map(|found| at(&found.numbers, site)[way])
                .sum::<f64>()
        };
        let (begin, end) = (sum(0), sum(last));
        let factor = 10.0 / LN_10 / length * if end > begin { -1.0 } else { 1.0 };
        // To first order, the logarithm of the ratio.
        let ratio = |numbers: &Numbers| at(numbers, 0)[way] / begin - at(numbers, last)[way] / end;
        Known {
            value: factor * (begin / end).ln(),
            half: self.half(
                self.errors_of_all(stated, &ratio)
                    .map(|error| factor.abs() * error),
                0.0,
            ),
        }
    }
}

/// What the power of one unit of mass per length is multiplied by in units of the field, and its unit.
///
/// # Errors
/// [`Error::Request`] for a mass with a unit where the field's have no size.
fn power_unit(
    field: &Field,
    mass: Option<Measure<LinearDensity>>,
    is_transient: bool,
) -> Result<(f64, String)> {
    let units = Units::of(&field.time, &field.space, field.unit.as_deref());
    let sample = field.unit.as_deref().unwrap_or_default();
    let [time, space] = [&units.time[..], &units.space];
    let velocity = match field.quantity {
        Quantity::Displacement => compose(&[sample], &[time]),
        Quantity::Acceleration => compose(&[sample, time], &[]),
        Quantity::StrainRate => compose(&[sample, space], &[]),
        Quantity::Velocity | Quantity::Force => sample.to_owned(),
    };
    let passed = if is_transient { time } else { "" };
    let own = compose(
        &[&square(&velocity), &compose(&[space], &[time]), passed],
        &[],
    );
    let Some(mass) = mass else {
        return Ok((1.0, own));
    };
    let sizes = || {
        let (time, space) = (size::<Time>(time)?, size::<Length>(space)?);
        let velocity = match (field.quantity, sample.split_once('/')) {
            (Quantity::Displacement, _) => size::<Length>(sample)? / time,
            (Quantity::Velocity, Some((over, under))) => {
                size::<Length>(over)? / size::<Time>(under)?
            }
            (Quantity::Acceleration, Some((over, under))) => {
                let under = under.strip_suffix("^2").or(under.strip_suffix('²'))?;
                size::<Length>(over)? / size::<Time>(under)?.powi(2) * time
            }
            (Quantity::StrainRate, Some(("1" | "strain", under))) => space / size::<Time>(under)?,
            _ => return None,
        };
        Some(velocity.powi(2) * space / time * if is_transient { time } else { 1.0 })
    };
    match sizes() {
        Some(size) => Ok((
            size * mass.value,
            if is_transient { "J" } else { "W" }.into(),
        )),
        None if mass.has_unit => {
            let expected = "a number: samples, times and positions have no units that are known";
            Err(Error::request(
                "mass-per-length",
                expected,
                format!("{mass:?}"),
            ))
        }
        None => Ok((mass.value, own)),
    }
}

impl Known {
    const NONE: Known = Known {
        value: f64::NAN,
        half: f64::NAN,
    };
}
