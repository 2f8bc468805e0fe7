//! What moved: kinds of fields of which something else was said than is so, each known by construction.

use std::f64::consts::TAU;

use ndarray::Array2;
use wavecascade::Field;
use wavecascade::analyze::{Analysis, Request, Results};
use wavecascade::chain::scene::SceneSource;
use wavecascade::moved::{Answer, Reason, Verdict};
use wavecascade::observer::Silent;
use wavecascade::reference::GrowingHarmonic;

use test_support::changed;
use test_support::fields::{analyzed, asking, noise};

pub fn request() -> Request {
    Request {
        results: Results {
            flux_surrogate: false,
            short_time: false,
            ..Results::ALL
        },
        maps: false,
        ..Request::default()
    }
}

pub fn analysis_of(values: Array2<f64>) -> Analysis {
    analyzed(&Field::from_array(values), &request())
}

/// Of `times` by `sites` samples, `of(n, j)` in noise of `level`.
pub fn answer_of(
    (times, sites): (usize, usize),
    level: f64,
    of: impl Fn(f64, f64) -> f64,
) -> Answer {
    let noise = noise(times, sites);
    let value = |(n, j): (usize, usize)| of(n as f64, j as f64) + level * noise[[n, j]];
    analysis_of(Array2::from_shape_fn((times, sites), value))
        .answer
        .unwrap()
}

pub fn hann(s: f64, length: f64) -> f64 {
    match (0.0..length).contains(&s) {
        true => 0.5 - 0.5 * (TAU * s / length).cos(),
        false => 0.0,
    }
}

/// A burst of `length` samples at the frequency f.
pub fn burst(s: f64, f: f64, length: f64) -> f64 {
    hann(s, length) * (TAU * f * s).sin()
}

pub fn ricker(s: f64, w: f64) -> f64 {
    (1.0 - (s / w).powi(2)) * (-0.5 * (s / w).powi(2)).exp()
}

/// Bursts of 0.02 and 0.05 cycles a sample from the two ends: neither has moved to the other. Pulses of one shape have not either,
/// whatever they come from.
#[test]
fn val_construction_two_origins_are_no_move() {
    for level in [0.0, 3e-3] {
        let found = answer_of((2048, 48), level, |n, j| {
            let (a, b) = (n - 300.0 - 14.0 * j, n - 350.0 - 14.0 * (47.0 - j));
            burst(a, 0.02, 250.0) + burst(b, 0.05, 250.0)
        });
        let moved = &found.frequency;
        assert_eq!(moved.reason, Some(Reason::Mixed), "{level}: {moved:?}");
        assert_eq!(moved.verdict, Verdict::Untold, "{level}: {moved:?}");
        assert_eq!(found.speed, None, "{level}");
    }
    let found = answer_of((2048, 48), 1e-3, |n, j| {
        let (a, b) = (n - 300.0 - 14.0 * j, n - 350.0 - 14.0 * (47.0 - j));
        ricker(a, 12.0) + 0.6 * ricker(b, 12.0)
    });
    assert_eq!(found.frequency.verdict, Verdict::Unchanged);
}

/// An array that rings down from the first sample on, each site at its own phase: no quiet part goes before. A drift by itself
/// changes nothing of a pulse.
#[test]
fn val_construction_transients_without_a_lead_are_not_told() {
    let found = answer_of((2048, 32), 3e-3, |n, j| {
        let decays = (-n / 250.0).exp();
        decays * ((TAU * 0.03 * n + 2.0 * j).sin() + 0.1 * j * (TAU * 0.08 * n + j).sin())
    });
    let moved = &found.frequency;
    let is_cut = matches!(moved.reason, Some(Reason::ShortRecord));
    assert!(is_cut, "{moved:?}");
    let found = answer_of((2048, 32), 1e-3, |n, j| {
        let drift = 0.1 * (1.7 * j).sin() * n / 2048.0 + 3.0 * (0.7 * j).cos();
        burst(n - 500.0 - 10.0 * j, 0.03, 200.0) + drift
    });
    let moved = &found.frequency;
    assert!(!moved.moves(), "{moved:?}");
}

