//! The search of the waves of each band, and the sums of what is found.

use std::f64::consts::{LN_10, PI, TAU};
use std::ops::Range;

use ndarray::{Array1, Array3, s};
use num_complex::Complex;
use rayon::prelude::*;

use super::band::{Band, Found, GROUPS, Numbers, Row, Setup, Unknowns};
use super::{Flux, FluxBand, FluxRequest, Known, NoFlux};
use crate::analyze::DispersionCurve;
use crate::error::{Error, Result};
use crate::estimates::realisations::{Realisations, Shots, TOGETHER};
use crate::estimates::{Averaging, Tapers};
use crate::field::{Field, Quantity};
use crate::measure::{Length, LinearDensity, Measure, Time, size};
use crate::numeric::student_two_sided;
use crate::observer::Observer;
use crate::prepare::{Detrend, Window};
use crate::ridges::{RidgePoint, Ridges};
use crate::sheet::Units;
use crate::transform::{Travelling, fold, frequencies};
use crate::unit::{compose, square};

/// Frequencies of a band at least, of transients and of steady records, whose window spreads each over its neighbours.
const LEAST_ROWS: [usize; 2] = [8, 40];
/// Deviation of the frequencies of the waves of a steady record in bins at least, half that of a band: the window spreads a tone over three.
const SPREAD: f64 = 6.0;
/// Points of ridges, or peaks alone, that the search of a band starts from.
const STARTS: usize = 3;

