//! Dispersion branches of a periodic lattice: frequencies of small waves on the static state.

use std::f64::consts::TAU;
use std::ops::Range;

use ndarray::{Array2, s};
use num_complex::Complex;

use super::lattice::all_are;
use super::{Chain, Ends};
use crate::error::{Error, Result};
use crate::numeric::hermitian::eigenvalues;
use crate::numeric::{median, sorted};

/// Bodies that a unit cell has at most.
const MOST_BODIES: usize = 16;
/// Relative difference of two masses or stiffnesses that count as the same.
const SAME: f64 = 1e-9;
/// Share of the bodies that may be defects of a lattice.
const DEFECTS: f64 = 0.1;

/// Why a chain has no dispersion branches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoBranches {
    /// The contacts have no stiffness at rest: a sonic vacuum.
    #[error(
        "the contacts have no stiffness at rest (a sonic vacuum), so small waves have no frequency"
    )]
    NoLinearLimit,
    /// Masses and stiffnesses do not repeat.
    #[error(
        "masses and stiffnesses do not repeat along the chain every {MOST_BODIES} bodies or less"
    )]
    NoCell,
}

/// The unit cell of an infinite lattice of bodies joined by linear springs.
///
/// `m_j u_j'' = c_j (u_{j+1} - u_j) - c_{j-1} (u_j - u_{j-1})`, where masses and stiffnesses
/// repeat every `p` bodies. Waves `u_j = A_j exp(i (q j - omega t))`, `A_{j+p} = A_j`, have `p`
/// frequencies at each phase q per body. They are the singular values of the matrix B (p contacts
/// by p bodies) with `B_{j,j} = -sqrt(c_j / m_j)`, `B_{j,j+1} = exp(i q) sqrt(c_j / m_{j+1})`,
/// since `B^H B` is the dynamical matrix; a spring k_j to the ground adds a row with `sqrt(k_j / m_j)`. A resonator of the mass
/// M_j and the stiffness K_j on body j adds a branch: a column, and a row with `-sqrt(K_j / m_j)` and `sqrt(K_j / M_j)`. With
/// one body alone `omega = 2 sqrt(c / m) |sin(q / 2)|`.
///
/// Units: q in rad per body; omega in rad per unit of time.
///
/// Source: L. Brillouin, *Wave Propagation in Periodic Structures* (1946); C. Kittel,
/// *Introduction to Solid State Physics*, chapter 4.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitCell {
    mass: Vec<f64>,
    /// Of the spring from each body to the next one; the last leads to the next cell.
    stiffness: Vec<f64>,
    /// Of the spring from each body to the ground.
    ground: Vec<f64>,
    /// Mass and stiffness of the resonator on each body; 0 is none.
    resonators: [Vec<f64>; 2],
}

impl UnitCell {
    /// A cell of these masses and stiffnesses.
    ///
    /// # Errors
    /// [`crate::Error::Request`] unless both have the same length, from 1 to 16, and all values are above
    /// 0 and finite.
    pub fn new(mass: Vec<f64>, stiffness: Vec<f64>) -> Result<UnitCell> {
        if mass.len() != stiffness.len() || !(1..=MOST_BODIES).contains(&mass.len()) {
            let expected = format!("as many masses as stiffnesses, 1 to {MOST_BODIES}");
            let found = format!("{} and {}", mass.len(), stiffness.len());
            return Err(Error::request("dispersion", &expected, found));
        }
        let above = ("dispersion", "masses and stiffnesses above 0");
        all_are(above, mass.iter().chain(&stiffness), |v| {
            v.is_finite() && v > 0.0
        })?;
        let none = || vec![0.0; mass.len()];
        Ok(UnitCell {
            ground: none(),
            resonators: [none(), none()],
            mass,
            stiffness,
        })
    }

    /// The smallest cell of which the chain, linearized about its static state, consists.
    ///
    /// At ends that do not repeat, the first and the last body and contact may differ. Where no
    /// cell fits all others, a tenth of them may be defects. Losses are left out.
    ///
    /// # Errors
    /// [`NoBranches`].
    pub fn of(chain: &Chain) -> std::result::Result<UnitCell, NoBranches> {
        let stiffness = chain.contacts().map(|contact| contact.stiffness(0.0));
        let stiffness: Vec<f64> = stiffness.collect();
        let is_linear = chain.contacts().all(|contact| contact.has_linear_limit());
        if !is_linear || stiffness.iter().any(|k| !(k.is_finite() && *k > 0.0)) {
            return Err(NoBranches::NoLinearLimit);
        }
        let none = || vec![0.0; chain.n_sites()];
        let ground = chain.on_site.ground.as_ref().map(|all| {
            let springs = (0..chain.n_sites()).map(|j| all.spring(j).stiffness(0.0));
            springs.collect()
        });
        let (own, tie) = match chain.resonators() {
            Some(all) => (all.mass.clone(), all.stiffness.clone()),
            None => (none(), none()),
        };
        let rows = [
            chain.mass.clone(),
            stiffness,
            ground.unwrap_or_else(none),
            own,
            tie,
        ];
        // Two whole cells at least, unless all is one cell of one body.
        let least = rows.iter().map(|row| chain.inner(row.len()).len()).min();
        let longest = (least.unwrap_or(0) / 2).clamp(1, MOST_BODIES);
        for defects in [0.0, DEFECTS] {
            for period in 1..=longest {
                let cells = rows.iter().map(|row| chain.cell(row, period, defects));
                let cells = cells.collect::<Option<Vec<_>>>().map(<[_; 5]>::try_from);
                if let Some(Ok([mass, stiffness, ground, own, tie])) = cells {
                    return Ok(UnitCell {
                        mass,
                        stiffness,
                        ground,
                        resonators: [own, tie],
                    });
                }
            }
        }
        Err(NoBranches::NoCell)
    }