/// A burst of two lines that beat, and its second harmonic that grows to a third of the energy: windows hold all beats, and the share
/// that moves is that of the means over the first and the last four sites, 0.30. The speed is that of all of it.
#[test]
fn val_construction_bursts_that_beat_are_held() {
    for level in [0.0, 1e-2] {
        let found = answer_of((2048, 48), level, |n, j| {
            let s = n - 300.0 - 12.0 * j;
            let second = (1.0f64 / 3.0).sqrt() * j / 47.0;
            let beats = burst(s, 0.03, 330.0) + 0.8 * burst(s, 0.0345, 330.0);
            let beats = beats / 1.64f64.sqrt();
            (1.0 - second * second).sqrt() * beats + second * burst(s, 0.06, 330.0)
        });
        let moved = &found.frequency;
        assert_eq!(moved.verdict, Verdict::Up, "{level}: {moved:?}");
        assert!((moved.up.share - 0.30).abs() < 0.03, "{level}: {moved:?}");
        assert_eq!(moved.transfer, Some(true), "{level}: {moved:?}");
        let speed = found.speed.unwrap();
        let off = (speed.value - 1.0 / 12.0).abs();
        assert!(off < speed.error, "{level}: {speed:?}");
        assert!(speed.error < 3e-3, "{level}: {speed:?}");
    }
}

/// A short burst whose harmonic interferes with it: its centroid shifts by a part of a period, which the interval of the speed says.
#[test]
fn val_construction_speeds_of_short_bursts_hold() {
    for cycles in [1.3, 1.7, 2.2] {
        let found = answer_of((1024, 40), 3e-3, |n, j| {
            let s = n - 200.0 - 6.0 * j;
            let second = 0.3f64.sqrt() * j / 39.0;
            let length = cycles / 0.02;
            (1.0 - second * second).sqrt() * burst(s, 0.02, length)
                + second * burst(s, 0.04, length)
        });
        let speed = found.speed.unwrap();
        let off = (speed.value * 6.0 - 1.0).abs();
        assert!(off < 6.0 * speed.error, "{cycles}: {speed:?}");
        assert!(6.0 * speed.error < 0.2, "{cycles}: {speed:?}");
    }
}

/// What comes back falls into windows of twice the length near the far end; the speed is that of the way there.
#[test]
fn val_construction_reflections_do_not_slow_the_front() {
    let found = answer_of((2048, 60), 1e-3, |n, j| {
        let (a, b) = (n - 200.0 - 14.0 * j, n - 200.0 - 14.0 * (118.0 - j));
        ricker(a, 12.0) - 0.8 * ricker(b, 12.0)
    });
    let speed = found.speed.unwrap();
    assert!((speed.value * 14.0 - 1.0).abs() < 1e-3, "{speed:?}");
    assert_eq!(found.frequency.verdict, Verdict::Unchanged);
}

/// A second harmonic that grows while all is damped, to 5 % of the energy at first: energy is gained there all the same. Of two lines, the
/// lower of which is damped, none is gained.
#[test]
fn val_construction_growth_under_damping_is_a_transfer() {
    let of = |grows: bool| {
        answer_of((2048, 40), 0.0, |n, j| {
            let (s, x) = (n - 300.0 - 12.0 * j, j / 39.0);
            let damped = (-1.5 * x).exp();
            match grows {
                true => damped * (burst(s, 0.03, 300.0) + 0.6 * x * burst(s, 0.06, 300.0)),
                false => damped * burst(s, 0.03, 300.0) + 0.5 * burst(s, 0.06, 300.0),
            }
        })
    };
    let moved = of(true).frequency;
    assert_eq!(moved.verdict, Verdict::Up, "{moved:?}");
    assert_eq!(moved.transfer, Some(true), "{moved:?}");
    let moved = of(false).frequency;
    assert_eq!(moved.verdict, Verdict::Up, "{moved:?}");
    assert_eq!(moved.transfer, Some(false), "{moved:?}");
}

