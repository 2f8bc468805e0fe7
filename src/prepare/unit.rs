//! The power of two that amplitudes are divided by, so that their squares stay in range: exact but where a quotient is
//! subnormal, far below the largest.

use crate::arrays::Precision;

/// 1 while squares of `largest` are far inside the number range, else the power of two at or
/// below it.
pub(super) fn near(largest: f64, precision: Precision) -> f64 {
    let safe = match precision {
        Precision::F64 => -200.0..200.0,
        Precision::F32 => -20.0..20.0,
    };
    // The logarithm of the largest number is rounded up.
    let exponent = largest.log2().floor().min(1023.0);
    match largest == 0.0 || safe.contains(&exponent) {
        true => 1.0,
        false => exponent.exp2(),
    }
}

/// Whether numbers up to `largest` are too small in this unit for their spectra to be computed.
pub(super) fn loses(unit: f64, largest: f64, precision: Precision) -> bool {
    let least = match precision {
        Precision::F64 => -450.0,
        Precision::F32 => -90.0,
    };
    largest > 0.0 && (largest / unit).log2() < least
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_bring_any_amplitude_to_one() {
        for largest in [5e-324, 1e-310, 1e-200, 1e200, f64::MAX] {
            let unit = near(largest, Precision::F64);
            let one = largest / unit;
            assert!((1.0..2.0).contains(&one), "{largest:e} became {one}");
            assert_eq!(one * unit, largest);
        }
        assert_eq!(near(3.0, Precision::F64), 1.0);
        let unit = near(1e40, Precision::F32);
        assert!(loses(unit, 1.0, Precision::F32) && !loses(unit, 1.0, Precision::F64));
        assert!(!loses(unit, 1e20, Precision::F32) && !loses(unit, 0.0, Precision::F32));
    }
}
