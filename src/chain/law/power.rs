//! Powers of the overlap, one-sided and two-sided.

use super::ContactLaw;
use super::kernel::{Hertz, Kernel, Power, PressedHertz};
use crate::numeric::{Jet, Real};

/// Excess energy of a one-sided contact at the overlap `d0 + r`.
fn energy(p: f64, d0: f64, r: f64) -> f64 {
    if d0 == 0.0 {
        let d = r.max(0.0);
        return Power { exponent: p }.force_at(d) * d / (p + 1.0);
    }
    let static_force = d0.powf(p);
    if d0 + r <= 0.0 {
        return static_force * (-r - d0 / (p + 1.0));
    }
    static_force * d0 * power_excess(p, r / d0)
}

/// `[(1 + q)^{p+1} - 1] / (p + 1) - q`, by its series where the difference would cancel.
fn power_excess(p: f64, q: f64) -> f64 {
    if q.abs() > 1e-2 {
        return ((p + 1.0) * q.ln_1p()).exp_m1() / (p + 1.0) - q;
    }
    let mut term = 0.5 * p * q * q;
    let mut sum = term;
    for n in 3..10 {
        term *= (p - (n - 2) as f64) * q / n as f64;
        sum += term;
    }
    sum
}

impl ContactLaw for Power {
    fn text(&self) -> String {
        format!("power {}", self.exponent)
    }

    fn force(&self, delta: Jet) -> Jet {
        match delta.value > 0.0 {
            true => delta.power(self.exponent),
            false => Jet::constant(0.0),
        }
    }

    fn opens(&self) -> Option<f64> {
        Some(self.exponent)
    }

    fn unit(&self) -> String {
        format!("N/m^{}", self.exponent)
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        match self.exponent == 1.5 {
            true if d0 == 0.0 => Kernel::force(&Hertz, 0, 1.0, d0, r),
            true => Kernel::force(&PressedHertz, 0, 1.0, d0, r),
            false => Kernel::force(self, 0, 1.0, d0, r),
        }
    }

    /// For the power 3/2, with the roots `s0` and `s` of both overlaps, a polynomial of `s0` and of `u = s - s0 = r / (s + s0)`.
    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        if self.exponent != 1.5 || d0 == 0.0 || d0 + r <= 0.0 {
            return energy(self.exponent, d0, r);
        }
        let s0 = d0.sqrt();
        let u = r / ((d0 + r).sqrt() + s0);
        0.4 * u * u * (s0 * s0 * (7.5 * s0 + 10.0 * u) + u * u * (5.0 * s0 + u))
    }
}

/// `F = sign(delta) |delta|^p`: the one-sided law, less that of the opposite overlap.
#[derive(Debug)]
pub(super) struct TwoSided {
    pub(super) pressed: Power,
}

impl ContactLaw for TwoSided {
    fn text(&self) -> String {
        format!("two-sided power {}", self.pressed.exponent)
    }

    fn force(&self, delta: Jet) -> Jet {
        match delta.value < 0.0 {
            true => -(-delta).power(self.pressed.exponent),
            false => delta.power(self.pressed.exponent),
        }
    }

    fn unit(&self) -> String {
        self.pressed.unit()
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        self.pressed.excess_force(d0, r) - self.pressed.force_at(-(d0 + r))
    }

    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        self.pressed.excess_energy(d0, r) + self.pressed.excess_energy(0.0, -(d0 + r))
    }
}
