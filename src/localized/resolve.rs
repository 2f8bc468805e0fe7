//! Grid convergence of a wave: the first root, a finer resolution, a longer period.

use super::convergence::Convergence;
use super::family::Family;
use super::grid::Grid;
use super::problem::{Parameter, Root};
use super::search::Search;
use super::slow::{solitary, unresolved};
use super::wave::{Alternation, Wave};
use crate::Result;

impl Search {
    /// The wave of order 1: that of the homogeneous chain, at the ratio 1. (For the mass dimer this
    /// is a double root, since mu and 1/mu are the same chain. Newton's method does not converge to
    /// it.)
    pub(super) fn homogeneous(&self) -> Result<Wave> {
        let series = solitary(self.family.exponent, 0.5, 1.0)?;
        let grid = Grid {
            half: series.len(),
            period: series.period(),
        };
        let values = self.family.sample(grid, &[series.clone(), series]);
        let theta = self.theta(1.0);
        let root = Root {
            residual: self.family.problem(grid).residual(&values, theta),
            values,
            theta,
            iterations: 0,
            converged: true,
        };
        Ok(self.assemble(grid, &root, Changes::default()))
    }

    /// The coarsest grid on which a wave is searched for.
    pub(super) fn coarsest(&self, stiffening: f64) -> Grid {
        let fastest = self.fastest * stiffening.sqrt();
        let density = (LEAST_FREQUENCY + 2.0 * fastest) / std::f64::consts::PI;
        Grid::new(2.0 * self.slow.end(), density.max(self.slow.density()))
    }

    /// A root on the coarsest grid.
    pub(super) fn first(&self, stiffening: f64) -> Option<(Grid, Root)> {
        let grid = self.coarsest(stiffening);
        if grid.half > self.most_points {
            return None;
        }
        let family = &self.family;
        let problem = family.problem(grid);
        let half = grid.half as isize;
        let slow = &self.slow;
        let values: Vec<f64> = match family.alternation {
            Alternation::Stiffness => {
                let soft = (0..=half).map(|j| slow.overlap(grid.time(j)));
                let stiff = (0..=half).map(|j| {
                    let t = grid.time(j);
                    let force = 0.5 * (slow.force(t + 0.5) + slow.force(t - 0.5));
                    force.powf(1.0 / family.exponent)
                });
                soft.chain(stiff).collect()
            }
            Alternation::Mass => (1 - half..=half)
                .map(|j| slow.overlap(grid.time(j) - 0.25))
                .collect(),
        };
        let theta = self.theta(stiffening);
        let held = problem.iterate(Parameter::Held, &values, theta, HELD)?;
        let mut root = problem.iterate(Parameter::Free, &held.values, theta, NEWTON)?;
        root.iterations += held.iterations;
        root.converged.then_some((grid, root))
    }

    /// Raises the resolution until the ratio converges, then extends the period once.
    pub(super) fn refine(
        &self,
        mut grid: Grid,
        mut root: Root,
        order: usize,
        identity: Identity,
    ) -> Result<Wave> {
        let mut changes = Changes {
            resolution: f64::INFINITY,
            ..Changes::default()
        };
        loop {
            let density = 2.0 * grid.half as f64 / grid.period;
            let finer = Grid::new(grid.period, 1.3 * density);
            if finer.half > self.most_points {
                break;
            }
            let better = self.again(grid, &root, finer, order)?;
            let change = self.change(&root, &better);
            let stalled = change < 1e-7 && change > 0.3 * changes.resolution;
            changes.resolution = if stalled {
                change.max(changes.resolution)
            } else {
                change
            };
            (grid, root) = (finer, better);
            if change < GOAL || stalled {
                break;
            }
        }
        if changes.resolution > LARGEST_CHANGE {
            let found = match changes.resolution {
                change if change.is_finite() => format!("a relative change of {change:.1e}"),
                _ => "a single resolution".to_owned(),
            };
            let most = self.most_points;
            return Err(unresolved(
                "the localized wave",
                format!("a ratio of order {order} that converges as the resolution is raised"),
                format!("{found} with up to {most} grid points per half period"),
            ));
        }
        let longer = Grid {
            half: (grid.half as f64 * LONGER).round() as usize,
            period: grid.period * LONGER,
        };
        let other = self.again(grid, &root, longer, order)?;
        changes.period = self.change(&root, &other);
        root.iterations = other.iterations;
        let wave = self.assemble(grid, &root, changes);
        if identity == Identity::Followed {
            return Ok(Wave { order, ..wave });
        }
        if wave.order != order {
            return Err(unresolved(
                "the localized wave",
                format!("a wave of order {order} at every resolution"),
                format!("one of order {}", wave.order),
            ));
        }
        Ok(wave)
    }

