//! Filters over unit cells: which neighbours of a site count how much at a scale l.
//!
//! A scale means different widths in the literature, so each filter states the three numbers that
//! are meant by it: the length l, the standard deviation sigma of its weights, and the wavenumber
//! at which its gain has fallen to 1/2.

use crate::numeric::at_or_below;
use std::f64::consts::{LN_2, PI};

/// A coarse-graining filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// Weights `exp(-x^2 / (2 sigma^2))` with `sigma = l / sqrt(12)`, the standard deviation of a
    /// box of length l (A. Leonard, Adv. Geophys. 18 A (1974) 237).
    #[default]
    Gaussian,
    /// Equal weights over the length l; the cells at its ends count by the part inside.
    Box,
    /// Gain 1 up to `k = 2 pi / l`, 0 above; reaches through the whole chain.
    Sharp,
}

/// A filter of one scale.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ScaleOf {
    pub filter: Filter,
    /// Length l, in units of length.
    pub scale: f64,
    /// Standard deviation of the continuous filter; `None` for the sharp one, which has none.
    pub sigma: Option<f64>,
    /// Wavenumber at which the continuous filter's gain is 1/2, in rad per length; the cut-off of
    /// the sharp one.
    pub cutoff_wavenumber: f64,
    /// Cells on either side that count.
    pub reach: usize,
}

/// Below this a weight no longer changes a sum of numbers in double precision.
const LEAST_WEIGHT: f64 = 1e-18;

impl ScaleOf {
    /// `scale` and `cell` in units of length.
    pub(super) fn new(filter: Filter, scale: f64, cell: f64, cells: usize) -> ScaleOf {
        let sigma = scale / 12f64.sqrt();
        // Where sin(z) / z = 1/2.
        let half_gain = 1.895_494_267_033_981;
        let (sigma, cutoff_wavenumber, reach) = match filter {
            Filter::Gaussian => {
                let reach = (-2.0 * LEAST_WEIGHT.ln()).sqrt() * sigma / cell;
                let cutoff = (2.0 * LN_2).sqrt() / sigma;
                (Some(sigma), cutoff, reach.floor() as usize)
            }
            Filter::Box => {
                let reach = (0.5 * scale / cell + 0.5).ceil() as usize - 1;
                (Some(sigma), 2.0 * half_gain / scale, reach)
            }
            Filter::Sharp => (None, 2.0 * PI / scale, cells / 2),
        };
        ScaleOf {
            filter,
            scale,
            sigma,
            cutoff_wavenumber,
            reach,
        }
    }

    /// Gain at each wavenumber `2 pi m / (cells cell)`, `m = 0 ..= cells / 2`, of the filter over a
    /// ring of cells.
    pub(super) fn gains(&self, cell: f64, cells: usize) -> Vec<f64> {
        let step = 2.0 * PI / (cells as f64 * cell);
        if self.filter == Filter::Sharp {
            let passes = |m: usize| at_or_below(step * m as f64, self.cutoff_wavenumber);
            let gain = |m: usize| if passes(m) { 1.0 } else { 0.0 };
            return (0..=cells / 2).map(gain).collect();
        }
        let weight = |i: usize| self.weight(i as f64 * cell, cell);
        let weights: Vec<f64> = (0..=self.reach).map(weight).collect();
        let total = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
        (0..=cells / 2)
            .map(|m| {
                let angle = |i: usize| 2.0 * PI * ((i * m) % cells) as f64 / cells as f64;
                let terms = weights.iter().enumerate().skip(1);
                // From the smallest on.
                let sum: f64 = terms.rev().map(|(i, w)| 2.0 * w * angle(i).cos()).sum();
                (sum + weights[0]) / total
            })
            .collect()
    }

    /// Weight of the cell at distance x, not normalised.
    fn weight(&self, x: f64, cell: f64) -> f64 {
        match self.filter {
            Filter::Box => ((0.5 * self.scale - x) / cell + 0.5).clamp(0.0, 1.0),
            _ => {
                let ratio = x / self.sigma.unwrap_or(self.scale);
                (-0.5 * ratio * ratio).exp()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cut-off of the continuous filters, which wide ones over many cells come close to.
    #[test]
    fn val_closed_form_cutoff() {
        let cells = 4096;
        let step = 2.0 * PI / cells as f64;
        for filter in [Filter::Gaussian, Filter::Box] {
            let wide = ScaleOf::new(filter, 400.0, 1.0, cells);
            let m = wide.cutoff_wavenumber / step;
            let gains = wide.gains(1.0, cells);
            let (low, share) = (gains[m as usize], m.fract());
            let between = low + share * (gains[m as usize + 1] - low);
            assert!((between - 0.5).abs() < 2e-3, "{filter:?} {between}");
        }
    }

    #[test]
    fn a_box_shorter_than_a_cell_changes_nothing() {
        for scale in [0.3, 1.0] {
            let boxed = ScaleOf::new(Filter::Box, scale, 1.0, 8);
            assert_eq!(boxed.gains(1.0, 8), [1.0; 5]);
        }
    }
}
