//! Families of dimers that differ only in their ratio, and estimates of the localized ratios.

use super::fast::Oscillator;
use super::search::Search;
use super::slow::{SlowWave, check_exponent, unresolved};
use super::wave::Alternation;
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
        if slow.exponent != self.exponent {
            return Err(Error::Request {
                option: "exponent",
                expected: format!("the exponent of the slow wave, {}", slow.exponent),
                found: self.exponent.to_string(),
            });
        }
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
        check_exponent(self.exponent)?;
        let slow = SlowWave::exact(self.exponent)?;
        Ok(Search::new(self, slow, last))
    }

    /// A search on a given slow wave; only its estimates are meaningful.
    pub(super) fn search_on(self, slow: SlowWave, last: usize) -> Search {
        Search::new(self, slow, last)
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
    if order > 0 {
        return Ok(());
    }
    Err(Error::Request {
        option: "order",
        expected: "an order of 1 or more".into(),
        found: order.to_string(),
    })
}

pub(super) fn no_estimate(order: usize, last: usize) -> Error {
    unresolved(
        "the asymptotic estimate",
        format!("a fast part above rounding at order {order}"),
        format!("rounding beyond order {last}"),
    )
}
