//! A good fit of a wrong chain is called one.

use wavecascade::fit::Fitted;
use wavecascade::sheet::Describe;

use super::made::Measurement;

fn fitted(truth: &str, model: &str, free: &[&str], end: f64) -> Fitted {
    let made = Measurement {
        noise: 0.02,
        ..Measurement::of(&[2, 5, 8], 300, end)
    };
    let right = made.fit(truth, truth, free).unwrap();
    println!("right: {}", right.describe().answer);
    assert!(right.misfit.is_none(), "{}", right.describe().answer);
    let wrong = made.fit(truth, model, free).unwrap();
    println!("wrong: {}", wrong.describe().answer);
    let answer = wrong.describe().answer;
    assert!(
        answer.starts_with("the model does not explain the records: misfit"),
        "{answer}"
    );
    wrong
}

const FREE: [&str; 2] = ["coefficient_cell[0]", "striker_velocity"];

fn scene(more: &str) -> String {
    format!("sites = 10\nstriker_velocity = 1.0\ncoefficient_cell = [1.0]\n{more}")
}

#[test]
fn val_missing_damping() {
    fitted(&scene("tangent = 0.03"), &scene(""), &FREE, 16.0);
}

#[test]
fn val_wrong_exponent() {
    let of = |p: f64| scene(&format!("law = \"power\"\nexponent = {p:?}"));
    fitted(&of(1.6), &of(1.5), &FREE, 16.0);
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
    fitted(&truth, &model, &["striker_velocity"], 16.0);
}

/// A body is heavier than it is said to be.
#[test]
fn val_wrong_mass() {
    fitted(
        &scene("[[defect]]\nsite = 6\nfactor = 1.3"),
        &scene(""),
        &FREE,
        16.0,
    );
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
    let times = found.misfit.unwrap().times.unwrap();
    assert!(times[0] > 8.0 && times[1] > 23.0, "{times:?}");
}
