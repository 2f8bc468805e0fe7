//! Peaks: frequencies at which the power is above that of their neighbours.

use std::ops::Range;

use super::SpectrumEstimate;
use crate::numeric::{chi_square_level, chi_square_quantile, median, parabola};

/// A frequency, or wavenumber, at which power stands above that on either side.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Peak {
    /// Index of the site, or of the time.
    pub column: usize,
    pub bin: usize,
    /// Frequency, or wavenumber, between bins.
    pub at: f64,
    /// Over the larger of the medians on both sides.
    pub ratio: f64,
    /// Of the range about it in which medians of three bins are above half of that of the five bins about it.
    pub width: f64,
}

/// Bins on either side of a peak that belong to it.
const OWN: usize = 2;
/// Bins of a side, at least.
const LEAST: usize = 3;

impl SpectrumEstimate {
    /// Peaks of the sites that have intervals, the highest first: bins above what chance exceeds anywhere in all
    /// spectra with probability alpha, by the chi-square distribution, over the larger of the medians of the bins on
    /// either side. `None` where no site has intervals.
    ///
    /// A slope of the spectrum is none, as one side is above it; the first and last bins have none. Two are one, unless
    /// the median between them is as far below both.
    pub fn peaks(&self) -> Option<Vec<Peak>> {
        let columns = (0..self.has_interval.len()).filter(|j| self.has_interval[*j]);
        let columns: Vec<usize> = columns.collect();
        if columns.is_empty() {
            return None;
        }
        let inside = 1..self.segment[0].div_ceil(2);
        let cells = (columns.len() * inside.len()).max(1) as f64;
        let reach = (inside.len() / 16).max(8);
        // The ratio to a median that chance exceeds.
        let exceeded = |degrees: f64| {
            let of_chance = chi_square_level(self.alpha / cells, degrees);
            of_chance / chi_square_quantile(0.5, degrees)
        };
        let mut last = (f64::NAN, f64::NAN);
        let step = self.bins[1] - self.bins[0];
        let mut peaks = Vec::new();
        for column in columns {
            let power: Vec<f64> = self.spectrum.column(column).to_vec();
            let median = |bins: Range<usize>| {
                let known = power[bins].iter().copied().filter(|s| s.is_finite());
                median(known.clone()).filter(|_| known.count() >= LEAST)
            };
            let about = |m: usize, reach: usize| {
                median(m.saturating_sub(reach)..(m + reach + 1).min(power.len()))
            };
            let first = peaks.len();
            for bin in inside.clone() {
                let above = power.get(bin + 1).copied().unwrap_or(0.0);
                let three = [power[bin - 1], power[bin], above];
                // NaN is above none.
                if !(power[bin] > 0.0 && three.iter().all(|other| power[bin] >= *other)) {
                    continue;
                }
                let below = bin.saturating_sub(OWN + reach).max(inside.start);
                let below = below..bin.saturating_sub(OWN).max(below);
                let above = (bin + OWN + 1).min(inside.end);
                let above = above..(above + reach).min(inside.end);
                let degrees = self.degrees[[bin, column]];
                let (Some(below), Some(above), true) =
                    (median(below), median(above), degrees.is_finite())
                else {
                    continue;
                };
                if degrees != last.0 {
                    last = (degrees, exceeded(degrees));
                }
                let (ratio, level) = (power[bin] / below.max(above), last.1);
                if ratio <= level {
                    continue;
                }
                let half = 0.5 * about(bin, 2).unwrap_or(power[bin]);
                let is_high = |m: &usize| about(*m, 1).is_some_and(|s| s > half);
                let above = (bin + 1..inside.end).take_while(is_high).count();
                let below = (1..bin).rev().take_while(is_high).count();
                let peak = Peak {
                    column,
                    bin,
                    at: self.bins[bin] + parabola(three)[0] * step,
                    ratio,
                    width: (1 + below + above) as f64 * step,
                };
                let is_one = |before: &Peak| {
                    median(before.bin + 1..bin)
                        .is_none_or(|valley| power[bin].min(power[before.bin]) <= valley * level)
                };
                match peaks[first..].last_mut().filter(|before| is_one(before)) {
                    Some(before) if power[bin] > power[before.bin] => *before = peak,
                    Some(_) => {}
                    None => peaks.push(peak),
                }
            }
        }
        peaks.sort_by(|a: &Peak, b| b.ratio.total_cmp(&a.ratio));
        Some(peaks)
    }
}
