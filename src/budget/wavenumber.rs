//! Energy, transfer and losses by wavenumber, at one instant.
//!
//! `q_j = sqrt(m_j) v_j` and `phi_i = sign(r_i) sqrt(V_i)` turn the energy into a sum of squares,
//! which a unitary transform preserves: `E(k) = |q^|^2 / 2 + |phi^|^2`. Its rate of change is `T(k)
//! = Re(conj(q^) f^) + 2 Re(conj(phi^) phi'^)` with the elastic forces `f_j = (F_{j-1} - F_j) /
//! sqrt(m_j)`, `phi'_i = F_i r'_i / (2 phi_i)`, and springs to the ground as contacts at the sites,
//! and resonators as further sites and contacts there; less `L(k) = - Re(conj(q^) fd^)` with the forces of
//! dampers and drag; plus `I(k)`, the power of a driven end. `sum T = 0`: it is exchange between
//! wavenumbers, whatever the state.

use num_complex::Complex;

use super::branches::{BranchSplit, Branches};
use super::contacts::{ContactState, Contacts};
use super::modes::{Modes, ModesScratch};
use super::motion::ChainState;
use crate::chain::{Ground, Resonators};

/// Scratch and constants used at every instant.
#[derive(Debug)]
pub(super) struct Transfers<'a> {
    pub(super) contacts: &'a Contacts<'a>,
    pub(super) modes: Modes,
    root_mass: Vec<f64>,
    /// Number of wavenumbers that a component counts.
    weights: Vec<f64>,
    lossy: bool,
    driven: bool,
    branches: Option<Branches>,
}

/// The terms of the balance, one value for each component with both signs of k; terms that a chain
/// lacks are empty.
#[derive(Debug, Clone, Default)]
pub(super) struct Terms {
    pub(super) energy: Vec<f64>,
    pub(super) transfer: Vec<f64>,
    pub(super) loss: Vec<f64>,
    pub(super) input: Vec<f64>,
    pub(super) split: Option<BranchSplit>,
    /// `sum T` as computed, relative to the size of its terms.
    pub(super) rounding: f64,
}

/// Working space of one thread.
#[derive(Debug, Clone)]
pub(super) struct TransferScratch {
    modes: ModesScratch,
    row: Vec<f64>,
    /// Squares of the sizes that transfers are differences of.
    size: Vec<f64>,
    pub(super) contacts: ContactState,
    q: Vec<Complex<f64>>,
    f: Vec<Complex<f64>>,
    phi: Vec<Complex<f64>>,
    rate: Vec<Complex<f64>>,
    other: Vec<Complex<f64>>,
}

