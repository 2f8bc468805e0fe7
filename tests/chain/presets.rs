//! Scenes that come with the program against the published results that they show.

use std::f64::consts::{PI, TAU};

use ndarray::ArrayView1;
use num_complex::Complex;
use wavecascade::chain::scene::{PRESETS, SceneSource, Setting, preset};
use wavecascade::chain::{Run, Simulation, UnitCell};
use wavecascade::observer::Silent;

fn simulation(name: &str, settings: &[(&str, &str)]) -> Simulation {
    let scene = SceneSource::new(None, preset(name).unwrap().text);
    let settings = settings
        .iter()
        .map(|(key, text)| Setting::new(key, *text, "a test"));
    scene.with(settings).setup().unwrap().simulation
}

fn run(name: &str, settings: &[(&str, &str)]) -> Run {
    simulation(name, settings).run(&Silent).unwrap()
}

/// The frequency at which a signal that swings about 0 passes it upwards, from the first pass to the last.
fn frequency(run: &Run, signal: ArrayView1<f64>) -> f64 {
    let rises: Vec<f64> = (1..signal.len())
        .filter(|&i| signal[i - 1] < 0.0 && signal[i] >= 0.0)
        .map(|i| {
            let share = signal[i - 1] / (signal[i - 1] - signal[i]);
            run.time[i - 1] + share * (run.time[i] - run.time[i - 1])
        })
        .collect();
    (rises.len() - 1) as f64 / (rises[rises.len() - 1] - rises[0])
}

#[test]
fn each_is_a_scene_of_the_folder() {
    for preset in PRESETS {
        let setup = SceneSource::new(None, preset.text).setup();
        assert!(setup.is_ok(), "{}: {:?}", preset.name, setup.err());
    }
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes");
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), PRESETS.len());
}

/// `v_j = sinh k (tanh(theta + k) - tanh theta)`, `theta = k (j - 12) - t sinh k`: nothing is shed at any time.
#[test]
fn val_closed_form_the_soliton_of_toda_sheds_nothing() {
    let run = run("toda_soliton", &[("tolerance", "1e-11")]);
    let k = 1f64;
    let mut off = 0f64;
    for (row, t) in run.velocity.rows().into_iter().zip(&run.time) {
        for (j, v) in row.iter().enumerate() {
            let theta = k * (j as f64 - 12.0) - t * k.sinh();
            let expected = k.sinh() * ((theta + k).tanh() - theta.tanh());
            off = off.max((v - expected).abs());
        }
    }
    assert!(off < 1e-10, "{off:e}");
}

/// A wave of the speed c presses with `c^6 psi^{3/2}`, psi the largest overlap of that of speed 1 (`data/solitary_wave.json`).
#[test]
fn val_published_the_speed_in_sonic_vacuum_is_the_sixth_root_of_the_force() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/solitary_wave.json");
    let wave: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let overlap = wave["largest_overlap"].as_f64().unwrap();
    for (speed, end) in [("0.1", "190"), ("1", "120")] {
        let run = run(
            "sonic_vacuum",
            &[("striker_velocity", speed), ("end_time", end)],
        );
        let force = run.force.as_ref().unwrap();
        // Where a contact presses most, by a parabola through three samples.
        let peak = |contact: usize| {
            let column = force.column(contact);
            let at = (1..column.len() - 1)
                .max_by(|a, b| column[*a].total_cmp(&column[*b]))
                .unwrap();
            let [a, b, c] = [column[at - 1], column[at], column[at + 1]];
            let shift = 0.5 * (a - c) / (a - 2.0 * b + c);
            (
                run.time[at] + shift * run.time[1],
                b - 0.25 * (a - c) * shift,
            )
        };
        let ((before, force), (after, _)) = (peak(60), peak(90));
        let found = 30.0 / (after - before);
        let expected = (force / overlap.powf(1.5)).powf(1.0 / 6.0);
        assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
        // The wave is five bodies wide: hardly any kinetic energy is farther than two and a half from its middle.
        let at = run
            .time
            .iter()
            .position(|t| *t >= 0.5 * (before + after))
            .unwrap();
        let energy = run.velocity.row(at).mapv(|v| v * v);
        let middle = (0..120)
            .max_by(|a, b| energy[*a].total_cmp(&energy[*b]))
            .unwrap();
        let near: f64 = energy.slice(ndarray::s![middle - 2..=middle + 2]).sum();
        assert!(near / energy.sum() > 0.98, "{}", near / energy.sum());
    }
}

