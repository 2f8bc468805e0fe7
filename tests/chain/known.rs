//! Chains whose motion is known: collisions, linear modes, the solitary wave, orders of methods.

use test_support::fields::{fixed, spring};
use wavecascade::chain::scene::SceneSource;
use wavecascade::chain::{
    Accuracy, Chain, EndTime, Ends, Law, Record, Run, RunWarning, Scheme, Simulation,
};
use wavecascade::field::Quantity;
use wavecascade::observer::Silent;

fn chain(mass: &[f64], coefficient: &[f64], ends: Ends, law: Law) -> Chain {
    test_support::fields::chain(mass.to_vec(), coefficient.to_vec(), law, ends)
}

fn last(run: &Run) -> Vec<f64> {
    run.velocity.row(run.time.len() - 1).to_vec()
}

#[test]
fn val_closed_form_two_bodies_collide_elastically() {
    for (m, c) in [(1.0, 1.0), (3.7, 1e4), (0.2, 1e-3)] {
        let free = chain(&[1.0, m], &[c], Ends::Free, Law::Hertz);
        let run = Simulation::impact(free, 2.0, 40.0 * f64::powf(c, -0.4), 3)
            .run(&Silent)
            .unwrap();
        let v = last(&run);
        let expected = [2.0 * (1.0 - m) / (1.0 + m), 4.0 / (1.0 + m)];
        assert!((v[0] - expected[0]).abs() < 1e-10, "{v:?} {expected:?}");
        assert!((v[1] - expected[1]).abs() < 1e-10, "{v:?} {expected:?}");
    }
}

/// Two equal sites strike a third of equal mass: at a soft second contact they act one by one.
#[test]
fn val_closed_form_three_bodies_with_a_hard_and_a_soft_contact() {
    // Bodies of masses 1 and 1 joined by a contact far stiffer than the next: the first collision
    // is over before the second begins, so that the speed passes on whole.
    let free = chain(&[1.0, 1.0, 1.0], &[1e12, 1.0], Ends::Free, Law::Hertz);
    let v = last(&Simulation::impact(free, 1.0, 20.0, 3).run(&Silent).unwrap());
    assert!((v.iter().sum::<f64>() - 1.0).abs() < 1e-13);
    assert!((v.iter().map(|v| v * v).sum::<f64>() - 1.0).abs() < 1e-10);
    assert!(v[0].abs() < 1e-4 && v[1].abs() < 1e-4 && (v[2] - 1.0).abs() < 1e-4);
}

/// Fixed ends: `x_j = sum_m A_m sin(pi m (j+1)/(N+1)) sin(w_m t)`.
#[test]
fn val_normal_modes_of_a_linear_chain() {
    let n = 24;
    let law = spring(0.0, 0.0);
    let ends = fixed(1.0);
    for scheme in [Scheme::Nystrom, Scheme::RungeKutta] {
        let linear = chain(&vec![1.0; n], &vec![1.0; n], ends, law.clone());
        let mut simulation = Simulation::impact(linear, 1.0, 60.0, 31);
        simulation.scheme = scheme;
        let run = simulation.run(&Silent).unwrap();
        let mut worst = 0f64;
        for (row, t) in run.velocity.rows().into_iter().zip(&run.time) {
            for (j, v) in row.iter().enumerate() {
                let exact: f64 = (1..=n)
                    .map(|m| {
                        let q = std::f64::consts::PI * m as f64 / (n + 1) as f64;
                        let (from, to) = (q.sin(), (q * (j + 1) as f64).sin());
                        2.0 / (n + 1) as f64 * from * to * (2.0 * (0.5 * q).sin() * t).cos()
                    })
                    .sum();
                worst = worst.max((v - exact).abs());
            }
        }
        println!("{scheme:?}: {worst:.1e}");
        assert!(worst < 1e-11, "{scheme:?}: {worst:e}");
    }
}

/// A weak impact on a strong precompression moves like the linear chain of the same stiffness.
#[test]
fn val_linear_limit_of_a_precompressed_chain() {
    let n = 30;
    let mut pressed = chain(&vec![1.0; n], &vec![1.0; n], Ends::Wall, Law::Hertz);
    pressed.precompression = 1.0;
    let law = spring(0.0, 0.0);
    let linear = chain(&vec![1.0; n], &vec![1.5; n], Ends::Wall, law);
    let difference = |speed: f64| {
        let [a, b] = [&pressed, &linear].map(|c| {
            Simulation::impact(c.clone(), speed, 30.0, 31)
                .run(&Silent)
                .unwrap()
        });
        let pairs = a.velocity.iter().zip(&b.velocity);
        pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs())) / speed
    };
    // The first correction is linear in the speed.
    let (large, small) = (difference(1e-4), difference(1e-6));
    println!("{large:.2e} {small:.2e}");
    assert!(small < 1e-6, "{small:e}");
    assert!((large / small - 100.0).abs() < 2.0, "{large:e} {small:e}");
}

/// V. F. Nesterenko, *Dynamics of Heterogeneous Materials* (2001): an impact on a Hertz chain
/// makes a solitary wave, which travels on without a change of shape or speed.
#[test]
fn val_solitary_wave_keeps_its_shape_and_speed() {
    let mut simulation = Simulation::impact(Chain::dimer(120, 1.0), 1.0, 130.0, 13001);
    simulation.record = Record::default();
    let run = simulation.run(&Silent).unwrap();
    let crossing = |site: usize| {
        let column = run.velocity.column(site);
        let half = 0.5 * column.iter().fold(0.0, |m: f64, v| m.max(*v));
        let n = column.iter().position(|v| *v > half).unwrap();
        let (a, b) = (column[n - 1], column[n]);
        run.time[n - 1] + (run.time[n] - run.time[n - 1]) * (half - a) / (b - a)
    };
    let peak = |site: usize| {
        run.velocity
            .column(site)
            .iter()
            .fold(0.0, |m: f64, v| m.max(*v))
    };
    let early = (crossing(60) - crossing(40)) / 20.0;
    let late = (crossing(100) - crossing(80)) / 20.0;
    println!("{early} {late} {} {}", peak(50), peak(90));
    assert!((early / late - 1.0).abs() < 2e-4);
    assert!((peak(50) / peak(90) - 1.0).abs() < 2e-3);
}

