//! Balances over time: what a quantity changed by against the integral of its rate.
//!
//! Energy that has passed each wavenumber, `Pi(k, t)` integrated since the first sample, two ways.
//!
//! By the definition it is `- sum_{k' <= k}` of the integral of `T(k')`. By the balance
//! `dE(k)/dt = T(k) - L(k) + I(k)` it is the sum over `k' <= k` of `E(k', t0) - E(k', t)`, less the
//! integral of `L(k') - I(k')`. The first knows no energy, the second no transfer: how far they are
//! apart checks both. At the largest k either is 0: the first since `sum T = 0`, the second if
//! energies and losses balance.

use super::result::{Budget, IntegratedFluxCheck, WavenumberBudget};
use super::wavenumber::Terms;

/// Passed energies below this share of the energy are rounding errors: spectral energies are squares
/// of transforms, each with an error of a few units in the last place.
const ROUNDING: f64 = 1e-14;

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

    /// Compares with the quantities at a sample between nodes.
    pub(super) fn compare(&mut self, values: &[f64]) {
        let first = self.first.get_or_insert_with(|| values.to_vec());
        self.integral.resize(values.len(), 0.0);
        self.off.clear();
        let all = values.iter().zip(&*first).zip(&self.integral);
        self.off
            .extend(all.map(|((value, first), integral)| (value - first - integral).abs()));
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
    let larger = |a: f64, b: f64| if a >= b || a.is_nan() { a } else { b };
    // In lanes: the largest does not depend on the order.
    let mut lanes = [worst; 8];
    let chunks = off.chunks_exact(8);
    let rest = chunks.remainder();
    for chunk in chunks {
        for (lane, off) in lanes.iter_mut().zip(chunk) {
            *lane = larger(*lane, *off);
        }
    }
    let all = lanes.into_iter().chain(rest.iter().copied());
    all.fold(worst, larger)
}

/// Which of the two is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum GivenRate {
    /// The integral of the transfer.
    #[default]
    Transfer,
    /// What the wavenumbers lost, less what losses took and inputs gave: without either a function
    /// of the state, exact at any sampling.
    Balance,
}

/// The integrals over time.
#[derive(Default)]
pub(super) struct Passage {
    way: GivenRate,
    /// The sample in the middle.
    half: usize,
    first: Option<Vec<f64>>,
    /// Integrals of the transfer, and of losses less input.
    transferred: Vec<f64>,
    gone: Vec<f64>,
    row: Vec<f64>,
    at_half: Vec<f64>,
    off: Vec<f64>,
    apart: Vec<f64>,
    /// The largest residual of the balance at any sample and wavenumber.
    worst: f64,
    check: IntegratedFluxCheck,
}

impl Passage {
    pub(super) fn new(way: GivenRate, samples: usize, wavenumbers: usize) -> Passage {
        Passage {
            way,
            half: (samples - 1) / 2,
            transferred: vec![0.0; wavenumbers],
            gone: vec![0.0; wavenumbers],
            ..Passage::default()
        }
    }

    /// Adds a node of a quadrature.
    pub(super) fn add(&mut self, weight: f64, terms: &Terms) {
        add(&mut self.transferred, weight, &terms.transfer);
        add(&mut self.gone, weight, &terms.loss);
        add(&mut self.gone, -weight, &terms.input);
    }

    /// Finds what has passed each wavenumber by sample i, at which the wavenumbers hold `energy`.
    pub(super) fn compare(&mut self, i: usize, energy: &[f64]) {
        let first = self.first.get_or_insert_with(|| energy.to_vec());
        let is_transfer = self.way == GivenRate::Transfer;
        let (mut passed, mut apart) = (0.0, 0.0);
        for row in [&mut self.row, &mut self.off, &mut self.apart] {
            row.clear();
        }
        let integrals = self.transferred.iter().zip(&self.gone);
        for ((first, now), (transferred, gone)) in first.iter().zip(energy).zip(integrals) {
            let lost = first - now - gone;
            passed += if is_transfer { -transferred } else { lost };
            apart += lost + transferred;
            self.row.push(passed);
            self.off.push((lost + transferred).abs());
            self.apart.push(apart.abs());
        }
        self.worst = worst_of(self.worst, &self.off);
        let check = &mut self.check;
        check.two_ways = worst_of(check.two_ways, &self.apart);
        check.at_largest_wavenumber = worst_of(check.at_largest_wavenumber, &[passed.abs()]);
        if i == self.half {
            self.at_half.clone_from(&self.row);
        }
    }

    /// What has passed each wavenumber by the last sample.
    pub(super) fn passed(&self) -> &[f64] {
        &self.row
    }

    /// Puts the integrated flux into `found`, its checks and the balance into the budget, and both together.
    pub(super) fn finish(self, mut found: WavenumberBudget, budget: &mut Budget) {
        let halves = self.row.iter().zip(&self.at_half);
        found.late_flux = halves.map(|(all, half)| all - half).collect();
        found.integrated_flux = self.row;
        // From samples the transfer integrates poorly; the balance does so only with losses.
        let error = match self.way {
            GivenRate::Transfer => self.check.two_ways,
            GivenRate::Balance => self.check.at_largest_wavenumber,
        };
        found.passed_error = error.max(ROUNDING * budget.scale);
        budget.closure.wavenumber = budget.relative(self.worst);
        let check = IntegratedFluxCheck {
            at_largest_wavenumber: self.check.at_largest_wavenumber / budget.scale,
            two_ways: self.check.two_ways / budget.scale,
        };
        let is_finite = check.at_largest_wavenumber.is_finite() && check.two_ways.is_finite();
        budget.closure.integrated_flux = is_finite.then_some(check);
        budget.wavenumber = Some(found);
    }
}

/// Sums of all terms up to each.
pub(super) fn running(sums: &mut Vec<f64>, terms: impl Iterator<Item = f64>) {
    let mut sum = 0.0;
    sums.clear();
    sums.extend(terms.map(|term| {
        sum += term;
        sum
    }));
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
