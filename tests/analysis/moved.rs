//! What moved: fields and chains whose answer is known by construction.

use std::f64::consts::{PI, TAU};

use ndarray::Array2;
use serde_json::json;
use wavecascade::Field;
use wavecascade::analyze::Analysis;
use wavecascade::budget;
use wavecascade::chain::Run;
use wavecascade::chain::scene::SceneSource;
use wavecascade::moved::{Answer, Fate, Reason, Verdict};
use wavecascade::observer::Silent;
use wavecascade::reference::LatticeImpact;

use crate::moved_kinds::{hann, request, ricker};
use test_support::changed;
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

/// A scan of 56 points 2.5 mm apart at 125 kHz: `of(t, x)` at 120 m/s, in noise of `level` of 1 um/s.
fn scan(level: f64, of: impl Fn(f64, f64) -> f64) -> Answer {
    let (dt, dx, nt, nx) = (8e-6, 2.5e-3, 4096, 56);
    let noise = noise(nt, nx);
    let value = |(n, j): (usize, usize)| {
        let (t, x) = (n as f64 * dt, j as f64 * dx);
        1e-6 * (of(t - 7e-3 - x / 120.0, x) + level * noise[[n, j]])
    };
    answer_of(Array2::from_shape_fn((nt, nx), value), dt, dx)
}

fn burst(s: f64, f: f64) -> f64 {
    hann(s, 2.4e-3) * (TAU * f * s).sin()
}

/// A burst of 4 kHz whose second harmonic holds 0.2 (x / L)^2 of the energy: between the means over the first and the last four
/// points, 0.189 of it moves, and none is lost. At any noise up to a third of that share's amplitude.
#[test]
fn val_construction_a_growing_harmonic_moves_up() {
    let length = 55.0 * 2.5e-3;
    for level in [0.0, 5e-4, 5e-3, 1e-2, 3e-2] {
        let found = scan(level, |s, x| {
            let second = 0.2f64.sqrt() * x / length;
            (1.0 - second * second).sqrt() * burst(s, 4e3) + second * burst(s, 8e3)
        });
        let moved = &found.frequency;
        assert_eq!(moved.verdict, Verdict::Up, "{level}: {moved:?}");
        let up = moved.up;
        let off = (up.share - 0.189).abs();
        assert!(off < 0.003 + 0.1 * level, "{level}: {up:?}");
        assert!(off < 2.0 * up.error, "{level}: {up:?}");
        assert!((4.3e3..7.5e3).contains(&up.at), "{level}: {up:?}");
        assert!(moved.down.share < 0.002, "{level}: {moved:?}");
        assert_eq!(moved.transfer, Some(true), "{level}");
        let energy_ratio = moved.energy_ratio;
        assert!((energy_ratio - 1.0).abs() < 0.02, "{level}: {energy_ratio}");
        // The burst is longer than the array.
        let folds = false;
        assert_eq!(found.wavenumber.reason, Some(Reason::Aperture { folds }));
        let speed = found.speed.unwrap();
        let error = (speed.value - 120.0).abs();
        assert!(error < 2.0 * speed.error.max(0.05), "{level}: {speed:?}");
    }
}

/// The same burst without harmonics, as it is and fading by exp(-x / 50 mm): nothing moves.
#[test]
fn val_construction_linear_scans_move_nothing() {
    let linear = scan(5e-3, |s, _| burst(s, 4e3));
    assert_eq!(linear.frequency.verdict, Verdict::Unchanged);
    assert!(linear.frequency.bound < 0.005, "{}", linear.frequency.bound);
    let fading = scan(5e-3, |s, x| burst(s, 4e3) * (-x / 0.05).exp());
    let frequency = &fading.frequency;
    assert_eq!(frequency.verdict, Verdict::Unchanged, "{frequency:?}");
    assert!(fading.frequency.bound < 0.06, "{}", fading.frequency.bound);
    // Means over four points of exp(-2 x / 50 mm), 52 points apart.
    let exact = (-2.0 * 52.0 * 2.5 / 50.0f64).exp();
    assert!((fading.frequency.energy_ratio / exact - 1.0).abs() < 0.15);
}

/// Two lines, of which one is absorbed: the share moves, but no energy is gained.
#[test]
fn val_construction_absorption_is_no_transfer() {
    for (absorbed, verdict) in [(8e3, Verdict::Down), (4e3, Verdict::Up)] {
        let found = scan(0.0, |s, x| {
            let fading = |f: f64| {
                if f == absorbed {
                    (-x / 0.07).exp()
                } else {
                    1.0
                }
            };
            fading(4e3) * burst(s, 4e3) + 0.5 * fading(8e3) * burst(s, 8e3)
        });
        assert_eq!(found.frequency.verdict, verdict, "{:?}", found.frequency);
        assert_eq!(found.frequency.transfer, Some(false));
    }
}

