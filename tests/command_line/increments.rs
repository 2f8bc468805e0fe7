//! `cascade increments` as a stranger runs it.

use test_support::fields::noise;
use test_support::place::Place;

#[test]
fn regress_structure_functions_are_written() {
    let place = Place::new();
    let mut values = noise(256, 32);
    for mut row in values.outer_iter_mut() {
        let mut sum = 0.0;
        row.mapv_inplace(|step| {
            sum += step;
            sum
        });
    }
    place.save("field.npy", &values);
    place.says("increments field.npy --band 1:8 --figures png");
    let summary = place.json("field-increments/summary.json");
    let exponents = &summary["axes"][0]["exponents"]["exponents"];
    let exponent = exponents[1].as_f64().unwrap();
    assert!((exponent - 1.0).abs() < 0.05, "{exponent}");
    let structure = place.array::<f64>("field-increments/increments.npz", "space_structure");
    assert_eq!(structure.shape(), [6, 6]);
    place.has("field-increments", "report.html figures/increments.png");
    let said = place.refuses(2, "increments field.npy --force --lag-band 1:1.5");
    assert!(said.contains("--lag-band"), "{said}");
}
