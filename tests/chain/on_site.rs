//! Springs to the ground, weight and resonators on bodies, against closed forms and independent chains.

use std::f64::consts::{PI, TAU};

use ndarray::Array2;
use test_support::fields::chain;
use test_support::place::Place;
use test_support::scenes::{apart, near, run, setup, simulation};
use wavecascade::chain::scene::SceneSource;
use wavecascade::chain::{Ends, Ground, Law, Run, UnitCell};
use wavecascade::observer::Silent;
use wavecascade::report::RunFile;

/// Modes of a chain of uniform bodies between walls, those of all branches, and the branches themselves.
fn branches_and_modes(keys: &str, branches: impl Fn(f64) -> Vec<f64>) -> UnitCell {
    let (n, many) = (10, branches(1.0).len());
    let it = simulation(&format!(
        "sites = {n}\nlaw = 'spring'\nends = 'fixed'\nend_time = 1.0\n{keys}"
    ));
    let cell = UnitCell::of(&it.chain).unwrap();
    assert_eq!((cell.bodies(), cell.branches()), (1, many));
    for i in 0..40 {
        let q = 0.1 * f64::from(i);
        assert!(apart(cell.frequencies(q), branches(q)) < 5e-8, "{q}");
    }
    let modes = it.chain.normal_modes().unwrap();
    let known = (1..=n).flat_map(|m| branches(PI * f64::from(m) / f64::from(n + 1)));
    let mut known: Vec<f64> = known.collect();
    known.sort_by(f64::total_cmp);
    assert!(apart(&modes.frequency, &known) < 1e-13);
    cell
}

/// With bodies of the mass m on springs c, `omega^2 (m + m_r w^2 / (w^2 - omega^2)) = 4 c sin^2(q/2)`: the gap between
/// both branches lies at the resonance w, up to `w (1 + m_r/m)^{1/2}`.
///
/// Source: H. H. Huang, C. T. Sun, G. L. Huang, Int. J. Eng. Sci. 47, 610 (2009).
#[test]
fn val_theory_branches_and_modes_of_mass_in_mass() {
    let (own, f) = (0.7, 0.12);
    let w = TAU * f;
    let keys = format!("resonator_mass = {own}\nresonator_frequency = {f}");
    let cell = branches_and_modes(&keys, |q| {
        let whole = 4.0 * (0.5 * q).sin().powi(2);
        let half = 0.5 * (w * w * (1.0 + own) + whole);
        let root = (half * half - w * w * whole).sqrt();
        vec![(half - root).max(0.0).sqrt(), (half + root).sqrt()]
    });
    let top = cell.frequencies(0.0)[1];
    near(top / (w * (1.0 + own).sqrt()), 1.0, 1e-14, top);
    let slow = cell.with_time_unit(10.0);
    assert!((slow.frequencies(0.0)[1] / top - 10.0).abs() < 1e-12);
}

/// `omega^2 = (k + 4 c sin^2(q/2)) / m`: a chain held by the ground, its modes, one of which stays, and the branch of its cell.
#[test]
fn val_theory_waves_of_a_held_chain_have_a_lowest_frequency() {
    let (n, mode, k) = (24, 5, 0.7);
    let branch = |q: f64| (k + 4.0 * (0.5 * q).sin().powi(2)).sqrt();
    let cell = branches_and_modes(&format!("ground_cell = [{k}]"), |q| vec![branch(q)]);
    assert!((cell.frequencies(0.0)[0] - k.sqrt()).abs() < 1e-13);
    let q = PI * f64::from(mode) / f64::from(n + 1);
    let run = run(&format!(
        "sites = {n}\nlaw = 'spring'\nends = 'fixed'\nmode = {mode}\nmode_amplitude = 1.0\nground_cell = [{k}]\nsamples = 82\n\
         tolerance = 1e-11\nend_time = {}",
        20.25 * TAU / branch(q)
    ));
    let known = Array2::from_shape_fn(run.velocity.dim(), |(i, j)| {
        -branch(q) * (q * (j + 1) as f64).sin() * (branch(q) * run.time[i]).sin()
    });
    assert!(apart(&run.velocity, &known) < 1e-10);
    assert!(run.report.energy_drift.unwrap() < 1e-12);
}

/// A mode keeps its shape and its energy, bodies and resonators alike; so it does in another run from half of the time on.
#[test]
fn val_theory_a_mode_of_bodies_and_resonators_stays() {
    let place = Place::new();
    let chain = "sites = 9\nlaw = \"spring\"\nmass_ratio = 2.0\nresonator_mass = [0.3, 0.0, 0.9]\n\
                 resonator_stiffness = 0.8\nsamples = 33\nend_time = 20.0\ntolerance = 1e-11\n";
    let setup = setup(&format!(
        "{chain}modes = [7, 7]\nmode_energy = 0.2\nseed = 3\n"
    ));
    let run = setup.simulation.run(&Silent).unwrap();
    let modes = run.chain.normal_modes().unwrap();
    let mut known = vec![0.0; modes.frequency.len()];
    known[modes.free + 6] = 0.2;
    let stays = |run: &Run| {
        for sample in 0..33 {
            let [y, w] = run.resonators_at(sample);
            let x = run.displacement.as_ref().unwrap().row(sample).to_vec();
            let v = run.velocity.row(sample).to_vec();
            let mut found = vec![0.0; known.len()];
            modes.energies(&modes.places(&x, &y), &modes.places(&v, &w), &mut found);
            assert!(apart(&found, &known) < 1e-11, "{sample}: {found:?}");
        }
    };
    stays(&run);
    for name in ["run.npz", "run.nc"] {
        let path = place.path(name);
        RunFile::write(&path, false, &setup, &run, &Silent).unwrap();
        let read = RunFile::read(&path).unwrap();
        assert_eq!(read.run.resonator_displacement, run.resonator_displacement);
        assert_eq!(read.run.resonator_velocity, run.resonator_velocity);
        assert_eq!(read.setup.simulation, setup.simulation);
        place.write("scene.toml", format!("{chain}state = \"{name}\"\n"));
        let onward = SceneSource::read(&place.path("scene.toml")).unwrap();
        let onward = onward.setup().unwrap();
        stays(&onward.simulation.run(&Silent).unwrap());
    }
}

/// What no keys of a scene can say, and a chain on a ridge of its energy, which has no modes.
#[test]
fn regress_grounds_of_other_sites_and_unstable_chains_are_refused() {
    let mut springs = chain(vec![1.0; 12], vec![1.0; 12], Law::Hertz, Ends::Wall);
    springs.on_site.ground = Some(Ground {
        law: Law::Hertz.into(),
        coefficient: vec![1.0; 3],
    });
    assert!(springs.check().is_err(), "coefficients of three sites");
    let ridge = simulation("sites = 6\nlaw = \"polynomial -1 0 1\"\nend_time = 1.0");
    let error = ridge.chain.normal_modes().unwrap_err().to_string();
    assert!(error.contains("stable at rest"), "{error}");
}
