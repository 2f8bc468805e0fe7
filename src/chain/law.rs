//! Contact laws: force and energy of a contact against its overlap.
//!
//! A contact of coefficient c and static overlap `d0` carries, at the overlap `d0 + r`, the excess
//! over its static state: `F(d0 + r) - F(d0)` and `V(d0 + r) - V(d0) - F(d0) r`. The excess is
//! computed as such, never as a difference of large numbers, so that small waves on a strong
//! precompression keep their digits. Without precompression it is the force itself.

use crate::numeric::lanes::Number;

/// How the force of a contact grows with its overlap delta.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Law {
    /// `F = c max(delta, 0)^{3/2}`, `V = (2/5) c max(delta, 0)^{5/2}`.
    #[default]
    Hertz,
    /// `F = c max(delta, 0)^p`, `V = c max(delta, 0)^{p+1} / (p+1)`, p > 1.
    Power { exponent: f64 },
    /// Two-sided, `F = c (delta - alpha delta^2 + beta delta^3)`,
    /// `V = c (delta^2/2 - alpha delta^3/3 + beta delta^4/4)`: linear at `alpha = beta = 0`,
    /// else the alpha and beta chains of Fermi, Pasta, Ulam and Tsingou (delta is minus the
    /// elongation).
    Spring { alpha: f64, beta: f64 },
    /// Two-sided, `F = c (e^x - 1) / b`, `V = c (e^x - 1 - x) / b^2`, `x = b delta`, `b` the steepness: Toda's chain, whose
    /// solitons pass through each other unchanged.
    Toda { steepness: f64 },
    /// Two-sided, `F = (c/b) e^x (e^x - 1)`, `V = c/(2 b^2) (e^x - 1)^2`, `x = b delta`: stiffer in compression, and torn by
    /// an elongation of `ln 2 / b` and a force of `c / (4 b)`.
    Morse { steepness: f64 },
}

impl Law {
    /// Whether the contact can only press, so that it opens.
    pub fn is_one_sided(&self) -> bool {
        matches!(self, Law::Hertz | Law::Power { .. })
    }

    /// Unit of its coefficients in an SI scene.
    pub(crate) fn coefficient_unit(&self) -> String {
        match self {
            Law::Hertz => "N/m^1.5".into(),
            Law::Power { exponent } => format!("N/m^{exponent}"),
            Law::Spring { .. } | Law::Toda { .. } | Law::Morse { .. } => "N/m".into(),
        }
    }

    /// Excess force at the overlap `static_overlap + r`.
    pub fn force(&self, coefficient: f64, static_overlap: f64, r: f64) -> f64 {
        match *self {
            Law::Hertz if static_overlap == 0.0 => Hertz.force(coefficient, 0.0, r),
            Law::Hertz => PressedHertz.force(coefficient, static_overlap, r),
            Law::Power { exponent } => Power { exponent }.force(coefficient, static_overlap, r),
            Law::Spring { alpha, beta } => Spring { alpha, beta }.force(coefficient, 0.0, r),
            Law::Toda { steepness } => Toda { steepness }.force(coefficient, 0.0, r),
            Law::Morse { steepness } => Morse { steepness }.force(coefficient, 0.0, r),
        }
    }

    /// Derivative of [`Law::force`] along r.
    pub fn stiffness(&self, coefficient: f64, static_overlap: f64, r: f64) -> f64 {
        match *self {
            Law::Hertz => 1.5 * coefficient * (static_overlap + r).max(0.0).sqrt(),
            Law::Power { exponent } => {
                exponent * coefficient * (static_overlap + r).max(0.0).powf(exponent - 1.0)
            }
            Law::Spring { alpha, beta } => coefficient * (1.0 + r * (3.0 * beta * r - 2.0 * alpha)),
            Law::Toda { steepness } => Toda { steepness }.stiffness(coefficient, 0.0, r),
            Law::Morse { steepness } => Morse { steepness }.stiffness(coefficient, 0.0, r),
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
            Law::Power { exponent: p } => {
                let static_force = coefficient * static_overlap.powf(p);
                if static_overlap == 0.0 {
                    return coefficient * r.max(0.0).powf(p + 1.0) / (p + 1.0);
                }
                if delta <= 0.0 {
                    return static_force * (-r - static_overlap / (p + 1.0));
                }
                static_force * static_overlap * power_excess(p, r / static_overlap)
            }
            Law::Spring { alpha, beta } => {
                coefficient * r * r * (0.5 + r * (0.25 * beta * r - alpha / 3.0))
            }
            Law::Toda { steepness: b } => coefficient * exponential_excess(b * r) / (b * b),
            Law::Morse { steepness: b } => 0.5 * coefficient * ((b * r).exp_m1() / b).powi(2),
        }
    }

