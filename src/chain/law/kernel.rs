//! Contact laws in the form that the stepping is compiled for.

use std::sync::Arc;

use super::Law;
use crate::numeric::lanes::Number;

/// A law in the form the stepping is compiled for.
///
/// Contacts are given by their place `at` in rows, that of the first one where there are many.
pub(crate) trait Kernel: Clone + Send + Sync {
    /// Excess force at the overlap `d0 + r`, of one contact or of many.
    fn force<N: Number>(&self, at: usize, c: N, d0: N, r: N) -> N;

    /// Derivative of the force along r.
    fn stiffness<N: Number>(&self, at: usize, c: N, d0: N, r: N) -> N;

    /// The same of one contact at one overlap or at many.
    #[inline(always)]
    fn stiffness_along<N: Number>(&self, at: usize, c: f64, d0: f64, r: N) -> N {
        self.stiffness(at, N::splat(c), N::splat(d0), r)
    }

    /// Force of one contact of unit coefficient that opens, over the power of `node` with which it does: `F(delta) / node^p`
    /// for `delta >= 0`, which of a power is `F(delta / node)`.
    #[inline(always)]
    fn onset<N: Number>(&self, at: usize, delta: N, node: N) -> N {
        self.force(at, N::splat(1.0), N::splat(0.0), delta / node)
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Hertz;

impl Kernel for Hertz {
    #[inline(always)]
    fn force<N: Number>(&self, _: usize, c: N, _: N, r: N) -> N {
        let d = r.positive();
        c * (d * d.sqrt())
    }

    #[inline(always)]
    fn stiffness<N: Number>(&self, _: usize, c: N, _: N, r: N) -> N {
        N::splat(1.5) * c * r.positive().sqrt()
    }
}

/// Hertz with a static overlap: `s^3 - s0^3 = r (s^2 + s s0 + s0^2) / (s + s0)`, s the root.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PressedHertz;

impl Kernel for PressedHertz {
    #[inline(always)]
    fn force<N: Number>(&self, _: usize, c: N, d0: N, r: N) -> N {
        let d = d0 + r;
        let r = d.choose(r, N::splat(0.0) - d0);
        let d = d.positive();
        let (s, s0) = (d.sqrt(), d0.sqrt());
        let sum = s + s0;
        let sum = sum.choose(sum, N::splat(1.0));
        c * (r * (d + s * s0 + d0) / sum)
    }

    #[inline(always)]
    fn stiffness<N: Number>(&self, _: usize, c: N, d0: N, r: N) -> N {
        Hertz.stiffness(0, c, d0, d0 + r)
    }

    #[inline(always)]
    fn onset<N: Number>(&self, at: usize, delta: N, node: N) -> N {
        Hertz.onset(at, delta, node)
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Power {
    pub(crate) exponent: f64,
}

impl Kernel for Power {
    #[inline(always)]
    fn force<N: Number>(&self, _: usize, c: N, d0: N, r: N) -> N {
        let p = self.exponent;
        c.at_each(d0, r, |_, c, d0, r| {
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
    fn stiffness<N: Number>(&self, _: usize, c: N, d0: N, r: N) -> N {
        let p = self.exponent;
        c.at_each(d0, r, |_, c, d0, r| {
            // 0^0 would be 1.
            let d = d0 + r;
            if d > 0.0 {
                c * p * d.powf(p - 1.0)
            } else {
                0.0
            }
        })
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Spring {
    pub(crate) alpha: f64,
    pub(crate) beta: f64,
}

impl Kernel for Spring {
    #[inline(always)]
    fn force<N: Number>(&self, _: usize, c: N, _: N, r: N) -> N {
        let [alpha, beta] = [self.alpha, self.beta].map(N::splat);
        c * r * (N::splat(1.0) + r * (beta * r - alpha))
    }

    #[inline(always)]
    fn stiffness<N: Number>(&self, _: usize, c: N, _: N, r: N) -> N {
        let [alpha, beta] = [2.0 * self.alpha, 3.0 * self.beta].map(N::splat);
        c * (N::splat(1.0) + r * (beta * r - alpha))
    }
}

/// Any laws, each at the place of its contact.
#[derive(Debug, Clone)]
pub(crate) struct General(pub(crate) Arc<[Option<Law>]>);

impl General {
    fn law(&self, at: usize) -> Option<&Law> {
        self.0.get(at)?.as_ref()
    }
}

impl Kernel for General {
    fn force<N: Number>(&self, at: usize, c: N, d0: N, r: N) -> N {
        c.at_each(d0, r, |l, c, d0, r| match self.law(at + l) {
            // Contacts outside an island are infinitely far apart.
            Some(law) if c != 0.0 && r.is_finite() => law.force(c, d0, r),
            _ => 0.0,
        })
    }

    fn stiffness<N: Number>(&self, at: usize, c: N, d0: N, r: N) -> N {
        c.at_each(d0, r, |l, c, d0, r| match self.law(at + l) {
            Some(law) if c != 0.0 && r.is_finite() => law.stiffness(c, d0, r),
            _ => 0.0,
        })
    }

    fn stiffness_along<N: Number>(&self, at: usize, c: f64, d0: f64, r: N) -> N {
        r.at_each(r, r, |_, r, _, _| self.stiffness(at, c, d0, r))
    }

    fn onset<N: Number>(&self, at: usize, delta: N, node: N) -> N {
        let law = self.law(at);
        let power = law.and_then(Law::opens).unwrap_or(1.0);
        delta.at_each(node, node, |_, delta, node, _| match law {
            Some(law) => law.force(1.0, 0.0, delta.max(0.0)) / node.powf(power),
            None => 0.0,
        })
    }
}
