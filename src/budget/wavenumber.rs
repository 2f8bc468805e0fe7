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
use super::modes::{Basis, Modes, ModesScratch};
use crate::chain::{Chain, NodeState};

/// Constants used at every instant.
pub(super) struct Transfers<'a> {
    pub(super) contacts: &'a Contacts<'a>,
    pub(super) modes: Modes,
    root_mass: Vec<f64>,
    /// Number of wavenumbers that a component counts.
    weights: Vec<f64>,
    lossy: bool,
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
    /// Squares of the sizes that transfers are differences of.
    size: Vec<f64>,
    /// Of [`Transfers::rows`].
    squares: Vec<Square>,
    other: Vec<Complex<f64>>,
}

impl<'a> Transfers<'a> {
    /// Spectra are split into the branches that the chain `stated` has.
    pub(super) fn new(contacts: &'a Contacts<'a>, stated: Option<&Chain>) -> Transfers<'a> {
        let chain = contacts.chain;
        let modes = Modes::new(Basis::of(chain.ends), chain.n_sites());
        Transfers {
            branches: stated.and_then(|stated| Branches::of(stated, &modes)),
            contacts,
            root_mass: chain.mass.iter().map(|m| m.sqrt()).collect(),
            weights: (0..modes.len()).map(|m| modes.weight(m)).collect(),
            lossy: chain.is_lossy(),
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
            size: Vec::new(),
            squares: (0..2 + springs).map(square).collect(),
            other: line(),
        }
    }

    /// `E(k)` alone.
    pub(super) fn energies(&self, at: NodeState) -> Vec<f64> {
        let (mut scratch, mut state) = (self.scratch(), ContactState::default());
        self.contacts.evaluate(at, &mut state);
        self.contacts.evaluate_roots(&mut state);
        self.load(at, &state, &mut scratch, false);
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
        self.load(at, state, scratch, true);
        let (size, squares) = (&mut scratch.size, &scratch.squares);
        let zero = |row: &mut Vec<f64>| {
            row.clear();
            row.resize(self.modes.len(), 0.0);
        };
        for row in [&mut terms.energy, &mut terms.transfer, &mut *size] {
            zero(row);
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
            zero(&mut terms.loss);
            self.losses(at, state, scratch, &mut terms.loss);
        }
        if self.contacts.drive.is_some() {
            zero(&mut terms.input);
            self.inputs(state, scratch, &mut terms.input);
        }
    }

    /// Rows whose squares are energies, with their rates: of the motion of sites, of contacts, of springs to the ground, of
    /// resonators' motions and of their springs; one value a site, or a contact.
    fn rows(&self, at: NodeState, state: &ContactState) -> Vec<[Vec<f64>; 2]> {
        let (contacts, chain) = (self.contacts, self.contacts.chain);
        let moving = self.root_mass.iter().zip(at.v);
        let mut pushed = vec![0.0; at.v.len()];
        contacts.push_all(&state.elastic, &mut pushed);
        let slopes = state.phi_slope.iter().zip(&state.closing);
        let mut growing: Vec<f64> = slopes.map(|(slope, closing)| slope * closing).collect();
        if contacts.offset == 1 {
            // The wall's own motion is an input.
            growing[0] -= state.phi_slope[0] * state.wall_velocity;
        }
        let mut springs = Vec::new();
        if let Some(ground) = &chain.on_site.ground {
            let sites = at.x.iter().zip(at.v).enumerate();
            let roots = sites.map(|(j, (x, v))| {
                pushed[j] -= ground.spring(j).force(*x);
                let (root, slope) = ground.spring(j).root_energy(*x);
                (root, slope * v)
            });
            springs.push(<[_; 2]>::from(roots.unzip::<_, _, Vec<f64>, Vec<f64>>()));
        }
        if let Some(all) = chain.resonators() {
            let [y, w] = at.resonators;
            let force = |j: usize| all.force(j, y[j] - at.x[j], 0.0);
            let each = pushed.iter_mut().enumerate();
            each.for_each(|(j, f)| *f += force(j));
            let push = |j: usize| match all.mass[j] > 0.0 {
                true => -force(j) / (2.0 * all.mass[j]).sqrt(),
                false => 0.0,
            };
            let grow = |j: usize| (0.5 * all.stiffness[j]).sqrt() * (w[j] - at.v[j]);
            let [moving, held] = all.root_energies(at.x, at.resonators);
            springs.push([moving, (0..y.len()).map(push).collect()]);
            springs.push([held, (0..y.len()).map(grow).collect()]);
        }
        let rates = pushed.iter().zip(&self.root_mass);
        let moving = [
            moving.map(|(root, v)| root * v).collect(),
            rates.map(|(f, root)| f / root).collect(),
        ];
        let mut all = vec![moving, [state.phi.clone(), growing]];
        all.append(&mut springs);
        all
    }

    /// Transforms the rows, of roots alone or with their rates.
    fn load(
        &self,
        at: NodeState,
        state: &ContactState,
        scratch: &mut TransferScratch,
        with_rates: bool,
    ) {
        let rows = self.rows(at, state);
        for (i, (square, rows)) in scratch.squares.iter_mut().zip(&rows).enumerate() {
            let rows = &rows[..1 + usize::from(with_rates)];
            for (row, out) in rows.iter().zip([&mut square.root, &mut square.rate]) {
                self.transform(i, row, &mut scratch.modes, out);
            }
        }
    }

    /// Components of a row of square i, of which one is over the contacts.
    fn transform(&self, i: usize, row: &[f64], work: &mut ModesScratch, out: &mut [Complex<f64>]) {
        match i {
            1 => self.modes.of_contacts(row, work, out),
            _ => self.modes.of_sites(row, work, out),
        }
    }

    /// `L(k)`: what dampers and drag take from the sites, and the dashpots of resonators from these.
    fn losses(
        &self,
        at: NodeState,
        state: &ContactState,
        scratch: &mut TransferScratch,
        loss: &mut [f64],
    ) {
        let (chain, [_, w]) = (self.contacts.chain, at.resonators);
        let resonators = chain.resonators();
        let own = |j: usize| resonators.map_or(0.0, |all| all.force(j, 0.0, w[j] - at.v[j]));
        let taken = |(j, root): (usize, &f64)| {
            let damping = self.contacts.push_on(j, &state.damping);
            (damping - chain.losses.drag * at.v[j]) / root + own(j) / root
        };
        let row: Vec<f64> = self.root_mass.iter().enumerate().map(taken).collect();
        self.add_power(-1.0, 0, &row, scratch, loss);
        if let Some(all) = resonators {
            let damped = |j: usize| match all.mass[j] > 0.0 {
                true => own(j) / all.mass[j].sqrt(),
                false => 0.0,
            };
            let row: Vec<f64> = (0..w.len()).map(damped).collect();
            // The square is the kinetic energy, half of that of `sqrt(m) w`.
            let moving = scratch.squares.len() - 2;
            self.add_power(SQRT_2, moving, &row, scratch, loss);
        }
    }

    /// `I(k)`: the power of the external force, and of a moving wall on its contact.
    fn inputs(&self, state: &ContactState, scratch: &mut TransferScratch, input: &mut [f64]) {
        let pushed = self.contacts.pushed();
        let mut row = vec![0.0; self.root_mass.len()];
        row[pushed] = state.push / self.root_mass[pushed];
        self.add_power(1.0, 0, &row, scratch, input);
        if self.contacts.offset == 1 {
            let mut row = vec![0.0; self.contacts.each.len()];
            row[0] = state.phi_slope[0] * state.wall_velocity;
            self.add_power(2.0, 1, &row, scratch, input);
        }
    }

    /// Adds `factor Re(conj(a) b)` of all wavenumbers that a component counts, a the root of square i, b of this row.
    fn add_power(
        &self,
        factor: f64,
        i: usize,
        row: &[f64],
        scratch: &mut TransferScratch,
        out: &mut [f64],
    ) {
        let (squares, other) = (&scratch.squares, &mut scratch.other);
        self.transform(i, row, &mut scratch.modes, other);
        let pairs = squares[i].root.iter().zip(other);
        for ((out, weight), (a, b)) in out.iter_mut().zip(&self.weights).zip(pairs) {
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
