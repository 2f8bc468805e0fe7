//! `cascade bicoherence` as a stranger runs it.

use ndarray::Array2;
use test_support::fields::noise;
use test_support::place::Place;

/// A record with a quadratic part, and one without.
fn place() -> Place {
    let place = Place::new();
    let source = noise(8192, 2);
    let mut low = [0.0; 2];
    let values = Array2::from_shape_fn((8192, 2), |(n, j)| {
        low[j] = 0.7 * low[j] + source[[n, j]];
        match j {
            0 => low[j] + 0.3 * low[j] * low[j],
            _ => source[[n, j]],
        }
    });
    place.save("field.npy", &values);
    place
}

#[test]
fn regress_coupling_is_found_and_written() {
    let place = place();
    let said = place.says("bicoherence field.npy --segment 64 --dt 10us --figures png");
    let first = said.lines().next().unwrap();
    assert!(first.starts_with("field.npy: "), "{said}");
    assert!(first.contains("are coupled with"), "{said}");
    assert!(said.contains("biphase"), "{said}");
    let summary = place.json("field-bicoherence/summary.json");
    assert!(summary["above_map_level"].as_u64().unwrap() > 20);
    assert_eq!(summary["correction"], "Sidak");
    let strongest = &summary["strongest"][0];
    assert!(strongest["biphase"].as_f64().unwrap().abs() < 0.5);
    let above = &summary["along"]["above_level"];
    assert!(above[0].as_u64() > above[1].as_u64());
    let array = |name| place.array::<f64>("field-bicoherence/bicoherence.npz", name);
    assert_eq!(array("bicoherence").shape(), [210]);
    assert_eq!(array("along_largest").shape(), [33, 2]);
    place.has("field-bicoherence", "report.html figures/bicoherence.png");
    let again = "bicoherence field.npy --figures none --output 1 --every 0";
    place.refuses(2, again);
    place.says(&format!("{again} --force"));
}

#[test]
fn regress_what_does_not_fit_is_refused_by_its_option() {
    let place = place();
    for (words, named) in [
        ("--site 2", "--site"),
        ("--output 2", "--output"),
        ("--along 0:3", "--along"),
        ("--segment 8192", "--segment"),
        ("--multitaper 4,7", "--multitaper"),
    ] {
        place.refuses_for(2, &format!("bicoherence field.npy {words}"), named);
    }
}