/// A pulse whose record ends soon behind it, so that ten of its widths fit nowhere: shorter windows hold it.
#[test]
fn val_construction_short_records_have_short_windows() {
    let found = answer_of((1024, 40), 1e-3, |n, j| {
        let s = n - 300.0 - 10.0 * j;
        let second = 0.25f64.sqrt() * j / 39.0;
        (1.0 - second * second).sqrt() * burst(s, 0.03, 260.0) + second * burst(s, 0.06, 260.0)
    });
    let moved = &found.frequency;
    assert_eq!(moved.verdict, Verdict::Up, "{moved:?}");
    let [first, last] = moved.to.unwrap().rows;
    let by = 0.25 * (0.5 * (first + last) as f64 / 39.0).powi(2);
    assert!((moved.up.share - by).abs() < 2e-3, "{by} {moved:?}");
    assert!(last >= 35, "{moved:?}");
}

/// Noise at twelve sites that follow each other in nothing, white and of slow frequencies: at most one of 40 fields moves. White
/// noise and offsets do not fold.
#[test]
fn val_noise_moves_nothing() {
    let white = noise(1500, 40 * 12);
    let mut moves = [0, 0];
    for k in 0..40 {
        let mut values = Array2::from_shape_fn((1500, 12), |(n, j)| white[[n, 12 * k + j]]);
        for slow in moves.iter_mut() {
            let analysis = analysis_of(values.clone());
            let moved = &analysis.answer.as_ref().unwrap().frequency;
            *slow += usize::from(moved.moves());
            if k < 5 {
                let is_noise = matches!(analysis.undirected, Some(Reason::Noise { .. }));
                assert!(is_noise, "{k}: {:?}", analysis.undirected);
            }
            for n in 1..1500 {
                for j in 0..12 {
                    values[[n, j]] += 0.8 * values[[n - 1, j]];
                }
            }
        }
    }
    assert!(moves[0] <= 1 && moves[1] <= 3, "{moves:?}");
    let noise = noise(1024, 32);
    let tone = |(n, j): (usize, usize)| {
        let wave = (TAU * (0.07 * n as f64 - 0.11 * j as f64)).cos();
        wave + 0.01 * noise[[n, j]] + 20.0 * noise[[3, j]]
    };
    let found = analysis_of(Array2::from_shape_fn((1024, 32), tone));
    assert_eq!(found.undirected, None);
}

/// Masses and coefficients that change threefold along a chain reflect next to nothing (1e-3 of the energy that has passed, by the
/// work at the contacts): the front keeps its energy, which lies at frequencies that fall as masses grow.
#[test]
fn val_identity_graded_chains_keep_their_energy() {
    for (key, value, expected) in [
        ("mass_taper", 3.0, Verdict::Down),
        ("mass_taper", 0.33, Verdict::Up),
        ("coefficient_taper", 0.2, Verdict::Down),
    ] {
        let scene = format!(
            "sites = 160\n{key} = {value}\nend_time = 300\nsamples = 4096\ntolerance = 1e-6"
        );
        let setup = SceneSource::new(None, &scene).setup().unwrap();
        let run = setup.simulation.run(&Silent).unwrap();
        let request = asking(|it| it.maps = false);
        let answer = analyzed(&run.to_field(), &request).answer.unwrap();
        let moved = &answer.frequency;
        assert_eq!(moved.verdict, expected, "{key} {value}: {moved:?}");
        let front = answer.front.unwrap();
        assert!(
            front.loss_per_100_bodies.abs() < 0.005,
            "{key} {value}: {front:?}"
        );
        assert!(!moved.lags, "{key} {value}: {moved:?}");
    }
}

/// What is said of the velocities of a run alone, and of the run, whose chain is known.
pub fn answers_of_scene(text: &str) -> [Answer; 2] {
    let setup = SceneSource::new(None, text).setup().unwrap();
    let run = setup.simulation.run(&Silent).unwrap();
    let mut analysis = analyzed(&run.to_field(), &Request::default());
    let alone = analysis.answer.clone().unwrap();
    wavecascade::budget::answer_of_run(&run, &mut analysis).unwrap();
    [alone, analysis.answer.unwrap()]
}

