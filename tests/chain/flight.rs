//! Collisions after free flight: bodies that meet late, whatever the samples.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use test_support::fields::{chain, fixed};
use test_support::measured::Normal;
use test_support::scenes::{apart, last, run, simulation, within};
use wavecascade::chain::{Drive, Ends, Law, Run, RunWarning, Scheme, Simulation, Waveform};
use wavecascade::observer::Silent;

/// The same motion at other counts of samples; how far the last velocities are from those of the last run, of the largest speed.
fn sampled(mut it: Simulation, samples: [usize; 4]) -> (f64, Vec<Run>) {
    let runs = samples.map(|samples| {
        it.samples = samples;
        it.run(&Silent)
            .unwrap_or_else(|error| panic!("{it:?}: {error}"))
    });
    let off = runs.iter().map(|run| apart(last(run), last(&runs[3])));
    let off = off.fold(0.0, f64::max) / runs[3].report.velocity_scale;
    (off, runs.into())
}

/// Bodies that part and meet again without gaps at first; and halfway through a late collision, where the energy is in the contact.
#[test]
fn regress_samples_agree_behind_heavy_strikers() {
    for keys in [
        "sites = 5\nstriker_mass = 10\nend_time = 80",
        "sites = 9\nstriker_mass = 7\nend_time = 100",
        "sites = 3\nstriker_mass = 40\nend_time = 200",
        "sites = 2\nends = 'free'\ndisplacements = [-45.026, 0]\nstriker_velocity = 1\nend_time = 46.812",
    ] {
        let (off, runs) = sampled(simulation(keys), [2, 9, 65, 1025]);
        assert!(off < 1e-9, "{keys}: {off:e}");
        let warned = runs.iter().any(|run| !run.report.warnings.is_empty());
        assert!(!warned, "{keys}");
        assert!(last(&runs[3])[1].abs() > 0.1, "{keys}");
    }
}

fn random_scene(seed: u64) -> Simulation {
    let mut random = Normal(seed);
    let n = random.between(2.0, 9.0) as usize;
    let sometimes = |random: &mut Normal, least: f64, most: f64| match random.uniform() < 0.5 {
        true => random.between(least, most),
        false => 0.0,
    };
    let spread = sometimes(&mut random, 0.0, 1.5);
    let mass = (0..n)
        .map(|_| random.between(-spread, spread).exp())
        .collect();
    let gaps = Vec::from_iter((0..n).map(|_| sometimes(&mut random, 0.0, 12.0)));
    let driven = random.uniform();
    let ends = match random.uniform() {
        _ if driven < 0.1 => fixed(1.0),
        _ if driven < 0.2 => Ends::Wall,
        u if u < 0.4 => Ends::Free,
        u if u < 0.8 => Ends::Wall,
        _ => fixed(2.0),
    };
    let contacts = if ends == Ends::Free { n - 1 } else { n };
    let (end_time, ratio) = (random.between(5.0, 60.0), random.between(0.0, 2.5).exp());
    let coefficient = (0..contacts).map(|j| if j % 2 == 0 { ratio } else { 1.0 });
    let chain = chain(mass, coefficient.collect(), Law::Hertz, ends);
    let mut it = Simulation::impact(chain, 1.0, end_time, 2);
    // Each is moved back by its gap and those of all bodies behind it; between two walls the first gap is before the first body.
    let whole = match ends {
        Ends::Fixed { .. } => gaps.iter().sum(),
        _ => 0.0,
    };
    for j in 0..n {
        it.displacement[j] = whole - gaps[j..].iter().sum::<f64>();
        if j > 0 && random.uniform() < 0.3 {
            it.velocity[j] = random.between(-0.5, 0.5);
        }
    }
    let (frequency, amplitude) = (random.between(0.02, 0.4), random.between(0.1, 1.0));
    let wave = match random.uniform() < 0.5 {
        true => Waveform::sine(amplitude, frequency),
        false => Waveform::half_sine(amplitude, 1.0 / frequency),
    };
    it.drive = match driven {
        u if u < 0.1 => Some(Drive::Wall(wave)),
        u if u < 0.2 => Some(Drive::Force(wave)),
        _ => None,
    };
    let losses = &mut it.chain.losses;
    match random.uniform() {
        u if u < 0.1 => losses.dashpot = random.between(0.01, 0.3),
        u if u < 0.2 => losses.tangent = random.between(0.01, 0.3),
        u if u < 0.3 => losses.drag = random.between(0.001, 0.05),
        u if u < 0.4 => {
            let exponent = random.between(1.2, 3.0);
            it.chain.law = Law::Power { exponent }.into();
        }
        _ => {}
    }
    if it.chain.losses.any() || random.uniform() < 0.2 {
        it.scheme = Scheme::RungeKutta;
    }
    it
}

