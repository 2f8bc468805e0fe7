//! Polynomials of the overlap: softening, hardening and bistable springs.

use std::fmt::Debug;

use super::ContactLaw;
use crate::numeric::{Jet, Real};

/// `F = sum_k a_k delta^k`, k from 1 on.
#[derive(Debug)]
pub(super) struct Polynomial<T> {
    pub(super) terms: T,
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

impl<T: AsRef<[f64]> + Debug + Send + Sync> ContactLaw for Polynomial<T> {
    fn text(&self) -> String {
        let terms: Vec<String> = self.terms.as_ref().iter().map(f64::to_string).collect();
        format!("polynomial {}", terms.join(" "))
    }

    fn force(&self, delta: Jet) -> Jet {
        let terms = self.terms.as_ref().iter();
        let sum = |sum: Jet, a: &f64| sum * delta + Jet::constant(*a);
        delta * terms.rfold(Jet::constant(0.0), sum)
    }

    fn unit(&self) -> String {
        "N/m".into()
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        if d0 == 0.0 {
            return self.force_at(r);
        }
        let terms = self.terms.as_ref().iter().rev().copied().chain([0.0]);
        r * divided(terms, [d0, d0 + r])[0]
    }

    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        let terms = self.terms.as_ref().iter().enumerate().rev();
        let energy = terms.map(|(i, a)| a / (i + 2) as f64).chain([0.0, 0.0]);
        r * r * divided(energy, [d0, d0 + r])[1]
    }
}
