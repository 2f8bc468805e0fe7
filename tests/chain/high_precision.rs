//! Chains against a program of another method in twice the precision.
//!
//! `data/dimer_14.622.npz` and `data/collisions.json` were made on 2026-11-21 by
//! `data/chain_reference.py shipped`: Stoermer extrapolation of order 22 in double-double
//! arithmetic, local error 1e-24; from 1e-22 to 1e-24 the velocities of the dimer change by 6e-17.
//! The same program repeats the trajectories of a third one, of order 12 in double-double
//! arithmetic, to 7e-15 at six stiffness ratios (`data/chain_reference.py check`).

use ndarray::{Array1, Array2};
use ndarray_npy::NpzReader;
use test_support::fields::chain;
use wavecascade::chain::{Accuracy, Chain, Ends, Law, Record, RunWarning, Scheme, Simulation};
use wavecascade::observer::Silent;

fn data(name: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name)
}

#[test]
fn val_double_double_dimer_14_622_tolerances_are_delivered() {
    let file = std::fs::File::open(data("dimer_14.622.npz")).unwrap();
    let mut npz = NpzReader::new(file).unwrap();
    let time: Array1<f64> = npz.by_name("t").unwrap();
    let velocity: Array2<f64> = npz.by_name("v").unwrap();
    let (samples, sites) = velocity.dim();
    let mut simulation =
        Simulation::impact(Chain::dimer(sites, 14.622), 1.0, time[samples - 1], samples);
    simulation.record = Record::default();
    let mut delivered = |scheme, exponent: i32| {
        simulation.scheme = scheme;
        simulation.accuracy = Accuracy::Tolerance(10f64.powi(-exponent));
        let run = simulation.run(&Silent).unwrap();
        let warnings = run.report.warnings;
        assert_eq!(run.time, time);
        let pairs = run.velocity.iter().zip(&velocity);
        let worst = pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()));
        println!("{scheme:?} 1e-{exponent}: {worst:.1e} {warnings:?}");
        (worst, warnings)
    };
    for exponent in 4..=10 {
        let (worst, warnings) = delivered(Scheme::Nystrom, exponent);
        assert!(warnings.is_empty(), "{warnings:?}");
        assert!(worst <= 10f64.powi(-exponent), "1e-{exponent}: {worst:e}");
    }
    // The chain amplifies rounding to this, and the run says so.
    let (worst, warnings) = delivered(Scheme::Nystrom, 11);
    assert!(worst <= 1.2e-11, "1e-11: {worst:e}");
    assert_eq!(warnings.len(), 1);
    // Nor are the steps needlessly short.
    assert!(delivered(Scheme::Nystrom, 4).0 > 1e-9);
    let (worst, warnings) = delivered(Scheme::RungeKutta, 8);
    assert!(worst <= 1e-8 && warnings.is_empty(), "{worst:e}");
}

#[derive(serde::Deserialize)]
struct Collisions {
    cases: Vec<Collision>,
}

#[derive(serde::Deserialize)]
struct Collision {
    mass: Vec<f64>,
    coefficient: Vec<f64>,
    velocity: Vec<f64>,
}

/// The first body strikes two at rest; the outcome depends on the contacts, not on the masses alone.
#[test]
fn val_double_double_three_bodies_collide() {
    let text = std::fs::read_to_string(data("collisions.json")).unwrap();
    let collisions: Collisions = serde_json::from_str(&text).unwrap();
    assert_eq!(collisions.cases.len(), 3);
    for case in collisions.cases {
        let chain = chain(case.mass.clone(), case.coefficient, Law::Hertz, Ends::Free);
        for scheme in [Scheme::Nystrom, Scheme::RungeKutta] {
            let mut simulation = Simulation::impact(chain.clone(), 1.0, 30.0, 2);
            simulation.scheme = scheme;
            simulation.accuracy = Accuracy::Tolerance(1e-12);
            let run = simulation.run(&Silent).unwrap();
            let pairs = run.velocity.row(1).into_iter().zip(&case.velocity);
            let worst = pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()));
            println!("{scheme:?} {:?}: {worst:.1e}", case.mass);
            assert!(worst < 1e-14, "{scheme:?} {:?}: {worst:e}", case.mass);
        }
    }
}

/// Two bodies, whatever their contact, part as momentum and energy say; equal ones exchange their
/// velocities.
#[test]
fn val_closed_form_two_bodies_exchange_momentum() {
    for (m, [v0, v1]) in [
        (1.0, [0.7, -0.4]),
        (1.0, [3.0, 2.0]),
        (5.0, [1.0, -1.0]),
        (1e-3, [1.0, 0.0]),
        (1e3, [0.0, -2.0]),
    ] {
        let chain = chain(vec![1.0, m], vec![2.0], Law::Hertz, Ends::Free);
        let mut simulation = Simulation::impact(chain, v0, 20.0, 2);
        simulation.velocity[1] = v1;
        simulation.accuracy = Accuracy::Tolerance(1e-12);
        let run = simulation.run(&Silent).unwrap();
        let centre = (v0 + m * v1) / (1.0 + m);
        let scale = f64::max(v0.abs(), v1.abs());
        for (found, before) in run.velocity.row(1).into_iter().zip([v0, v1]) {
            let expected = 2.0 * centre - before;
            let error = (found - expected).abs() / scale;
            assert!(error < 1e-14, "{m} {v0} {v1}: {found} {expected}");
        }
    }
}

#[derive(serde::Deserialize)]
struct Flights {
    cases: Vec<Flight>,
}

#[derive(serde::Deserialize)]
struct Flight {
    mass: Vec<f64>,
    coefficient: Vec<f64>,
    velocity: Vec<f64>,
    end_time: f64,
    samples: usize,
    tolerance: f64,
    /// The one at which velocities are `expected`.
    sample: usize,
    expected: Vec<f64>,
}

/// Bodies that fly and collide many times: two runs agree to a half or a third of the error that rounding leaves, which
/// the stated one holds. Below it no tolerance is assured. `data/flights.json` is of `data/chain_reference.py flights`.
#[test]
fn val_double_double_flights_have_the_stated_error() {
    let text = std::fs::read_to_string(data("flights.json")).unwrap();
    let flights: Flights = serde_json::from_str(&text).unwrap();
    assert_eq!(flights.cases.len(), 2);
    for case in flights.cases {
        let chain = chain(case.mass, case.coefficient, Law::Hertz, Ends::Free);
        let mut simulation = Simulation::impact(chain, 0.0, case.end_time, case.samples);
        simulation.velocity = case.velocity;
        let with = |tolerance: f64| {
            let mut simulation = simulation.clone();
            simulation.accuracy = Accuracy::Tolerance(tolerance);
            simulation.run(&Silent).unwrap()
        };
        let run = with(case.tolerance);
        let scale = run.report.velocity_scale;
        let pairs = run
            .velocity
            .row(case.sample)
            .into_iter()
            .zip(&case.expected);
        let worst = pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs())) / scale;
        let stated = run.report.error.unwrap();
        println!("{worst:.2e} of {stated:.2e} stated");
        assert!(
            (0.05..1.0).contains(&(worst / stated)),
            "{worst:e} {stated:e}"
        );
        assert!(run.report.warnings.is_empty(), "{:?}", run.report.warnings);
        let run = with(1e-13);
        assert!(run.report.error.unwrap() > 1e-13);
        assert!(
            matches!(run.report.warnings[..], [RunWarning::Rounding { .. }]),
            "{:?}",
            run.report.warnings
        );
    }
}
