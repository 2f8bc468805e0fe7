//! Balances over time: what a quantity changed by against the integral of its rate.

use super::wavenumber::Terms;

/// A balance of many quantities: `change = integral of rate`, and how far it is from closing.
#[derive(Debug, Clone, Default)]
pub(super) struct Ledger {
    first: Option<Vec<f64>>,
    integral: Vec<f64>,
    worst: f64,
}

impl Ledger {
    /// Adds `weight` times the rates at a node of a quadrature, after a first sample was compared.
    pub(super) fn add(&mut self, weight: f64, rates: impl Iterator<Item = f64>) {
        for (sum, rate) in self.integral.iter_mut().zip(rates) {
            *sum += weight * rate;
        }
    }

    /// Adds a step of the trapezoid rule between two samples.
    pub(super) fn trapezoid(&mut self, dt: f64, before: &[f64], now: &[f64]) {
        self.integral.resize(now.len(), 0.0);
        for (sum, (before, now)) in self.integral.iter_mut().zip(before.iter().zip(now)) {
            *sum += 0.5 * dt * (before + now);
        }
    }

    /// Compares with the quantities at a sample.
    pub(super) fn compare(&mut self, values: &[f64]) {
        let first = self.first.get_or_insert_with(|| values.to_vec());
        self.integral.resize(values.len(), 0.0);
        let mut worst = self.worst;
        for ((value, first), integral) in values.iter().zip(first).zip(&self.integral) {
            let off = (value - *first - integral).abs();
            // What is not a number is worse than any residual, and stays.
            worst = if worst >= off || worst.is_nan() {
                worst
            } else {
                off
            };
        }
        self.worst = worst;
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
