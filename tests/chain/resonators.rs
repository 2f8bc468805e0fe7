//! Resonators on bodies, against closed forms and DOP853 of SciPy (`tests/data/make_resonators.py`).

use std::f64::consts::{PI, TAU};
use std::fs;

use ndarray::ArrayView1;
use serde_json::Value;
use wavecascade::chain::scene::SceneSource;
use wavecascade::chain::{Run, Simulation, UnitCell};
use wavecascade::observer::Silent;
use wavecascade::report::RunFile;

fn setup(text: &str) -> Result<Simulation, String> {
    let setup = SceneSource::new(None, text).setup();
    setup
        .map(|setup| setup.simulation)
        .map_err(|error| error.to_string())
}

fn run(text: &str) -> Run {
    setup(text).unwrap().run(&Silent).unwrap()
}

fn off(found: ArrayView1<f64>, known: &Value) -> f64 {
    let pairs = found.iter().zip(known.as_array().unwrap());
    pairs.fold(0.0, |most, (a, b)| {
        most.max((a - b.as_f64().unwrap()).abs())
    })
}

#[test]
fn val_scipy_resonators() {
    let text = fs::read_to_string("tests/data/resonators.json").unwrap();
    let known: Value = serde_json::from_str(&text).unwrap();
    for (name, case) in known.as_object().unwrap() {
        let run = run(case["scene"].as_str().unwrap());
        let last = run.time.len() - 1;
        let scale = run.report.velocity_scale;
        let displacement = run.displacement.as_ref().unwrap();
        let y = run.resonator_displacement.as_ref().unwrap();
        let w = run.resonator_velocity.as_ref().unwrap();
        let states = [
            ("displacement", displacement),
            ("velocity", &run.velocity),
            ("resonator_displacement", y),
            ("resonator_velocity", w),
        ];
        let offs = states.map(|(key, array)| off(array.row(last), &case[key]) / scale);
        let energy = 0.5 * scale * scale;
        let put_in = run.energy_input.as_ref().map_or(0.0, |input| input[last]);
        let lost = run
            .energy_lost
            .as_ref()
            .map_or(0.0, |lost| lost.row(last).sum());
        let heat = (lost - case["lost"].as_f64().unwrap()).abs() / energy;
        let work = (put_in - case["work"].as_f64().unwrap()).abs() / energy;
        let drift = run.report.energy_drift.unwrap();
        println!("{name}: {offs:?} heat {heat:.1e} work {work:.1e} drift {drift:.1e}");
        // DOP853 steps over openings.
        let most = if name.starts_with("open chain") {
            5e-12
        } else {
            4e-13
        };
        for off in offs {
            assert!(off < most, "{name}: {offs:?}");
        }
        assert!(heat < 3e-13 && work < 1e-12, "{name}: {heat:e} {work:e}");
        assert!(drift < 3e-14, "{name}: {drift:e}");
        let stated = run.report.error.unwrap();
        assert!(stated < 1e-11, "{name}: {stated:e}");
    }
}

/// With bodies of the mass m on springs c, `omega^2 (m + m_r w^2 / (w^2 - omega^2)) = 4 c sin^2(q/2)`: the gap between
/// both branches lies at the resonance w, up to `w (1 + m_r/m)^{1/2}`.
///
/// Source: H. H. Huang, C. T. Sun, G. L. Huang, Int. J. Eng. Sci. 47, 610 (2009).
#[test]
fn val_theory_branches_and_modes_of_mass_in_mass() {
    let (n, own, f) = (10, 0.7, 0.12);
    let text = format!(
        "sites = {n}\nlaw = \"spring\"\nends = \"fixed\"\nend_time = 1.0\n\
         resonator_mass = {own}\nresonator_frequency = {f}\n"
    );
    let chain = setup(&text).unwrap().chain;
    let w = TAU * f;
    let branches = |q: f64| {
        let whole = 4.0 * (0.5 * q).sin().powi(2);
        let half = 0.5 * (w * w * (1.0 + own) + whole);
        let root = (half * half - w * w * whole).sqrt();
        [(half - root).max(0.0).sqrt(), (half + root).sqrt()]
    };
    let cell = UnitCell::of(&chain).unwrap();
    assert_eq!((cell.bodies(), cell.branches()), (1, 2));
    for i in 0..40 {
        let q = 0.1 * f64::from(i);
        let pairs = cell.frequencies(q).into_iter().zip(branches(q));
        pairs.for_each(|(a, b)| assert!((a - b).abs() < 1e-7 * w, "{q}: {a} {b}"));
    }
    let top = cell.frequencies(0.0)[1];
    assert!(
        (top / (w * (1.0 + own).sqrt()) - 1.0).abs() < 1e-14,
        "{top}"
    );
    let slow = cell.with_time_unit(10.0);
    assert!((slow.frequencies(0.0)[1] / top - 10.0).abs() < 1e-12);
    let modes = chain.normal_modes().unwrap();
    let mut expected: Vec<f64> = (1..=n)
        .flat_map(|m| branches(PI * f64::from(m) / f64::from(n + 1)))
        .collect();
    expected.sort_by(f64::total_cmp);
    for (a, b) in modes.frequency.iter().zip(&expected) {
        assert!((a - b).abs() < 1e-13, "{a} {b}");
    }
    assert_eq!(modes.frequency.len(), expected.len());
}

