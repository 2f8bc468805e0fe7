//! Transfer between wavenumbers by triads, where the equation of motion is quadratic.
//!
//! A quadratic term couples three wavenumbers whose sum is 0. Each triad conserves its energy, so the
//! transfer to a wavenumber splits into parts `T(k | p, q)` from pairs `p + q = k`, and the flux past a
//! wavenumber into parts from triads of near and of far wavenumbers: how local the cascade is.

mod kernel;
mod locality;
mod motions;
mod sheet;

use std::ops::Range;

use ndarray::Array2;
use rayon::prelude::*;

use self::kernel::{Components, Grid};
pub use self::locality::Locality;
use self::locality::past;
use self::motions::QuadraticChain;
use super::motion::Motion;
use super::units::BudgetUnits;
use crate::error::{Error, Result};
use crate::observer::Observer;
use crate::system::memory::{half_of_free_memory, try_filled};
use crate::system::threads::in_pool;

/// The options of [`chain_triads`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TriadsRequest {
    /// Samples over which transfers are integrated; `None`: all.
    pub window: Option<Range<usize>>,
    pub units: BudgetUnits,
    /// Worker threads; `None`: one per core. The results do not depend on it.
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    pub memory: Option<u64>,
}

/// The law whose triads are found: equal masses, and contacts whose force is `linear r + quadratic r^2` and a rest, about
/// the static state.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct QuadraticLaw {
    pub mass: f64,
    pub linear: f64,
    pub quadratic: f64,
}

/// Energy that wavenumbers gained from others, over the samples of a window.
///
/// Rows are wavenumbers k, both signs together; columns the larger partner p.
#[derive(Debug, Clone)]
pub struct Triads {
    pub law: QuadraticLaw,
    pub units: BudgetUnits,
    /// Times of the first and the last sample.
    pub window: [f64; 2],
    pub samples: usize,
    /// k, in rad per unit of length.
    pub wavenumber: Vec<f64>,
    /// Energy that k gained with the larger partner p: `q = k - p` for `p <= k`, a sum; `q = p - k` beyond, a
    /// difference.
    pub transfer: Array2<f64>,
    /// The same where the three wavenumbers add up to a full turn per site, `q = 2 pi - k - p`.
    pub umklapp: Array2<f64>,
    /// Energy that k gained from all pairs.
    pub gained: Vec<f64>,
    /// Energy at k: at the end less at the start.
    pub change: Vec<f64>,
    /// Energy that the terms of the law beyond the quadratic one gave; `None` of a law without.
    pub beyond: Option<Vec<f64>>,
    /// Energy that went past k towards larger wavenumbers: `- sum of gained up to k`.
    pub flux: Vec<f64>,
    /// Energy at the start.
    pub energy: f64,
    /// The error of the flux by the sampling: what every second sample differs by, over three.
    pub sampling_error: f64,
    /// The largest flux, and the triads that carry it.
    pub locality: Locality,
    pub identities: TriadIdentities,
}

/// Identities that hold for any motion; deviations are rounding.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct TriadIdentities {
    /// The three transfers of a triad, added up, relative to the largest transfer.
    pub detailed: f64,
    /// Transfers summed over pairs against the transform of the product, relative to the largest.
    pub sums: f64,
}

impl Triads {
    /// What the change has beside the quadratic transfer and the rest of the law: losses, drives, ends, sampling.
    pub fn unexplained(&self) -> Vec<f64> {
        let beyond = |k: usize| self.beyond.as_ref().map_or(0.0, |beyond| beyond[k]);
        let unexplained = |k: usize| self.change[k] - (self.gained[k] + beyond(k));
        (0..self.change.len()).map(unexplained).collect()
    }

    /// What terms beyond the quadratic one moved, as a share of what it moved.
    pub fn share_beyond(&self) -> f64 {
        let moved = |values: &[f64]| values.iter().map(|value| value.abs()).sum::<f64>();
        let beyond = self.beyond.as_deref().map_or(0.0, moved);
        match beyond == 0.0 {
            true => 0.0,
            false => beyond / moved(&self.gained),
        }
    }

