//! A good fit of a wrong chain is called one, and what is wrong is named where the records say so.

use wavecascade::Field;
use wavecascade::chain::scene::SceneSource;
use wavecascade::fit::Fitted;
use wavecascade::observer::Silent;
use wavecascade::sheet::Describe;

use super::made::Measurement;

const FREE: [&str; 2] = ["coefficient_cell[0]", "striker_velocity"];

fn scene(more: &str) -> String {
    format!("sites = 10\nstriker_velocity = 1.0\ncoefficient_cell = [1.0]\n{more}")
}

fn made(end: f64) -> Measurement {
    Measurement {
        noise: 0.02,
        ..Measurement::of(&[2, 5, 8], 300, end)
    }
}

/// The fit of a scene to a field, which it does not explain.
fn unexplained(made: &Measurement, field: &Field, scene: &str, free: &[&str]) -> Fitted {
    let source = SceneSource::new(None, scene);
    let found = made.request(free).run(field, &source, &Silent).unwrap();
    let answer = found.describe().answer;
    println!("{answer}: {:?}", found.causes.cause);
    assert!(
        answer.starts_with("the model does not explain the records: ") && answer.len() < 120,
        "{answer}"
    );
    found
}

/// The cause by its name, alone, with the value of the truth; NaN for what is no number.
fn named(found: &Fitted, name: &str, truth: f64, most: f64) {
    let cause = found.causes.cause.as_ref().unwrap();
    assert_eq!(
        (cause.name.as_str(), &cause.rivals[..]),
        (name, &[][..]),
        "{cause:?}"
    );
    assert!(cause.is_all && cause.explained > 0.5, "{cause:?}");
    let off = (cause.free - truth).abs();
    assert!(off < most || truth.is_nan(), "{cause:?}");
}

/// Chains that differ from that of the scene by one thing.
#[test]
fn val_what_a_chain_differs_by_is_named() {
    let power = |p: f64| scene(&format!("law = \"power\"\nexponent = {p:?}"));
    let list = |c: f64| {
        let cell = format!("1.0, 1.0, 1.0, 1.0, {c:?}, 1.0, 1.0, 1.0, 1.0, 1.0");
        format!("sites = 10\nstriker_velocity = 1.0\ncoefficients = [{cell}]")
    };
    let ratio =
        |kappa: f64| format!("sites = 10\nstriker_velocity = 1.0\nstiffness_ratio = {kappa:?}");
    let defect = scene("[[defect]]\nsite = 6\nfactor = 1.3");
    let (plain, speed) = (scene(""), &FREE[1..]);
    let damped = scene("tangent = 0.03");
    let pressed = scene("precompression = 0.02");
    let soft = "coefficient between bodies 4 and 5";
    let kappa = "stiffness_ratio";
    for (truth, model, free, name, value, most) in [
        (damped, plain.clone(), &FREE[..], "tangent", 0.03, 0.001),
        (pressed, plain.clone(), &FREE, "precompression", 0.02, 0.002),
        (power(1.6), power(1.5), &FREE, "exponent", 1.6, 0.01),
        (power(1.6), plain.clone(), speed, "exponent", 1.6, 0.01),
        (list(0.6), list(1.0), speed, soft, 0.6, 0.01),
        (ratio(3.0), ratio(2.7), speed, kappa, 3.0, 0.03),
        (defect, plain, &FREE, "mass of body 6", 1.3, 0.01),
    ] {
        let made = made(16.0);
        let field = made.measured(&truth);
        let right = made.fit(&truth, &truth, free).unwrap();
        assert!(right.misfit.is_none(), "{}", right.describe().answer);
        named(&unexplained(&made, &field, &model, free), name, value, most);
    }
}

/// Nothing reflects the wave, and something should: late, and not before.
#[test]
fn val_no_wall() {
    let made = made(24.0);
    let field = made.measured(&scene("ends = \"wall\""));
    let found = unexplained(&made, &field, &scene("ends = \"free\""), &FREE);
    named(&found, "ends = \"wall\"", f64::NAN, 0.0);
    let times = found.misfit.unwrap().times.unwrap();
    assert!(times[0] > 8.0 && times[1] > 23.0, "{times:?}");
}

/// Gains, signs, places and the clock of instruments are none of the chain.
#[test]
fn val_what_instruments_differ_by_is_named() {
    let (clock, loud) = ("clock of the records", "gain at body 5");
    let (own, even, none) = ([2, 5, 8], [1.0; 3], f64::NAN);
    let upside_down = "sign of all records";
    for (bodies, gains, origin, name, value) in [
        (own, even, 0.4, clock, 0.4),
        (own, even, 2.0, clock, 2.0),
        (own, [1.0, 1.1, 1.0], 0.0, loud, 1.1),
        (own, [1.0, 1.3, 1.0], 0.0, loud, 1.3),
        (own, [1.0, 1.5, 1.0], 0.0, loud, 1.5),
        (own, [-1.0; 3], 0.0, upside_down, none),
        (own, [1.0, 1.0, -1.0], 0.0, "sign at body 8", none),
        ([8, 5, 2], even, 0.0, "records of bodies 8, 5 and 2", none),
        ([2, 6, 8], even, 0.0, "records of bodies 2, 6 and 8", none),
    ] {
        let made = made(16.0);
        let there = Measurement {
            bodies: bodies.to_vec(),
            ..made.clone()
        };
        let records = there.records(&there.run(&scene(""))) * &ndarray::arr1(&gains);
        let mut field = made.field(made.with_noise(&records));
        field.time.origin = origin;
        let found = unexplained(&made, &field, &scene(""), &FREE);
        named(&found, name, value, 0.01);
    }
}

/// Hum on a part of one record is nothing that a number of the chain explains: what was tried is said.
#[test]
fn val_no_cause_of_what_is_none_of_the_chain() {
    let made = made(16.0);
    let mut records = made.with_noise(&made.records(&made.run(&scene(""))));
    let hum = |i: usize| match (150..200).contains(&i) {
        true => 0.05 * (0.9 * i as f64).sin(),
        false => 0.0,
    };
    let mut record = records.column_mut(2);
    record
        .iter_mut()
        .enumerate()
        .for_each(|(i, v)| *v += hum(i));
    let found = unexplained(&made, &made.field(records), &scene(""), &FREE);
    assert!(found.causes.cause.is_none(), "{:?}", found.causes.cause);
    let advice = &found.describe().warnings[0].advice;
    assert!(
        advice.contains("none of what was tried") && advice.contains("one gain"),
        "{advice}"
    );
}
