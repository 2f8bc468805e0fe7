//! Energy that has passed each wavenumber, `Pi(k, t)` integrated since the first sample, two ways.
//!
//! By the definition it is `- sum_{k' <= k}` of the integral of `T(k')`. By the balance
//! `dE(k)/dt = T(k) - L(k) + I(k)` it is the sum over `k' <= k` of `E(k', t0) - E(k', t)`, less the
//! integral of `L(k') - I(k')`. The first knows no energy, the second no transfer: how far they are
//! apart checks both. At the largest k either is 0: the first since `sum T = 0`, the second if
//! energies and losses balance.

use super::balance::{trapezoid, worst_of};
use super::wavenumber::Terms;

/// Which of the two is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GivenRate {
    /// The integral of the transfer.
    Transfer,
    /// What the wavenumbers lost, less what losses took and inputs gave: without either a function
    /// of the state, exact at any sampling.
    Balance,
}

/// Transfer, and losses less input, at one sample.
#[derive(Debug, Clone, Default)]
pub(super) struct PassageRates {
    pub(super) transfer: Vec<f64>,
    pub(super) gone: Vec<f64>,
}

impl PassageRates {
    pub(super) fn load(&mut self, terms: &Terms) {
        self.transfer.clone_from(&terms.transfer);
        self.gone.clear();
        self.gone.resize(terms.transfer.len(), 0.0);
        add_gone(&mut self.gone, 1.0, terms);
    }
}

/// Adds `weight` times losses less input.
fn add_gone(sums: &mut [f64], weight: f64, terms: &Terms) {
    for (sum, loss) in sums.iter_mut().zip(&terms.loss) {
        *sum += weight * loss;
    }
    for (sum, input) in sums.iter_mut().zip(&terms.input) {
        *sum -= weight * input;
    }
}

/// The integrals over time.
pub(super) struct Passage {
    way: GivenRate,
    /// The sample in the middle.
    half: usize,
    first: Option<Vec<f64>>,
    /// Integrals of the transfer, and of losses less input.
    transferred: Vec<f64>,
    gone: Vec<f64>,
    by_transfer: Vec<f64>,
    by_balance: Vec<f64>,
    at_half: Vec<f64>,
    off: Vec<f64>,
    top: f64,
    apart: f64,
}

impl Passage {
    pub(super) fn new(way: GivenRate, samples: usize, wavenumbers: usize) -> Passage {
        let row = || vec![0.0; wavenumbers];
        Passage {
            way,
            half: (samples - 1) / 2,
            first: None,
            transferred: row(),
            gone: row(),
            by_transfer: row(),
            by_balance: row(),
            at_half: row(),
            off: row(),
            top: 0.0,
            apart: 0.0,
        }
    }

    /// Adds a node of a quadrature.
    pub(super) fn add(&mut self, weight: f64, terms: &Terms) {
        for (sum, transfer) in self.transferred.iter_mut().zip(&terms.transfer) {
            *sum += weight * transfer;
        }
        add_gone(&mut self.gone, weight, terms);
    }

    /// Adds a step of the trapezoid rule between two samples.
    pub(super) fn trapezoid(&mut self, dt: f64, before: &PassageRates, now: &PassageRates) {
        trapezoid(&mut self.transferred, dt, &before.transfer, &now.transfer);
        trapezoid(&mut self.gone, dt, &before.gone, &now.gone);
    }

    /// What has passed each wavenumber by sample i, at which the wavenumbers hold `energy`.
    pub(super) fn sample(&mut self, i: usize, energy: &[f64]) -> &[f64] {
        let first = self.first.get_or_insert_with(|| energy.to_vec());
        let lost = first.iter().zip(energy).zip(&self.gone);
        running(
            &mut self.by_balance,
            lost.map(|((first, now), gone)| first - now - gone),
        );
        let transferred = self.transferred.iter().map(|transferred| -transferred);
        running(&mut self.by_transfer, transferred);
        let pairs = self.by_transfer.iter().zip(&self.by_balance);
        self.off.clear();
        self.off.extend(pairs.map(|(a, b)| (a - b).abs()));
        self.apart = worst_of(self.apart, &self.off);
        let row = match self.way {
            GivenRate::Transfer => &self.by_transfer,
            GivenRate::Balance => &self.by_balance,
        };
        let top = row.last().map_or(0.0, |top| top.abs());
        self.top = worst_of(self.top, &[top]);
        if i == self.half {
            self.at_half.clone_from(row);
        }
        row
    }

    /// Over the record, and over its second half.
    pub(super) fn whole_and_late(&self) -> [Vec<f64>; 2] {
        let whole = match self.way {
            GivenRate::Transfer => &self.by_transfer,
            GivenRate::Balance => &self.by_balance,
        };
        let late = whole
            .iter()
            .zip(&self.at_half)
            .map(|(all, half)| all - half);
        [whole.clone(), late.collect()]
    }

    /// The largest magnitude at the largest wavenumber, where it is 0, at any sample.
    pub(super) fn top(&self) -> f64 {
        self.top
    }

    /// The largest difference of the two ways at any sample and wavenumber.
    pub(super) fn apart(&self) -> f64 {
        self.apart
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
