//! Finding the localized waves of a dimer, order by order.

use super::dense::Matrix;
use super::fast::Oscillator;
use super::grid::Grid;
use super::problem::{Parameter, Problem, Root, Symmetry};
use super::series::Series;
use super::slow::{MOST_POINTS, SlowProfile, check_exponent, solitary, unresolved};
use super::wave::{Alternation, Wave};
use crate::{Error, Result};

/// Dimers that differ in their ratio only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Family {
    pub alternation: Alternation,
    /// p of `F = c delta^p`.
    pub exponent: f64,
}

impl Default for Family {
    /// Stiffness dimers of Hertz contacts.
    fn default() -> Family {
        Family {
            alternation: Alternation::Stiffness,
            exponent: 1.5,
        }
    }
}

/// How far a wave's numbers can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Convergence {
    /// Relative change of the ratio when the resolution is raised.
    pub resolution_change: f64,
    /// Relative change of the ratio when the period is made longer.
    pub period_change: f64,
    /// Largest residual of the integrated equations, relative to the largest overlap.
    pub residual: f64,
    /// Newton's steps on all grids together.
    pub iterations: usize,
    /// Largest amplitude in the last tenth of the spectrum, relative to the largest.
    pub spectral_tail: f64,
    /// Largest force in the outer twentieth of the period on each side, relative to the peak.
    pub tail: f64,
    /// Times in a period.
    pub points: usize,
    pub period: f64,
}

impl Convergence {
    /// Estimated relative error of the ratio.
    pub fn error(&self) -> f64 {
        self.resolution_change
            .max(self.period_change)
            .max(f64::EPSILON)
    }
}

/// The estimates and starting values of a family, from which its waves are found.
#[derive(Debug)]
pub struct Search {
    family: Family,
    slow: SlowProfile,
    fastest: f64,
    stiffenings: Vec<f64>,
}

impl Family {
    /// Asymptotic estimates of the ratios of orders 1 to `last` on the given slow wave.
    ///
    /// # Errors
    /// [`Error::Request`] for order 0 or a profile of another exponent, [`Error::Unresolved`] where
    /// the fast part is below rounding.
    pub fn estimates(&self, slow: &SlowProfile, last: usize) -> Result<Vec<f64>> {
        check_order(last)?;
        if slow.exponent != self.exponent {
            return Err(Error::Request {
                option: "exponent",
                expected: format!("the exponent of the slow wave, {}", slow.exponent),
                found: self.exponent.to_string(),
            });
        }
        let roots = Oscillator::new(self.alternation, slow).roots(last)?;
        Ok(roots.into_iter().map(|s| self.ratio(s)).collect())
    }

    /// Prepares to find the waves of orders 1 to `last`.
    ///
    /// # Errors
    /// [`Error::Request`] for order 0 or an exponent that is not above 1, [`Error::Unresolved`]
    /// where no starting values can be had.
    pub fn search(self, last: usize) -> Result<Search> {
        check_order(last)?;
        check_exponent(self.exponent)?;
        let slow = SlowProfile::exact(self.exponent)?;
        let oscillator = Oscillator::new(self.alternation, &slow);
        Ok(Search {
            family: self,
            fastest: oscillator.fastest(),
            stiffenings: oscillator.roots(last)?,
            slow,
        })
    }

    /// kappa or mu of a stiffening `kappa^{1/p}` or `1/mu`.
    fn ratio(&self, stiffening: f64) -> f64 {
        match self.alternation {
            Alternation::Stiffness => stiffening.powf(self.exponent),
            Alternation::Mass => 1.0 / stiffening,
        }
    }

