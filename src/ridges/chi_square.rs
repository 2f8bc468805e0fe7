//! Quantiles of chi-square: levels of spectra of noise.

/// `sqrt(2 / degrees)` steps that a quantile is bracketed by.
const STEPS: f64 = 2.0;

/// The value that chi-square of `degrees` degrees of freedom, divided by them, exceeds with probability
/// `tail`.
pub(super) fn exceeded(degrees: f64, tail: f64) -> f64 {
    let half = degrees / 2.0;
    let step = STEPS / half.sqrt();
    let mut high = 1.0 + step;
    while upper_gamma(half, half * high) > tail && high < 1e6 {
        high += step.max(0.5 * high);
    }
    let mut low = 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        match upper_gamma(half, half * middle) > tail {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

/// The regularized upper incomplete gamma function Q(a, x), by its series below `a + 1` and its continued
/// fraction above.
///
/// Source: Abramowitz and Stegun, 6.5.29 and 6.5.31; Lentz's evaluation of the fraction.
fn upper_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-17 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - front * sum;
    }
    let mut b = x + 1.0 - a;
    let mut c = 1e300;
    let mut d = 1.0 / b;
    let mut value = d;
    for i in 1..10_000 {
        let i = f64::from(i);
        let step = -i * (i - a);
        b += 2.0;
        d = 1.0 / (step * d + b);
        c = b + step / c;
        let factor = d * c;
        value *= factor;
        if (factor - 1.0).abs() < 1e-16 {
            break;
        }
    }
    front * value
}

/// `ln Gamma(x)` for x > 0, by Stirling's series after shifting x above 12.
fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut shift) = (x, 0.0);
    while x < 12.0 {
        shift += x.ln();
        x += 1.0;
    }
    let inverse = 1.0 / (x * x);
    let series =
        (1.0 / 12.0 - inverse * (1.0 / 360.0 - inverse * (1.0 / 1260.0 - inverse / 1680.0))) / x;
    (x - 0.5) * x.ln() - x + 0.5 * std::f64::consts::TAU.ln() + series - shift
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SciPy 1.17: `chi2.isf(tail, degrees) / degrees`.
    #[test]
    fn val_scipy_quantiles() {
        for (degrees, tail, expected) in [
            (2.0, 0.05, 2.995_732_273_553_991_3),
            (2.0, 1e-9, 20.723_265_836_946_41),
            (14.0, 0.5, 0.952_805_296_364_252_8),
            (14.0, 1e-7, 4.313_948_379_352_941),
            (7.3, 0.01, 2.597_861_284_091_047),
            (200.0, 1e-6, 1.549_190_459_950_389_6),
        ] {
            let found = exceeded(degrees, tail);
            assert!(
                (found / expected - 1.0).abs() < 1e-12,
                "{degrees} {tail}: {found:.16}"
            );
        }
    }
}