    /// Solves for the same root on another grid.
    fn again(&self, from: Grid, root: &Root, to: Grid, order: usize) -> Result<Root> {
        let values = self
            .family
            .sample(to, &self.family.series(from, &root.values));
        let problem = self.family.problem(to);
        match problem.iterate(Parameter::Free, &values, root.theta, NEWTON) {
            Some(mut better) if better.converged => {
                better.iterations += root.iterations;
                Ok(better)
            }
            _ => Err(unresolved(
                "the localized wave",
                format!("Newton's method to converge at order {order}"),
                format!(
                    "no convergence with {} grid points in a period of {}",
                    2 * to.half,
                    to.period
                ),
            )),
        }
    }

    fn change(&self, a: &Root, b: &Root) -> f64 {
        let [a, b] = [a, b].map(|root| self.family.ratio(self.stiffening(root.theta)));
        (a / b - 1.0).abs()
    }

    pub(super) fn theta(&self, stiffening: f64) -> f64 {
        match self.family.alternation {
            Alternation::Stiffness => stiffening,
            Alternation::Mass => stiffening - 1.0,
        }
    }

    pub(super) fn stiffening(&self, theta: f64) -> f64 {
        match self.family.alternation {
            Alternation::Stiffness => theta,
            Alternation::Mass => theta + 1.0,
        }
    }

    pub(super) fn assemble(&self, grid: Grid, root: &Root, changes: Changes) -> Wave {
        let Family {
            alternation,
            exponent,
        } = self.family;
        let psi = self.family.series(grid, &root.values);
        let forces: Vec<f64> = (root.values.iter())
            .map(|u| u.max(0.0).powf(exponent))
            .collect();
        let force = self.family.series(grid, &forces);
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let outer = (0..=50).map(|j| 0.5 * grid.period * (0.95 + 0.001 * f64::from(j)));
        let tail =
            largest(&mut outer.flat_map(|t| [force[0].value(t).abs(), force[1].value(t).abs()]))
                / largest(&mut forces.iter().copied());
        let convergence = Convergence {
            resolution_change: changes.resolution,
            period_change: changes.period,
            residual: root.residual,
            iterations: root.iterations,
            spectral_tail: psi[0].spectral_tail().max(psi[1].spectral_tail()),
            tail,
            points: 2 * grid.half,
            period: grid.period,
        };
        let ratio = self.family.ratio(self.stiffening(root.theta));
        Wave::new(alternation, exponent, ratio, psi, force, convergence)
    }
}

/// How the order of a wave was identified.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Identity {
    /// By counting the maxima of its fast part.
    Counted,
    /// By continuation from a wave of known order.
    Followed,
}

/// Relative changes of the ratio.
#[derive(Default)]
pub(super) struct Changes {
    resolution: f64,
    period: f64,
}

/// Relative change of the ratio at which refinement ends.
const GOAL: f64 = 1e-12;
/// A larger relative change of the ratio means that refinement has not converged.
const LARGEST_CHANGE: f64 = 1e-6;
const LONGER: f64 = 1.2;
/// Most Gauss-Newton steps at a fixed ratio, and most Newton steps.
const HELD: usize = 5;
pub(super) const NEWTON: usize = 25;
/// Angular frequency that the coarsest grid resolves beyond twice that of the fast part.
const LEAST_FREQUENCY: f64 = 35.0;
