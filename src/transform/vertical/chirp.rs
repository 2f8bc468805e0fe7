//! Any length, by a convolution (Bluestein's algorithm).
//!
//! With `c_n = exp(-i pi n^2 / N)` and `n m = (n^2 + m^2 - (m - n)^2) / 2`,
//!
//! `X_m = c_m sum_n (v_n c_n) conj(c_{m-n})`, `m = 0 ..= N / 2`,
//!
//! a convolution that a cyclic one of `M >= N + N / 2` points holds, for which M is free: it has
//! small prime factors. `M = m1 m2` is transformed in halves as in [`super`]; the numbers need no
//! order in between, so each row of the second half is transformed, multiplied by the transform of
//! `conj(c)`, and transformed back while it is in the first cache. Transforms back are forward
//! ones of conjugates.
//!
//! Source: L. Bluestein, IEEE Trans. Audio Electroacoust. 18, 451 (1970).

use num_complex::Complex;
use rustfft::FftPlanner;

use super::fast::{Half, index};
use super::kernels::{InstructionSet, Kernelled, Kernels};
use super::passes::Turn;
use crate::transform::Real;
use crate::turns::cos_sin_exact;

/// As in [`super::fast`].
const PADDING: usize = 2;

/// A planned transform of one length.
pub struct Chirp<T: 'static> {
    length: usize,
    first: Half<T>,
    second: Half<T>,
    first_digits: Vec<u32>,
    second_digits: Vec<u32>,
    /// `c_n`, and for the result `conj(c_m)`.
    chirp: Vec<T>,
    chirp_back: Vec<T>,
    /// `exp(-2 pi i k1 j2 / M)`, row by row of k1.
    twiddles: Vec<T>,
    /// Transform of `conj(c)` over M, in rows of k1.
    response: Vec<T>,
    kernels: Vec<&'static Kernels<T>>,
}

impl<T: Real> Chirp<T> {
    /// `first` and `second` multiply to M.
    pub fn new(
        set: InstructionSet,
        length: usize,
        (first, second): (Vec<usize>, Vec<usize>),
    ) -> Self {
        let (first, second) = (Half::<T>::new(first), Half::<T>::new(second));
        let (m1, m2) = (first.length, second.length);
        let points = m1 * m2;
        let c = |n: usize| {
            // The phase is reduced in integers wide enough for any length.
            let phase = (n as u128 * n as u128 % (2 * length as u128)) as u64;
            cos_sin_exact(phase, 2 * length as u64)
        };
        let pairs = |of: &mut dyn Iterator<Item = (f64, f64)>| -> Vec<T> {
            of.flat_map(|(re, im)| [T::rounded(re), T::rounded(im)])
                .collect()
        };
        let bins = length / 2 + 1;
        let mut kernel = vec![Complex::new(0.0, 0.0); points];
        for n in 0..length {
            let (cos, sin) = c(n);
            let value = Complex::new(cos, sin) / points as f64;
            if n < bins {
                kernel[n] = value;
            }
            if n > 0 {
                kernel[points - n] = value;
            }
        }
        FftPlanner::new()
            .plan_fft_forward(points)
            .process(&mut kernel);
        let response = (0..m1).flat_map(|k1| (0..m2).map(move |k2| k1 + m1 * k2));
        let twiddles = (0..m1).flat_map(|k1| (0..m2).map(move |j2| k1 * j2));
        Chirp {
            length,
            chirp: pairs(&mut (0..length).map(c).map(|(cos, sin)| (cos, -sin))),
            chirp_back: pairs(&mut (0..bins).map(c)),
            twiddles: pairs(&mut twiddles.map(|turn| {
                let (cos, sin) = cos_sin_exact(turn as u64, points as u64);
                (cos, -sin)
            })),
            response: pairs(&mut response.map(|k| (kernel[k].re, kernel[k].im))),
            first_digits: first.digits(),
            second_digits: second.digits(),
            first,
            second,
            kernels: <T as Kernelled>::kernels(set).iter().map(|k| k.0).collect(),
        }
    }

