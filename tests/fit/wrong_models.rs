//! A good fit of a wrong chain is called one, and what is wrong is named where the records say so.

use wavecascade::fit::Fitted;
use wavecascade::sheet::Describe;

use super::made::Measurement;

fn fitted(truth: &str, model: &str, free: &[&str], end: f64) -> Fitted {
    let made = Measurement {
        noise: 0.02,
        ..Measurement::of(&[2, 5, 8], 300, end)
    };
    let right = made.fit(truth, truth, free).unwrap();
    assert!(right.misfit.is_none(), "{}", right.describe().answer);
    let wrong = made.fit(truth, model, free).unwrap();
    let answer = wrong.describe().answer;
    assert!(
        answer.starts_with("the model does not explain the records: ") && answer.len() < 120,
        "{answer}"
    );
    wrong
}

/// The cause by its name, alone, with the value of the truth.
fn named(found: &Fitted, name: &str, truth: f64, most: f64) {
    let cause = found.cause.as_ref().unwrap();
    assert_eq!(
        (cause.name.as_str(), &cause.rivals[..]),
        (name, &[][..]),
        "{cause:?}"
    );
    assert!(cause.is_all && cause.explained > 0.5, "{cause:?}");
    let off = (cause.free - truth).abs();
    assert!(off < most || truth.is_nan(), "{cause:?}");
}

const FREE: [&str; 2] = ["coefficient_cell[0]", "striker_velocity"];

fn scene(more: &str) -> String {
    format!("sites = 10\nstriker_velocity = 1.0\ncoefficient_cell = [1.0]\n{more}")
}

#[test]
fn val_missing_damping() {
    let found = fitted(&scene("tangent = 0.03"), &scene(""), &FREE, 16.0);
    named(&found, "tangent", 0.03, 0.001);
}

#[test]
fn val_wrong_exponent() {
    let of = |p: f64| scene(&format!("law = \"power\"\nexponent = {p:?}"));
    let found = fitted(&of(1.6), &of(1.5), &FREE, 16.0);
    named(&found, "exponent of the law", 1.6, 0.01);
}

/// The contact between bodies 4 and 5 is softer.
#[test]
fn val_loose_contact() {
    let mut cell = ["1.0"; 10];
    cell[4] = "0.6";
    let truth = format!(
        "sites = 10\nstriker_velocity = 1.0\ncoefficients = [{}]",
        cell.join(", ")
    );
    let model = truth.replace("0.6", "1.0");
    let found = fitted(&truth, &model, &["striker_velocity"], 16.0);
    named(&found, "coefficient between bodies 4 and 5", 0.6, 0.01);
}

/// A body is heavier than it is said to be.
#[test]
fn val_wrong_mass() {
    let truth = scene("[[defect]]\nsite = 6\nfactor = 1.3");
    let found = fitted(&truth, &scene(""), &FREE, 16.0);
    named(&found, "mass of body 6", 1.3, 0.01);
}

/// Nothing reflects the wave, and something should: late, and not before.
#[test]
fn val_no_wall() {
    let found = fitted(
        &scene("ends = \"wall\""),
        &scene("ends = \"free\""),
        &FREE,
        24.0,
    );
    named(&found, "ends = \"wall\"", f64::NAN, 0.0);
    let times = found.misfit.unwrap().times.unwrap();
    assert!(times[0] > 8.0 && times[1] > 23.0, "{times:?}");
}

/// A gain and a clock that are off are none of the chain.
#[test]
fn val_wrong_gain_and_clock() {
    let made = Measurement::of(&[2, 5, 8], 300, 16.0);
    let mut records = made.records(&made.run(&scene("")));
    let fit = |field: wavecascade::Field| {
        let source = wavecascade::chain::scene::SceneSource::new(None, scene(""));
        let silent = wavecascade::observer::Silent;
        made.request(&FREE).run(&field, &source, &silent).unwrap()
    };
    let mut late = made.field(made.with_noise(&records));
    late.time.origin = 0.4;
    named(&fit(late), "clock of the records", 0.4, 0.01);
    records.column_mut(1).mapv_inplace(|v| 1.1 * v);
    let loud = fit(made.field(made.with_noise(&records)));
    named(&loud, "gain at body 5", 1.1, 0.01);
}

/// Hum on one record is nothing that a number of the chain explains.
#[test]
fn val_no_cause_of_what_is_none_of_the_chain() {
    let made = Measurement::of(&[2, 5, 8], 300, 16.0);
    let mut records = made.with_noise(&made.records(&made.run(&scene(""))));
    let hum = |i: usize| 0.03 * (0.9 * i as f64).sin();
    records
        .column_mut(2)
        .iter_mut()
        .enumerate()
        .for_each(|(i, v)| *v += hum(i));
    let source = wavecascade::chain::scene::SceneSource::new(None, scene(""));
    let found = made.request(&FREE).run(
        &made.field(records),
        &source,
        &wavecascade::observer::Silent,
    );
    let found = found.unwrap();
    assert!(
        found.misfit.is_some() && found.cause.is_none(),
        "{:?}",
        found.cause
    );
}
