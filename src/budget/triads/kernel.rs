//! Sums over the pairs of partners of a wavenumber.

use std::f64::consts::TAU;

use ndarray::Array2;

use crate::transform::fold;

/// The components that take part.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    /// Places in a period.
    pub points: usize,
    /// Components 0 up to the largest wavenumber.
    pub components: usize,
}

/// Coefficients and rates at one sample.
#[derive(Debug, Clone, Default)]
pub(super) struct Components {
    /// Real and imaginary parts of the coefficients.
    pub value: [Vec<f64>; 2],
    /// Likewise of what the kernel has as their rates.
    pub rate: [Vec<f64>; 2],
    /// `b` and the number of places: what products are multiplied by.
    pub scale: f64,
    pub energy: Vec<f64>,
    /// From the transform of the product: the sum over all pairs.
    pub transfer: Vec<f64>,
    /// What terms beyond the quadratic one give.
    pub beyond: Vec<f64>,
}

impl Grid {
    /// Wavenumber of a component in rad a site.
    pub fn step(&self, k: usize) -> f64 {
        TAU * k as f64 / self.points as f64
    }

    /// The largest component, where k and -k are one.
    fn has_largest(&self, k: usize) -> bool {
        2 * k == self.points
    }
}

/// Adds `weight T(k | p, q)` to the column of the larger partner p, of sums and of differences.
pub(super) fn add_pairs(grid: &Grid, k: usize, at: &Components, weight: f64, row: &mut [f64]) {
    // The largest component has the sums of both signs.
    let sign = if k == 0 { 1.0 } else { 2.0 };
    let scale = weight * sign * at.scale / 3.0;
    let half = k.div_ceil(2);
    for (p, cell) in (half..).zip(&mut row[half..=k]) {
        let pair = at.pair(p, k - p, 1.0);
        // The largest component with the mean is the same for both signs.
        let is_own = 2 * p == k || (p == k && grid.has_largest(k));
        let orders = if is_own { 1.0 } else { 2.0 };
        *cell += orders * scale * at.transfer(k, pair);
    }
    for (p, cell) in (k + 1..).zip(&mut row[k + 1..]) {
        let pair = at.pair(p, p - k, -1.0);
        let is_own = k == 0 && grid.has_largest(p);
        let orders = if is_own { 1.0 } else { 2.0 };
        *cell += orders * scale * at.transfer(k, pair);
    }
}

/// The same of partners that add up to a full turn with k.
pub(super) fn add_wrapped(grid: &Grid, k: usize, at: &Components, weight: f64, row: &mut [f64]) {
    if grid.has_largest(k) {
        return;
    }
    let most = (grid.points - 1) / 2;
    let scale = weight * fold(k, grid.points) * at.scale / 3.0;
    let sum = grid.points - k;
    let half = sum.div_ceil(2);
    let end = most.min(sum - 1) + 1;
    for (p, cell) in (half..).zip(&mut row[half.min(end)..end]) {
        let q = sum - p;
        let ([re, im], [rate_re, rate_im]) = at.pair(p, q, 1.0);
        let orders = if p == q { 1.0 } else { 2.0 };
        // Both partners have negative wavenumbers.
        *cell += orders * scale * at.transfer(k, ([re, -im], [rate_re, -rate_im]));
    }
}

impl Components {
    /// `Re(conj(a_k) D - 2 conj(a_k') P)` of a product P and its rate D.
    #[inline]
    fn transfer(&self, k: usize, (product, rate): ([f64; 2], [f64; 2])) -> f64 {
        let dot = |[re, im]: &[Vec<f64>; 2], b: [f64; 2]| re[k] * b[0] + im[k] * b[1];
        dot(&self.value, rate) - 2.0 * dot(&self.rate, product)
    }

    /// The product `a_p a_q` and its rate; with `sign` -1 that of `a_p conj(a_q)`.
    #[inline]
    fn pair(&self, p: usize, q: usize, sign: f64) -> ([f64; 2], [f64; 2]) {
        let at = |[re, im]: &[Vec<f64>; 2], m: usize, sign: f64| [re[m], sign * im[m]];
        let (a, b) = (at(&self.value, p, 1.0), at(&self.value, q, sign));
        let (da, db) = (at(&self.rate, p, 1.0), at(&self.rate, q, sign));
        let times =
            |a: [f64; 2], b: [f64; 2]| [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
        let ([x, y], [z, w]) = (times(da, b), times(a, db));
        (times(a, b), [x + z, y + w])
    }
}

/// The largest sum of the three transfers of a triad.
pub(super) fn detailed(transfer: &Array2<f64>) -> f64 {
    let n = transfer.nrows();
    let mut worst = 0.0f64;
    for k in 0..n {
        for p in k.div_ceil(2)..=k {
            let q = k - p;
            let mut sum = transfer[[k, p]];
            if q == 0 {
                // k with itself and 0: the column of k is of both.
                sum += if k == 0 { -sum } else { transfer[[0, k]] };
            } else {
                sum += transfer[[p, k]];
                if q != p {
                    sum += transfer[[q, k]];
                }
            }
            worst = worst.max(sum.abs());
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Random;
    use num_complex::Complex;

    /// Against the defining sum over all pairs of a ring.
    #[test]
    fn val_defining_sums_over_a_ring() {
        for points in [7, 8, 12] {
            let n = points / 2 + 1;
            let grid = Grid {
                points,
                components: n,
            };
            let mut random = Random::new(points as u64);
            let mut rows = || {
                let mut rows = [0, 1].map(|_| (0..n).map(|_| random.normal()).collect());
                let [_, imaginary]: &mut [Vec<f64>; 2] = &mut rows;
                (0..n)
                    .filter(|k| 2 * k % points == 0)
                    .for_each(|k| imaginary[k] = 0.0);
                rows
            };
            let at = Components {
                value: rows(),
                rate: rows(),
                scale: 3.0,
                ..Components::default()
            };
            let ring = |[re, im]: &[Vec<f64>; 2], m: usize| match points - m {
                mirrored if mirrored < m => Complex::new(re[mirrored], -im[mirrored]),
                _ => Complex::new(re[m], im[m]),
            };
            let [mut found, mut expected] = [0, 1].map(|_| [0, 1].map(|_| vec![0.0; n * n]));
            for k in 0..n {
                let [pairs, wrapped] = &mut found;
                add_pairs(&grid, k, &at, 1.0, &mut pairs[k * n..][..n]);
                add_wrapped(&grid, k, &at, 1.0, &mut wrapped[k * n..][..n]);
            }
            for (k, p) in (0..points).flat_map(|k| (0..points).map(move |p| (k, p))) {
                let three = [k, p, (points + k - p) % points];
                let [[a, b, c], [da, db, dc]] =
                    [&at.value, &at.rate].map(|of| three.map(|m| ring(of, m)));
                let transfer = a.conj() * (db * c + b * dc) - 2.0 * da.conj() * b * c;
                let [k, p, q] = three.map(|m| m.min(points - m));
                let adds_up = k == p + q || p == k + q || q == k + p;
                expected[usize::from(!adds_up)][k * n + p.max(q)] += transfer.re;
            }
            for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
                assert!(
                    (found - expected).abs() < 1e-13,
                    "{points}: {found} {expected}"
                );
            }
        }
    }
}
