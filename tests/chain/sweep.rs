//! Sweeps: the same table from any order of work, however often it is interrupted.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use wavecascade::Error;
use wavecascade::attenuation::{Sense, pulses};
use wavecascade::chain::scene::SceneSource;
use wavecascade::observer::{Observer, Silent};
use wavecascade::sheet::Describe;
use wavecascade::sweep::{ENSEMBLES, Outcome, Part, Sweep, Swept, TABLE, read};

const SCENE: &str = "sites = 12\nend_time = 20.0\nsamples = 240\ntolerance = 1e-7\n";

fn sweep(vary: &[&str]) -> Sweep {
    let vary: Vec<String> = vary.iter().map(|&v| v.to_owned()).collect();
    Sweep::new(SceneSource::new(None, SCENE), &vary).unwrap()
}

const VARY: [&str; 2] = ["stiffness_ratio=1:20:6log", "striker_velocity=0.5,1,2"];

fn table(directory: &Path) -> String {
    std::fs::read_to_string(directory.join(TABLE)).unwrap()
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

fn whole(place: &Path) -> String {
    let standing = sweep(&VARY).run(place, Part::WHOLE, &Silent).unwrap();
    assert_eq!(standing.members, 18);
    assert_eq!(standing.computed, 18);
    assert_eq!(standing.failed, 0);
    table(place)
}

/// Peaks scale as `v^{6/5}` with the impact's speed in a Hertz chain, energies as `v^2`.
#[test]
fn val_scaling_of_peaks_and_energies() {
    let place = tempfile::tempdir().unwrap();
    let out = place.path().join("sweep");
    let all = whole(&out);
    let mut rows = csv::Reader::from_reader(all.as_bytes());
    let columns = rows.headers().unwrap().clone();
    let column = |name: &str| columns.iter().position(|c| c == name).unwrap();
    assert_eq!(&columns[0], "stiffness_ratio");
    let rows: Vec<Vec<f64>> = rows
        .records()
        .map(|row| {
            row.unwrap()
                .iter()
                .map(|v| v.parse().unwrap_or(f64::NAN))
                .collect()
        })
        .collect();
    assert_eq!(rows.len(), 18);
    for rows in rows.chunks(3) {
        for (name, power) in [("peak_force_first", 1.2), ("energy_input", 2.0)] {
            let value =
                |i: usize| rows[i][column(name)] / rows[i][column("striker_velocity")].powf(power);
            for i in 1..3 {
                let off = value(i) / value(0) - 1.0;
                println!("{name}: {off:e}");
                assert!(off.abs() < 2e-9, "{name}: {off:e}");
            }
        }
        for row in rows {
            let (v, drift) = (row[column("striker_velocity")], row[column("energy_drift")]);
            assert_eq!(row[column("energy_input")], 0.5 * v * v);
            assert!(drift < 1e-8, "{drift:e}");
        }
    }
}

/// What has passed the last contact follows from the states, to the tolerance, with two thirds of the
/// steps that a run takes which follows energies.
#[test]
fn val_quadrature_energy_passed_by_the_last_contact() {
    let scene = "sites = 16\nend_time = 25.0\nsamples = 2\ntolerance = 1e-8\n";
    let vary = ["ends=wall,free,fixed", "precompression=0,0.3"].map(str::to_owned);
    let sweep = Sweep::new(SceneSource::new(None, scene), &vary).unwrap();
    let (_, outcomes) = sweep.compute(&Silent).unwrap();
    for (member, outcome) in &outcomes {
        let Outcome::Done(found) = outcome else {
            panic!("{outcome:?}")
        };
        let mut simulation = sweep.simulation(*member).unwrap();
        assert!(simulation.record.energy);
        let run = simulation.run(&Silent).unwrap();
        let passed = run.energy_passed.unwrap()[[1, 14]];
        let off = found.energy_passed_last.unwrap() - passed;
        let steps = found.steps as f64 / run.report.cost.steps as f64;
        assert!(passed > 1e-6 && off.abs() < 1e-8, "{off:e}");
        assert!((0.4..0.8).contains(&steps), "{steps}");
        simulation.record.energy = false;
        assert_eq!(
            found.steps,
            simulation.run(&Silent).unwrap().report.cost.steps
        );
    }
}

#[test]
fn regress_the_same_table_from_threads_parts_and_interruptions() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    let all = whole(&at("whole"));

    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(one.install(|| whole(&at("one"))), all);

    for (k, name) in [(1, "first"), (2, "second"), (3, "third")] {
        let part = Part::new(k, 3).unwrap();
        let standing = sweep(&VARY).run(&at(name), part, &Silent).unwrap();
        assert_eq!((standing.known, standing.table), (6, None));
    }
    let merged = Sweep::merge(&[at("third"), at("first")], &at("merged")).unwrap();
    assert_eq!((merged.known, merged.table), (12, None));
    let merged = Sweep::merge(&[at("second"), at("merged")], &at("merged")).unwrap();
    assert_eq!(merged.table, Some(at("merged").join(TABLE)));
    assert_eq!(table(&at("merged")), all);

    let stopped = at("stopped");
    let mut rounds = 0;
    let standing = loop {
        match sweep(&VARY).run(&stopped, Part::WHOLE, &Impatient(AtomicU64::new(4))) {
            Ok(standing) => break standing,
            Err(Error::Paused { .. }) => rounds += 1,
            Err(error) => panic!("{error}"),
        }
    };
    assert!(rounds >= 2 && standing.known == 18, "{rounds} {standing:?}");
    assert_eq!(table(&stopped), all);
}

