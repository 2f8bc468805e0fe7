//! A good fit of a wrong chain is called one, and what is wrong is named where the records say so.

use ndarray::Array2;
use wavecascade::chain::scene::SceneSource;
use wavecascade::fit::Fitted;
use wavecascade::observer::Silent;
use wavecascade::sheet::Describe;

use super::made::Measurement;

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
fn val_what_is_wrong_with_a_model_is_named() {
    let rows = include_str!("causes.txt").lines();
    for row in rows.filter(|row| !row.is_empty() && !row.starts_with('#')) {
        let parts: Vec<&str> = row.split(" | ").collect();
        let scene = |keys: &str| {
            let keys = keys.replace(" ; ", "\n");
            format!("sites = 10\nstriker_velocity = 1.0\n{keys}")
        };
        let [truth, model] = [0, 1].map(|i| scene(parts[i]));
        let free: Vec<&str> = parts[2].split(' ').collect();
        let made = Measurement::of(&[2, 5, 8], 300, parts[3].parse().unwrap());
        let right = made.fit(&truth, &truth, &free).unwrap();
        assert!(right.misfit.is_none(), "{}", right.describe().answer);
        let found = made.fit(&truth, &model, &free).unwrap();
        let answer = found.describe().answer;
        let is_said = answer.starts_with("the model does not explain the records: ");
        assert!(is_said && answer.len() < 120, "{answer}");
        let (value, most) = parts[5].split_once(' ').unwrap();
        let [value, most] = [value, most].map(|text| text.parse::<f64>().unwrap());
        named(&found, parts[4], value, most);
        // Of what has no value, when it begins.
        if value.is_nan() {
            let times = found.misfit.unwrap().times.unwrap();
            assert!(times[0] > most && times[1] > parts[3].parse::<f64>().unwrap() - 1.0);
        }
    }
}

/// Fits records of the right model, after a change.
fn fit(change: impl FnOnce(&mut Array2<f64>), origin: f64) -> Fitted {
    let made = Measurement::of(&[2, 5, 8], 300, 16.0);
    let mut records = made.records(&made.run(&scene("")));
    let size = records.clone();
    change(&mut records);
    // Noise is of the size of the records as they are.
    let noise = made.with_noise(&size) - &size;
    let mut field = made.field(records + noise);
    field.time.origin = origin;
    let source = SceneSource::new(None, scene(""));
    made.request(&FREE).run(&field, &source, &Silent).unwrap()
}

/// A gain and a clock that are off are none of the chain.
#[test]
fn val_wrong_gain_and_clock() {
    named(&fit(|_| (), 0.4), "clock of the records", 0.4, 0.01);
    let loud = |records: &mut Array2<f64>| records.column_mut(1).mapv_inplace(|v| 1.1 * v);
    named(&fit(loud, 0.0), "gain at body 5", 1.1, 0.01);
}

/// Hum on one record is nothing that a number of the chain explains.
#[test]
fn val_no_cause_of_what_is_none_of_the_chain() {
    let hum = |records: &mut Array2<f64>| {
        for (i, v) in records.column_mut(2).iter_mut().enumerate() {
            *v += 0.03 * (0.9 * i as f64).sin();
        }
    };
    let found = fit(hum, 0.0);
    let is_unexplained = found.misfit.is_some() && found.cause.is_none();
    assert!(is_unexplained, "{:?}", found.cause);
}
