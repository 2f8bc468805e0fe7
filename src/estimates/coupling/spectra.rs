//! The transforms of all realisations of a record, at hand.

use num_complex::Complex;

use crate::estimates::realisations::{Realisations, Records, SegmentScratch};
use crate::numeric::lanes::WIDTH;

/// Transforms of one record below the Nyquist frequency, realisation by realisation.
#[derive(Debug, Clone, Default)]
pub(super) struct Spectra {
    bins: usize,
    /// Numbers of a realisation: its bins, and zeros, so that blocks may begin at any bin.
    stride: usize,
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

/// See [`Spectra`].
fn stride(bins: usize) -> usize {
    (bins + WIDTH).next_multiple_of(WIDTH)
}

/// The highest bin below the Nyquist frequency of segments of this length.
pub(super) fn last_bin(length: usize) -> usize {
    (length - 1) / 2
}

impl Spectra {
    /// Of each of the records the realisations that are kept.
    pub fn of(
        realisations: &Realisations,
        records: Records<'_>,
        scratch: &mut SegmentScratch,
    ) -> Vec<Spectra> {
        let (bins, width) = (last_bin(realisations.segments.length) + 1, records.width());
        let stride = stride(bins);
        let zeros = vec![0.0; stride * realisations.count()];
        let empty = Spectra {
            bins,
            stride,
            re: zeros.clone(),
            im: zeros.clone(),
            power: zeros,
        };
        let mut found = vec![empty; width];
        let visit = |r: usize, spectra: &[Complex<f64>]| {
            for (c, one) in found.iter_mut().enumerate() {
                let range = r * stride..r * stride + bins;
                let (re, im) = (&mut one.re[range.clone()], &mut one.im[range.clone()]);
                let places = re.iter_mut().zip(im).zip(&mut one.power[range]);
                let spectrum = spectra.iter().skip(c).step_by(width);
                for (x, ((re, im), power)) in spectrum.zip(places) {
                    (*re, *im, *power) = (x.re, x.im, x.norm_sqr());
                }
            }
        };
        realisations.each(records, scratch, visit);
        found
    }

    /// Bytes of so many realisations of one record, of segments of this length.
    pub fn bytes(length: usize, count: usize) -> u64 {
        24 * (stride(last_bin(length) + 1) * count) as u64
    }

    pub fn bins(&self) -> usize {
        self.bins
    }

    /// Sums of the power of each bin over all realisations, added to `sums`.
    pub fn add_power(&self, sums: &mut [f64]) {
        for power in self.power.chunks_exact(self.stride) {
            for (sum, power) in sums.iter_mut().zip(power) {
                *sum += power;
            }
        }
    }

    /// Sets a bin to 0.
    pub fn clear(&mut self, bin: usize) {
        for values in [&mut self.re, &mut self.im, &mut self.power] {
            let cells = values.iter_mut().skip(bin).step_by(self.stride);
            cells.for_each(|v| *v = 0.0);
        }
    }

    pub fn count(&self) -> usize {
        self.re.len() / self.stride.max(1)
    }

    pub fn get(&self, realisation: usize) -> Spectrum<'_> {
        let range = realisation * self.stride..(realisation + 1) * self.stride;
        Spectrum {
            re: &self.re[range.clone()],
            im: &self.im[range.clone()],
            power: &self.power[range],
        }
    }
}