/// Chains of fixed steps go eight together; which eight makes no difference.
#[test]
fn regress_the_same_table_of_fixed_steps_from_parts() {
    let scene = "sites = 30\nend_time = 40.0\nsamples = 100\nscheme = \"velocity-verlet\"\n\
                 step = 0.01\nrecord = [\"displacement\", \"force\"]\n";
    let vary = ["ends=wall,free,fixed", "stiffness_ratio=2,3,4"].map(str::to_owned);
    let sweep = Sweep::new(SceneSource::new(None, scene), &vary).unwrap();
    let place = tempfile::tempdir().unwrap();
    let whole = place.path().join("whole");
    sweep.run(&whole, Part::WHOLE, &Silent).unwrap();
    let parts: Vec<_> = (1..=9)
        .map(|k| {
            let out = place.path().join(k.to_string());
            sweep.run(&out, Part::new(k, 9).unwrap(), &Silent).unwrap();
            out
        })
        .collect();
    let merged = place.path().join("merged");
    Sweep::merge(&parts, &merged).unwrap();
    assert_eq!(table(&merged), table(&whole));
}

/// Peaks that the samples do not show, or that the end of the run cuts off, are not told.
#[test]
fn val_definition_peaks_that_are_not_known() {
    let peaks = |samples: usize, end: f64| {
        let scene =
            format!("sites = 40\nend_time = {end}\nsamples = {samples}\ntolerance = 1e-7\n");
        let vary = ["stiffness_ratio=4.9272".to_owned()];
        let sweep = Sweep::new(SceneSource::new(None, scene), &vary).unwrap();
        let place = tempfile::tempdir().unwrap();
        let out = place.path().join("sweep");
        sweep.run(&out, Part::WHOLE, &Silent).unwrap();
        match &read(&out).unwrap().1[&0] {
            Outcome::Done(measures) => (
                measures.peak_force_first,
                measures.peak_force_last,
                measures.peak_force_first_error,
            ),
            other => panic!("{other:?}"),
        }
    };
    let (first, last, error) = peaks(4096, 60.0);
    // The same from 16 times as many samples.
    assert!((first.unwrap() - 0.775_7).abs() < 1e-4, "{first:?}");
    assert!((last.unwrap() - 1.019_8).abs() < 1e-4, "{last:?}");
    assert!(error.unwrap() < 2e-7, "{error:?}");
    assert_eq!(peaks(2, 60.0).0, None);
    assert_eq!(peaks(16, 60.0).0, None);
    // The front has only just arrived.
    assert_eq!(peaks(4096, 34.0).1, None);
    // It has not: a force of 0 is none that is known.
    assert_eq!(peaks(4096, 20.0).1, None);
}

/// The force of a front is known beside velocities that the chain amplifies behind it: against pulses that are followed step
/// by step.
#[test]
fn val_followed_pulses_forces_of_chains_that_amplify() {
    let vary = ["stiffness_ratio=2,8".to_owned()];
    let sweep = Sweep::new(SceneSource::new(None, "sites = 120\n"), &vary).unwrap();
    let (_, outcomes) = sweep.compute(&Silent).unwrap();
    for (member, outcome) in &outcomes {
        let found = outcome.done().unwrap();
        let followed = pulses(&sweep.simulation(*member).unwrap(), Sense::Wall, &Silent);
        let truth = followed.unwrap().pulses[0].peak_force;
        let (force, error) = (found.peak_force_last, found.peak_force_last_error.unwrap());
        let off = (force.unwrap() - truth.value).abs();
        assert!(
            off <= error + truth.error && error < 1e-3,
            "{off:e} {error:e}"
        );
        assert!(found.error.unwrap() > 1e-8 && !found.warned, "{found:?}");
    }
}

