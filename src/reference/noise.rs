//! Noise from a seed.

use std::cell::Cell;

use super::Grid;
use crate::field::Field;
use crate::numeric::{split_mix, unit_interval};

/// Independent samples, uniform between `-sqrt(3) sigma` and `sqrt(3) sigma`: the same bits from
/// the same seed everywhere.
///
/// The expected one-sided power spectral density is `2 sigma^2 dt` at every frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WhiteNoise {
    pub grid: Grid,
    /// sigma, in m/s.
    pub deviation: f64,
    pub seed: u64,
}

impl WhiteNoise {
    pub fn field(&self) -> Field {
        let next = self.samples();
        self.grid.sample("white-noise", |_, _| next())
    }

    /// One sample after the other.
    pub(super) fn samples(&self) -> impl Fn() -> f64 {
        let half_range = 3.0_f64.sqrt() * self.deviation;
        let state = Cell::new(self.seed);
        move || {
            let (next, bits) = split_mix(state.get());
            state.set(next);
            half_range * (2.0 * unit_interval(bits) - 1.0)
        }
    }

    /// `2 sigma^2 dt`, in (m/s)^2 / Hz.
    pub fn density(&self) -> f64 {
        2.0 * self.deviation.powi(2) * self.grid.dt
    }
}
