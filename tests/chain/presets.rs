//! Scenes that come with the program against the published results that they show.

use std::f64::consts::{PI, TAU};

use ndarray::ArrayView1;
use num_complex::Complex;
use test_support::changed;
use test_support::scenes::{apart, data, largest, near, within};
use wavecascade::chain::scene::{PRESETS, SceneSource, Setting, preset};
use wavecascade::chain::{Run, Simulation, UnitCell};
use wavecascade::observer::Silent;

fn simulation(name: &str, settings: &[(&str, &str)]) -> Simulation {
    let scene = SceneSource::new(None, preset(name).unwrap().text);
    let settings = settings.iter();
    let settings = settings.map(|(key, text)| Setting::new(key, *text, "a test"));
    scene.with(settings).setup().unwrap().simulation
}

fn run(name: &str, settings: &[(&str, &str)]) -> Run {
    simulation(name, settings).run(&Silent).unwrap()
}

/// Where the largest value is.
fn place(values: ArrayView1<f64>) -> usize {
    let places = 0..values.len();
    places
        .max_by(|a, b| values[*a].total_cmp(&values[*b]))
        .unwrap()
}

/// The frequency at which a signal that swings about 0 passes it upwards, from the first pass to the last.
fn frequency(run: &Run, signal: ArrayView1<f64>) -> f64 {
    let rises = (1..signal.len()).filter(|&i| signal[i - 1] < 0.0 && signal[i] >= 0.0);
    let at = rises.map(|i| {
        let share = signal[i - 1] / (signal[i - 1] - signal[i]);
        run.time[i - 1] + share * (run.time[i] - run.time[i - 1])
    });
    let at: Vec<f64> = at.collect();
    (at.len() - 1) as f64 / (at[at.len() - 1] - at[0])
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
    let known = |(i, j): (usize, usize)| {
        let theta = k * (j as f64 - 12.0) - run.time[i] * k.sinh();
        k.sinh() * ((theta + k).tanh() - theta.tanh())
    };
    let known = ndarray::Array2::from_shape_fn(run.velocity.dim(), known);
    assert!(apart(&run.velocity, &known) < 1e-10);
}

