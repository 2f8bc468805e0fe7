//! How many realisations are independent: what tapers share in their places, and over neighbouring bins.

use std::f64::consts::TAU;

use ndarray::{Array1, Array2};
use num_complex::Complex;

use super::averaging::{Realisations, no_segment_left};
use super::ensemble::Independence;
use super::kept::{KeptSegments, SegmentPairs, SegmentsLeft};
use crate::error::Result;
use crate::transform::Segments;

impl Realisations {
    /// How many independent realisations of white noise have the variance of this average,
    ///
    /// ```text
    /// K = R^2 / sum_{r r'} |sum_n w_r(n) w_r'(n)|^2,
    /// ```
    ///
    /// with the tapers of all segments in their places. Source: Welch (1967), eq. 12, for one window;
    /// the same sum for several.
    pub fn effective(&self) -> f64 {
        self.effective_products(2)
    }

    /// The same of means of products of `order` transforms, whose phases cancel: the sums of shared tapers
    /// to that power. Neighbouring products of three have less in common than powers.
    pub fn effective_products(&self, order: i32) -> f64 {
        let shared = shared_products(&self.tapers, self.segments, order);
        effective_number(self.tapers.len(), &self.pairs(), &shared)
    }

    /// Pairs of visited segments that overlap, by their distance.
    fn pairs(&self) -> Vec<f64> {
        self.kept.pairs(self.distances())
    }

    /// Distances, in segments, at which segments overlap, 0 among them.
    pub fn distances(&self) -> usize {
        let Segments { length, hop, .. } = self.segments;
        length.div_ceil(hop).min(self.segments.count())
    }

    /// What is left of each site of so many records; `None` where no segments are left out.
    ///
    /// # Errors
    /// [`crate::Error::Request`] where no site has any.
    pub fn segments_left<'p>(
        &self,
        records: usize,
        sites: impl Iterator<Item = &'p SegmentPairs> + Clone,
    ) -> Result<Option<SegmentsLeft>> {
        let left: Vec<usize> = sites.clone().map(|site| site.segments() as usize).collect();
        if left.is_empty() {
            return Ok(None);
        }
        if left.iter().all(|left| *left == 0) {
            return Err(no_segment_left(self.segments.length));
        }
        let shared = shared_products(&self.tapers, self.segments, 2);
        let effective = |pairs: &SegmentPairs| match pairs.segments() > 0.0 {
            true => effective_number(self.tapers.len(), &pairs.pairs, &shared),
            false => 0.0,
        };
        Ok(Some(SegmentsLeft {
            of: self.segments.count() * records,
            left,
            effective: sites.map(effective).collect(),
        }))
    }

    /// How many of the realisations of so many records are independent; `left`: of these segments, where some are left out.
    pub fn independence(
        &self,
        records: usize,
        left: Option<&SegmentsLeft>,
        steadiness: f64,
    ) -> Independence {
        let (segments, effective) = match left {
            None => (self.segment_count(), self.effective()),
            Some(left) => {
                let effective = left.median_effective() / records as f64;
                (left.least_and_median()[1] / records, effective)
            }
        };
        let counts = [records, segments, self.tapers()];
        Independence::new(counts, effective, steadiness, self.segments.record)
    }

    /// The same as [`Self::effective`] of the parts of the transforms along a line and beside it: along `u_k`, the direction of the
    /// tapers' sums, and at right angles to it.
    ///
    /// ```text
    /// K_1 = S^2 / sum_{s s'} (u^T G u)^2,    K_2 = ((K - 1) S)^2 / sum_{s s'} |P G P|^2,
    /// ```
    ///
    /// over S segments, with `G_kk' = sum_n w_k(n) w_k'(n)` of tapers in the places of both segments and `P` the
    /// projection at right angles to u. Source: the sum of [`Self::effective`], of linear combinations of tapers.
    /// `pairs` of segments by their distance, by default of all.
    pub fn effective_beside_lines(
        &self,
        pairs: Option<&SegmentPairs>,
        shared: &[[f64; 2]],
    ) -> [f64; 2] {
        let pairs = pairs.map_or_else(|| self.pairs(), |pairs| pairs.pairs.clone());
        let (count, tapers) = (pairs[0], self.tapers.len());
        let mut all = [count, count * (tapers - 1) as f64];
        let wanted = all.map(|all| all * all);
        for (pairs, shared) in pairs.iter().zip(shared).skip(1) {
            all[0] += 2.0 * pairs * shared[0];
            all[1] += 2.0 * pairs * shared[1];
        }
        [wanted[0] / all[0], wanted[1] / all[1]]
    }

    /// What pairs of segments of a distance have in common along a line, and beside it.
    pub fn shared_beside_lines(&self) -> Vec<[f64; 2]> {
        // `sum_n w_k(n)`, the transform at the frequency of a line; 0 of odd ones.
        let sums: Vec<f64> = self.tapers.iter().map(|w| crate::numeric::sum(w)).collect();
        let norm = sums.iter().map(|u| u * u).sum::<f64>().sqrt();
        let direction: Array1<f64> = sums.iter().map(|u| u / norm).collect();
        let hop = self.segments.hop;
        let of = |j: usize| {
            let shared = |(k, i): (usize, usize)| -> f64 {
                let overlapping = self.tapers[k][j * hop..].iter().zip(&self.tapers[i]);
                overlapping.map(|(v, w)| v * w).sum()
            };
            let matrix = Array2::from_shape_fn((sums.len(), sums.len()), shared);
            let (right, left) = (matrix.dot(&direction), direction.dot(&matrix));
            let along = direction.dot(&right);
            let beside = |((k, i), g): ((usize, usize), &f64)| {
                let (u, v) = (direction[k], direction[i]);
                (g - right[k] * v - u * left[i] + along * u * v).powi(2)
            };
            [along * along, matrix.indexed_iter().map(beside).sum()]
        };
        (0..self.distances()).map(of).collect()
    }

    /// Neighbouring bins that an average shares, in bins: 1 without a taper, 1.94 of a Hann window.
    ///
    /// `B = N sum_n (sum_k w_k(n)^2)^2 / K`, the sum of the squared correlations of a bin with all others.
    pub fn shared_bins(&self) -> f64 {
        let length = self.segments.length;
        let weight = |n: usize| -> f64 { self.tapers.iter().map(|w| w[n] * w[n]).sum() };
        let squares: f64 = (0..length).map(|n| weight(n).powi(2)).sum();
        length as f64 * squares / self.tapers.len() as f64
    }

    /// `sum_k sum_n w_k(n) w_k(n + lag)`, by which averages over tapers multiply a correlation at a lag, in samples.
    pub fn autocorrelation(&self, lag: usize) -> f64 {
        let shared = |w: &Vec<f64>| -> f64 {
            let later = w.iter().skip(lag);
            later.zip(w).map(|(a, b)| a * b).sum()
        };
        self.tapers.iter().map(shared).sum()
    }

    /// What coefficients of products of two transforms are multiplied by to be those of products of Fourier
    /// coefficients: `N sum w^4 / sum w^3` under the first taper, since a product has it twice.
    pub fn quadratic_scale(&self) -> f64 {
        let taper = self.tapers[0].iter();
        let [cubes, fourths] =
            [3, 4].map(|order| taper.clone().map(|w| w.powi(order)).sum::<f64>());
        self.segments.length as f64 * fourths / cubes
    }

    /// Bins from which on two are nearly independent under the window: 1 without a taper, 2 of a Hann window.
    pub fn least_distance(&self) -> usize {
        let is_far = |distance: &usize| self.bin_correlation(*distance) < 0.1;
        (1..self.bins()).find(is_far).unwrap_or(self.bins())
    }

    /// Correlation of the power of a bin with that of the bin `lag` beside it, of white noise under the first
    /// taper.
    pub fn bin_correlation(&self, lag: usize) -> f64 {
        let length = self.segments.length;
        let term = |(n, w): (usize, &f64)| {
            let turn = TAU * (n * lag % length) as f64 / length as f64;
            Complex::from_polar(w * w, turn)
        };
        let sum: Complex<f64> = self.tapers[0].iter().enumerate().map(term).sum();
        sum.norm_sqr()
    }
}

