//! Complete elliptic integrals of an ellipse given by `w = ln(a / b)`, without cancellation.
//!
//! With the complementary modulus `k' = b / a = e^{-w}` and the complete integrals K, E,
//! `D = (K - E) / k^2` and `B = K - D`, everything a Hertz contact needs is even or odd in w:
//!
//! ```text
//! K = (pi / 2) e^{w/2} / M(w),   M(w) = agm(1, cosh(w / 2)),   rho(w) = (D - B) / K.
//! ```
//!
//! Both come from one arithmetic-geometric mean whose terms are all positive, so that neither the
//! circle (w = 0, where every textbook form is 0/0) nor the line (w to infinity, where `1 - k'^2`
//! rounds to 1) loses digits.
//!
//! Source: M. Abramowitz, I. A. Stegun, *Handbook of Mathematical Functions*, section 17.6.

/// `M(w) - 1` and `rho(w)`, see the [module](self) documentation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EllipseIntegrals {
    pub(crate) mean_excess: f64,
    pub(crate) rho: f64,
}

/// `M(w) - 1` and `rho(w)` for `0 <= w < 1400`, each to a few units in the last place.
pub(crate) fn ellipse_integrals(w: f64) -> EllipseIntegrals {
    let mut p = 2.0 * (0.25 * w).sinh().powi(2);
    let mut q = 0.0;
    let mut c = (0.5 * w).sinh();
    let mut term = 0.5 * (0.5 * w).tanh();
    let mut rho = term;
    while c > 1e-9 * (1.0 + p) {
        let mean = 0.5 * (p + q);
        let sum = p + q + p * q;
        c *= c / (4.0 * (1.0 + mean));
        q = sum / (1.0 + (1.0 + sum).sqrt());
        p = mean;
        term *= c / (2.0 * (1.0 + p));
        rho += term;
    }
    EllipseIntegrals {
        mean_excess: 0.5 * (p + q),
        rho,
    }
}