/// A line that was cut short by a kill, and one of which any byte is another, is computed again.
#[test]
fn regress_lines_cut_short_and_damaged() {
    let place = tempfile::tempdir().unwrap();
    let out = place.path().join("sweep");
    let all = whole(&out);
    let members = out.join("members.jsonl");
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
    for (damaged, missing) in cases {
        std::fs::write(&members, damaged).unwrap();
        let standing = sweep(&VARY).run(&out, Part::WHOLE, &Silent).unwrap();
        assert_eq!(standing.computed, missing);
        assert_eq!(table(&out), all);
        let again = sweep(&VARY).run(&out, Part::WHOLE, &Silent).unwrap();
        assert_eq!(
            again.computed, 0,
            "what was added stands in lines of its own"
        );
    }
    // Of a request that is another one no member counts.
    let request = out.join("sweep.json");
    let changed = std::fs::read_to_string(&request)
        .unwrap()
        .replace("240", "241");
    std::fs::write(&request, changed).unwrap();
    let error = Sweep::merge(&[out], &place.path().join("m")).unwrap_err();
    assert!(matches!(&error, Error::Damaged { .. }), "{error}");
}

#[test]
fn what_is_not_this_sweep_is_left_alone() {
    let place = tempfile::tempdir().unwrap();
    let out = place.path().join("sweep");
    whole(&out);
    let other = sweep(&["stiffness_ratio=1:20:7log"]);
    let error = other
        .run(&out, Part::WHOLE, &Silent)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("another sweep: it differs in vary"),
        "{error}"
    );
    let scene = SceneSource::new(None, SCENE.replace("samples = 240", "samples = 241"));
    let other = Sweep::new(scene, &VARY.map(str::to_owned)).unwrap();
    let error = other
        .run(&out, Part::WHOLE, &Silent)
        .unwrap_err()
        .to_string();
    assert!(error.contains("it differs in scene"), "{error}");
    // What a kill before the first member leaves is no hindrance.
    let young = place.path().join("young");
    std::fs::create_dir(&young).unwrap();
    std::fs::write(young.join(".cascade-partial-0123456789abcdef"), "{").unwrap();
    assert!(sweep(&VARY).run(&young, Part::WHOLE, &Silent).is_ok());
    let foreign = place.path().join("foreign");
    std::fs::create_dir(&foreign).unwrap();
    std::fs::write(foreign.join("thesis.tex"), "").unwrap();
    let error = sweep(&VARY)
        .run(&foreign, Part::WHOLE, &Silent)
        .unwrap_err();
    assert!(
        error.is_usage() && error.to_string().contains("something other"),
        "{error}"
    );
    let error = Sweep::merge(&[foreign], &place.path().join("m")).unwrap_err();
    assert!(error.to_string().contains("no sweep is there"), "{error}");
}

/// A run that fails is a row of the table.
#[test]
fn members_at_fault() {
    let place = tempfile::tempdir().unwrap();
    let out = place.path().join("sweep");
    let scene =
        "sites = 8\nend_time = 20.0\nsamples = 8\nscheme = \"velocity-verlet\"\nstep = 0.01\n";
    let steps = ["step=0.01,9.0".to_owned()];
    let sweep = Sweep::new(SceneSource::new(None, scene), &steps).unwrap();
    let standing = sweep.run(&out, Part::WHOLE, &Silent).unwrap();
    assert_eq!((standing.known, standing.failed), (2, 1));
    let (_, outcomes) = read(&out).unwrap();
    assert!(
        matches!(&outcomes[&1], Outcome::Failed(why) if why.contains("stability")),
        "{outcomes:?}"
    );
    assert!(table(&out).lines().nth(2).unwrap().starts_with("9.0,,,"));
}

/// Ensembles over seeds: the same whatever the order of the work, and the quantiles of NumPy.
#[test]
fn val_numpy_ensembles() {
    let scene = format!("{SCENE}coefficient_spread = 0.3\nstriker_velocity_spread = 0.1\n");
    let source = SceneSource::new(None, scene);
    let vary = ["stiffness_ratio=1,4".to_owned(), "seed=3:12".to_owned()];
    let sweep = Sweep::new(source.clone(), &vary).unwrap();
    let place = tempfile::tempdir().unwrap();
    let [one, two] = ["one", "two"].map(|name| place.path().join(name));
    sweep.run(&one, Part::WHOLE, &Silent).unwrap();
    for part in [2, 1] {
        sweep
            .run(&two, Part::new(part, 2).unwrap(), &Silent)
            .unwrap();
    }
    let text = |directory: &Path| std::fs::read_to_string(directory.join(ENSEMBLES)).unwrap();
    assert_eq!(text(&one), text(&two));
    let (request, outcomes) = read(&one).unwrap();
    let ensembles = request.ensembles(&outcomes);
    assert_eq!(ensembles.len(), 2);
    assert_eq!(ensembles[1].values, ["4"]);
    // As numpy.quantile(values, [0.05, 0.5, 0.95]): linear between order statistics.
    let mut speeds: Vec<f64> = (10..20)
        .map(|member| match &outcomes[&member] {
            Outcome::Done(measures) => measures.velocity_scale,
            Outcome::Failed(why) => panic!("{why}"),
        })
        .collect();
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
