//! Finding the localized waves of a family, order by order.

use super::equations::Grid;
use super::family::{Family, no_estimate};
use super::fast::Oscillator;
use super::problem::Root;
use super::slow::{MOST_POINTS, SlowWave, unresolved};
use super::wave::Wave;
use crate::{Error, Result};

/// The estimates and starting values of a family, from which its waves are found.
#[derive(Debug)]
pub struct Search {
    pub(super) family: Family,
    pub(super) slow: SlowWave,
    pub(super) fastest: f64,
    /// Estimated stiffenings of orders 1 to `last + 1`; fewer if the estimates end earlier.
    stiffenings: Vec<f64>,
    last: usize,
    pub(super) most_points: usize,
}

impl Search {
    pub(super) fn new(family: Family, slow: SlowWave, last: usize) -> Search {
        let oscillator = Oscillator::new(family.alternation, &slow);
        Search {
            family,
            fastest: oscillator.fastest(),
            stiffenings: oscillator.roots(last + 1),
            slow,
            last,
            most_points: MOST_POINTS,
        }
    }

    /// Limits grids to `most_points` points per half period (700 by default). Waves that need more
    /// points are found with a larger error, or not at all.
    pub fn with_most_points(self, most_points: usize) -> Search {
        Search {
            most_points,
            ..self
        }
    }

    /// The exact homogeneous wave on which the estimates are based.
    pub fn slow(&self) -> &SlowWave {
        &self.slow
    }

    /// The asymptotic estimate of a ratio; `None` for an order that was not prepared, or whose
    /// fast part is below rounding.
    pub fn estimate(&self, order: usize) -> Option<f64> {
        let index = order.checked_sub(1).filter(|_| order <= self.last)?;
        let stiffening = self.stiffenings.get(index)?;
        Some(self.family.ratio(*stiffening))
    }

    /// The localized wave of an order, including its ratio.
    ///
    /// Starting from the estimate, Gauss-Newton steps at a fixed ratio improve the values; Newton
    /// steps then solve for values and ratio together. The number of maxima of the fast part and
    /// the nearest estimate identify the order. If they do not both give this order, or no root is
    /// found, other starting ratios around the estimate are tried. The last resort is continuation
    /// in the exponent from the wave of Hertz contacts. Finally, the resolution is raised until the
    /// ratio converges, and the period is extended once.
    ///
    /// # Errors
    /// [`Error::Request`] for an order that was not prepared, [`Error::Unresolved`] where no start
    /// leads to a wave of this order.
    pub fn wave(&self, order: usize) -> Result<Wave> {
        let last = self.last;
        let expected = format!("an order from 1 to {last}");
        Error::require((1..=last).contains(&order), "order", expected, order)?;
        if order == 1 {
            return Ok(self.homogeneous());
        }
        if order > self.stiffenings.len() {
            return Err(no_estimate(order, self.stiffenings.len()));
        }
        let centre = self.stiffenings[order - 1].sqrt();
        let spacing = centre - self.stiffenings[order - 2].sqrt();
        let mut found = "none".to_owned();
        for offset in OFFSETS {
            let start = centre + offset * spacing;
            let Some((grid, root)) = self.first(start * start) else {
                continue;
            };
            let wave = self.assemble(grid, &root);
            let (maxima, nearest) = (wave.order, self.nearest(wave.ratio));
            if [maxima, nearest] == [order; 2] {
                return self.counted(grid, root, order);
            }
            let ratio = wave.ratio;
            found = format!(
                "one with {maxima} maxima at the ratio {ratio}, nearest to the estimate of order {nearest}"
            );
        }
        if let Some((grid, root)) = self.followed(order)
            && self.nearest(self.ratio(&root)) == order
        {
            let wave = self.refine(grid, root, order)?;
            return Ok(Wave { order, ..wave });
        }
        let expected = format!("a wave of order {order}");
        Err(unresolved("the localized wave", expected, found))
    }

    /// Refines a wave and counts its maxima again.
    fn counted(&self, grid: Grid, root: Root, order: usize) -> Result<Wave> {
        let wave = self.refine(grid, root, order)?;
        if wave.order == order {
            return Ok(wave);
        }
        let expected = format!("a wave of order {order} at every resolution");
        let found = format!("one of order {}", wave.order);
        Err(unresolved("the localized wave", expected, found))
    }

    /// The order of the estimate nearest to a ratio. Distances are taken in the square root of the
    /// stiffening, in which orders are almost equidistant.
    fn nearest(&self, ratio: f64) -> usize {
        let root = self.family.stiffening(ratio).sqrt();
        let far = |order: &usize| (self.stiffenings[order - 1].sqrt() - root).abs();
        let nearest = (1..=self.stiffenings.len()).min_by(|a, b| far(a).total_cmp(&far(b)));
        nearest.unwrap_or(0)
    }
}

/// Offsets of the starting points from the estimate, in orders.
const OFFSETS: [f64; 9] = [0.0, -0.25, 0.25, -0.5, 0.5, -0.75, 0.75, -1.0, 1.0];
