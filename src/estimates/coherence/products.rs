//! Products of the transforms of a few sites with those of the reference.

use std::ops::Range;

use num_complex::Complex;

use crate::estimates::realisations::TOGETHER;
use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel};

/// What one realisation of a tile adds to its sums.
pub(super) struct Products<'a> {
    /// `[bin * width + site]`.
    pub spectra: &'a [Complex<f64>],
    pub width: usize,
    /// The conjugate transform of the reference.
    pub reference: &'a [Complex<f64>],
    /// 1, or 0 for a site whose realisation does not count.
    pub has: &'a [f64; TOGETHER],
    /// A block a bin: power, real and imaginary part of the product with the reference.
    pub sums: [&'a mut [LaneBlock]; 3],
    /// Bands of bins, the power of the reference in each, and a block of its products with that of the sites.
    pub bands: (&'a [Range<usize>], &'a [f64], &'a mut [LaneBlock]),
}

impl SimdKernel for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let [own, re, im] = self.sums;
        let has = L::read(self.has);
        // Of less than eight sites.
        let mut room = [Complex::default(); TOGETHER];
        let add = |sum: &mut LaneBlock, value: L| (L::load(sum) + value).store(sum);
        let (bands, levels, shared) = self.bands;
        for ((bins, level), shared) in bands.iter().zip(levels).zip(shared) {
            let mut power = L::splat(0.0);
            let rows = self.spectra[bins.start * self.width..].chunks_exact(self.width);
            let rows = rows.zip(&self.reference[bins.clone()]);
            let (re, im) = (&mut re[bins.clone()], &mut im[bins.clone()]);
            let rows = rows.zip(&mut own[bins.clone()]);
            for (((row, y), own), (re, im)) in rows.zip(re.iter_mut().zip(im)) {
                let row = match row.try_into() {
                    Ok(row) => row,
                    Err(_) => {
                        room[..self.width].copy_from_slice(row);
                        &room
                    }
                };
                let (x_re, x_im) = (L::read(&row.map(|x| x.re)), L::read(&row.map(|x| x.im)));
                let (y_re, y_im) = (L::splat(y.re), L::splat(y.im));
                let of_bin = has * (x_re * x_re + x_im * x_im);
                power = power + of_bin;
                add(own, of_bin);
                add(re, has * (y_re * x_re - y_im * x_im));
                add(im, has * (y_re * x_im + y_im * x_re));
            }
            add(shared, L::splat(*level) * power);
        }
    }
}
