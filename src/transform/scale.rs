//! From `|X|^2` to a spectrum with a unit.

use std::f64::consts::TAU;

/// How a spectrum is scaled; see [`Scale`] for the equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scaling {
    /// Energy spectral density of a transient: its integral is the sum of `v^2 dt`.
    #[default]
    Energy,
    /// Power spectral density: its integral is the mean square.
    Density,
    /// Power spectrum: a sine of amplitude A peaks at `A^2 / 2`.
    Spectrum,
}

/// The number of two-sided bins of a real record of length `n` that the one-sided bin `m` counts: 1
/// at `m = 0` and, for even `n`, at `m = n / 2`; else 2.
#[inline(always)]
pub fn fold(m: usize, n: usize) -> f64 {
    if m == 0 || 2 * m == n { 1.0 } else { 2.0 }
}

/// One axis' share in the factor between `|X|^2` and a spectrum.
///
/// With window `w` over `n` samples of spacing `d`, `X = sum w v exp(..)`:
///
/// - energy: `S = |X|^2 d^2 n / sum w^2`, with `sum S df = sum v^2 d` without a window;
/// - density: `S = |X|^2 d / sum w^2`, with `sum S df` the mean square;
/// - spectrum: `S = |X|^2 / (sum w)^2`; a sine of amplitude A has `A^2 / 2` in its bin.
///
/// Along space, bins are counted in rad: energy and density carry another `1 / (2 pi)`. With
/// Welch's method `n d` is the length of the whole record, so that energy stays density times
/// duration. Source: G. Heinzel, A. Rüdiger, R. Schilling, "Spectrum and spectral density
/// estimation by the DFT", 2002, sections 8 and 9.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// `S / |X|^2`, of each of the two sides.
    pub factor: f64,
    /// What a bin counts in the spectrum's integral: its width, in cycles along time and in rad
    /// along space; 1 for the scaling `spectrum`.
    pub measure: f64,
    /// Parseval: `integral S = energy * sum (w v)^2`.
    pub energy: f64,
}

impl Scale {
    /// Along time: bins in cycles.
    ///
    /// `window` over one segment; `record` samples in the whole record; transforms of length
    /// `padded`.
    pub fn along_time(
        scaling: Scaling,
        window: &[f64],
        record: usize,
        padded: usize,
        dt: f64,
    ) -> Scale {
        Self::new(scaling, window, record, padded, dt, 1.0)
    }

    /// Along space: bins in rad.
    pub fn along_space(scaling: Scaling, window: &[f64], padded: usize, dx: f64) -> Scale {
        Self::new(scaling, window, window.len(), padded, dx, TAU)
    }

    fn new(
        scaling: Scaling,
        window: &[f64],
        record: usize,
        padded: usize,
        step: f64,
        turn: f64,
    ) -> Scale {
        let power: f64 = crate::numeric::sum_of_squares(window);
        let gain: f64 = crate::numeric::sum(window);
        let padded = padded as f64;
        let bin = turn / (padded * step);
        let (factor, measure, energy) = match scaling {
            Scaling::Density => (step / power / turn, bin, 1.0 / power),
            Scaling::Energy => {
                let duration = record as f64 * step;
                (duration * (step / power) / turn, bin, duration / power)
            }
            Scaling::Spectrum => (1.0 / (gain * gain), 1.0, padded / (gain * gain)),
        };
        Scale {
            factor,
            measure,
            energy,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sided_bins_count_all_two_sided_ones() {
        for n in 1..50 {
            let total: f64 = (0..=n / 2).map(|m| fold(m, n)).sum();
            assert_eq!(total, n as f64);
        }
    }
}
