//! Products of the transforms of a few sites with those of the reference.

use num_complex::Complex;

use crate::estimates::realisations::TOGETHER;
use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, widest};

/// What one realisation of a tile adds to its sums.
pub(super) struct Products<'a> {
    /// `[bin * width + site]`.
    pub spectra: &'a [Complex<f64>],
    pub width: usize,
    /// The conjugate transform of the reference, times `squared`.
    pub reference: &'a [Complex<f64>],
    /// What powers are multiplied by.
    pub squared: f64,
    /// 1, or 0 for a site whose realisation does not count.
    pub has: &'a [f64; TOGETHER],
    /// A block a bin: power, real and imaginary part of the product with the reference.
    pub sums: [&'a mut [LaneBlock]; 3],
}

impl Products<'_> {
    /// Adds them.
    pub fn add(self) {
        if self.width == TOGETHER {
            return widest(OfEight(self));
        }
        let [own, re, im] = self.sums;
        let rows = self.spectra.chunks_exact(self.width).zip(self.reference);
        for (((row, y), own), (re, im)) in rows.zip(own).zip(re.iter_mut().zip(im)) {
            let cells = own.0.iter_mut().zip(re.0.iter_mut().zip(&mut im.0));
            for ((x, has), (own, (re, im))) in row.iter().zip(self.has).zip(cells) {
                let product = y * x;
                *own += has * (x.norm_sqr() * self.squared);
                *re += has * product.re;
                *im += has * product.im;
            }
        }
    }
}

/// The same of eight sites, with the same bits.
struct OfEight<'a>(Products<'a>);

impl SimdKernel for OfEight<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Products {
            spectra,
            reference,
            squared,
            has,
            sums: [own, re, im],
            ..
        } = self.0;
        let (rows, _) = spectra.as_chunks::<TOGETHER>();
        let (squared, has) = (L::splat(squared), L::read(has));
        let rows = rows.iter().zip(reference);
        for (((row, y), own), (re, im)) in rows.zip(own).zip(re.iter_mut().zip(im)) {
            let [x_re, x_im] = L::parts(row);
            let (y_re, y_im) = (L::splat(y.re), L::splat(y.im));
            let add = |sum: &mut LaneBlock, value: L| (L::load(sum) + value).store(sum);
            add(own, has * ((x_re * x_re + x_im * x_im) * squared));
            add(re, has * (y_re * x_re - y_im * x_im));
            add(im, has * (y_re * x_im + y_im * x_re));
        }
    }
}
