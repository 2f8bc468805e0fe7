//! Measured fields against runs: what differs is named, and nothing else.

use ndarray::Array2;
use rayon::prelude::*;
use wavecascade::chain::EndTime;
use wavecascade::chain::scene::SceneSource;
use wavecascade::field::Quantity;
use wavecascade::fit::{CompareRequest, Comparison, Records};
use wavecascade::observer::Silent;
use wavecascade::sheet::Describe;

use test_support::measured::Normal;

use super::made::Measurement;

const BODIES: [usize; 5] = [3, 6, 9, 12, 15];

fn scene(more: &str) -> String {
    format!("sites = 20\ncoefficient_cell = [1.0, 2.0]\nend_time = 30.0\n{more}")
}

fn made() -> Measurement {
    Measurement {
        noise: 0.01,
        ..Measurement::of(&BODIES, 600, 30.0)
    }
}

/// A measurement of a truth, changed, against the run of a scene.
fn compared(
    made: &Measurement,
    truth: &str,
    change: impl FnOnce(&mut Array2<f64>),
    origin: f64,
) -> Comparison {
    let mut records = made.records(&made.run(&scene(truth)));
    change(&mut records);
    let mut field = made.field(made.with_noise(&records));
    field.time.origin = origin;
    let request = CompareRequest {
        bodies: Some(made.bodies.clone()),
        ..CompareRequest::default()
    };
    let source = SceneSource::new(None, scene(""));
    let found = request.run(&field, &source, &Silent).unwrap();
    let off =
        (&found.overlay.measured - &found.overlay.run - &found.overlay.residual).mapv(f64::abs);
    assert!(off.iter().all(|off| *off < 1e-12), "{off}");
    found
}

/// A line below the answer; empty for none.
fn fact(found: &Comparison, name: &str) -> String {
    let facts = found.describe().facts;
    let fact = facts.into_iter().find(|fact| fact.name == name);
    fact.map_or(String::new(), |fact| fact.text)
}

/// They differ, the answer is short, and arrivals, largest values and energies have these words; `None` for alike, or below noise.
fn differs(found: &Comparison, words: [Option<&str>; 3]) {
    let answer = found.describe().answer;
    let is_short = answer.len() < 160 && answer.matches([';', ':']).count() < 3;
    assert!(
        !found.agrees() && is_short && answer.starts_with("measurement and run differ"),
        "{answer}"
    );
    for (name, words) in ["arrivals", "largest values", "energies"].iter().zip(words) {
        let fact = fact(found, name);
        match words {
            Some(words) => assert!(fact.contains(words), "{name}: {fact}"),
            None => assert!(
                fact.is_empty() || fact.starts_with("agree") && !fact.contains("run"),
                "{name}: {fact}"
            ),
        }
    }
}

/// Nothing explains the difference, and the answer says by how much it is.
fn unexplained(found: &Comparison, words: &str) {
    let answer = found.describe().answer;
    assert!(found.cause.is_none() && answer.contains(words), "{answer}");
    assert!(answer.contains("no one number"), "{answer}");
}

/// What explains the difference, alone, with the number of the truth.
fn explained(found: &Comparison, name: &str, truth: f64, most: f64) {
    let cause = found.cause.as_ref().unwrap();
    assert_eq!(
        (cause.name.as_str(), cause.rivals.len()),
        (name, 0),
        "{cause:?}"
    );
    assert!((cause.free - truth).abs() < most, "{cause:?}");
    let answer = found.describe().answer;
    assert!(
        answer.contains(&format!("differ by one number: {name}, ")),
        "{answer}"
    );
}

/// Of any size, white or not, at many or few samples: nothing parts.
#[test]
fn val_noise_alone_is_no_difference() {
    let mut all = Vec::new();
    for noise in [1e-6, 1e-3, 0.02, 0.3, 3.0, 30.0] {
        for correlation in [0.0, 0.8] {
            for samples in [90, 400] {
                all.extend((1..=3).map(|seed| Measurement {
                    noise,
                    correlation,
                    seed,
                    ..Measurement::of(&BODIES, samples, 29.0)
                }));
            }
        }
    }
    let wrong: Vec<String> = all
        .par_iter()
        .filter_map(|made| {
            let found = compared(made, "", |_| (), 0.0);
            let answer = found.describe().answer;
            let is_right = found.agrees() && answer.starts_with("measurement and run agree");
            (!is_right).then(|| {
                format!(
                    "{} {} {}: {answer}",
                    made.noise, made.correlation, made.seed
                )
            })
        })
        .collect();
    assert!(
        wrong.is_empty(),
        "{} of {}: {wrong:#?}",
        wrong.len(),
        all.len()
    );
    let least = compared(&all[0], "", |_| (), 0.0);
    for name in ["arrivals", "largest values", "energies"] {
        assert!(fact(&least, name).starts_with("agree within"), "{name}");
    }
    let answer = least.describe().answer;
    assert!(answer.contains("e-5 % of the signal"), "{answer}");
    let last = compared(all.last().unwrap(), "", |_| (), 0.0);
    assert!(last.describe().answer.contains("hides the run"));
}

