//! Structure functions: moments of increments of the field against scale.

mod moments;
mod result;
mod sheet;
mod sums;

pub use result::{
    AxisIncrements, ExponentBasis, IncrementHistogram, Increments, IncrementsRequest,
    IntervalBasis, ScaleMoments, ScalingExponents,
};
pub use sums::FieldAxis;

use crate::error::{Error, Result};
use crate::estimates::realisations::{
    LEAST_STEADINESS, first_of, steadiness_of_sites, steadiness_without,
};
use crate::field::Field;
use crate::numeric::at_or_below;
use crate::numeric::least_squares::LineFit;
use crate::observer::Observer;
use crate::system::threads::in_pool;
use moments::{ORDERS, Sums, added, jackknife, statistics};
use sums::{CELLS, Counts, IncrementPass, PARTS, PartSums, REACH};

/// Structure functions, flatness and histograms of the increments of a field.
///
/// # Equation
/// With the increments `d = v(t, x + r) - v(t, x)` over a separation r, or `v(t + tau, x) - v(t, x)` over a lag,
///
/// ```text
/// S_p = <|d|^p>, p = 1 to 6;    <d^3>;    F = <d^4> / <d^2>^2,
/// ```
///
/// means over all pairs of finite samples. Sums are paired; missing samples are left out, never filled.
/// Exponents are slopes of `ln S_p` over a stated band. Intervals are jackknife estimates with Student's t, over
/// shots if there are several, else over 16 parts of a stationary record; of a transient there is none.
///
/// The local flatness compares `d` with its own level, of each pair of sites, or site, in each part of the times:
///
/// ```text
/// F_local = < sum <d^4> / sum <d^2>_a <d^2>_b >,
/// ```
///
/// sums over pairs or sites, a and b quarters of the part that are no neighbours, mean over parts. Normal fields have 3, whatever
/// their spectra and levels; a field is intermittent where it is above 3 and grows towards small scales.
///
/// # Shapes
/// Each field is one record of every site (a shot); all have the same axes. Every pair has the same weight.
///
/// # Units
/// Powers of the samples' unit; scales in units of length or time; positive separations towards +x.
///
/// # Errors
/// [`Error::Request`] for fields with different axes, steps that are longer than the axis, and bands with fewer than
/// three scales; [`Error::Memory`]; [`Error::Cancelled`]; [`Error::Threads`].
///
/// # Source
/// A. N. Kolmogorov, Dokl. Akad. Nauk SSSR 30, 301 (1941); U. Frisch, "Turbulence" (1995), chapter 8; R. Benzi
/// et al., Phys. Rev. E 48, R29 (1993) for extended self-similarity; B. Efron, "The Jackknife" (1982).
pub fn increments(
    fields: &[&Field],
    request: &IncrementsRequest,
    observer: &dyn Observer,
) -> Result<Increments> {
    let first = first_of(fields)?;
    let alpha = request.alpha;
    if !(alpha > 0.0 && alpha < 1.0) {
        let expected = "a probability between 0 and 1".to_owned();
        return refuse("significance", expected, alpha.to_string());
    }
    let steps = [
        steps_of(&request.separations, first.n_sites(), "separations")?,
        steps_of(&request.lags, first.n_times(), "lags")?,
    ];
    if steps.iter().all(Vec::is_empty) {
        let found = format!("{} times by {} sites", first.n_times(), first.n_sites());
        return refuse("field", "at least two times or sites".into(), found);
    }
    in_pool(request.threads, || {
        let steadiness = steadiness_at_sites(first);
        let is_steady = steadiness >= LEAST_STEADINESS && first.n_times() >= 2 * PARTS;
        let basis = match fields.len() > 1 {
            true => IntervalBasis::Shots,
            false if is_steady => IntervalBasis::Parts,
            false => IntervalBasis::None,
        };
        let mut axes = Vec::new();
        for (axis, steps) in [FieldAxis::Space, FieldAxis::Time].into_iter().zip(&steps) {
            if !steps.is_empty() {
                let along = Along {
                    fields,
                    axis,
                    steps,
                    basis,
                    request,
                    observer,
                };
                axes.push(along.run()?);
            }
        }
        Ok(Increments {
            time: first.time.clone(),
            space: first.space.clone(),
            unit: first.unit.clone(),
            shots: fields.len(),
            steadiness,
            basis,
            alpha,
            axes,
        })
    })
}

/// Sites whose records are looked at.
const SITES: usize = 64;

/// A pulse that passes all sites is as steady as the array is long, and a transient at each.
fn steadiness_at_sites(field: &Field) -> f64 {
    let (times, sites) = (field.n_times(), field.n_sites());
    let mut record = vec![0.0; times];
    let each = (0..sites).step_by(sites.div_ceil(SITES)).map(|site| {
        field.read_site_major(0..times, site..site + 1, &mut record);
        field.release_pages();
        let missing: Vec<usize> = (0..times).filter(|i| record[*i].is_nan()).collect();
        missing.iter().for_each(|i| record[*i] = 0.0);
        let energy = crate::numeric::sum_of_squares(&record);
        (steadiness_without(&record, &missing, true), energy)
    });
    steadiness_of_sites(each.collect())
}

