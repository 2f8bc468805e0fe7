//! Chains whose motion is known: collisions, flights, periods, linear modes, orders and limits of methods.

use std::f64::consts::PI;

use test_support::scenes::{
    apart, data, largest, last, near, numbers, parsed, rows, run, simulation,
};
use wavecascade::chain::{Accuracy, RunWarning, Scheme};
use wavecascade::field::Quantity;
use wavecascade::observer::Silent;

const SAMPLES: [usize; 6] = [2, 3, 9, 65, 257, 1025];

/// Largest error of the last velocities, relative to the scale, over counts of samples and the schemes that the chain may have.
/// Each run is as good as it states, keeps its energy and warns of nothing; bodies that have parted press no more.
fn worst(keys: &str, samples: &[usize], expected: &[f64], parted: bool) -> f64 {
    let mut it = simulation(keys);
    let schemes = match it.scheme {
        Scheme::Nystrom => vec![Scheme::Nystrom, Scheme::RungeKutta],
        only => vec![only],
    };
    // The last digits of positions far from 0 are coarser than those of the motion.
    let rounding = 1e-12 + 2e-15 * largest(&it.displacement);
    let mut worst = 0.0;
    for scheme in schemes {
        for &samples in samples {
            (it.scheme, it.samples) = (scheme, samples);
            let run = it.run(&Silent).unwrap();
            let report = &run.report;
            assert!(report.warnings.is_empty(), "{keys} {samples}: {report:?}");
            let error = apart(last(&run), expected) / report.velocity_scale;
            near(error, 0.0, report.error.unwrap() + rounding, keys);
            let drift = report.energy_drift.unwrap_or(0.0);
            near(drift, 0.0, 4.0 * rounding, keys);
            let force = run.force.as_ref().unwrap();
            assert!(!parted || largest(force.row(samples - 1)) == 0.0, "{keys}");
            worst = largest([worst, error]);
        }
    }
    worst
}

#[test]
fn val_closed_form_motions() {
    for [name, keys, samples, expected, most] in rows(include_str!("known.txt")) {
        let samples: Vec<usize> = parsed(&samples).into_iter().map(|n| n as usize).collect();
        let worst = worst(&keys, &samples, &parsed(&expected), name.ends_with("apart"));
        println!("{name}: {worst:.1e}");
        assert!(worst < most.parse().unwrap(), "{name}: {worst:e}");
    }
}

/// The first body strikes two that touch, at once and after a flight: velocities by double-double arithmetic
/// (`tests/data/collisions.json`). The outcome depends on the contacts, not on the masses alone.
#[test]
fn val_double_double_three_bodies_collide() {
    for case in data("collisions.json")["cases"].as_array().unwrap() {
        let keys = format!(
            "ends = 'free'\nsites = 3\nmasses = {}\ncoefficients = {}\nstriker_velocity = 1\n",
            case["mass"], case["coefficient"]
        );
        let expected = numbers(&case["velocity"]);
        let touching = format!("{keys}tolerance = 1e-12\nend_time = 30");
        let flying = format!("{keys}displacements = [-33.3, 0, 0]\nend_time = 63.3");
        assert!(worst(&touching, &[2], &expected, true) < 1e-14);
        assert!(worst(&flying, &SAMPLES, &expected, true) < 1e-12);
    }
}

/// The error of a smooth chain falls with the order of the method, and so does that of the work of a force on a body.
#[test]
fn val_order_of_every_scheme() {
    let struck = "sites = 8\nbeta = 0.2\nalpha = 0.3\nend_time = 20.0\n";
    let pushed = "sites = 12\nalpha = 0.25\nend_time = 12.0\ndrive = 'force'\ndrive_site = 4\ndrive_amplitude = 0.2\n\
                  drive_frequency = 0.08\n";
    for (scheme, steps, keys) in [
        ("nystrom", [0.4, 0.2], struck),
        ("runge-kutta", [0.5, 0.25], struck),
        ("velocity-verlet", [0.02, 0.01], struck),
        ("symplectic-4", [0.2, 0.1], struck),
        ("symplectic-6", [0.4, 0.2], struck),
        ("velocity-verlet", [0.4, 0.2], pushed),
        ("runge-kutta", [0.4, 0.2], pushed),
    ] {
        let keys = format!("law = 'spring'\nends = 'fixed'\nsamples = 2\n{keys}");
        let mut exact = simulation(&keys);
        exact.accuracy = Accuracy::LocalError(1e-15);
        exact.estimate_error = false;
        let exact = exact.run(&Silent).unwrap();
        let mut order = 0.0;
        let [coarse, fine] = steps.map(|step| {
            let it = simulation(&format!("{keys}scheme = '{scheme}'\nstep = {step}"));
            order = f64::from(it.scheme.order());
            let run = it.run(&Silent).unwrap();
            let work =
                [&run, &exact].map(|run| run.energy_input.as_ref().map_or(0.0, |input| input[1]));
            [apart(last(&run), last(&exact)), (work[0] - work[1]).abs()]
        });
        let [found, work] = [0, 1].map(|of| (coarse[of] / fine[of]).log2());
        println!("{scheme}: {coarse:?} {fine:?} orders {found:.2} {work:.2}");
        let slack = if keys.contains("drive") { 0.7 } else { 0.4 };
        assert!((found - order).abs() < slack, "{scheme}: {found}");
        assert!(work.is_nan() || work > order - 1.0, "{scheme}: {work}");
    }
}

