//! Contact laws: force and energy of a contact against its overlap.
//!
//! A contact of coefficient c and static overlap `d0` carries, at the overlap `d0 + r`, the excess
//! over its static state: `F(d0 + r) - F(d0)` and `V(d0 + r) - V(d0) - F(d0) r`. The excess is
//! computed as such, never as a difference of large numbers, so that small waves on a strong
//! precompression keep their digits. Without precompression it is the force itself.
//!
//! A law of a file of its own implements [`ContactLaw`]; [`typed`] lists the words by which scenes name them.

mod exponential;
mod expression;
mod kernel;
mod laws;
mod polynomial;
mod power;
mod rows;
mod sided;
mod table;
pub(crate) mod typed;

use std::fmt::Debug;
use std::sync::Arc;

use crate::error::Result;
use crate::numeric::{Jet, Real, integral, root};
pub(crate) use kernel::{General, Hertz, Kernel, Power, PressedHertz, Spring};
pub use laws::Laws;
pub(crate) use rows::{hertz_energies, hertz_roots};

/// Force of a contact of unit coefficient against its overlap delta, with `F(0) = 0`. Contacts of the
/// coefficient c carry c times as much. Stiffnesses and energies follow from the force.
pub trait ContactLaw: Debug + Send + Sync {
    /// The law as a scene names it, by which laws are compared.
    fn text(&self) -> String;

    /// `F(delta)`, with its derivatives.
    fn force(&self, delta: Jet) -> Jet;

    /// `F(delta)` alone.
    fn force_at(&self, delta: f64) -> f64 {
        self.force(Jet::constant(delta)).value
    }

    /// The power of the overlap with which the force sets in at 0, where the contact opens; `None` where it pulls, too.
    fn opens(&self) -> Option<f64> {
        None
    }

    /// Unit of the coefficients in an SI scene; "1" where the law itself is in N.
    fn unit(&self) -> String {
        "1".into()
    }

    /// The overlaps between which the law is known.
    fn range(&self) -> [f64; 2] {
        [f64::NEG_INFINITY, f64::INFINITY]
    }

    /// The overlaps between two at which the force has a kink, in the order from one to the other.
    fn breaks(&self, _from: f64, _to: f64) -> Vec<f64> {
        Vec::new()
    }

    /// `F(d0 + r) - F(d0)`: the integral of the stiffness where the difference would cancel.
    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        if d0 == 0.0 {
            return self.force_at(r);
        }
        if !is_small(d0, r) {
            return self.force_at(d0 + r) - self.force_at(d0);
        }
        along(self, d0, r, |y| self.force(Jet::variable(d0 + y)).slope)
    }

    /// `V(d0 + r) - V(d0) - F(d0) r`, V the integral of the force.
    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        if is_small(d0, r) {
            let slope = |y: f64| self.force(Jet::variable(d0 + y)).slope;
            return along(self, d0, r, |y| (r - y) * slope(y));
        }
        let static_force = self.force_at(d0);
        along(self, d0, r, |y| self.force_at(d0 + y) - static_force)
    }
}

/// Whether a force at `d0 + r` is so near that at `d0` that their difference loses digits.
fn is_small(d0: f64, r: f64) -> bool {
    r.abs() < 0.1 * d0.abs()
}

/// The integral over `0..r` of a function of how far the overlap is beyond `d0`.
fn along(law: &(impl ContactLaw + ?Sized), d0: f64, r: f64, f: impl Fn(f64) -> f64) -> f64 {
    let mut breaks = law.breaks(d0, d0 + r);
    breaks.iter_mut().for_each(|delta| *delta -= d0);
    integral(0.0, r, &breaks, f)
}

/// How the force of a contact grows with its overlap delta.
#[derive(Debug, Clone, Default)]
pub enum Law {
    /// `F = c max(delta, 0)^{3/2}`, `V = (2/5) c max(delta, 0)^{5/2}`.
    #[default]
    Hertz,
    /// `F = c max(delta, 0)^p`, `V = c max(delta, 0)^{p+1} / (p+1)`, p at least 1.
    Power { exponent: f64 },
    /// Two-sided, `F = c (delta - alpha delta^2 + beta delta^3)`,
    /// `V = c (delta^2/2 - alpha delta^3/3 + beta delta^4/4)`: linear at `alpha = beta = 0`,
    /// else the alpha and beta chains of Fermi, Pasta, Ulam and Tsingou (delta is minus the
    /// elongation).
    Spring { alpha: f64, beta: f64 },
    /// Any other.
    Other(Arc<dyn ContactLaw>),
}

