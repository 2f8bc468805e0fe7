//! Roots of a wave and their continuation: the first one, from another exponent, to a finer resolution, to a longer period.

use super::equations::Grid;
use super::family::Family;
use super::problem::{Parameter, Problem, Root};
use super::search::Search;
use super::series::largest;
use super::slow::unresolved;
use super::wave::{Alternation, Convergence, Wave};
use crate::Result;

impl Search {
    /// The wave of order 1: that of the homogeneous chain, at the ratio 1, by scaling the slow wave
    /// to half its travel time and twice its inverse mass. (For the mass dimer this is a double root,
    /// since mu and 1/mu are the same chain. Newton's method does not converge to it.)
    pub(super) fn homogeneous(&self) -> Wave {
        let slow = &self.slow.series;
        let grid = Grid {
            half: slow.len(),
            period: 0.5 * slow.period(),
        };
        let scale = 2f64.powf(1.0 / (self.family.exponent - 1.0));
        let values = (self.family).sample(grid, |_, t| scale * slow.value(2.0 * t));
        let root = self.family.problem(grid).start(values, self.theta(1.0));
        self.assemble(grid, &root)
    }

    /// The coarsest grid on which a wave is searched for.
    fn coarsest(&self, stiffening: f64) -> Grid {
        let slow = &self.slow.series;
        let fastest = self.fastest * stiffening.sqrt();
        let density = (LEAST_FREQUENCY + 2.0 * fastest) / std::f64::consts::PI;
        let least = 2.0 * slow.len() as f64 / slow.period();
        Grid::new(slow.period(), density.max(least))
    }

    /// A root on the coarsest grid.
    pub(super) fn first(&self, stiffening: f64) -> Option<(Grid, Root)> {
        let grid = self.coarsest(stiffening);
        if grid.half > self.most_points {
            return None;
        }
        let (family, slow) = (&self.family, &self.slow);
        let values = family.sample(grid, |contact, t| match (family.alternation, contact) {
            (Alternation::Stiffness, 0) => slow.overlap(t),
            (Alternation::Stiffness, _) => {
                let force = 0.5 * (slow.force(t + 0.5) + slow.force(t - 0.5));
                force.powf(1.0 / family.exponent)
            }
            (Alternation::Mass, _) => slow.overlap(t - 0.25),
        });
        let (problem, theta) = (family.problem(grid), self.theta(stiffening));
        let held = problem.iterate(Parameter::Held, problem.start(values, theta), HELD)?;
        let root = problem.iterate(Parameter::Free, held, NEWTON)?;
        root.converged.then_some((grid, root))
    }

    /// Continues the wave of an order from the exponent 3/2, where its maxima are counted, to this
    /// family's exponent. `None` where even the shortest step fails, and for the exponent 3/2
    /// itself.
    ///
    /// Each step starts from an unchanged `psi^{p-1}`, which by scaling varies little with the
    /// exponent.
    pub(super) fn followed(&self, order: usize) -> Option<(Grid, Root)> {
        let target = self.family.exponent;
        let mut family = Family {
            exponent: HERTZ,
            ..self.family
        };
        if target == HERTZ {
            return None;
        }
        let known = family.search(order).ok()?.wave(order).ok()?;
        let coarsest = self.coarsest(self.family.stiffening(self.estimate(order)?));
        let period = coarsest.period.max(known.convergence.period);
        let grid = Grid::new(period, coarsest.density());
        if grid.half > self.most_points {
            return None;
        }
        let values = family.sample(grid, |contact, t| known.psi(contact, t));
        let theta = self.theta(family.stiffening(known.ratio));
        let mut root = family.problem(grid).start(values, theta);
        root.iterations = known.convergence.iterations;
        let (mut step, mut slope) = (LONGEST, 0.0);
        while family.exponent != target {
            let left = target - family.exponent;
            let next = match left.abs() <= step {
                true => target,
                false => family.exponent + step * left.signum(),
            };
            let (theta, change) = (root.theta, next - family.exponent);
            let power = (family.exponent - 1.0) / (next - 1.0);
            let start = root.values.iter().map(|v| v.max(0.0).powf(power));
            let ahead = Family {
                exponent: next,
                ..family
            };
            let problem = ahead.problem(grid);
            let theta_ahead = theta + slope * change;
            let found = onwards(&problem, start.collect(), theta_ahead, root.iterations);
            match found.filter(|it| (it.theta / theta - 1.0).abs() < MOST_CHANGE) {
                Some(found) => {
                    slope = (found.theta - theta) / change;
                    (family, root) = (ahead, found);
                }
                None if step > SHORTEST => step *= 0.5,
                None => return None,
            }
        }
        Some((grid, root))
    }

