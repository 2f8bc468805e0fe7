//! Lines: sines of constant amplitude, found by Thomson's F-test.

use num_complex::Complex;

use super::shots::TOGETHER;

/// A line of one record.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Line {
    /// Index of the site, or of the time.
    pub column: usize,
    /// Frequency, or wavenumber, of the bin.
    pub at: f64,
    /// Of the sine, in the unit of the samples.
    pub amplitude: f64,
    /// Its standard error.
    pub amplitude_error: f64,
    /// The statistic of the test.
    pub f: f64,
    /// By which one cell exceeds it by chance.
    pub probability: f64,
}

/// Sums over segments and records of one cell: the power of the line that fits best, and the rest.
#[derive(Clone, Copy, Default)]
pub(super) struct LineSums {
    pub line: [f64; TOGETHER],
    pub rest: [f64; TOGETHER],
}

/// Sums over the tapers of one segment of one cell.
#[derive(Clone, Copy, Default)]
pub(super) struct TaperSums {
    product: [Complex<f64>; TOGETHER],
    power: [f64; TOGETHER],
}

impl TaperSums {
    /// Adds the transforms of the sites under a taper with this sum.
    pub fn add(&mut self, taper_sum: f64, transforms: &[Complex<f64>]) {
        let sums = self.product.iter_mut().zip(&mut self.power);
        for ((product, power), x) in sums.zip(transforms) {
            *product += x * taper_sum;
            *power += x.norm_sqr();
        }
    }

    /// Adds them to the sums of segments, and empties them. `gain`: the sum of the squares of the tapers'
    /// sums; `squared`: what squares are multiplied by.
    pub fn take_into(&mut self, sums: &mut LineSums, gain: f64, squared: f64) {
        for c in 0..TOGETHER {
            let line = self.product[c].norm_sqr() / gain;
            sums.line[c] += squared * line;
            // Rounding may leave less than nothing.
            sums.rest[c] += squared * (self.power[c] - line).max(0.0);
        }
        *self = TaperSums::default();
    }
}
