//! Balances over time: what a quantity changed by against the integral of its rate.

use super::scale::{ScaleTerms, Scales};
use super::wavenumber::Terms;

/// A balance of many quantities: `change = integral of rate`, and how far it is from closing.
#[derive(Debug, Clone, Default)]
pub(super) struct Ledger {
    first: Option<Vec<f64>>,
    integral: Vec<f64>,
    worst: f64,
}

impl Ledger {
    /// Adds `weight` times the rates at a node of a quadrature.
    pub(super) fn add(&mut self, weight: f64, rates: impl Iterator<Item = f64>) {
        // The first node brings the length.
        if self.integral.is_empty() {
            self.integral.extend(rates.map(|rate| weight * rate));
            return;
        }
        for (sum, rate) in self.integral.iter_mut().zip(rates) {
            *sum += weight * rate;
        }
    }

    /// Compares with the quantities at a sample.
    pub(super) fn compare(&mut self, values: &[f64]) {
        let first = self.first.get_or_insert_with(|| values.to_vec());
        for (m, (value, first)) in values.iter().zip(first).enumerate() {
            let off = (value - *first - self.integral.get(m).unwrap_or(&0.0)).abs();
            // What is not a number is worse than any residual, and stays.
            if off > self.worst || off.is_nan() {
                self.worst = off;
            }
        }
    }

    /// The largest residual so far, in units of the quantities.
    pub(super) fn worst(&self) -> f64 {
        self.worst
    }
}

/// `dE(k)/dt` from all its terms.
pub(super) fn energy_rates(terms: &Terms) -> impl Iterator<Item = f64> + '_ {
    terms.transfer.iter().enumerate().map(|(m, transfer)| {
        transfer - terms.loss.get(m).unwrap_or(&0.0) + terms.input.get(m).unwrap_or(&0.0)
    })
}

/// The balances of chosen scales.
#[derive(Debug)]
pub(super) struct ScaleLedgers(Vec<Ledger>);

impl ScaleLedgers {
    pub(super) fn new(scales: &Scales) -> ScaleLedgers {
        ScaleLedgers(vec![Ledger::default(); scales.scales.len()])
    }

    pub(super) fn add(&mut self, scale: usize, weight: f64, terms: &ScaleTerms) {
        self.0[scale].add(weight, terms.energy_rate.iter().copied());
    }

    pub(super) fn compare(&mut self, scale: usize, terms: &ScaleTerms) {
        self.0[scale].compare(&terms.energy);
    }

    /// Of each scale.
    pub(super) fn worst(&self) -> Vec<f64> {
        self.0.iter().map(Ledger::worst).collect()
    }
}