    /// The error that sampling and terms that are not quadratic leave in the flux at the wavenumber of the largest
    /// one.
    pub fn flux_error(&self) -> f64 {
        let beyond = self.beyond.as_deref().unwrap_or_default();
        let past: f64 = beyond.iter().take(self.locality.at + 1).sum();
        self.sampling_error.max(past.abs())
    }

    /// Whether terms beyond the quadratic one moved little enough, a fifth, for triads to describe the transfer.
    pub fn is_quadratic(&self) -> bool {
        self.share_beyond() <= 0.2
    }

    /// Whether the largest flux is one: ten times its error, and more than rounding of the energy.
    pub fn is_resolved(&self) -> bool {
        let flux = self.flux[self.locality.at].abs();
        flux > 10.0 * self.flux_error() && flux > 1e-9 * self.energy
    }
}

/// The triads of a chain whose contacts have a quadratic term.
///
/// # Equation
/// With `r_j` the closing of contact j from the static state, `F = a r + b r^2 + ...`, and coefficients
/// `r^_k = (1/N) sum_j r_j exp(-i k j)`,
///
/// ```text
/// T(k | p, q) = (N b / 3) Re( conj(r^_k) (r^_p r^_q)' - 2 conj(r^_k)' r^_p r^_q ),    p + q = k,
/// dE(k)/dt = sum T(k | p, q) + rest,    T(k | p, q) + T(p | k, -q) + T(q | k, -p) = 0,
/// ```
///
/// with the prime for the rate of change, and `E(k) = N (m |v^_k|^2 / 2 + a |r^_k|^2 / 2 + Re(conj(r^_k) (b r^2)^_k) / 3)`,
/// which sums to the energy up to terms beyond the quadratic force. Between two walls, the chain and its mirror image are
/// one period.
///
/// # Shapes
/// See [`Triads`]; a chain of N sites has N / 2 + 1 wavenumbers, or N + 2 between two walls.
///
/// # Units
/// Energies; wavenumbers in rad per unit of length, for sites `pitch` apart.
///
/// # Errors
/// [`Error::Request`] for masses or contacts that differ, for a law without a quadratic term about its static
/// state, and for a window of fewer than three samples; [`Error::Memory`]; [`Error::Failed`]; [`Error::Cancelled`].
///
/// # Source
/// R. H. Kraichnan, J. Fluid Mech. 5, 497 (1959), for triads that conserve energy each; the third of the interaction's
/// energy at each of its wavenumbers is what makes them do so here.
pub fn chain_triads(
    motion: &Motion,
    pitch: f64,
    request: &TriadsRequest,
    observer: &dyn Observer,
) -> Result<Triads> {
    motion.check()?;
    let chain = QuadraticChain::of(motion)?;
    let is_length = pitch > 0.0 && pitch.is_finite();
    Error::require(is_length, "pitch", "a positive length", pitch)?;
    let samples = motion.samples();
    let window = request.window.clone().unwrap_or(0..samples);
    let fits = window.end <= samples && window.len() >= 3;
    let expected = format!("three samples or more within 0:{samples}");
    let found = format!("{}:{}", window.start, window.end);
    Error::require(fits, "window-samples", expected, found)?;
    let n = chain.grid.components;
    let needed = 8 * (2 * n * n + BLOCK * 6 * n) as u64;
    let allowed = request.memory.unwrap_or_else(half_of_free_memory);
    let what = "the transfers of all pairs";
    Error::beyond_memory(what, needed, allowed)?;
    let full = |_| Error::Memory {
        what,
        needed,
        allowed,
    };
    let map = || try_filled(n * n, 0.0).map_err(full);
    let maps = [map()?, map()?];
    in_pool(request.threads, || {
        integrate(&chain, maps, window, pitch, request, observer)
    })
}

/// The largest magnitude.
fn largest<'v>(values: impl IntoIterator<Item = &'v f64>) -> f64 {
    let values = values.into_iter();
    values.fold(0.0, |most: f64, value| most.max(value.abs()))
}

/// Samples whose coefficients are at hand at once.
const BLOCK: usize = 16;