const SCENES: u64 = 1000;

/// A thousand random scenes of gaps, masses, spreads, laws, losses and drives: whatever the samples,
/// the last velocities agree to the errors stated, which are within the tolerance or warned of.
#[test]
fn regress_random_scenes_agree_at_all_samples() {
    let warned = AtomicU64::new(0);
    let seeds = (0..SCENES).into_par_iter();
    let failures = seeds.filter_map(|seed| {
        let (off, runs) = sampled(random_scene(seed), [2, 9, 65, 1025]);
        let is_warned = runs.iter().any(|run| !run.report.warnings.is_empty());
        warned.fetch_add(u64::from(is_warned), Ordering::Relaxed);
        (off > 2e-9 && !is_warned).then(|| format!("{seed}: {off:e}"))
    });
    let failures: Vec<String> = failures.collect();
    assert!(failures.is_empty(), "{failures:#?}");
    let warned = warned.into_inner();
    assert!(warned < SCENES / 8, "{warned} of {SCENES} warned");
}

/// Steps that nobody checks, too long for the collisions in them.
#[test]
fn val_conservation_long_fixed_steps_are_warned_of() {
    for (step, warns) in [(1.5, true), (0.01, false)] {
        let report = run(&format!(
            "sites = 2\nends = 'free'\ndisplacements = [-5.3, 0]\nstriker_velocity = 1\nend_time = 12\nsamples = 2\n\
             scheme = 'velocity-verlet'\nstep = {step}"
        ))
        .report;
        let found = matches!(report.warnings[..], [RunWarning::EnergyBalance { .. }]);
        assert_eq!(found, warns, "{step}: {report:?}");
    }
}

/// Runs whose steps the start or the samples limit, not the tolerance: what is stated is not by how little two runs of the same
/// steps differ.
#[test]
fn regress_short_runs_at_coarse_tolerances_have_the_stated_error() {
    for keys in [
        "samples = 11\nend_time = 2.0\nsites = 4\nstiffness_ratio = 2.0\nprecompression = 0.1",
        "samples = 101\nend_time = 10.0\nsites = 4\nstiffness_ratio = 2.0",
        "samples = 2\nend_time = 2.0\nsites = 8\nlaw = 'power'\nexponent = 2.5\nprecompression = 0.1",
        "samples = 101\nend_time = 10.0\nsites = 6\nstiffness_ratio = 2.0\nlaw = 'power'\nexponent = 2.5",
        "samples = 3\nend_time = 5.0\nsites = 4\nlaw = 'spring'",
        "samples = 3\nend_time = 10.0\nsites = 6\nstiffness_ratio = 4.9\nlaw = 'spring'\nalpha = 0.25",
    ] {
        let run = |tolerance: f64| {
            run(&format!(
                "ends = 'periodic'\ntolerance = {tolerance}\n{keys}"
            ))
        };
        let fine = run(1e-11);
        for tolerance in [1e-3, 1e-2, 1e-1] {
            let coarse = run(tolerance);
            let off = apart(&coarse.velocity, &fine.velocity) / coarse.report.velocity_scale;
            let stated = coarse.report.error.unwrap() + fine.report.error.unwrap();
            assert!(off <= stated, "{keys} {tolerance}: {off:e} {stated:e}");
            within(stated, ..=tolerance + 1e-11, keys);
        }
    }
}
