//! What six of the shipped scenes show, beside the theory that each reproduces.
//!
//! Equation: `m x_j'' = F(x_{j-1} - x_j) - F(x_j - x_{j+1})` under the law of each scene.
//! Command: `cargo run --release -p figures --bin presets`; 3 s of processor time.
//! Shows: Toda's soliton at three times on its closed form; the speed of solitary waves in sonic vacuum, the sixth root of their
//! force; the energies of the first modes of the alpha chain, which come back; the gap of two masses in the spectrum of a struck
//! chain; the frequencies at the edges of a gap that opens with the amplitude, on those of Duffing's oscillator; the contacts of a
//! bistable chain that an impact leaves in their second wells.
//! Asserts: each against its theory, to the figures below.
//! Differs: the paper has no such figure.

use std::f64::consts::{PI, TAU};

use figures::{Outcome, Panel, save_as};
use ndarray::ArrayView1;
use wavecascade::chain::scene::{SceneSource, Setting, preset};
use wavecascade::chain::{Run, Simulation};
use wavecascade::observer::Silent;
use wavecascade::plot::{Look, Mark};

/// The panel of the gap, and the edges of the gap in theory: `(2/3)^{1/2}` and `2^{1/2}`.
const GAP: usize = 3;
const EDGES: [f64; 2] = [0.816_496_580_927_726, std::f64::consts::SQRT_2];

fn simulation(name: &str, keys: &[(&str, &str)]) -> Outcome<Simulation> {
    let preset = preset(name).ok_or("a preset of this name")?;
    let settings = keys
        .iter()
        .map(|(key, text)| Setting::new(key, *text, *key));
    let scene = SceneSource::new(None, preset.text).with(settings);
    Ok(scene.setup()?.simulation)
}

fn run(name: &str, keys: &[(&str, &str)]) -> Outcome<Run> {
    Ok(simulation(name, keys)?.run(&Silent)?)
}

fn toda() -> Outcome<Panel> {
    let run = run("toda_soliton", &[])?;
    let theory = |x: f64, t: f64| {
        let theta = x - 12.0 - t * 1f64.sinh();
        1f64.sinh() * ((theta + 1.0).tanh() - theta.tanh())
    };
    let (mut found, mut closed) = (Vec::new(), Vec::new());
    for sample in [0, 512, 1023] {
        let t = run.time[sample];
        for (j, v) in run.velocity.row(sample).iter().enumerate() {
            assert!((v - theory(j as f64, t)).abs() < 2e-9);
            found.push((j as f64, *v));
        }
        closed.extend((0..471).map(|i| (0.1 * f64::from(i), theory(0.1 * f64::from(i), t))));
        for points in [&mut found, &mut closed] {
            points.push((f64::NAN, f64::NAN));
        }
    }
    Ok(Panel {
        title: "Toda's soliton at three times".into(),
        x_label: "site",
        y_label: "velocity",
        x: 0.0..47.0,
        y: 0.0..1.4,
        curves: vec![("closed form", closed), ("run", found)],
    })
}

fn vacuum() -> Outcome<Panel> {
    let mut found = Vec::new();
    for speed in ["0.03", "0.1", "0.3", "1", "3"] {
        let end = 130.0 / speed.parse::<f64>()?.powf(0.2);
        let run = run(
            "sonic_vacuum",
            &[("striker_velocity", speed), ("end_time", &end.to_string())],
        )?;
        let force = run.force.as_ref().ok_or("forces")?;
        let peak = |contact: usize| {
            let column = force.column(contact);
            let most = (0..column.len()).max_by(|a, b| column[*a].total_cmp(&column[*b]));
            most.map_or((0.0, 0.0), |at| (run.time[at], column[at]))
        };
        let ((before, force), (after, _)) = (peak(60), peak(90));
        found.push((force.log10(), (30.0 / (after - before)).log10()));
    }
    let (x, y) = found[2];
    let line: Vec<(f64, f64)> = found
        .iter()
        .map(|(at, _)| (*at, y + (at - x) / 6.0))
        .collect();
    for ((_, found), (_, line)) in found.iter().zip(&line) {
        assert!((found - line).abs() < 1e-3, "{found} {line}");
    }
    Ok(Panel {
        title: "sonic vacuum: speed against force".into(),
        x_label: "log10 of the largest force",
        y_label: "log10 of the speed",
        x: -2.2..0.6,
        y: -0.45..0.15,
        curves: vec![("slope 1/6", line), ("runs", found)],
    })
}