    /// Bodies of the cell, without resonators.
    pub fn bodies(&self) -> usize {
        self.mass.len()
    }

    /// Branches: one a body and one a resonator.
    pub fn branches(&self) -> usize {
        let resonators = self.resonators[0].iter().filter(|mass| **mass > 0.0);
        self.bodies() + resonators.count()
    }

    /// Mass and stiffness of a cell of one body, without a spring to the ground or a resonator.
    pub fn uniform(&self) -> Option<(f64, f64)> {
        if self.branches() > self.bodies() {
            return None;
        }
        match (&self.mass[..], &self.stiffness[..], &self.ground[..]) {
            (&[mass], &[stiffness], &[0.0]) => Some((mass, stiffness)),
            _ => None,
        }
    }

    /// The same lattice with time in units that are `factor` times as long.
    #[must_use]
    pub fn with_time_unit(mut self, factor: f64) -> UnitCell {
        self.stiffness
            .iter_mut()
            .chain(&mut self.ground)
            .chain(&mut self.resonators[1])
            .for_each(|c| *c *= factor * factor);
        self
    }

    /// The frequencies omega of all branches at the phase q per body, ascending.
    pub fn frequencies(&self, phase: f64) -> Vec<f64> {
        let p = self.bodies();
        let turn = Complex::cis(phase % TAU);
        // Column by column: the contacts that each body moves, its spring to the ground, and that of its resonator.
        let mut columns = vec![vec![Complex::new(0.0, 0.0); 3 * p]; p];
        for (j, &stiffness) in self.ground.iter().enumerate() {
            columns[j][p + j] = Complex::new((stiffness / self.mass[j]).sqrt(), 0.0);
        }
        for (j, &stiffness) in self.stiffness.iter().enumerate() {
            let next = (j + 1) % p;
            columns[j][j] -= (stiffness / self.mass[j]).sqrt();
            columns[next][j] += turn * (stiffness / self.mass[next]).sqrt();
        }
        let [own, tie] = &self.resonators;
        for j in (0..p).filter(|j| own[*j] > 0.0) {
            let mut column = vec![Complex::new(0.0, 0.0); 3 * p];
            column[2 * p + j] += (tie[j] / own[j]).sqrt();
            columns[j][2 * p + j] -= (tie[j] / self.mass[j]).sqrt();
            columns.push(column);
        }
        singular_values(&columns)
    }
}

impl Chain {
    /// Of so many bodies or contacts those away from ends, where a striker or a wall may differ from the rest.
    pub(crate) fn inner(&self, count: usize) -> Range<usize> {
        let ends = usize::from(self.ends != Ends::Periodic).min(count);
        ends..count.saturating_sub(ends).max(ends)
    }

    /// One period of values along the chain, if all but a share of `defects` of those away from the ends repeat.
    pub(crate) fn cell(&self, values: &[f64], period: usize, defects: f64) -> Option<Vec<f64>> {
        let inner = self.inner(values.len());
        let class = |phase: usize| {
            let class = inner.clone().filter(|j| j % period == phase);
            median(class.map(|j| values[j]))
        };
        let cell: Vec<f64> = (0..period).map(class).collect::<Option<_>>()?;
        let differs = |j: &usize| (values[*j] - cell[j % period]).abs() > SAME * cell[j % period];
        let count = inner.clone().filter(differs).count();
        (count as f64 <= defects * inner.len() as f64).then_some(cell)
    }
}

