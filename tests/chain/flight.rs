//! Collisions after free flight: bodies that meet late, however few samples ask for a step on the
//! way.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use test_support::changed;
use test_support::fields::{chain, fixed};
use wavecascade::chain::scene::SceneSource;
use wavecascade::chain::{
    Accuracy, Chain, Drive, EndTime, Ends, Law, Run, RunWarning, Scheme, Simulation, Waveform,
};
use wavecascade::observer::Silent;

const SAMPLES: [usize; 6] = [2, 3, 9, 65, 257, 1025];

/// Bodies of these masses on contacts of coefficient 1, each moved back by its gap and those of all
/// bodies behind it, the first one moving at speed 1.
fn apart(mass: &[f64], gaps: &[f64], ends: Ends, end_time: f64) -> Simulation {
    let n = mass.len();
    let chain = chain(
        mass.to_vec(),
        vec![1.0; if ends == Ends::Free { n - 1 } else { n }],
        Law::Hertz,
        ends,
    );
    let mut simulation = Simulation::impact(chain, 1.0, end_time, 2);
    let mut behind = 0.0;
    for (displacement, gap) in simulation.displacement.iter_mut().zip(gaps).rev() {
        behind -= gap;
        *displacement = behind;
    }
    simulation
}

/// Largest error of the last velocities, relative to the scale, over samples and schemes.
fn worst(simulation: &Simulation, expected: &[f64]) -> f64 {
    let mut worst = 0.0f64;
    for scheme in [Scheme::Nystrom, Scheme::RungeKutta] {
        for samples in SAMPLES {
            let simulation = Simulation {
                samples,
                scheme,
                ..simulation.clone()
            };
            let run = simulation.run(&Silent).unwrap();
            let report = &run.report;
            let warnings = &report.warnings;
            assert!(warnings.is_empty(), "{samples}: {warnings:?}");
            // The last digits of positions far from 0 are coarser than those of the motion.
            let flight = simulation
                .displacement
                .iter()
                .fold(0.0, |m: f64, x| m.max(x.abs()));
            let rounding = 1e-12 + 2e-15 * flight;
            assert!(report.energy_drift < Some(4.0 * rounding), "{report:?}");
            let last = run.velocity.row(samples - 1);
            let errors = last.iter().zip(expected).map(|(a, b)| (a - b).abs());
            let error = errors.fold(0.0, f64::max) / report.velocity_scale;
            assert!(
                error <= report.error.unwrap() + rounding,
                "{samples}: {error:e} {report:?}"
            );
            worst = worst.max(error);
        }
    }
    worst
}

/// Equal bodies exchange their velocities; others part as momentum and energy say.
#[test]
fn val_closed_form_two_bodies_meet_late() {
    for (flight, after) in [
        (45.026, 1.786),
        (45.026, 5.0),
        (1e-3, 5.0),
        (0.68, 8.0),
        (3000.0, 7.0),
    ] {
        for heavy in [1.0, 7.0, 0.05] {
            let end = flight + after * if after < 2.0 { 10.0 } else { 1.0 };
            let simulation = apart(&[1.0, heavy], &[flight, 0.0], Ends::Free, end);
            let centre = 1.0 / (1.0 + heavy);
            let worst = worst(&simulation, &[2.0 * centre - 1.0, 2.0 * centre]);
            assert!(worst < 2e-10, "{flight} {heavy}: {worst:e}");
        }
    }
}

/// Halfway through the collision, too: the energy is then in the contact, and the samples agree.
#[test]
fn regress_samples_agree_within_a_late_collision() {
    let simulation = apart(&[1.0, 1.0], &[45.026, 0.0], Ends::Free, 46.812);
    let at_end = |samples| {
        let simulation = changed(simulation.clone(), |it| it.samples = samples);
        simulation
            .run(&Silent)
            .unwrap()
            .velocity
            .row(samples - 1)
            .to_vec()
    };
    let fine = at_end(1025);
    assert!((fine[0] + fine[1] - 1.0).abs() < 1e-13 && fine[1] > 0.1);
    for samples in SAMPLES {
        let off = (at_end(samples)[0] - fine[0]).abs();
        assert!(off < 1e-10, "{samples}: {off:e}");
    }
}

#[test]
fn val_closed_form_a_body_returns_from_a_wall() {
    for flight in [0.1, 45.0, 1e4] {
        let simulation = apart(&[1.0], &[flight], Ends::Wall, 1.5 * flight + 8.0);
        let worst = worst(&simulation, &[-1.0]);
        assert!(worst < 2e-10, "{flight}: {worst:e}");
    }
}