/// No wave between `(2c/m)^{1/2}` of the heavy and of the light mass: far from the blow less than a thousandth of the energy.
#[test]
fn val_theory_the_gap_of_two_masses() {
    let simulation = simulation("diatomic", &[]);
    let cell = UnitCell::of(&simulation.chain).unwrap();
    let edges = cell.frequencies(PI / 2.0);
    assert!((edges[0] - (2.0f64 / 3.0).sqrt()).abs() < 1e-12);
    assert!((edges[1] - 2f64.sqrt()).abs() < 1e-12);
    let run = simulation.run(&Silent).unwrap();
    let (n, step) = (run.time.len(), run.time[1]);
    let (mut inside, mut whole) = (0.0, 0.0);
    for site in 16..40 {
        let v = run.velocity.column(site);
        for bin in 1..150 {
            let omega = TAU * bin as f64 / (n as f64 * step);
            let (mut re, mut im) = (0.0, 0.0);
            for (i, v) in v.iter().enumerate() {
                let window = 0.5 - 0.5 * (TAU * i as f64 / n as f64).cos();
                let (sin, cos) = (TAU * (bin * i % n) as f64 / n as f64).sin_cos();
                (re, im) = (re + window * v * cos, im + window * v * sin);
            }
            let energy = re * re + im * im;
            whole += energy;
            if (0.9..1.33).contains(&omega) {
                inside += energy;
            }
        }
    }
    assert!(inside / whole < 1e-3, "{}", inside / whole);
}

/// The energy of the first mode of the alpha chain comes back: DOP853 of SciPy 1.17 (relative tolerance 1e-10, these samples) has
/// 0.9807124 of it after 153.4272 of its periods, and 0.0856380 at least.
#[test]
fn val_scipy_the_alpha_chain_recurs() {
    let run = run("fput", &[("end_time", "12500"), ("tolerance", "1e-6")]);
    let x = run.displacement.as_ref().unwrap();
    let n = 32;
    let omega = 2.0 * (PI / (2.0 * (n + 1) as f64)).sin();
    let shape: Vec<f64> = (0..n)
        .map(|j| (PI * (j + 1) as f64 / (n + 1) as f64).sin())
        .collect();
    let energy: Vec<f64> = (0..run.time.len())
        .map(|i| {
            let of =
                |row: ArrayView1<f64>| -> f64 { row.iter().zip(&shape).map(|(a, b)| a * b).sum() };
            of(run.velocity.row(i)).powi(2) + (omega * of(x.row(i))).powi(2)
        })
        .collect();
    let least = energy.iter().fold(f64::INFINITY, |a, b| a.min(*b)) / energy[0];
    let from = run
        .time
        .iter()
        .position(|t| *t * omega / TAU > 120.0)
        .unwrap();
    let back = (from..energy.len())
        .max_by(|a, b| energy[*a].total_cmp(&energy[*b]))
        .unwrap();
    let periods = run.time[back] * omega / TAU;
    assert!((least - 0.085_638).abs() < 2e-6, "{least}");
    assert!((periods - 153.427_2).abs() < 1e-4, "{periods}");
    assert!(
        (energy[back] / energy[0] - 0.980_712_4).abs() < 2e-6,
        "{}",
        energy[back] / energy[0]
    );
}

