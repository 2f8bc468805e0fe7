//! Exponential laws: Toda's and Morse's.
//!
//! Sources: M. Toda, J. Phys. Soc. Japan 22 (1967) 431; P. M. Morse, Physical Review 34 (1929) 57.

use super::ContactLaw;
use crate::numeric::{Jet, Real};

/// `F = (e^x - 1) / b`, `x = b delta`. About a static overlap it is the same law, `e^{b d0}` times as stiff.
#[derive(Debug)]
pub(super) struct Toda {
    pub(super) steepness: f64,
}

impl ContactLaw for Toda {
    fn text(&self) -> String {
        format!("toda {}", self.steepness)
    }

    fn force(&self, delta: Jet) -> Jet {
        let b = Jet::constant(self.steepness);
        (b * delta).exp_m1() / b
    }

    fn unit(&self) -> String {
        "N/m".into()
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        (self.steepness * d0).exp() * self.force_at(r)
    }

    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        let grown = (self.steepness * d0).exp();
        grown * excess(self.steepness * r) / (self.steepness * self.steepness)
    }
}

/// `e^x - 1 - x`, by its series where the difference would cancel.
fn excess(x: f64) -> f64 {
    if x.abs() > 0.5 {
        return x.exp_m1() - x;
    }
    let mut term = 0.5 * x * x;
    let mut sum = term;
    for n in 3..18 {
        term *= x / n as f64;
        sum += term;
    }
    sum
}

/// `F = e^x (e^x - 1) / b`, `x = b delta`.
#[derive(Debug)]
pub(super) struct Morse {
    pub(super) steepness: f64,
}

impl ContactLaw for Morse {
    fn text(&self) -> String {
        format!("morse {}", self.steepness)
    }

    fn force(&self, delta: Jet) -> Jet {
        let b = Jet::constant(self.steepness);
        let excess = (b * delta).exp_m1();
        (Jet::constant(1.0) + excess) * excess / b
    }

    fn unit(&self) -> String {
        "N/m".into()
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        let grown = (self.steepness * d0).exp();
        let excess = (self.steepness * r).exp_m1();
        grown * excess * (grown * (excess + 2.0) - 1.0) / self.steepness
    }

    /// With `u = e^{b r} - 1` and `s = e^{b d0}`, `V = [s (s - 1) g + s^2 u^2 / 2] / b^2`, `g = u - b r`.
    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        let (excess_d0, u) = (
            (self.steepness * d0).exp_m1(),
            (self.steepness * r).exp_m1(),
        );
        let grown = 1.0 + excess_d0;
        let whole = grown * (excess_d0 * excess(self.steepness * r) + 0.5 * grown * u * u);
        whole / (self.steepness * self.steepness)
    }
}