    /// `phi = sign(r) sqrt(V)`, by which the energy is a square, and `d phi / dr = F / (2 phi)` with its
    /// limit at 0. Without a static overlap both come from the overlap itself: V is below the smallest
    /// number long before phi is.
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
                let slope = 0.5 * (coefficient * (p + 1.0)).sqrt() * d.powf(0.5 * (p - 1.0));
                (phi, slope)
            }
            _ => {
                let phi = self
                    .energy(coefficient, static_overlap, r)
                    .max(0.0)
                    .sqrt()
                    .copysign(r);
                let slope = match phi == 0.0 {
                    true => (0.5 * self.stiffness(coefficient, static_overlap, r)).sqrt(),
                    false => 0.5 * self.force(coefficient, static_overlap, r) / phi,
                };
                (phi, slope)
            }
        }
    }

    /// The static overlap under a static force.
    pub fn static_overlap(&self, coefficient: f64, force: f64) -> f64 {
        match *self {
            _ if force == 0.0 => 0.0,
            Law::Hertz => (force / coefficient).powf(2.0 / 3.0),
            Law::Power { exponent } => (force / coefficient).powf(1.0 / exponent),
            Law::Spring { .. } | Law::Toda { .. } | Law::Morse { .. } => 0.0,
        }
    }

    /// The factor of `delta^2` in `F / c` about the state at rest; `None` for laws without such an expansion.
    pub(crate) fn quadratic(&self) -> Option<f64> {
        match *self {
            Law::Hertz | Law::Power { .. } => None,
            Law::Spring { alpha, .. } => Some(-alpha),
            Law::Toda { steepness } => Some(0.5 * steepness),
            Law::Morse { steepness } => Some(1.5 * steepness),
        }
    }
}

