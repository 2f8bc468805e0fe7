//! States that a run starts from: other runs, tables, and modes of the chain.

use std::f64::consts::PI;

use test_support::place::Place;
use test_support::scenes::{apart, last, run, setup, simulation};
use wavecascade::chain::scene::SceneSource;
use wavecascade::observer::Silent;
use wavecascade::report::RunFile;

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
