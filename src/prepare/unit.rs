//! The power of two that amplitudes are divided by.

use crate::arrays::Precision;

/// A power of two, possibly beyond the range in which one factor can divide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PowerOfTwo {
    exponent: i32,
}

impl PowerOfTwo {
    pub const ONE: PowerOfTwo = PowerOfTwo { exponent: 0 };

    /// 1 while squares of `largest` are far inside the number range, else the power of two at or
    /// below it.
    pub fn near(largest: f64, precision: Precision) -> PowerOfTwo {
        if largest == 0.0 {
            return Self::ONE;
        }
        let exponent = exponent_of(largest);
        let safe = match precision {
            Precision::F64 => -200..200,
            Precision::F32 => -20..20,
        };
        match safe.contains(&exponent) {
            true => Self::ONE,
            false => PowerOfTwo { exponent },
        }
    }

    /// Whether numbers up to `largest` are too small in this unit for their spectra to be computed.
    pub fn loses(self, largest: f64, precision: Precision) -> bool {
        let least = match precision {
            Precision::F64 => -450,
            Precision::F32 => -90,
        };
        largest > 0.0 && exponent_of(largest) - self.exponent < least
    }

    pub fn value(self) -> f64 {
        let half = self.exponent / 2;
        2f64.powi(half) * 2f64.powi(self.exponent - half)
    }

    /// Exact but where a quotient is subnormal, far below the largest.
    pub fn divide(self, values: &mut [f64]) {
        if self == Self::ONE {
            return;
        }
        let half = -self.exponent / 2;
        let (a, b) = (2f64.powi(half), 2f64.powi(-self.exponent - half));
        values.iter_mut().for_each(|v| *v = *v * a * b);
    }
}

/// `floor(log2 x)` of a positive finite number, subnormal ones included.
fn exponent_of(x: f64) -> i32 {
    let bits = |x: f64| ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    match x < f64::MIN_POSITIVE {
        true => bits(x * 2f64.powi(64)) - 64,
        false => bits(x),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_bring_any_amplitude_to_one() {
        for largest in [5e-324, 1e-310, 1e-200, 1e200, f64::MAX] {
            let unit = PowerOfTwo::near(largest, Precision::F64);
            let mut x = [largest];
            unit.divide(&mut x);
            assert!((1.0..2.0).contains(&x[0]), "{largest:e} became {}", x[0]);
            assert_eq!(x[0] * unit.value(), largest);
        }
        assert_eq!(PowerOfTwo::near(3.0, Precision::F64), PowerOfTwo::ONE);
        let unit = PowerOfTwo::near(1e40, Precision::F32);
        assert!(unit.loses(1.0, Precision::F32) && !unit.loses(1.0, Precision::F64));
        assert!(!unit.loses(1e20, Precision::F32) && !unit.loses(0.0, Precision::F32));
    }
}