fn integrate(
    source: &QuadraticChain,
    [mut transfer, mut umklapp]: [Vec<f64>; 2],
    window: Range<usize>,
    pitch: f64,
    request: &TriadsRequest,
    observer: &dyn Observer,
) -> Result<Triads> {
    let grid = &source.grid;
    let n = grid.components;
    observer.stage("triads", window.len() as u64);
    let (t0, dt) = (source.motion.time[0], source.motion.step());
    let last = window.len() - 1;
    let weight = |i: usize| if i == 0 || i == last { 0.5 * dt } else { dt };
    // An odd number of steps has no half of them; its last one counts in full for both.
    let even = last - last % 2;
    let coarse = |i: usize| match i {
        _ if i > even => 0.5 * dt,
        _ if i == even && even < last => 1.5 * dt,
        _ if i == 0 || i == even => dt,
        _ if i.is_multiple_of(2) => 2.0 * dt,
        _ => 0.0,
    };
    let mut total = vec![0.0; n];
    let mut coarser = vec![0.0; n];
    let mut beyond = source.has_more().then(|| vec![0.0; n]);
    let [mut first, mut end] = [Vec::new(), Vec::new()];
    let numbers: Vec<usize> = window.clone().collect();
    for (b, block) in numbers.chunks(BLOCK).enumerate() {
        observer.go_on()?;
        let at: Vec<Components> = block.par_iter().map(|i| source.components(*i)).collect();
        for (j, one) in at.iter().enumerate() {
            let i = b * BLOCK + j;
            for (k, rate) in one.transfer.iter().enumerate() {
                total[k] += weight(i) * rate;
                coarser[k] += coarse(i) * rate;
            }
            for (sum, rate) in beyond.iter_mut().flatten().zip(&one.beyond) {
                *sum += weight(i) * rate;
            }
            match i {
                0 => first.clone_from(&one.energy),
                _ if i == last => end.clone_from(&one.energy),
                _ => {}
            }
        }
        let weights: Vec<f64> = (0..block.len()).map(|j| weight(b * BLOCK + j)).collect();
        type Add = fn(&Grid, usize, &Components, f64, &mut [f64]);
        let kinds: [(_, Add); 2] = [
            (&mut transfer, kernel::add_pairs),
            (&mut umklapp, kernel::add_wrapped),
        ];
        for (map, add) in kinds {
            map.par_chunks_mut(n).enumerate().for_each(|(k, row)| {
                for (one, weight) in at.iter().zip(&weights) {
                    add(grid, k, one, *weight, row);
                }
            });
        }
        observer.advance(block.len() as u64);
    }
    // Both have n rows of n.
    let matrix = |values| Array2::from_shape_vec((n, n), values).unwrap_or_default();
    let transfer = matrix(transfer);
    let umklapp = matrix(umklapp);
    let sum = |map: &Array2<f64>, k: usize| crate::numeric::sum(&map.row(k).to_vec());
    let gained = (0..n).map(|k| sum(&transfer, k) + sum(&umklapp, k));
    let gained: Vec<f64> = gained.collect();
    let flux = past(&gained);
    let pairs = total.iter().zip(&coarser);
    let differences: Vec<f64> = pairs.map(|(a, b)| (a - b) / 3.0).collect();
    let relative = |off: f64, of: f64| if off == 0.0 { 0.0 } else { off / of };
    let off: Vec<f64> = gained.iter().zip(&total).map(|(a, b)| a - b).collect();
    let scale = largest(&transfer);
    Ok(Triads {
        law: source.law,
        units: request.units.clone(),
        window: [window.start, window.end - 1].map(|i| t0 + dt * i as f64),
        samples: window.len(),
        wavenumber: (0..n).map(|k| grid.step(k) / pitch).collect(),
        identities: TriadIdentities {
            detailed: relative(kernel::detailed(&transfer), scale),
            sums: relative(largest(&off), scale),
        },
        locality: Locality::of(grid, &transfer, &umklapp, &flux),
        change: end.iter().zip(&first).map(|(a, b)| a - b).collect(),
        energy: crate::numeric::sum(&first),
        sampling_error: largest(&past(&differences)),
        beyond,
        flux,
        gained,
        transfer,
        umklapp,
    })
}
