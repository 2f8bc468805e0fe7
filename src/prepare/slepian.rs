//! Discrete prolate spheroidal (Slepian) sequences.
//!
//! The sequences of length n that hold most of their energy in `|f| <= W = NW / n` are
//! eigenvectors of the band matrix `sin(2 pi W (i - j)) / (pi (i - j))`, and of a tridiagonal one
//! that commutes with it (Slepian 1978, eq. 14). Subtracted from `(n^2 - 1) / 4`, the latter is
//!
//! ```text
//! A = Laplacian of the path with weights e_i = i (n - i) / 2, plus diag(s_i),
//! s_i = 2 sin^2(pi W) x_i^2,    x_i = (n - 1) / 2 - i,
//! ```
//!
//! whose lowest eigenvalues, of order NW, would drown in the rounding of entries of order n^2.
//! Eliminating from the end in `g_i = pivot_i - e_{i+1}`,
//!
//! ```text
//! g_i = s_i - sigma + e_i g_{i-1} / (e_i + g_{i-1}),
//! ```
//!
//! never forms the large differences, so that a record of any length keeps its digits. Even and odd sequences
//! are solved apart, each on half the samples.

use std::f64::consts::PI;

/// One sequence with the share of its energy inside the band.
#[derive(Debug, Clone, PartialEq)]
pub struct Slepian {
    /// `v_i`, with `sum v_i^2 = 1`.
    pub samples: Vec<f64>,
    /// Energy in `|f| <= W` over all energy, 0 to 1.
    pub concentration: f64,
}

/// The first `count` sequences of length `n` for the time-bandwidth product `nw`, best first.
///
/// Symmetric ones have a positive sum, antisymmetric ones begin with a positive lobe. At most `n`
/// are returned; `nw` at or above `n / 2` (all frequencies) is taken as `n / 2`.
///
/// Cost: `O(n)` memory and about 60 sweeps over `n / 2` samples a sequence.
///
/// Source: Slepian, Bell Syst. Tech. J. 57, 1371 (1978); signs as Percival and Walden (1993),
/// p. 379, and as SciPy.
pub fn sequences(n: usize, nw: f64, count: usize) -> Vec<Slepian> {
    (0..count.min(n)).map(|k| sequence(n, nw, k)).collect()
}

/// The first half, centre included, of the zeroth sequence, scaled to a largest sample of 1.
pub(super) fn taper_half(n: usize, nw: f64) -> Vec<f64> {
    let half = Half::new(n, nw, false);
    half.eigenvector(half.eigenvalue(0, nw))
}

fn sequence(n: usize, nw: f64, k: usize) -> Slepian {
    let odd = k % 2 == 1;
    let half = Half::new(n, nw, odd);
    let mut samples = half.eigenvector(half.eigenvalue(k / 2, nw));
    let mirrored: Vec<f64> = samples[..n / 2].iter().rev().copied().collect();
    if odd && n % 2 == 1 {
        samples.push(0.0);
    }
    samples.extend(mirrored.iter().map(|v| if odd { -v } else { *v }));

    let norm = samples.iter().map(|v| v * v).sum::<f64>().sqrt();
    let scale = sign(&samples, norm, odd) / norm;
    samples.iter_mut().for_each(|v| *v *= scale);
    let concentration = concentration(&samples, half.bandwidth);
    Slepian {
        samples,
        concentration,
    }
}

/// The sign that makes a symmetric sequence sum, or an antisymmetric one begin, above 0.
fn sign(samples: &[f64], norm: f64, odd: bool) -> f64 {
    let noise = norm * (1.0 / samples.len() as f64).max(1e-7).sqrt();
    let deciding: f64 = match odd {
        true => *samples.iter().find(|v| v.abs() > noise).unwrap_or(&0.0),
        false => samples.iter().sum(),
    };
    if deciding < 0.0 { -1.0 } else { 1.0 }
}