impl<'a> Transfers<'a> {
    /// With `branches`, spectra are split into them.
    pub(super) fn new(
        contacts: &'a Contacts<'a>,
        modes: Modes,
        branches: Option<Branches>,
        driven: bool,
    ) -> Transfers<'a> {
        let chain = contacts.chain();
        Transfers {
            branches,
            contacts,
            root_mass: chain.mass.iter().map(|m| m.sqrt()).collect(),
            weights: (0..modes.len()).map(|m| modes.weight(m)).collect(),
            lossy: chain.is_lossy(),
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
            size: Vec::new(),
            contacts: ContactState::default(),
            q: line(),
            f: line(),
            phi: line(),
            rate: line(),
            other: line(),
        }
    }

    /// All terms of the balance. The contacts of `scratch` are those at this instant.
    pub(super) fn evaluate(
        &self,
        at: ChainState,
        scratch: &mut TransferScratch,
        terms: &mut Terms,
    ) {
        let TransferScratch {
            modes: work,
            row,
            size,
            contacts: state,
            q,
            f,
            phi,
            rate,
            other,
        } = scratch;
        self.contacts.evaluate(at, state);
        self.contacts.evaluate_roots(state);
        let state = &*state;
        let (n, modes, contacts) = (at.v.len(), &self.modes, self.contacts);
        row.resize(n, 0.0);
        for ((q, root), v) in row.iter_mut().zip(&self.root_mass).zip(at.v) {
            *q = root * v;
        }
        modes.of_sites(row, work, q);
        contacts.push_all(&state.elastic, row);
        let ground = contacts.chain().on_site.ground.as_ref();
        if let Some(ground) = ground {
            for (j, (f, x)) in row.iter_mut().zip(at.x).enumerate() {
                *f -= ground.force(j, *x);
            }
        }
        let resonators = contacts.chain().resonators();
        if let Some(all) = resonators {
            let [y, _] = at.resonators;
            for (j, f) in row.iter_mut().enumerate() {
                *f += all.force(j, y[j] - at.x[j], 0.0);
            }
        }
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

        let Terms {
            energy,
            transfer,
            loss,
            input,
            split,
            rounding,
        } = terms;
        for row in [&mut *energy, transfer] {
            row.resize(self.modes.len(), 0.0);
        }
        size.resize(self.modes.len(), 0.0);
        let parts = q.iter().zip(&*f).zip(phi.iter().zip(&*rate));
        let out = energy.iter_mut().zip(&mut *transfer).zip(&mut *size);
        for ((((energy, transfer), size), weight), ((q, f), (phi, rate))) in
            out.zip(&self.weights).zip(parts)
        {
            let (kinetic, held) = (q.norm_sqr(), phi.norm_sqr());
            *energy = weight * (0.5 * kinetic + held);
            *transfer = weight * (dot(*q, *f) + 2.0 * dot(*phi, *rate));
            *size = weight * weight * (kinetic * f.norm_sqr() + 4.0 * held * rate.norm_sqr());
        }
        if let Some(ground) = ground {
            self.add_ground(ground, at, work, [&mut *energy, &mut *transfer, &mut *size]);
        }
        if let Some(all) = resonators {
            self.add_resonators(all, at, work, [energy, transfer, size]);
        }
        *rounding = reconcile(transfer, size);
        *split = self
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
            if let Some(all) = resonators {
                let [_, w] = at.resonators;
                for (j, (force, root)) in row.iter_mut().zip(&self.root_mass).enumerate() {
                    *force += all.force(j, 0.0, w[j] - at.v[j]) / root;
                }
            }
            modes.of_sites(row, work, other);
            let parts = self.weights.iter().zip(q.iter().zip(&*other));
            loss.clear();
            loss.extend(parts.map(|(weight, (q, damped))| -weight * dot(*q, *damped)));
            if let Some(all) = resonators {
                self.add_resonator_losses(all, at, work, loss);
            }
        }
        if self.driven {
            row.clear();
            row.resize(n, 0.0);
            let pushed = contacts.pushed();
            row[pushed] = state.push / self.root_mass[pushed];
            modes.of_sites(row, work, other);
            let parts = self.weights.iter().zip(q.iter().zip(&*other));
            input.clear();
            input.extend(parts.map(|(weight, (q, push))| weight * dot(*q, *push)));
            row.clear();
            row.resize(contacts.len(), 0.0);
            if contacts.offset == 1 {
                row[0] = state.phi_slope[0] * state.wall_velocity;
            }
            modes.of_contacts(row, work, other);
            let parts = self.weights.iter().zip(phi.iter().zip(&*other));
            for (input, (weight, (phi, moved))) in input.iter_mut().zip(parts) {
                *input += 2.0 * weight * dot(*phi, *moved);
            }
        }
    }
}

impl Transfers<'_> {
    /// Adds the springs to the ground: their energies are squares at the sites.
    fn add_ground(
        &self,
        ground: &Ground,
        at: ChainState,
        work: &mut ModesScratch,
        [energy, transfer, size]: [&mut Vec<f64>; 3],
    ) {
        let roots = at.x.iter().enumerate();
        let roots = roots.map(|(j, x)| ground.root_energy(j, *x));
        let (root, slope): (Vec<f64>, Vec<f64>) = roots.unzip();
        let rate: Vec<f64> = slope.iter().zip(at.v).map(|(slope, v)| slope * v).collect();
        let line = || vec![Complex::default(); self.modes.len()];
        let (mut held, mut grown) = (line(), line());
        self.modes.of_sites(&root, work, &mut held);
        self.modes.of_sites(&rate, work, &mut grown);
        let out = energy.iter_mut().zip(transfer).zip(size);
        let parts = held.iter().zip(&grown).zip(&self.weights);
        for (((energy, transfer), size), ((held, grown), weight)) in out.zip(parts) {
            *energy += weight * held.norm_sqr();
            *transfer += 2.0 * weight * dot(*held, *grown);
            *size += 4.0 * weight * weight * held.norm_sqr() * grown.norm_sqr();
        }
    }
}

