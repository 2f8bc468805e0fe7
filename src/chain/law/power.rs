//! Powers of the overlap, one-sided and two-sided.

use super::ContactLaw;

/// `c p delta^{p-1}` in compression, else 0.
pub(super) fn slope(p: f64, c: f64, delta: f64) -> f64 {
    // 0^0 would be 1.
    if delta > 0.0 {
        c * p * delta.powf(p - 1.0)
    } else {
        0.0
    }
}

/// Excess energy of a one-sided contact at the overlap `d0 + r`.
pub(super) fn energy(p: f64, coefficient: f64, d0: f64, r: f64) -> f64 {
    if d0 == 0.0 {
        return coefficient * r.max(0.0).powf(p + 1.0) / (p + 1.0);
    }
    let static_force = coefficient * d0.powf(p);
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

/// `F = max(delta, 0)^p`, among other laws of a chain.
#[derive(Debug)]
pub(super) struct OneSided {
    pub(super) exponent: f64,
}

impl ContactLaw for OneSided {
    fn text(&self) -> String {
        format!("power {}", self.exponent)
    }

    fn force(&self, delta: f64) -> f64 {
        match self.exponent == 1.5 {
            true => delta.max(0.0) * delta.max(0.0).sqrt(),
            false => delta.max(0.0).powf(self.exponent),
        }
    }

    fn stiffness(&self, delta: f64) -> f64 {
        match self.exponent == 1.5 {
            true => 1.5 * delta.max(0.0).sqrt(),
            false => slope(self.exponent, 1.0, delta),
        }
    }

    fn bend(&self, delta: f64) -> f64 {
        let p = self.exponent;
        match delta > 0.0 && p > 1.0 {
            true => p * (p - 1.0) * delta.powf(p - 2.0),
            false => 0.0,
        }
    }

    fn energy(&self, delta: f64) -> f64 {
        energy(self.exponent, 1.0, 0.0, delta)
    }

    fn opens(&self) -> Option<f64> {
        Some(self.exponent)
    }

    fn unit(&self) -> String {
        format!("N/m^{}", self.exponent)
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        if d0 == 0.0 {
            return self.force(r);
        }
        super::Law::Power {
            exponent: self.exponent,
        }
        .force(1.0, d0, r)
    }

    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        energy(self.exponent, 1.0, d0, r)
    }
}

/// `F = sign(delta) |delta|^p`.
#[derive(Debug)]
pub(super) struct TwoSided {
    pub(super) exponent: f64,
}

impl ContactLaw for TwoSided {
    fn text(&self) -> String {
        format!("two-sided power {}", self.exponent)
    }

    fn force(&self, delta: f64) -> f64 {
        delta.abs().powf(self.exponent).copysign(delta)
    }

    fn stiffness(&self, delta: f64) -> f64 {
        self.exponent * delta.abs().powf(self.exponent - 1.0)
    }

    fn bend(&self, delta: f64) -> f64 {
        let p = self.exponent;
        match delta == 0.0 || p == 1.0 {
            true => 0.0,
            false => p * (p - 1.0) * delta.abs().powf(p - 2.0).copysign(delta),
        }
    }

    fn energy(&self, delta: f64) -> f64 {
        delta.abs().powf(self.exponent + 1.0) / (self.exponent + 1.0)
    }

    fn unit(&self) -> String {
        format!("N/m^{}", self.exponent)
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        if d0 + r > 0.0 {
            return super::Law::Power {
                exponent: self.exponent,
            }
            .force(1.0, d0, r);
        }
        self.force(d0 + r) - self.force(d0)
    }

    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        if d0 + r > 0.0 {
            return energy(self.exponent, 1.0, d0, r);
        }
        self.energy(d0 + r) - self.energy(d0) - self.force(d0) * r
    }
}
