//! Prime lengths, by a convolution (Rader's algorithm, folded for real columns).
//!
//! For a prime N let g be a primitive root, `h = (N - 1) / 2` and `g^h = -1`. All n but 0 are
//! powers of g, and with `n = g^q`, `m = g^-p` the product n m is `g^(q-p)`. Rows n and N - n have
//! the same cosine and opposite sines, so that sums and differences of them suffice:
//!
//! `X_m = v_0 + sum_q u_q cos(2 pi g^(q-p) / N) - i sum_q w_q sin(2 pi g^(q-p) / N)`,
//! `u_q = v_n + v_{N-n}`, `w_q = v_n - v_{N-n}`, `p, q = 0 .. h`,
//!
//! where m is a bin or, beyond N / 2, the mirror of one. These are two real convolutions of h
//! points. They go through one complex transform of `M >= 2 h - 1 = N - 2` points as `z = u + i w`,
//! of which bin k becomes `P_k z_k + Q_k conj(z_-k)`: half the sum and half the difference of
//! what cosines and sines transform to are P and Q. Bluestein's algorithm needs half as many points
//! again. Bin 0 is `v_0 + Re z_0`.
//!
//! Rows k1 and m1 - k1 of the second half hold mirrored bins, so they go through it as a pair.
//!
//! Source: C. M. Rader, Proc. IEEE 56, 1107 (1968).

use num_complex::Complex;

use super::algorithm::{self, Halves};
use super::cyclic::{Cyclic, Scratch};
use super::kernels::{InstructionSet, Kernels};
use super::mixed_radix::{RowOrder, Store, Tile, index};
use super::passes::{Blend, Fold, Scatter};
use crate::Real;
use crate::twiddle::cos_sin_exact;

/// A planned transform of one prime length.
pub struct Rader<T: 'static> {
    length: usize,
    cyclic: Cyclic<T>,
    /// `g^q`, in the order of use: by columns j2 of `q = j1 m2 + j2`.
    sources: Vec<u32>,
    /// Of each p in the same order twice its bin, and 1 more where it is the bin's mirror.
    bins: Vec<u32>,
    /// Where column j2 starts in both.
    starts: Vec<usize>,
    /// P and Q, in rows of k1 up to m1 / 2.
    responses: Vec<T>,
}

impl<T: Real> Rader<T> {
    /// For a prime `length` from 5 on; the radices of `halves` multiply to M.
    pub fn new(set: InstructionSet, length: usize, halves: Halves) -> Self {
        assert!(algorithm::is_odd_prime(length));
        let cyclic = Cyclic::<T>::new(halves.clone());
        let (m1, m2) = (cyclic.first.length, cyclic.second.length);
        let points = cyclic.points();
        let half = (length - 1) / 2;
        let root = primitive_root(length as u64);
        // g^q for q = 0 .. N - 1; g^-p is that of N - 1 - p.
        let mut powers = vec![1_u64; length];
        for q in 1..length {
            powers[q] = powers[q - 1] * root % length as u64;
        }
        let by_column = |of: &dyn Fn(usize) -> u32| -> Vec<u32> {
            let columns = (0..m2).flat_map(|j| (j..half).step_by(m2));
            columns.map(of).collect()
        };
        let bin = |p: usize| {
            let m = powers[length - 1 - p] as usize;
            match m > half {
                true => 2 * (length - m) as u32 + 1,
                false => 2 * m as u32,
            }
        };
        // Over d = p - q, the cosine as real and the sine as imaginary part: their transforms are
        // the even and the odd part of the sum's.
        let mut kernel = vec![Complex::new(0.0, 0.0); points];
        for d in 0..half {
            let at = |power: u64| {
                let (cos, sin) = cos_sin_exact(power, length as u64);
                Complex::new(cos, sin) / points as f64
            };
            kernel[d] = at(powers[length - 1 - d]);
            if d > 0 {
                kernel[points - d] = at(powers[d]);
            }
        }
        let response = Cyclic::<f64>::new(halves).response(set, &kernel);
        let bin_at = |k: usize| response[k % m1 * m2 + k / m1];
        let mut responses = Vec::new();
        for k1 in 0..=m1 / 2 {
            for k2 in 0..m2 {
                let k = k1 + m1 * k2;
                let (z, mirror) = (bin_at(k), bin_at((points - k) % points).conj());
                let cosines = (z + mirror) / 2.0;
                let sines = (z - mirror) / Complex::new(0.0, 2.0);
                for factor in [(cosines + sines) / 2.0, (cosines - sines) / 2.0] {
                    responses.extend([T::rounded(factor.re), T::rounded(factor.im)]);
                }
            }
        }
        let mut starts = vec![0];
        for j in 0..m2 {
            starts.push(starts[j] + cyclic.below(half, j));
        }
        Rader {
            length,
            sources: by_column(&|q| powers[q] as u32),
            bins: by_column(&bin),
            starts,
            responses,
            cyclic,
        }
    }

