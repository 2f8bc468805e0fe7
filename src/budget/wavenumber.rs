//! Energy, transfer and losses by wavenumber, at one instant.
//!
//! `q_j = sqrt(m_j) v_j` and `phi_i = sign(r_i) sqrt(V_i)` turn the energy into a sum of squares,
//! which a unitary transform preserves: `E(k) = |q^|^2 / 2 + |phi^|^2`. Its rate of change is `T(k)
//! = Re(conj(q^) f^) + 2 Re(conj(phi^) phi'^)` with the elastic forces `f_j = (F_{j-1} - F_j) /
//! sqrt(m_j)`, `phi'_i = F_i r'_i / (2 phi_i)`, and springs to the ground as contacts at the sites,
//! and resonators as further sites and contacts there; less `L(k) = - Re(conj(q^) fd^)` with the forces of
//! dampers and drag; plus `I(k)`, the power of a driven end. `sum T = 0`: it is exchange between
//! wavenumbers, whatever the state.

use std::f64::consts::SQRT_2;

use num_complex::Complex;

use super::branches::{BranchSplit, Branches};
use super::contacts::{ContactState, Contacts};
use super::modes::{Modes, ModesScratch};
use crate::chain::NodeState;

/// Constants used at every instant.
pub(super) struct Transfers<'a> {
    pub(super) contacts: &'a Contacts<'a>,
    pub(super) modes: Modes,
    root_mass: Vec<f64>,
    /// Number of wavenumbers that a component counts.
    weights: Vec<f64>,
    lossy: bool,
    driven: bool,
    pub(super) branches: Option<Branches>,
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

/// A transformed row whose squares are energies, `factor |root|^2`, and its rate of change.
#[derive(Debug, Clone)]
struct Square {
    factor: f64,
    root: Vec<Complex<f64>>,
    rate: Vec<Complex<f64>>,
}

/// Working space of one thread.
#[derive(Debug, Clone)]
pub(super) struct TransferScratch {
    modes: ModesScratch,
    row: Vec<f64>,
    /// Squares of the sizes that transfers are differences of.
    size: Vec<f64>,
    /// Of the motion of sites, of contacts, then of [`Transfers::springs`].
    squares: Vec<Square>,
    springs: Vec<[Vec<f64>; 2]>,
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
        let chain = contacts.chain;
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

    pub(super) fn scratch(&self) -> TransferScratch {
        let line = || vec![Complex::default(); self.modes.len()];
        let chain = self.contacts.chain;
        let springs = usize::from(chain.on_site.ground.is_some())
            + 2 * usize::from(chain.resonators().is_some());
        let square = |i: usize| Square {
            factor: if i == 0 { 0.5 } else { 1.0 },
            root: line(),
            rate: line(),
        };
        TransferScratch {
            modes: self.modes.scratch(),
            row: Vec::new(),
            size: Vec::new(),
            squares: (0..2 + springs).map(square).collect(),
            springs: Vec::new(),
            other: line(),
        }
    }

    /// `E(k)` alone.
    pub(super) fn energies(&self, at: NodeState) -> Vec<f64> {
        let (mut scratch, mut state) = (self.scratch(), ContactState::default());
        self.contacts.evaluate(at, &mut state);
        self.contacts.evaluate_roots(&mut state);
        self.load_roots(at, &state, &mut scratch);
        let mut energies = vec![0.0; self.modes.len()];
        for Square { factor, root, .. } in &scratch.squares {
            for ((energy, weight), root) in energies.iter_mut().zip(&self.weights).zip(root) {
                *energy += weight * factor * root.norm_sqr();
            }
        }
        energies
    }

