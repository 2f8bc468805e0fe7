//! What moved: kinds of fields of which something else was said than is so, each known by construction.

use std::f64::consts::{PI, TAU};

use ndarray::Array2;
use wavecascade::Field;
use wavecascade::analyze::{Analysis, Request, Results};
use wavecascade::chain::scene::SceneSource;
use wavecascade::moved::{Answer, Fate, Reason, Verdict};
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

/// Whether a word, with a number or none, is true of what is said of a field's frequencies.
pub fn holds(expected: &str, found: &Answer) -> bool {
    let moved = &found.frequency;
    let (word, number) = expected.split_once(' ').unwrap_or((expected, "0"));
    let number: f64 = number.parse().unwrap();
    match word {
        "up" => moved.verdict == Verdict::Up,
        "down" => moved.verdict == Verdict::Down,
        "unchanged" => moved.verdict == Verdict::Unchanged,
        "untold" => moved.verdict == Verdict::Untold,
        "still" => !moved.moves(),
        "lags-at-most" => moved.lags || !moved.moves(),
        "prompt" => !moved.lags,
        "gained" => moved.transfer == Some(true),
        "absorbed" => moved.transfer == Some(false),
        "not-gained" => moved.transfer != Some(true),
        "neither" => moved.transfer.is_none(),
        "back" => moved.fate == Some(Fate::Back),
        "lost" => moved.fate == Some(Fate::Lost),
        "share" => (moved.up.share - number).abs() < 0.02,
        "bound" => moved.bound < number,
        "delay" => found
            .speed
            .is_some_and(|speed| (speed.value - 1.0 / number).abs() < 2.0 * speed.error),
        "speedless" => found.speed.is_none(),
        _ => panic!("{expected}"),
    }
}

/// A line and its harmonic of these amplitudes, as a burst.
fn pair(s: f64, f: f64, length: f64, [first, second]: [f64; 2]) -> f64 {
    first * burst(s, f, length) + second * burst(s, 2.0 * f, length)
}

/// Amplitudes of a line and of its harmonic that has this share of the energy.
fn shared(share: f64) -> [f64; 2] {
    [(1.0 - share).sqrt(), share.sqrt()]
}

fn gauss(s: f64, f: f64, width: f64) -> f64 {
    (-0.5 * (s / width).powi(2)).exp() * (TAU * f * s).cos()
}

/// A line of 0.058 cycles a sample and its harmonic, later by 1 / 0.42 samples a site.
fn gauss_pair(n: f64, j: f64, [first, second]: [f64; 2]) -> f64 {
    let s = n - 300.0 - j / 0.42;
    first * gauss(s, 0.058, 28.0) + second * gauss(s, 0.116, 28.0)
}

/// Waves `w = c k (1 - beta k^2)` about the site 35.
fn dispersive(n: f64, j: f64, [c, beta, carrier, width]: [f64; 4]) -> f64 {
    let waves = (1..560).map(|i| {
        let k = 0.005 * f64::from(i);
        let a = (-0.5 * ((k - carrier) / width).powi(2)).exp();
        [
            a,
            a * (k * (j - 35.0) - c * k * (1.0 - beta * k * k) * n).cos(),
        ]
    });
    let [all, sum] = waves.fold([0.0; 2], |[all, sum], [a, wave]| [all + a, sum + wave]);
    sum / all
}

type Motion = fn(f64, f64) -> f64;

/// Name, samples and sites, levels of noise, the motion of sample and site, and what is true of the answer.
type Kind = (
    &'static str,
    (usize, usize),
    &'static [f64],
    Motion,
    &'static str,
);

