//! A law in compression alone.

use std::sync::Arc;

use super::ContactLaw;
use crate::chain::lattice::refuse;
use crate::error::Result;

/// `F = f(delta)` for `delta > 0`, else 0.
#[derive(Debug)]
pub(super) struct OneSided {
    law: Arc<dyn ContactLaw>,
    opens: f64,
}

impl OneSided {
    pub(super) fn new(law: Arc<dyn ContactLaw>) -> Result<OneSided> {
        // The power of a force that begins as one: the limit of `delta F' / F`.
        let at = f64::exp2(-100.0);
        let force = law.force(at);
        let opens = match law.stiffness(0.0) > 0.0 {
            true => 1.0,
            false => (at * law.stiffness(at) / force * 1e3).round() / 1e3,
        };
        if !(opens >= 1.0 && force >= 0.0) {
            let expected = "a force that grows from 0 on, as a power of 1 or more of the overlap";
            return Err(refuse("law", expected, format!("`{}`", law.text())));
        }
        Ok(OneSided { law, opens })
    }
}

impl ContactLaw for OneSided {
    fn text(&self) -> String {
        format!("one-sided {}", self.law.text())
    }

    fn force(&self, delta: f64) -> f64 {
        if delta > 0.0 {
            self.law.force(delta)
        } else {
            0.0
        }
    }

    fn stiffness(&self, delta: f64) -> f64 {
        if delta > 0.0 {
            self.law.stiffness(delta)
        } else {
            0.0
        }
    }

    fn bend(&self, delta: f64) -> f64 {
        if delta > 0.0 {
            self.law.bend(delta)
        } else {
            0.0
        }
    }

    fn energy(&self, delta: f64) -> f64 {
        if delta > 0.0 {
            self.law.energy(delta)
        } else {
            0.0
        }
    }

    fn opens(&self) -> Option<f64> {
        Some(self.opens)
    }

    fn unit(&self) -> String {
        self.law.unit()
    }

    fn range(&self) -> [f64; 2] {
        [f64::NEG_INFINITY, self.law.range()[1]]
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        if d0 + r > 0.0 {
            self.law.excess_force(d0, r)
        } else {
            -self.force(d0)
        }
    }

    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        if d0 + r > 0.0 {
            return self.law.excess_energy(d0, r);
        }
        // Up to the opening, and from there on against the static force alone.
        self.law.excess_energy(d0, -d0) - self.force(d0) * (d0 + r)
    }
}
