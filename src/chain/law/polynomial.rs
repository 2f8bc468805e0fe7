//! Polynomials of the overlap: softening, hardening and bistable springs.

use super::{ContactLaw, Spring};
use crate::numeric::Jet;

/// `F = sum_k a_k delta^k`, k from 1 on.
#[derive(Debug)]
pub(super) struct Polynomial {
    pub(super) terms: Vec<f64>,
}

fn force(terms: &[f64], delta: Jet) -> Jet {
    let sum = |sum: Jet, a: &f64| sum * delta + Jet::constant(*a);
    delta * terms.iter().rfold(Jet::constant(0.0), sum)
}

/// Divided differences `F[d0, d0 + r]` and `F[d0, d0, d0 + r]`, by Horner's rule, in which nothing cancels that does not
/// cancel in the polynomial.
fn divided(terms: impl Iterator<Item = f64>, [at, far]: [f64; 2]) -> [f64; 2] {
    let (mut value, mut once, mut twice) = (0.0, 0.0, 0.0);
    for term in terms {
        twice = twice * far + once;
        once = once * at + value;
        value = value * at + term;
    }
    // `once` is the derivative at `at`, `twice` the difference of it.
    [once + twice * (far - at), twice]
}

fn excess_force(terms: &[f64], d0: f64, r: f64) -> f64 {
    let terms = terms.iter().rev().copied().chain([0.0]);
    r * divided(terms, [d0, d0 + r])[0]
}

fn excess_energy(terms: &[f64], d0: f64, r: f64) -> f64 {
    let terms = terms.iter().enumerate().rev();
    let energy = terms.map(|(i, a)| a / (i + 2) as f64).chain([0.0, 0.0]);
    r * r * divided(energy, [d0, d0 + r])[1]
}

impl ContactLaw for Polynomial {
    fn text(&self) -> String {
        let terms: Vec<String> = self.terms.iter().map(f64::to_string).collect();
        format!("polynomial {}", terms.join(" "))
    }

    fn force(&self, delta: Jet) -> Jet {
        force(&self.terms, delta)
    }

    fn unit(&self) -> String {
        "N/m".into()
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        match d0 == 0.0 {
            true => self.force_at(r),
            false => excess_force(&self.terms, d0, r),
        }
    }

    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        excess_energy(&self.terms, d0, r)
    }
}

impl Spring {
    fn terms(&self) -> [f64; 3] {
        [1.0, -self.alpha, self.beta]
    }
}

impl ContactLaw for Spring {
    fn text(&self) -> String {
        match *self {
            Spring {
                alpha: 0.0,
                beta: 0.0,
            } => "spring".into(),
            Spring { alpha, beta } => format!("spring alpha={alpha} beta={beta}"),
        }
    }

    fn force(&self, delta: Jet) -> Jet {
        force(&self.terms(), delta)
    }

    fn unit(&self) -> String {
        "N/m".into()
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        excess_force(&self.terms(), d0, r)
    }

    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        excess_energy(&self.terms(), d0, r)
    }
}