    /// The equations on a grid; theta is the stiffening, less 1 for the mass dimer.
    fn problem(&self, grid: Grid) -> Problem {
        let n = grid.half + 1;
        let (plain, ahead, behind) = (grid.kernel(0.0), grid.kernel(0.5), grid.kernel(-0.5));
        match self.alternation {
            Alternation::Stiffness => {
                let both: Vec<f64> = ahead.iter().zip(&behind).map(|(a, b)| a + b).collect();
                let mut soft = Matrix::zeros(2 * n, 2 * n);
                grid.fill_even(&plain, 2.0, &mut soft, (0, 0));
                grid.fill_even(&both, -1.0, &mut soft, (0, n));
                let mut stiff = Matrix::zeros(2 * n, 2 * n);
                grid.fill_even(&both, -1.0, &mut stiff, (n, 0));
                grid.fill_even(&plain, 2.0, &mut stiff, (n, n));
                let unit = |j: usize| (0..2 * n).map(|i| f64::from(u8::from(i == j))).collect();
                let end = |j: usize| if j == 0 || j == n - 1 { 0.5 } else { 1.0 };
                let balance = (0..2 * n).map(|j| if j < n { end(j) } else { -end(j - n) });
                let scale = 1.0 / n as f64;
                Problem {
                    exponent: self.exponent,
                    constant: soft,
                    linear: Some(stiff),
                    block: n,
                    symmetry: Symmetry::Even,
                    on_values: vec![unit(n - 1), unit(2 * n - 1)],
                    on_forces: vec![balance.map(|w| scale * w).collect()],
                }
            }
            Alternation::Mass => {
                let m = 2 * grid.half;
                let mut linear = Matrix::zeros(m, m);
                grid.fill_full(&plain, 1.0, false, &mut linear);
                grid.fill_full(&behind, -1.0, true, &mut linear);
                let mut constant = Matrix::zeros(m, m);
                grid.fill_full(&plain, 2.0, false, &mut constant);
                grid.fill_full(&behind, -1.0, true, &mut constant);
                grid.fill_full(&ahead, -1.0, true, &mut constant);
                let mut end = vec![0.0; m];
                end[m - 1] = 1.0;
                Problem {
                    exponent: self.exponent,
                    constant,
                    linear: Some(linear),
                    block: m,
                    symmetry: Symmetry::None,
                    on_values: vec![end, grid.slope_at_end()],
                    on_forces: Vec::new(),
                }
            }
        }
    }

    /// Values of psi on a grid.
    fn sample(&self, grid: Grid, psi: &[Series; 2]) -> Vec<f64> {
        let half = grid.half as isize;
        match self.alternation {
            Alternation::Stiffness => psi
                .iter()
                .flat_map(|s| (0..=half).map(|j| s.value(grid.time(j))))
                .collect(),
            Alternation::Mass => (1 - half..=half)
                .map(|j| psi[0].value(grid.time(j)))
                .collect(),
        }
    }

    /// The reverse of [`Family::sample`].
    fn series(&self, grid: Grid, values: &[f64]) -> [Series; 2] {
        match self.alternation {
            Alternation::Stiffness => {
                let (soft, stiff) = values.split_at(grid.half + 1);
                [soft, stiff].map(|v| Series::even(grid.period, v))
            }
            Alternation::Mass => {
                let series = Series::full(grid.period, values);
                let mirrored = series.reversed();
                [series, mirrored]
            }
        }
    }
}

impl Search {
    /// The exact homogeneous wave that the estimates build on.
    pub fn slow(&self) -> &SlowProfile {
        &self.slow
    }

    /// The asymptotic estimate of a ratio.
    pub fn estimate(&self, order: usize) -> Option<f64> {
        let stiffening = self.stiffenings.get(order.checked_sub(1)?)?;
        Some(self.family.ratio(*stiffening))
    }