/// Records at uneven times, with gaps.
#[test]
fn val_uneven_sampling_is_no_difference() {
    let mut normal = Normal(7);
    let mut simulation = SceneSource::new(None, scene(""))
        .setup()
        .unwrap()
        .simulation;
    (simulation.end_time, simulation.samples) = (EndTime::At(30.0), 3001);
    let run = simulation.run(&Silent).unwrap();
    // Every third to eleventh sample.
    let mut at = vec![0];
    while at[at.len() - 1] + 12 < 3001 {
        let step = 3 + (normal.draw().abs() * 3.0).min(8.0) as usize;
        at.push(at[at.len() - 1] + step);
    }
    for noise in [1e-4, 0.01, 0.1] {
        let mut sample = |i: usize, body: usize| match i % 97 {
            0 => f64::NAN,
            _ => run.velocity[[i, body]] + noise * normal.draw(),
        };
        let records = |delay: f64, sample: &mut dyn FnMut(usize, usize) -> f64| Records {
            quantity: Quantity::Velocity,
            times: at.iter().map(|i| delay + *i as f64 * 0.01).collect(),
            bodies: BODIES.to_vec(),
            values: BODIES
                .iter()
                .flat_map(|body| at.iter().map(|i| sample(*i, *body)).collect::<Vec<_>>())
                .collect(),
            units: Default::default(),
        };
        let source = SceneSource::new(None, scene(""));
        let of = |records| CompareRequest::default().of_records(records, &source, &Silent);
        let found = of(records(0.0, &mut sample)).unwrap();
        assert!(found.agrees(), "{}", found.describe().answer);
        let late = of(records(0.5, &mut sample)).unwrap();
        explained(&late, "clock of the records", 0.5, 0.05);
        differs(&late, [Some("early at all bodies"), None, None]);
    }
}

/// A record that is late by so many samples arrives so much later, at its body alone; a clock makes all late.
#[test]
fn val_a_late_record_and_a_late_clock_are_named() {
    let step = 30.0 / 599.0;
    let late = |records: &mut Array2<f64>| {
        let record = records.column(2).to_vec();
        for i in 0..600 {
            records[[i, 2]] = if i < 8 { 0.0 } else { record[i - 8] };
        }
    };
    let found = compared(&made(), "", late, 0.0);
    differs(&found, [Some("early at body 9"), None, None]);
    unexplained(&found, "early at body 9");
    let at = &found.bodies[2];
    let off = at.arrival[0] - at.arrival[1] - 8.0 * step;
    assert!(
        off.abs() < 3.0 * at.arrival_error && at.arrival_error < 0.02,
        "{at:?}"
    );
    let found = compared(&made(), "", |_| (), 0.3);
    differs(&found, [Some("early at all bodies"), None, None]);
    explained(&found, "clock of the records", 0.3, 0.003);
    // Far off: an unknown trigger.
    let found = compared(&made(), "", |_| (), -6.0);
    differs(&found, [Some("late at all bodies"), None, None]);
}

/// One gain of 1.2: the run's front is 1/1.2 there.
#[test]
fn val_a_wrong_gain_is_named() {
    let loud = |records: &mut Array2<f64>| records.column_mut(3).mapv_inplace(|v| 1.2 * v);
    let found = compared(&made(), "", loud, 0.0);
    let words = fact(&found, "largest values");
    assert!(words.contains("times the measured at body 12"), "{words}");
    assert!(fact(&found, "arrivals").starts_with("agree within"));
    explained(&found, "gain at body 12", 1.2, 0.01);
    let size = found.bodies[3].peak[0] / found.bodies[3].peak[1];
    assert!((size - 1.2).abs() < 0.01, "{size}");
    assert_eq!(found.bodies.iter().filter(|at| at.is_other).count(), 1);
    let dead = compared(&made(), "", |records| records.column_mut(3).fill(0.0), 0.0);
    let words = fact(&dead, "largest values");
    assert!(
        words.starts_with("in the run more than ") && words.ends_with("at body 12"),
        "{words}"
    );
    assert!(fact(&dead, "arrivals").starts_with("agree within"));
}

