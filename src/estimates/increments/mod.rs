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
use crate::numeric::least_squares::{LineFit, mean_of};
use crate::numeric::student_two_sided;
use crate::observer::Observer;
use crate::system::threads::in_pool;
use moments::{ORDERS, SIGNED, SUMS, added};
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
        let mut found = Increments {
            time: first.time.clone(),
            space: first.space.clone(),
            unit: first.unit.clone(),
            shots: fields.len(),
            steadiness: 1.0,
            basis: IntervalBasis::Shots,
            alpha,
            axes: Vec::new(),
        };
        let mut all = Vec::new();
        for (axis, steps) in [FieldAxis::Space, FieldAxis::Time].into_iter().zip(&steps) {
            if !steps.is_empty() {
                let passes = Passes {
                    fields,
                    axis,
                    steps,
                    request,
                    observer,
                };
                all.push((passes.sums()?, passes));
            }
        }
        let steadiness = |(sums, passes): &(Vec<PartSums>, Passes)| {
            let longest = match passes.axis {
                FieldAxis::Time => first.n_times() / PARTS / 8,
                FieldAxis::Space => first.n_sites() / 8,
            };
            let scales = passes.steps.iter().take_while(|step| **step <= longest);
            let each = (0..scales.count().max(1)).map(|scale| steadiness_of(sums, scale));
            each.fold(1.0, f64::min)
        };
        found.steadiness = all.iter().map(steadiness).fold(1.0, f64::min);
        if fields.len() == 1 {
            found.steadiness = found.steadiness.min(steadiness_at_sites(first));
        }
        found.basis = match (fields.len() > 1, found.steadiness >= LEAST_STEADINESS) {
            (true, _) => IntervalBasis::Shots,
            (false, true) if first.n_times() >= 2 * PARTS => IntervalBasis::Parts,
            _ => IntervalBasis::None,
        };
        for (sums, passes) in &all {
            found.axes.push(passes.finish(sums, found.basis)?);
        }
        Ok(found)
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
    let mut steps = match typed {
        Some(steps) => steps.clone(),
        None => {
            let half_octaves = (0..128).map(|i| 2f64.powf(0.5 * f64::from(i)).round() as usize);
            half_octaves
                .take_while(|step| *step == 1 || *step <= n / 4)
                .collect()
        }
    };
    steps.sort_unstable();
    steps.dedup();
    if typed.is_none() {
        steps.retain(|step| *step < n);
    }
    match steps.iter().find(|step| **step == 0 || **step >= n) {
        Some(step) if n < 2 => refuse(
            option,
            "an axis of two samples or more".into(),
            step.to_string(),
        ),
        Some(step) => refuse(option, format!("steps of 1 to {}", n - 1), step.to_string()),
        None => Ok(steps),
    }
}

/// From the sums of squares of each part over a step. Noise hides a pulse over the smallest one; steps near the
/// length of a part have too few values in it.
fn steadiness_of(shots: &[PartSums], scale: usize) -> f64 {
    let of_one = |parts: &PartSums| {
        let (mut sum, mut squares) = (0.0, 0.0);
        for part in parts {
            let energy = part.get(scale).map_or(0.0, |sums| sums[2]);
            sum += energy;
            squares += energy * energy;
        }
        match squares > 0.0 {
            true => sum * sum / (PARTS as f64 * squares),
            false => 1.0,
        }
    };
    shots.iter().map(of_one).sum::<f64>() / shots.len() as f64
}

/// All fields along one axis.
struct Passes<'a> {
    fields: &'a [&'a Field],
    axis: FieldAxis,
    steps: &'a [usize],
    request: &'a IncrementsRequest,
    observer: &'a dyn Observer,
}