/// A pulse of constant shape that enters after the start and does not reach the last sites.
#[test]
fn val_construction_a_constant_pulse() {
    let (dt, dx) = (1e-3, 0.012);
    let noise = noise(900, 240);
    let value = |(n, j): (usize, usize)| {
        let s = (j as f64 * dx - 0.3 - 2.2 * n as f64 * dt) / 0.035;
        (-0.5 * s * s).exp() + 1e-3 * noise[[n, j]]
    };
    let found = answer_of(Array2::from_shape_fn((900, 240), value), dt, dx);
    for (moved, bound) in [(&found.frequency, 0.01), (&found.wavenumber, 0.05)] {
        assert_eq!(moved.verdict, Verdict::Unchanged, "{moved:?}");
        assert!(moved.bound < bound, "{moved:?}");
    }
    // Sites that the wave has passed before the record, or does not reach, are no part of it.
    let [from, to] = [found.frequency.from.unwrap(), found.frequency.to.unwrap()];
    assert!(from.rows[0] >= 25 && to.rows[1] <= 190, "{from:?} {to:?}");
    let speed = found.speed.unwrap();
    assert!((speed.value - 2.2).abs() < 1e-3, "{speed:?}");
}

/// Steady waves: standing, one way, and white noise. None moves, and noise has no direction.
#[test]
fn val_construction_steady_fields_move_nothing() {
    let (dt, dx, nt, nx) = (1e-3, 0.01, 2048, 60);
    let noise = noise(nt, nx);
    let of = |level: f64, wave: &dyn Fn(f64, f64) -> f64| {
        let value =
            |(n, j): (usize, usize)| wave(n as f64 * dt, j as f64 * dx) + level * noise[[n, j]];
        analysis_of(Array2::from_shape_fn((nt, nx), value), dt, dx)
    };
    let standing = of(1e-3, &|t, x| {
        (TAU * 43.95 * t).cos() * (TAU * x / 0.15 + 0.4).cos()
    });
    let tone = of(1e-2, &|t, x| (TAU * (71.7 * t - 4.0 * x)).cos());
    let white = of(1.0, &|_, _| 0.0);
    for (name, found, bound) in [
        ("standing", &standing, 0.01),
        ("tone", &tone, 0.01),
        ("white", &white, 0.15),
    ] {
        let answer = found.answer.as_ref().unwrap();
        for moved in [&answer.frequency, &answer.wavenumber] {
            assert_eq!(moved.verdict, Verdict::Unchanged, "{name}: {moved:?}");
            assert!(moved.bound < bound, "{name}: {moved:?}");
        }
        assert!(!answer.has_fronts, "{name}");
    }
    assert!(standing.undirected.is_none() && tone.undirected.is_none());
    assert!(white.undirected.is_some());
    // It sweeps from wavelengths as long as the array.
    let chirp = of(1e-2, &|t, x| {
        let s = t - x / 80.0;
        (TAU * (25.0 * s + 0.5 * 150.0 / 2.048 * s * s)).cos()
    });
    let answer = chirp.answer.unwrap();
    let frequency = &answer.frequency;
    assert_eq!(frequency.verdict, Verdict::Unchanged, "{frequency:?}");
    let wavenumber = &answer.wavenumber;
    assert_eq!(wavenumber.verdict, Verdict::Untold, "{wavenumber:?}");
}