/// Sums of the shared parts of tapers with `sum w^2 = 1`, to a power, by the distance of two segments.
fn shared_products(tapers: &[Vec<f64>], segments: Segments, order: i32) -> Vec<f64> {
    let Segments { length, hop, .. } = segments;
    let shared = |lag: usize| -> f64 {
        let pairs = tapers
            .iter()
            .flat_map(|a| tapers.iter().map(move |b| (a, b)));
        let product = |(a, b): (&Vec<f64>, &Vec<f64>)| -> f64 {
            let overlapping = a[lag..].iter().zip(b);
            let shared: f64 = overlapping.map(|(v, w)| v * w).sum();
            shared.abs().powi(order)
        };
        pairs.map(product).sum()
    };
    let overlap = (0..segments.count()).take_while(|j| j * hop < length);
    overlap.map(|j| shared(j * hop)).collect()
}

/// See [`Realisations::effective_products`], of pairs of segments by their distance.
fn effective_number(tapers: usize, pairs: &[f64], shared: &[f64]) -> f64 {
    let terms = pairs.iter().zip(shared);
    let beside: f64 = terms.skip(1).map(|(pairs, shared)| pairs * shared).sum();
    let all = pairs[0] * tapers as f64;
    all.powi(2) / (pairs[0] * shared[0] + 2.0 * beside)
}

/// How many independent segments of white noise have the variance of the average over all `segments` under a
/// window.
pub(crate) fn effective_segments(window: &[f64], segments: Segments) -> f64 {
    let power = crate::numeric::sum_of_squares(window);
    let scaled = window.iter().map(|w| w / power.sqrt()).collect();
    let shared = shared_products(&[scaled], segments, 2);
    let pairs = KeptSegments::without(segments, []).pairs(shared.len());
    effective_number(1, &pairs, &shared)
}
