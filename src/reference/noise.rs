//! Noise from a seed.

use std::cell::Cell;

use super::Grid;
use crate::field::Field;

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
        let half_range = 3.0_f64.sqrt() * self.deviation;
        let state = Cell::new(self.seed);
        self.grid.sample("white-noise", |_, _| {
            let (next, bits) = split_mix(state.get());
            state.set(next);
            let unit = (bits >> 11) as f64 / (1_u64 << 53) as f64;
            half_range * (2.0 * unit - 1.0)
        })
    }

    /// `2 sigma^2 dt`, in (m/s)^2 / Hz.
    pub fn density(&self) -> f64 {
        2.0 * self.deviation.powi(2) * self.grid.dt
    }
}

/// The next state and 64 random bits.
///
/// Source: Steele, Lea and Flood, OOPSLA 2014 (SplitMix64).
pub(crate) fn split_mix(state: u64) -> (u64, u64) {
    let state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut bits = state;
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (state, bits ^ (bits >> 31))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First outputs for seed 1234567 of the authors' C code (prng.di.unimi.it/splitmix64.c).
    #[test]
    fn val_splitmix_first_outputs() {
        let (state, first) = split_mix(1234567);
        let (_, second) = split_mix(state);
        assert_eq!(first, 6457827717110365317);
        assert_eq!(second, 3203168211198807973);
    }
}