/// With gaps between all balls each hands its velocity on before the next one moves.
#[test]
fn val_closed_form_cradle_with_gaps() {
    let simulation = apart(&[1.0; 5], &[10.0, 20.0, 5.0, 40.0, 0.0], Ends::Free, 110.0);
    let worst = worst(&simulation, &[0.0, 0.0, 0.0, 0.0, 1.0]);
    assert!(worst < 2e-10, "{worst:e}");
}

/// The first of three bodies strikes two that touch, after a flight: velocities of
/// `tests/data/collisions.json`, by double-double arithmetic, of bodies that touch from the start.
#[test]
fn val_double_double_three_bodies_meet_late() {
    let text = std::fs::read_to_string("tests/data/collisions.json").unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let numbers = |case: &serde_json::Value, key: &str| -> Vec<f64> {
        let list = case[key].as_array().unwrap();
        list.iter().map(|v| v.as_f64().unwrap()).collect()
    };
    for case in json["cases"].as_array().unwrap() {
        let mass = numbers(case, "mass");
        let mut simulation = apart(&mass, &[33.3, 0.0, 0.0], Ends::Free, 33.3 + 30.0);
        simulation.chain.coefficient = numbers(case, "coefficient");
        let worst = worst(&simulation, &numbers(case, "velocity"));
        assert!(worst < 2e-9, "{mass:?}: {worst:e}");
    }
}

/// Bodies that part and meet again without gaps at first.
#[test]
fn regress_samples_agree_behind_heavy_strikers() {
    for (sites, striker, end) in [(5, 10.0, 80.0), (9, 7.0, 100.0), (3, 40.0, 200.0)] {
        let mut chain = Chain::dimer(sites, 1.0);
        chain.mass[0] = striker;
        let simulation = Simulation::impact(chain, 1.0, end, 1025);
        let fine = simulation.run(&Silent).unwrap();
        for samples in [2, 9, 65] {
            let simulation = changed(simulation.clone(), |it| it.samples = samples);
            let run = simulation.run(&Silent).unwrap();
            let off = largest_difference(&run, &fine);
            assert!(off < 1e-9, "{sites} {samples}: {off:e}");
            assert!(run.report.warnings.is_empty(), "{sites} {samples}: {off:e}");
        }
    }
}

fn largest_difference(run: &Run, other: &Run) -> f64 {
    let last = |run: &Run| run.velocity.row(run.velocity.nrows() - 1).to_vec();
    let pairs = last(run).into_iter().zip(last(other));
    let most = pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    most / run.report.velocity_scale
}

/// SplitMix64: G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e3779b97f4a7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58476d1ce4e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d049bb133111eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn happens(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }
}

fn random_scene(seed: u64) -> Simulation {
    let mut random = Random(seed);
    let n = random.between(2.0, 9.0) as usize;
    let spread = if random.happens(0.5) {
        random.between(0.0, 1.5)
    } else {
        0.0
    };
    let mass: Vec<f64> = (0..n)
        .map(|_| random.between(-spread, spread).exp())
        .collect();
    let gaps: Vec<f64> = (0..n)
        .map(|_| {
            if random.happens(0.5) {
                random.between(0.0, 12.0)
            } else {
                0.0
            }
        })
        .collect();
    let driven = random.unit();
    let ends = match random.unit() {
        _ if driven < 0.1 => fixed(1.0),
        _ if driven < 0.2 => Ends::Wall,
        u if u < 0.4 => Ends::Free,
        u if u < 0.8 => Ends::Wall,
        _ => fixed(2.0),
    };
    let end_time = random.between(5.0, 60.0);
    let mut simulation = apart(&mass, &gaps, ends, end_time);
    let ratio = random.between(0.0, 2.5).exp();
    for c in simulation.chain.coefficient.iter_mut().step_by(2) {
        *c = ratio;
    }
    if ends != Ends::Free && ends != Ends::Wall {
        // Between two walls the first gap is before the first body.
        simulation
            .displacement
            .iter_mut()
            .for_each(|x| *x += gaps.iter().sum::<f64>());
        simulation.displacement[0] = simulation.displacement[0].max(0.0);
    }
    for v in simulation.velocity.iter_mut().skip(1) {
        if random.happens(0.3) {
            *v = random.between(-0.5, 0.5);
        }
    }
    let frequency = random.between(0.02, 0.4);
    let amplitude = random.between(0.1, 1.0);
    let wave = if random.happens(0.5) {
        Waveform::sine(amplitude, frequency)
    } else {
        Waveform::half_sine(amplitude, 1.0 / frequency)
    };
    if driven < 0.1 {
        simulation.drive = Some(Drive::Wall(wave));
    } else if driven < 0.2 {
        simulation.drive = Some(Drive::Force(wave));
    }
    match random.unit() {
        u if u < 0.1 => simulation.chain.losses.dashpot = random.between(0.01, 0.3),
        u if u < 0.2 => simulation.chain.losses.tangent = random.between(0.01, 0.3),
        u if u < 0.3 => simulation.chain.losses.drag = random.between(0.001, 0.05),
        u if u < 0.4 => {
            simulation.chain.law = Law::Power {
                exponent: random.between(1.2, 3.0),
            }
            .into()
        }
        _ => {}
    }
    if simulation.chain.losses.any() || random.happens(0.2) {
        simulation.scheme = Scheme::RungeKutta;
    }
    simulation
}