/// The error of a smooth chain falls with the order of the method.
#[test]
fn val_order_of_every_scheme() {
    let n = 8;
    let law = spring(0.3, 0.2);
    let ends = fixed(1.0);
    for (scheme, steps) in [
        (Scheme::Nystrom, [0.4, 0.2]),
        (Scheme::RungeKutta, [0.5, 0.25]),
        (Scheme::VelocityVerlet, [0.02, 0.01]),
        (Scheme::Symplectic4, [0.2, 0.1]),
        (Scheme::Symplectic6, [0.4, 0.2]),
    ] {
        let springs = chain(&vec![1.0; n], &vec![1.0; n], ends, law.clone());
        let mut simulation = Simulation::impact(springs, 1.0, 20.0, 2);
        simulation.end_time = EndTime::At(20.0);
        simulation.accuracy = Accuracy::LocalError(1e-15);
        simulation.estimate_error = false;
        let exact = last(&simulation.run(&Silent).unwrap());
        simulation.scheme = scheme;
        let [coarse, fine] = steps.map(|step| {
            simulation.accuracy = Accuracy::Step(step);
            let v = last(&simulation.run(&Silent).unwrap());
            let pairs = v.iter().zip(&exact);
            pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()))
        });
        let order = (coarse / fine).log2();
        println!("{scheme:?}: {coarse:.1e} {fine:.1e} order {order:.2}");
        assert!(
            (order - f64::from(scheme.order())).abs() < 0.4,
            "{scheme:?}: {order}"
        );
    }
}

#[test]
fn val_stability_an_unstable_step_is_told() {
    let mut simulation = Simulation::impact(Chain::dimer(20, 1e6), 1.0, 200.0, 5);
    simulation.scheme = Scheme::VelocityVerlet;
    simulation.accuracy = Accuracy::Step(20.0);
    simulation.chain.law = spring(0.0, 0.0).into();
    let error = simulation.run(&Silent).unwrap_err().to_string();
    assert!(error.contains("stability limit"), "{error}");
}

/// Hertz contacts, whose frequency grows with the overlap, at several times the limit.
#[test]
fn val_stability_an_unstable_step_of_hertz_contacts_is_told() {
    for scheme in [
        Scheme::VelocityVerlet,
        Scheme::Symplectic4,
        Scheme::Symplectic6,
    ] {
        for kappa in [4.9272, 1e4] {
            let mut simulation = Simulation::impact(Chain::dimer(40, kappa), 1.0, 100.0, 3);
            simulation.scheme = scheme;
            simulation.accuracy = Accuracy::Step(20.0 * kappa.powf(-1.0 / 3.0));
            let error = simulation.run(&Silent).unwrap_err();
            assert!(error.is_usage());
            let error = error.to_string();
            assert!(
                error.contains("stability limit"),
                "{scheme:?} {kappa}: {error}"
            );
        }
    }
}

/// More is asked than numbers of 53 bits hold.
#[test]
fn val_rounding_a_tolerance_below_it_is_told() {
    let mut simulation = Simulation::impact(Chain::dimer(20, 1.0), 1.0, 20.0, 11);
    simulation.accuracy = Accuracy::Tolerance(1e-16);
    let report = simulation.run(&Silent).unwrap().report;
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
        let scene = format!("sites = 20000\nmass_cell = 2.0\nmass_spread = 0.25\nseed = {seed}");
        let setup = SceneSource::new(None, scene).setup().unwrap();
        setup.simulation.chain.mass
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
    let run = Simulation::impact(Chain::dimer(12, 2.0), 1.0, 8.0, 33)
        .run(&Silent)
        .unwrap();
    let field = run.to_field();
    assert_eq!(field.quantity, Quantity::Velocity);
    assert_eq!((field.time.origin, field.time.step), (0.0, 0.25));
    assert_eq!((field.n_times(), field.n_sites()), (33, 12));
}

/// Two bodies bound by Morse's law return after `2 pi sqrt(mu / c) / sqrt(1 - E / D)`, `D = c / (2 b^2)`.
#[test]
fn val_closed_form_period_of_two_bodies_under_the_law_of_morse() {
    let (c, b) = (2.0f64, 1.5f64);
    let depth = 0.5 * c / (b * b);
    for share in [0.01f64, 0.5, 0.9] {
        let speed = (4.0 * share * depth).sqrt();
        let period = std::f64::consts::TAU * (0.5 / c).sqrt() / (1.0 - share).sqrt();
        let pair = chain(&[1.0, 1.0], &[c], Ends::Free, Law::morse(b));
        let mut bound = Simulation::impact(pair, speed, 3.0 * period, 4);
        bound.accuracy = Accuracy::Tolerance(1e-11);
        let run = bound.run(&Silent).unwrap();
        for row in run.velocity.rows() {
            assert!((row[0] - speed).abs() < 1e-10 * speed, "{share}: {row}");
            assert!(row[1].abs() < 1e-10 * speed, "{share}: {row}");
        }
    }
}
