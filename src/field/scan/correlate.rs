//! By how many samples a record comes later than another one.

use std::sync::Arc;

use column_fft::{Complex, ComplexToReal, RealToComplex, rows};

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

/// The first record, to which others are compared.
///
/// With the records less their medians, which are the baseline of a blow, `c(L) = sum_n a[n] b[n + L]` over all `n` at which both are known, for
/// all `L` at which there is one. The delay is the `L` of the largest `c`, the smallest distance first.
pub(super) struct Correlator {
    first: Vec<f64>,
    energy: f64,
    plans: Plans,
    /// Transform of the first record.
    spectrum: Vec<Complex<f64>>,
}

struct Plans {
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

impl Plans {
    fn new(len: usize) -> Plans {
        Plans {
            forward: rows::plan_fft_forward(len),
            inverse: rows::plan_fft_inverse(len),
        }
    }

    fn len(&self) -> usize {
        self.forward.len()
    }

    /// The transform of a record with zeros behind it.
    fn spectrum(&self, record: &[f64]) -> Vec<Complex<f64>> {
        let mut padded = record.to_vec();
        padded.resize(self.len(), 0.0);
        let mut spectrum = self.forward.make_output_vec();
        let done = self.forward.process(&mut padded, &mut spectrum);
        done.expect("lengths as planned");
        spectrum
    }

    fn back(&self, mut spectrum: Vec<Complex<f64>>) -> Vec<f64> {
        let mut series = self.inverse.make_output_vec();
        let done = self.inverse.process(&mut spectrum, &mut series);
        done.expect("lengths as planned");
        series
    }
}

impl Correlator {
    /// `None` if `first` has a sample that is not finite, or all are equal.
    pub(super) fn new(first: &[f64]) -> Option<Correlator> {
        let (first, energy) = without_median(first)?;
        let plans = Plans::new((2 * first.len()).next_power_of_two());
        Some(Correlator {
            spectrum: plans.spectrum(&first),
            first,
            energy,
            plans,
        })
    }

    /// The delay of `record` against the first one; `None` as for [`Correlator::new`].
    pub(super) fn delay(&self, record: &[f64]) -> Option<Delay> {
        let (record, energy) = without_median(record)?;
        let needed = self.first.len() + record.len();
        if needed <= self.plans.len() {
            return Some(self.peak(&self.plans, &self.spectrum, &record, energy));
        }
        let plans = Plans::new(needed.next_power_of_two());
        Some(self.peak(&plans, &plans.spectrum(&self.first), &record, energy))
    }

    fn peak(&self, plans: &Plans, first: &[Complex<f64>], record: &[f64], energy: f64) -> Delay {
        let spectrum = plans.spectrum(record);
        let product = first.iter().zip(&spectrum).map(|(a, b)| a.conj() * b);
        let series = plans.back(product.collect());
        let at = |lag: i64| series[lag.rem_euclid(series.len() as i64) as usize];
        let (least, most) = (1 - self.first.len() as i64, record.len() as i64 - 1);
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
        let scale = plans.len() as f64 * (self.energy * energy).sqrt();
        Delay {
            samples,
            fraction: fraction.clamp(-0.5, 0.5),
            coefficient: here / scale,
        }
    }
}

/// A record less its median, and the energy that is left; `None` if there is none.
fn without_median(record: &[f64]) -> Option<(Vec<f64>, f64)> {
    let (sorted, n) = (sorted(record.iter().copied()), record.len());
    let median = (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0;
    let rest: Vec<f64> = record.iter().map(|value| value - median).collect();
    let energy: f64 = rest.iter().map(|value| value * value).sum();
    (energy > 0.0 && energy.is_finite()).then_some((rest, energy))
}
