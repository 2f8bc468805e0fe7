//! Largest Lyapunov exponents.

use test_support::scenes::{near, parsed, rows, simulation};
use wavecascade::observer::Silent;

/// SciPy 1.17: `y' = f(y), Y' = J(y) Y` together by DOP853 (rtol 2.3e-14, atol 1e-15), `Y(0) = (0, cos j)`, tau of
/// `F(v tau) tau = v`.
const KNOWN: &str = "
# Keys | end | logarithm of |Y| over t after an eighth, a quarter, a half and all of the time.
law = 'spring'\\nbeta = 1\\nstriker_velocity = 3 | 80 | 0.16391548 0.13078095 0.09497242 0.0797064
law = 'spring'\\nalpha = 0.25\\nbeta = 0.5\\nstriker_velocity = 4 | 80 | 0.15189021 0.11065169 0.07822362 0.06958901
# Integrable: its exponent falls to 0.
law = 'toda 1'\\nstriker_velocity = 2 | 400 | 0.03109913 0.02455517 0.0148239 0.00952882
";

#[test]
fn val_scipy_variational_equations() {
    for [keys, end, known] in rows(KNOWN) {
        let it = simulation(&format!(
            "sites = 8\nends = 'fixed'\nend_time = {end}\ntolerance = 1e-11\n{keys}"
        ));
        let found = it.lyapunov(end.parse().unwrap(), &Silent).unwrap();
        assert_eq!(found.exponent, found.convergence[3][1]);
        for ([t, found], known) in found.convergence.into_iter().zip(parsed(&known)) {
            near(found, known, 1e-7, (&keys, t));
            assert!(!keys.contains("toda") || found * t < t.ln());
        }
    }
}

/// The beta chain (0.1) at an energy of about 18 a body: 0.18 by the geometric theory of L. Casetti, R. Livi, M. Pettini, Phys. Rev.
/// Lett. 74 (1995) 375, of which runs of 64 bodies by the method of Verlet find four fifths.
#[test]
fn val_published_exponent_of_the_beta_chain() {
    let it = simulation(
        "sites = 16\nends = \"periodic\"\nlaw = \"spring\"\nbeta = 0.1\nmodes = [1, 15]\nmode_energy = 10\ntolerance = 1e-4\nend_time = 100.0",
    );
    let found = it.lyapunov(100.0, &Silent).unwrap();
    assert!((0.11..0.19).contains(&found.exponent), "{found:?}");
}