impl Passes<'_> {
    fn pass<'p>(&'p self, field: &'p Field, steps: &'p [usize]) -> IncrementPass<'p> {
        IncrementPass {
            field,
            axis: self.axis,
            steps,
            observer: self.observer,
        }
    }

    fn sums(&self) -> Result<Vec<PartSums>> {
        let one = |field: &&Field| {
            let pass = self.pass(field, self.steps);
            pass.check_memory(self.request.memory)?;
            pass.sums()
        };
        self.fields.iter().map(one).collect()
    }

    fn step_length(&self) -> f64 {
        match self.axis {
            FieldAxis::Space => self.fields[0].space.step.abs(),
            FieldAxis::Time => self.fields[0].time.step,
        }
    }

    fn finish(&self, shots: &[PartSums], basis: IntervalBasis) -> Result<AxisIncrements> {
        let over_parts = |parts: &PartSums, step: usize| {
            parts
                .iter()
                .fold([0.0; SUMS], |sum, part| added(&sum, &part[step]))
        };
        let scale = |(i, step): (usize, &usize)| {
            let of_shots: Vec<[f64; SUMS]> =
                shots.iter().map(|parts| over_parts(parts, i)).collect();
            // Longer lags reach into other parts, which then are not independent.
            let is_short =
                self.axis == FieldAxis::Space || 4 * step * PARTS <= self.fields[0].n_times();
            let values: Vec<[f64; SUMS]> = match basis {
                IntervalBasis::Shots => of_shots.clone(),
                IntervalBasis::Parts if is_short => shots[0].iter().map(|part| part[i]).collect(),
                _ => Vec::new(),
            };
            let total = of_shots
                .iter()
                .fold([0.0; SUMS], |sum, one| added(&sum, one));
            moments(
                *step,
                *step as f64 * self.step_length(),
                &total,
                &values,
                self.request.alpha,
            )
        };
        let scales: Vec<ScaleMoments> = self.steps.iter().enumerate().map(scale).collect();
        let exponents = self.exponents(&scales, shots, over_parts)?;
        Ok(AxisIncrements {
            axis: self.axis,
            histograms: self.histograms(&scales)?,
            scales,
            exponents,
        })
    }

    fn exponents(
        &self,
        scales: &[ScaleMoments],
        shots: &[PartSums],
        over_parts: impl Fn(&PartSums, usize) -> [f64; SUMS],
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
        let too_few = || {
            let expected = "a band with three or more scales at which the field varies";
            refuse(
                option,
                expected.into(),
                format!("{from}:{to} with {}", used.len()),
            )
        };
        let slope = |p: usize, of: &dyn Fn(usize) -> [f64; 2]| {
            let points: Vec<(f64, f64)> = used
                .iter()
                .map(|i| of(*i))
                .map(|[x, y]| (x.ln(), y.ln()))
                .collect();
            LineFit::through(&points).map(|fit| (p, fit))
        };
        let mut found = ScalingExponents {
            band: [0.0; 2],
            points: used.len(),
            exponents: [0.0; ORDERS],
            half: [0.0; ORDERS],
            basis: match shots.len() > 1 {
                true => ExponentBasis::Shots,
                false => ExponentBasis::Regression,
            },
            relative: [0.0; ORDERS],
        };
        for p in 0..ORDERS {
            let of = |i: usize| [scales[i].scale, scales[i].structure[p]];
            let against_third = |i: usize| [scales[i].structure[2], scales[i].structure[p]];
            let (Some((_, fit)), Some((_, relative))) = (slope(p, &of), slope(p, &against_third))
            else {
                return too_few();
            };
            found.exponents[p] = fit.slope;
            found.relative[p] = relative.slope;
            let of_shots: Vec<f64> = shots
                .iter()
                .filter_map(|parts| {
                    let of = |i: usize| {
                        let sums = over_parts(parts, i);
                        [scales[i].scale, sums[p + 1] / sums[0]]
                    };
                    slope(p, &of).map(|(_, fit)| fit.slope)
                })
                .collect();
            found.half[p] = match mean_of(&of_shots, self.request.alpha) {
                Some((_, half)) => half,
                None => fit.half_interval(self.request.alpha),
            };
        }
        found.band = [used[0], used[used.len() - 1]].map(|i| scales[i].scale);
        Ok(Some(found))
    }

    fn histograms(&self, scales: &[ScaleMoments]) -> Result<Vec<IncrementHistogram>> {
        let count = self.request.histograms.min(scales.len());
        let last = scales.len() - 1;
        let mut chosen: Vec<usize> = (0..count)
            .map(|h| {
                if count == 1 {
                    0
                } else {
                    h * last / (count - 1)
                }
            })
            .filter(|i| scales[*i].structure[1] > 0.0)
            .collect();
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

/// Orders 1 to 6, the third moment with its sign, flatness, skewness.
fn statistics(sums: &[f64; SUMS]) -> [f64; ORDERS + 3] {
    let mean = |i: usize| sums[i] / sums[0];
    std::array::from_fn(|i| match i {
        0..ORDERS => mean(i + 1),
        ORDERS => mean(SIGNED),
        _ if i == ORDERS + 1 => mean(4) / (mean(2) * mean(2)),
        _ => mean(SIGNED) / mean(2).powf(1.5),
    })
}

fn moments(
    step: usize,
    scale: f64,
    total: &[f64; SUMS],
    values: &[[f64; SUMS]],
    alpha: f64,
) -> ScaleMoments {
    let found = statistics(total);
    let values: Vec<_> = values.iter().filter(|sums| sums[0] > 0.0).collect();
    let n = values.len() as f64;
    let mut half = [f64::NAN; ORDERS + 3];
    if values.len() > 1 {
        // Jackknife: all values but one.
        let without: Vec<[f64; ORDERS + 3]> = values
            .iter()
            .map(|one| statistics(&std::array::from_fn(|i| total[i] - one[i])))
            .collect();
        let within = student_two_sided(alpha, n - 1.0);
        for (i, half) in half.iter_mut().enumerate() {
            let mean = without.iter().map(|s| s[i]).sum::<f64>() / n;
            let squares: f64 = without.iter().map(|s| (s[i] - mean).powi(2)).sum();
            *half = within * ((n - 1.0) / n * squares).sqrt();
        }
    }
    ScaleMoments {
        step,
        scale,
        pairs: total[0] as u64,
        structure: std::array::from_fn(|p| found[p]),
        third: found[ORDERS],
        flatness: found[ORDERS + 1],
        skewness: found[ORDERS + 2],
        half,
        realisations: values.len(),
    }
}