/// `e^x - 1 - x`, by its series where the difference would cancel.
fn exponential_excess(x: f64) -> f64 {
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

/// A law in the form the stepping is compiled for.
pub(crate) trait Kernel: Copy + Send + Sync {
    /// The power of the overlap with which a contact opens; `None` where it does not open.
    fn opening_power(self) -> Option<f64> {
        None
    }

    /// Excess force at the overlap `d0 + r`, of one contact or of many.
    fn force<N: Number>(self, c: N, d0: N, r: N) -> N;

    /// Derivative of the force along r.
    fn stiffness<N: Number>(self, c: N, d0: N, r: N) -> N;

    /// `delta^p` for `delta >= 0`, with the power at which the contact opens.
    fn power(self, delta: f64) -> f64 {
        delta
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Hertz;

impl Kernel for Hertz {
    fn opening_power(self) -> Option<f64> {
        Some(1.5)
    }

    #[inline(always)]
    fn force<N: Number>(self, c: N, _: N, r: N) -> N {
        let d = r.positive();
        c * (d * d.sqrt())
    }

    #[inline(always)]
    fn stiffness<N: Number>(self, c: N, _: N, r: N) -> N {
        N::splat(1.5) * c * r.positive().sqrt()
    }

    #[inline(always)]
    fn power(self, delta: f64) -> f64 {
        delta * delta.sqrt()
    }
}

/// Hertz with a static overlap: `s^3 - s0^3 = r (s^2 + s s0 + s0^2) / (s + s0)`, s the root.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PressedHertz;

impl Kernel for PressedHertz {
    fn opening_power(self) -> Option<f64> {
        Some(1.5)
    }

    #[inline(always)]
    fn force<N: Number>(self, c: N, d0: N, r: N) -> N {
        let d = d0 + r;
        let r = d.choose(r, N::splat(0.0) - d0);
        let d = d.positive();
        let (s, s0) = (d.sqrt(), d0.sqrt());
        let sum = s + s0;
        let sum = sum.choose(sum, N::splat(1.0));
        c * (r * (d + s * s0 + d0) / sum)
    }

    #[inline(always)]
    fn stiffness<N: Number>(self, c: N, d0: N, r: N) -> N {
        Hertz.stiffness(c, d0, d0 + r)
    }

    #[inline(always)]
    fn power(self, delta: f64) -> f64 {
        delta * delta.sqrt()
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Power {
    pub(crate) exponent: f64,
}

impl Kernel for Power {
    fn opening_power(self) -> Option<f64> {
        Some(self.exponent)
    }

    #[inline(always)]
    fn force<N: Number>(self, c: N, d0: N, r: N) -> N {
        let p = self.exponent;
        c.map3(d0, r, |c, d0, r| {
            let d = d0 + r;
            if d0 == 0.0 {
                // Most contacts of a chain are open or not reached.
                if d > 0.0 { c * d.powf(p) } else { 0.0 }
            } else if d > 0.0 {
                c * d0.powf(p) * (p * (r / d0).ln_1p()).exp_m1()
            } else {
                -c * d0.powf(p)
            }
        })
    }

    #[inline(always)]
    fn stiffness<N: Number>(self, c: N, d0: N, r: N) -> N {
        let p = self.exponent;
        c.map3(d0, r, |c, d0, r| c * p * (d0 + r).max(0.0).powf(p - 1.0))
    }

    #[inline(always)]
    fn power(self, delta: f64) -> f64 {
        delta.powf(self.exponent)
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Spring {
    pub(crate) alpha: f64,
    pub(crate) beta: f64,
}

impl Kernel for Spring {
    #[inline(always)]
    fn force<N: Number>(self, c: N, _: N, r: N) -> N {
        let [alpha, beta] = [self.alpha, self.beta].map(N::splat);
        c * r * (N::splat(1.0) + r * (beta * r - alpha))
    }

    #[inline(always)]
    fn stiffness<N: Number>(self, c: N, _: N, r: N) -> N {
        let [alpha, beta] = [2.0 * self.alpha, 3.0 * self.beta].map(N::splat);
        c * (N::splat(1.0) + r * (beta * r - alpha))
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Toda {
    pub(crate) steepness: f64,
}

impl Kernel for Toda {
    #[inline(always)]
    fn force<N: Number>(self, c: N, d0: N, r: N) -> N {
        let b = self.steepness;
        c.map3(d0, r, |c, _, r| c * (b * r).exp_m1() / b)
    }

    #[inline(always)]
    fn stiffness<N: Number>(self, c: N, d0: N, r: N) -> N {
        let b = self.steepness;
        c.map3(d0, r, |c, _, r| c * (b * r).exp())
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Morse {
    pub(crate) steepness: f64,
}

impl Kernel for Morse {
    #[inline(always)]
    fn force<N: Number>(self, c: N, d0: N, r: N) -> N {
        let b = self.steepness;
        c.map3(d0, r, |c, _, r| {
            let excess = (b * r).exp_m1();
            c * (1.0 + excess) * excess / b
        })
    }

    #[inline(always)]
    fn stiffness<N: Number>(self, c: N, d0: N, r: N) -> N {
        let b = self.steepness;
        c.map3(d0, r, |c, _, r| {
            let excess = (b * r).exp_m1();
            c * (1.0 + excess) * (1.0 + 2.0 * excess)
        })
    }
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
            Law::Toda { steepness: 0.8 },
            Law::Morse { steepness: 0.6 },
        ];
        for law in laws {
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