    /// All terms of the balance, with the contacts at this instant and the roots of their energies.
    pub(super) fn evaluate(
        &self,
        at: NodeState,
        state: &ContactState,
        scratch: &mut TransferScratch,
        terms: &mut Terms,
    ) {
        self.load_roots(at, state, scratch);
        self.load_rates(at, state, scratch);
        let (size, squares) = (&mut scratch.size, &scratch.squares);
        for row in [&mut terms.energy, &mut terms.transfer, size] {
            row.clear();
            row.resize(self.modes.len(), 0.0);
        }
        for Square { factor, root, rate } in squares {
            let out = terms.energy.iter_mut().zip(&mut terms.transfer);
            let out = out.zip(&mut *size).zip(&self.weights);
            for ((((energy, transfer), size), weight), (root, rate)) in
                out.zip(root.iter().zip(rate))
            {
                let (square, slope) = (root.norm_sqr(), 2.0 * factor * weight);
                *energy += weight * factor * square;
                *transfer += slope * dot(*root, *rate);
                *size += slope * slope * square * rate.norm_sqr();
            }
        }
        terms.rounding = reconcile(&mut terms.transfer, size);
        let branches = self.branches.as_ref();
        terms.split = branches.map(|branches| {
            let [sites, contacts] = [&squares[0], &squares[1]];
            branches.split([&sites.root, &sites.rate], [&contacts.root, &contacts.rate])
        });
        if self.lossy {
            self.losses(at, state, scratch, &mut terms.loss);
        }
        if self.driven {
            self.inputs(state, scratch, &mut terms.input);
        }
    }

    /// Roots of the energies of springs to the ground, of resonators' motions and of their springs, with their rates;
    /// one value a site.
    fn springs(&self, at: NodeState) -> Vec<[Vec<f64>; 2]> {
        let chain = self.contacts.chain;
        let mut all = Vec::new();
        if let Some(ground) = &chain.on_site.ground {
            let sites = at.x.iter().zip(at.v).enumerate();
            let roots = sites.map(|(j, (x, v))| {
                let (root, slope) = ground.spring(j).root_energy(*x);
                (root, slope * v)
            });
            all.push(<[_; 2]>::from(roots.unzip::<_, _, Vec<f64>, Vec<f64>>()));
        }
        if let Some(resonators) = chain.resonators() {
            let [y, w] = at.resonators;
            let push = |j: usize| match resonators.mass[j] > 0.0 {
                true => {
                    -resonators.force(j, y[j] - at.x[j], 0.0) / (2.0 * resonators.mass[j]).sqrt()
                }
                false => 0.0,
            };
            let grow = |j: usize| (0.5 * resonators.stiffness[j]).sqrt() * (w[j] - at.v[j]);
            let [moving, held] = resonators.root_energies(at.x, at.resonators);
            all.push([moving, (0..y.len()).map(push).collect()]);
            all.push([held, (0..y.len()).map(grow).collect()]);
        }
        all
    }

    fn load_roots(&self, at: NodeState, state: &ContactState, scratch: &mut TransferScratch) {
        let (work, row) = (&mut scratch.modes, &mut scratch.row);
        let (squares, springs) = (&mut scratch.squares, &mut scratch.springs);
        *springs = self.springs(at);
        row.clear();
        row.extend(self.root_mass.iter().zip(at.v).map(|(root, v)| root * v));
        self.modes.of_sites(row, work, &mut squares[0].root);
        self.modes
            .of_contacts(&state.phi, work, &mut squares[1].root);
        for (square, [root, _]) in squares[2..].iter_mut().zip(springs) {
            self.modes.of_sites(root, work, &mut square.root);
        }
    }

