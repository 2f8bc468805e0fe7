//! Normal modes of a chain about its static state.

use std::f64::consts::PI;

use ndarray::Array2;
use num_complex::Complex;

use super::lattice::Chain;
use crate::numeric::hermitian::eigen;
use crate::numeric::next_uniform;
use crate::{Error, Result};

/// Sites beyond which the matrix of a chain is not diagonalized.
const MOST_SITES: usize = 2000;

/// Squares of frequencies below this share of the largest are those of a free motion of the whole chain.
const FREE: f64 = 1e-12;

/// Squares below 0 by more than this share of it are no rounding.
const UNSTABLE: f64 = 1e-9;

/// The modes of a chain whose contacts are springs of the stiffness that they have in the static state.
///
/// With `q_j = m_j^{1/2} x_j` the chain is `q'' = -D q`, `D` symmetric; `D e_k = w_k^2 e_k` with unit vectors. A
/// mode has the energy `E_k = (Q'^2 + w_k^2 Q^2) / 2`, `Q = e_k . q`. Resonators are places behind those of the bodies, in their order;
/// dashpots are left out.
#[derive(Debug, Clone)]
pub struct NormalModes {
    /// Angular frequencies, rising.
    pub frequency: Vec<f64>,
    /// The vector `e_k` of each, its first element that is not 0 positive.
    pub shape: Vec<Vec<f64>>,
    root_mass: Vec<f64>,
    /// The sites that have resonators.
    resonators: Vec<usize>,
    /// Modes of frequency 0: the chain as a whole.
    pub free: usize,
}

impl Chain {
    /// The modes of small motion about the static state.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for a chain without small linear motion, such as Hertz contacts that are not
    /// compressed, and for more than 2000 bodies and resonators.
    pub fn normal_modes(&self) -> Result<NormalModes> {
        let n = self.n_sites();
        let linear = self.all_contacts().all(|of| of.has_linear_limit());
        let expected = "a chain with linear small motion: one with precompression, or of a law that pulls, too";
        Error::require(linear, "mode", expected, "contacts that only touch")?;
        let resonators = self.resonators().into_iter().flat_map(|all| all.sites());
        let resonators: Vec<usize> = resonators.collect();
        let places = n + resonators.len();
        let expected = "at most 2000 bodies and resonators for modes";
        Error::require(places <= MOST_SITES, "mode", expected, places)?;
        let own = self.resonators().map_or(&[][..], |all| &all.mass[..]);
        let own = resonators.iter().map(|j| own[*j]);
        let root_mass = self.mass.iter().copied().chain(own).map(f64::sqrt);
        let root_mass: Vec<f64> = root_mass.collect();
        let mut matrix = Array2::<Complex<f64>>::zeros((places, places));
        let mut add = |i: usize, j: usize, value: f64| {
            matrix[[i, j]] += value / (root_mass[i] * root_mass[j]);
        };
        let own = self.resonators().map_or(&[][..], |all| &all.stiffness[..]);
        let ties = resonators.iter().zip(n..);
        let ties = ties.map(|(&j, s)| ([Some(j), Some(s)], own[j]));
        let springs = self.springs().map(|of| (of.sites, of.stiffness(0.0)));
        for (sites, stiffness) in ties.chain(springs) {
            let ends = sites.into_iter().zip([1.0, -1.0]);
            let ends: Vec<(usize, f64)> = ends.filter_map(|(j, sign)| Some((j?, sign))).collect();
            for ((i, a), (j, b)) in ends.iter().flat_map(|a| ends.iter().map(move |b| (*a, *b))) {
                add(i, j, a * b * stiffness);
            }
        }
        let found = eigen(&matrix);
        let most = found.values.first().copied().unwrap_or(0.0);
        let least = found.values.last().copied().unwrap_or(0.0);
        let expected = "a chain that is stable at rest, for modes";
        let square = format!("the square {least} of a frequency");
        Error::require(least >= -UNSTABLE * most, "mode", expected, square)?;
        let mut frequency: Vec<f64> = Vec::with_capacity(places);
        let mut shape = Vec::with_capacity(places);
        for (square, vector) in found.values.iter().zip(found.vectors).rev() {
            let is_free = *square < FREE * most;
            frequency.push(if is_free { 0.0 } else { square.sqrt() });
            shape.push(real(&vector));
        }
        Ok(NormalModes {
            free: frequency.iter().filter(|w| **w == 0.0).count(),
            frequency,
            shape,
            root_mass,
            resonators,
        })
    }
}

