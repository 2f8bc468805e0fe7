//! The transforms of all realisations of a record, at hand.

use std::ops::Range;

use num_complex::Complex;

use crate::estimates::realisations::{Realisations, Records, SegmentScratch};
use crate::numeric::lanes::WIDTH;
use crate::numeric::pieces;

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

    /// Power of each realisation in some bins.
    pub fn powers_in(&self, bins: Range<usize>) -> impl Iterator<Item = f64> {
        let all = self.power.chunks_exact(self.stride);
        all.map(move |power| power[bins.clone()].iter().sum())
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

/// How evenly realisations share the products of three transforms where phases are not coupled, in bands of frequencies.
#[derive(Debug, Clone)]
pub(super) struct Evenness {
    bands: Vec<Range<usize>>,
    count: usize,
    /// Sums of `P^2`, Q and `P^2 Q` in each band, with the powers P at the site of the pair and Q at that of the third.
    sums: Vec<[f64; 3]>,
}

/// Bands of equal width, and bins of one at least.
const BANDS: usize = 4;
const OF_BAND: usize = 8;

impl Evenness {
    pub fn zeros(length: usize) -> Evenness {
        let bins = last_bin(length);
        let bands = pieces(bins, bins.div_ceil(BANDS).max(OF_BAND));
        let bands: Vec<_> = bands.map(|band| band.start + 1..band.end + 1).collect();
        let (count, sums) = (0, vec![[0.0; 3]; bands.len()]);
        Evenness { bands, count, sums }
    }

    pub fn add(&mut self, x: &Spectra, z: &Spectra) {
        self.count += x.count();
        for (band, sums) in self.bands.iter().zip(&mut self.sums) {
            let powers = x.powers_in(band.clone()).zip(z.powers_in(band.clone()));
            for (p, q) in powers {
                let terms = [p * p, q, p * p * q];
                sums.iter_mut()
                    .zip(terms)
                    .for_each(|(sum, term)| *sum += term);
            }
        }
    }

    /// `<P^2> <Q> / <P^2 Q>` in the least even band: 1, or less where few realisations have the power of three frequencies. White
    /// noise of one site has `1 / (1 + 2 / k)` in a band of k independent bins, which is taken out.
    pub fn least(&self, shared_bins: f64, is_one_site: bool) -> f64 {
        let of = |(band, [pairs, thirds, all]): (&Range<usize>, &[f64; 3])| {
            let by_chance = 2.0 * shared_bins / band.len() as f64;
            let by_chance = if is_one_site { by_chance } else { 0.0 };
            pairs * thirds / (self.count as f64 * all) * (1.0 + by_chance)
        };
        let bands = self.bands.iter().zip(&self.sums).map(of);
        bands.fold(1.0, f64::min)
    }
}
