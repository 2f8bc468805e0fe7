//! Families of dimers that differ only in their ratio, and estimates of the localized ratios.

use super::fast::Oscillator;
use super::search::Search;
use super::slow::{SlowWave, unresolved};
use super::wave::Alternation;
use crate::chain::{Chain, Law};
use crate::{Error, Result};

/// Dimers that differ in their ratio only.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
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

impl Family {
    /// Asymptotic estimates of the ratios of orders 1 to `last` on the given slow wave.
    ///
    /// # Errors
    /// [`Error::Request`] for order 0 or a profile of another exponent, [`Error::Unresolved`] where
    /// the fast part is below rounding.
    pub fn estimates(&self, slow: &SlowWave, last: usize) -> Result<Vec<f64>> {
        check_order(last)?;
        let expected = format!("the exponent of the slow wave, {}", slow.exponent);
        let is_so = slow.exponent == self.exponent;
        Error::require(is_so, "exponent", expected, self.exponent)?;
        let roots = Oscillator::new(self.alternation, slow).roots(last);
        if roots.len() < last {
            return Err(no_estimate(last, roots.len()));
        }
        Ok(roots.into_iter().map(|s| self.ratio(s)).collect())
    }

    /// Prepares to find the waves of orders 1 to `last`. An order without starting values is
    /// reported by [`Search::wave`].
    ///
    /// # Errors
    /// [`Error::Request`] for order 0 or an exponent that is not above 1, [`Error::Unresolved`]
    /// where the homogeneous chain's wave is too wide (exponents close to 1).
    pub fn search(self, last: usize) -> Result<Search> {
        check_order(last)?;
        Ok(Search::new(self, SlowWave::exact(self.exponent)?, last))
    }

    /// A dimer of so many cells, a free first site, a wall behind the last.
    pub(super) fn chain(&self, ratio: f64, cells: usize) -> Chain {
        let pair = |[a, b]: [f64; 2]| (0..2 * cells).map(move |j| if j % 2 == 0 { a } else { b });
        let law = match self.exponent {
            1.5 => Law::Hertz,
            exponent => Law::Power { exponent },
        };
        Chain {
            mass: pair(self.alternation.masses(ratio)).collect(),
            coefficient: pair(self.alternation.coefficients(ratio)).collect(),
            law: law.into(),
            ..Chain::dimer(2 * cells, 1.0)
        }
    }

    /// The ratio kappa or mu for a stiffening `kappa^{1/p}` or `1/mu`.
    pub(super) fn ratio(&self, stiffening: f64) -> f64 {
        match self.alternation {
            Alternation::Stiffness => stiffening.powf(self.exponent),
            Alternation::Mass => 1.0 / stiffening,
        }
    }

    /// The inverse of [`Family::ratio`].
    pub(super) fn stiffening(&self, ratio: f64) -> f64 {
        match self.alternation {
            Alternation::Stiffness => ratio.powf(1.0 / self.exponent),
            Alternation::Mass => 1.0 / ratio,
        }
    }
}

fn check_order(order: usize) -> Result<()> {
    Error::require(order > 0, "order", "an order of 1 or more", order)
}

pub(super) fn no_estimate(order: usize, last: usize) -> Error {
    unresolved(
        "the asymptotic estimate",
        format!("a fast part above rounding at order {order}"),
        format!("rounding beyond order {last}"),
    )
}
