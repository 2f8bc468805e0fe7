//! The search of the waves of each band, and the sums of what is found.

use std::f64::consts::{LN_10, PI, TAU};
use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex;
use rayon::prelude::*;

use super::band::{Band, Found, GROUPS, Numbers, Row};
use super::{Flux, FluxBand, FluxRequest, GroupVelocity, Known, NoFlux};
use crate::analyze::DispersionCurve;
use crate::error::{Error, Result};
use crate::estimates::realisations::{Realisations, Shots, TOGETHER};
use crate::estimates::{Averaging, Tapers};
use crate::field::{Field, Quantity};
use crate::measure::{Length, LinearDensity, Measure, Time, size};
use crate::numeric::{jackknife, student_two_sided};
use crate::observer::Observer;
use crate::prepare::{Detrend, Window};
use crate::ridges::{RidgePoint, Ridges};
use crate::sheet::Units;
use crate::transform::{Travelling, fold, frequencies};
use crate::unit::{compose, square};

/// Frequencies of a band at least, of transients and of steady records, whose window spreads each over its neighbours.
const LEAST_ROWS: [usize; 2] = [8, 40];
/// Points of ridges that the search of a band starts from.
const STARTS: usize = 3;
/// Share of the power above which another ridge, so many resolutions away, or what the waves leave, is a second wave.
const SECOND: f64 = 0.05;
const APART: f64 = 2.0;
/// Share of what the waves leave that one wavenumber holds above which it is another wave.
const IN_ONE: f64 = 0.4;
/// Power of the waves over that of the noise in as many unknowns, at least.
const OVER_NOISE: f64 = 2.0;
/// Phase, or logarithm of the amplitude, to which a wave is known over all sites at least: beyond it errors are none of a linear fit.
const KNOWN: f64 = 0.5;
/// Share of itself to which the group velocity is known at least.
const VELOCITY_KNOWN: f64 = 0.3;
/// Share of the shapes of the two waves that is not the same at least.
const TOLD_APART: f64 = 0.2;

/// Factor between the power at an end and that of the waves there at most.
const AT_ENDS: f64 = 1.5;

/// What is searched in.
pub(super) struct Search<'a> {
    request: &'a FluxRequest,
    shots: usize,
    scan: &'a Ridges,
    law: Option<DispersionCurve>,
    is_transient: bool,
    /// Of one unit of velocity squared times a velocity at each site of a cell, and its unit.
    power: (Vec<f64>, String),
    /// `[shot, bin, site of the cell][cell]`, from the last one on where all waves come from there.
    spectra: Vec<Vec<Complex<f64>>>,
    frequency: Vec<f64>,
    n_times: usize,
    /// Of whole cells.
    n_sites: usize,
    /// Length of a cell.
    site: f64,
    is_strain: bool,
    positions: Vec<f64>,
}

