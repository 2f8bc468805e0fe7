//! Quantiles of the chi-square distribution and of Student's t, for any positive degrees of freedom.

use super::root;

/// Terms of a series or a continued fraction, at most.
const TERMS: usize = 10_000;

/// `x` that a chi-square variable of `freedom` degrees stays below with probability `p`.
pub(crate) fn chi_square_quantile(p: f64, freedom: f64) -> f64 {
    let shape = 0.5 * freedom;
    let mut high = freedom.max(1.0);
    while gamma_share(shape, 0.5 * high) < p && high < 1e300 {
        high *= 2.0;
    }
    root::between(0.0, high, |x| gamma_share(shape, 0.5 * x) - p)
}

/// `t` within which a variable of Student's distribution of `freedom` degrees lies, both signs, with
/// probability `p`.
pub(crate) fn student_within(p: f64, freedom: f64) -> f64 {
    let mut high = 1.0;
    while student_outside(high, freedom) > 1.0 - p && high < 1e150 {
        high *= 2.0;
    }
    root::between(0.0, high, |x| student_outside(x, freedom) - (1.0 - p))
}

/// Probability that a variable of Student's distribution lies beyond `t` to either side. Source: DLMF 8.17, Abramowitz
/// and Stegun 26.7.1.
pub(crate) fn student_outside(t: f64, freedom: f64) -> f64 {
    beta_share(freedom / (freedom + t * t), 0.5 * freedom, 0.5)
}

/// `ln Gamma(x)`, `x > 0`, to a few units of the last digit. Source: C. Lanczos, SIAM J. Numer. Anal. 1,
/// 86 (1964), with the coefficients of g = 7, n = 9.
pub(crate) fn ln_gamma(x: f64) -> f64 {
    const TERMS: [f64; 8] = [
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    let x = x - 1.0;
    let sum = TERMS
        .iter()
        .zip(1u32..)
        .fold(0.999_999_999_999_809_9, |sum, (c, i)| {
            sum + c / (x + f64::from(i))
        });
    let t = x + 7.5;
    0.5 * std::f64::consts::TAU.ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

/// The regularized lower incomplete gamma function `P(a, x)`. Source: DLMF 8.11.4 and 8.9.2.
fn gamma_share(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for n in 1..TERMS {
            term *= x / (a + n as f64);
            sum += term;
            if term < f64::EPSILON * sum {
                break;
            }
        }
        return (front * sum).min(1.0);
    }
    // Lentz's evaluation of the continued fraction of the complement.
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (f64::INFINITY, 1.0 / b);
    let mut fraction = d;
    for n in 1..TERMS {
        let n = n as f64;
        let step = -n * (n - a);
        b += 2.0;
        d = 1.0 / (step * d + b);
        c = b + step / c;
        fraction *= c * d;
        if (c * d - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    1.0 - front * fraction
}

/// The regularized incomplete beta function `I_x(a, b)`. Source: DLMF 8.17.22, by Lentz's evaluation.
fn beta_share(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_share(1.0 - x, b, a);
    }
    let ln_front = a * x.ln() + b * (-x).ln_1p() + ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b);
    let (mut c, mut d) = (1.0, 1.0 / (1.0 - (a + b) * x / (a + 1.0)));
    let mut fraction = d;
    for m in 1..TERMS {
        let m = m as f64;
        let before = fraction;
        for step in [
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0)),
        ] {
            d = 1.0 / (1.0 + step * d);
            c = 1.0 + step / c;
            fraction *= c * d;
        }
        if (fraction - before).abs() < f64::EPSILON * fraction.abs() {
            break;
        }
    }
    ln_front.exp() * fraction / a
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `scipy.stats.chi2.ppf` and `scipy.stats.t.ppf`, SciPy 1.17.1.
    #[test]
    fn val_scipy_quantiles() {
        for (p, freedom, expected) in CHI_SQUARE {
            let found = chi_square_quantile(p, freedom);
            assert!(
                (found / expected - 1.0).abs() < 1e-12,
                "{p} {freedom} {found}"
            );
        }
        for (p, freedom, expected) in STUDENT {
            let found = student_within(p, freedom);
            assert!(
                (found / expected - 1.0).abs() < 1e-12,
                "{p} {freedom} {found}"
            );
        }
    }

    /// Probability, degrees of freedom, quantile.
    const CHI_SQUARE: [(f64, f64, f64); 8] = [
        (0.025, 2.0, 0.05063561596857975),
        (0.975, 2.0, 7.377758908227871),
        (0.025, 30.0, 16.79077226556663),
        (0.975, 30.0, 46.97924224367115),
        (0.025, 58.8, 39.49806510716661),
        (0.975, 58.8, 81.88116800780182),
        (0.05, 1000.0, 927.594363020979),
        (0.995, 7.3, 20.78593231890649),
    ];
    /// Probability of both sides, degrees of freedom, quantile.
    const STUDENT: [(f64, f64, f64); 5] = [
        (0.95, 1.0, 12.706204736174694),
        (0.95, 3.0, 3.1824463052837078),
        (0.95, 30.0, 2.0422724563012378),
        (0.99, 7.5, 3.421422688124044),
        (0.95, 1000.0, 1.9623390808264083),
    ];
}
