//! Largest Lyapunov exponents.

use wavecascade::chain::Lyapunov;
use wavecascade::chain::scene::SceneSource;
use wavecascade::observer::Silent;

fn lyapunov(scene: &str, end: f64) -> Lyapunov {
    let scene = SceneSource::new(None, format!("{scene}\nend_time = {end:?}"));
    let simulation = scene.setup().unwrap().simulation;
    simulation.lyapunov(end, &Silent).unwrap()
}

/// SciPy 1.17: `y' = f(y), Y' = J(y) Y` together by DOP853 (rtol 2.3e-14, atol 1e-15), `Y(0) = (0, cos j)`, tau of
/// `F(v tau) tau = v`, the logarithm of `|Y|` over t after an eighth, a quarter, a half and all of the time.
#[test]
fn val_scipy_variational_equations() {
    const HEAD: &str = "sites = 8\nends = \"fixed\"\n";
    let [beta, both] = [
        "beta = 1\nstriker_velocity = 3",
        "alpha = 0.25\nbeta = 0.5\nstriker_velocity = 4",
    ]
    .map(|keys| format!("law = \"spring\"\n{keys}"));
    // Integrable: its exponent falls to 0.
    let toda = "law = \"toda 1\"\nstriker_velocity = 2".to_owned();
    for (scene, end, known) in [
        (&beta, 80.0, [0.16391548, 0.13078095, 0.09497242, 0.0797064]),
        (
            &both,
            80.0,
            [0.15189021, 0.11065169, 0.07822362, 0.06958901],
        ),
        (
            &toda,
            400.0,
            [0.03109913, 0.02455517, 0.0148239, 0.00952882],
        ),
    ] {
        let found = lyapunov(&format!("{HEAD}{scene}\ntolerance = 1e-11"), end);
        assert_eq!(found.exponent, found.convergence[3][1]);
        for ([t, found], known) in found.convergence.into_iter().zip(known) {
            assert!(
                (found - known).abs() < 1e-7,
                "{scene}: {found} {known} at {t}"
            );
            assert!(scene != &toda || found * t < t.ln(), "{found} at {t}");
        }
    }
}

/// The beta chain (0.1) at an energy of about 18 a body: 0.18 by the geometric theory of L. Casetti, R. Livi, M. Pettini, Phys. Rev.
/// Lett. 74 (1995) 375, of which runs of 64 bodies by the method of Verlet find four fifths.
#[test]
fn val_published_exponent_of_the_beta_chain() {
    let scene = "sites = 16\nends = \"periodic\"\nlaw = \"spring\"\nbeta = 0.1\nmodes = [1, 15]\nmode_energy = 10\ntolerance = 1e-4";
    let found = lyapunov(scene, 100.0);
    assert!((0.11..0.19).contains(&found.exponent), "{found:?}");
}