impl PartialEq for Law {
    fn eq(&self, other: &Law) -> bool {
        match (self, other) {
            (Law::Hertz, Law::Hertz) => true,
            (Law::Power { exponent: a }, Law::Power { exponent: b }) => a == b,
            (Law::Spring { alpha, beta }, Law::Spring { alpha: a, beta: b }) => {
                alpha == a && beta == b
            }
            (Law::Other(a), Law::Other(b)) => a.text() == b.text(),
            _ => false,
        }
    }
}

impl Law {
    /// Two-sided, `F = c (e^x - 1) / b`, `V = c (e^x - 1 - x) / b^2`, `x = b delta`, b the steepness: Toda's chain, whose
    /// solitons pass through each other unchanged.
    pub fn toda(steepness: f64) -> Law {
        Law::Other(Arc::new(exponential::Toda { steepness }))
    }

    /// Two-sided, `F = (c/b) e^x (e^x - 1)`, `V = c/(2 b^2) (e^x - 1)^2`, `x = b delta`: stiffer in compression, and torn by
    /// an elongation of `ln 2 / b` and a force of `c / (4 b)`.
    pub fn morse(steepness: f64) -> Law {
        Law::Other(Arc::new(exponential::Morse { steepness }))
    }

    /// Two-sided, `F = c sum_k a_k delta^k`, k from 1 on: softening, hardening or bistable.
    pub fn polynomial(terms: Vec<f64>) -> Law {
        Law::Other(Arc::new(polynomial::Polynomial { terms }))
    }

    /// Two-sided, `F = c sign(delta) |delta|^p`, p at least 1.
    pub fn two_sided_power(exponent: f64) -> Law {
        let pressed = Power { exponent };
        Law::Other(Arc::new(power::TwoSided { pressed }))
    }

    /// Forces at overlaps, two-sided, with a monotone cubic between them and a line beyond.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for fewer than two points, overlaps that do not grow, or a force other than 0 at 0.
    pub fn table(overlap: Vec<f64>, force: Vec<f64>) -> Result<Law> {
        Ok(Law::Other(Arc::new(table::Table::new(overlap, force)?)))
    }

    /// A formula of the overlap `d`, such as `k*d + a*d^3; k=1, a=0.3`, two-sided and differentiated exactly.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for a text that is no formula, and a force other than 0 at 0.
    pub fn expression(text: &str) -> Result<Law> {
        Ok(Law::Other(Arc::new(expression::Expression::parse(text)?)))
    }

    /// The same in compression, and nothing in tension.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for a law that does not press at small overlaps.
    pub fn one_sided(self) -> Result<Law> {
        match self {
            Law::Hertz | Law::Power { .. } => Ok(self),
            Law::Spring { alpha, beta } if alpha == 0.0 && beta == 0.0 => {
                Ok(Law::Power { exponent: 1.0 })
            }
            other => Ok(Law::Other(Arc::new(sided::OneSided::new(other)?))),
        }
    }

    /// What a function makes of the law as one of the trait.
    pub(crate) fn with<R>(&self, of: impl FnOnce(&dyn ContactLaw) -> R) -> R {
        match *self {
            Law::Hertz => of(&Power { exponent: 1.5 }),
            Law::Power { exponent } => of(&Power { exponent }),
            Law::Spring { alpha, beta } => of(&polynomial::Polynomial {
                terms: [1.0, -alpha, beta],
            }),
            Law::Other(ref law) => of(&**law),
        }
    }

    /// The law as a scene names it.
    pub fn text(&self) -> String {
        match self {
            Law::Hertz => "hertz".into(),
            Law::Spring { alpha, beta } if *alpha == 0.0 && *beta == 0.0 => "spring".into(),
            Law::Spring { alpha, beta } => format!("spring alpha={alpha} beta={beta}"),
            other => other.with(|law| law.text()),
        }
    }

    /// Whether the contact can only press, so that it opens.
    pub fn is_one_sided(&self) -> bool {
        self.opens().is_some()
    }