impl<'a> Search<'a> {
    pub fn new(
        fields: &'a [&'a Field],
        request: &'a FluxRequest,
        scan: &'a Ridges,
        law: Option<DispersionCurve>,
        observer: &'a dyn Observer,
    ) -> Result<Self> {
        let (field, is_transient) = (fields[0], scan.independence.is_transient());
        let (n_times, n_sites) = (field.n_times(), field.n_sites());
        let (window, detrend) = match is_transient {
            true => (Window::None, Detrend::None),
            false => (Window::USUAL, Detrend::Mean),
        };
        let averaging = Averaging {
            segment: Some(n_times),
            overlap: None,
            tapers: Tapers::Window(window),
            detrend,
        };
        let realisations = Realisations::new(&averaging, n_times)?;
        let shots = Shots::new(fields, request.gaps, request.memory, n_times, observer)?;
        let held = 32 * (realisations.bins() * shots.tiles() * TOGETHER * shots.count()) as u64;
        let what = "the spectra of all sites, which are held,";
        let mut tiles: Vec<Vec<Complex<f64>>> = vec![Vec::new(); shots.tiles()];
        shots.each(shots.block(what, held)?, |shot| {
            shot.each_tile("spectra", &mut tiles, |scratch, _, records, tile| {
                realisations.each(records, scratch, |_, spectra| {
                    tile.extend_from_slice(spectra)
                });
            })
        })?;
        let (mut masses, unit) = power(field, &request.mass_per_length, is_transient)?;
        let (cell, is_reversed) = (masses.len(), request.towards == Travelling::TowardMinusX);
        if is_reversed {
            masses.reverse();
        }
        let row = |row: usize| {
            let of_tile = |(t, tile): (usize, &Vec<Complex<f64>>)| {
                let width = TOGETHER.min(n_sites - t * TOGETHER);
                tile[row * width..(row + 1) * width].to_vec()
            };
            let mut sites: Vec<_> = tiles.iter().enumerate().flat_map(of_tile).collect();
            sites.truncate(n_sites / cell * cell);
            if is_reversed {
                sites.reverse();
            }
            (0..cell).map(move |first| sites[first..].iter().step_by(cell).copied().collect())
        };
        Ok(Search {
            request,
            shots: fields.len(),
            scan,
            law,
            is_transient,
            power: (masses, unit),
            spectra: (0..shots.count() * realisations.bins())
                .flat_map(row)
                .collect(),
            frequency: frequencies(n_times, field.time.step),
            n_times,
            n_sites: n_sites / cell * cell,
            site: cell as f64 * field.space.step,
            is_strain: field.quantity == Quantity::StrainRate,
            positions: (0..n_sites / cell * cell)
                .map(|j| field.space.at(j))
                .collect(),
        })
    }

    pub fn run(&self) -> Result<Flux> {
        let bins = self.bands();
        let first = |bins: &Range<usize>| self.band(bins, self.starts(bins));
        let mut bands: Vec<FluxBand> = bins.par_iter().map(first).collect();
        // What is found of a band leads to its neighbours.
        while self.law.is_none() {
            let again = |b: usize| {
                let own = &bands[b];
                let is_open = own.found.is_none()
                    && self.starts(&bins[b]).err() != Some(NoFlux::SeveralWaves);
                let beside = [b.checked_sub(1), Some(b + 1)];
                let mut beside = beside.into_iter().flatten().filter_map(|b| bands.get(b));
                let known = beside.find(|band| is_open && band.found.is_some())?;
                let (velocity, away) =
                    (known.group_velocity.value, own.frequency - known.frequency);
                let start = [known.wavenumber.value + TAU * away / velocity, velocity];
                let band = self.band(&bins[b], Ok(vec![start]));
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

    fn is_both(&self) -> bool {
        self.request.towards == Travelling::Anywhere
    }

    /// Bins of each band: where there are ridges or frequencies of the law, but those without a direction.
    fn bands(&self) -> Vec<Range<usize>> {
        let all: Vec<f64> = match &self.law {
            Some(law) => law
                .branches
                .concat()
                .into_iter()
                .filter(|f| f.is_finite())
                .collect(),
            None => self.scan.points().map(|point| point.frequency).collect(),
        };
        let bin = |frequency: f64| (frequency / self.frequency[1]).round() as usize;
        // The mean has a flux if nothing comes back.
        let least = usize::from(self.is_both() || self.law.is_none());
        let from = bin(all.iter().copied().fold(f64::INFINITY, f64::min)).max(least);
        let to = (bin(all.into_iter().fold(0.0, f64::max)) + 1).min(self.n_times.div_ceil(2));
        let least = LEAST_ROWS[usize::from(!self.is_transient)];
        let count = (to.saturating_sub(from) / least).min(self.request.bands);
        let edge = |n: usize| from + n * (to - from) / count;
        (0..count).map(|n| edge(n)..edge(n + 1)).collect()
    }

    /// The ends of a band in cycles.
    fn ends(&self, bins: &Range<usize>) -> [f64; 2] {
        [bins.start, bins.end].map(|bin| (bin as f64 - 0.5) * self.frequency[1])
    }

    /// Wavenumbers in the middle of a band and group velocities of its strongest ridge points, with the sign of a wave whose
    /// energy goes to +x.
    fn starts(&self, bins: &Range<usize>) -> Result<Vec<[f64; 2]>, NoFlux> {
        if self.law.is_some() {
            return Ok(vec![[0.0, f64::INFINITY]]);
        }
        let ([from, to], [resolution, apart]) = (self.ends(bins), self.scan.resolution);
        let near = from - resolution..=to + resolution;
        let is_near = |p: &&RidgePoint| near.contains(&p.frequency) && p.group_velocity.is_finite();
        let mut near: Vec<&RidgePoint> = self.scan.points().filter(is_near).collect();
        near.sort_by(|a, b| b.power.total_cmp(&a.power));
        let strongest = *near.first().ok_or(NoFlux::NoWave)?;
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
        let start = |p: &&RidgePoint| [at(p, 0.5 * (from + to)), p.group_velocity.abs()];
        Ok(near.iter().take(STARTS).map(start).collect())
    }

    /// Wavenumber up to the cells' Nyquist wavenumber and group velocity that the law has at a frequency, by a parabola through three of its
    /// points.
    fn of_law(&self, law: &DispersionCurve, frequency: f64) -> Result<[f64; 2], NoFlux> {
        let zero = law.wavenumber.len() / 2;
        let k = &law.wavenumber[zero..];
        let last = (k.len() - 1) / self.power.0.len();
        let is_crossed = |f: &[f64]| {
            f[0] <= frequency && frequency < f[1] || f[1] <= frequency && frequency < f[0]
        };
        let places = law.branches.iter().flat_map(|branch| {
            let pairs = branch[zero..=zero + last].windows(2).enumerate();
            let places = pairs.filter(|(_, pair)| is_crossed(pair));
            places.map(move |(i, _)| (&branch[zero..], i.min(k.len() - 3)))
        });
        let places: Vec<(&[f64], usize)> = places.collect();
        let [(f, i)] = places[..] else {
            return Err(NoFlux::SeveralWaves);
        };
        let slope = |a: usize| (k[a + 1] - k[a]) / (f[a + 1] - f[a]);
        let bend = (slope(i + 1) - slope(i)) / (f[i + 2] - f[i]);
        let wavenumber = k[i] + (frequency - f[i]) * (slope(i) + (frequency - f[i + 1]) * bend);
        let velocity = TAU / (slope(i) + (2.0 * frequency - f[i] - f[i + 1]) * bend);
        Ok([wavenumber * velocity.signum(), velocity.abs()])
    }

    /// The flux of a band.
    fn band(&self, bins: &Range<usize>, starts: Result<Vec<[f64; 2]>, NoFlux>) -> FluxBand {
        let [from, to] = self.ends(bins);
        let found = starts.and_then(|starts| self.found(bins, &starts));
        let known = |of: &dyn Fn(&Numbers) -> f64| match &found {
            Ok(found) => Known {
                value: of(&found.numbers),
                half: self.half([found.error(of), 0.0]),
            },
            Err(_) => Known::NONE,
        };
        let frequency = found
            .as_ref()
            .map_or(0.5 * (from + to), |found| found.numbers.frequency);
        FluxBand {
            from: from.max(0.0),
            to,
            frequency,
            reason: found.as_ref().err().copied(),
            wavenumber: known(&|n| n.wavenumber / self.site),
            group_velocity: known(&|n| n.velocity * self.site),
            attenuation: known(&|n| n.loss / self.site),
            loss_factor: known(&|n| n.loss * n.velocity / (PI * frequency)),
            found: found.ok(),
        }
    }

    fn found(&self, bins: &Range<usize>, starts: &[[f64; 2]]) -> Result<Found, NoFlux> {
        let ([from, to], site) = (self.ends(bins), self.site);
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let mut rows = Vec::new();
        for bin in bins.clone() {
            let frequency = self.frequency[bin];
            let law = self.law.as_ref().map(|law| self.of_law(law, frequency));
            let [wavenumber, velocity] = law.transpose()?.unwrap_or([0.0, f64::NAN]);
            let velocity = match self.request.group_velocity {
                GroupVelocity::Measured => None,
                GroupVelocity::Stated(velocity) => Some(velocity / site),
                GroupVelocity::Of(_) => Some(velocity / site),
            };
            let weight = site * fold(bin, self.n_times) / self.shots as f64;
            let cell = self.power.0.len();
            let all = (0..cell).flat_map(|first| (0..self.shots).map(move |shot| (first, shot)));
            rows.extend(all.map(|(first, shot)| Row {
                spectrum: &self.spectra[(shot * self.frequency.len() + bin) * cell + first],
                frequency,
                offset: (frequency - middle) / half,
                wavenumber: wavenumber * site,
                velocity,
                weight: weight * self.power.0[first],
                beyond: [first, cell - 1 - first].map(|sites| sites as f64 / cell as f64),
            }));
        }
        let band = Band {
            rows,
            shots: self.shots,
            starts: starts
                .iter()
                .map(|[k, v]| [0.0, k * site, TAU * half * site / v, 0.0])
                .collect(),
            unknowns: if self.law.is_some() { 1 } else { 4 },
            is_both: self.is_both(),
            is_single: self.is_transient && self.shots == 1,
            half,
            strain: self.is_strain.then_some(site),
        };
        let found = band.found();
        let span = (self.n_sites / self.power.0.len() - 1) as f64;
        let Numbers {
            loss,
            wavenumber,
            velocity,
            ..
        } = found.numbers;
        let is_known = |of: fn(&Numbers) -> f64| found.error(of) * span < KNOWN;
        let is_wave =
            found.over_noise > OVER_NOISE && is_known(|n| n.loss) && is_known(|n| n.wavenumber);
        let is_moving = velocity > 0.0 && found.error(|n| n.velocity) < VELOCITY_KNOWN * velocity;
        match () {
            () if found.left[0] > SECOND && found.left[1] > IN_ONE => Err(NoFlux::SeveralWaves),
            () if !is_wave => Err(NoFlux::NoWave),
            () if found.ends > AT_ENDS => Err(NoFlux::Ends),
            () if loss.abs() > wavenumber.abs() / TAU && wavenumber != 0.0 => {
                Err(NoFlux::Evanescent)
            }
            () if self.is_both() && found.apart < TOLD_APART => Err(NoFlux::Directions),
            () if !is_moving => Err(NoFlux::Velocity),
            () => Ok(found),
        }
    }

    /// Half of an interval by independent standard errors.
    fn half(&self, [a, b]: [f64; 2]) -> f64 {
        let groups = if self.shots > 1 {
            self.shots.min(GROUPS)
        } else {
            GROUPS
        };
        a.hypot(b) * student_two_sided(self.request.alpha, groups as f64 - 1.0)
    }

    /// Flux of a band at a site: towards +x, towards -x, net.
    fn at(&self, numbers: &Numbers, site: usize) -> [f64; 3] {
        let decay =
            |sites: usize| (-2.0 * numbers.loss * sites as f64 / self.power.0.len() as f64).exp();
        let (later, earlier) = (decay(site), decay(self.n_sites - 1 - site));
        let [first, second] = numbers.flux;
        match self.request.towards {
            Travelling::TowardMinusX => [0.0, first * earlier, -first * earlier],
            _ => [
                first * later,
                second * earlier,
                first * later - second * earlier,
            ],
        }
    }

    /// Powers at all sites, and their totals.
    fn summed(&self, bands: Vec<FluxBand>) -> Flux {
        let stated: Vec<&Found> = bands
            .iter()
            .filter_map(|band| band.found.as_ref())
            .collect();
        // Sites are left out of all bands at once, rows of each.
        let known = |found: &[&Found], of: &dyn Fn(&Numbers) -> f64| {
            let without = |g: usize| found.iter().map(|found| of(&found.without[0][g])).sum();
            let groups = found.first().map_or(0, |found| found.without[0].len());
            let sites: Vec<f64> = (0..groups).map(without).collect();
            let rows = found
                .iter()
                .map(|found| found.errors(of)[1].powi(2))
                .sum::<f64>();
            Known {
                value: found.iter().map(|found| of(&found.numbers)).sum(),
                half: self.half([jackknife(&sites), rows.sqrt()]),
            }
        };
        let density = [0, 1, 2].map(|way| {
            let of_band = |[b, site]: [usize; 2]| match (&bands[b], &bands[b].found) {
                (band, Some(found)) => {
                    let known = known(&[found], &|numbers| self.at(numbers, site)[way]);
                    [known.value, known.half].map(|value| value / (band.to - band.from))
                }
                _ => [f64::NAN; 2],
            };
            let all = Array2::from_shape_fn((bands.len(), self.n_sites), |(b, j)| of_band([b, j]));
            [all.mapv(|pair| pair[0]), all.mapv(|pair| pair[1])]
        });
        let total = [0, 1, 2].map(|way| {
            let at = |site| known(&stated, &|numbers| self.at(numbers, site)[way]);
            (0..self.n_sites).map(at).collect::<Vec<Known>>()
        });
        let mut powers = [0.0; 2];
        for (row, spectrum) in self.spectra.iter().enumerate() {
            let bin = row / self.power.0.len() % self.frequency.len();
            let within = |b: &FluxBand| (b.from..b.to).contains(&self.frequency[bin]);
            let is_stated = bands.iter().any(|b| b.found.is_some() && within(b));
            let squares: f64 = spectrum.iter().map(Complex::norm_sqr).sum();
            let power = fold(bin, self.n_times) * squares;
            powers[0] += if is_stated { power } else { 0.0 };
            powers[1] += if is_stated || bin > 0 { power } else { 0.0 };
        }
        let mut flux = Flux {
            scan: self.scan.clone(),
            power_unit: self.power.1.clone(),
            alpha: self.request.alpha,
            density,
            loss: Known::NONE,
            stated: powers[0] / powers[1],
            total,
            positions: self.positions.clone(),
            bands: Vec::new(),
        };
        let (last, way) = (self.n_sites - 1, usize::from(flux.is_backward()));
        let [enters, leaves] = if way == 0 { [0, last] } else { [last, 0] };
        let [first, reach] = [enters, leaves].map(|site| flux.total[way][site].value);
        // To first order, the logarithm of the ratio.
        let ratio = |n: &Numbers| self.at(n, enters)[way] / first - self.at(n, leaves)[way] / reach;
        let decibels = 10.0 / LN_10 / (self.positions[last] - self.positions[0]);
        flux.loss = Known {
            value: decibels * (first / reach).ln(),
            half: decibels * known(&stated, &ratio).half,
        };
        flux.bands = bands;
        flux
    }
}

/// What a mean square velocity times a group velocity is multiplied by at each site of a cell, both in units of the field, and the unit of
/// power (energy).
///
/// # Errors
/// [`Error::Request`] for a mass with a unit where the field's have no size.
fn power(
    field: &Field,
    masses: &[Measure<LinearDensity>],
    is_transient: bool,
) -> Result<(Vec<f64>, String)> {
    let units = Units::of(&field.time, &field.space, field.unit.as_deref());
    let mut sample = field.unit.clone().unwrap_or_default();
    if field.quantity == Quantity::StrainRate {
        sample = compose(&[&sample, &units.space], &[]);
    }
    let sizes = || {
        let (over, under) = sample.split_once('/')?;
        let time = size::<Time>(&units.time)?;
        let velocity = size::<Length>(over)? / size::<Time>(under)?;
        let passed = if is_transient { time } else { 1.0 };
        Some(velocity.powi(2) * size::<Length>(&units.space)? / time * passed)
    };
    let passed = if is_transient { &units.time } else { "" };
    let own = compose(&[&square(&sample), &units.velocity, passed], &[]);
    // A record's mean square, or its integral.
    let mut measure = if is_transient {
        field.time.step
    } else {
        1.0 / field.n_times() as f64
    };
    let fault = |expected, found: String| Err(Error::request("mass-per-length", expected, found));
    if let Some(mass) = masses.iter().find(|mass| mass.value <= 0.0) {
        return fault("masses above 0", mass.value.to_string());
    }
    let unit = match sizes() {
        Some(size) if !masses.is_empty() => {
            measure *= size;
            if is_transient { "J".into() } else { "W".into() }
        }
        None if masses.iter().any(|mass| mass.has_unit) => {
            let expected = "numbers: samples, times or positions have no unit that is known";
            return fault(expected, format!("{masses:?}"));
        }
        _ => own,
    };
    if masses.is_empty() {
        return Ok((vec![measure], unit));
    }
    let of = |mass: &Measure<LinearDensity>| measure * mass.value / masses.len() as f64;
    Ok((masses.iter().map(of).collect(), unit))
}