/// A wave of the speed c presses with `c^6 psi^{3/2}`, psi the largest overlap of that of speed 1 (`data/solitary_wave.json`).
#[test]
fn val_published_the_speed_in_sonic_vacuum_is_the_sixth_root_of_the_force() {
    let overlap = data("solitary_wave.json")["largest_overlap"]
        .as_f64()
        .unwrap();
    for (speed, end) in [("0.1", "190"), ("1", "120")] {
        let run = run(
            "sonic_vacuum",
            &[("striker_velocity", speed), ("end_time", end)],
        );
        let force = run.force.as_ref().unwrap();
        // Where a contact presses most, by a parabola through three samples.
        let peak = |contact: usize| {
            let column = force.column(contact);
            let at = place(column);
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
    }
}

/// No wave between `(2c/m)^{1/2}` of the heavy and of the light mass: far from the blow less than a thousandth of the energy.
#[test]
fn val_theory_the_gap_of_two_masses() {
    let simulation = simulation("diatomic", &[]);
    let edges = UnitCell::of(&simulation.chain)
        .unwrap()
        .frequencies(PI / 2.0);
    assert!(apart(edges, [(2.0f64 / 3.0).sqrt(), 2f64.sqrt()]) < 1e-12);
    let run = simulation.run(&Silent).unwrap();
    let (n, step) = (run.time.len(), run.time[1]);
    let angle = |i: usize| TAU * (i % n) as f64 / n as f64;
    let (mut inside, mut whole) = (0.0, 0.0);
    for (site, bin) in (16..40).flat_map(|site| (1..150).map(move |bin| (site, bin))) {
        let terms = run.velocity.column(site).into_iter().enumerate();
        let terms =
            terms.map(|(i, v)| Complex::cis(angle(bin * i)) * v * (0.5 - 0.5 * angle(i).cos()));
        let energy = terms.sum::<Complex<f64>>().norm_sqr();
        whole += energy;
        if (0.9..1.33).contains(&(TAU * bin as f64 / (n as f64 * step))) {
            inside += energy;
        }
    }
    assert!(inside / whole < 1e-3, "{}", inside / whole);
}

/// Part of a shape of sites that the k-th of n modes between walls has.
fn part(row: ArrayView1<f64>, k: f64) -> f64 {
    let q = PI * k / (row.len() + 1) as f64;
    let terms = row.iter().enumerate();
    terms.map(|(j, v)| v * (q * (j + 1) as f64).sin()).sum()
}

/// The energy of the first mode of the alpha chain comes back: DOP853 of SciPy 1.17 (relative tolerance 1e-10, these samples) has
/// 0.9807124 of it after 153.4272 of its periods, and 0.0856380 at least.
#[test]
fn val_scipy_the_alpha_chain_recurs() {
    let run = run("fput", &[("end_time", "12500"), ("tolerance", "1e-6")]);
    let x = run.displacement.as_ref().unwrap();
    let omega = 2.0 * (PI / 66.0).sin();
    let energy = (0..run.time.len())
        .map(|i| part(run.velocity.row(i), 1.0).powi(2) + (omega * part(x.row(i), 1.0)).powi(2));
    let energy = ndarray::Array1::from_iter(energy);
    let least = energy.iter().fold(f64::INFINITY, |a, b| a.min(*b)) / energy[0];
    let mut times = run.time.iter();
    let from = times.position(|t| *t * omega / TAU > 120.0).unwrap();
    let back = from + place(energy.slice(ndarray::s![from..]));
    let periods = run.time[back] * omega / TAU;
    assert!((periods - 153.427_2).abs() < 1e-4, "{periods}");
    let found = [least, energy[back] / energy[0]];
    assert!(apart(found, [0.085_638, 0.980_712_4]) < 2e-6, "{found:?}");
}

/// Modes of the beta chain that are even about its middle stay without energy.
#[test]
fn val_symmetry_the_beta_chain_keeps_to_odd_modes() {
    let run = run("fput_beta", &[("end_time", "1000")]);
    let mirrored = run.velocity.slice(ndarray::s![.., ..;-1]);
    assert!(apart(&run.velocity, mirrored) < 1e-8);
    // Energy does leave the first mode.
    let row = run.velocity.row(run.time.len() - 1);
    assert!(part(row, 3.0).abs() > 1e-3 * part(row, 1.0).abs());
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
    for (shift, b) in [(0, -0.1), (1, 0.1)] {
        for amplitude in [0.01, 0.5, 1.0] {
            let shape = (0..32).map(|j| amplitude * simulation.displacement[(j + shift) % 32]);
            let edge = changed(simulation.clone(), |it| it.displacement = shape.collect());
            let run = edge.run(&Silent).unwrap();
            let x = run.displacement.as_ref().unwrap();
            // 0, 1 | 2, 3: the pair of sites 0 and 1, or 1 and 2, moves as one.
            let strained = [x[[0, 0]] - x[[0, 1]], x[[0, 1]] - x[[0, 2]]];
            let soft = strained[0].abs() > strained[1].abs();
            assert_eq!(soft, b < 0.0, "{strained:?}");
            let (found, expected) = (frequency(&run, x.column(1)), duffing(amplitude, b));
            near(found / expected, 1.0, 2e-5, (amplitude, b));
        }
    }
}

/// After the impact each contact rests in one of its wells, 0 and 3, and those at 3 keep 0.45 each: `V(3) = 27 k / 12`, k = 0.2.
#[test]
fn val_energy_bistable_contacts_keep_energy() {
    let run = run("bistable", &[]);
    let end = run.time.len() - 1;
    let last = run.displacement.as_ref().unwrap().row(end).to_vec();
    let overlap = |j: usize| last[j] - last.get(j + 1).copied().unwrap_or(0.0);
    let near = |well: f64| {
        (0..16)
            .filter(|j| (overlap(*j) - well).abs() < 1e-5)
            .count()
    };
    let (full, empty) = (near(3.0), near(0.0));
    assert!(full + empty == 16 && full > 0, "{full} {empty}");
    let kept = 0.5 * 16.0 - run.energy_lost.as_ref().unwrap().row(end).sum();
    assert!((kept - 0.45 * full as f64).abs() < 1e-6, "{kept} {full}");
}

/// The peak force of the pulse falls behind random masses, and the more the more they differ.
#[test]
fn val_published_a_pulse_decays_in_disorder() {
    let found = ["0", "0.2", "0.5"].map(|spread| {
        let run = run(
            "disordered",
            &[("mass_spread", spread), ("tolerance", "1e-6")],
        );
        let force = run.force.as_ref().unwrap();
        largest(force.column(100)) / largest(force.column(10))
    });
    near(found[0], 1.0, 0.02, found);
    within(found[1] / found[0], ..0.9, found);
    within(found[2] / found[1], ..0.5, found);
}

/// The gap at the resonance w: `w (1 + m_r/m)^{1/2}` is its upper edge, the top of the lower branch its lower one. In it a wave falls by
/// `exp(-kappa)` a body, `2 - 2 cosh kappa = omega^2 (1 + m_r w^2 / (w^2 - omega^2))`; below and above it passes.
#[test]
fn val_published_the_resonance_opens_a_gap() {
    let (own, w) = (0.5f64, TAU * 0.15);
    let cell = UnitCell::of(&simulation("mass_in_mass", &[]).chain).unwrap();
    let sum = w * w * (1.0 + own) + 4.0;
    let lower = (0.5 * (sum - (sum * sum - 16.0 * w * w).sqrt())).sqrt();
    let edges = [cell.frequencies(PI)[0], cell.frequencies(0.0)[1]];
    assert!(apart(edges, [lower, w * (1.0 + own).sqrt()]) < 1e-13);
    // The share of the velocity that reaches body 30, and of the energy.
    let passed = |run: &Run| {
        let [far, near] = [30, 1].map(|site| largest(run.velocity.column(site)));
        let end = run.time.len() - 1;
        let energy = run.energy_passed.as_ref().unwrap()[[end, 30]];
        (far / near, energy / run.energy_input.as_ref().unwrap()[end])
    };
    let inside = run("mass_in_mass", &[]);
    let omega = TAU * 0.165;
    let effective = 1.0 + own * w * w / (w * w - omega * omega);
    let fall = (1.0 - 0.5 * omega * omega * effective).acosh();
    let amplitude = |site: usize| {
        let each = inside.velocity.column(site).into_iter().zip(&inside.time);
        each.map(|(v, t)| Complex::cis(omega * t) * v)
            .sum::<Complex<f64>>()
            .norm()
    };
    // Farther on the slow waves of the edges outlast the burst.
    for site in [0, 1] {
        let found = (amplitude(site) / amplitude(site + 1)).ln();
        assert!((found / fall - 1.0).abs() < 1e-3, "{site}: {found} {fall}");
    }
    // What is left is of the burst's own frequencies outside of the gap.
    assert!(passed(&inside).0 < 0.02);
    for frequency in ["0.1", "0.25"] {
        let burst = [
            ("drive_frequency", frequency),
            ("drive_cycles", "10"),
            ("end_time", "220"),
        ];
        let (velocity, energy) = passed(&run("mass_in_mass", &burst));
        within(velocity, 0.95.., frequency);
        near(energy, 1.0, 1e-3, frequency);
    }
}
