//! The transforms of all realisations of a record, at hand.

use crate::estimates::realisations::{Realisations, SegmentScratch};

/// Transforms of one record below the Nyquist frequency, realisation by realisation.
#[derive(Debug, Clone, Default)]
pub(super) struct Spectra {
    bins: usize,
    re: Vec<f64>,
    im: Vec<f64>,
    power: Vec<f64>,
}

/// One realisation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spectrum<'s> {
    pub re: &'s [f64],
    pub im: &'s [f64],
    pub power: &'s [f64],
}

/// The highest bin below the Nyquist frequency of segments of this length.
pub(super) fn last_bin(length: usize) -> usize {
    (length - 1) / 2
}

impl Spectra {
    /// Of `width` records that follow one another, multiplied by `scale`.
    pub fn of(
        realisations: &Realisations,
        records: &[f64],
        width: usize,
        scale: f64,
        scratch: &mut SegmentScratch,
    ) -> Vec<Spectra> {
        let bins = last_bin(realisations.segments.length) + 1;
        let all = bins * realisations.count();
        let mut found = vec![
            Spectra {
                bins,
                re: Vec::with_capacity(all),
                im: Vec::with_capacity(all),
                power: Vec::with_capacity(all),
            };
            width
        ];
        realisations.each(records, scratch, |_, spectra| {
            for row in spectra.chunks_exact(width).take(bins) {
                for (x, one) in row.iter().zip(&mut found) {
                    let x = x * scale;
                    one.re.push(x.re);
                    one.im.push(x.im);
                    one.power.push(x.norm_sqr());
                }
            }
        });
        found
    }

    /// Bytes of one record's, of segments of this length.
    pub fn bytes(realisations: &Realisations) -> u64 {
        let bins = last_bin(realisations.segments.length) + 1;
        24 * (bins * realisations.count()) as u64
    }

    /// Sums of the power of each bin over all realisations, added to `sums`.
    pub fn add_power(&self, sums: &mut Vec<f64>) {
        sums.resize(self.bins, 0.0);
        for power in self.power.chunks_exact(self.bins) {
            for (sum, power) in sums.iter_mut().zip(power) {
                *sum += power;
            }
        }
    }

    /// Sets a bin to 0.
    pub fn clear(&mut self, bin: usize) {
        for values in [&mut self.re, &mut self.im, &mut self.power] {
            values
                .iter_mut()
                .skip(bin)
                .step_by(self.bins)
                .for_each(|v| *v = 0.0);
        }
    }

    pub fn count(&self) -> usize {
        self.re.len() / self.bins.max(1)
    }

    pub fn get(&self, realisation: usize) -> Spectrum<'_> {
        let range = realisation * self.bins..(realisation + 1) * self.bins;
        Spectrum {
            re: &self.re[range.clone()],
            im: &self.im[range.clone()],
            power: &self.power[range],
        }
    }
}