impl Transfers<'_> {
    /// Adds resonators: their velocities are rows of sites, the energies of their springs squares there.
    fn add_resonators(
        &self,
        all: &Resonators,
        at: ChainState,
        work: &mut ModesScratch,
        [energy, transfer, size]: [&mut Vec<f64>; 3],
    ) {
        let [y, w] = at.resonators;
        let n = at.x.len();
        let pull = |j: usize| all.force(j, y[j] - at.x[j], 0.0);
        let push = |j: usize| match all.mass[j] > 0.0 {
            true => -pull(j) / (2.0 * all.mass[j]).sqrt(),
            false => 0.0,
        };
        let grow = |j: usize| (0.5 * all.stiffness[j]).sqrt() * (w[j] - at.v[j]);
        let rates = [
            (0..n).map(push).collect::<Vec<_>>(),
            (0..n).map(grow).collect(),
        ];
        let line = || vec![Complex::default(); self.modes.len()];
        let (mut root, mut rate) = (line(), line());
        for (roots, rates) in all.root_energies(at.x, at.resonators).iter().zip(&rates) {
            self.modes.of_sites(roots, work, &mut root);
            self.modes.of_sites(rates, work, &mut rate);
            let out = energy.iter_mut().zip(&mut *transfer).zip(&mut *size);
            let parts = root.iter().zip(&rate).zip(&self.weights);
            for (((energy, transfer), size), ((root, rate), weight)) in out.zip(parts) {
                *energy += weight * root.norm_sqr();
                *transfer += 2.0 * weight * dot(*root, *rate);
                *size += 4.0 * weight * weight * root.norm_sqr() * rate.norm_sqr();
            }
        }
    }

    /// Adds what their dashpots take from the resonators themselves.
    fn add_resonator_losses(
        &self,
        all: &Resonators,
        at: ChainState,
        work: &mut ModesScratch,
        loss: &mut [f64],
    ) {
        let [_, w] = at.resonators;
        let n = at.x.len();
        let root = |j: usize| all.mass[j].sqrt();
        let momentum: Vec<f64> = (0..n).map(|j| root(j) * w[j]).collect();
        let damped = |j: usize| match all.mass[j] > 0.0 {
            true => all.force(j, 0.0, w[j] - at.v[j]) / root(j),
            false => 0.0,
        };
        let damped: Vec<f64> = (0..n).map(damped).collect();
        let line = || vec![Complex::default(); self.modes.len()];
        let (mut q, mut f) = (line(), line());
        self.modes.of_sites(&momentum, work, &mut q);
        self.modes.of_sites(&damped, work, &mut f);
        for ((loss, weight), (q, f)) in loss.iter_mut().zip(&self.weights).zip(q.iter().zip(&f)) {
            *loss += weight * dot(*q, *f);
        }
    }
}

/// Sums of transfers this small, over the size of their terms, are rounding.
const ROUNDING: f64 = 1e-13;

/// Removes rounding from the transfers, whose exact sum is 0; returns the removed sum relative to
/// the root of the sum of squares of the products that they are differences of.
///
/// A wave that keeps its shape exchanges next to nothing, a thousandth of the power in its
/// contacts, and products of that power round. The result is the least-squares projection onto
/// transfers of sum 0, in units of each one's rounding. A sum that rounding does not explain is
/// left unchanged, so that the residual shows it.
fn reconcile(transfer: &mut [f64], squares: &[f64]) -> f64 {
    let (sum, total) = (crate::numeric::sum(transfer), crate::numeric::sum(squares));
    if sum == 0.0 || total == 0.0 {
        return 0.0;
    }
    let share = sum.abs() / total.sqrt();
    if share < ROUNDING {
        for (transfer, square) in transfer.iter_mut().zip(squares) {
            *transfer -= sum * (square / total);
        }
    }
    share
}

/// `Re(conj(a) b)`.
#[inline]
pub(super) fn dot(a: Complex<f64>, b: Complex<f64>) -> f64 {
    a.re * b.re + a.im * b.im
}