fn fput() -> Outcome<Panel> {
    let run = run("fput", &[("end_time", "12500"), ("tolerance", "1e-6")])?;
    let x = run.displacement.as_ref().ok_or("displacements")?;
    let energies = |mode: usize| -> Vec<(f64, f64)> {
        let q = PI * mode as f64 / 33.0;
        let omega = 2.0 * (0.5 * q).sin();
        let shape: Vec<f64> = (1..=32).map(|j| (q * f64::from(j)).sin()).collect();
        let of = |row: ArrayView1<f64>| -> f64 { row.iter().zip(&shape).map(|(a, b)| a * b).sum() };
        let energy = |i: usize| {
            let (v, x) = (of(run.velocity.row(i)), of(x.row(i)));
            (v * v + omega * omega * x * x) / 33.0
        };
        (0..run.time.len())
            .step_by(4)
            .map(|i| (run.time[i], energy(i)))
            .collect()
    };
    let curves: Vec<_> = ["mode 1", "mode 2", "mode 3", "mode 4"]
        .into_iter()
        .enumerate()
        .map(|(i, name)| (name, energies(i + 1)))
        .collect();
    let first = &curves[0].1;
    let back = first
        .iter()
        .filter(|(t, _)| *t > 9000.0)
        .fold(0.0, |a: f64, (_, e)| a.max(*e));
    assert!((back / first[0].1 - 0.98).abs() < 0.005);
    Ok(Panel {
        title: "FPUT: the first mode comes back".into(),
        x_label: "time",
        y_label: "energy of a mode",
        x: 0.0..13000.0,
        y: 0.0..1.1 * first[0].1,
        curves,
    })
}

fn gap() -> Outcome<Panel> {
    let run = run("diatomic", &[])?;
    let (n, step) = (run.time.len(), run.time[1]);
    let spectrum = (1..150).map(|bin| {
        let energies = (16..40).map(|site| {
            let (mut re, mut im) = (0.0, 0.0);
            for (i, v) in run.velocity.column(site).iter().enumerate() {
                let window = 0.5 - 0.5 * (TAU * i as f64 / n as f64).cos();
                let (sin, cos) = (TAU * (bin * i % n) as f64 / n as f64).sin_cos();
                (re, im) = (re + window * v * cos, im + window * v * sin);
            }
            re * re + im * im
        });
        (TAU * bin as f64 / (n as f64 * step), energies.sum::<f64>())
    });
    let spectrum: Vec<(f64, f64)> = spectrum.collect();
    let most = spectrum.iter().fold(0.0, |a: f64, b| a.max(b.1));
    let decades: Vec<_> = spectrum
        .iter()
        .map(|(w, e)| (*w, (e / most).log10().max(-6.0)))
        .collect();
    let inside = decades.iter().filter(|(w, _)| (0.9..1.33).contains(w));
    assert!(inside.fold(f64::NEG_INFINITY, |a, b| a.max(b.1)) < -3.0);
    Ok(Panel {
        title: "masses 1 and 3: a gap between the marks".into(),
        x_label: "angular frequency",
        y_label: "log10 of the energy / largest",
        x: 0.0..2.2,
        y: -6.0..0.5,
        curves: vec![("", decades)],
    })
}