/// Linear waves keep their frequencies: of bursts whose parts travel at different speeds nothing is transferred, wherever they
/// are driven, though windows late along the chain miss what arrives after them.
#[test]
fn val_theory_bursts_in_linear_chains_transfer_nothing() {
    for (sites, site, ratio, frequency) in [
        (60, 0, 2.0, 0.1),
        (60, 20, 2.0, 0.1),
        (60, 0, 1.0, 0.1),
        (150, 0, 1.0, 0.25),
        (150, 75, 1.0, 0.25),
        (150, 40, 1.0, 0.29),
        (300, 0, 2.0, 0.1),
    ] {
        let text = format!(
            "sites = {sites}\nlaw = \"spring\"\nends = \"free\"\nmass_ratio = {ratio}\ndrive = \"force\"\n\
             drive_site = {site}\ndrive_waveform = \"tone-burst\"\ndrive_amplitude = 0.2\ndrive_frequency = {frequency}\n\
             drive_cycles = 6\nend_time = 200.0\nsamples = 1024\ntolerance = 1e-6"
        );
        let [alone, known] = answers_of_scene(&text);
        let alone = alone.frequency;
        assert_ne!(
            alone.transfer,
            Some(true),
            "{sites} {site} {frequency}: {alone:?}"
        );
        let moved = known.frequency;
        let is_quiet = moved.lags || !moved.moves();
        assert!(is_quiet, "{sites} {site} {frequency}: {moved:?}");
    }
}

/// In the gap of a mass-in-mass chain a wave decays and what is left is what the burst has beside the gap: nothing has moved.
#[test]
fn val_theory_a_gap_moves_nothing() {
    let text = wavecascade::chain::scene::preset("mass_in_mass")
        .unwrap()
        .text;
    let [alone, known] = answers_of_scene(text);
    let frequency = &alone.frequency;
    assert_ne!(frequency.transfer, Some(true), "{frequency:?}");
    let moved = known.frequency;
    assert!(moved.verdict != Verdict::Up || moved.lags, "{moved:?}");
    // Its velocities as a field of which nothing else is known.
    let setup = SceneSource::new(None, text).setup().unwrap();
    let run = setup.simulation.run(&Silent).unwrap();
    let mut field = Field::from_array(run.velocity.clone());
    field.time.step = run.time[1];
    let analysis = analyzed(&field, &Request::default());
    let moved = &analysis.answer.as_ref().unwrap().frequency;
    assert_ne!(moved.transfer, Some(true), "{moved:?}");
    let words = analysis.words().answer;
    assert!(!words.starts_with("energy moves"), "{words}");
}

/// A second harmonic that grows is a move up in both, where the sites tell its wavenumber; where they do not, it
/// folds to a longer wave, and in time nothing is told.
#[test]
fn val_armstrong_a_growing_harmonic_moves_up_unless_it_folds() {
    let at_distance = |dx: f64, n_sites: usize| {
        let example = GrowingHarmonic::EXAMPLE;
        let grid = changed(example.grid, |it| (it.dx, it.n_sites) = (dx, n_sites));
        analyzed(
            &GrowingHarmonic { grid, ..example }.field(),
            &Request::default(),
        )
        .answer
        .unwrap()
    };
    let found = at_distance(0.008, 96);
    assert_eq!(found.frequency.verdict, Verdict::Up);
    let wavenumber = &found.wavenumber;
    assert_eq!(wavenumber.verdict, Verdict::Up, "{wavenumber:?}");
    // 0.02 m: the harmonic's 251 rad/m appear as 63, below the fundamental's 126.
    let found = at_distance(0.02, 48);
    assert_eq!(found.frequency.verdict, Verdict::Up);
    let moved = &found.wavenumber;
    assert_eq!(
        moved.reason,
        Some(Reason::Aperture { folds: true }),
        "{moved:?}"
    );
}