    pub fn kernels(&self) -> &[&'static Kernels<T>] {
        &self.kernels
    }

    /// Points M of the convolution.
    pub fn points(&self) -> usize {
        self.first.length * self.second.length
    }

    fn work(&self) -> usize {
        self.first.length.max(self.second.length)
    }

    fn row(&self) -> usize {
        self.second.length + PADDING
    }

    /// Numbers of scratch for tiles of `width` columns.
    pub fn scratch_len(&self, width: usize) -> usize {
        2 * width * (2 * self.work() + self.first.length * self.row())
    }

    /// Transforms one tile of `kernels.width` columns.
    ///
    /// # Safety
    /// As [`super::fast::Fast::tiles`]; `to` needs no alignment.
    pub unsafe fn tile(
        &self,
        kernels: &Kernels<T>,
        (from, from_stride): (*const T, usize),
        (to, to_stride): (*mut T, usize),
        scratch: &mut [T],
    ) {
        assert!(scratch.len() >= self.scratch_len(kernels.width));
        let (m1, m2) = (self.first.length, self.second.length);
        let complex = 2 * kernels.width;
        let bins = self.length / 2 + 1;
        // Of all points j1 m2 + j2 of one j2, those below a limit.
        let below = |limit: usize, j: usize| limit.saturating_sub(j).div_ceil(m2);
        let work = scratch.as_mut_ptr();
        // SAFETY: all places are within what the caller promises and `scratch_len` counts; the
        // kernels are those of this processor.
        unsafe {
            let other = work.add(complex * self.work());
            let between = other.add(complex * self.work());
            let row = complex * self.row();
            let first_turn = &kernels.turn[index(self.first.last())];
            for j in 0..m2 {
                let valid = below(self.length, j);
                let rows = from.wrapping_add(j * from_stride);
                let chirp = self.chirp.as_ptr().wrapping_add(2 * j);
                (kernels.chirp)(rows, m2 * from_stride, chirp, m2, valid, m1, work);
                let source = self.first.all_but_last(kernels, work, work);
                first_turn(&Turn {
                    from: source,
                    groups: m1 / self.first.last(),
                    digits: self.first_digits.as_ptr(),
                    to: between.add(complex * j),
                    next: row,
                    factors: self.twiddles.as_ptr().add(2 * j),
                    factors_apart: m2,
                    end: m1,
                });
            }
            let radix = self.second.last();
            for k in 0..m1 {
                let numbers = between.add(row * k);
                let source = self.second.all_but_last(kernels, numbers, work);
                let mut turn = Turn {
                    from: source,
                    groups: m2 / radix,
                    digits: self.second_digits.as_ptr(),
                    to: other,
                    next: complex,
                    factors: self.response.as_ptr().add(2 * k * m2),
                    factors_apart: 1,
                    end: m2,
                };
                kernels.turn_mirrored[index(radix)](&turn);
                turn.from = self.second.all_but_last(kernels, other, work);
                turn.to = numbers;
                turn.factors = self.twiddles.as_ptr().add(2 * k * m2);
                kernels.turn[index(radix)](&turn);
            }
            let last_turn = &kernels.turn_pairs[index(self.first.last())];
            for j in 0..m2.min(bins) {
                (kernels.collect)(between.add(complex * j), row, m1, work);
                let source = self.first.all_but_last(kernels, work, work);
                last_turn(&Turn {
                    from: source,
                    groups: m1 / self.first.last(),
                    digits: self.first_digits.as_ptr(),
                    to: to.add(j * to_stride),
                    next: m2 * to_stride,
                    factors: self.chirp_back.as_ptr().add(2 * j),
                    factors_apart: m2,
                    end: below(bins, j),
                });
            }
            for real in [Some(0), self.length.is_multiple_of(2).then_some(bins - 1)] {
                let Some(bin) = real else { continue };
                let bin = to.add(bin * to_stride);
                for column in 0..kernels.width {
                    *bin.add(2 * column + 1) = T::zero();
                }
            }
        }
    }
}
