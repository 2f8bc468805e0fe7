//! Continuation of a wave from Hertz contacts to another exponent.

use super::family::Family;
use super::grid::Grid;
use super::problem::{Parameter, Root};
use super::resolve::NEWTON;
use super::search::Search;

impl Search {
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
        let grid = {
            let stiffening = self.family.stiffening(self.estimate(order)?);
            let coarsest = self.coarsest(stiffening);
            let density = 2.0 * coarsest.half as f64 / coarsest.period;
            Grid::new(coarsest.period.max(known.convergence.period), density)
        };
        if grid.half > self.most_points {
            return None;
        }
        let mut theta = self.theta(family.stiffening(known.ratio));
        let mut values = family.sample(grid, &known.psi());
        let (mut step, mut slope, mut iterations) = (LONGEST, 0.0, known.convergence.iterations);
        while family.exponent != target {
            let left = target - family.exponent;
            let next = match left.abs() <= step {
                true => target,
                false => family.exponent + step * left.signum(),
            };
            let power = (family.exponent - 1.0) / (next - 1.0);
            let start: Vec<f64> = values.iter().map(|v| v.max(0.0).powf(power)).collect();
            let change = next - family.exponent;
            let ahead = Family {
                exponent: next,
                ..family
            };
            let found = (ahead.problem(grid))
                .iterate(Parameter::Free, &start, theta + slope * change, NEWTON)
                .filter(|root| root.converged && (root.theta / theta - 1.0).abs() < MOST_CHANGE);
            match found {
                Some(root) => {
                    slope = (root.theta - theta) / change;
                    iterations += root.iterations;
                    (family, theta, values) = (ahead, root.theta, root.values.clone());
                    if next == target {
                        let root = Root { iterations, ..root };
                        return Some((grid, root));
                    }
                }
                None if step > SHORTEST => step *= 0.5,
                None => return None,
            }
        }
        None
    }
}

const HERTZ: f64 = 1.5;
/// Longest and shortest steps of the exponent.
const LONGEST: f64 = 0.02;
const SHORTEST: f64 = 0.002;
/// A larger relative change of theta in a step is a jump to another order.
const MOST_CHANGE: f64 = 0.05;