fn alternating() -> Outcome<Panel> {
    let duffing = |amplitude: f64, b: f64| {
        let stiffness = 2.0 * (1.0 + b * amplitude * amplitude);
        let m = b * amplitude * amplitude / stiffness;
        let (mut a, mut g) = (1.0f64, (1.0 - m).sqrt());
        for _ in 0..8 {
            (a, g) = (0.5 * (a + g), (a * g).sqrt());
        }
        stiffness.sqrt() * a
    };
    let edge = simulation("alternating", &[])?;
    let (mut curves, mut all) = (Vec::new(), Vec::new());
    for (name, shift, b) in [
        ("softening, theory", 0, -0.1),
        ("hardening, theory", 1, 0.1),
    ] {
        let theory = (0..=60)
            .map(|i| 0.03 * f64::from(i))
            .map(|a| (a, duffing(a, b)));
        curves.push((name, theory.collect()));
        for step in 1..=6 {
            let amplitude = 0.3 * f64::from(step);
            let mut at = edge.clone();
            at.displacement = (0..32)
                .map(|j| amplitude * edge.displacement[(j + shift) % 32])
                .collect();
            let run = at.run(&Silent)?;
            let x = run
                .displacement
                .as_ref()
                .ok_or("displacements")?
                .column(1)
                .to_owned();
            let rises: Vec<f64> = (1..x.len())
                .filter(|&i| x[i - 1] < 0.0 && x[i] >= 0.0)
                .map(|i| run.time[i - 1] + run.time[1] * x[i - 1] / (x[i - 1] - x[i]))
                .collect();
            let found = TAU * (rises.len() - 1) as f64 / (rises[rises.len() - 1] - rises[0]);
            assert!((found / duffing(amplitude, b) - 1.0).abs() < 2e-5);
            all.push((amplitude, found));
        }
        all.push((f64::NAN, f64::NAN));
    }
    curves.push(("runs", all));
    Ok(Panel {
        title: "alternate softening, hardening: a gap opens".into(),
        x_label: "largest overlap",
        y_label: "angular frequency",
        x: 0.0..1.85,
        y: 1.1..1.75,
        curves,
    })
}

fn bistable() -> Outcome<Panel> {
    let run = run("bistable", &[])?;
    let x = run.displacement.as_ref().ok_or("displacements")?;
    let overlap = |i: usize, j: usize| x[[i, j]] - if j < 15 { x[[i, j + 1]] } else { 0.0 };
    let last = run.time.len() - 1;
    let names = [
        "contact 0",
        "contact 1",
        "contact 2",
        "contact 3",
        "contact 4",
    ];
    for j in 0..16 {
        let rest = overlap(last, j);
        assert!(rest.abs() < 1e-5 || (rest - 3.0).abs() < 1e-5);
    }
    let until = run.time.iter().filter(|t| **t < 60.0).count();
    let curve = |j: usize| (0..until).map(|i| (run.time[i], overlap(i, j))).collect();
    Ok(Panel {
        title: "bistable contacts, some of which snap".into(),
        x_label: "time",
        y_label: "overlap",
        x: 0.0..60.0,
        y: -1.5..6.0,
        curves: names
            .into_iter()
            .enumerate()
            .map(|(j, name)| (name, curve(j)))
            .collect(),
    })
}

fn main() -> Outcome<()> {
    let panels = [
        toda()?,
        vacuum()?,
        fput()?,
        gap()?,
        alternating()?,
        bistable()?,
    ];
    save_as("presets", 2, &panels, |i, mut chart| {
        for series in &mut chart.series {
            if series.label.starts_with("run") {
                series.look = Look::Dots;
            }
        }
        if i == GAP {
            let edge = |at: f64, label: &str| Mark {
                at,
                label: label.into(),
            };
            chart.marks = vec![edge(EDGES[0], "0.816"), edge(EDGES[1], "1.414")];
        }
        chart
    })
}
