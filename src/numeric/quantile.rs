//! Quantiles of the chi-square distribution, of Student's t and of Fisher's F.
//!
//! Gamma functions appear in ratios alone, by their remainder to Stirling's formula, so that many degrees
//! of freedom cost no digits. Source: NIST Digital Library of Mathematical Functions, 5.11.1, 8.11.4,
//! 8.9.2, 8.17.22.

use std::f64::consts::TAU;

use super::find_root;

/// Terms of a series or a continued fraction at most; a hundred thousand degrees of freedom take about a
/// thousand.
const MOST_TERMS: usize = 100_000;
/// Keeps denominators of continued fractions away from 0.
const TINY: f64 = 1e-300;

/// What a variable with this chi-square distribution is below with probability `share`, in 0..1.
pub(crate) fn chi_square_quantile(share: f64, degrees: f64) -> f64 {
    chi_square_between([share, 1.0 - share], degrees)
}

/// What a variable with this chi-square distribution exceeds with probability `alpha`, however small.
pub(crate) fn chi_square_level(alpha: f64, degrees: f64) -> f64 {
    chi_square_between([1.0 - alpha, alpha], degrees)
}

/// The value with these probabilities below and above it.
fn chi_square_between(wanted: [f64; 2], degrees: f64) -> f64 {
    let shape = 0.5 * degrees;
    // In the logarithm, and of the smaller tail, so that relative digits are kept.
    let excess = |u: f64| {
        let (below, above) = gamma_shares(shape, shape * u.exp());
        match wanted[0] <= 0.5 {
            true => below - wanted[0],
            false => wanted[1] - above,
        }
    };
    degrees * increasing_root(excess, shape.sqrt().recip()).exp()
}

/// The probability by which the magnitude of a variable with Student's distribution exceeds `value`.
pub(crate) fn student_outside(value: f64, degrees: f64) -> f64 {
    let square = value * value;
    let all = degrees + square;
    beta_share([0.5 * degrees, 0.5], [degrees / all, square / all])
}

/// What the magnitude of a variable with Student's distribution exceeds with probability `alpha`.
pub(crate) fn student_two_sided(alpha: f64, degrees: f64) -> f64 {
    increasing_root(|u| alpha - student_outside(u.exp(), degrees), 0.5).exp()
}

/// The probability by which a variable with Fisher's distribution exceeds `value`.
pub(crate) fn fisher_tail(value: f64, [above, below]: [f64; 2]) -> f64 {
    let all = below + above * value;
    beta_share(
        [0.5 * below, 0.5 * above],
        [below / all, above * value / all],
    )
}

/// What a variable with Fisher's distribution exceeds with probability `alpha`.
pub(crate) fn fisher_level(alpha: f64, degrees: [f64; 2]) -> f64 {
    increasing_root(|u| alpha - fisher_tail(u.exp(), degrees), 0.5).exp()
}

/// The root of an increasing function, searched around 0 in steps that double.
fn increasing_root(f: impl Fn(f64) -> f64, mut step: f64) -> f64 {
    let (mut low, mut high) = (-step, step);
    while f(high) < 0.0 && high < 700.0 {
        step *= 2.0;
        (low, high) = (high, high + step);
    }
    while f(low) > 0.0 && low > -700.0 {
        step *= 2.0;
        (low, high) = (low - step, low);
    }
    find_root(low, high, f)
}

/// `ln Gamma(a) - ((a - 1/2) ln a - a + ln(2 pi) / 2)`.
pub(crate) fn stirling_remainder(a: f64) -> f64 {
    if a < 12.0 {
        // From the recurrence of the gamma function.
        return stirling_remainder(a + 1.0) + (a + 0.5) * a.recip().ln_1p() - 1.0;
    }
    let square = a.recip().powi(2);
    const TERMS: [f64; 6] = [
        1.0 / 12.0,
        -1.0 / 360.0,
        1.0 / 1260.0,
        -1.0 / 1680.0,
        1.0 / 1188.0,
        -691.0 / 360_360.0,
    ];
    let sum = TERMS.iter().rev().fold(0.0, |sum, c| c + square * sum);
    sum / a
}

