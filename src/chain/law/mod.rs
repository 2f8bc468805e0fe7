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
use crate::numeric::root;
pub(crate) use kernel::{General, Hertz, Kernel, Power, PressedHertz, Spring};
pub use laws::Laws;
pub(crate) use rows::{hertz_energies, hertz_roots};

/// Force of a contact of unit coefficient against its overlap delta, with `F(0) = 0`. Contacts of the
/// coefficient c carry c times as much.
pub trait ContactLaw: Debug + Send + Sync {
    /// The law as a scene names it, by which laws are compared.
    fn text(&self) -> String;

    /// `F(delta)`.
    fn force(&self, delta: f64) -> f64;

    /// `dF/d delta`.
    fn stiffness(&self, delta: f64) -> f64;

    /// `d^2 F/d delta^2`.
    fn bend(&self, delta: f64) -> f64;

    /// `V(delta)`, the integral of the force from 0 on.
    fn energy(&self, delta: f64) -> f64 {
        delta * mean(|share| self.force(share * delta))
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

    /// `F(d0 + r) - F(d0)`.
    fn excess_force(&self, d0: f64, r: f64) -> f64 {
        if d0 == 0.0 {
            return self.force(r);
        }
        if is_small(d0, r) {
            return r * mean(|share| self.stiffness(d0 + share * r));
        }
        self.force(d0 + r) - self.force(d0)
    }

    /// `V(d0 + r) - V(d0) - F(d0) r`.
    fn excess_energy(&self, d0: f64, r: f64) -> f64 {
        if d0 == 0.0 {
            return self.energy(r);
        }
        r * mean(|share| self.excess_force(d0, share * r))
    }
}

/// Whether a force at `d0 + r` is so near that at `d0` that their difference loses digits.
fn is_small(d0: f64, r: f64) -> bool {
    r.abs() < 0.1 * d0.abs()
}

/// The mean of a function over 0..1, by Gauss's rule: to rounding where it is smooth.
fn mean(f: impl Fn(f64) -> f64) -> f64 {
    /// Positive nodes on -1..1 and their weights.
    const NODES: [(f64, f64); 8] = [
        (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
        (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
        (0.458_016_777_657_227_4, 0.169_156_519_395_002_54),
        (0.617_876_244_402_643_7, 0.149_595_988_816_576_73),
        (0.755_404_408_355_003, 0.124_628_971_255_533_87),
        (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
        (0.944_575_023_073_232_6, 0.062_253_523_938_647_89),
        (0.989_400_934_991_649_9, 0.027_152_459_411_754_095),
    ];
    let each = NODES.iter().map(|&(node, weight)| {
        let step = 0.5 * node;
        0.5 * weight * (f(0.5 - step) + f(0.5 + step))
    });
    each.sum()
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
        Law::Other(Arc::new(polynomial::Polynomial::new(terms)))
    }

    /// Two-sided, `F = c sign(delta) |delta|^p`, p at least 1.
    pub fn two_sided_power(exponent: f64) -> Law {
        Law::Other(Arc::new(power::TwoSided { exponent }))
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
            other => Ok(Law::Other(Arc::new(sided::OneSided::new(other.shared())?))),
        }
    }

    /// The law as one of the trait.
    pub(crate) fn shared(&self) -> Arc<dyn ContactLaw> {
        match self {
            Law::Hertz => Arc::new(power::OneSided { exponent: 1.5 }),
            Law::Power { exponent } => Arc::new(power::OneSided {
                exponent: *exponent,
            }),
            Law::Spring { alpha, beta } => Arc::new(polynomial::Polynomial::spring(*alpha, *beta)),
            Law::Other(law) => law.clone(),
        }
    }

    /// The law as a scene names it.
    pub fn text(&self) -> String {
        match self {
            Law::Hertz => "hertz".into(),
            other => other.shared().text(),
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
        match self {
            Law::Hertz | Law::Power { .. } => false,
            Law::Spring { alpha, beta } => *alpha == 0.0 && *beta == 0.0,
            Law::Other(law) => {
                law.opens().is_none() && PROBES.iter().all(|delta| law.bend(*delta) == 0.0)
            }
        }
    }

    /// The power with which the force sets in where the contact opens.
    pub(crate) fn opens(&self) -> Option<f64> {
        match self {
            Law::Hertz => Some(1.5),
            Law::Power { exponent } => Some(*exponent),
            Law::Spring { .. } => None,
            Law::Other(law) => law.opens(),
        }
    }

    /// Unit of its coefficients in an SI scene.
    pub(crate) fn coefficient_unit(&self) -> String {
        match self {
            Law::Hertz => "N/m^1.5".into(),
            Law::Power { exponent } => format!("N/m^{exponent}"),
            Law::Spring { .. } => "N/m".into(),
            Law::Other(law) => law.unit(),
        }
    }

    /// The overlaps between which the law is known.
    pub(crate) fn range(&self) -> [f64; 2] {
        match self {
            Law::Other(law) => law.range(),
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// Excess force at the overlap `static_overlap + r`.
    pub fn force(&self, coefficient: f64, static_overlap: f64, r: f64) -> f64 {
        match *self {
            Law::Hertz if static_overlap == 0.0 => Hertz.force(0, coefficient, 0.0, r),
            Law::Hertz => PressedHertz.force(0, coefficient, static_overlap, r),
            Law::Power { exponent } => Power { exponent }.force(0, coefficient, static_overlap, r),
            Law::Spring { alpha, beta } if static_overlap == 0.0 => {
                Spring { alpha, beta }.force(0, coefficient, 0.0, r)
            }
            Law::Spring { alpha, beta } => {
                let terms = polynomial::Polynomial::spring(alpha, beta);
                coefficient * terms.excess_force(static_overlap, r)
            }
            Law::Other(ref law) => coefficient * law.excess_force(static_overlap, r),
        }
    }

    /// Derivative of [`Law::force`] along r.
    pub fn stiffness(&self, coefficient: f64, static_overlap: f64, r: f64) -> f64 {
        let delta = static_overlap + r;
        match *self {
            Law::Hertz => 1.5 * coefficient * delta.max(0.0).sqrt(),
            Law::Power { exponent } => power::slope(exponent, coefficient, delta),
            Law::Spring { alpha, beta } => {
                coefficient * (1.0 + delta * (3.0 * beta * delta - 2.0 * alpha))
            }
            Law::Other(ref law) => coefficient * law.stiffness(delta),
        }
    }

    /// Excess energy at the overlap `static_overlap + r`.
    pub fn energy(&self, coefficient: f64, static_overlap: f64, r: f64) -> f64 {
        let delta = static_overlap + r;
        match *self {
            Law::Hertz if static_overlap == 0.0 => {
                let d = r.max(0.0);
                0.4 * coefficient * d * d * d.sqrt()
            }
            Law::Hertz => {
                let s0 = static_overlap.sqrt();
                if delta <= 0.0 {
                    return coefficient * static_overlap * s0 * (-r - 0.4 * static_overlap);
                }
                let u = r / (delta.sqrt() + s0);
                let cubic = s0 * s0 * (7.5 * s0 + 10.0 * u) + u * u * (5.0 * s0 + u);
                0.4 * coefficient * u * u * cubic
            }
            Law::Power { exponent } => power::energy(exponent, coefficient, static_overlap, r),
            Law::Spring { alpha, beta } if static_overlap == 0.0 => {
                coefficient * r * r * (0.5 + r * (0.25 * beta * r - alpha / 3.0))
            }
            Law::Spring { alpha, beta } => {
                let terms = polynomial::Polynomial::spring(alpha, beta);
                coefficient * terms.excess_energy(static_overlap, r)
            }
            Law::Other(ref law) => coefficient * law.excess_energy(static_overlap, r),
        }
    }

    /// `phi = sign(r) sqrt(V)`, by which the energy is a square, and `d phi / dr = F / (2 phi)` with its
    /// limit at 0. Without a static overlap both come from the overlap itself: V is below the smallest
    /// number long before phi is. 0 where the energy is below that at rest.
    pub(crate) fn root_energy(&self, coefficient: f64, static_overlap: f64, r: f64) -> (f64, f64) {
        match *self {
            Law::Hertz if static_overlap == 0.0 => {
                let d = r.max(0.0);
                let root = d.sqrt().sqrt();
                let phi = (0.4 * coefficient).sqrt() * d * root;
                (phi, 0.5 * (2.5 * coefficient).sqrt() * root)
            }
            Law::Power { exponent: p } if static_overlap == 0.0 => {
                let d = r.max(0.0);
                let phi = (coefficient / (p + 1.0)).sqrt() * d.powf(0.5 * (p + 1.0));
                // 0^0 would be 1.
                let root = if r > 0.0 {
                    d.powf(0.5 * (p - 1.0))
                } else {
                    0.0
                };
                (phi, 0.5 * (coefficient * (p + 1.0)).sqrt() * root)
            }
            _ => {
                let energy = self.energy(coefficient, static_overlap, r);
                let phi = energy.max(0.0).sqrt().copysign(r);
                let slope = match phi == 0.0 {
                    true => (0.5 * self.stiffness(coefficient, static_overlap, r)).sqrt(),
                    false => 0.5 * self.force(coefficient, static_overlap, r) / phi,
                };
                (phi, slope)
            }
        }
    }

    /// The static overlap under a static force; not a number where no overlap carries it.
    pub fn static_overlap(&self, coefficient: f64, force: f64) -> f64 {
        match self {
            _ if force == 0.0 => 0.0,
            Law::Hertz => (force / coefficient).powf(2.0 / 3.0),
            Law::Power { exponent } => (force / coefficient).powf(1.0 / exponent),
            other => pressed(&*other.shared(), force / coefficient),
        }
    }

    /// The factor of `r^2` in the force about the static state; `None` for laws without such an expansion.
    pub(crate) fn quadratic(&self, coefficient: f64, static_overlap: f64) -> Option<f64> {
        let p = match *self {
            Law::Hertz => 1.5,
            Law::Power { exponent } => exponent,
            Law::Spring { alpha, beta } => {
                return Some(coefficient * (3.0 * beta * static_overlap - alpha));
            }
            Law::Other(ref law) if law.opens().is_none() || static_overlap > 0.0 => {
                return Some(0.5 * coefficient * law.bend(static_overlap));
            }
            Law::Other(_) => return None,
        };
        let stiffness = self.stiffness(coefficient, static_overlap, 0.0);
        (static_overlap > 0.0).then(|| 0.5 * stiffness * (p - 1.0) / static_overlap)
    }
}

/// The first overlap from 0 on at which a law presses by this force.
fn pressed(law: &dyn ContactLaw, force: f64) -> f64 {
    /// Octaves below and above the overlap that the stiffness at 0 makes of the force, and steps in each: where a law turns,
    /// the first overlap counts.
    const BELOW: i32 = 10;
    const ABOVE: i32 = 60;
    const STEPS: i32 = 8;
    let stiffness = law.stiffness(0.0);
    let guess = match stiffness > 0.0 {
        true => force / stiffness,
        false => force,
    };
    let mut below = guess * f64::from(-BELOW).exp2();
    while below > 0.0 && law.force(below) >= force {
        below *= 0.5;
    }
    let step = (1.0 / f64::from(STEPS)).exp2();
    for _ in 0..STEPS * (BELOW + ABOVE) {
        let above = below * step;
        if law.force(above) >= force {
            return root::between(below, above, |delta| law.force(delta) - force);
        }
        below = above;
    }
    f64::NAN
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five-point derivative of the energy against the force, on both sides of opening.
    #[test]
    fn val_calculus_force_is_the_slope_of_the_energy() {
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
            Law::table(
                vec![-3.0, -0.02, 0.0, 1.35, 4.0],
                vec![-2.0, -0.1, 0.0, 1.0, 5.0],
            )
            .unwrap(),
        ];
        for law in &laws {
            for d0 in [0.0, 0.7] {
                for r in [-1.3, -0.4, 0.005, 0.01, 0.6, 2.0] {
                    let h = 1e-3 * f64::abs(d0 + r);
                    let v = |k: f64| law.energy(2.0, d0, r + k * h);
                    let slope = (8.0 * (v(1.0) - v(-1.0)) - (v(2.0) - v(-2.0))) / (12.0 * h);
                    let f = law.force(2.0, d0, r);
                    assert!((slope - f).abs() < 1e-9, "{law:?} {d0} {r}: {slope} {f}");
                    let f = |k: f64| law.force(2.0, d0, r + k * h);
                    let slope = (8.0 * (f(1.0) - f(-1.0)) - (f(2.0) - f(-2.0))) / (12.0 * h);
                    let k = law.stiffness(2.0, d0, r);
                    assert!((slope - k).abs() < 1e-5, "{law:?} {d0} {r}: {slope} {k}");
                }
            }
        }
    }

    /// The quadratic term against second differences of the force about the static state.
    #[test]
    fn val_calculus_quadratic_terms() {
        for (law, d0) in [
            (Law::Hertz, 0.7),
            (Law::Power { exponent: 2.5 }, 0.7),
            (
                Law::Spring {
                    alpha: 0.25,
                    beta: 0.5,
                },
                0.3,
            ),
            (Law::toda(0.8), 0.0),
            (Law::morse(0.6), 0.4),
            (Law::expression("sinh(d) + 0.2*d^2").unwrap(), 0.2),
        ] {
            let h = 1e-3;
            let f = |k: f64| law.force(2.0, d0, k * h);
            let second = (16.0 * (f(1.0) + f(-1.0)) - (f(2.0) + f(-2.0))) / (24.0 * h * h);
            let found = law.quadratic(2.0, d0).unwrap();
            assert!((found - second).abs() < 1e-8, "{law:?}: {found} {second}");
        }
        assert_eq!(Law::Hertz.quadratic(2.0, 0.0), None);
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
