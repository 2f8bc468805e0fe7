//! What moved: fields and chains whose answer is known by construction.

use std::f64::consts::PI;

use ndarray::Array2;
use wavecascade::Field;
use wavecascade::analyze::Analysis;
use wavecascade::budget;
use wavecascade::chain::Run;
use wavecascade::chain::scene::SceneSource;
use wavecascade::moved::{Answer, Fate, Reason, Verdict};
use wavecascade::observer::Silent;
use wavecascade::reference::LatticeImpact;

use crate::moved_kinds::{holds, request};
use test_support::fields::{analyzed, noise};

fn field(values: Array2<f64>, dt: f64, dx: f64) -> Field {
    let mut field = Field::from_array(values);
    (field.time.step, field.space.step) = (dt, dx);
    field
}

fn analysis_of(values: Array2<f64>, dt: f64, dx: f64) -> Analysis {
    analyzed(&field(values, dt, dx), &request())
}

fn answer_of(values: Array2<f64>, dt: f64, dx: f64) -> Answer {
    analysis_of(values, dt, dx).answer.unwrap()
}

fn run(scene: &str) -> Run {
    let setup = SceneSource::new(None, scene).setup().unwrap();
    setup.simulation.run(&Silent).unwrap()
}

fn answer_of_run(scene: &str) -> Answer {
    let run = run(scene);
    let mut analysis = analyzed(&run.to_field(), &request());
    budget::answer_of_run(&run, &mut analysis).unwrap();
    analysis.answer.unwrap()
}

/// A struck chain, until its front has passed.
fn chain(keys: &str) -> Answer {
    answer_of_run(&format!(
        "sites = 160\nend_time = 160\nsamples = 2048\ntolerance = 1e-6\n{keys}"
    ))
}

/// By the launch energy moves down in the uniform chain and in dimers; then the front keeps its content, and loses what its waves of
/// constant speed leave behind, which is nothing in the uniform chain and in localized waves.
#[test]
fn val_theory_fronts_lose_energy_and_keep_their_content() {
    for (keys, loss) in [
        ("stiffness_ratio = 1.0", 0.0),
        ("stiffness_ratio = 4.9272268", 0.0),
        ("stiffness_ratio = 14.6221002", 0.0),
        ("stiffness_ratio = 31.275671", 0.0),
        ("mass_ratio = 0.3428", 0.0),
        ("stiffness_ratio = 24", 0.0098),
        ("stiffness_ratio = 1.05", 0.0115),
        ("stiffness_ratio = 20", 0.0148),
        ("stiffness_ratio = 5.5", 0.0179),
        ("stiffness_ratio = 10", 0.101),
        ("stiffness_ratio = 7", 0.132),
        ("stiffness_ratio = 3", 0.733),
        ("stiffness_ratio = 1.5", 0.815),
    ] {
        let found = chain(keys);
        let (front, launch) = (found.front.unwrap(), found.launch.unwrap());
        let off = (front.loss_per_100_bodies - loss).abs();
        assert!(off < 1e-4 + 5e-3 * loss, "{keys}: {front:?}");
        assert!(front.error < 2e-3, "{keys}: {front:?}");
        let moved = &found.frequency;
        assert_eq!(moved.verdict, Verdict::Unchanged, "{keys}: {moved:?}");
        assert!(launch.down.share > launch.up.share, "{keys}: {launch:?}");
    }
}

/// The loss is that of the wave, not of the chain that is simulated.
#[test]
fn val_theory_losses_do_not_depend_on_the_length() {
    for ratio in [4.9272268, 20.0] {
        let losses = [150, 300].map(|sites| {
            let found = answer_of_run(&format!(
                "sites = {sites}\nstiffness_ratio = {ratio}\nend_time = \"auto\"\nsamples = 2048\ntolerance = 1e-6"
            ));
            found.front.unwrap().loss_per_100_bodies
        });
        assert!((losses[0] - losses[1]).abs() < 1e-4, "{ratio}: {losses:?}");
    }
}

/// Between the localized waves a front breaks up into several pulses: it does not fall evenly, and has no content of its own.
#[test]
fn val_theory_a_front_that_breaks_up_is_not_told_to_keep_its_content() {
    let found = chain("stiffness_ratio = 2.398");
    let moved = &found.frequency;
    assert_eq!(moved.verdict, Verdict::Untold, "{moved:?}");
    assert_eq!(moved.reason, Some(Reason::Mixed));
    let front = found.front.unwrap();
    let [least, most] = [-1.0, 1.0].map(|sign| front.loss_per_100_bodies + sign * front.error);
    assert!(least < 0.2, "{front:?}");
    assert!(most > 0.05, "{front:?}");
    assert!(front.error > 0.05, "{front:?}");
}

