//! The acoustic and the optical part of a dimer's spectra, where it has a linear limit.
//!
//! Small waves on the static state of a dimer mix k with k + pi / a alone. With `q^`, `phi^` at the
//! two as vectors over the sublattices, the linear chain is `phi = B q~` (`q~` with displacements in
//! place of velocities): the singular vectors of the 2 x 2 matrix B are its acoustic and optical
//! modes. Projections of `q^` on the right ones and of `phi^` on the left ones split E(k) and T(k)
//! without remainder, in a nonlinear state too; where the chain is linear nothing passes between
//! the two.

use std::f64::consts::PI;

use num_complex::Complex;

use super::modes::{Basis, Modes};
use super::wavenumber::dot;
use crate::chain::Chain;

type Pair = [Complex<f64>; 2];

/// The optical mode at one wavenumber of the cell; the acoustic one is orthogonal to it.
#[derive(Debug, Clone, Copy)]
struct Optical {
    sites: Pair,
    contacts: Pair,
}

#[derive(Debug)]
pub(super) struct Branches {
    sites: usize,
    /// Wavenumbers of the cell, `0 ..= N / 4` steps.
    optical: Vec<Optical>,
}

/// Both branches over the wavenumbers of the cell, both signs of k in one.
#[derive(Debug, Clone, Default)]
pub(super) struct BranchSplit {
    pub(super) acoustic_energy: Vec<f64>,
    pub(super) optical_energy: Vec<f64>,
    /// Rate at which all of the optical branch gains energy from the acoustic one.
    pub(super) optical_transfer: f64,
}

impl Branches {
    /// `None` where the chain has no linear limit, or is no dimer of whole cells.
    pub(super) fn of(chain: &Chain, modes: &Modes) -> Option<Branches> {
        let n = chain.n_sites();
        let held = chain.on_site.any();
        let odd = n < 4 || n % 2 == 1;
        let linear = chain.all_contacts().all(|of| of.has_linear_limit());
        if modes.basis() != Basis::Fourier || odd || held || !linear {
            return None;
        }
        let cell = |values: &[f64]| <[f64; 2]>::try_from(chain.cell(values, 2, 0.0)?).ok();
        let stiffness = chain.all_contacts().map(|of| of.stiffness(0.0));
        let stiffness: Vec<f64> = stiffness.collect();
        let (mass, stiffness) = (cell(&chain.mass)?, cell(&stiffness)?);
        let alike = |[a, b]: [f64; 2]| (a - b).abs() <= 1e-9 * a.abs();
        if alike(mass) && alike(stiffness) {
            return None;
        }
        let step = 2.0 * PI / n as f64;
        let optical = |m: usize| optical(step * m as f64, mass, stiffness);
        let optical = (0..=n / 4).map(optical).collect();
        Some(Branches { sites: n, optical })
    }

    /// How many wavenumbers the cell has: the first of those of the sites.
    pub(super) fn len(&self) -> usize {
        self.optical.len()
    }

    /// Of motions and of contacts, each with its rate.
    pub(super) fn split(
        &self,
        sites: [&[Complex<f64>]; 2],
        contacts: [&[Complex<f64>]; 2],
    ) -> BranchSplit {
        let count = self.optical.len();
        let mut split = BranchSplit {
            acoustic_energy: vec![0.0; count],
            optical_energy: vec![0.0; count],
            optical_transfer: 0.0,
        };
        for (m, optical) in self.optical.iter().enumerate() {
            // k and k + pi meet in one wavenumber of the cell; at its ends they are each other's
            // images, which count once.
            let is_end = m == 0 || 4 * m == self.sites;
            let weight = if is_end { 1.0 } else { 2.0 };
            let pair = |z: &[Complex<f64>]| self.sublattices(z, m);
            let ([q, f], [phi, rate]) = (sites.map(pair), contacts.map(pair));
            let total = 0.5 * norm(q) + norm(phi);
            let [q1, f1] = [q, f].map(|z| project(optical.sites, z));
            let [phi1, rate1] = [phi, rate].map(|z| project(optical.contacts, z));
            let energy = 0.5 * q1.norm_sqr() + phi1.norm_sqr();
            split.optical_energy[m] = weight * energy;
            split.acoustic_energy[m] = weight * (total - energy);
            split.optical_transfer += weight * (dot(q1, f1) + 2.0 * dot(phi1, rate1));
        }
        split
    }

    /// Transforms of even and odd places, from those at k and at k + pi.
    fn sublattices(&self, z: &[Complex<f64>], m: usize) -> Pair {
        // z(k + pi) = conj(z(pi - k)), since rows are real.
        let (here, there) = (z[m], z[self.sites / 2 - m].conj());
        let scale = 0.5f64.sqrt();
        [(here + there) * scale, (here - there) * scale]
    }
}

/// The larger singular value's vectors of `B`, [`Branches`]' matrix at k.
fn optical(k: f64, [m0, m1]: [f64; 2], [k0, k1]: [f64; 2]) -> Optical {
    let turn = Complex::from_polar(1.0, -k);
    let real = |x: f64| Complex::new(x, 0.0);
    let b = [
        [real((0.5 * k0 / m0).sqrt()), -turn * (0.5 * k0 / m1).sqrt()],
        [-turn * (0.5 * k1 / m0).sqrt(), real((0.5 * k1 / m1).sqrt())],
    ];
    // B^H B = [[p, s], [conj(s), r]], its larger eigenvalue p/2 + r/2 + root.
    let p = b[0][0].norm_sqr() + b[1][0].norm_sqr();
    let r = b[0][1].norm_sqr() + b[1][1].norm_sqr();
    let s = b[0][0].conj() * b[0][1] + b[1][0].conj() * b[1][1];
    let half = 0.5 * (p - r);
    let root = half.hypot(s.norm());
    let sites = if half > 0.0 {
        unit([real(half + root), s.conj()])
    } else if s.norm() > 0.0 {
        unit([s, real(root - half)])
    } else {
        [real(0.0), real(1.0)]
    };
    let image = [0, 1].map(|row| b[row][0] * sites[0] + b[row][1] * sites[1]);
    Optical {
        sites,
        contacts: unit(image),
    }
}

fn norm(z: Pair) -> f64 {
    z[0].norm_sqr() + z[1].norm_sqr()
}

fn unit(z: Pair) -> Pair {
    let scale = 1.0 / norm(z).sqrt();
    z.map(|z| z * scale)
}

fn project(mode: Pair, z: Pair) -> Complex<f64> {
    mode[0].conj() * z[0] + mode[1].conj() * z[1]
}