    fn load_rates(&self, at: NodeState, state: &ContactState, scratch: &mut TransferScratch) {
        let (work, row) = (&mut scratch.modes, &mut scratch.row);
        let (squares, springs) = (&mut scratch.squares, &scratch.springs);
        let (modes, contacts) = (&self.modes, self.contacts);
        contacts.push_all(&state.elastic, row);
        if let Some(ground) = &contacts.chain.on_site.ground {
            for (j, (f, x)) in row.iter_mut().zip(at.x).enumerate() {
                *f -= ground.spring(j).force(*x);
            }
        }
        if let Some(all) = contacts.chain.resonators() {
            let [y, _] = at.resonators;
            for (j, f) in row.iter_mut().enumerate() {
                *f += all.force(j, y[j] - at.x[j], 0.0);
            }
        }
        for (f, root) in row.iter_mut().zip(&self.root_mass) {
            *f /= root;
        }
        modes.of_sites(row, work, &mut squares[0].rate);
        row.clear();
        let slopes = state.phi_slope.iter().zip(&state.closing);
        row.extend(slopes.map(|(slope, closing)| slope * closing));
        if contacts.offset == 1 {
            // The wall's own motion is an input.
            row[0] -= state.phi_slope[0] * state.wall_velocity;
        }
        modes.of_contacts(row, work, &mut squares[1].rate);
        for (square, [_, rate]) in squares[2..].iter_mut().zip(springs) {
            modes.of_sites(rate, work, &mut square.rate);
        }
    }

    /// `L(k)`: what dampers and drag take from the sites, and the dashpots of resonators from these.
    fn losses(
        &self,
        at: NodeState,
        state: &ContactState,
        scratch: &mut TransferScratch,
        loss: &mut Vec<f64>,
    ) {
        let (work, row) = (&mut scratch.modes, &mut scratch.row);
        let (squares, other) = (&scratch.squares, &mut scratch.other);
        let chain = self.contacts.chain;
        row.resize(at.v.len(), 0.0);
        self.contacts.push_all(&state.damping, row);
        for ((force, root), v) in row.iter_mut().zip(&self.root_mass).zip(at.v) {
            *force = (*force - chain.losses.drag * v) / root;
        }
        let [_, w] = at.resonators;
        if let Some(all) = chain.resonators() {
            for (j, (force, root)) in row.iter_mut().zip(&self.root_mass).enumerate() {
                *force += all.force(j, 0.0, w[j] - at.v[j]) / root;
            }
        }
        self.modes.of_sites(row, work, other);
        loss.clear();
        loss.resize(self.weights.len(), 0.0);
        self.add_power(-1.0, [&squares[0].root, other], loss);
        if let Some(all) = chain.resonators() {
            let damped = |j: usize| match all.mass[j] > 0.0 {
                true => all.force(j, 0.0, w[j] - at.v[j]) / all.mass[j].sqrt(),
                false => 0.0,
            };
            row.clear();
            row.extend((0..w.len()).map(damped));
            self.modes.of_sites(row, work, other);
            // The square is the kinetic energy, half of that of `sqrt(m) w`.
            let moving = &squares[squares.len() - 2].root;
            self.add_power(SQRT_2, [moving, other], loss);
        }
    }

    /// `I(k)`: the power of the external force, and of a moving wall on its contact.
    fn inputs(&self, state: &ContactState, scratch: &mut TransferScratch, input: &mut Vec<f64>) {
        let (work, row) = (&mut scratch.modes, &mut scratch.row);
        let (squares, other) = (&scratch.squares, &mut scratch.other);
        let pushed = self.contacts.pushed();
        row.clear();
        row.resize(self.root_mass.len(), 0.0);
        row[pushed] = state.push / self.root_mass[pushed];
        self.modes.of_sites(row, work, other);
        input.clear();
        input.resize(self.weights.len(), 0.0);
        self.add_power(1.0, [&squares[0].root, other], input);
        row.clear();
        row.resize(self.contacts.len(), 0.0);
        if self.contacts.offset == 1 {
            row[0] = state.phi_slope[0] * state.wall_velocity;
        }
        self.modes.of_contacts(row, work, other);
        self.add_power(2.0, [&squares[1].root, other], input);
    }

    /// Adds `factor Re(conj(a) b)` of all wavenumbers that a component counts.
    fn add_power(&self, factor: f64, [a, b]: [&[Complex<f64>]; 2], out: &mut [f64]) {
        for ((out, weight), (a, b)) in out.iter_mut().zip(&self.weights).zip(a.iter().zip(b)) {
            *out += factor * weight * dot(*a, *b);
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