/// All records are 1.1 times as large: one gain that they share explains it.
#[test]
fn val_identity_a_gain_of_all_records_is_one_number() {
    let found = compared(&made(), "", |records| *records *= 1.1, 0.0);
    assert!(fact(&found, "arrivals").starts_with("agree within"));
    explained(&found, "gain of all records", 1.1, 0.01);
}

/// A wrong mass, modulus and exponent, and missing losses are what explains the difference.
#[test]
fn val_a_wrong_chain_is_named() {
    let made = made();
    let heavy = compared(&made, "[[defect]]\nsite = 7\nfactor = 1.3", |_| (), 0.0);
    explained(&heavy, "mass of body 7", 1.3, 0.01);
    let before = &heavy.bodies[0];
    assert!(!before.is_late && !before.is_other, "{before:?}");
    let lossy = compared(&made, "tangent = 0.03", |_| (), 0.0);
    let [largest, energies] = ["largest values", "energies"].map(|name| fact(&lossy, name));
    assert!(largest.contains("times the measured") && energies.contains("times the measured"));
    explained(&lossy, "tangent", 0.03, 0.001);
    let [measured, run] = lossy.attenuation.unwrap();
    // Fronts fall to 1/1.06 at body 3 and to 1/1.2 at 15.
    let more = measured.rate - run.rate;
    assert!((0.008..0.014).contains(&more), "{measured:?} {run:?}");
}

#[test]
fn val_a_wrong_modulus_is_named() {
    let made = made();
    let source = |factor: f64| {
        let cell = format!("[{:?}, {:?}]", factor, 2.0 * factor);
        scene("").replace("[1.0, 2.0]", &cell)
    };
    for factor in [1.03, 1.3] {
        let records = made.with_noise(&made.records(&made.run(&source(factor))));
        let request = CompareRequest {
            bodies: Some(made.bodies.clone()),
            ..CompareRequest::default()
        };
        let scene = SceneSource::new(None, scene(""));
        let found = request.run(&made.field(records), &scene, &Silent).unwrap();
        // At one speed of impact times are as the coefficients to the power -2/5.
        let words = fact(&found, "arrivals");
        assert!(
            words.contains("late at all bodies, by ") && words.contains(" to "),
            "{words}"
        );
        assert!(!words.contains("early"), "{words}");
        // Between that of the first half of the front and that of its end.
        for at in &found.bodies {
            let late =
                (at.arrival[1] - at.arrival[0]) / (at.arrival[1] * (1.0 - factor.powf(-0.4)));
            assert!((0.9..1.35).contains(&late), "{late}: {at:?}");
        }
        if let Some(cause) = &found.cause {
            assert_eq!(cause.name, "coefficients of all contacts");
            assert!((cause.free / factor - 1.0).abs() < 0.01, "{cause:?}");
        }
    }
}

/// A filter that lets (1 + cos(2 pi f 8 dt))/2 of the energy pass: the run has more of it above a frequency.
#[test]
fn val_closed_form_energies_above_a_frequency() {
    let smooth = |records: &mut Array2<f64>| {
        for mut record in records.columns_mut() {
            for i in (8..600).rev() {
                record[i] = 0.5 * (record[i] + record[i - 8]);
            }
        }
    };
    let found = compared(&made(), "", smooth, 0.0);
    let step = 30.0 / 599.0;
    let told: Vec<_> = found
        .bands
        .iter()
        .filter(|band| band.ratio[1].is_finite())
        .collect();
    assert!(told.len() >= 2, "{:?}", found.bands);
    for band in told {
        let pass = |f: f64| 0.5 * (1.0 + (std::f64::consts::TAU * f * 8.0 * step).cos());
        assert!(
            band.ratio[0] < 1.0 / pass(band.to) && band.ratio[1] > 1.0 / pass(band.from),
            "{band:?}"
        );
    }
    assert!(found.cause.is_none());
    let words = fact(&found, "energies");
    assert!(words.contains("times the measured"), "{words}");
}
