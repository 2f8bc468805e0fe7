//! Any length, by a convolution (Bluestein's algorithm).
//!
//! With `c_n = exp(-i pi n^2 / N)` and `n m = (n^2 + m^2 - (m - n)^2) / 2`,
//!
//! `X_m = c_m sum_n (v_n c_n) conj(c_{m-n})`, `m = 0 ..= N / 2`,
//!
//! a convolution that a cyclic one of `M >= N + N / 2` points holds, for which M is free: it has
//! small prime factors. Each row of the second half is transformed, multiplied by the transform of
//! `conj(c)`, and transformed back while it is in L1.
//!
//! Source: L. Bluestein, IEEE Trans. Audio Electroacoust. 18, 451 (1970).

use num_complex::Complex;

use super::algorithm::Halves;
use super::cyclic::Cyclic;
use super::kernels::{InstructionSet, Kernels};
use super::mixed_radix::{RowOrder, Tile, index};
use super::passes::Twiddled;
use crate::Real;
use crate::twiddle::cos_sin_exact;

/// A planned transform of one length.
pub struct Bluestein<T: 'static> {
    length: usize,
    cyclic: Cyclic<T>,
    /// `c_n`, and for the result `conj(c_m)`.
    chirp: Vec<T>,
    chirp_back: Vec<T>,
    /// Transform of `conj(c)` over M, in rows of k1.
    response: Vec<T>,
}

impl<T: Real> Bluestein<T> {
    /// The radices of `halves` multiply to M.
    pub fn new(set: InstructionSet, length: usize, halves: Halves) -> Self {
        let cyclic = Cyclic::<T>::new(halves.clone());
        let points = cyclic.points();
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
        let response = Cyclic::<f64>::new(halves).response(set, &kernel);
        Bluestein {
            length,
            chirp: pairs(&mut (0..length).map(c).map(|(cos, sin)| (cos, -sin))),
            chirp_back: pairs(&mut (0..bins).map(c)),
            response: pairs(&mut response.iter().map(|bin| (bin.re, bin.im))),
            cyclic,
        }
    }

    /// Transforms one tile of `kernels.width` columns.
    ///
    /// # Safety
    /// As [`super::mixed_radix::MixedRadix::tile`], for plain rows; stores are not streaming.
    pub unsafe fn tile(&self, kernels: &Kernels<T>, tile: Tile<T>, scratch: &mut [T]) {
        let cyclic = &self.cyclic;
        let (m1, m2) = (cyclic.first.length, cyclic.second.length);
        let bins = self.length / 2 + 1;
        assert!(matches!(tile.rows, RowOrder::Plain));
        let parts = cyclic.split(kernels.width, scratch);
        // SAFETY: all places are within what the caller promises and `parts` has checked; the
        // kernels are those of this processor.
        unsafe {
            for j in 0..m2 {
                let valid = cyclic.below(self.length, j);
                let rows = tile.from.wrapping_add(j * tile.from_stride);
                let chirp = self.chirp.as_ptr().wrapping_add(2 * j);
                (kernels.chirp)(
                    rows,
                    m2 * tile.from_stride,
                    chirp,
                    m2,
                    valid,
                    m1,
                    parts.work,
                );
                cyclic.column(kernels, &parts, j);
            }
            let other = parts.other;
            for k in 0..m1 {
                let numbers = cyclic.numbers(kernels.width, &parts, k);
                let response = self.response.as_ptr().add(2 * k * m2);
                let pass = cyclic.bins(kernels, &parts, numbers, (response, other));
                kernels.twiddle_conjugated[index(cyclic.second.last())](&pass);
                cyclic.row_back(kernels, &parts, other, k);
            }
            let last_pass = &kernels.twiddle_interleaved[index(cyclic.first.last())];
            for j in 0..m2.min(bins) {
                last_pass(&Twiddled {
                    of: cyclic.column_back(kernels, &parts, j),
                    to: tile.to.add(j * tile.to_stride),
                    next: m2 * tile.to_stride,
                    factors: self.chirp_back.as_ptr().add(2 * j),
                    factors_apart: m2,
                    end: cyclic.below(bins, j),
                });
            }
            for real in [Some(0), self.length.is_multiple_of(2).then_some(bins - 1)] {
                let Some(bin) = real else { continue };
                let bin = tile.to.add(bin * tile.to_stride);
                for column in 0..kernels.width {
                    *bin.add(2 * column + 1) = T::zero();
                }
            }
        }
    }
}