/// More is asked than numbers of 53 bits hold.
#[test]
fn val_rounding_a_tolerance_below_it_is_told() {
    let report = run("sites = 20\nend_time = 20.0\nsamples = 11\ntolerance = 1e-16").report;
    let [RunWarning::Rounding { tolerance, reached }] = report.warnings[..] else {
        panic!("{:?}", report.warnings)
    };
    assert_eq!(tolerance, 1e-16);
    assert!(reached > 1e-16 && reached < 1e-12, "{reached:e}");
}

/// Uniform in 1.5..2.5, of the mean 2 and the variance 1/12, each to three standard errors.
#[test]
fn val_definition_random_masses() {
    let random = |seed: u64| {
        let both = "mass_cell = 2.0\nmass_spread = 0.25\ncoefficient_cell = 2.0\ncoefficient_spread = 0.25";
        let chain = simulation(&format!("sites = 20000\n{both}\nseed = {seed}")).chain;
        assert_ne!(chain.mass, chain.coefficient);
        chain.mass
    };
    let values = random(7);
    assert_eq!(values, random(7));
    assert_ne!(values, random(8));
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square = values.iter().map(|v| (v - 2.0).powi(2)).sum::<f64>() / values.len() as f64;
    assert!((mean - 2.0).abs() < 0.006, "{mean}");
    assert!((square * 12.0 - 1.0).abs() < 0.02, "{square}");
    assert!(values.iter().all(|v| (1.5..2.5).contains(v)));
}

#[test]
fn val_definition_the_field_of_a_run() {
    let field = run("sites = 12\nstiffness_ratio = 2.0\nend_time = 8.0\nsamples = 33").to_field();
    assert_eq!(field.quantity, Quantity::Velocity);
    assert_eq!((field.time.origin, field.time.step), (0.0, 0.25));
    assert_eq!((field.n_times(), field.n_sites()), (33, 12));
}

// The speed that errors are relative to, where it is not that of a striker.

/// Linear chains: velocities of initial displacements and of tiny initial speeds add up.
#[test]
fn val_superposition_a_tiny_speed_beside_large_displacements() {
    let [without, with] = [0.0, 1e-12].map(|speed| {
        let mut it =
            simulation("sites = 10\nlaw = 'spring'\nends = 'fixed'\nend_time = 20.0\nsamples = 16");
        (it.displacement[0], it.velocity[0]) = (1.0, speed);
        it.run(&Silent).unwrap()
    });
    assert_eq!(with.report.velocity_scale, without.report.velocity_scale);
    let off = apart(&with.velocity, &without.velocity);
    assert!(off > 1e-13 && off < 3e-12, "{off:e}");
}

/// A force that rises slowly for longer than the run: `m v = integral of the force` for all sites
/// together, at the tolerance of the largest speed.
#[test]
fn val_momentum_of_a_slow_push() {
    for tolerance in [1e-5, 1e-9] {
        let run = run(&format!(
            "sites = 20\nends = 'free'\nend_time = 1000.0\nsamples = 50\ntolerance = {tolerance:e}\ndrive = 'force'\n\
             drive_waveform = 'half-sine'\ndrive_amplitude = 1e-3\ndrive_duration = 1e6"
        ));
        let (scale, largest) = (run.report.velocity_scale, largest(&run.velocity));
        assert!((scale / largest - 1.0).abs() < 0.2, "{scale:e} {largest:e}");
        let rate = PI / 1e6;
        let impulse = 1e-3 * 2.0 * (0.5 * rate * 1000.0f64).sin().powi(2) / rate;
        let off = (last(&run).sum() - impulse).abs() / (20.0 * largest);
        assert!(off < tolerance, "{tolerance:e}: {off:e}");
    }
}
