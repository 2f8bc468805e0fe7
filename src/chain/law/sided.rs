//! A law in compression alone.

use super::{ContactLaw, Law};
use crate::error::{Error, Result};
use crate::numeric::{Jet, Real};

/// `F = f(delta)` for `delta > 0`, else 0.
#[derive(Debug)]
pub(super) struct OneSided {
    law: Law,
    opens: f64,
}

impl OneSided {
    pub(super) fn new(law: Law) -> Result<OneSided> {
        // The power of a force that begins as one: the limit of `delta F' / F`.
        let at = f64::exp2(-100.0);
        let Jet { value, slope, .. } = law.jet(at);
        let opens = match law.jet(0.0).slope > 0.0 {
            true => 1.0,
            false => (at * slope / value * 1e3).round() / 1e3,
        };
        let grows = opens >= 1.0 && value >= 0.0;
        let expected = "a force that grows from 0 on, as a power of 1 or more of the overlap";
        Error::require(grows, "law", expected, format!("`{}`", law.text()))?;
        Ok(OneSided { law, opens })
    }
}

impl ContactLaw for OneSided {
    fn text(&self) -> String {
        format!("one-sided {}", self.law.text())
    }

    fn force(&self, delta: Jet) -> Jet {
        match delta.value > 0.0 {
            true => self.law.with(|law| law.force(delta)),
            false => Jet::constant(0.0),
        }
    }

    fn force_at(&self, delta: f64) -> f64 {
        match delta > 0.0 {
            true => self.law.with(|law| law.force_at(delta)),
            false => 0.0,
        }
    }

    fn opens(&self) -> Option<f64> {
        Some(self.opens)
    }

    fn unit(&self) -> String {
        self.law.coefficient_unit()
    }

    fn range(&self) -> [f64; 2] {
        [f64::NEG_INFINITY, self.law.range()[1]]
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        match d0 + r > 0.0 {
            true => self.law.force(1.0, d0, r),
            false => -self.force_at(d0),
        }
    }

    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        if d0 + r > 0.0 {
            return self.law.energy(1.0, d0, r);
        }
        // Up to the opening, and from there on against the static force alone.
        self.law.energy(1.0, d0, -d0) - self.force_at(d0) * (d0 + r)
    }
}
