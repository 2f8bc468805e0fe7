//! States that a run starts from: other runs, tables, and modes of the chain.

use std::f64::consts::PI;
use std::fs;

use test_support::fields::{fixed, spring};
use wavecascade::chain::scene::{SceneSource, Setup};
use wavecascade::chain::{Chain, Ends, NormalModes};
use wavecascade::observer::Silent;
use wavecascade::report::RunFile;

fn setup(text: &str) -> Setup {
    SceneSource::new(None, text)
        .setup()
        .unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn springs(n: usize, ends: Ends) -> Chain {
    let contacts = if ends == Ends::Free { n - 1 } else { n };
    Chain {
        law: spring(0.25, 0.0).into(),
        ends,
        coefficient: vec![1.0; contacts],
        ..Chain::dimer(n, 1.0)
    }
}

fn energies(modes: &NormalModes, x: &[f64], v: &[f64]) -> Vec<f64> {
    let mut energies = vec![0.0; x.len()];
    modes.energies(x, v, &mut energies);
    energies
}

/// Frequencies of uniform chains with every end, and of a compressed ring of two masses.
#[test]
fn val_closed_form_frequencies_of_modes() {
    let n = 32;
    let sites = n as f64;
    let fixed = fixed(1.0);
    type AngleOf = fn(f64, f64) -> f64;
    let cases: [(Ends, usize, AngleOf); 4] = [
        (fixed, 0, |k, n| PI * k / (n + 1.0)),
        (Ends::Free, 1, |k, n| PI * k / n),
        (Ends::Wall, 0, |k, n| PI * (k - 0.5) / (n + 0.5)),
        (Ends::Periodic, 1, |k, n| {
            2.0 * PI * ((k + 1.0) / 2.0).floor() / n
        }),
    ];
    for (ends, free, angle) in cases {
        let modes = springs(n, ends).normal_modes().unwrap();
        assert_eq!(modes.free, free, "{ends:?}");
        for (k, w) in modes.frequency[free..].iter().enumerate() {
            let known = 2.0 * (0.5 * angle(k as f64 + 1.0, sites)).sin();
            assert!((w / known - 1.0).abs() < 2e-12, "{ends:?} {k}: {w} {known}");
        }
    }
    let mut ring = Chain::dimer(n, 1.0);
    ring.ends = Ends::Periodic;
    ring.precompression = 0.3;
    for mass in ring.mass.iter_mut().skip(1).step_by(2) {
        *mass = 3.0;
    }
    let stiffness = 1.5 * 0.3f64.cbrt();
    let mut known: Vec<f64> = (0..n / 2)
        .flat_map(|k| {
            let (sum, half) = (1.0 + 1.0 / 3.0, (2.0 * PI * k as f64 / sites).sin());
            let root = (sum * sum - 4.0 / 3.0 * half * half).sqrt();
            [sum - root, sum + root].map(|square: f64| (stiffness * square.max(0.0)).sqrt())
        })
        .collect();
    known.sort_by(f64::total_cmp);
    let modes = ring.normal_modes().unwrap();
    for (w, known) in modes.frequency.iter().zip(known).skip(1) {
        assert!((w / known - 1.0).abs() < 2e-12, "{w} {known}");
    }
}

/// Modes of a disordered linear chain keep their energies, and start with those stated.
#[test]
fn val_closed_form_modes_of_a_linear_chain() {
    let scene = "sites = 24\nlaw = \"spring\"\nends = \"fixed\"\nmass_spread = 0.5\ncoefficient_spread = 0.4\nseed = 5\n\
                 modes = [3, 8]\nmode_energy = 0.25\nend_time = 60.0\nsamples = 7\ntolerance = 1e-11\n";
    let setup = setup(scene);
    let run = setup.simulation.run(&Silent).unwrap();
    let modes = run.chain.normal_modes().unwrap();
    let x = run.displacement.as_ref().unwrap();
    for i in 0..7 {
        let (x, v) = (x.row(i).to_vec(), run.velocity.row(i).to_vec());
        for (k, energy) in energies(&modes, &x, &v).iter().enumerate() {
            let known = if (2..8).contains(&k) { 0.25 } else { 0.0 };
            assert!((energy - known).abs() < 1e-10, "{i} {k}: {energy}");
        }
        let all = run.chain.energy(&x, &v, 0.0);
        assert!((all / 1.5 - 1.0).abs() < 1e-10, "{all}");
    }
    let v = run.velocity.row(0).to_vec();
    assert!(v.iter().any(|v| v.abs() > 0.1), "phases are not random");
}

/// A mode with an energy is that of the chain as it is; with an amplitude, of the uniform one, as ever.
#[test]
fn val_closed_form_one_mode() {
    let scene = "sites = 16\nlaw = \"spring\"\nends = \"fixed\"\nmode = 3\nend_time = 1.0\n";
    let shape = |j: usize| (PI * 3.0 * (j as f64 + 1.0) / 17.0).sin();
    let by_energy = setup(&format!("{scene}mode_energy = 0.1")).simulation;
    let by_amplitude = setup(&format!("{scene}mode_amplitude = 0.7")).simulation;
    let frequency = 2.0 * (PI * 3.0 / 34.0).sin();
    let amplitude = (2.0 * 0.1f64 / frequency.powi(2) / 8.5).sqrt();
    for j in 0..16 {
        let off = by_energy.displacement[j] - amplitude * shape(j);
        assert!(off.abs() < 1e-13, "{j}: {off:e}");
        assert_eq!(by_energy.velocity[j], 0.0);
        assert!((by_amplitude.displacement[j] - 0.7 * shape(j)).abs() < 1e-15);
    }
    let open = SceneSource::new(None, "sites = 8\nmode = 1\nmode_energy = 0.1").setup();
    let expected = "mode: expected a chain with linear small motion: one with precompression, or of a law that \
                    pulls, too, found contacts that only touch";
    assert_eq!(open.unwrap_err().to_string(), expected);
    let many = "sites = 8\nlaw = \"spring\"\nends = \"free\"\nmodes = [2, 8]\nmode_energy = 0.1";
    let many = SceneSource::new(None, many).setup().unwrap_err();
    let expected = "modes: expected modes from 1 to 7, the first one before the last, found 2, 8";
    assert_eq!(many.to_string(), expected);
}

/// A run in two parts is the run in one.
#[test]
fn val_identity_a_run_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let chain = "sites = 30\nstiffness_ratio = 2.0\ntolerance = 1e-11\nsamples = 11\n";
    let whole = setup(&format!("{chain}end_time = 30.0")).simulation;
    let whole = whole.run(&Silent).unwrap();
    let first = setup(&format!("{chain}end_time = 12.0"));
    let run = first.simulation.run(&Silent).unwrap();
    for name in ["first.npz", "first.nc"] {
        RunFile::write(&path(name), false, &first, &run, &Silent).unwrap();
    }
    let columns = run.displacement.as_ref().unwrap().row(10).to_owned();
    let columns = columns.iter().zip(run.velocity.row(10));
    let rows: String = columns.map(|(x, v)| format!("{v};{x}\n")).collect();
    fs::write(path("first.csv"), format!("velocity;displacement\n{rows}")).unwrap();
    for name in ["first.npz", "first.nc", "first.csv"] {
        let text = format!("{chain}end_time = 18.0\nstate = \"{name}\"\n");
        fs::write(path("second.toml"), text).unwrap();
        let second = SceneSource::read(&path("second.toml")).unwrap();
        let second = second.setup().unwrap();
        assert!(!second.text.contains("first"), "{}", second.text);
        let second = second.simulation.run(&Silent).unwrap();
        let pairs = second
            .velocity
            .row(10)
            .into_iter()
            .zip(whole.velocity.row(10));
        let off = pairs.fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
        println!("{name}: {off:e}");
        assert!(off < 1e-11, "{name}: {off:e}");
    }
}