/// A record of random waves with a hum, dead channels, offsets or gain steps: each as it is.
#[test]
fn val_construction_faults_of_channels_move_nothing() {
    let (dt, dx, nt, nx) = (1e-3, 0.01, 2048, 60);
    let source = noise(80, 2);
    // Eighty waves of 2.5 m/s, of a Gaussian band of 6 Hz around 22 Hz.
    let wave = |t: f64, x: f64| -> f64 {
        let lines = source.outer_iter().enumerate().map(|(i, line)| {
            let off = 36.0 * (i as f64 / 79.0 - 0.5);
            let s = TAU * (22.0 + off) * (t - x / 2.5);
            (-off * off / 72.0).exp() * (line[0] * s.cos() + line[1] * s.sin())
        });
        lines.sum::<f64>() / 23.3f64.sqrt()
    };
    let noise = noise(nt, nx);
    let clean = Array2::from_shape_fn((nt, nx), |(n, j)| {
        wave(n as f64 * dt, j as f64 * dx) + 0.02 * noise[[n, j]]
    });
    let with = |change: &dyn Fn(usize, usize, f64) -> f64| {
        let value = |(n, j): (usize, usize)| change(n, j, clean[[n, j]]);
        analysis_of(Array2::from_shape_fn((nt, nx), value), dt, dx)
    };
    let fields = [
        (
            "hum",
            with(&|n, _, v| v + 4.0 * (TAU * 60.0 * n as f64 * dt).cos()),
        ),
        (
            "dead",
            with(&|_, j, v| if j == 7 || j == 41 { 0.2 } else { v }),
        ),
        ("offsets", with(&|_, j, v| v + 15.0 * noise[[0, j]])),
        (
            "gain",
            with(&|n, j, v| match j {
                9 if n >= nt / 2 => 4.0 * v,
                30.. => 6.0 * v,
                _ => v,
            }),
        ),
    ];
    // What is left of a wave that fades into noise has its content.
    let fades = with(&|n, j, v| (-(j as f64) / 20.0).exp() * v + 0.1 * noise[[n, j]]);
    let moved = fades.answer.unwrap().frequency;
    assert_eq!(moved.verdict, Verdict::Unchanged, "{moved:?}");
    for (name, analysis) in fields {
        let said: Vec<String> = analysis
            .warnings
            .iter()
            .map(|of| of.message.clone())
            .collect();
        let wanted = match name {
            "hum" => "60 cycles/unit of time common to all sites (k = 0) holds 87 %",
            "dead" => "sites 7, 41 at 0.07, 0.41 unit of length: constant",
            "offsets" => "lies at f = 0",
            _ => "the gain changes along x, x 5.99",
        };
        assert!(
            said.iter().any(|said| said.contains(wanted)),
            "{name}: {said:?}"
        );
        let mut gains = analysis.warnings.clone();
        gains.retain(|of| of.code.starts_with("gain-"));
        match name {
            "gain" => {
                assert_eq!(gains.len(), 2, "{gains:?}");
                for (gain, (site, exact)) in gains.iter().zip([(30, 6.0), (9, 4.0)]) {
                    assert_eq!(gain.numbers["sites"], json!([site]));
                    let ratio = gain.numbers["ratios"][0].as_f64().unwrap();
                    assert!((ratio / exact - 1.0).abs() < 0.1, "{gains:?}");
                }
            }
            _ => assert!(gains.is_empty(), "{name}: {gains:?}"),
        }
        let found = analysis.answer.unwrap();
        assert_eq!(
            found.frequency.energy_ratio.is_nan(),
            name == "gain",
            "{name}"
        );
        assert_eq!(
            found.frequency.verdict,
            Verdict::Unchanged,
            "{name}: {:?}",
            found.frequency
        );
        // Segments follow the wave: those of neighbours say the same.
        let bound = match name {
            "gain" => 0.13,
            "hum" => 0.08,
            _ => 0.03,
        };
        let frequency = &found.frequency;
        assert!(frequency.bound < bound, "{name}: {frequency:?}");
        let in_time = found.wavenumber.verdict;
        assert!(
            matches!(in_time, Verdict::Unchanged | Verdict::Untold),
            "{name}: {in_time:?}"
        );
    }
}

/// Pulses from both ends, and one that comes back: windows that hold both are left out.
#[test]
fn val_construction_reflections_are_left_out() {
    let (dt, dx, nt, nx) = (1e-3, 0.01, 2048, 60);
    let last = 59.0 * dx;
    let noise = noise(nt, nx);
    let of = |wave: &dyn Fn(f64, f64) -> f64| {
        let value =
            |(n, j): (usize, usize)| wave(n as f64 * dt, j as f64 * dx) + 1e-3 * noise[[n, j]];
        analysis_of(Array2::from_shape_fn((nt, nx), value), dt, dx)
    };
    let two = of(&|t, x| {
        ricker(t - 0.3 - x / 0.6, 0.02) + 0.4 * ricker(t - 0.3 - (last - x) / 0.6, 0.02)
    });
    let back = of(&|t, x| {
        ricker(t - 0.2 - x / 1.1, 0.02) + 0.7 * ricker(t - 0.2 - (2.0 * last - x) / 1.1, 0.02)
    });
    // Energies 1 and 0.16; 1 and 0.49.
    for (name, found, plus) in [("two", two, 1.0 / 1.16), ("back", back, 1.0 / 1.49)] {
        let answer = found.answer.unwrap();
        for (moved, bound) in [(&answer.frequency, 0.01), (&answer.wavenumber, 0.1)] {
            assert_eq!(moved.verdict, Verdict::Unchanged, "{name}: {moved:?}");
            assert!(moved.bound < bound, "{name}: {moved:?}");
        }
        let direction = found.direction.unwrap();
        assert!(
            (direction.toward_plus_x - plus).abs() < 0.007,
            "{name}: {direction:?}"
        );
        assert_eq!(found.undirected, None, "{name}");
    }
}

