//! Sweeps: the same table from any order of work, however often it is interrupted.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use test_support::contains_all;
use test_support::scenes::{apart, largest, near, within};
use wavecascade::Error;
use wavecascade::attenuation::{Sense, pulses};
use wavecascade::chain::scene::SceneSource;
use wavecascade::observer::{Observer, Silent};
use wavecascade::sheet::Describe;
use wavecascade::sweep::{ENSEMBLES, Outcome, Part, Standing, Sweep, Swept, TABLE, read};

const SCENE: &str = "sites = 12\nend_time = 20.0\nsamples = 240\ntolerance = 1e-7\n";
const VARY: [&str; 2] = ["stiffness_ratio=1:20:6log", "striker_velocity=0.5,1,2"];

fn sweep(scene: &str, vary: &[&str]) -> Sweep {
    let vary: Vec<String> = vary.iter().map(|&v| v.to_owned()).collect();
    Sweep::new(SceneSource::new(None, scene), &vary).unwrap()
}

/// A folder for a sweep, and what is in it.
struct Out(tempfile::TempDir);

impl Out {
    fn new() -> Out {
        Out(tempfile::tempdir().unwrap())
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Part k of n of a sweep into a folder of its own.
    fn run(&self, name: &str, sweep: &Sweep, [k, n]: [usize; 2]) -> Standing {
        let part = Part::new(k, n).unwrap();
        sweep.run(&self.at(name), part, &Silent).unwrap()
    }

    /// The table of the sweep of [`VARY`], all of it computed.
    fn whole(&self, name: &str) -> String {
        let standing = self.run(name, &sweep(SCENE, &VARY), [1, 1]);
        assert_eq!(
            (standing.members, standing.computed, standing.failed),
            (18, 18, 0)
        );
        self.table(name)
    }

    fn table(&self, name: &str) -> String {
        std::fs::read_to_string(self.at(name).join(TABLE)).unwrap()
    }
}

/// Asks to stop after so many members.
struct Impatient(AtomicU64);

impl Observer for Impatient {
    fn advance(&self, units: u64) {
        self.0
            .fetch_sub(units.min(self.0.load(Ordering::SeqCst)), Ordering::SeqCst);
    }

