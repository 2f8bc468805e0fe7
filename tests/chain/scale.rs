//! The speed that errors are relative to, where it is not that of a striker.

use test_support::fields::fixed;
use wavecascade::chain::{Accuracy, Chain, Drive, Ends, Law, Simulation, Waveform};
use wavecascade::observer::Silent;

fn springs(n: usize, ends: Ends, alpha: f64, beta: f64) -> Simulation {
    let mut chain = Chain::dimer(n, 1.0);
    chain.law = Law::Spring { alpha, beta }.into();
    chain.ends = ends;
    if ends == Ends::Free {
        chain.coefficient.pop();
    }
    Simulation::impact(chain, 0.0, 20.0, 16)
}

/// Linear chains: velocities of initial displacements and of tiny initial speeds add up.
#[test]
fn val_superposition_a_tiny_speed_beside_large_displacements() {
    let fixed = fixed(1.0);
    let mut s = springs(10, fixed, 0.0, 0.0);
    s.displacement[0] = 1.0;
    let without = s.run(&Silent).unwrap();
    s.velocity[0] = 1e-12;
    let with = s.run(&Silent).unwrap();
    assert_eq!(with.report.velocity_scale, without.report.velocity_scale);
    let off = (&with.velocity - &without.velocity)
        .iter()
        .fold(0.0f64, |m, d| m.max(d.abs()));
    assert!(off > 1e-13 && off < 3e-12, "{off:e}");
}

/// A force that rises slowly for longer than the run: `m v = integral of the force` for all sites
/// together, at the tolerance of the largest speed.
#[test]
fn val_momentum_of_a_slow_push() {
    let wave = Waveform::half_sine(1e-3, 1e6);
    let mut chain = Chain::dimer(20, 1.0);
    chain.ends = Ends::Free;
    chain.coefficient.pop();
    let mut s = Simulation::impact(chain, 0.0, 1000.0, 50);
    s.drive = Some(Drive::Force(wave));
    for tolerance in [1e-5, 1e-9] {
        s.accuracy = Accuracy::Tolerance(tolerance);
        let run = s.run(&Silent).unwrap();
        let largest = run.velocity.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let scale = run.report.velocity_scale;
        assert!((scale / largest - 1.0).abs() < 0.2, "{scale:e} {largest:e}");
        let momentum: f64 = run.velocity.row(49).sum();
        let rate = std::f64::consts::PI / 1e6;
        let impulse = 1e-3 * 2.0 * (0.5 * rate * 1000.0f64).sin().powi(2) / rate;
        let off = (momentum - impulse).abs() / (20.0 * largest);
        assert!(off < tolerance, "{tolerance:e}: {off:e}");
    }
}

/// A chain whose contacts hold less energy than at rest moves all the same.
#[test]
fn val_identity_energy_below_that_of_rest() {
    let mut s = springs(4, Ends::Free, 3.0, 1.5);
    s.displacement[0] = 1.0;
    let run = s.run(&Silent).unwrap();
    assert!(run.report.velocity_scale > 0.1, "{:?}", run.report);
    assert!(run.report.energy_drift.unwrap() < 1e-9, "{:?}", run.report);
}
