//! Energy, transfer and losses by wavenumber, at one instant.
//!
//! `q_j = sqrt(m_j) v_j` and `phi_i = sign(r_i) sqrt(V_i)` turn the energy into a sum of squares,
//! which a unitary transform keeps: `E(k) = |q^|^2 / 2 + |phi^|^2`. Its rate of change is
//! `T(k) = Re(conj(q^) f^) + 2 Re(conj(phi^) phi'^)` with the elastic forces
//! `f_j = (F_{j-1} - F_j) / sqrt(m_j)`, `phi'_i = F_i r'_i / (2 phi_i)`; less
//! `L(k) = - Re(conj(q^) fd^)` with the forces of dampers and drag; plus `I(k)`, what a driven end
//! puts in. `sum T = 0`: it is exchange between wavenumbers, whatever the state.

use num_complex::Complex;

use super::branches::{Branches, Split};
use super::contacts::{ContactState, Contacts};
use super::modes::{Modes, ModesScratch};
use super::motion::Instant;

/// What is needed at every instant.
#[derive(Debug)]
pub(super) struct Transfers<'a> {
    pub(super) contacts: &'a Contacts<'a>,
    pub(super) modes: Modes,
    root_mass: Vec<f64>,
    lossy: bool,
    driven: bool,
    branches: Option<Branches>,
}

/// The terms of the balance, each of as many values as there are components, both signs of k in
/// one; those that a chain has not are empty.
#[derive(Debug, Clone, Default)]
pub(super) struct Terms {
    pub(super) energy: Vec<f64>,
    pub(super) transfer: Vec<f64>,
    pub(super) loss: Vec<f64>,
    pub(super) input: Vec<f64>,
    pub(super) split: Option<Split>,
}

/// Working space of one thread.
#[derive(Debug, Clone)]
pub(super) struct TransferScratch {
    modes: ModesScratch,
    row: Vec<f64>,
    pub(super) contacts: ContactState,
    q: Vec<Complex<f64>>,
    f: Vec<Complex<f64>>,
    phi: Vec<Complex<f64>>,
    rate: Vec<Complex<f64>>,
    other: Vec<Complex<f64>>,
}

impl<'a> Transfers<'a> {
    pub(super) fn new(contacts: &'a Contacts<'a>, modes: Modes, driven: bool) -> Transfers<'a> {
        let chain = contacts.chain();
        Transfers {
            branches: Branches::of(contacts, &modes),
            contacts,
            root_mass: chain.mass.iter().map(|m| m.sqrt()).collect(),
            lossy: chain.losses.any(),
            driven,
            modes,
        }
    }

    pub(super) fn branches(&self) -> Option<&Branches> {
        self.branches.as_ref()
    }

    pub(super) fn scratch(&self) -> TransferScratch {
        let line = || vec![Complex::default(); self.modes.len()];
        TransferScratch {
            modes: self.modes.scratch(),
            row: Vec::new(),
            contacts: ContactState::default(),
            q: line(),
            f: line(),
            phi: line(),
            rate: line(),
            other: line(),
        }
    }

    /// All terms of the balance. The contacts of `scratch` are those at this instant.
    pub(super) fn evaluate(&self, at: Instant, scratch: &mut TransferScratch) -> Terms {
        let TransferScratch {
            modes: work,
            row,
            contacts: state,
            q,
            f,
            phi,
            rate,
            other,
        } = scratch;
        self.contacts.evaluate(at.t, at.x, at.v, state);
        self.contacts.evaluate_roots(state);
        let state = &*state;
        let (n, modes, contacts) = (at.v.len(), &self.modes, self.contacts);
        row.resize(n, 0.0);
        for ((q, root), v) in row.iter_mut().zip(&self.root_mass).zip(at.v) {
            *q = root * v;
        }
        modes.of_sites(row, work, q);
        contacts.push_all(&state.elastic, row);
        for (f, root) in row.iter_mut().zip(&self.root_mass) {
            *f /= root;
        }
        modes.of_sites(row, work, f);
        modes.of_contacts(&state.phi, work, phi);
        row.clear();
        let slopes = state.phi_slope.iter().zip(&state.closing);
        row.extend(slopes.map(|(slope, closing)| slope * closing));
        if contacts.offset == 1 {
            // The wall's own motion is an input.
            row[0] -= state.phi_slope[0] * state.wall_velocity;
        }
        modes.of_contacts(row, work, rate);

        let weight = |m: usize| self.modes.weight(m);
        let count = self.modes.len();
        let mut terms = Terms {
            energy: (0..count)
                .map(|m| weight(m) * (0.5 * q[m].norm_sqr() + phi[m].norm_sqr()))
                .collect(),
            transfer: (0..count)
                .map(|m| weight(m) * (dot(q[m], f[m]) + 2.0 * dot(phi[m], rate[m])))
                .collect(),
            ..Terms::default()
        };
        terms.split = self
            .branches
            .as_ref()
            .map(|branches| branches.split(q, f, phi, rate));
        if self.lossy {
            row.resize(n, 0.0);
            contacts.push_all(&state.damping, row);
            let drag = contacts.chain().losses.drag;
            for ((force, root), v) in row.iter_mut().zip(&self.root_mass).zip(at.v) {
                *force = (*force - drag * v) / root;
            }
            modes.of_sites(row, work, other);
            let loss = (0..count).map(|m| -weight(m) * dot(q[m], other[m]));
            terms.loss = loss.collect();
        }
        if self.driven {
            row.clear();
            row.resize(n, 0.0);
            row[0] = state.push / self.root_mass[0];
            modes.of_sites(row, work, other);
            let input = (0..count).map(|m| weight(m) * dot(q[m], other[m]));
            terms.input = input.collect();
            row.clear();
            row.resize(contacts.len(), 0.0);
            if contacts.offset == 1 {
                row[0] = state.phi_slope[0] * state.wall_velocity;
            }
            modes.of_contacts(row, work, other);
            for (m, input) in terms.input.iter_mut().enumerate() {
                *input += 2.0 * weight(m) * dot(phi[m], other[m]);
            }
        }
        terms
    }
}

/// `Re(conj(a) b)`.
#[inline]
pub(super) fn dot(a: Complex<f64>, b: Complex<f64>) -> f64 {
    a.re * b.re + a.im * b.im
}