const SCENES: u64 = 1000;

/// A thousand random scenes of gaps, masses, spreads, laws, losses and drives: whatever the samples,
/// the last velocities agree to the errors stated, which are within the tolerance or warned of.
#[test]
fn regress_random_scenes_agree_at_all_samples() {
    let warned = AtomicU64::new(0);
    let failures: Vec<String> = (0..SCENES)
        .into_par_iter()
        .filter_map(|seed| {
            let simulation = random_scene(seed);
            let runs: Vec<Run> = [2, 9, 65, 1025]
                .into_iter()
                .map(|samples| {
                    let simulation = changed(simulation.clone(), |it| it.samples = samples);
                    simulation
                        .run(&Silent)
                        .unwrap_or_else(|e| panic!("{seed}: {e}"))
                })
                .collect();
            let is_warned = runs.iter().any(|run| !run.report.warnings.is_empty());
            warned.fetch_add(u64::from(is_warned), Ordering::Relaxed);
            let off = runs.iter().map(|run| largest_difference(run, &runs[3]));
            let off = off.fold(0.0, f64::max);
            (off > 2e-9 && !is_warned).then(|| format!("{seed}: {off:e}"))
        })
        .collect();
    assert!(failures.is_empty(), "{failures:#?}");
    let warned = warned.into_inner();
    assert!(warned < SCENES / 8, "{warned} of {SCENES} warned");
}

/// Steps that nobody checks, too long for the collisions in them.
#[test]
fn val_conservation_long_fixed_steps_are_warned_of() {
    let mut simulation = apart(&[1.0, 1.0], &[5.3, 0.0], Ends::Free, 12.0);
    simulation.scheme = Scheme::VelocityVerlet;
    simulation.end_time = EndTime::At(12.0);
    for (step, warns) in [(1.5, true), (0.01, false)] {
        simulation.accuracy = Accuracy::Step(step);
        let run = simulation.run(&Silent).unwrap();
        let found = matches!(run.report.warnings[..], [RunWarning::EnergyBalance { .. }]);
        assert_eq!(found, warns, "{step}: {:?}", run.report);
    }
}

/// Runs whose steps the start or the samples limit, not the tolerance: what is stated is not by how little two runs of the same
/// steps differ.
#[test]
fn regress_short_runs_at_coarse_tolerances_have_the_stated_error() {
    for (scene, samples, end) in [
        (
            "sites = 4\nstiffness_ratio = 2.0\nprecompression = 0.1",
            11,
            2.0,
        ),
        ("sites = 4\nstiffness_ratio = 2.0", 101, 10.0),
        (
            "sites = 8\nlaw = 'power'\nexponent = 2.5\nprecompression = 0.1",
            2,
            2.0,
        ),
        (
            "sites = 6\nstiffness_ratio = 2.0\nlaw = 'power'\nexponent = 2.5",
            101,
            10.0,
        ),
        ("sites = 4\nlaw = 'spring'", 3, 5.0),
        (
            "sites = 6\nstiffness_ratio = 4.9\nlaw = 'spring'\nalpha = 0.25",
            3,
            10.0,
        ),
    ] {
        let run = |tolerance: f64| {
            let more = format!("samples = {samples}\nend_time = {end:?}\ntolerance = {tolerance}");
            let scene = format!("{scene}\nends = 'periodic'\n{more}");
            let setup = SceneSource::new(None, &scene).setup().unwrap();
            setup.simulation.run(&Silent).unwrap()
        };
        let fine = run(1e-11);
        for tolerance in [1e-3, 1e-2, 1e-1] {
            let coarse = run(tolerance);
            let pairs = coarse.velocity.iter().zip(&fine.velocity);
            let off = pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
            let scale = coarse.report.velocity_scale;
            let stated = scale * (coarse.report.error.unwrap() + fine.report.error.unwrap());
            assert!(off <= stated, "{scene} {tolerance}: {off:e} {stated:e}");
            assert!(
                stated <= scale * (tolerance + 1e-11),
                "{scene} {tolerance}: {stated:e}"
            );
        }
    }
}
