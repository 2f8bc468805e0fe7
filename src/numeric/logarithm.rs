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

    /// The standard library's is right to about half a unit in the last place: over all exponents, and beside 1.
    #[test]
    fn val_standard_library_logarithms() {
        let apart = |x: f64| {
            let right = x.ln();
            let unit = f64::from_bits(right.abs().to_bits() + 1) - right.abs();
            ((ln_normal(x) - right) / unit).abs()
        };
        let mut worst = apart(f64::MIN_POSITIVE).max(apart(f64::MAX));
        let mut state = 1;
        for i in 0..400_000 {
            let fraction = crate::numeric::next_uniform(&mut state);
            let exponent = [i % 2046 - 1022, i % 4 - 2][i as usize / 2 % 2];
            let near = 1.0 + (fraction - 0.5) * 2f64.powi(-(i % 60));
            for x in [(1.0 + fraction) * 2f64.powi(exponent), near] {
                worst = worst.max(apart(x));
            }
        }
        assert!((0.5..=1.0).contains(&worst), "{worst}");
        assert_eq!(ln_normal(1.0), 0.0);
        assert!(ln_normal(0.0).is_finite() && ln_normal(5e-324).is_finite());
    }
}
