//! `cascade localize` as a stranger meets it.

use std::fs;

use test_support::contains_all;
use test_support::place::{Place, names, set};
use wavecascade::chain::contact::{Ellipse, stiffness_ratio};

/// The arrays satisfy what they are: forces are powers of psi, the parts make up psi.
#[test]
fn val_definitions_a_profile_is_written_and_drawn() {
    let place = Place::of(&["localize"]);
    let said = place.good(&["--profile", "3", "--out", "wave"]);
    contains_all(&said, &["14.6221", "wave/report.html"]);
    let expected = ["figures", "report.html", "summary.json", "wave.npz"];
    assert_eq!(names(&place.path("wave")), set(&expected));
    let array = |name: &str| place.array::<f64>("wave/wave.npz", name);
    let [time, slow, fast] = ["time", "slow", "fast"].map(array);
    let ratio = array("ratio")[0];
    let [psi, force, overlap] = ["psi", "force", "overlap"].map(array);
    assert_eq!(array("velocity").shape(), [2, time.len()]);
    for j in 0..time.len() {
        for (i, coefficient) in [(0, 1.0), (1, ratio)] {
            assert!((psi[[i, j]].powf(1.5) - force[[i, j]]).abs() < 1e-11);
            let made = coefficient * overlap[[i, j]].max(0.0).powf(1.5);
            assert!((made - force[[i, j]]).abs() < 1e-10, "{j}: {made}");
        }
        assert!((slow[j] + fast[j] - psi[[1, j]]).abs() < 1e-7, "{j}");
    }
    let picture = fs::read(place.path("wave/figures/wave.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
    assert_eq!(place.says_json("--profile 2 --json")["order"], 2);
    assert!(place.path("localized-2/wave.npz").exists());
}

/// Angles by the published form of the ellipse: 8 degrees are nearly those of order 2.
#[test]
fn val_paper_angles_of_localized_and_most_dispersive_waves() {
    let place = Place::of(&["localize"]);
    let words = "--order 2..3 --angles --material quartz --radius 9mm --cells 80 --json";
    let table = place.says_json(words);
    let number = |key: &str| {
        let found = table.pointer(&format!("/orders/{key}"));
        found.and_then(serde_json::Value::as_f64).expect(key)
    };
    let degrees = number("0/angle/degrees");
    assert!((7.0..8.0).contains(&degrees), "{degrees}");
    let [soft, stiff] = [0, 1].map(|i| number(&format!("0/angle/coefficients/{i}")));
    let kappa = number("0/exact/kappa");
    assert!((stiff / soft / kappa - 1.0).abs() < 1e-12);
    let between = number("0/most_dispersive/angle/degrees");
    assert!(between < degrees && between > number("1/angle/degrees"));
    assert!(number("0/most_dispersive/leak") > 1e-3);
    // Its error is that of the ratio; the answer states both.
    let aside = number("0/most_dispersive/angle/degrees_error");
    let [low, high] = [between + aside, between - aside]
        .map(|degrees| stiffness_ratio(degrees, Ellipse::Approximate).unwrap());
    let [ratio, error] = ["kappa", "error"].map(|key| number(&format!("0/most_dispersive/{key}")));
    let stated = (high - low) / (2.0 * error * ratio);
    assert!((stated - 1.0).abs() < 0.1, "{low} {high} {stated}");
    let answer = table["answer"].as_str().unwrap();
    contains_all(
        answer,
        &["cylinders crossed at 7.", "lose most", "±", "degrees"],
    );
    let off = (number("0/direct/kappa") / kappa - 1.0).abs();
    assert!(off <= number("0/direct/error") && off < 1e-4);
}
