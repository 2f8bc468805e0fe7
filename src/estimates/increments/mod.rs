//! Structure functions: moments of increments of the field against scale.

mod moments;
mod result;
mod sheet;
mod sums;

pub use result::{
    AxisIncrements, IncrementHistogram, Increments, IncrementsRequest, IntervalBasis, ScaleMoments,
    ScalingExponents,
};

use crate::error::{Error, Result};
use crate::estimates::FieldAxis;
use crate::estimates::realisations::{
    LEAST_STEADINESS, check_significance, first_of, steadiness_of_field,
};
use crate::field::Field;
use crate::numeric::{LineFit, in_band, jackknife, student_two_sided};
use crate::observer::Observer;
use crate::system::threads::in_pool;
use moments::{ORDERS, Sums, added, statistics};
use sums::{CELLS, Counts, PARTS, REACH, add_counts};

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
/// three scales; [`Error::Memory`]; [`Error::Cancelled`]; [`Error::Failed`].
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
    check_significance(request.alpha)?;
    let (n_times, n_sites) = (first.n_times(), first.n_sites());
    let steps = [
        steps_of(&request.separations, n_sites, "separations")?,
        steps_of(&request.lags, n_times, "lags")?,
    ];
    let has_steps = steps.iter().any(|steps| !steps.is_empty());
    let found = format!("{n_times} times by {n_sites} sites");
    Error::require(has_steps, "field", "at least two times or sites", found)?;
    in_pool(request.threads, || {
        let looked_at = (0..n_sites).step_by(n_sites.div_ceil(SITES));
        let steadiness = steadiness_of_field(first, looked_at.map(|site| site..site + 1), 1.0);
        let is_steady = steadiness >= LEAST_STEADINESS && n_times >= 2 * PARTS;
        let basis = match fields.len() > 1 {
            true => IntervalBasis::Shots,
            false if is_steady => IntervalBasis::Parts,
            false => IntervalBasis::None,
        };
        let axes = [FieldAxis::Space, FieldAxis::Time].into_iter().zip(&steps);
        let along = axes.filter(|(_, steps)| !steps.is_empty());
        let along = along.map(|(axis, steps)| Along {
            fields,
            axis,
            steps,
            basis,
            request,
            observer,
        });
        Ok(Increments {
            time: first.time.clone(),
            space: first.space.clone(),
            unit: first.unit.clone(),
            shots: fields.len(),
            steadiness,
            basis,
            alpha: request.alpha,
            axes: along.map(|along| along.run()).collect::<Result<_>>()?,
        })
    })
}

/// Sites whose records are looked at.
const SITES: usize = 64;

/// Steps along an axis of `n` samples, ascending.
fn steps_of(typed: &Option<Vec<usize>>, n: usize, option: &'static str) -> Result<Vec<usize>> {
    let half_octaves = (0..128).map(|i| 2f64.powf(0.5 * f64::from(i)).round() as usize);
    let usual = half_octaves.take_while(|step| *step < n && (*step == 1 || *step <= n / 4));
    let mut steps = typed.clone().unwrap_or_else(|| usual.collect());
    steps.sort_unstable();
    steps.dedup();
    for step in &steps {
        let expected = format!("steps of 1 to {}", n - 1);
        Error::require((1..n).contains(step), option, expected, step)?;
    }
    Ok(steps)
}

/// All fields along one axis.
struct Along<'a> {
    fields: &'a [&'a Field],
    axis: FieldAxis,
    /// Separations in sites, or lags in samples.
    steps: &'a [usize],
    basis: IntervalBasis,
    request: &'a IncrementsRequest,
    observer: &'a dyn Observer,
}

/// Sums over everything, and the values that make them up, by scale.
struct Values {
    all: Vec<Sums>,
    each: Vec<Vec<Sums>>,
    /// Scales of which they are independent: longer lags reach into other parts.
    independent: usize,
    alpha: f64,
}

impl Values {
    /// Of the scales `used`: what `of` makes of their sums, half of its intervals, and the values these rest on: a
    /// jackknife that leaves one of them out. Half is NaN for fewer than two values.
    fn find<const N: usize>(
        &self,
        used: &[usize],
        of: impl Fn(&[Sums]) -> [f64; N],
    ) -> ([f64; N], [f64; N], usize) {
        let pick = |sums: &Vec<Sums>| -> Vec<Sums> { used.iter().map(|i| sums[*i]).collect() };
        let all = pick(&self.all);
        let are_independent = used.iter().all(|i| *i < self.independent);
        let each = self.each.iter().filter(|_| are_independent).map(pick);
        let there = each.filter(|one| one.iter().all(|sums| sums[0] > 0.0));
        let without = there.map(|one| {
            let pairs = all.iter().zip(&one);
            let rest = pairs.map(|(all, one)| std::array::from_fn(|i| all[i] - one[i]));
            of(&rest.collect::<Vec<Sums>>())
        });
        let without: Vec<[f64; N]> = without.collect();
        let within = student_two_sided(self.alpha, without.len().max(2) as f64 - 1.0);
        let half = |i: usize| {
            let of_each: Vec<f64> = without.iter().map(|one| one[i]).collect();
            match of_each.len() {
                0..2 => f64::NAN,
                _ => within * jackknife(&of_each),
            }
        };
        (of(&all), std::array::from_fn(half), without.len())
    }
}

