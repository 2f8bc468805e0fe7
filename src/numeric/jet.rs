//! Numbers that carry derivatives along one variable.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value with its first and second derivative along one variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet {
    pub value: f64,
    pub slope: f64,
    pub bend: f64,
}

/// What laws and formulas are evaluated with: `f64`, or a [`Jet`].
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    fn constant(value: f64) -> Self;

    fn value(self) -> f64;

    /// A function of this, from its value here and, where they are needed, its first two derivatives.
    #[must_use]
    fn through(self, value: f64, slopes: impl FnOnce() -> [f64; 2]) -> Self;

    /// `self^p`; powers of 0 have the derivatives that they have as limits.
    #[must_use]
    fn power(self, p: f64) -> Self {
        let x = self.value();
        let value = if p == 1.5 { x * x.sqrt() } else { x.powf(p) };
        let limit = |factor: f64, p: f64| match factor {
            0.0 => 0.0,
            _ => factor * x.powf(p),
        };
        self.through(value, || match x == 0.0 {
            true => [limit(p, p - 1.0), limit(p * (p - 1.0), p - 2.0)],
            false => [p * value / x, p * (p - 1.0) * (value / x) / x],
        })
    }

    /// `e^self - 1`.
    #[must_use]
    fn exp_m1(self) -> Self {
        let value = self.value().exp_m1();
        self.through(value, || [value + 1.0; 2])
    }
}

impl Real for f64 {
    fn constant(value: f64) -> f64 {
        value
    }

    fn value(self) -> f64 {
        self
    }

    fn through(self, value: f64, _: impl FnOnce() -> [f64; 2]) -> f64 {
        value
    }
}

impl Real for Jet {
    fn constant(value: f64) -> Jet {
        Jet::of([value, 0.0, 0.0])
    }

    fn value(self) -> f64 {
        self.value
    }

    fn through(self, value: f64, slopes: impl FnOnce() -> [f64; 2]) -> Jet {
        let Jet { slope, bend, .. } = self;
        // An infinite derivative along what does not change is none.
        let times = |factor: f64, rate: f64| if rate == 0.0 { 0.0 } else { factor * rate };
        let [first, second] = slopes();
        let bend = times(second, slope * slope) + times(first, bend);
        Jet::of([value, times(first, slope), bend])
    }
}

impl Jet {
    /// The variable itself.
    pub fn variable(value: f64) -> Jet {
        Jet::of([value, 1.0, 0.0])
    }

    fn of([value, slope, bend]: [f64; 3]) -> Jet {
        Jet { value, slope, bend }
    }

    fn parts(self) -> [f64; 3] {
        [self.value, self.slope, self.bend]
    }
}

impl Add for Jet {
    type Output = Jet;

    fn add(self, b: Jet) -> Jet {
        let (a, b) = (self.parts(), b.parts());
        Jet::of([0, 1, 2].map(|i| a[i] + b[i]))
    }
}

impl Sub for Jet {
    type Output = Jet;

    fn sub(self, b: Jet) -> Jet {
        self + -b
    }
}

impl Mul for Jet {
    type Output = Jet;

    fn mul(self, b: Jet) -> Jet {
        let slope = self.slope * b.value + self.value * b.slope;
        let bend = self.bend * b.value + 2.0 * self.slope * b.slope + self.value * b.bend;
        Jet::of([self.value * b.value, slope, bend])
    }
}

impl Div for Jet {
    type Output = Jet;

    fn div(self, b: Jet) -> Jet {
        let value = self.value / b.value;
        let slope = (self.slope - value * b.slope) / b.value;
        let bend = (self.bend - 2.0 * slope * b.slope - value * b.bend) / b.value;
        Jet { value, slope, bend }
    }
}

impl Neg for Jet {
    type Output = Jet;

    fn neg(self) -> Jet {
        Jet::of(self.parts().map(|part| -part))
    }
}