    /// The localized wave of an order, its ratio included.
    ///
    /// From the estimate, values at a held ratio come first, by Gauss and Newton's steps, then the
    /// ratio with them. Counting the maxima of the fast part tells which order was found; where it
    /// is another one, or none, other starts around the estimate are tried. Then the resolution is
    /// raised until the ratio stands, and the period made longer once.
    ///
    /// # Errors
    /// [`Error::Request`] for an order that was not prepared, [`Error::Unresolved`] where no start
    /// leads to a wave of this order.
    pub fn wave(&self, order: usize) -> Result<Wave> {
        let last = self.stiffenings.len();
        if order == 0 || order > last {
            return Err(Error::Request {
                option: "order",
                expected: format!("an order from 1 to {last}"),
                found: order.to_string(),
            });
        }
        if order == 1 {
            return self.homogeneous();
        }
        let centre = self.stiffenings[order - 1].sqrt();
        let spacing = centre - self.stiffenings[order - 2].sqrt();
        let mut found = "none".to_owned();
        for offset in OFFSETS {
            let start = centre + offset * spacing;
            let Some((grid, root)) = self.first(start * start) else {
                continue;
            };
            let wave = self.assemble(grid, &root, Changes::default());
            if wave.order == order {
                return self.refine(grid, root, order);
            }
            found = format!("one of order {} at the ratio {}", wave.order, wave.ratio);
        }
        Err(unresolved(
            "the localized wave",
            format!("a wave of order {order}"),
            found,
        ))
    }

    /// The wave of order 1: that of the homogeneous chain, at the ratio 1. (For the mass dimer this
    /// is a double root, since mu and 1/mu are one chain, so that Newton's steps do not end at it.)
    fn homogeneous(&self) -> Result<Wave> {
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

    /// A root on the coarsest grid.
    fn first(&self, stiffening: f64) -> Option<(Grid, Root)> {
        let fastest = self.fastest * stiffening.sqrt();
        let density = (LEAST_FREQUENCY + 2.0 * fastest) / std::f64::consts::PI;
        let density = density.max(self.slow.density());
        let grid = Grid::new(2.0 * self.slow.end(), density);
        if grid.half as f64 > MOST_POINTS {
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

    /// Raises the resolution until the ratio stands, then makes the period longer.
    fn refine(&self, mut grid: Grid, mut root: Root, order: usize) -> Result<Wave> {
        let mut changes = Changes {
            resolution: f64::INFINITY,
            ..Changes::default()
        };
        loop {
            let density = 2.0 * grid.half as f64 / grid.period;
            let finer = Grid::new(grid.period, 1.3 * density);
            if finer.half as f64 > MOST_POINTS {
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
            return Err(unresolved(
                "the localized wave",
                format!("a ratio of order {order} that stands when the resolution is raised"),
                format!(
                    "a relative change of {:e} at the last grid",
                    changes.resolution
                ),
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
        if wave.order != order {
            return Err(unresolved(
                "the localized wave",
                format!("a wave of order {order} at every resolution"),
                format!("one of order {}", wave.order),
            ));
        }
        Ok(wave)
    }

    /// The same root on another grid.
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
                format!("Newton's steps that converge at order {order}"),
                format!(
                    "none with {} times in a period of {}",
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

    fn theta(&self, stiffening: f64) -> f64 {
        match self.family.alternation {
            Alternation::Stiffness => stiffening,
            Alternation::Mass => stiffening - 1.0,
        }
    }

    fn stiffening(&self, theta: f64) -> f64 {
        match self.family.alternation {
            Alternation::Stiffness => theta,
            Alternation::Mass => theta + 1.0,
        }
    }

    fn assemble(&self, grid: Grid, root: &Root, changes: Changes) -> Wave {
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

/// Relative changes of the ratio.
#[derive(Default)]
struct Changes {
    resolution: f64,
    period: f64,
}

/// Relative change of the ratio at which the resolution is enough.
const GOAL: f64 = 1e-12;
/// Relative change of the ratio beyond which no digit that is promised stands.
const LARGEST_CHANGE: f64 = 1e-6;
const LONGER: f64 = 1.2;
/// Where to start, in orders from the estimate.
const OFFSETS: [f64; 9] = [0.0, -0.25, 0.25, -0.5, 0.5, -0.75, 0.75, -1.0, 1.0];
/// Steps at a held ratio, and Newton's steps at most.
const HELD: usize = 5;
const NEWTON: usize = 25;
/// Angular frequency that the coarsest grid resolves beyond the fast part's.
const LEAST_FREQUENCY: f64 = 35.0;

fn check_order(order: usize) -> Result<()> {
    if order > 0 {
        return Ok(());
    }
    Err(Error::Request {
        option: "order",
        expected: "an order of 1 or more".into(),
        found: order.to_string(),
    })
}