/// Singular values of a matrix with as many rows as columns or more, ascending, each to rounding of the largest: with their
/// negatives they are the eigenvalues of the matrix beside its adjoint.
fn singular_values(columns: &[Vec<Complex<f64>>]) -> Vec<f64> {
    let (n, rows) = (columns.len(), columns[0].len());
    let all = columns.iter().flatten();
    // Added to the diagonal, so that no eigenvalue is negative.
    let size = all.map(Complex::norm_sqr).sum::<f64>().sqrt();
    let mut beside = Array2::from_diag_elem(n + rows, Complex::new(size, 0.0));
    for ((i, j), value) in beside.slice_mut(s![n.., ..n]).indexed_iter_mut() {
        *value = columns[j][i];
    }
    let values = eigenvalues(&beside).into_iter().take(n);
    sorted(values.map(|value| (value - size).max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::{Law, Laws};

    fn phases() -> impl Iterator<Item = f64> {
        (-40..=40).map(|n| 0.1 * f64::from(n))
    }

    /// `omega^2 = A/2 -+ sqrt(A^2/4 - 4 c1 c2 sin^2(q) / (m1 m2))`, `A = (c1 + c2)(1/m1 + 1/m2)`.
    #[test]
    fn val_kittel_branches_of_one_and_of_two_bodies() {
        let one = UnitCell::new(vec![0.5], vec![3.0]).unwrap();
        let ([m1, m2], [c1, c2]) = ([1.0, 2.5], [1.0, 4.9]);
        let cell = UnitCell::new(vec![m1, m2], vec![c1, c2]).unwrap();
        for q in phases() {
            let expected = 2.0 * 6.0f64.sqrt() * (0.5 * q).sin().abs();
            assert!((one.frequencies(q)[0] - expected).abs() < 1e-12, "{q}");
            let half = 0.5 * (c1 + c2) * (1.0 / m1 + 1.0 / m2);
            let rest = 4.0 * c1 * c2 * q.sin() * q.sin() / (m1 * m2);
            let optical = (half + (half * half - rest).sqrt()).sqrt();
            // Their product is exact where the difference of squares would cancel.
            let acoustic = rest.sqrt() / optical;
            let found = cell.frequencies(q);
            assert!((found[0] - acoustic).abs() < 1e-12, "{q}: {found:?}");
            assert!((found[1] - optical).abs() < 1e-12, "{q}: {found:?}");
        }
    }

    /// The trace of the dynamical matrix, and twice the same cell has the same branches, folded.
    #[test]
    fn squares_sum_to_the_trace_and_a_doubled_cell_folds() {
        let (mass, stiffness) = (vec![1.0, 0.3, 2.0, 1.1, 0.7], vec![2.0, 0.1, 1.0, 5.0, 0.9]);
        let cell = UnitCell::new(mass.clone(), stiffness.clone()).unwrap();
        let doubled = UnitCell::new(mass.repeat(2), stiffness.repeat(2)).unwrap();
        let trace: f64 = (0..5)
            .map(|j| (stiffness[j] + stiffness[(j + 4) % 5]) / mass[j])
            .sum();
        for q in phases() {
            let found = cell.frequencies(q);
            let sum: f64 = found.iter().map(|w| w * w).sum();
            assert!((sum / trace - 1.0).abs() < 1e-13, "{q}: {sum} {trace}");
            let mut folded = [found, cell.frequencies(q + TAU / 10.0)].concat();
            folded.sort_by(f64::total_cmp);
            for (a, b) in folded.iter().zip(doubled.frequencies(q)) {
                assert!((a - b).abs() < 1e-12, "{q}: {a} {b}");
            }
        }
        assert!(cell.frequencies(0.0)[0] < 1e-12);
    }

    #[test]
    fn cells_are_found_about_the_static_state() {
        let mut chain = Chain::dimer(40, 4.9);
        assert_eq!(UnitCell::of(&chain), Err(NoBranches::NoLinearLimit));
        chain.precompression = 0.5;
        chain.mass[0] = 7.0;
        let cell = UnitCell::of(&chain).unwrap();
        // F = c d^1.5, so dF/dd = 1.5 c^(2/3) F^(1/3).
        let slope = |c: f64| 1.5 * c.powf(2.0 / 3.0) * 0.5f64.cbrt();
        assert_eq!(cell.bodies(), 2);
        for (found, c) in cell.stiffness.iter().zip([1.0, 4.9]) {
            assert!((found / slope(c) - 1.0).abs() < 1e-14, "{found}");
        }
        chain.mass[11] = 3.0;
        assert_eq!(UnitCell::of(&chain).unwrap(), cell, "a defect");
        chain.law = Laws::from(Law::Spring {
            alpha: 0.2,
            beta: 0.0,
        });
        chain.coefficient = (0..40).map(f64::from).map(|j| 1.0 + j).collect();
        assert_eq!(UnitCell::of(&chain), Err(NoBranches::NoCell));
    }

    #[test]
    fn cells_that_are_none_are_refused() {
        assert!(UnitCell::new(vec![], vec![]).is_err());
        assert!(UnitCell::new(vec![1.0], vec![-1.0]).is_err());
        assert!(UnitCell::new(vec![1.0], vec![1.0, 1.0]).is_err());
    }
}
