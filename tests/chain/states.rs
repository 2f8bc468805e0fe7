//! States that a run starts from: other runs, tables, and modes of the chain.

use std::f64::consts::PI;

use test_support::place::Place;
use test_support::scenes::{apart, last, run, setup, simulation};
use wavecascade::chain::scene::SceneSource;
use wavecascade::observer::Silent;
use wavecascade::report::RunFile;

/// Frequencies of uniform chains with every end, and of a compressed ring of two masses.
#[test]
fn val_closed_form_frequencies_of_modes() {
    let n = 32;
    let known = |frequency: &dyn Fn(f64) -> Vec<f64>, from: usize, to: usize| {
        let each = (from..=to).flat_map(|k| frequency(k as f64));
        let mut all: Vec<f64> = each.collect();
        all.sort_by(f64::total_cmp);
        all
    };
    let springs = |angle: f64| 2.0 * (0.5 * angle).sin();
    let sites = n as f64;
    let fixed = known(&|k| vec![springs(PI * k / (sites + 1.0))], 1, n);
    let free = known(&|k| vec![springs(PI * k / sites)], 1, n - 1);
    let wall = known(&|k| vec![springs(PI * (k - 0.5) / (sites + 0.5))], 1, n);
    let ring = known(
        &|k| vec![springs(2.0 * PI * ((k + 1.0) / 2.0).floor() / sites)],
        1,
        n - 1,
    );
    // Masses 1 and 3 on the stiffness 1.5 F0^(1/3).
    let two = |k: f64| {
        let (sum, half) = (1.0 + 1.0 / 3.0, (2.0 * PI * k / sites).sin());
        let root = (sum * sum - 4.0 / 3.0 * half * half).sqrt();
        let squares = [sum - root, sum + root].into_iter();
        let all = squares.map(|square: f64| (1.5 * 0.3f64.cbrt() * square.max(0.0)).sqrt());
        all.collect()
    };
    let two = known(&two, 0, n / 2 - 1)[1..].to_vec();
    for (ends, free, known, keys) in [
        ("fixed", 0, fixed, "law = 'spring'\nalpha = 0.25"),
        ("free", 1, free, "law = 'spring'\nalpha = 0.25"),
        ("wall", 0, wall, "law = 'spring'\nalpha = 0.25"),
        ("periodic", 1, ring, "law = 'spring'\nalpha = 0.25"),
        ("periodic", 1, two, "precompression = 0.3\nmass_ratio = 3"),
    ] {
        let keys = format!("sites = {n}\nends = '{ends}'\nend_time = 1.0\n{keys}");
        let modes = simulation(&keys).chain.normal_modes().unwrap();
        assert_eq!(modes.free, free, "{keys}");
        let ratios = modes.frequency[free..]
            .iter()
            .zip(&known)
            .map(|(w, known)| w / known);
        assert!(apart(ratios, vec![1.0; known.len()]) < 2e-12, "{keys}");
    }
}

/// Modes of a disordered linear chain keep their energies, and start with those stated.
#[test]
fn val_closed_form_modes_of_a_linear_chain() {
    let run = run(
        "sites = 24\nlaw = \"spring\"\nends = \"fixed\"\nmass_spread = 0.5\ncoefficient_spread = 0.4\nseed = 5\n\
         modes = [3, 8]\nmode_energy = 0.25\nend_time = 60.0\nsamples = 7\ntolerance = 1e-11\n",
    );
    let modes = run.chain.normal_modes().unwrap();
    let known = Vec::from_iter((0..24).map(|k| if (2..8).contains(&k) { 0.25 } else { 0.0 }));
    for i in 0..7 {
        let x = run.displacement.as_ref().unwrap().row(i).to_vec();
        let v = run.velocity.row(i).to_vec();
        let mut energies = vec![0.0; 24];
        modes.energies(&x, &v, &mut energies);
        assert!(apart(&energies, &known) < 1e-10, "{i}: {energies:?}");
        let all = run.chain.energy(&x, &v, 0.0);
        assert!((all / 1.5 - 1.0).abs() < 1e-10, "{all}");
    }
    let mut start = run.velocity.row(0).into_iter();
    assert!(start.any(|v| v.abs() > 0.1), "phases are not random");
}

/// A mode with an energy is that of the chain as it is; with an amplitude, of the uniform one, as ever.
#[test]
fn val_closed_form_one_mode() {
    let keys = "sites = 16\nlaw = \"spring\"\nends = \"fixed\"\nmode = 3\nend_time = 1.0\n";
    let frequency = 2.0 * (PI * 3.0 / 34.0).sin();
    for (key, amplitude) in [
        (
            "mode_energy = 0.1",
            (2.0 * 0.1f64 / frequency.powi(2) / 8.5).sqrt(),
        ),
        ("mode_amplitude = 0.7", 0.7),
    ] {
        let it = simulation(&format!("{keys}{key}"));
        let shape = (0..16).map(|j| amplitude * (PI * 3.0 * (j as f64 + 1.0) / 17.0).sin());
        assert!(apart(&it.displacement, shape) < 1e-13, "{key}");
        assert_eq!(it.velocity, [0.0; 16]);
    }
}

/// A run in two parts is the run in one.
#[test]
fn val_identity_a_run_goes_on() {
    let place = Place::new();
    let chain = "sites = 30\nstiffness_ratio = 2.0\ntolerance = 1e-11\nsamples = 11\n";
    let whole = run(&format!("{chain}end_time = 30.0"));
    let first = setup(&format!("{chain}end_time = 12.0"));
    let run = first.simulation.run(&Silent).unwrap();
    for name in ["first.npz", "first.nc"] {
        RunFile::write(&place.path(name), false, &first, &run, &Silent).unwrap();
    }
    let columns = run.displacement.as_ref().unwrap().row(10).to_owned();
    let columns = columns.iter().zip(last(&run));
    let rows: String = columns.map(|(x, v)| format!("{v};{x}\n")).collect();
    place.write("first.csv", format!("velocity;displacement\n{rows}"));
    for name in ["first.npz", "first.nc", "first.csv"] {
        let text = format!("{chain}end_time = 18.0\nstate = \"{name}\"\n");
        place.write("second.toml", text);
        let second = SceneSource::read(&place.path("second.toml")).unwrap();
        let second = second.setup().unwrap();
        assert!(!second.text.contains("first"), "{}", second.text);
        let off = apart(last(&second.simulation.run(&Silent).unwrap()), last(&whole));
        assert!(off < 1e-11, "{name}: {off:e}");
    }
}
