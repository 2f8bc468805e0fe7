//! Springs to the ground and weight, against closed forms and independent chains.

use std::f64::consts::{PI, TAU};

use test_support::fields::chain;
use wavecascade::chain::scene::SceneSource;
use wavecascade::chain::{Accuracy, Ends, Ground, Law, Run, Simulation, UnitCell};
use wavecascade::observer::Silent;

fn setup(text: &str) -> Result<Simulation, String> {
    let setup = SceneSource::new(None, text).setup();
    setup
        .map(|setup| setup.simulation)
        .map_err(|error| error.to_string())
}

fn run(text: &str) -> Run {
    setup(text).unwrap().run(&Silent).unwrap()
}

/// `omega^2 = (k + 4 c sin^2(q/2)) / m`: a chain held by the ground in one mode, and the branch of its cell.
#[test]
fn val_theory_waves_of_a_held_chain_have_a_lowest_frequency() {
    let (n, mode, k) = (24, 5, 0.7);
    let q = PI * f64::from(mode) / f64::from(n + 1);
    let omega = (k + 4.0 * (0.5 * q).sin().powi(2)).sqrt();
    let end = 20.25 * TAU / omega;
    let text = format!(
        "sites = {n}\nlaw = \"spring\"\nends = \"fixed\"\nmode = {mode}\nmode_amplitude = 1.0\n\
         ground_cell = [{k}]\nend_time = {end}\nsamples = 82\ntolerance = 1e-11"
    );
    let simulation = setup(&text).unwrap();
    let cell = UnitCell::of(&simulation.chain).unwrap();
    assert!((cell.frequencies(q)[0] - omega).abs() < 1e-13);
    assert!((cell.frequencies(0.0)[0] - k.sqrt()).abs() < 1e-13);
    let modes = simulation.chain.normal_modes().unwrap();
    for (m, found) in modes.frequency.iter().enumerate() {
        let half = PI * (m + 1) as f64 / f64::from(2 * (n + 1));
        let expected = (k + 4.0 * half.sin().powi(2)).sqrt();
        assert!((found - expected).abs() < 1e-13, "{m}: {found} {expected}");
    }
    let run = simulation.run(&Silent).unwrap();
    let shape = |j: usize| (q * (j + 1) as f64).sin();
    for (row, t) in run.velocity.rows().into_iter().zip(&run.time) {
        for (j, v) in row.iter().enumerate() {
            let expected = -omega * shape(j) * (omega * t).sin();
            assert!((v - expected).abs() < 1e-10, "{t} {j}: {v} {expected}");
        }
    }
    assert!(run.report.energy_drift.unwrap() < 1e-12);
}

/// A single body on a hardening spring is Duffing's oscillator: it returns after `4 K(m) / omega`.
#[test]
fn val_closed_form_one_body_on_a_hardening_spring() {
    let (a, speed) = (0.8f64, 1.5f64);
    // v^2/2 = x^2/2 + a x^4/4 at the largest displacement.
    let square = ((1.0 + 2.0 * a * speed * speed).sqrt() - 1.0) / a;
    let stiffness = 1.0 + a * square;
    let m = a * square / (2.0 * stiffness);
    let (mut mean, mut root) = (1.0f64, (1.0 - m).sqrt());
    for _ in 0..8 {
        (mean, root) = (0.5 * (mean + root), (mean * root).sqrt());
    }
    let period = TAU / (mean * stiffness.sqrt());
    let run = run(&format!(
        "sites = 2\nlaw = \"spring\"\nends = \"free\"\nground_cell = [1.0]\nground_law = \"d + {a}*d^3\"\n\
         velocities = [{speed}, {speed}]\nend_time = {}\nsamples = 5\ntolerance = 1e-11",
        2.0 * period
    ));
    for row in [2, 4] {
        assert!(
            (run.velocity[[row, 0]] - speed).abs() < 1e-9,
            "{}",
            run.velocity.row(row)
        );
    }
    assert!((run.velocity[[1, 0]] + speed).abs() < 1e-9);
}

/// Weight presses contact j by `g sum_{i <= j} m_i`: small waves see the stiffness of that force, as in a chain of springs.
#[test]
fn val_other_chain_weight_stiffens_contacts_downwards() {
    let n = 12;
    let text = "sites = 12\ngravity = 0.3\nstriker_velocity = 1e-7\nend_time = 8.0\nsamples = 33\ntolerance = 1e-10";
    let run = run(text);
    // F = d^1.5 under F0 has the stiffness 1.5 F0^(1/3).
    let stiffness = (0..n).map(|j| 1.5 * (0.3 * (j + 1) as f64).cbrt());
    let law = Law::polynomial(vec![1.0]);
    let mut springs = chain(vec![1.0; n], stiffness.collect(), law, Ends::Wall);
    let mut linear = Simulation::impact(springs.clone(), 1e-7, 8.0, 33);
    linear.accuracy = Accuracy::Tolerance(1e-10);
    let linear = linear.run(&Silent).unwrap();
    for (a, b) in run.velocity.iter().zip(&linear.velocity) {
        assert!((a - b).abs() < 2e-13, "{a:e} {b:e}");
    }
    springs.on_site.ground = Some(Ground {
        law: Law::Hertz.into(),
        coefficient: vec![1.0; 3],
    });
    assert!(springs.check().is_err(), "coefficients of three sites");
}

/// A ground with losses and openings: energy closes, and smaller steps keep the stated error.
#[test]
fn val_other_steps_held_hertz_contacts() {
    let text = |tolerance: f64| {
        format!(
            "sites = 16\nground_cell = [0.4, 0.0]\nground_law = \"d + 0.3*d^3\"\ndrag = 0.02\nends = \"fixed\"\n\
             striker_velocity = 1.0\nend_time = 25.0\nsamples = 65\ntolerance = {tolerance:e}"
        )
    };
    let (coarse, fine) = (run(&text(1e-7)), run(&text(1e-11)));
    let pairs = coarse.velocity.iter().zip(&fine.velocity);
    let off = pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(off < coarse.report.error.unwrap() && off < 1e-7, "{off:e}");
    assert!(coarse.report.energy_drift.unwrap() < 1e-8);
}

/// Peaks between samples are found with the pull of the ground: as among samples twenty times as dense.
#[test]
fn val_denser_samples_peaks_of_held_contacts() {
    let text = |samples: usize| {
        format!(
            "sites = 10\nlaw = \"spring\"\nground_cell = [40.0]\nstriker_velocity = 1.0\nend_time = 4.0\n\
             samples = {samples}\ntolerance = 1e-10"
        )
    };
    let (coarse, fine) = (run(&text(41)), run(&text(20 * 40 + 1)));
    for contact in [0, 1, 2] {
        let [a, b] = [&coarse, &fine].map(|run| run.peak_force(contact).unwrap());
        let off = (a.value - b.value).abs() / b.value;
        assert!(off < 2e-6, "{contact}: {off:e}");
    }
}

/// A chain on a ridge of its energy has no modes.
#[test]
fn an_unstable_chain_has_no_modes() {
    let text = "sites = 6\nlaw = \"polynomial -1 0 1\"\nend_time = 1.0";
    let error = setup(text).unwrap().chain.normal_modes().unwrap_err();
    assert!(error.to_string().contains("stable at rest"), "{error}");
}