/// A mode keeps its shape and its energy, bodies and resonators alike; so it does in another run from half of the time on.
#[test]
fn val_theory_a_mode_of_bodies_and_resonators_stays() {
    let folder = tempfile::tempdir().unwrap();
    let chain = "sites = 9\nlaw = \"spring\"\nmass_ratio = 2.0\nresonator_mass = [0.3, 0.0, 0.9]\n\
                 resonator_stiffness = 0.8\nsamples = 33\nend_time = 20.0\ntolerance = 1e-11\n";
    let source = SceneSource::new(
        None,
        format!("{chain}modes = [7, 7]\nmode_energy = 0.2\nseed = 3\n"),
    );
    let setup = source.setup().unwrap();
    let run = setup.simulation.run(&Silent).unwrap();
    let modes = run.chain.normal_modes().unwrap();
    let energies = |run: &Run, sample: usize| {
        let [y, w] = run.resonators_at(sample);
        let x = run.displacement.as_ref().unwrap().row(sample).to_vec();
        let mut all = vec![0.0; modes.frequency.len()];
        modes.energies(
            &modes.places(&x, &y),
            &modes.places(&run.velocity.row(sample).to_vec(), &w),
            &mut all,
        );
        all
    };
    let stays = |run: &Run| {
        for sample in 0..33 {
            for (mode, energy) in energies(run, sample).iter().enumerate() {
                let expected = if mode == modes.free + 6 { 0.2 } else { 0.0 };
                assert!(
                    (energy - expected).abs() < 1e-11,
                    "{sample} {mode}: {energy:e}"
                );
            }
        }
    };
    stays(&run);
    for name in ["run.npz", "run.nc"] {
        let path = folder.path().join(name);
        RunFile::write(&path, false, &setup, &run, &Silent).unwrap();
        let read = RunFile::read(&path).unwrap();
        assert_eq!(read.run.resonator_displacement, run.resonator_displacement);
        assert_eq!(read.run.resonator_velocity, run.resonator_velocity);
        assert_eq!(read.setup.simulation, setup.simulation);
        let scene = folder.path().join("scene.toml");
        fs::write(&scene, format!("{chain}state = \"{name}\"\n")).unwrap();
        let onward = SceneSource::read(&scene).unwrap().setup().unwrap();
        stays(&onward.simulation.run(&Silent).unwrap());
    }
}

/// Bodies that move together carry their resonators along, which feel nothing.
#[test]
fn val_identity_a_chain_in_flight_stays_as_it_is() {
    let run = run(
        "sites = 5\nends = \"free\"\nvelocities = [1.0, 1.0, 1.0, 1.0, 1.0]\nresonator_mass = 0.4\n\
         resonator_frequency = 0.3\nresonator_damping = 0.1\nend_time = 9.0\nsamples = 4\n",
    );
    let w = run.resonator_velocity.as_ref().unwrap();
    let mut all = run.velocity.iter().chain(w);
    assert!(all.all(|v| (v - 1.0).abs() < 1e-14));
}

/// Peaks between samples are found with the pull of resonators: as among samples twenty times as dense.
#[test]
fn val_denser_samples_peaks_beside_resonators() {
    let text = |samples: usize| {
        format!(
            "sites = 10\nlaw = \"spring\"\nresonator_mass = 2.0\nresonator_stiffness = 40.0\nstriker_velocity = 1.0\n\
             end_time = 4.0\nsamples = {samples}\ntolerance = 1e-10"
        )
    };
    let (coarse, fine) = (run(&text(81)), run(&text(20 * 80 + 1)));
    for contact in [0, 1, 2] {
        let [a, b] = [&coarse, &fine].map(|run| run.peak_force(contact).unwrap());
        let off = (a.value - b.value).abs() / b.value;
        assert!(off < 2e-6, "{contact}: {off:e}");
    }
}