/// What is searched in.
pub(super) struct Search<'a> {
    request: &'a FluxRequest,
    field: &'a Field,
    scan: &'a Ridges,
    law: Option<DispersionCurve>,
    /// Of one unit of velocity squared times a velocity at each site of a cell, and its unit.
    power: (Vec<f64>, String),
    /// `[shot, bin, site]`, of whole cells, one-sided.
    spectra: Array3<Complex<f64>>,
    frequency: Vec<f64>,
    /// Of the sites, from the first one.
    distances: Array1<f64>,
    setup: Setup,
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
        let n_times = field.n_times();
        let (window, detrend, spread) = match is_transient {
            true => (Window::None, Detrend::None, 0.0),
            false => (Window::USUAL, Detrend::Mean, SPREAD),
        };
        let averaging = Averaging {
            segment: Some(n_times),
            overlap: None,
            tapers: Tapers::Window(window),
            detrend,
        };
        let realisations = Realisations::new(&averaging, n_times)?;
        let shots = Shots::new(fields, request.gaps, request.memory, n_times, observer)?;
        let what = "the spectra of all sites, which are held,";
        let (bins, mut tiles) = (realisations.bins(), vec![Vec::new(); shots.tiles()]);
        let held = 32 * (bins * shots.count() * shots.tiles() * TOGETHER) as u64;
        shots.each(shots.block(what, held)?, |shot| {
            shot.each_tile("spectra", &mut tiles, |scratch, _, records, tile| {
                let add = |_: usize, spectra: &[Complex<f64>]| tile.extend_from_slice(spectra);
                realisations.each(records, scratch, add);
            })
        })?;
        let at = |(shot, bin, j): (usize, usize, usize)| {
            let (tile, rows) = (&tiles[j / TOGETHER], bins * shots.count());
            let value = tile[(shot * bins + bin) * (tile.len() / rows) + j % TOGETHER];
            value * fold(bin, n_times).sqrt()
        };
        let is_strain = field.quantity == Quantity::StrainRate;
        let power = power(field, &request.mass_per_length, is_transient)?;
        let sites = field.n_sites() / power.0.len() * power.0.len();
        Ok(Search {
            request,
            field,
            scan,
            spectra: Array3::from_shape_fn((shots.count(), bins, sites), at),
            frequency: frequencies(n_times, field.time.step),
            distances: (0..sites).map(|j| j as f64 * field.space.step).collect(),
            power,
            setup: Setup {
                ways: match request.towards {
                    Travelling::TowardPlusX => [1.0, 0.0],
                    Travelling::TowardMinusX => [0.0, 1.0],
                    _ => [1.0; 2],
                },
                groups: match fields.len() {
                    1 => GROUPS,
                    n => n.min(GROUPS),
                },
                span: (sites - 1) as f64 * field.space.step,
                is_law: law.is_some(),
                is_single: is_transient && fields.len() == 1,
                spread: spread / (n_times as f64 * field.time.step),
                strain: if is_strain { -2 } else { 0 },
            },
            law,
        })
    }

    pub fn run(&self) -> Flux {
        let bands = self.bands().unwrap_or_default();
        let found: Vec<_> = bands.par_iter().map(|bins| self.found(bins)).collect();
        let stated: Vec<&Found> = found.iter().flatten().collect();
        let power = |bins: Range<usize>| -> f64 {
            let spectra = self.spectra.slice(s![.., bins, ..]);
            spectra.iter().map(Complex::norm_sqr).sum()
        };
        // The mean counts where it has a band.
        let first = bands.first().map_or(1, |bins| bins.start.min(1));
        let of_bands = bands.iter().zip(&found).filter(|(_, found)| found.is_ok());
        let of_bands = of_bands.fold(0.0, |sum, (bins, _)| sum + power(bins.clone()));
        let bands = bands.iter().zip(&found);
        let mut flux = Flux {
            scan: self.scan.clone(),
            power_unit: self.power.1.clone(),
            alpha: self.request.alpha,
            positions: (&self.distances + self.field.space.origin).to_vec(),
            bands: bands.map(|(bins, found)| self.band(bins, found)).collect(),
            total: self.flux(&stated),
            loss: Known::NONE,
            stated: of_bands / power(first..self.frequency.len()),
        };
        let (way, [enters, leaves]) = flux.larger();
        let [first, reach] = [enters, leaves].map(|j| flux.total[way][j].value);
        let at = |numbers: &Numbers, j: usize| self.at(numbers, self.distances[j])[way];
        // To first order, the logarithm of the ratio.
        let ratio = |n: &Numbers| at(n, enters) / first - at(n, leaves) / reach;
        let loss = Known {
            value: (first / reach).ln(),
            ..self.known(&stated, &ratio)
        };
        flux.loss = loss.times(10.0 / LN_10 / self.setup.span);
        flux
    }

    /// Bins of each band: where there are ridges, peaks alone or frequencies of the law, but those without a direction.
    fn bands(&self) -> Option<Vec<Range<usize>>> {
        let curve = self.law.as_ref().or(self.scan.analysis.dispersion.first());
        let of_curve = curve
            .iter()
            .flat_map(|curve| curve.branches.iter().flatten());
        let lone = self.scan.lone.iter().map(|[f, _]| f);
        let lone = lone.filter(|_| self.law.is_none());
        let all = of_curve.chain(lone).filter(|f| f.is_finite());
        let bins = all.map(|f| (f / self.frequency[1]).round() as usize);
        // The mean has a flux if nothing comes back.
        let least = usize::from(self.setup.ways == [1.0; 2] || self.law.is_none());
        let (from, to) = (bins.clone().min()?.max(least), bins.max()? + 1);
        let rows = LEAST_ROWS[usize::from(!self.scan.independence.is_transient())];
        // Those of a narrow band are about its middle.
        let from = from.min(((from + to).saturating_sub(rows) / 2).max(least));
        let to = to.max(from + rows).min(self.field.n_times().div_ceil(2));
        let count = (to.saturating_sub(from) / rows).min(self.request.bands);
        let edge = |n: usize| from + n * (to - from) / count;
        Some((0..count).map(|n| edge(n)..edge(n + 1)).collect())
    }

    /// The ends of a band in cycles.
    fn ends(&self, bins: &Range<usize>) -> [f64; 2] {
        [bins.start, bins.end].map(|bin| (bin as f64 - 0.5) * self.frequency[1])
    }

    /// Where the search of a band begins: at the ridge points that are next to it, the strongest first. Peaks alone have the group velocity
    /// that is stated, or that of their phase.
    fn starts(&self, [from, to]: [f64; 2]) -> Vec<Unknowns> {
        if self.law.is_some() {
            return vec![[0.0; 4]];
        }
        let (middle, cell) = (0.5 * (from + to), self.power.0.len() as f64);
        let zone = TAU / (cell * self.field.space.step);
        let stated = self.request.group_velocity;
        let of_peak = |[f, k]: &[f64; 2]| {
            let velocity = stated.map_or(TAU * f / k, |velocity| velocity.copysign(*k));
            [0.0, *f, *k, velocity]
        };
        let of_point = |p: &RidgePoint| [p.power, p.frequency, p.wavenumber, p.group_velocity];
        let points = self.scan.points().map(of_point);
        let points = points.chain(self.scan.lone.iter().map(of_peak));
        let mut points: Vec<[f64; 4]> = points.filter(|p| p[3].is_finite()).collect();
        let away = |p: &[f64; 4]| (from - p[1]).max(p[1] - to).max(0.0);
        points.sort_by(|a, b| away(a).total_cmp(&away(b)).then(b[0].total_cmp(&a[0])));
        let start = |[_, f, k, velocity]: &[f64; 4]| {
            // With the sign of a wave whose energy goes to +x, in the first zone of the cells.
            let (sign, slope) = (velocity.signum(), TAU / velocity.abs());
            let k = k * sign + slope * (middle - f);
            [0.0, k - zone * (k / zone).round(), slope * middle, 0.0]
        };
        points.iter().take(STARTS).map(start).collect()
    }

    /// Wavenumber up to the cells' Nyquist wavenumber and group velocity that the law has at a frequency, by a parabola through three of its
    /// points.
    fn of_law(&self, law: &DispersionCurve, frequency: f64) -> Result<[f64; 2], NoFlux> {
        let zero = law.wavenumber.len() / 2;
        let k = &law.wavenumber[zero..];
        let last = (k.len() - 1) / self.power.0.len();
        let places = law.branches.iter().flat_map(|branch| {
            let f = &branch[zero..];
            let is_crossed = move |i: &usize| {
                let [a, b] = [f[*i] - frequency, f[i + 1] - frequency];
                a * b <= 0.0 && b != 0.0
            };
            let crossed = (0..last).filter(is_crossed);
            crossed.map(move |i| (f, i.min(k.len() - 3)))
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

    fn found(&self, bins: &Range<usize>) -> Result<Found, NoFlux> {
        let [from, to] = self.ends(bins);
        let (middle, cell, shots) = (0.5 * (from + to), self.power.0.len(), self.spectra.dim().0);
        let (groups, mut rows) = (self.setup.groups, Vec::new());
        for bin in bins.clone() {
            let frequency = self.frequency[bin];
            let law = self.law.as_ref().map(|law| self.of_law(law, frequency));
            let [wavenumber, velocity] = law.transpose()?.unwrap_or([0.0, f64::NAN]);
            let measured = self.law.is_some().then_some(velocity);
            let part = (bin - bins.start) * groups / bins.len();
            for (first, mass) in self.power.0.iter().enumerate() {
                let sites = s![first..;cell as isize];
                rows.extend((0..shots).map(|shot| Row {
                    spectrum: self.spectra.slice(s![shot, bin, ..]).slice_move(sites),
                    distances: self.distances.slice(sites),
                    offset: frequency / middle - 1.0,
                    wavenumber,
                    velocity: self.request.group_velocity.or(measured),
                    weight: mass / shots as f64,
                    group: if shots > 1 { shot % groups } else { part },
                }));
            }
        }
        let band = Band {
            setup: &self.setup,
            rows,
            middle,
        };
        band.found(&self.starts([from, to]))
    }

    fn band(&self, bins: &Range<usize>, found: &Result<Found, NoFlux>) -> FluxBand {
        let ([from, to], stated) = (self.ends(bins), Vec::from_iter(found));
        let known = |of: &dyn Fn(&Numbers) -> f64| self.known(&stated, of);
        let frequency = stated.first().map(|found| found.numbers.frequency);
        let frequency = frequency.unwrap_or(0.5 * (from + to));
        FluxBand {
            from: from.max(0.0),
            to,
            frequency,
            reason: found.as_ref().err().copied(),
            wavenumber: known(&|n| n.wavenumber),
            group_velocity: known(&|n| n.velocity),
            attenuation: known(&|n| n.loss),
            loss_factor: known(&|n| n.loss * n.velocity / (PI * frequency)),
            flux: self.flux(&stated),
        }
    }

    /// A sum over bands with its interval; NaN of none.
    fn known(&self, found: &[&Found], of: &dyn Fn(&Numbers) -> f64) -> Known {
        if found.is_empty() {
            return Known::NONE;
        }
        let quantile = student_two_sided(self.request.alpha, self.setup.groups as f64 - 1.0);
        Known {
            value: found.iter().map(|found| of(&found.numbers)).sum(),
            half: quantile * Found::error(found, of),
        }
    }

    /// Power (energy) of bands at all sites: towards +x, towards -x, net.
    fn flux(&self, found: &[&Found]) -> [Vec<Known>; 3] {
        [0, 1, 2].map(|way| {
            let known = |x: &f64| self.known(found, &|numbers| self.at(numbers, *x)[way]);
            self.distances.iter().map(known).collect()
        })
    }

    /// The same of one band at a distance from the first site.
    fn at(&self, numbers: &Numbers, x: f64) -> [f64; 3] {
        let decay = |x: f64| (-2.0 * numbers.loss * x).exp();
        let [plus, minus] = numbers.flux;
        let (plus, minus) = (plus * decay(x), minus * decay(self.setup.span - x));
        [plus, minus, plus - minus]
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
    // A record's mean square, or its integral.
    let (measure, passed, si) = match is_transient {
        true => (field.time.step, &units.time[..], "J"),
        false => (1.0 / field.n_times() as f64, "", "W"),
    };
    let size = || {
        let (over, under) = sample.split_once('/')?;
        let velocity = size::<Length>(over)? / size::<Time>(under)?;
        let (length, time) = (size::<Length>(&units.space)?, size::<Time>(&units.time)?);
        Some(velocity.powi(2) * length * if is_transient { 1.0 } else { 1.0 / time })
    };
    let fault = |expected, found: String| Err(Error::request("mass-per-length", expected, found));
    if let Some(mass) = masses.iter().find(|mass| mass.value <= 0.0) {
        return fault("masses above 0", mass.value.to_string());
    }
    let plain = compose(&[&square(&sample), &units.velocity, passed], &[]);
    let (size, unit) = match (masses, size()) {
        ([_, ..], Some(size)) => (size, si.into()),
        (masses, None) if masses.iter().any(|mass| mass.has_unit) => {
            let expected = "numbers: samples, times or positions have no unit that is known";
            return fault(expected, format!("{masses:?}"));
        }
        _ => (1.0, plain),
    };
    let mut values: Vec<f64> = masses.iter().map(|mass| mass.value).collect();
    if values.is_empty() {
        values.push(1.0);
    }
    let times = measure * size / values.len() as f64;
    Ok((values.iter().map(|mass| times * mass).collect(), unit))
}
