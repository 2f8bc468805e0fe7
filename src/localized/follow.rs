//! Continuation of a wave from Hertz contacts to another exponent.

use super::equations::Grid;
use super::family::Family;
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
            let mut start = problem.start(start.collect(), theta + slope * change);
            start.iterations = root.iterations;
            let found = problem.iterate(Parameter::Free, start, NEWTON);
            match found.filter(|it| it.converged && (it.theta / theta - 1.0).abs() < MOST_CHANGE) {
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
}

const HERTZ: f64 = 1.5;
/// Longest and shortest steps of the exponent.
const LONGEST: f64 = 0.02;
const SHORTEST: f64 = 0.002;
/// A larger relative change of theta in a step is a jump to another order.
const MOST_CHANGE: f64 = 0.05;