/// Modes of the beta chain that are even about its middle stay without energy.
#[test]
fn val_symmetry_the_beta_chain_keeps_to_odd_modes() {
    let run = run("fput_beta", &[("end_time", "1000")]);
    for row in run.velocity.rows() {
        for j in 0..16 {
            assert!(
                (row[j] - row[31 - j]).abs() < 1e-8,
                "{}",
                row[j] - row[31 - j]
            );
        }
    }
    // Energy does leave the first mode.
    let row = run.velocity.row(run.time.len() - 1);
    let of = |k: f64| -> f64 {
        row.iter()
            .enumerate()
            .map(|(j, v)| v * (PI * k * (j + 1) as f64 / 33.0).sin())
            .sum()
    };
    assert!(of(3.0).abs() > 1e-3 * of(1.0).abs());
}

/// In the modes at the edges of the gap one kind of contact alone is strained, by A: `A'' = -2 (A -+ b A^3)`, whose frequency is
/// that of Duffing's oscillator, `(2 -+ 2 b A^2)^{1/2} / (4 K)` with `K` of `m = -+ b A^2 / (2 (1 -+ b A^2))`.
#[test]
fn val_published_a_gap_opens_with_the_amplitude() {
    // Complete elliptic integral of the first kind, by the arithmetic-geometric mean.
    let duffing = |amplitude: f64, b: f64| {
        let stiffness = 2.0 * (1.0 + b * amplitude * amplitude);
        let m = b * amplitude * amplitude / stiffness;
        let (mut a, mut g) = (1.0f64, (1.0 - m).sqrt());
        for _ in 0..8 {
            (a, g) = (0.5 * (a + g), (a * g).sqrt());
        }
        stiffness.sqrt() * a / TAU
    };
    let simulation = simulation("alternating", &[]);
    for (shift, sign) in [(0, -1.0), (1, 1.0)] {
        for amplitude in [0.01, 0.5, 1.0] {
            let mut edge = simulation.clone();
            let shape = &simulation.displacement;
            edge.displacement = (0..32)
                .map(|j| amplitude * shape[(j + shift) % 32])
                .collect();
            let run = edge.run(&Silent).unwrap();
            let x = run.displacement.as_ref().unwrap();
            // 0, 1 | 2, 3: the pair of sites 0 and 1, or 1 and 2, moves as one.
            let found = frequency(&run, x.column(1));
            let strained = [x[[0, 0]] - x[[0, 1]], x[[0, 1]] - x[[0, 2]]];
            let soft = strained[0].abs() > strained[1].abs();
            let b = if soft { -0.1 } else { 0.1 };
            assert_eq!(soft, sign < 0.0, "{strained:?}");
            let expected = duffing(amplitude, b);
            assert!(
                (found / expected - 1.0).abs() < 2e-5,
                "{amplitude} {b}: {found} {expected}"
            );
        }
    }
}

/// After the impact each contact rests in one of its wells, 0 and 3, and those at 3 keep 0.45 each: `V(3) = 27 k / 12`, k = 0.2.
#[test]
fn val_energy_bistable_contacts_keep_energy() {
    let run = run("bistable", &[]);
    let x = run.displacement.as_ref().unwrap();
    let last = x.row(run.time.len() - 1).to_vec();
    let overlap = |j: usize| last[j] - last.get(j + 1).copied().unwrap_or(0.0);
    let full = (0..16).filter(|j| (overlap(*j) - 3.0).abs() < 1e-5).count();
    let empty = (0..16).filter(|j| overlap(*j).abs() < 1e-5).count();
    assert_eq!(full + empty, 16);
    assert!(full > 0);
    let lost: f64 = run
        .energy_lost
        .as_ref()
        .unwrap()
        .row(run.time.len() - 1)
        .sum();
    let kept = 0.5 * 16.0 - lost;
    assert!((kept - 0.45 * full as f64).abs() < 1e-6, "{kept} {full}");
}