    fn cancelled(&self) -> bool {
        self.0.load(Ordering::SeqCst) == 0
    }
}

/// Peaks scale as `v^{6/5}` with the impact's speed in a Hertz chain, energies as `v^2`.
#[test]
fn val_scaling_of_peaks_and_energies() {
    let all = Out::new().whole("sweep");
    let mut rows = csv::Reader::from_reader(all.as_bytes());
    let columns = rows.headers().unwrap().clone();
    let column = |name: &str| columns.iter().position(|c| c == name).unwrap();
    assert_eq!(&columns[0], "stiffness_ratio");
    let rows = rows.records().map(|row| {
        let row = row.unwrap();
        row.iter().map(|v| v.parse().unwrap_or(f64::NAN)).collect()
    });
    let rows: Vec<Vec<f64>> = rows.collect();
    assert_eq!(rows.len(), 18);
    for rows in rows.chunks(3) {
        let of = |name: &str| Vec::from_iter(rows.iter().map(|row| row[column(name)]));
        let v = of("striker_velocity");
        assert_eq!(
            of("energy_input"),
            Vec::from_iter(v.iter().map(|v| 0.5 * v * v))
        );
        assert!(largest(of("energy_drift")) < 1e-8, "{rows:?}");
        let peaks = of("peak_force_first");
        let scaled = peaks
            .iter()
            .zip(&v)
            .map(|(peak, speed)| peak / peaks[0] * (v[0] / speed).powf(1.2));
        assert!(apart(scaled, [1.0; 3]) < 2e-9, "{peaks:?}");
    }
}

/// What has passed the last contact follows from the states, to the tolerance, with two thirds of the
/// steps that a run takes which follows energies.
#[test]
fn val_quadrature_energy_passed_by_the_last_contact() {
    let scene = "sites = 16\nend_time = 25.0\nsamples = 2\ntolerance = 1e-8\n";
    let sweep = sweep(scene, &["ends=wall,free,fixed", "precompression=0,0.3"]);
    let (_, outcomes) = sweep.compute(&Silent).unwrap();
    for (member, outcome) in &outcomes {
        let found = outcome.done().unwrap();
        let mut simulation = sweep.simulation(*member).unwrap();
        assert!(simulation.record.energy);
        let run = simulation.run(&Silent).unwrap();
        let passed = run.energy_passed.unwrap()[[1, 14]];
        let off = found.energy_passed_last.unwrap() - passed;
        let steps = found.steps as f64 / run.report.cost.steps as f64;
        assert!(passed > 1e-6 && off.abs() < 1e-8, "{off:e}");
        assert!((0.4..0.8).contains(&steps), "{steps}");
        simulation.record.energy = false;
        let plain = simulation.run(&Silent).unwrap().report.cost.steps;
        assert_eq!(found.steps, plain);
    }
}

#[test]
fn regress_the_same_table_from_threads_parts_and_interruptions() {
    let out = Out::new();
    let all = out.whole("whole");

    let one = rayon::ThreadPoolBuilder::new().num_threads(1);
    let one = one.build().unwrap();
    assert_eq!(one.install(|| out.whole("one")), all);

    for (k, name) in [(1, "first"), (2, "second"), (3, "third")] {
        let standing = out.run(name, &sweep(SCENE, &VARY), [k, 3]);
        assert_eq!((standing.known, standing.table), (6, None));
    }
    let merge = |names: [&str; 2]| {
        let parts = names.map(|name| out.at(name));
        Sweep::merge(&parts, &out.at("merged")).unwrap()
    };
    let merged = merge(["third", "first"]);
    assert_eq!((merged.known, merged.table), (12, None));
    let merged = merge(["second", "merged"]);
    assert_eq!(merged.table, Some(out.at("merged").join(TABLE)));
    assert_eq!(out.table("merged"), all);

    let mut rounds = 0;
    let standing = loop {
        let impatient = Impatient(AtomicU64::new(4));
        match sweep(SCENE, &VARY).run(&out.at("stopped"), Part::WHOLE, &impatient) {
            Ok(standing) => break standing,
            Err(Error::Paused { .. }) => rounds += 1,
            Err(error) => panic!("{error}"),
        }
    };
    assert!(rounds >= 2 && standing.known == 18, "{rounds} {standing:?}");
    assert_eq!(out.table("stopped"), all);

    // Chains of fixed steps go eight together; which eight makes no difference.
    let scene = "sites = 30\nend_time = 40.0\nsamples = 100\nscheme = \"velocity-verlet\"\n\
                 step = 0.01\nrecord = [\"displacement\", \"force\"]\n";
    let fixed = sweep(scene, &["ends=wall,free,fixed", "stiffness_ratio=2,3,4"]);
    out.run("all", &fixed, [1, 1]);
    let parts = [1, 2, 3, 4, 5, 6, 7, 8, 9].map(|k| {
        out.run(&k.to_string(), &fixed, [k, 9]);
        out.at(&k.to_string())
    });
    Sweep::merge(&parts, &out.at("of nine")).unwrap();
    assert_eq!(out.table("of nine"), out.table("all"));
}

/// Peaks that the samples do not show, or that the end of the run cuts off, are not told.
#[test]
fn val_definition_peaks_that_are_not_known() {
    let measures = |samples: usize, end: f64| {
        let scene =
            format!("sites = 40\nend_time = {end}\nsamples = {samples}\ntolerance = 1e-7\n");
        let (_, outcomes) = sweep(&scene, &["stiffness_ratio=4.9272"])
            .compute(&Silent)
            .unwrap();
        outcomes[&0].done().unwrap().clone()
    };
    let found = measures(4096, 60.0);
    // The same from 16 times as many samples.
    let [first, last] = [found.peak_force_first, found.peak_force_last].map(Option::unwrap);
    near(first, 0.775_7, 1e-4, "first");
    near(last, 1.019_8, 1e-4, "last");
    assert!(found.peak_force_first_error.unwrap() < 2e-7, "{found:?}");
    assert_eq!(measures(2, 60.0).peak_force_first, None);
    assert_eq!(measures(16, 60.0).peak_force_first, None);
    // The front has only just arrived.
    assert_eq!(measures(4096, 34.0).peak_force_last, None);
    // It has not: a force of 0 is none that is known.
    assert_eq!(measures(4096, 20.0).peak_force_last, None);
}

/// The force of a front is known beside velocities that the chain amplifies behind it: against pulses that are followed step
/// by step.
#[test]
fn val_followed_pulses_forces_of_chains_that_amplify() {
    let sweep = sweep("sites = 120\n", &["stiffness_ratio=2,8"]);
    let (_, outcomes) = sweep.compute(&Silent).unwrap();
    for (member, outcome) in &outcomes {
        let found = outcome.done().unwrap();
        let followed = pulses(&sweep.simulation(*member).unwrap(), Sense::Wall, &Silent);
        let truth = followed.unwrap().pulses[0].peak_force;
        let (force, error) = (found.peak_force_last, found.peak_force_last_error.unwrap());
        near(force.unwrap(), truth.value, error + truth.error, member);
        within(error, ..1e-3, member);
        assert!(found.error.unwrap() > 1e-8 && !found.warned, "{found:?}");
    }
}

/// A line that was cut short by a kill, and one of which any byte is another, is computed again.
#[test]
fn regress_lines_cut_short_and_damaged() {
    let out = Out::new();
    let all = out.whole("sweep");
    let members = out.at("sweep").join("members.jsonl");
    let text = std::fs::read(&members).unwrap();
    let lines = |text: &[u8]| text.iter().filter(|b| **b == b'\n').count();
    let cut = |length: usize| (text[..length].to_vec(), 18 - lines(&text[..length]));
    let mut cases = vec![cut(0), cut(1), cut(text.len() / 2), cut(text.len() - 1)];
    for at in (0..text.len()).step_by(97).filter(|at| text[*at] != b'\n') {
        let mut damaged = text.clone();
        damaged[at] = match damaged[at] {
            digit @ b'0'..=b'8' => digit + 1,
            _ => b'9',
        };
        if damaged != text {
            cases.push((damaged, 1));
        }
    }
    let sweep = sweep(SCENE, &VARY);
    for (damaged, missing) in cases {
        std::fs::write(&members, damaged).unwrap();
        assert_eq!(out.run("sweep", &sweep, [1, 1]).computed, missing);
        assert_eq!(out.table("sweep"), all);
        // What was added stands in lines of its own.
        assert_eq!(out.run("sweep", &sweep, [1, 1]).computed, 0);
    }
    // Of a request that is another one no member counts.
    let request = out.at("sweep").join("sweep.json");
    let changed = std::fs::read_to_string(&request).unwrap();
    std::fs::write(&request, changed.replace("240", "241")).unwrap();
    let error = Sweep::merge(&[out.at("sweep")], &out.at("m")).unwrap_err();
    assert!(matches!(&error, Error::Damaged { .. }), "{error}");
}

#[test]
fn what_is_not_this_sweep_is_left_alone() {
    let out = Out::new();
    out.whole("sweep");
    std::fs::create_dir(out.at("foreign")).unwrap();
    std::fs::write(out.at("foreign").join("thesis.tex"), "").unwrap();
    for (name, scene, vary, words) in [
        (
            "sweep",
            SCENE,
            "stiffness_ratio=1:20:7log",
            "another sweep: it differs in vary",
        ),
        (
            "sweep",
            &SCENE.replace("240", "241"),
            VARY[0],
            "it differs in scene",
        ),
        ("foreign", SCENE, VARY[0], "something other"),
    ] {
        let other = sweep(scene, &[vary, VARY[1]]);
        let error = other.run(&out.at(name), Part::WHOLE, &Silent).unwrap_err();
        contains_all(&error.to_string(), &[words]);
        assert!(error.is_usage(), "{error}");
    }
    let error = Sweep::merge(&[out.at("foreign")], &out.at("m")).unwrap_err();
    contains_all(&error.to_string(), &["no sweep is there"]);
    // What a kill before the first member leaves is no hindrance.
    std::fs::create_dir(out.at("young")).unwrap();
    let left = out.at("young").join(".cascade-partial-0123456789abcdef");
    std::fs::write(left, "{").unwrap();
    out.run("young", &sweep(SCENE, &VARY), [1, 1]);
}

/// A run that fails is a row of the table.
#[test]
fn members_at_fault() {
    let out = Out::new();
    let scene =
        "sites = 8\nend_time = 20.0\nsamples = 8\nscheme = \"velocity-verlet\"\nstep = 0.01\n";
    let standing = out.run("sweep", &sweep(scene, &["step=0.01,9.0"]), [1, 1]);
    assert_eq!((standing.known, standing.failed), (2, 1));
    let (_, outcomes) = read(&out.at("sweep")).unwrap();
    assert!(
        matches!(&outcomes[&1], Outcome::Failed(why) if why.contains("stability")),
        "{outcomes:?}"
    );
    let table = out.table("sweep");
    assert!(table.contains("\n9.0,,,"), "{table}");
}

/// Ensembles over seeds: the same whatever the order of the work, and the quantiles of NumPy.
#[test]
fn val_numpy_ensembles() {
    let out = Out::new();
    let scene = format!("{SCENE}coefficient_spread = 0.3\nstriker_velocity_spread = 0.1\n");
    let sweep = sweep(&scene, &["stiffness_ratio=1,4", "seed=3:12"]);
    out.run("one", &sweep, [1, 1]);
    for part in [2, 1] {
        out.run("two", &sweep, [part, 2]);
    }
    let text = |name: &str| std::fs::read_to_string(out.at(name).join(ENSEMBLES)).unwrap();
    assert_eq!(text("one"), text("two"));
    let (request, outcomes) = read(&out.at("one")).unwrap();
    let ensembles = request.ensembles(&outcomes);
    assert_eq!(ensembles.len(), 2);
    assert_eq!(ensembles[1].values, ["4"]);
    // As numpy.quantile(values, [0.05, 0.5, 0.95]): linear between order statistics.
    let speeds = (10..20).map(|member| outcomes[&member].done().unwrap().velocity_scale);
    let mut speeds: Vec<f64> = speeds.collect();
    speeds.sort_by(f64::total_cmp);
    assert!(speeds[0] > 0.9 && speeds[9] < 1.1 && speeds[9] - speeds[0] > 0.05);
    let spread = ensembles[1].of("velocity_scale").unwrap();
    let mean = speeds.iter().sum::<f64>() / 10.0;
    let squares: f64 = speeds.iter().map(|v| (v - mean).powi(2)).sum();
    for (found, known) in [
        (spread.p05, 0.55 * speeds[0] + 0.45 * speeds[1]),
        (spread.median, 0.5 * (speeds[4] + speeds[5])),
        (spread.p95, 0.45 * speeds[8] + 0.55 * speeds[9]),
        (spread.mean, mean),
        (spread.deviation, (squares / 9.0).sqrt()),
    ] {
        assert!((found - known).abs() < 1e-15, "{found} {known}");
    }
    assert_eq!(spread.members, 10);
    let swept = Swept { request, outcomes };
    let answer = swept.describe().answer;
    let begins = "median force at the last contact from";
    assert!(answer.starts_with(begins), "{answer}");
    assert!(!swept.pictures().is_empty());
}
