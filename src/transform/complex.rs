//! Complex profiles to their spectrum over wavenumbers of both signs.

use ndarray::ArrayView2;
use num_complex::Complex;

use super::records::{RecordScratch, RecordTransform, interleave};
use super::{Real, power};
use crate::numeric::lanes::{Lanes, SimdKernel, widest};

/// `|X_m|^2` of `X_m = sum_j w_j u_j exp(+2 pi i m j / N)` of complex profiles u, `m` ascending
/// from `-(N / 2)`, so that positive m travels towards +x.
///
/// The real and the imaginary part pass through a real transform, which gives A and B:
/// `X_(-m) = A_m + i B_m` and, for real parts, `X_m = A_m^* + i B_m^*`.
#[derive(Debug)]
pub struct ComplexTransform<T: Real> {
    parts: RecordTransform<T>,
}

/// Working space of one thread; grows once.
#[derive(Debug, Clone, Default)]
pub struct ComplexScratch<T> {
    /// Real and imaginary parts, interleaved.
    parts: Vec<f64>,
    records: RecordScratch<T>,
    powers: Vec<f64>,
}

impl<T: Real> ComplexTransform<T> {
    /// Profiles that pass through the transform together, at best.
    pub const TOGETHER: usize = 4;

    /// Plans transforms of `window.len()` samples padded to `padded`.
    ///
    /// # Panics
    /// If there are no samples or `padded` is shorter than the window.
    pub fn new(window: &[f64], padded: usize) -> Self {
        ComplexTransform {
            parts: RecordTransform::new(window, padded),
        }
    }

    /// Bytes that the working space of a thread grows to at most, for profiles of `samples` padded
    /// to `padded`.
    pub(crate) fn working_bytes(samples: usize, padded: usize) -> u64 {
        let parts = RecordTransform::<T>::working_bytes(samples, padded, 2 * Self::TOGETHER);
        (8 * Self::TOGETHER * (2 * samples + padded)) as u64 + parts
    }

    /// Length N of the transform.
    pub fn padded(&self) -> usize {
        self.parts.padded()
    }

    /// `|X_m|^2` of each of `profiles`, `(profile, site)`, one after the other, ascending in m.
    ///
    /// # Panics
    /// If profiles are not as long as the window, or not contiguous.
    pub fn powers<'s>(
        &self,
        profiles: ArrayView2<Complex<T>>,
        scratch: &'s mut ComplexScratch<T>,
    ) -> &'s [f64] {
        let (count, length) = (profiles.nrows(), self.padded());
        scratch.parts.resize(2 * count * profiles.ncols(), 0.0);
        scratch.powers.resize(count * length, 0.0);
        let rows = profiles.outer_iter();
        let rows = rows.map(|row| row.to_slice().expect("contiguous profiles"));
        let (parts, _) = scratch.parts.as_chunks_mut::<2>();
        interleave(&rows.collect::<Vec<_>>(), parts, |u| {
            [u.re.to_f64(), u.im.to_f64()]
        });
        let (parts, records) = (&scratch.parts, &mut scratch.records);
        let spectra = self.parts.spectra_of_rows(parts, 2 * count, records);
        widest(PairPowers {
            spectra,
            count,
            length,
            powers: &mut scratch.powers,
        });
        &scratch.powers
    }
}

/// From the transforms of real and imaginary parts, interleaved bin by bin.
struct PairPowers<'a, T> {
    spectra: &'a [Complex<T>],
    count: usize,
    length: usize,
    powers: &'a mut [f64],
}

impl<T: Real> SimdKernel for PairPowers<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let zero = self.length / 2;
        let (pairs, _) = self.spectra.as_chunks::<2>();
        for (p, powers) in self.powers.chunks_exact_mut(self.length).enumerate() {
            let (below, above) = powers.split_at_mut(zero);
            for (m, [a, b]) in pairs[p..].iter().step_by(self.count).enumerate() {
                let (a, b) = (wide(*a), wide(*b));
                if let Some(above) = above.get_mut(m) {
                    *above = power(Complex::new(a.re + b.im, b.re - a.im));
                }
                if m > 0 {
                    below[zero - m] = power(Complex::new(a.re - b.im, a.im + b.re));
                }
            }
        }
    }
}

#[inline(always)]
fn wide<T: Real>(x: Complex<T>) -> Complex<f64> {
    Complex::new(x.re.to_f64(), x.im.to_f64())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transform::direct_sums;
    use ndarray::Array2;

    /// Even and odd lengths, tapered and padded, with an offset in one part; against direct sums of
    /// the parts; and the same bits however many go together.
    #[test]
    fn val_direct_sums_at_both_signs() {
        let tapered = [(12, 12), (15, 15), (20, 27), (1, 1), (300, 300), (11, 22)];
        let plain = [2, 3, 7, 8, 251, 253, 300].map(|n| (n, n));
        let tapered = tapered.map(|n| (n, 0.5)).into_iter();
        for ((sites, padded), depth) in tapered.chain(plain.map(|n| (n, 0.0))) {
            let window: Vec<f64> = (0..sites).map(|j| 1.0 - depth * (j as f64).sin()).collect();
            let plan = ComplexTransform::<f64>::new(&window, padded);
            let profiles = Array2::from_shape_fn((9, sites), |(p, j)| {
                let phase = (p * 7 + j * j) as f64;
                Complex::new(phase.sin(), 30.0 * (p % 2) as f64 + phase.cos())
            });
            let mut scratch = ComplexScratch::default();
            let all = plan.powers(profiles.view(), &mut scratch).to_vec();
            for together in [1, 3, ComplexTransform::<f64>::TOGETHER] {
                let groups = profiles.axis_chunks_iter(ndarray::Axis(0), together);
                let found = groups.flat_map(|group| plan.powers(group, &mut scratch).to_vec());
                assert_eq!(found.collect::<Vec<_>>(), all, "{sites} {together}");
            }
            let bins: Vec<usize> = (0..padded).collect();
            for (profile, found) in profiles.outer_iter().zip(all.chunks_exact(padded)) {
                let tapered = profile.iter().zip(&window).map(|(u, w)| u * w);
                let (mut re, mut im): (Vec<f64>, Vec<f64>) = tapered.map(|u| (u.re, u.im)).unzip();
                re.resize(padded, 0.0);
                im.resize(padded, 0.0);
                let [re, im] = [re, im].map(|part| direct_sums(&part, &bins));
                let largest = found.iter().fold(0.0, |m: f64, p| m.max(*p));
                for (i, power) in found.iter().enumerate() {
                    // exp(+) at m is exp(-) at -m.
                    let m = (padded + padded / 2 - i) % padded;
                    let right = (re[m] + Complex::<f64>::i() * im[m]).norm_sqr();
                    let error = (power - right).abs() / (largest * right).sqrt().max(1e-30);
                    assert!(error < 2e-14, "{sites} {padded} {i}: {error:e}");
                }
            }
        }
    }
}
