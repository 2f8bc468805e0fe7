//! Complex transforms of `M = m1 m2` points by the four-step algorithm, for convolutions: bins need no order.
//!
//! With `j = j1 m2 + j2` and `k = k1 + m1 k2`, as in [`super`]: the first half transforms each
//! series over j1 to a column of a matrix of m1 rows and m2 columns, the second half each row of it to
//! bins k. They are multiplied and transformed back, first rows, then columns.
//! Transforms back are forward ones of conjugates.

use num_complex::Complex;

use super::kernels::{InstructionSet, Kernels, kernels};
use super::mixed_radix::{Half, index};
use super::passes::{Twiddled, Unordered};
use crate::Real;
use crate::twiddle::cos_sin_exact;

/// As in [`super::mixed_radix`].
const PADDING: usize = 2;

/// From row to row of the matrix, in complex numbers.
#[inline]
fn row(second: usize) -> usize {
    second + PADDING
}

/// Numbers of scratch for tiles of `width` columns by halves of these lengths: two series or rows, and the
/// matrix.
#[inline]
pub fn scratch_len([first, second]: [usize; 2], width: usize) -> usize {
    2 * width * (2 * first.max(second) + first * row(second))
}

/// A planned transform there and back.
pub struct Cyclic<T: 'static> {
    pub first: Half<T>,
    pub second: Half<T>,
    first_digits: Vec<u32>,
    second_digits: Vec<u32>,
    /// `exp(-2 pi i k1 j2 / M)`, row by row of k1.
    twiddles: Vec<T>,
}

/// Parts of the scratch of one tile: two series or rows, and the intermediate matrix.
#[derive(Debug, Clone, Copy)]
pub struct Scratch<T> {
    pub work: *mut T,
    pub other: *mut T,
    pub intermediate: *mut T,
}

impl<T: Real> Cyclic<T> {
    /// Of halves of these radices.
    pub fn new((first, second): (Vec<usize>, Vec<usize>)) -> Self {
        let (first, second) = (Half::<T>::new(first), Half::<T>::new(second));
        let (m1, m2) = (first.length, second.length);
        let products = (0..m1).flat_map(|k1| (0..m2).map(move |j2| k1 * j2));
        Cyclic {
            twiddles: products
                .flat_map(|product| {
                    let (cos, sin) = cos_sin_exact(product as u64, (m1 * m2) as u64);
                    [T::rounded(cos), T::rounded(-sin)]
                })
                .collect(),
            first_digits: first.digits(),
            second_digits: second.digits(),
            first,
            second,
        }
    }

    /// Points M.
    pub fn points(&self) -> usize {
        self.first.length * self.second.length
    }

    /// Of all points `j1 m2 + j2` of one j2, how many lie below a limit.
    pub fn below(&self, limit: usize, j2: usize) -> usize {
        limit.saturating_sub(j2).div_ceil(self.second.length)
    }

    fn row(&self) -> usize {
        row(self.second.length)
    }

    fn scratch_len(&self, width: usize) -> usize {
        scratch_len([self.first.length, self.second.length], width)
    }

    /// The parts of a scratch, whose length is checked against [`scratch_len`].
    pub fn split(&self, width: usize, scratch: &mut [T]) -> Scratch<T> {
        assert!(scratch.len() >= self.scratch_len(width));
        let part = 2 * width * self.first.length.max(self.second.length);
        let work = scratch.as_mut_ptr();
        let at = |parts: usize| work.wrapping_add(parts * part);
        Scratch {
            work,
            other: at(1),
            intermediate: at(2),
        }
    }

    /// Row k1 of the matrix.
    pub fn numbers(&self, width: usize, parts: &Scratch<T>, k1: usize) -> *mut T {
        parts.intermediate.wrapping_add(2 * width * self.row() * k1)
    }

    /// The series over j1 in `parts.work`, transformed, to column j2 of the matrix.
    ///
    /// # Safety
    /// The kernels are those of this processor; `parts` is this plan's, for their width.
    pub unsafe fn column(&self, kernels: &Kernels<T>, parts: &Scratch<T>, j2: usize) {
        let (m1, m2) = (self.first.length, self.second.length);
        let radix = self.first.last();
        // SAFETY: as promised.
        unsafe {
            kernels.twiddle[index(radix)](&Twiddled {
                of: Unordered {
                    from: self.first.all_but_last(kernels, parts.work, parts.work),
                    groups: m1 / radix,
                    digits: self.first_digits.as_ptr(),
                },
                to: parts.intermediate.add(2 * kernels.width * j2),
                next: 2 * kernels.width * self.row(),
                factors: self.twiddles.as_ptr().add(2 * j2),
                factors_apart: m2,
                end: m1,
            });
        }
    }