/// Shares are means over the first and the last four sites.
const KINDS: [Kind; 25] = [
    (
        "a harmonic grows",
        (4096, 56),
        &[0.0, 5e-3, 3e-2],
        |n, j| {
            pair(
                n - 875.0 - 2.604 * j,
                0.032,
                300.0,
                shared(0.2 * (j / 55.0).powi(2)),
            )
        },
        "up, gained, share 0.189, delay 2.604",
    ),
    (
        "a harmonic of two lines that beat grows",
        (2048, 48),
        &[0.0, 1e-2],
        |n, j| {
            let (s, [first, second]) = (n - 300.0 - 12.0 * j, shared((j / 47.0).powi(2) / 3.0));
            let beats = burst(s, 0.03, 330.0) + 0.8 * burst(s, 0.0345, 330.0);
            first * beats / 1.64f64.sqrt() + second * burst(s, 0.06, 330.0)
        },
        "up, gained, share 0.3, delay 12",
    ),
    (
        "a harmonic grows in a short burst",
        (1024, 40),
        &[3e-3],
        |n, j| {
            pair(
                n - 200.0 - 6.0 * j,
                0.02,
                85.0,
                shared(0.3 * (j / 39.0).powi(2)),
            )
        },
        "delay 6",
    ),
    (
        "a harmonic grows in a short record",
        (1024, 40),
        &[1e-3],
        |n, j| {
            pair(
                n - 300.0 - 10.0 * j,
                0.03,
                260.0,
                shared(0.25 * (j / 39.0).powi(2)),
            )
        },
        "up",
    ),
    (
        "a harmonic grows under damping",
        (2048, 40),
        &[0.0],
        |n, j| (-j / 26.0).exp() * pair(n - 300.0 - 12.0 * j, 0.03, 300.0, [1.0, j / 65.0]),
        "up, gained",
    ),
    (
        "a harmonic out of step",
        (1200, 52),
        &[5e-3],
        |n, j| {
            let part = 0.7 * (PI * j / 52.0).sin();
            gauss_pair(n, j, [part.cos(), part.sin()])
        },
        "up, gained, share 0.407, back",
    ),
    (
        "a harmonic rises and is absorbed",
        (1200, 52),
        &[5e-3],
        |n, j| {
            let part = 0.85 * (j / 16.0).min(1.0);
            gauss_pair(
                n,
                j,
                [part.cos(), part.sin() * (-(j - 16.0).max(0.0) / 5.0).exp()],
            )
        },
        "up, gained, lost",
    ),
    (
        "a line is lost beside its harmonic, under uneven gains",
        (1200, 52),
        &[5e-3],
        |n, j| (1.0 + 0.2 * (7.3 * j * j).sin()) * gauss_pair(n, j, [(-1.2 * j / 52.0).exp(), 0.4]),
        "not-gained",
    ),
    (
        "the lower line is damped",
        (2048, 40),
        &[0.0],
        |n, j| pair(n - 300.0 - 12.0 * j, 0.03, 300.0, [(-j / 26.0).exp(), 0.5]),
        "up, absorbed",
    ),
    (
        "the upper line is absorbed",
        (4096, 56),
        &[0.0],
        |n, j| {
            pair(
                n - 875.0 - 2.604 * j,
                0.032,
                300.0,
                [1.0, 0.5 * (-j / 28.0).exp()],
            )
        },
        "down, absorbed",
    ),
    (
        "absorption makes a pulse longer",
        (2048, 48),
        &[1e-4],
        |n, j| {
            let (s, b) = (TAU * (n - 500.0 - 10.0 * j), 30.0 + j);
            b * b / (b * b + s * s) * 30.0 / b
        },
        "prompt, not-gained",
    ),
    (
        "a wave decays and leaves what passes",
        (4096, 64),
        &[2e-3],
        |n, j| {
            let slow = (-0.32 * j).exp() * burst(n - 600.0, 0.006, 1000.0);
            slow + 0.008 * burst(n - 620.0 - 6.0 * j, 0.012, 700.0)
        },
        "not-gained",
    ),
    (
        "a burst",
        (4096, 56),
        &[5e-3],
        |n, j| burst(n - 875.0 - 2.604 * j, 0.032, 300.0),
        "unchanged, bound 0.005, delay 2.604",
    ),
    (
        "a burst over an offset",
        (800, 40),
        &[1e-3],
        |n, j| 1e6 + burst(n - 100.0 - 10.0 * j, 0.06, 60.0),
        "unchanged, bound 0.0015",
    ),
    (
        "a burst over drifts",
        (2048, 32),
        &[1e-3],
        |n, j| {
            let drift = 0.1 * (1.7 * j).sin() * n / 2048.0 + 3.0 * (0.7 * j).cos();
            burst(n - 500.0 - 10.0 * j, 0.03, 200.0) + drift
        },
        "still",
    ),
    (
        "a burst fades",
        (4096, 56),
        &[5e-3],
        |n, j| (-j / 20.0).exp() * burst(n - 875.0 - 2.604 * j, 0.032, 300.0),
        "unchanged, bound 0.06",
    ),
    (
        "a pulse that windows cut",
        (2000, 120),
        &[1e-3],
        |n, j| (-0.5 * ((j - 30.0 - 0.032 * n) / 4.9).powi(2)).exp(),
        "unchanged, bound 0.1",
    ),
    (
        "a pulse that comes back",
        (2048, 60),
        &[1e-3],
        |n, j| {
            ricker(n - 200.0 - 14.0 * j, 12.0) - 0.8 * ricker(n - 200.0 - 14.0 * (118.0 - j), 12.0)
        },
        "unchanged, delay 14",
    ),
    (
        "a pulse before a fixed end",
        (4096, 64),
        &[2e-3],
        |n, j| {
            let passed = |i: i32| {
                if i % 2 == 0 {
                    f64::from(i) * 63.0 + j
                } else {
                    f64::from(i + 1) * 63.0 - j
                }
            };
            let pulse = |i: i32| (-0.9f64).powi(i) * ricker(n - 500.0 - 4.17 * passed(i), 30.0);
            (0..30).map(pulse).sum()
        },
        "still",
    ),
    (
        "pulses of one shape from both ends",
        (2048, 48),
        &[1e-3],
        |n, j| {
            ricker(n - 300.0 - 14.0 * j, 12.0) + 0.6 * ricker(n - 350.0 - 14.0 * (47.0 - j), 12.0)
        },
        "unchanged",
    ),
    (
        "bursts of two frequencies from both ends",
        (2048, 48),
        &[0.0, 3e-3],
        |n, j| {
            burst(n - 300.0 - 14.0 * j, 0.02, 250.0)
                + burst(n - 350.0 - 14.0 * (47.0 - j), 0.05, 250.0)
        },
        "untold, speedless",
    ),
    (
        "a slow wave falls behind a fast one",
        (3600, 52),
        &[4e-3],
        |n, j| {
            gauss(n - 200.0 - 5.0 * j, 0.095, 9.0) + 1.2 * gauss(n - 200.0 - 10.0 * j, 0.04, 13.0)
        },
        "lags-at-most, neither",
    ),
    (
        "a dispersive pulse outlasts the record",
        (1024, 300),
        &[1e-4],
        |n, j| dispersive(n, j, [0.234, 0.054, 0.8, 0.6]),
        "lags-at-most, neither",
    ),
    (
        "an array rings down from the start",
        (2048, 32),
        &[3e-3],
        |n, j| {
            (-n / 250.0).exp()
                * ((TAU * 0.03 * n + 2.0 * j).sin() + 0.1 * j * (TAU * 0.08 * n + j).sin())
        },
        "untold",
    ),
    (
        "a standing tone",
        (2048, 60),
        &[1e-3],
        |n, j| (TAU * 0.04395 * n).cos() * (TAU * j / 15.0 + 0.4).cos(),
        "unchanged, bound 0.01",
    ),
];

