//! Lines: sines of constant amplitude, found by Thomson's F-test.

use num_complex::Complex;

use crate::estimates::realisations::TOGETHER;
use crate::numeric::lanes::LaneBlock;

/// A line of one record.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Line {
    /// Index of the site, or of the time.
    pub column: usize,
    /// Frequency, or wavenumber, to a quarter of a bin.
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

/// Where in a bin lines are searched, as shares of a bin: a line away from the middle of a bin leaves a part
/// of itself beside the line that is fitted there, so that F is at most 5 half a bin off with seven tapers.
pub(super) const OFFSETS: [f64; 4] = [0.0, 0.25, 0.5, -0.25];

/// Blocks of sums over segments and records of one cell: the power of the line that fits best at each offset,
/// and all.
pub(crate) const LINE_BLOCKS: usize = OFFSETS.len() + 1;

/// The power of the line at an offset, and what is left beside it, of a site.
pub(crate) fn line_and_rest(
    sums: &[LaneBlock; LINE_BLOCKS],
    offset: usize,
    lane: usize,
) -> (f64, f64) {
    let (line, power) = (sums[offset].0[lane], sums[OFFSETS.len()].0[lane]);
    // Rounding may leave less than nothing.
    (line, (power - line).max(f64::EPSILON * power))
}

/// Sums over the tapers of one segment of one cell.
#[derive(Clone, Copy, Default)]
pub(super) struct TaperSums {
    product: [[Complex<f64>; TOGETHER]; OFFSETS.len()],
    power: [f64; TOGETHER],
}

impl TaperSums {
    /// Adds the transforms of the sites under a taper with these transforms at the offsets.
    pub fn add(&mut self, taper: &[Complex<f64>; OFFSETS.len()], transforms: &[Complex<f64>]) {
        for (product, u) in self.product.iter_mut().zip(taper) {
            for (product, x) in product.iter_mut().zip(transforms) {
                *product += u.conj() * x;
            }
        }
        for (power, x) in self.power.iter_mut().zip(transforms) {
            *power += x.norm_sqr();
        }
    }

    /// Adds them to the sums of segments, and empties them. `gains`: sums of the squares of the tapers'
    /// transforms; `has`: 1, or 0 for a site whose segment does not count.
    pub fn take_into(
        &mut self,
        sums: &mut [LaneBlock; LINE_BLOCKS],
        gains: &[f64; OFFSETS.len()],
        has: &[f64; TOGETHER],
    ) {
        let lines = sums.iter_mut().zip(&self.product);
        for ((sums, products), gain) in lines.zip(gains) {
            for ((sum, product), has) in sums.0.iter_mut().zip(products).zip(has) {
                *sum += has * product.norm_sqr() / gain;
            }
        }
        let powers = sums[OFFSETS.len()].0.iter_mut().zip(&self.power);
        for ((sum, power), has) in powers.zip(has) {
            *sum += has * power;
        }
        *self = TaperSums::default();
    }
}