/// A pulse half of whose wavelength is shorter than the spacing: its direction is withheld.
#[test]
fn val_construction_an_aliased_pulse_has_no_direction() {
    let value = |(n, j): (usize, usize)| ricker(n as f64 * 1e-3 - 0.25 - j as f64 / 90.0, 0.0045);
    let found = analysis_of(Array2::from_shape_fn((2000, 50), value), 1e-3, 1.0);
    assert!(found.undirected.is_some());
    assert_eq!(found.answer.unwrap().frequency.verdict, Verdict::Unchanged);
}

/// A dispersive pulse: its shape changes along x, the spectrum of each site does not.
#[test]
fn val_construction_dispersion_moves_nothing() {
    let (nt, nx, dx) = (1024, 220, 0.01);
    let waves: Vec<[f64; 3]> = (0..560)
        .map(|i| -280.0 + f64::from(i))
        .map(|k| {
            [
                k,
                1.8 * k * (1.0 - 3e-6 * k * k),
                (-0.5 * (k / 55.0).powi(2)).exp(),
            ]
        })
        .collect();
    let largest: f64 = waves.iter().map(|[.., a]| a).sum();
    let noise = noise(nt, nx);
    let value = |(n, j): (usize, usize)| {
        let (t, x) = (n as f64 * 1e-3, j as f64 * dx - 0.35);
        let sum: f64 = waves
            .iter()
            .map(|[k, w, a]| a * (k * x - w * t).cos())
            .sum();
        sum / largest + 1e-4 * noise[[n, j]]
    };
    let found = answer_of(Array2::from_shape_fn((nt, nx), value), 1e-3, dx);
    for moved in [&found.frequency, &found.wavenumber] {
        assert_eq!(moved.verdict, Verdict::Unchanged, "{moved:?}");
        assert!(moved.bound < 0.05, "{moved:?}");
    }
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

/// Between a dispersive ratio and its walls, compressed by more than the impact moves; and with losses, which take from the front what
/// none of the later bodies gets: no energy moves up in either.
#[test]
fn val_theory_compressed_and_lossy_chains_move_nothing_up() {
    for (keys, loss) in [
        ("stiffness_ratio = 2.4\nprecompression = 0.1", 0.2..0.4),
        ("stiffness_ratio = 4.9272\ndashpot = 0.02", 0.8..1.2),
    ] {
        let found = chain(keys);
        let moved = &found.frequency;
        assert_eq!(moved.verdict, Verdict::Unchanged, "{keys}: {moved:?}");
        assert!(moved.up.share < 0.025, "{keys}: {moved:?}");
        let front = found.front.unwrap();
        assert!(
            loss.contains(&front.loss_per_100_bodies),
            "{keys}: {front:?}"
        );
    }
}

/// A chain of linear springs moves no energy in frequency: high frequencies lag behind its front, and E(k) stays.
#[test]
fn val_theory_a_linear_chain_disperses() {
    let found = chain("law = \"spring\"");
    let moved = &found.frequency;
    assert!(moved.lags || !moved.moves(), "{moved:?}");
    assert!(moved.transfer.is_none(), "{moved:?}");
    assert!(moved.up.share < 0.01, "{moved:?}");
    let moved = &found.wavenumber;
    assert_eq!(moved.verdict, Verdict::Unchanged, "{moved:?}");
    assert!(moved.bound < 0.01, "{moved:?}");
}

/// Unequal masses scatter the pulse: the front loses most of its energy, none of which moves up.
#[test]
fn val_theory_disorder_moves_nothing_up() {
    for seed in 1..4 {
        let found = chain(&format!("mass_spread = 0.3\nseed = {seed}"));
        let moved = &found.frequency;
        assert_ne!(moved.verdict, Verdict::Up, "{seed}: {moved:?}");
        assert_ne!(moved.transfer, Some(true), "{seed}: {moved:?}");
        let front = found.front.unwrap();
        assert!(front.loss_per_100_bodies > 0.3, "{seed}: {front:?}");
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

/// Bits of the answer depend neither on the number of threads nor on the block size.
#[test]
fn regress_answers_are_the_same_on_any_number_of_threads() {
    let run =
        run("sites = 80\nstiffness_ratio = 2.4\nend_time = 90\nsamples = 1024\ntolerance = 1e-6");
    let answer = |threads| {
        let request = changed(request(), |it| it.threads = Some(threads));
        analyzed(&run.to_field(), &request).answer.unwrap()
    };
    let one = answer(1);
    for threads in [2, 3] {
        assert_eq!(format!("{:?}", answer(threads)), format!("{one:?}"));
    }
}