    /// Raises the resolution until the ratio converges, then extends the period once.
    pub(super) fn refine(&self, mut grid: Grid, mut root: Root, order: usize) -> Result<Wave> {
        let mut resolution_change = f64::INFINITY;
        loop {
            let finer = Grid::new(grid.period, 1.3 * grid.density());
            if finer.half > self.most_points {
                break;
            }
            let better = self.again(grid, &root, finer, order)?;
            let change = self.change(&root, &better);
            (grid, root) = (finer, better);
            let stalled = change < 1e-7 && change > 0.3 * resolution_change;
            let worst = change.max(resolution_change);
            resolution_change = if stalled { worst } else { change };
            if change < GOAL || stalled {
                break;
            }
        }
        if resolution_change > LARGEST_CHANGE {
            let found = match resolution_change {
                change if change.is_finite() => format!("a relative change of {change:.1e}"),
                _ => "a single resolution".to_owned(),
            };
            let found = format!(
                "{found} with up to {} grid points per half period",
                self.most_points
            );
            let expected =
                format!("a ratio of order {order} that converges as the resolution is raised");
            return Err(unresolved("the localized wave", expected, found));
        }
        let longer = Grid {
            half: (grid.half as f64 * LONGER).round() as usize,
            period: grid.period * LONGER,
        };
        let other = self.again(grid, &root, longer, order)?;
        let period_change = self.change(&root, &other);
        root.iterations = other.iterations;
        let mut wave = self.assemble(grid, &root);
        wave.convergence.resolution_change = resolution_change;
        wave.convergence.period_change = period_change;
        Ok(wave)
    }

    /// Solves for the same root on another grid.
    fn again(&self, from: Grid, root: &Root, to: Grid, order: usize) -> Result<Root> {
        let series = self.family.series(from, &root.values);
        let problem = self.family.problem(to);
        let values = self.family.sample(to, |i, t| series[i].value(t));
        let better = onwards(&problem, values, root.theta, root.iterations);
        better.ok_or_else(|| {
            let expected = format!("Newton's method to converge at order {order}");
            let (points, period) = (2 * to.half, to.period);
            let found = format!("no convergence with {points} grid points in a period of {period}");
            unresolved("the localized wave", expected, found)
        })
    }

    fn change(&self, a: &Root, b: &Root) -> f64 {
        let [a, b] = [a, b].map(|root| self.ratio(root));
        (a / b - 1.0).abs()
    }

    pub(super) fn ratio(&self, root: &Root) -> f64 {
        self.family.ratio(root.theta - self.theta(0.0))
    }

    /// The parameter of the equations.
    pub(super) fn theta(&self, stiffening: f64) -> f64 {
        match self.family.alternation {
            Alternation::Stiffness => stiffening,
            Alternation::Mass => stiffening - 1.0,
        }
    }

    /// The wave of a root, its changes with the grid left open.
    pub(super) fn assemble(&self, grid: Grid, root: &Root) -> Wave {
        let psi = self.family.series(grid, &root.values);
        let exponent = self.family.exponent;
        let forces = root.values.iter().map(|u| u.max(0.0).powf(exponent));
        let forces: Vec<f64> = forces.collect();
        let force = self.family.series(grid, &forces);
        let outer = (0..=50).map(|j| 0.5 * grid.period * (0.95 + 0.001 * f64::from(j)));
        let outer = outer.flat_map(|t| [force[0].value(t), force[1].value(t)]);
        let outer: Vec<f64> = outer.collect();
        let convergence = Convergence {
            resolution_change: 0.0,
            period_change: 0.0,
            residual: root.residual,
            iterations: root.iterations,
            spectral_tail: psi[0].spectral_tail().max(psi[1].spectral_tail()),
            tail: largest(&outer) / largest(&forces),
            points: 2 * grid.half,
            period: grid.period,
        };
        Wave::new(self.family, self.ratio(root), psi, force, convergence)
    }
}

/// The root next to values of a root elsewhere, which took so many iterations.
fn onwards(problem: &Problem, values: Vec<f64>, theta: f64, iterations: usize) -> Option<Root> {
    let mut start = problem.start(values, theta);
    start.iterations = iterations;
    let root = problem.iterate(Parameter::Free, start, NEWTON)?;
    root.converged.then_some(root)
}

/// Relative change of the ratio at which refinement ends.
const GOAL: f64 = 1e-12;
/// A larger relative change of the ratio means that refinement has not converged.
const LARGEST_CHANGE: f64 = 1e-6;
const LONGER: f64 = 1.2;
/// Most Gauss-Newton steps at a fixed ratio, and most Newton steps.
const HELD: usize = 5;
const NEWTON: usize = 25;
/// Angular frequency that the coarsest grid resolves beyond twice that of the fast part.
const LEAST_FREQUENCY: f64 = 35.0;
const HERTZ: f64 = 1.5;
/// Longest and shortest steps of the exponent.
const LONGEST: f64 = 0.02;
const SHORTEST: f64 = 0.002;
/// A larger relative change of theta in a step is a jump to another order.
const MOST_CHANGE: f64 = 0.05;
