//! Complex profiles to their spectrum over wavenumbers of both signs.

use ndarray::{ArrayView2, ArrayViewMut2};
use num_complex::Complex;

use super::Real;
use super::records::{RecordScratch, RecordTransform};
use crate::numeric::lanes::{Lanes, SimdKernel, widest};
use crate::system::prefetch::{LINE, prefetch_after};

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
    spectra: Vec<Complex<T>>,
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
        let spectra = 2 * (padded / 2 + 1) * 2 * size_of::<T>();
        (Self::TOGETHER * (8 * 2 * samples + spectra + 8 * padded)) as u64 + parts
    }

    /// Length N of the transform.
    pub fn padded(&self) -> usize {
        self.parts.padded()
    }

    /// `|X_m|^2` of each of `profiles`, `(profile, site)`, one after the other, ascending in m.
    ///
    /// # Panics
    /// If profiles are not as long as the window.
    pub fn powers<'s>(
        &self,
        profiles: ArrayView2<Complex<T>>,
        scratch: &'s mut ComplexScratch<T>,
    ) -> &'s [f64] {
        let (count, length, bins) = (profiles.nrows(), self.padded(), self.parts.bins());
        scratch.parts.resize(2 * count * profiles.ncols(), 0.0);
        let spectra = &mut scratch.spectra;
        spectra.resize(2 * count * bins, Complex::default());
        scratch.powers.resize(count * length, 0.0);
        side_by_side(profiles, &mut scratch.parts);
        // The shape is the buffer's own, so this cannot fail.
        if let Ok(output) = ArrayViewMut2::from_shape((bins, 2 * count), &mut *spectra) {
            self.parts
                .transform_columns(&scratch.parts, output, &mut scratch.records);
        }
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
                if let Some(power) = above.get_mut(m) {
                    *power = square(a.re + b.im, b.re - a.im);
                }
                if m > 0 {
                    below[zero - m] = square(a.re - b.im, a.im + b.re);
                }
            }
        }
    }
}

#[inline(always)]
fn square(re: f64, im: f64) -> f64 {
    re * re + im * im
}

/// Real and imaginary parts of profiles, site by site.
fn side_by_side<T: Real>(profiles: ArrayView2<Complex<T>>, parts: &mut [f64]) {
    let profile = |p| profiles.row(p).to_slice();
    if profiles.nrows() == 4
        && let [Some(a), Some(b), Some(c), Some(d)] = [0, 1, 2, 3].map(profile)
    {
        let (rows, _) = parts.as_chunks_mut();
        let further = profiles.len();
        let profiles = a.iter().zip(b).zip(c).zip(d);
        for (j, (row, (((a, b), c), d))) in rows.iter_mut().zip(profiles).enumerate() {
            if j.is_multiple_of(LINE / size_of::<Complex<T>>()) {
                // The next four mostly follow these.
                for u in [a, b, c, d] {
                    prefetch_after(u, further);
                }
            }
            let [a, b, c, d] = [a, b, c, d].map(|u| wide(*u));
            *row = [a.re, a.im, b.re, b.im, c.re, c.im, d.re, d.im];
        }
        return;
    }
    let count = profiles.nrows();
    for (p, profile) in profiles.outer_iter().enumerate() {
        for (row, &u) in parts.chunks_exact_mut(2 * count).zip(profile) {
            (row[2 * p], row[2 * p + 1]) = (u.re.to_f64(), u.im.to_f64());
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
        let tapered =
            [(12, 12), (15, 15), (20, 27), (1, 1), (300, 300), (11, 22)].map(|n| (n, 0.5));
        let plain = [
            (2, 2),
            (3, 3),
            (7, 7),
            (8, 8),
            (251, 251),
            (253, 253),
            (300, 300),
        ];
        for ((sites, padded), depth) in tapered.into_iter().chain(plain.map(|n| (n, 0.0))) {
            let window: Vec<f64> = (0..sites).map(|j| 1.0 - depth * (j as f64).sin()).collect();
            let plan = ComplexTransform::<f64>::new(&window, padded);
            let profiles = Array2::from_shape_fn((9, sites), |(p, j)| {
                let phase = (p * 7 + j * j) as f64;
                Complex::new(phase.sin(), 30.0 * (p % 2) as f64 + phase.cos())
            });
            let mut scratch = ComplexScratch::default();
            let all = plan.powers(profiles.view(), &mut scratch).to_vec();
            for together in [1, 3, ComplexTransform::<f64>::TOGETHER] {
                let found: Vec<f64> = profiles
                    .axis_chunks_iter(ndarray::Axis(0), together)
                    .flat_map(|profiles| plan.powers(profiles, &mut scratch).to_vec())
                    .collect();
                assert_eq!(found, all, "{sites} {together}");
            }
            for (profile, found) in profiles.outer_iter().zip(all.chunks_exact(padded)) {
                let part = |of: fn(&Complex<f64>) -> f64| -> Vec<Complex<f64>> {
                    let mut x: Vec<f64> = profile
                        .iter()
                        .zip(&window)
                        .map(|(u, w)| of(u) * w)
                        .collect();
                    x.resize(padded, 0.0);
                    let bins: Vec<usize> = (0..padded).collect();
                    direct_sums(&x, &bins)
                };
                let (re, im) = (part(|u| u.re), part(|u| u.im));
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
