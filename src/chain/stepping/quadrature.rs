//! Gauss-Jacobi rules on 0..1, for integrands that start or end like a power.

/// Nodes and weights: `integral of s^left (1 - s)^right g(s) ds = sum w g(s)`.
pub(crate) type Rule = Vec<(f64, f64)>;

/// The rule of `n` nodes, by Newton's method on the Jacobi polynomial with deflation.
///
/// Source: G. Szego, *Orthogonal Polynomials* (1939), sections 4.5 and 15.3.
pub(crate) fn gauss_jacobi(n: usize, left: f64, right: f64) -> Rule {
    let mut nodes: Vec<f64> = Vec::with_capacity(n);
    for k in 0..n {
        let mut z = -(std::f64::consts::PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
        for _ in 0..60 {
            let (p, slope) = jacobi(n, right, left, z);
            let deflation: f64 = nodes.iter().map(|other| 1.0 / (z - other)).sum();
            let step = p / (slope - p * deflation);
            z -= step;
            if step.abs() <= 4.0 * f64::EPSILON {
                break;
            }
        }
        nodes.push(z);
    }
    nodes.sort_by(f64::total_cmp);
    let raw = nodes.iter().map(|&z| {
        let (_, slope) = jacobi(n, right, left, z);
        1.0 / ((1.0 - z * z) * slope * slope)
    });
    let raw: Vec<f64> = raw.collect();
    let scale = beta(left + 1.0, right + 1.0) / raw.iter().sum::<f64>();
    let rule = nodes.iter().zip(raw);
    rule.map(|(z, w)| (0.5 * (1.0 + z), w * scale)).collect()
}

/// The Jacobi polynomial of degree n and its derivative on -1..1.
fn jacobi(n: usize, alpha: f64, beta: f64, z: f64) -> (f64, f64) {
    let (mut previous, mut p) = (0.0, 1.0);
    let (mut slope_previous, mut slope) = (0.0, 0.0);
    for k in 1..=n {
        let k = k as f64;
        let sum = 2.0 * k + alpha + beta;
        let scale = 2.0 * k * (k + alpha + beta) * (sum - 2.0);
        // The general recurrence is 0/0 in its constant term at k = 1 with alpha + beta = 0.
        let (factor, shift, back) = if k == 1.0 {
            (0.5 * (alpha + beta + 2.0), 0.5 * (alpha - beta), 0.0)
        } else {
            (
                (sum - 1.0) * sum * (sum - 2.0) / scale,
                (sum - 1.0) * (alpha * alpha - beta * beta) / scale,
                2.0 * (k + alpha - 1.0) * (k + beta - 1.0) * sum / scale,
            )
        };
        let line = factor * z + shift;
        let next_slope = factor * p + line * slope - back * slope_previous;
        let next = line * p - back * previous;
        (previous, p) = (p, next);
        (slope_previous, slope) = (slope, next_slope);
    }
    (p, slope)
}

/// Euler's beta function.
fn beta(a: f64, b: f64) -> f64 {
    let shift = 12.0;
    if a < shift {
        return beta(a + 1.0, b) * (a + b) / a;
    }
    if b < shift {
        return beta(a, b + 1.0) * (a + b) / b;
    }
    (ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b)).exp()
}

/// Stirling's series, for arguments of 12 and above.
fn ln_gamma(x: f64) -> f64 {
    let r = 1.0 / (x * x);
    let series =
        (1.0 / 12.0 - r * (1.0 / 360.0 - r * (1.0 / 1260.0 - r * (1.0 / 1680.0 - r / 1188.0)))) / x;
    (x - 0.5) * x.ln() - x + 0.5 * (2.0 * std::f64::consts::PI).ln() + series
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments `B(left + 1 + q, right + 1)` are exact up to degree 2n - 1.
    #[test]
    fn val_beta_function_moments() {
        for (left, right) in [(1.5, 0.0), (1.5, 1.5), (1.1, 0.0), (3.0, 3.0), (0.0, 0.0)] {
            for n in [4, 6, 8] {
                let rule = gauss_jacobi(n, left, right);
                for q in 0..2 * n {
                    let sum: f64 = rule.iter().map(|(s, w)| w * s.powi(q as i32)).sum();
                    let exact = beta(left + 1.0 + q as f64, right + 1.0);
                    let off = (sum / exact - 1.0).abs();
                    assert!(off < 5e-14, "{left} {right} {n} {q}: {off:e}");
                }
            }
        }
        assert!((beta(2.5, 2.5) / (3.0 * std::f64::consts::PI / 128.0) - 1.0).abs() < 1e-13);
    }
}