fn refuse<T>(option: &'static str, expected: String, found: String) -> Result<T> {
    Err(Error::Request {
        option,
        expected,
        found,
    })
}

/// Steps along an axis of `n` samples, ascending.
fn steps_of(typed: &Option<Vec<usize>>, n: usize, option: &'static str) -> Result<Vec<usize>> {
    let half_octaves = (0..128).map(|i| 2f64.powf(0.5 * f64::from(i)).round() as usize);
    let usual = half_octaves.take_while(|step| *step < n && (*step == 1 || *step <= n / 4));
    let mut steps = typed.clone().unwrap_or_else(|| usual.collect());
    steps.sort_unstable();
    steps.dedup();
    match steps.iter().find(|step| **step == 0 || **step >= n) {
        Some(step) => refuse(option, format!("steps of 1 to {}", n - 1), step.to_string()),
        None => Ok(steps),
    }
}

/// All fields along one axis.
struct Along<'a> {
    fields: &'a [&'a Field],
    axis: FieldAxis,
    steps: &'a [usize],
    basis: IntervalBasis,
    request: &'a IncrementsRequest,
    observer: &'a dyn Observer,
}

/// Sums over everything, and the values that make them up, by scale.
struct Values {
    all: Vec<Sums>,
    each: Vec<Vec<Sums>>,
    /// Longer lags reach into other parts, which then are not independent.
    short: usize,
    alpha: f64,
}

impl Values {
    /// Of the scales `used`: what `of` makes of their sums, half of its intervals, and the values these rest on.
    fn find<const N: usize>(
        &self,
        used: &[usize],
        of: impl Fn(&[Sums]) -> [f64; N],
    ) -> ([f64; N], [f64; N], usize) {
        let pick = |sums: &Vec<Sums>| -> Vec<Sums> { used.iter().map(|i| sums[*i]).collect() };
        let each: Vec<Vec<Sums>> = match used.iter().all(|i| *i < self.short) {
            true => self.each.iter().map(pick).collect(),
            false => Vec::new(),
        };
        let each: Vec<&[Sums]> = each.iter().map(Vec::as_slice).collect();
        let all = pick(&self.all);
        let (half, count) = jackknife(&all, &each, self.alpha, &of);
        (of(&all), half, count)
    }
}

