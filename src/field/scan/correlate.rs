//! By how many samples a record comes later than another one.

use column_fft::{Complex, rows};

use crate::numeric::sorted;

/// The delay of a record against the first one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Delay {
    /// Whole samples at the largest correlation.
    pub(super) samples: i64,
    /// From there to the vertex of the parabola through the largest correlation and its neighbours, between
    /// -1/2 and 1/2.
    pub(super) fraction: f64,
    /// The largest correlation over the root of the product of both energies.
    pub(super) coefficient: f64,
}

/// The delay of `record` against the first one; `None` if one of them has a sample that is not finite, or all are equal.
///
/// With the records less their medians, which are the baseline of a blow, `c(L) = sum_n a[n] b[n + L]` over all `n` at which both are known, for
/// all `L` at which there is one. The delay is the `L` of the largest `c`, the smallest distance first.
pub(super) fn delay(first: &[f64], record: &[f64]) -> Option<Delay> {
    let (first, own) = without_median(first)?;
    let (record, others) = without_median(record)?;
    let len = (first.len() + first.len().max(record.len())).next_power_of_two();
    let forward = rows::plan_fft_forward(len);
    let inverse = rows::plan_fft_inverse(len);
    let spectrum = |record: &[f64]| {
        // With zeros behind it.
        let mut padded = record.to_vec();
        padded.resize(len, 0.0);
        let mut spectrum = forward.make_output_vec();
        let done = forward.process(&mut padded, &mut spectrum);
        done.expect("lengths as planned");
        spectrum
    };
    let pairs = spectrum(&first).into_iter().zip(spectrum(&record));
    let mut product: Vec<Complex<f64>> = pairs.map(|(a, b)| a.conj() * b).collect();
    let mut series: Vec<f64> = inverse.make_output_vec();
    let done = inverse.process(&mut product, &mut series);
    done.expect("lengths as planned");
    let at = |lag: i64| series[lag.rem_euclid(len as i64) as usize];
    let (least, most) = (1 - first.len() as i64, record.len() as i64 - 1);
    let near_first = (0..=most.max(-least)).flat_map(|lag| [-lag, lag]);
    let mut samples = 0;
    for lag in near_first.filter(|lag| (least..=most).contains(lag)) {
        if at(lag) > at(samples) {
            samples = lag;
        }
    }
    let (before, here, after) = (at(samples - 1), at(samples), at(samples + 1));
    let bend = before - 2.0 * here + after;
    let fraction = match bend < 0.0 {
        true => (before - after) / (2.0 * bend),
        false => 0.0,
    };
    Some(Delay {
        samples,
        fraction: fraction.clamp(-0.5, 0.5),
        coefficient: here / (len as f64 * (own * others).sqrt()),
    })
}

/// A record less its median, and the energy that is left; `None` if there is none.
fn without_median(record: &[f64]) -> Option<(Vec<f64>, f64)> {
    let (sorted, n) = (sorted(record.iter().copied()), record.len());
    let median = (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0;
    let rest: Vec<f64> = record.iter().map(|value| value - median).collect();
    let energy: f64 = rest.iter().map(|value| value * value).sum();
    (energy > 0.0 && energy.is_finite()).then_some((rest, energy))
}
