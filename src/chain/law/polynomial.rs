//! Polynomials of the overlap: softening, hardening and bistable springs.

use super::ContactLaw;

/// `F = sum_k a_k delta^k`, k from 1 on.
#[derive(Debug)]
pub(super) struct Polynomial {
    /// The name under which a scene has it, if it is not its terms.
    name: Option<String>,
    terms: Vec<f64>,
}

impl Polynomial {
    pub(super) fn new(terms: Vec<f64>) -> Polynomial {
        Polynomial { name: None, terms }
    }

    pub(super) fn spring(alpha: f64, beta: f64) -> Polynomial {
        Polynomial {
            name: Some(match alpha == 0.0 && beta == 0.0 {
                true => "spring".into(),
                false => format!("spring alpha={alpha} beta={beta}"),
            }),
            terms: vec![1.0, -alpha, beta],
        }
    }

    /// Divided differences `F[d0, d0 + r]` and `F[d0, d0, d0 + r]`, by Horner's rule, in which nothing cancels that does
    /// not cancel in the polynomial.
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
}

impl ContactLaw for Polynomial {
    fn text(&self) -> String {
        let terms: Vec<String> = self.terms.iter().map(f64::to_string).collect();
        let own = || format!("polynomial {}", terms.join(" "));
        self.name.clone().unwrap_or_else(own)
    }

    fn force(&self, delta: f64) -> f64 {
        delta * self.terms.iter().rfold(0.0, |sum, a| sum * delta + a)
    }

    fn stiffness(&self, delta: f64) -> f64 {
        let terms = self.terms.iter().enumerate();
        terms.rfold(0.0, |sum, (i, a)| sum * delta + (i + 1) as f64 * a)
    }

    fn bend(&self, delta: f64) -> f64 {
        let terms = self.terms.iter().enumerate().skip(1);
        terms.rfold(0.0, |sum, (i, a)| sum * delta + (i * (i + 1)) as f64 * a)
    }

    fn energy(&self, delta: f64) -> f64 {
        let terms = self.terms.iter().enumerate();
        let mean = terms.rfold(0.0, |sum, (i, a)| sum * delta + a / (i + 2) as f64);
        delta * delta * mean
    }

    fn unit(&self) -> String {
        "N/m".into()
    }

    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        let terms = self.terms.iter().rev().copied().chain([0.0]);
        r * Polynomial::divided(terms, [d0, d0 + r])[0]
    }

    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        let terms = self.terms.iter().enumerate().rev();
        let energy = terms.map(|(i, a)| a / (i + 2) as f64).chain([0.0, 0.0]);
        r * r * Polynomial::divided(energy, [d0, d0 + r])[1]
    }
}