impl Along<'_> {
    fn pass<'p>(&'p self, field: &'p Field, steps: &'p [usize]) -> IncrementPass<'p> {
        IncrementPass {
            field,
            axis: self.axis,
            steps,
            observer: self.observer,
        }
    }

    fn run(&self) -> Result<AxisIncrements> {
        let sums = |field: &&Field| {
            let pass = self.pass(field, self.steps);
            pass.check_memory(self.request.memory)?;
            pass.sums()
        };
        let shots: Vec<PartSums> = self.fields.iter().map(sums).collect::<Result<_>>()?;
        let total = |values: &[Vec<Sums>]| -> Vec<Sums> {
            let of = |i: usize| {
                values
                    .iter()
                    .fold(Sums::default(), |s, one| added(&s, &one[i]))
            };
            (0..self.steps.len()).map(of).collect()
        };
        let of_shots: Vec<Vec<Sums>> = shots.iter().map(|parts| total(parts)).collect();
        let n_times = self.fields[0].n_times();
        let is_short = |s: &&usize| self.axis == FieldAxis::Space || 4 * **s * PARTS <= n_times;
        let values = Values {
            all: total(&of_shots),
            short: match self.basis {
                IntervalBasis::Shots => self.steps.len(),
                _ => self.steps.iter().take_while(is_short).count(),
            },
            each: match self.basis {
                IntervalBasis::Shots => of_shots,
                IntervalBasis::Parts => shots.into_iter().next().unwrap_or_default(),
                IntervalBasis::None => Vec::new(),
            },
            alpha: self.request.alpha,
        };
        let length = match self.axis {
            FieldAxis::Space => self.fields[0].space.step.abs(),
            FieldAxis::Time => self.fields[0].time.step,
        };
        let moments = |(i, step): (usize, &usize)| {
            let (mut found, mut half, realisations) =
                values.find(&[i], |sums| statistics(&sums[0]));
            if !is_short(&step) {
                [found[ORDERS + 3], half[ORDERS + 3]] = [f64::NAN; 2];
            }
            ScaleMoments {
                step: *step,
                scale: *step as f64 * length,
                pairs: values.all[i][0] as u64,
                structure: std::array::from_fn(|p| found[p]),
                third: found[ORDERS],
                flatness: found[ORDERS + 1],
                skewness: found[ORDERS + 2],
                local_flatness: found[ORDERS + 3],
                half,
                realisations,
            }
        };
        let scales: Vec<ScaleMoments> = self.steps.iter().enumerate().map(moments).collect();
        Ok(AxisIncrements {
            axis: self.axis,
            growth: growth(&scales, &values),
            exponents: self.exponents(&scales, &values)?,
            histograms: self.histograms(&scales)?,
            scales,
        })
    }

    fn exponents(
        &self,
        scales: &[ScaleMoments],
        values: &Values,
    ) -> Result<Option<ScalingExponents>> {
        let (band, option) = match self.axis {
            FieldAxis::Space => (self.request.band, "band"),
            FieldAxis::Time => (self.request.lag_band, "lag-band"),
        };
        let Some((from, to)) = band else {
            return Ok(None);
        };
        let inside = |scale: f64| at_or_below(scale, to) && at_or_below(from, scale);
        let is_used = |m: &ScaleMoments| inside(m.scale) && m.pairs > 0 && m.structure[0] > 0.0;
        let used: Vec<usize> = (0..scales.len()).filter(|i| is_used(&scales[*i])).collect();
        // Of order p against the scale, or against order 3.
        let line = |sums: &[Sums], p: usize, against_third: bool| {
            let point = |(i, sums): (&usize, &Sums)| {
                let of = |p: usize| (sums[p + 1] / sums[0]).ln();
                match against_third {
                    true => (of(2), of(p)),
                    false => (scales[*i].scale.ln(), of(p)),
                }
            };
            LineFit::through(&used.iter().zip(sums).map(point).collect::<Vec<_>>())
        };
        let slope = |sums: &[Sums], p: usize, against_third: bool| {
            line(sums, p, against_third).map_or(f64::NAN, |line| line.slope)
        };
        let (exponents, mut half, count) = values.find(&used, |sums| {
            std::array::from_fn::<_, ORDERS, _>(|p| slope(sums, p, false))
        });
        let all: Vec<Sums> = used.iter().map(|i| values.all[*i]).collect();
        let relative = std::array::from_fn(|p| slope(&all, p, true));
        if exponents
            .iter()
            .chain(&relative)
            .any(|slope| slope.is_nan())
        {
            let expected = "a band with three or more scales at which the field varies";
            let found = format!("{from}:{to} with {}", used.len());
            return refuse(option, expected.into(), found);
        }
        let basis = match (count > 1, self.basis) {
            (true, IntervalBasis::Shots) => ExponentBasis::Shots,
            (true, _) => ExponentBasis::Parts,
            (false, _) => ExponentBasis::Regression,
        };
        if basis == ExponentBasis::Regression {
            let of = |p| line(&all, p, false).map_or(f64::NAN, |l| l.half_interval(values.alpha));
            half = std::array::from_fn(of);
        }
        Ok(Some(ScalingExponents {
            band: [used[0], used[used.len() - 1]].map(|i| scales[i].scale),
            points: used.len(),
            exponents,
            half,
            basis,
            relative,
        }))
    }

    fn histograms(&self, scales: &[ScaleMoments]) -> Result<Vec<IncrementHistogram>> {
        let count = self.request.histograms.min(scales.len());
        let (last, apart) = (scales.len() - 1, count.max(2) - 1);
        let mut chosen: Vec<usize> = (0..count).map(|h| h * last / apart).collect();
        chosen.retain(|i| scales[*i].structure[1] > 0.0);
        chosen.dedup();
        if chosen.is_empty() {
            return Ok(Vec::new());
        }
        let steps: Vec<usize> = chosen.iter().map(|i| self.steps[*i]).collect();
        let sizes: Vec<f64> = chosen
            .iter()
            .map(|i| scales[*i].structure[1].sqrt())
            .collect();
        let mut sums: Vec<Counts> = vec![[0; CELLS + 2]; steps.len()];
        for field in self.fields {
            let counts = self.pass(field, &steps).histograms(&sizes)?;
            for (sum, count) in sums.iter_mut().flatten().zip(counts.iter().flatten()) {
                *sum += count;
            }
        }
        let width = 2.0 * REACH / CELLS as f64;
        let of = |(index, counts): (&usize, &Counts)| {
            let all = scales[*index].pairs as f64;
            let cells = &counts[1..=CELLS];
            IncrementHistogram {
                index: *index,
                edges: (0..=CELLS).map(|c| width * c as f64 - REACH).collect(),
                density: cells.iter().map(|c| *c as f64 / (all * width)).collect(),
                outside: [counts[0], counts[CELLS + 1]],
            }
        };
        Ok(chosen.iter().zip(&sums).map(of).collect())
    }
}

/// `- d ln F_local / d ln scale` with half of its interval, where three or more scales have one.
fn growth(scales: &[ScaleMoments], values: &Values) -> Option<[f64; 2]> {
    let is_used = |i: &usize| scales[*i].local_flatness_half().is_finite();
    let used: Vec<usize> = (0..scales.len()).filter(is_used).collect();
    let ([exponent], [half], _) = values.find(&used, |sums| {
        let point = |(i, sums): (&usize, &Sums)| {
            let flatness = statistics(sums)[ORDERS + 3];
            (scales[*i].scale.ln(), flatness.ln())
        };
        let points: Vec<_> = used.iter().zip(sums).map(point).collect();
        [LineFit::through(&points).map_or(f64::NAN, |line| -line.slope)]
    });
    half.is_finite().then_some([exponent, half])
}