/// The peak force of the pulse falls behind random masses, and the more the more they differ.
#[test]
fn val_published_a_pulse_decays_in_disorder() {
    let left = |spread: &str| {
        let run = run(
            "disordered",
            &[("mass_spread", spread), ("tolerance", "1e-6")],
        );
        let force = run.force.as_ref().unwrap();
        let peak = |contact: usize| {
            force
                .column(contact)
                .iter()
                .fold(0.0, |a: f64, b| a.max(*b))
        };
        peak(100) / peak(10)
    };
    let found = ["0", "0.2", "0.5"].map(left);
    assert!((found[0] - 1.0).abs() < 0.02, "{found:?}");
    assert!(found[1] < 0.9 * found[0], "{found:?}");
    assert!(found[2] < 0.5 * found[1], "{found:?}");
}

/// The gap at the resonance w: `w (1 + m_r/m)^{1/2}` is its upper edge, the top of the lower branch its lower one. In it a wave falls by
/// `exp(-kappa)` a body, `2 - 2 cosh kappa = omega^2 (1 + m_r w^2 / (w^2 - omega^2))`; below and above it passes.
#[test]
fn val_published_the_resonance_opens_a_gap() {
    let (own, w) = (0.5f64, TAU * 0.15);
    let cell = UnitCell::of(&simulation("mass_in_mass", &[]).chain).unwrap();
    let sum = w * w * (1.0 + own) + 4.0;
    let lower = (0.5 * (sum - (sum * sum - 16.0 * w * w).sqrt())).sqrt();
    assert!((cell.frequencies(PI)[0] / lower - 1.0).abs() < 1e-13);
    let upper = w * (1.0 + own).sqrt();
    assert!((cell.frequencies(0.0)[1] / upper - 1.0).abs() < 1e-13);
    let peak = |run: &Run, site: usize| {
        let column = run.velocity.column(site);
        column.iter().fold(0.0, |most: f64, v| most.max(v.abs()))
    };
    let passed = |run: &Run| {
        let passed = run.energy_passed.as_ref().unwrap();
        passed[[passed.nrows() - 1, 30]] / run.energy_input.as_ref().unwrap()[passed.nrows() - 1]
    };
    let inside = run("mass_in_mass", &[]);
    let omega = TAU * 0.165;
    let effective = 1.0 + own * w * w / (w * w - omega * omega);
    let fall = (1.0 - 0.5 * omega * omega * effective).acosh();
    let amplitude = |site: usize| {
        let column = inside.velocity.column(site);
        let turn = |t: &f64| Complex::cis(omega * t);
        let each = column.iter().zip(&inside.time);
        each.map(|(v, t)| turn(t) * *v).sum::<Complex<f64>>().norm()
    };
    // Farther on the slow waves of the edges outlast the burst.
    for site in [0, 1] {
        let found = (amplitude(site) / amplitude(site + 1)).ln();
        println!("{site}: {found} {fall}");
        assert!((found / fall - 1.0).abs() < 1e-3, "{site}: {found} {fall}");
    }
    println!(
        "inside: {:e} {:e}",
        peak(&inside, 30) / peak(&inside, 1),
        passed(&inside)
    );
    // What is left is of the burst's own frequencies outside of the gap.
    assert!(peak(&inside, 30) < 0.02 * peak(&inside, 1));
    for frequency in ["0.1", "0.25"] {
        let outside = run(
            "mass_in_mass",
            &[
                ("drive_frequency", frequency),
                ("drive_cycles", "10"),
                ("end_time", "220"),
            ],
        );
        println!(
            "{frequency}: {} {}",
            peak(&outside, 30) / peak(&outside, 1),
            passed(&outside)
        );
        assert!(peak(&outside, 30) > 0.95 * peak(&outside, 1), "{frequency}");
        assert!((passed(&outside) - 1.0).abs() < 1e-3, "{frequency}");
    }
}