/// Compressed by more than the impact moves; with losses, which take from the front what none of the later bodies gets; of linear
/// springs, whose high frequencies lag; of unequal masses, which scatter: no energy moves up in any.
#[test]
fn val_theory_other_chains_move_nothing_up() {
    for (keys, words, loss) in [
        (
            "stiffness_ratio = 2.4\nprecompression = 0.1",
            "unchanged, not-gained",
            Some(0.2..0.4),
        ),
        (
            "stiffness_ratio = 4.9272\ndashpot = 0.02",
            "unchanged, not-gained",
            Some(0.8..1.2),
        ),
        ("law = \"spring\"", "lags-at-most, neither", None),
        ("mass_spread = 0.3\nseed = 1", "not-gained", Some(0.3..2.0)),
        ("mass_spread = 0.3\nseed = 3", "not-gained", Some(0.3..2.0)),
    ] {
        let found = chain(keys);
        let moved = &found.frequency;
        for word in words.split(", ") {
            assert!(holds(word, &found), "{keys}: no {word}: {moved:?}");
        }
        assert!(moved.up.share < 0.025 || moved.verdict == Verdict::Down);
        if let Some(loss) = loss {
            let front = found.front.unwrap();
            assert!(loss.contains(&front.loss_per_100_bodies), "{front:?}");
        }
    }
}

/// A wall that shakes below the gap of the small waves: what it sends is no front that loses evenly.
#[test]
fn val_scene_a_driven_end_is_not_told_to_move() {
    let scene = std::fs::read_to_string("examples/scenes/driven_end.toml").unwrap();
    let moved = answer_of_run(&scene).frequency;
    assert!(!moved.moves() && moved.most().share < 0.1, "{moved:?}");
    assert!(moved.transfer.is_none(), "{moved:?}");
}

/// The lattice struck at its end, `J_2j(2 t)`, as a file without a word of its origin: high frequencies lag behind the front, which
/// is neither a transfer nor a loss; what is quiet behind the wave is no noise.
#[test]
fn val_theory_a_dispersive_lattice_lags() {
    let impact = LatticeImpact {
        n_times: 768,
        n_sites: 96,
        dt: 0.125,
    };
    let mut values = Array2::zeros((impact.n_times, impact.n_sites));
    let samples = values.as_slice_mut().unwrap();
    impact.field().read_time_major(0..768, 0..96, samples);
    let found = answer_of(values, 0.125, 1.0);
    let moved = &found.frequency;
    assert_eq!(moved.verdict, Verdict::Down, "{moved:?}");
    assert!(moved.lags && moved.transfer.is_none(), "{moved:?}");
    assert!(moved.up.share < 0.01, "{moved:?}");
    // The group velocity is at most 1, and less on the average over frequencies.
    let speed = found.speed.unwrap();
    assert!((0.8..1.0).contains(&speed.value), "{speed:?}");
}

/// Of a chain between walls, energy in sines: all of the FPUT chain's starts in the first, rises, and comes back; that of a linear
/// chain stays in the mode that it starts in.
#[test]
fn val_theory_modes_between_walls() {
    let fput = "sites = 32\nlaw = \"spring\"\nalpha = 0.25\nends = \"fixed\"\nmode = 1\n\
        mode_amplitude = 1.0\nend_time = 11000.0\nsamples = 4096\ntolerance = 1e-6";
    let found = answer_of_run(fput);
    assert_ne!(found.frequency.transfer, Some(true));
    let moved = &found.wavenumber;
    assert_eq!(moved.verdict, Verdict::Up, "{moved:?}");
    assert_eq!(moved.fate, Some(Fate::Back), "{moved:?}");
    // Out of the first mode, k = pi / 33.
    let up = moved.up;
    assert!(up.share > 0.6, "{up:?}");
    assert!((up.at / (PI / 33.0) - 1.5).abs() < 0.51, "{up:?}");
    let linear = "sites = 64\nlaw = \"spring\"\nends = \"fixed\"\nmode = 5\nmode_amplitude = 1.0\n\
        end_time = 400.0\nsamples = 2048\ntolerance = 1e-6";
    let found = answer_of_run(linear);
    for moved in [&found.frequency, &found.wavenumber] {
        assert_eq!(moved.verdict, Verdict::Unchanged, "{moved:?}");
        assert!(moved.bound < 1e-3, "{moved:?}");
    }
}

/// What is left out is said: too few sites, too short a record, nothing that moves.
#[test]
fn val_construction_reasons() {
    let short = answer_of(noise(12, 20), 1.0, 1.0).frequency.reason;
    assert!(matches!(short, Some(Reason::ShortRecord)), "{short:?}");
    let one = answer_of(noise(512, 1), 1.0, 1.0);
    for moved in [&one.frequency, &one.wavenumber] {
        assert_eq!(moved.verdict, Verdict::Untold);
        assert_eq!(moved.reason, Some(Reason::FewSites));
    }
    let silent = analysis_of(Array2::zeros((512, 16)), 1.0, 1.0);
    assert!(
        silent
            .answer
            .is_none_or(|answer| answer.frequency.verdict == Verdict::Untold)
    );
}