    /// Whether the force is proportional to the overlap, as far as its curvature tells.
    pub(crate) fn is_linear(&self) -> bool {
        /// Overlaps of all sizes that a law is likely to bend at.
        const PROBES: [f64; 8] = [-1.3, -0.2, -1e-3, -1e-6, 1e-6, 1e-3, 0.2, 1.3];
        !self.is_one_sided() && PROBES.iter().all(|delta| self.jet(*delta).bend == 0.0)
    }

    /// The power with which the force sets in where the contact opens.
    pub(crate) fn opens(&self) -> Option<f64> {
        self.with(|law| law.opens())
    }

    /// Unit of its coefficients in an SI scene.
    pub(crate) fn coefficient_unit(&self) -> String {
        self.with(|law| law.unit())
    }

    /// The overlaps between which the law is known.
    pub(crate) fn range(&self) -> [f64; 2] {
        self.with(|law| law.range())
    }

    /// Force of a contact of unit coefficient at an overlap, with its derivatives.
    pub(crate) fn jet(&self, delta: f64) -> Jet {
        self.with(|law| law.force(Jet::variable(delta)))
    }

    /// Excess force at the overlap `static_overlap + r`.
    pub fn force(&self, coefficient: f64, static_overlap: f64, r: f64) -> f64 {
        coefficient * self.with(|law| law.excess_force(static_overlap, r))
    }

    /// Derivative of [`Law::force`] along r.
    pub fn stiffness(&self, coefficient: f64, static_overlap: f64, r: f64) -> f64 {
        coefficient * self.jet(static_overlap + r).slope
    }

    /// Excess energy at the overlap `static_overlap + r`.
    pub fn energy(&self, coefficient: f64, static_overlap: f64, r: f64) -> f64 {
        coefficient * self.with(|law| law.excess_energy(static_overlap, r))
    }

    /// `phi = sign(r) sqrt(V)`, by which the energy is a square, and `d phi / dr = F / (2 phi)` with its
    /// limit at 0. Without a static overlap both come from the overlap itself: V is below the smallest
    /// number long before phi is. 0 where the energy is below that at rest.
    pub(crate) fn root_energy(&self, coefficient: f64, static_overlap: f64, r: f64) -> (f64, f64) {
        if let Some(p) = self.exponent().filter(|_| static_overlap == 0.0) {
            let d = r.max(0.0);
            let phi = (coefficient / (p + 1.0)).sqrt() * d.powf(0.5 * (p + 1.0));
            // 0^0 would be 1.
            let root = if r > 0.0 {
                d.powf(0.5 * (p - 1.0))
            } else {
                0.0
            };
            return (phi, 0.5 * (coefficient * (p + 1.0)).sqrt() * root);
        }
        let energy = self.energy(coefficient, static_overlap, r);
        let phi = energy.max(0.0).sqrt().copysign(r);
        let slope = match phi == 0.0 {
            true => (0.5 * self.stiffness(coefficient, static_overlap, r)).sqrt(),
            false => 0.5 * self.force(coefficient, static_overlap, r) / phi,
        };
        (phi, slope)
    }

    /// The power of the overlap that the force is.
    pub(crate) fn exponent(&self) -> Option<f64> {
        match *self {
            Law::Hertz => Some(1.5),
            Law::Power { exponent } => Some(exponent),
            _ => None,
        }
    }

    /// The static overlap under a static force; not a number where no overlap carries it.
    pub fn static_overlap(&self, coefficient: f64, force: f64) -> f64 {
        match self.exponent() {
            _ if force == 0.0 => 0.0,
            Some(p) => (force / coefficient).powf(1.0 / p),
            None => self.pressed(force / coefficient),
        }
    }

    /// The factor of `r^2` in the force about the static state; `None` for laws without such an expansion.
    pub(crate) fn quadratic(&self, coefficient: f64, static_overlap: f64) -> Option<f64> {
        let expands = !self.is_one_sided() || static_overlap > 0.0;
        expands.then(|| 0.5 * coefficient * self.jet(static_overlap).bend)
    }

