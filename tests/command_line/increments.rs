//! `cascade increments` as a stranger runs it.

use ndarray::Array2;
use ndarray_npy::NpzReader;
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
    let words = [
        "increments",
        "field.npy",
        "--band",
        "1:8",
        "--figures",
        "png",
    ];
    let said = place.good(&words);
    assert!(said.contains("intervals of the regression"), "{said}");
    let summary = place.json("field-increments/summary.json");
    let exponent = summary["axes"][0]["exponents"]["exponents"][1]
        .as_f64()
        .unwrap();
    assert!((exponent - 1.0).abs() < 0.05, "{exponent}");
    let file = std::fs::File::open(place.path("field-increments/increments.npz")).unwrap();
    let mut archive = NpzReader::new(file).unwrap();
    let structure: Array2<f64> = archive.by_name("space_structure").unwrap();
    assert_eq!(structure.dim(), (6, 6));
    for name in ["report.html", "figures/increments.png"] {
        assert!(place.path(format!("field-increments/{name}")).exists());
    }
    let before = place.names();
    for (words, named) in [
        ("--separations 32", "--separations"),
        ("--lags 0", "--lags"),
        ("--band 1:1.5", "--band"),
        ("--lag-band 1:1.5", "--lag-band"),
    ] {
        let words: Vec<&str> = ["increments", "field.npy", "--force"]
            .into_iter()
            .chain(words.split(' '))
            .collect();
        let said = place.bad(2, &words);
        assert!(said.contains(named), "{words:?}: {said}");
        assert_eq!(place.names(), before, "{words:?}");
    }
}