/// A Lorentzian pulse whose spectrum `exp(-b f)` absorption narrows by `exp(-x f)` becomes a longer one in closed form: what it loses
/// does not lag behind.
#[test]
fn val_theory_an_absorbed_pulse_does_not_lag() {
    for (b, rate) in [(30.0, 1.0), (40.0, 2.0), (20.0, 0.5)] {
        let found = answer_of((2048, 48), 1e-4, |n, j| {
            let (s, b) = (TAU * (n - 500.0 - 10.0 * j), b + rate * j);
            b * b / (b * b + s * s) * 30.0 / b
        });
        let moved = &found.frequency;
        assert!(!moved.lags, "{b} {rate}: {moved:?}");
        assert_ne!(moved.transfer, Some(true), "{b} {rate}: {moved:?}");
    }
}

/// A burst whose second harmonic grows to two fifths of its energy, in noise that hides when it arrives: what is said not to move is
/// more than moves, or nothing is said.
#[test]
fn val_construction_bounds_hold_in_loud_noise() {
    // Means over the first and the last four sites.
    let moves = 0.4 * (1407.5 - 3.5) / 39f64.powi(2);
    for level in [0.1, 0.2, 0.3, 0.4] {
        let found = answer_of((2048, 40), level, |n, j| {
            let (s, second) = (n - 500.0 - 9.0 * j, 0.4f64.sqrt() * j / 39.0);
            (1.0 - second * second).sqrt() * burst(s, 0.04, 300.0) + second * burst(s, 0.08, 300.0)
        });
        let moved = &found.frequency;
        let holds = match moved.verdict {
            Verdict::Unchanged => moved.bound > moves,
            Verdict::Up | Verdict::Untold => true,
            _ => false,
        };
        assert!(holds, "{level}: {moved:?}");
        let is_late = matches!(moved.reason, Some(Reason::ShortRecord));
        assert!(!is_late, "{level}: {moved:?}");
    }
}

/// A Hertz chain that is compressed by far more than the impact moves is all but linear, and its wavenumbers keep their energies: high
/// frequencies lag behind its front.
#[test]
fn val_identity_chains_that_keep_their_wavenumbers_transfer_nothing() {
    let text = "sites = 120\nprecompression = 1.0\nstriker_velocity = 0.1\nend_time = 110.0\nsamples = 2048\ntolerance = 1e-7";
    let [_, known] = answers_of_scene(text);
    let wavenumber = &known.wavenumber;
    assert_eq!(wavenumber.verdict, Verdict::Unchanged, "{wavenumber:?}");
    let moved = known.frequency;
    assert!(moved.lags || !moved.moves(), "{moved:?}");
    assert_eq!(moved.transfer, None, "{moved:?}");
}

/// Of a burst in noise above a hundredth of its amplitude the first sample above that is none of the wave: no share is that of a front.
#[test]
fn val_construction_noise_ahead_of_a_burst_is_no_front() {
    let noise = noise(2048, 48);
    let of = |level: f64| {
        analysis_of(Array2::from_shape_fn((2048, 48), |(n, j)| {
            let at = n as f64 - 500.0 - 9.0 * j as f64;
            burst(at, 0.03, 300.0) + level * noise[[n, j]]
        }))
    };
    for level in [0.005, 0.01, 0.02] {
        let front = of(level).front.unwrap();
        assert!(
            front.high_share.iter().all(|share| share.is_nan()),
            "{level}"
        );
    }
    let front = of(1e-5).front.unwrap();
    assert!(front.high_share[20].is_finite());
}

/// What sensors add to all samples is no motion: a burst over an offset a million times as large is told as without it.
#[test]
fn val_symmetry_an_offset_changes_nothing() {
    let [plain, offset] = [0.0, 1e6].map(|offset| {
        let found = answer_of((800, 40), 1e-3, |n, j| {
            offset + burst(n - 100.0 - 10.0 * j, 0.06, 60.0)
        });
        found.frequency
    });
    assert_eq!(plain.verdict, Verdict::Unchanged, "{plain:?}");
    assert_eq!(offset.verdict, plain.verdict, "{offset:?}");
    assert!(plain.bound < 1.5e-3 && offset.bound < 1.5e-3, "{offset:?}");
}