    /// What the last pass of the second half takes to give the bins of row k1 in order, each times a
    /// factor from `factors` on, to `to`; all other passes are done.
    ///
    /// # Safety
    /// As [`Cyclic::column`].
    pub unsafe fn bins(
        &self,
        kernels: &Kernels<T>,
        parts: &Scratch<T>,
        numbers: *const T,
        (factors, to): (*const T, *mut T),
    ) -> Twiddled<T> {
        // SAFETY: as promised.
        let from = unsafe { self.second.all_but_last(kernels, numbers, parts.work) };
        Twiddled {
            of: Unordered {
                from,
                groups: self.second.length / self.second.last(),
                digits: self.second_digits.as_ptr(),
            },
            to,
            next: 2 * kernels.width,
            factors,
            factors_apart: 1,
            end: self.second.length,
        }
    }

    /// The conjugate bins of row k1 in `bins`, transformed back to row k1 of the matrix.
    ///
    /// # Safety
    /// As [`Cyclic::column`].
    pub unsafe fn row_back(
        &self,
        kernels: &Kernels<T>,
        parts: &Scratch<T>,
        bins: *const T,
        k1: usize,
    ) {
        let to = self.numbers(kernels.width, parts, k1);
        let twiddles = self.twiddles.as_ptr();
        // SAFETY: as promised.
        unsafe {
            let twiddles = twiddles.add(2 * k1 * self.second.length);
            let pass = self.bins(kernels, parts, bins, (twiddles, to));
            kernels.twiddle[index(self.second.last())](&pass);
        }
    }

    /// Column j2 of the matrix, transformed back but for the last pass; where its numbers are.
    ///
    /// # Safety
    /// As [`Cyclic::column`].
    pub unsafe fn column_back(
        &self,
        kernels: &Kernels<T>,
        parts: &Scratch<T>,
        j2: usize,
    ) -> Unordered<T> {
        let complex = 2 * kernels.width;
        let m1 = self.first.length;
        // SAFETY: as promised.
        unsafe {
            let from = parts.intermediate.add(complex * j2);
            (kernels.collect)(from, complex * self.row(), m1, parts.work);
            Unordered {
                from: self.first.all_but_last(kernels, parts.work, parts.work),
                groups: m1 / self.first.last(),
                digits: self.first_digits.as_ptr(),
            }
        }
    }
}

/// Rotated copies of a kernel that a response is the mean over.
const SHIFTS: usize = 4;

impl Cyclic<f64> {
    /// What a convolution multiplies by: the transform of `kernel`, row by row of k1, good to a fraction
    /// of what the transforms there and back round, so that it adds little to the error.
    ///
    /// It is the mean over transforms of cyclic shifts of the kernel, with the shifts undone. Their rounding
    /// errors are independent where the shifts have no pattern.
    pub fn response(&self, set: InstructionSet, kernel: &[Complex<f64>]) -> Vec<Complex<f64>> {
        const GOLDEN: f64 = 0.618_033_988_749_894_8;
        let (m1, m2, points) = (self.first.length, self.second.length, self.points());
        let shift = |s: usize| (s as f64 * GOLDEN * points as f64) as usize % points;
        let roots = (0..points as u64).map(|k| cos_sin_exact(k, points as u64));
        let roots: Vec<_> = roots.map(|(cos, sin)| Complex::new(cos, -sin)).collect();
        let all = kernels::<f64>(set);
        let found = all.iter().find(|kernels| kernels.width <= SHIFTS);
        let kernels = *found.unwrap_or(&all[all.len() - 1]);
        let width = kernels.width;
        let order = kernels.order[index(self.second.last())];
        let mut scratch = vec![0.0; self.scratch_len(width)];
        let parts = self.split(width, &mut scratch);
        let mut sum = vec![Complex::default(); points];
        // A column for each shift.
        for first in (0..SHIFTS).step_by(width) {
            for j2 in 0..m2 {
                for (i, n) in (j2..points).step_by(m2).enumerate() {
                    for column in 0..width {
                        let value = kernel[(n + shift(first + column)) % points];
                        let at = 2 * width * i + column;
                        // SAFETY: i is below m1, and the scratch holds as many complex numbers.
                        unsafe {
                            *parts.work.add(at) = value.re;
                            *parts.work.add(at + width) = value.im;
                        }
                    }
                }
                // SAFETY: the kernels are those of this processor, the scratch is theirs.
                unsafe { self.column(kernels, &parts, j2) };
            }
            let bins = parts.other;
            for k1 in 0..m1 {
                let numbers = self.numbers(width, &parts, k1);
                // SAFETY: as above; bins without factors.
                unsafe { order(&self.bins(kernels, &parts, numbers, (numbers, bins))) };
                for (k2, sum) in sum[k1 * m2..][..m2].iter_mut().enumerate() {
                    for column in 0..width {
                        let at = 2 * width * k2 + column;
                        // SAFETY: k2 is below m2.
                        let bin = unsafe { Complex::new(*bins.add(at), *bins.add(at + width)) };
                        let phase = (k1 + m1 * k2) as u64 * shift(first + column) as u64;
                        *sum += bin * roots[(phase % points as u64) as usize];
                    }
                }
            }
        }
        // A power of two: exact.
        sum.iter_mut().for_each(|bin| *bin /= SHIFTS as f64);
        sum
    }
}
