//! The natural logarithm without branches, so that loops of it run in registers of any width.

/// `ln x` of a positive normal number; the bits do not depend on the processor.
///
/// Error below 1 unit in the last place. 0 and smaller positive numbers give some finite number.
///
/// `x = 2^k (1 + f)` with `1 + f` between `sqrt(1/2)` and `sqrt(2)`; `ln(1 + f)` is
/// `f - f^2/2 + s (f^2/2 + R(s^2))`, `s = f / (2 + f)`, with a polynomial R.
///
/// Source: `e_log.c` of fdlibm, Sun Microsystems 1993, which has the polynomial and the bound.
#[inline(always)]
pub(crate) fn ln_normal(x: f64) -> f64 {
    const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    const L: [f64; 7] = [
        6.666_666_666_666_735e-1,
        3.999_999_999_940_942e-1,
        2.857_142_874_366_239e-1,
        2.222_219_843_214_978_4e-1,
        1.818_357_216_161_805e-1,
        1.531_383_769_920_937_3e-1,
        1.479_819_860_511_658_6e-1,
    ];
    /// High bits of `sqrt(1/2)`, and how far they are from those of 1.
    const ROOT: u64 = 0x3fe6_a09e << 32;
    const FROM_ONE: u64 = (0x3ff0_0000 - 0x3fe6_a09e) << 32;
    let bits = x.to_bits().wrapping_add(FROM_ONE);
    // 2^52 + n has the integer n as its last bits.
    let exponent = f64::from_bits(0x4330 << 48 | bits >> 52);
    let k = exponent - (4_503_599_627_370_496.0 + 1023.0);
    let f = f64::from_bits((bits & ((1 << 52) - 1)) + ROOT) - 1.0;
    let half_square = 0.5 * f * f;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let even = w * (L[1] + w * (L[3] + w * L[5]));
    let odd = z * (L[0] + w * (L[2] + w * (L[4] + w * L[6])));
    s * (half_square + (even + odd)) + k * LN2_LOW - half_square + f + k * LN2_HIGH
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Units in the last place of `right` that `x` is away from it.
    fn apart(x: f64, right: f64) -> f64 {
        let unit = f64::from_bits(right.abs().to_bits() + 1) - right.abs();
        ((x - right) / unit).abs()
    }

    /// Known to 20 digits: `ln 2`, `ln 10`, and the logarithm of the least normal number, `-1022 ln
    /// 2`.
    #[test]
    fn val_known_logarithms() {
        assert_eq!(ln_normal(1.0), 0.0);
        assert!(ln_normal(0.0).is_finite() && ln_normal(5e-324).is_finite());
        for (x, right) in [
            (2.0, std::f64::consts::LN_2),
            (0.5, -std::f64::consts::LN_2),
            (10.0, std::f64::consts::LN_10),
            (std::f64::consts::E, 1.0),
            (f64::MIN_POSITIVE, -708.396_418_532_264_1),
            (f64::MAX, 709.782_712_893_384),
        ] {
            assert!(apart(ln_normal(x), right) <= 1.0, "{x:e}");
        }
    }

    /// The standard library's is right to about half a unit.
    #[test]
    fn val_standard_library_over_all_exponents_and_beside_one() {
        let mut worst: f64 = 0.0;
        let mut state: u64 = 1;
        for i in 0..400_000_u64 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let fraction = state >> 12;
            // Every second number is within a few octaves of 1.
            let exponent = [1 + i / 2 % 2046, 1021 + i / 2 % 4][i as usize % 2];
            let x = f64::from_bits(exponent << 52 | fraction);
            let near = 1.0 + (fraction as f64 - 2e15) * 2f64.powi(-40 - (i % 60) as i32);
            for x in [x, near].into_iter().filter(|x| x.is_normal() && *x > 0.0) {
                worst = worst.max(apart(ln_normal(x), x.ln()));
            }
        }
        assert!((0.5..=1.0).contains(&worst), "{worst}");
    }
}
