//! Roots of one-dimensional functions.

/// The root of `f` between `a` and `b`, where `f` has opposite signs, to the last digits.
///
/// Source: T. R. Chandrupatla, Advances in Engineering Software 28 (1997) 145-149.
pub(crate) fn between(mut a: f64, mut b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut fa, mut fb) = (f(a), f(b));
    let mut share = 0.5;
    loop {
        if fa == 0.0 {
            return a;
        }
        if fb == 0.0 {
            return b;
        }
        let x = a + share * (b - a);
        let fx = f(x);
        let (c, fc) = if fx.is_sign_negative() == fa.is_sign_negative() {
            (a, fa)
        } else {
            let behind = (b, fb);
            (b, fb) = (a, fa);
            behind
        };
        (a, fa) = (x, fx);
        let best = if fa.abs() < fb.abs() { a } else { b };
        let limit = 2.0 * f64::EPSILON * best.abs() + f64::MIN_POSITIVE;
        let least = limit / (b - a).abs();
        if least > 0.5 {
            return best;
        }
        let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        share = if phi * phi < xi && (1.0 - phi).powi(2) < 1.0 - xi {
            fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        } else {
            0.5
        };
        share = share.clamp(least, 1.0 - least);
    }
}