impl Along<'_> {
    fn run(&self) -> Result<AxisIncrements> {
        let shots = self.fields.iter().map(|field| self.sums(field));
        let shots: Vec<Vec<Vec<Sums>>> = shots.collect::<Result<_>>()?;
        let total = |values: &Vec<Vec<Sums>>| -> Vec<Sums> {
            let of = |i| {
                values
                    .iter()
                    .fold(Sums::default(), |sum, one| added(&sum, &one[i]))
            };
            (0..self.steps.len()).map(of).collect()
        };
        let of_shots: Vec<Vec<Sums>> = shots.iter().map(total).collect();
        let first = self.fields[0];
        let longest = self.axis.of([usize::MAX, first.n_times() / (4 * PARTS)]);
        let short = self.steps.partition_point(|step| *step <= longest);
        let all = total(&of_shots);
        let (each, independent) = match self.basis {
            IntervalBasis::Shots => (of_shots, self.steps.len()),
            IntervalBasis::Parts => (shots.into_iter().next().unwrap_or_default(), short),
            _ => (Vec::new(), short),
        };
        let values = Values {
            all,
            each,
            independent,
            alpha: self.request.alpha,
        };
        let length = self.axis.of([first.space.step.abs(), first.time.step]);
        let moments = |(i, step): (usize, &usize)| {
            let (mut found, mut half, realisations) =
                values.find(&[i], |sums| statistics(&sums[0]));
            if i >= short {
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
        let (band, option) = self.axis.of([
            (self.request.band, "band"),
            (self.request.lag_band, "lag-band"),
        ]);
        let Some(band) = band else {
            return Ok(None);
        };
        let is_used =
            |m: &ScaleMoments| in_band(m.scale, band) && m.pairs > 0 && m.structure[0] > 0.0;
        let used: Vec<usize> = (0..scales.len()).filter(|i| is_used(&scales[*i])).collect();
        // The logarithm of a structure function of order p + 1.
        let ln = |sums: &Sums, p: usize| (sums[p + 1] / sums[0]).ln();
        let line = |sums: &[Sums], p: usize| {
            let scales = used.iter().map(|i| scales[*i].scale.ln());
            line_of(scales.zip(sums.iter().map(|sums| ln(sums, p))))
        };
        let slope = |line: Option<LineFit>| line.map_or(f64::NAN, |line| line.slope);
        let (exponents, mut half, count) = values.find(&used, |sums| {
            std::array::from_fn::<_, ORDERS, _>(|p| slope(line(sums, p)))
        });
        let all: Vec<Sums> = used.iter().map(|i| values.all[*i]).collect();
        let against_third = |p| slope(line_of(all.iter().map(|sums| (ln(sums, 2), ln(sums, p)))));
        let relative: [f64; ORDERS] = std::array::from_fn(against_third);
        let mut slopes = exponents.iter().chain(&relative);
        if slopes.any(|slope| slope.is_nan()) {
            let expected = "a band with three or more scales at which the field varies";
            let found = format!("{}:{} with {}", band.0, band.1, used.len());
            return Err(Error::request(option, expected, found));
        }
        let of_line = |p| line(&all, p).map_or(f64::NAN, |l| l.half_interval(values.alpha));
        let basis = match count {
            0..2 => IntervalBasis::Regression,
            _ => self.basis,
        };
        if basis == IntervalBasis::Regression {
            half = std::array::from_fn(of_line);
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
        let some = Along {
            steps: &steps,
            ..*self
        };
        let sizes = chosen.iter().map(|i| scales[*i].structure[1].sqrt());
        let sizes: Vec<f64> = sizes.collect();
        let mut sums: Vec<Counts> = vec![[0; CELLS + 2]; steps.len()];
        for field in self.fields {
            add_counts(&mut sums, &some.counts(field, &sizes)?);
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

fn line_of(points: impl Iterator<Item = (f64, f64)>) -> Option<LineFit> {
    LineFit::through(&points.collect::<Vec<_>>())
}

/// `- d ln F_local / d ln scale` with half of its interval, where three or more scales have one.
fn growth(scales: &[ScaleMoments], values: &Values) -> Option<[f64; 2]> {
    let is_used = |i: &usize| scales[*i].local_flatness_half().is_finite();
    let used: Vec<usize> = (0..scales.len()).filter(is_used).collect();
    let ([exponent], [half], _) = values.find(&used, |sums| {
        let flatness = sums.iter().map(|sums| statistics(sums)[ORDERS + 3].ln());
        let scales = used.iter().map(|i| scales[*i].scale.ln());
        [line_of(scales.zip(flatness)).map_or(f64::NAN, |line| -line.slope)]
    });
    half.is_finite().then_some([exponent, half])
}