/// The eigenvalue of the band matrix, from its row where the sequence is largest.
fn concentration(samples: &[f64], bandwidth: f64) -> f64 {
    let size = |i: usize| samples[i].abs();
    let peak = (0..samples.len()).max_by(|&a, &b| size(a).total_cmp(&size(b)));
    let peak = peak.unwrap_or(0);
    let term = |(i, v): (usize, &f64)| match i.abs_diff(peak) as f64 {
        0.0 => 2.0 * bandwidth * v,
        lag => (2.0 * PI * bandwidth * lag).sin() / (PI * lag) * v,
    };
    let row: f64 = samples.iter().enumerate().map(term).sum();
    (row / samples[peak]).clamp(0.0, 1.0)
}

/// The matrix A on the even or on the odd sequences: the first half of the samples.
struct Half {
    n: usize,
    /// W in cycles a sample.
    bandwidth: f64,
    /// `2 sin^2(pi W)`.
    curvature: f64,
    size: usize,
    /// Multiplicity of the last row's neighbour: 2 if the row is the centre itself.
    last_fold: f64,
    /// Coefficient of the last row that represents the coupling to the other half.
    last_weight: f64,
}

impl Half {
    fn new(n: usize, nw: f64, odd: bool) -> Self {
        let bandwidth = (nw / n as f64).min(0.5);
        let middle = weight(n, n / 2);
        let (size, last_fold, last_weight) = match (n % 2 == 1, odd) {
            (true, false) => (n / 2 + 1, 2.0, 0.0),
            (true, true) => (n / 2, 1.0, middle),
            (false, false) => (n / 2, 1.0, 0.0),
            (false, true) => (n / 2, 1.0, 2.0 * middle),
        };
        Half {
            n,
            bandwidth,
            curvature: 2.0 * (PI * bandwidth).sin().powi(2),
            size,
            last_fold,
            last_weight,
        }
    }

    /// Visits the pivots of `A - sigma`, eliminated from the end to the centre.
    fn pivots(&self, sigma: f64, mut visit: impl FnMut(f64)) {
        let centre = (self.n as f64 - 1.0) / 2.0;
        let own = |i: usize| self.curvature * (centre - i as f64).powi(2) - sigma;
        let mut inflow = 0.0;
        for i in 0..self.size - 1 {
            let weight = weight(self.n, i + 1);
            let excess = own(i) + inflow;
            let pivot = match weight + excess {
                0.0 => f64::EPSILON * weight,
                pivot => pivot,
            };
            visit(pivot);
            inflow = weight * (excess / pivot);
        }
        visit(own(self.size - 1) + self.last_fold * inflow + self.last_weight);
    }

    /// The eigenvalue with `index` others below it, by bisection on the count of negative pivots.
    fn eigenvalue(&self, index: usize, nw: f64) -> f64 {
        let below = |sigma: f64| {
            let mut count = 0;
            self.pivots(sigma, |pivot| count += usize::from(pivot < 0.0));
            count
        };
        let (mut low, mut high) = (0.0, PI * nw.max(1.0));
        while below(high) <= index && high < f64::MAX / 2.0 {
            (low, high) = (high, 2.0 * high);
        }
        for _ in 0..128 {
            let middle = 0.5 * (low + high);
            if high - low <= f64::EPSILON * high {
                break;
            }
            match below(middle) <= index {
                true => low = middle,
                false => high = middle,
            }
        }
        0.5 * (low + high)
    }

    /// The eigenvector, by substitution from its sample next to (or at) the centre, set to 1.
    fn eigenvector(&self, eigenvalue: f64) -> Vec<f64> {
        let mut vector = Vec::with_capacity(self.size);
        self.pivots(eigenvalue, |pivot| vector.push(pivot));
        vector[self.size - 1] = 1.0;
        for i in (0..self.size - 1).rev() {
            vector[i] = weight(self.n, i + 1) / vector[i] * vector[i + 1];
        }
        vector
    }
}

/// `e_i = i (n - i) / 2`.
fn weight(n: usize, i: usize) -> f64 {
    i as f64 * (n - i) as f64 / 2.0
}
