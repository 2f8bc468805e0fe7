//! Products of the transforms of a few sites with those of the reference.

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
}

impl SimdKernel for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let [own, re, im] = self.sums;
        let has = L::read(self.has);
        // Of less than eight sites.
        let mut room = [Complex::default(); TOGETHER];
        let rows = self.spectra.chunks_exact(self.width).zip(self.reference);
        for (((row, y), own), (re, im)) in rows.zip(own).zip(re.iter_mut().zip(im)) {
            let row = match row.try_into() {
                Ok(row) => row,
                Err(_) => {
                    room[..self.width].copy_from_slice(row);
                    &room
                }
            };
            let (x_re, x_im) = (L::read(&row.map(|x| x.re)), L::read(&row.map(|x| x.im)));
            let (y_re, y_im) = (L::splat(y.re), L::splat(y.im));
            let add = |sum: &mut LaneBlock, value: L| (L::load(sum) + value).store(sum);
            add(own, has * (x_re * x_re + x_im * x_im));
            add(re, has * (y_re * x_re - y_im * x_im));
            add(im, has * (y_re * x_im + y_im * x_re));
        }
    }
}