/// The regularised incomplete gamma functions `P(a, x)` and `Q(a, x)`.
fn gamma_shares(a: f64, x: f64) -> (f64, f64) {
    if x <= 0.0 {
        return (0.0, 1.0);
    }
    // x^a e^-x / Gamma(a).
    let deviation = (x - a) / a;
    let exponent = -a * (deviation - (x / a).ln()) - stirling_remainder(a);
    let density = (a / TAU).sqrt() * exponent.exp();
    if x < a + 1.0 {
        let (mut term, mut sum) = (a.recip(), a.recip());
        for n in 1..MOST_TERMS {
            term *= x / (a + n as f64);
            sum += term;
            if term < 1e-17 * sum {
                break;
            }
        }
        let below = (density * sum).min(1.0);
        return (below, 1.0 - below);
    }
    let first = x + 1.0 - a;
    let mut constant = first;
    let term = |n: f64| {
        constant += 2.0;
        [[-n * (n - a), constant]]
    };
    let above = (density * fraction(TINY.recip(), first, term)).min(1.0);
    (1.0 - above, above)
}

/// The regularised incomplete beta function `I_x(a, b)`, with `y = 1 - x`.
fn beta_share([a, b]: [f64; 2], [x, y]: [f64; 2]) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if y <= 0.0 {
        return 1.0;
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_share([b, a], [y, x]);
    }
    let all = a + b;
    // x^a y^b / B(a, b).
    let remainders = stirling_remainder(all) - stirling_remainder(a) - stirling_remainder(b);
    let exponent = a * (x * all / a).ln() + b * (y * all / b).ln() + remainders;
    let density = (a * b / (TAU * all)).sqrt() * exponent.exp();
    let terms = |n: f64| {
        let even = n * (b - n) * x / ((a + 2.0 * n - 1.0) * (a + 2.0 * n));
        let odd = -(a + n) * (all + n) * x / ((a + 2.0 * n) * (a + 2.0 * n + 1.0));
        [[even, 1.0], [odd, 1.0]]
    };
    density * fraction(1.0, nonzero(1.0 - all * x / (a + 1.0)), terms) / a
}

/// A continued fraction by the algorithm of Lentz, from its first two denominators and, for each n, the weights and
/// constants of the next ones.
fn fraction<const N: usize>(
    mut c: f64,
    first: f64,
    mut terms: impl FnMut(f64) -> [[f64; 2]; N],
) -> f64 {
    let mut d = first.recip();
    let mut fraction = d;
    for n in 1..MOST_TERMS {
        for [weight, constant] in terms(n as f64) {
            d = nonzero(constant + weight * d).recip();
            c = nonzero(constant + weight / c);
            fraction *= c * d;
        }
        if (c * d - 1.0).abs() < 1e-16 {
            break;
        }
    }
    fraction
}

fn nonzero(value: f64) -> f64 {
    if value.abs() < TINY { TINY } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(serde::Deserialize)]
    struct Reference {
        /// share, degrees, quantile.
        chi_square: Vec<[f64; 3]>,
        /// alpha, degrees, quantile.
        student: Vec<[f64; 3]>,
        /// alpha, degrees of the numerator and of the denominator, quantile.
        fisher: Vec<[f64; 4]>,
    }

    #[test]
    fn val_scipy_quantiles() {
        let reference: Reference =
            serde_json::from_str(include_str!("../../tests/data/quantiles.json")).unwrap();
        let check = |found: f64, expected: f64, most: f64, of: &[f64]| {
            let error = (found / expected - 1.0).abs();
            assert!(error < most, "{of:?}: {error:e}");
        };
        for of @ [share, degrees, expected] in reference.chi_square {
            check(chi_square_quantile(share, degrees), expected, 1e-11, &of);
        }
        // Small tails: `chi2.isf(tail, degrees)` of SciPy 1.17.
        for (degrees, tail, expected) in [
            (2.0, 1e-9, 41.446_531_673_892_82),
            (14.0, 1e-7, 60.395_277_310_941_175),
            (200.0, 1e-6, 309.838_091_990_077_92),
        ] {
            let found = chi_square_level(tail, degrees);
            check(found, expected, 1e-12, &[tail, degrees]);
        }
        for of @ [alpha, degrees, expected] in reference.student {
            check(student_two_sided(alpha, degrees), expected, 1e-11, &of);
            check(student_outside(expected, degrees), alpha, 1e-10, &of);
        }
        for of @ [alpha, above, below, expected] in reference.fisher {
            check(fisher_level(alpha, [above, below]), expected, 1e-11, &of);
            check(fisher_tail(expected, [above, below]), alpha, 1e-10, &of);
        }
    }
}