    /// Transforms one tile of `kernels.width` columns.
    ///
    /// # Safety
    /// As [`super::mixed_radix::MixedRadix::tile`], for plain rows.
    pub unsafe fn tile(&self, kernels: &Kernels<T>, tile: Tile<T>, scratch: &mut [T]) {
        let cyclic = &self.cyclic;
        let m1 = cyclic.first.length;
        let width = kernels.width;
        assert!(matches!(tile.rows, RowOrder::Plain));
        let parts = cyclic.split(width, scratch);
        let radix = index(cyclic.first.last());
        let scatter = match tile.store {
            Store::Streaming => kernels.scatter_streaming[radix],
            _ => kernels.scatter[radix],
        };
        // SAFETY: all places are within what the caller promises and `parts` has checked; the
        // kernels are those of this processor.
        unsafe {
            for (j, start) in self.starts.windows(2).enumerate() {
                (kernels.fold)(&Fold {
                    from: tile.from,
                    stride: tile.from_stride,
                    length: self.length,
                    rows: self.sources.as_ptr().add(start[0]),
                    wanted: start[1] - start[0],
                    count: m1,
                    to: parts.work,
                });
                cyclic.column(kernels, &parts, j);
            }
            for k1 in 0..=m1 / 2 {
                self.pair_of_rows(kernels, &parts, k1, tile);
            }
            for (j, start) in self.starts.windows(2).enumerate() {
                if start[0] == start[1] {
                    break;
                }
                scatter(&Scatter {
                    of: cyclic.column_back(kernels, &parts, j),
                    to: tile.to,
                    stride: tile.to_stride,
                    rows: self.bins.as_ptr().add(start[0]),
                    end: start[1] - start[0],
                    constant: tile.from,
                });
            }
        }
    }

    /// Rows k1 and m1 - k1 of the second half: there, multiplied, and back. Of row 0 also bin 0 of the
    /// result.
    ///
    /// # Safety
    /// As [`Rader::tile`].
    unsafe fn pair_of_rows(
        &self,
        kernels: &Kernels<T>,
        parts: &Scratch<T>,
        k1: usize,
        tile: Tile<T>,
    ) {
        let cyclic = &self.cyclic;
        let (m1, m2) = (cyclic.first.length, cyclic.second.length);
        let complex = 2 * kernels.width;
        let mirror = (m1 - k1) % m1;
        let order = kernels.order[index(cyclic.second.last())];
        let [mut bins, mut mirrors] = parts.others;
        let rows = [(k1, bins), (mirror, mirrors)];
        let rows = if mirror == k1 { &rows[..1] } else { &rows };
        // SAFETY: as promised.
        unsafe {
            for &(k1, to) in rows {
                let numbers = cyclic.numbers(kernels.width, parts, k1);
                order(&cyclic.bins(kernels, parts, numbers, (numbers, to)));
            }
            let mut factors = self.responses.as_ptr().add(4 * k1 * m2);
            let mut blend = |bins: *mut T, mirrors: *mut T, count: usize| {
                (kernels.blend)(&Blend {
                    bins,
                    mirrors,
                    count,
                    factors,
                });
                factors = factors.add(4 * count);
            };
            if k1 == 0 {
                for column in 0..kernels.width {
                    *tile.to.add(2 * column) = *tile.from.add(column) + *bins.add(column);
                    *tile.to.add(2 * column + 1) = T::zero();
                }
                // Bin 0 is its own mirror, the others lie about the middle.
                blend(bins, bins, 1);
                bins = bins.add(complex);
                mirrors = bins.add(complex * (m2 - 2));
                blend(bins, mirrors, m2 / 2);
            } else if mirror == k1 {
                blend(bins, bins.add(complex * (m2 - 1)), m2.div_ceil(2));
            } else {
                blend(bins, mirrors.add(complex * (m2 - 1)), m2);
            }
            for &(k1, bins) in rows {
                cyclic.row_back(kernels, parts, bins, k1);
            }
        }
    }
}

/// The least number whose powers are all numbers from 1 to `prime - 1`, for a prime below 2^32.
fn primitive_root(prime: u64) -> u64 {
    let mut rest = prime - 1;
    let mut factors = Vec::new();
    let mut factor = 2;
    while factor * factor <= rest {
        if rest.is_multiple_of(factor) {
            factors.push(factor);
        }
        while rest.is_multiple_of(factor) {
            rest /= factor;
        }
        factor += 1;
    }
    // What is left is 1 or a prime.
    if rest > 1 {
        factors.push(rest);
    }
    let power = |base: u64, mut exponent: u64| {
        let (mut result, mut square) = (1, base % prime);
        while exponent > 0 {
            if exponent % 2 == 1 {
                result = result * square % prime;
            }
            square = square * square % prime;
            exponent /= 2;
        }
        result
    };
    let generates = |&g: &u64| factors.iter().all(|f| power(g, (prime - 1) / f) != 1);
    (1..prime).find(generates).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_roots_are_all_numbers() {
        for prime in [3, 5, 7, 11, 41, 191, 257, 409, 1009, 5881, 10007] {
            let root = primitive_root(prime);
            let mut seen = vec![false; prime as usize];
            let mut power = 1;
            for _ in 1..prime {
                seen[power as usize] = true;
                power = power * root % prime;
            }
            assert!(seen[1..].iter().all(|&seen| seen), "{prime}: {root}");
        }
    }
}