    /// The first overlap from 0 on at which a contact of unit coefficient presses by this force.
    fn pressed(&self, force: f64) -> f64 {
        /// Octaves below and above the overlap that the stiffness at 0 makes of the force, and steps in each: where a law
        /// turns, the first overlap counts.
        const BELOW: i32 = 10;
        const ABOVE: i32 = 60;
        const STEPS: i32 = 8;
        let excess = |delta: f64| self.force(1.0, 0.0, delta) - force;
        let stiffness = self.jet(0.0).slope;
        let guess = if stiffness > 0.0 {
            force / stiffness
        } else {
            force
        };
        let mut below = guess * f64::from(-BELOW).exp2();
        while below > 0.0 && excess(below) >= 0.0 {
            below *= 0.5;
        }
        let step = (1.0 / f64::from(STEPS)).exp2();
        for _ in 0..STEPS * (BELOW + ABOVE) {
            let above = below * step;
            if excess(above) >= 0.0 {
                return root::between(below, above, excess);
            }
            below = above;
        }
        f64::NAN
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five-point derivatives of energy and force against force, stiffness and curvature, on both sides of opening.
    #[test]
    fn val_calculus_force_is_the_slope_of_the_energy() {
        const R: [f64; 6] = [-1.3, -0.4, 0.005, 0.01, 0.6, 2.0];
        let laws = [
            Law::Hertz,
            Law::Power { exponent: 2.5 },
            Law::Spring {
                alpha: 0.25,
                beta: 0.5,
            },
            Law::toda(0.8),
            Law::morse(0.6),
            Law::two_sided_power(2.5),
            Law::polynomial(vec![-1.0, 0.3, 0.2, 0.1]),
            Law::expression("sinh(d) + 0.2*d^3").unwrap(),
            Law::expression("2*d + d^2").unwrap().one_sided().unwrap(),
            Law::expression("max(min(2*d, 0.9), d) + abs(d)").unwrap(),
            Law::table(
                vec![-3.0, -0.02, 0.0, 1.35, 4.0],
                vec![-2.0, -0.1, 0.0, 1.0, 5.0],
            )
            .unwrap(),
        ];
        for law in &laws {
            for (d0, r) in [0.0, 0.7].iter().flat_map(|d0| R.map(|r| (*d0, r))) {
                let h = 1e-3 * f64::abs(d0 + r);
                let slope = |of: &dyn Fn(f64) -> f64| {
                    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|i| of(r + i * h));
                    (8.0 * (c - b) - (d - a)) / (12.0 * h)
                };
                let found = slope(&|r| law.energy(2.0, d0, r));
                let f = law.force(2.0, d0, r);
                assert!((found - f).abs() < 1e-9, "{law:?} {d0} {r}: {found} {f}");
                let found = slope(&|r| law.force(2.0, d0, r));
                let k = law.stiffness(2.0, d0, r);
                assert!((found - k).abs() < 1e-5, "{law:?} {d0} {r}: {found} {k}");
                let found = slope(&|r| law.stiffness(0.5, d0, r));
                let bend = law.quadratic(1.0, d0 + r).unwrap_or(0.0);
                assert!(
                    (found - bend).abs() < 1e-5 * bend.abs().max(1.0),
                    "{law:?} {d0} {r}: {found} {bend}"
                );
            }
        }
    }

    #[test]
    fn val_expansion_small_waves_on_a_strong_precompression() {
        for (law, p) in [
            (Law::Hertz, 1.5),
            (Law::Power { exponent: 2.2 }, 2.2f64),
            (Law::Power { exponent: 1.5 }, 1.5),
        ] {
            for r in [1e-3, 1e-9, -1e-9, 1e-15] {
                let q: f64 = r;
                let f = p * q
                    + p * (p - 1.0) / 2.0 * q * q
                    + p * (p - 1.0) * (p - 2.0) / 6.0 * q.powi(3)
                    + p * (p - 1.0) * (p - 2.0) * (p - 3.0) / 24.0 * q.powi(4);
                let found = law.force(1.0, 1.0, r);
                assert!((found / f - 1.0).abs() < 2e-14, "{law:?} {r}");
                let v = p / 2.0 * q * q
                    + p * (p - 1.0) / 6.0 * q.powi(3)
                    + p * (p - 1.0) * (p - 2.0) / 24.0 * q.powi(4)
                    + p * (p - 1.0) * (p - 2.0) * (p - 3.0) / 120.0 * q.powi(5);
                let found = law.energy(1.0, 1.0, r);
                assert!((found / v - 1.0).abs() < 2e-12, "{law:?} {r}");
            }
        }
    }
}
