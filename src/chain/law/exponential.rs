//! Exponential laws: Toda's and Morse's.
//!
//! Sources: M. Toda, J. Phys. Soc. Japan 22 (1967) 431; P. M. Morse, Physical Review 34 (1929) 57.

use super::ContactLaw;

/// `F = (e^x - 1) / b`, `x = b delta`. About a static overlap it is the same law, `e^{b d0}` times as stiff.
#[derive(Debug)]
pub(super) struct Toda {
    pub(super) steepness: f64,
}

impl ContactLaw for Toda {
    fn text(&self) -> String {
        format!("toda {}", self.steepness)
    }

    fn force(&self, delta: f64) -> f64 {
        (self.steepness * delta).exp_m1() / self.steepness
    }

    fn stiffness(&self, delta: f64) -> f64 {
        (self.steepness * delta).exp()
    }

    fn bend(&self, delta: f64) -> f64 {
        self.steepness * (self.steepness * delta).exp()
    }

    fn energy(&self, delta: f64) -> f64 {
        excess(self.steepness * delta) / (self.steepness * self.steepness)
    }

    fn unit(&self) -> String {
        "N/m".into()
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        self.stiffness(d0) * self.force(r)
    }

    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        self.stiffness(d0) * self.energy(r)
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

    fn force(&self, delta: f64) -> f64 {
        let excess = (self.steepness * delta).exp_m1();
        (1.0 + excess) * excess / self.steepness
    }

    fn stiffness(&self, delta: f64) -> f64 {
        let excess = (self.steepness * delta).exp_m1();
        (1.0 + excess) * (1.0 + 2.0 * excess)
    }

    fn bend(&self, delta: f64) -> f64 {
        let grown = (self.steepness * delta).exp();
        self.steepness * grown * (4.0 * grown - 1.0)
    }

    fn energy(&self, delta: f64) -> f64 {
        0.5 * ((self.steepness * delta).exp_m1() / self.steepness).powi(2)
    }

    fn unit(&self) -> String {
        "N/m".into()
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        let grown = (self.steepness * d0).exp();
        let excess = (self.steepness * r).exp_m1();
        grown * excess * (grown * (excess + 2.0) - 1.0) / self.steepness
    }

    /// With `u = e^{b r} - 1` and `s = e^{b d0}`, `V = [s^2 (u^2 / 2 + g) - s g] / b^2`, `g = u - b r`.
    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        let grown = (self.steepness * d0).exp();
        let (u, rest) = ((self.steepness * r).exp_m1(), excess(self.steepness * r));
        let whole = grown * grown * (0.5 * u * u + rest) - grown * rest;
        whole / (self.steepness * self.steepness)
    }
}
