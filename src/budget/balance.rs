//! Balances over time: what a quantity changed by against the integral of its rate.

use super::wavenumber::Terms;
use crate::numeric::lanes::{Lanes, SimdKernel, widest};

/// A balance of many quantities: `change = integral of rate`, and how far it is from closing.
#[derive(Debug, Clone, Default)]
pub(super) struct RunningBalance {
    first: Option<Vec<f64>>,
    integral: Vec<f64>,
    off: Vec<f64>,
    worst: f64,
}

impl RunningBalance {
    /// Adds `weight` times the rates at a node of a quadrature, after a first sample was compared.
    pub(super) fn add(&mut self, weight: f64, rates: &[f64]) {
        add(&mut self.integral, weight, rates);
    }

    /// A sample of the trapezoid rule: the weights of its rates in the step before it and in that behind it.
    pub(super) fn sample(&mut self, [before, behind]: [f64; 2], rates: &[f64], values: &[f64]) {
        self.add(before, rates);
        self.compare(values);
        self.add(behind, rates);
    }

    /// Compares with the quantities at a sample.
    pub(super) fn compare(&mut self, values: &[f64]) {
        let first = self.first.get_or_insert_with(|| values.to_vec());
        for row in [&mut self.integral, &mut self.off] {
            row.resize(values.len(), 0.0);
        }
        widest(Residuals {
            values,
            first,
            integral: &self.integral,
            off: &mut self.off,
        });
        self.worst = worst_of(self.worst, &self.off);
    }

    /// The largest residual so far, in units of the quantities.
    pub(super) fn worst(&self) -> f64 {
        self.worst
    }
}

/// Adds `weight` times each value to its sum.
pub(super) fn add(sums: &mut [f64], weight: f64, values: &[f64]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += weight * value;
    }
}

/// The largest of residuals that are 0 or more; NaN counts as larger than any number.
pub(super) fn worst_of(worst: f64, off: &[f64]) -> f64 {
    widest(Worst { worst, off })
}

struct Residuals<'a> {
    values: &'a [f64],
    first: &'a [f64],
    integral: &'a [f64],
    off: &'a mut [f64],
}

impl SimdKernel for Residuals<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let now = self.values.iter().zip(self.first).zip(self.integral);
        for (off, ((value, first), integral)) in self.off.iter_mut().zip(now) {
            *off = (value - first - integral).abs();
        }
    }
}

struct Worst<'a> {
    worst: f64,
    off: &'a [f64],
}

impl SimdKernel for Worst<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let keep = |worst: &mut f64, off: f64| {
            *worst = if *worst >= off || worst.is_nan() {
                *worst
            } else {
                off
            };
        };
        // In lanes: the largest does not depend on the order.
        let mut lanes = [self.worst; 8];
        let chunks = self.off.chunks_exact(8);
        let rest = chunks.remainder();
        for chunk in chunks {
            for (lane, off) in lanes.iter_mut().zip(chunk) {
                keep(lane, *off);
            }
        }
        let mut worst = self.worst;
        for off in lanes.iter().chain(rest) {
            keep(&mut worst, *off);
        }
        worst
    }
}

/// `dE(k)/dt` from all its terms.
pub(super) fn energy_rates(terms: &Terms, rates: &mut Vec<f64>) {
    rates.clone_from(&terms.transfer);
    add(rates, -1.0, &terms.loss);
    add(rates, 1.0, &terms.input);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_residual_is_kept_wherever_it_stands_and_so_is_what_is_no_number() {
        for length in [1, 7, 8, 30] {
            for at in 0..length {
                let mut off = vec![0.5; length];
                off[at] = 2.0;
                assert_eq!(worst_of(1.0, &off), 2.0);
                assert_eq!(worst_of(3.0, &off), 3.0);
                off[at] = f64::NAN;
                assert!(worst_of(1.0, &off).is_nan());
                assert!(worst_of(f64::NAN, &vec![1.0; length]).is_nan());
            }
        }
    }
}