#[test]
fn val_construction_kinds_of_fields_and_what_is_said_of_them() {
    for (name, shape, levels, of, expected) in KINDS {
        for level in levels {
            let found = answer_of(shape, *level, of);
            for word in expected.split(", ") {
                let said = (&found.frequency, &found.speed);
                assert!(holds(word, &found), "{name}, {level}: no {word}: {said:?}");
            }
        }
    }
}

/// Noise at twelve sites that follow each other in nothing, white and of slow frequencies: at most one of 40 fields moves, and none has
/// a direction.
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
            let is_noise = matches!(analysis.undirected, Some(Reason::Noise { .. }));
            assert!(is_noise || k >= 5, "{k}: {:?}", analysis.undirected);
            for n in 1..1500 {
                for j in 0..12 {
                    values[[n, j]] += 0.8 * values[[n - 1, j]];
                }
            }
        }
    }
    assert!(moves[0] <= 1 && moves[1] <= 3, "{moves:?}");
}

/// A wave towards +x in noise of three quarters of the energy and more: noise goes both ways, and counts for neither.
#[test]
fn val_construction_noise_has_no_direction() {
    let noise = noise(4096, 56);
    for level in [0.05, 0.1, 0.2] {
        let scan = |(n, j): (usize, usize)| {
            burst(n as f64 - 900.0 - 2.6 * j as f64, 0.032, 300.0) + level * noise[[n, j]]
        };
        let analysis = analysis_of(Array2::from_shape_fn((4096, 56), scan));
        let all = analysis.direction.unwrap();
        let waves = analysis.direction_of_waves().unwrap();
        assert!(all.toward_minus_x > 0.04, "{level}: {all:?}");
        assert!(waves.toward_plus_x > 0.95, "{level}: {waves:?}");
    }
}

/// What is said of the front in a short chain is what is said of it in a long one, or nothing: its launch is no move.
#[test]
fn val_identity_short_chains_say_what_long_ones_do() {
    for ratio in [1.0, 2.398, 4.9272, 8.04, 14.622, 100.0] {
        let of = |sites: usize| {
            let text = format!(
                "sites = {sites}\nstiffness_ratio = {ratio}\nend_time = {}\nsamples = 1024\ntolerance = 1e-7",
                sites + 6
            );
            let [_, known] = answers_of_scene(&text);
            known.frequency.verdict
        };
        let long = of(100);
        assert_eq!(long == Verdict::Unchanged, ratio != 2.398, "{ratio}");
        for sites in [8, 10, 12, 16, 20, 24, 26, 30, 36, 40, 60, 80] {
            let short = of(sites);
            let is_same = short == Verdict::Untold || short == long;
            assert!(is_same, "{ratio}, {sites}: {short:?} {long:?}");
        }
    }
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