/// An eigenvector of a real matrix, its phase taken off.
fn real(vector: &[Complex<f64>]) -> Vec<f64> {
    let larger = |a: Complex<f64>, b: &Complex<f64>| match b.norm_sqr() > a.norm_sqr() {
        true => *b,
        false => a,
    };
    let largest = vector.iter().fold(Complex::default(), larger);
    let phase = largest.conj() / largest.norm();
    let mut row: Vec<f64> = vector.iter().map(|value| (value * phase).re).collect();
    let size = row.iter().map(|v| v * v).sum::<f64>().sqrt();
    let first = row.iter().find(|v| v.abs() > 1e-9 * size).copied();
    let scale = size.copysign(first.unwrap_or(1.0));
    row.iter_mut().for_each(|value| *value /= scale);
    row
}

impl NormalModes {
    /// The values of all places: those of the bodies, and of the resonators, one a site.
    pub fn places(&self, bodies: &[f64], resonators: &[f64]) -> Vec<f64> {
        let own = self.resonators.iter().map(|j| resonators[*j]);
        bodies.iter().copied().chain(own).collect()
    }

    /// Energies of all modes, those of frequency 0 included, by displacements and velocities of all places.
    pub fn energies(&self, displacement: &[f64], velocity: &[f64], out: &mut [f64]) {
        let modes = self.frequency.iter().zip(&self.shape);
        for (energy, (w, shape)) in out.iter_mut().zip(modes) {
            let project = |values: &[f64]| -> f64 {
                let sites = shape.iter().zip(&self.root_mass).zip(values);
                sites.map(|((e, root), value)| e * root * value).sum()
            };
            let (at, rate) = (project(displacement), project(velocity));
            *energy = 0.5 * (rate * rate + w * w * at * at);
        }
    }

    /// Displacements and velocities of bodies, and of resonators, one a site, in modes, counted from 1 from the lowest frequency above 0, with this energy
    /// each, and random phases of a seed or, without one, at rest.
    pub(crate) fn excite(
        &self,
        modes: std::ops::RangeInclusive<usize>,
        energy: f64,
        seed: Option<u64>,
    ) -> [[Vec<f64>; 2]; 2] {
        let n = self.root_mass.len();
        let mut state = seed.unwrap_or(0);
        let (mut x, mut v) = (vec![0.0; n], vec![0.0; n]);
        for mode in modes {
            let k = self.free + mode - 1;
            let phase = match seed {
                None => 0.0,
                Some(_) => 2.0 * PI * next_uniform(&mut state),
            };
            let size = (2.0 * energy).sqrt();
            let (at, rate) = (size / self.frequency[k] * phase.cos(), size * phase.sin());
            let sites = self.shape[k].iter().zip(&self.root_mass);
            for ((x, v), (e, root)) in x.iter_mut().zip(&mut v).zip(sites) {
                *x += at * e / root;
                *v += rate * e / root;
            }
        }
        let sites = n - self.resonators.len();
        let apart = |all: &Vec<f64>| {
            let mut own = vec![0.0; sites];
            for (j, value) in self.resonators.iter().zip(&all[sites..]) {
                own[*j] = *value;
            }
            own
        };
        let own = [&x, &v].map(apart);
        x.truncate(sites);
        v.truncate(sites);
        [[x, v], own]
    }
}
