//! `cascade localize` as a stranger meets it.

use std::collections::BTreeSet;
use std::fs;

use test_support::contains_all;
use test_support::place::{Place, names, set};
use wavecascade::chain::contact::{Ellipse, stiffness_ratio};

/// The paper's direct values, to 1e-4.
#[test]
fn val_paper_a_table_and_its_json() {
    let place = Place::of(&["localize"]);
    let said = place.good(&[]);
    assert_eq!(said.lines().count(), 1 + 1 + 8, "{said}");
    let first = said.lines().next().unwrap();
    contains_all(first, &["localized waves", "4.927"]);
    contains_all(&said, &["exact ratio", "4.927226808384", "119.92"]);

    let table = place.says_json("--order 1..3 --json");
    let rows = table["orders"].as_array().unwrap();
    assert_eq!(rows.len(), 3);
    for (row, paper) in rows.iter().zip([1.0, 4.9272, 14.622]) {
        let exact = &row["exact"];
        let kappa = exact["kappa"].as_f64().unwrap();
        assert!((kappa / paper - 1.0).abs() < 1e-4, "{kappa}");
        for key in [
            "error",
            "digits",
            "residual",
            "iterations",
            "tail",
            "points",
            "period",
            "speed_coefficient",
            "width",
            "energy",
            "momentum",
        ] {
            assert!(exact[key].is_number(), "{key}: {row}");
        }
        assert!(exact["digits"].as_u64().unwrap() >= 10, "{row}");
        assert!(row["asymptotic"]["exact_profile"].is_number(), "{row}");
        assert!(row["asymptotic"]["fitted_profile"].is_number(), "{row}");
        assert!(row["direct"].is_null(), "{row}");
        assert!(row.get("reason").is_none(), "{row}");
        assert_eq!(row["published"]["direct"].as_f64(), Some(paper));
        let difference = &row["differences"]["published_direct"];
        assert_eq!(difference.as_f64(), Some(paper / kappa - 1.0));
    }
    let last = place.says_json("--order 19 --json");
    assert_eq!(last["orders"][0]["published"]["printed_order"], 18);
    assert_eq!(place.names(), BTreeSet::new());

    let mass = place.says_json("--alternation mass --order 2 --json");
    let ratio = mass["orders"][0]["exact"]["mass_ratio"].as_f64().unwrap();
    assert!((ratio - 0.3428).abs() < 1e-4 && mass["orders"][0]["published"].is_null());
}

#[test]
fn a_directory_with_the_table_and_the_waves_appears_whole() {
    let place = Place::of(&["localize"]);
    place.good(&["--order", "2..3", "--out", "waves", "--quiet"]);
    let expected = [
        "figures",
        "plot.py",
        "report.html",
        "summary.json",
        "table.csv",
        "wave-02.npz",
        "wave-03.npz",
    ];
    assert_eq!(names(&place.path("waves")), set(&expected));
    let summary = place.json("waves/summary.json");
    assert_eq!(summary["schema"], "cascade.localize/2");
    assert_eq!(summary["family"]["alternation"], "stiffness");
    assert_eq!(summary["orders"][1]["order"], 3);
    let table = place.read("waves/table.csv");
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let header = reader.headers().unwrap().clone();
    let records: Vec<csv::StringRecord> = reader.records().map(|r| r.unwrap()).collect();
    assert_eq!(records.len(), 2);
    let column = header.iter().position(|name| name == "ratio").unwrap();
    let kappa = summary["orders"][0]["exact"]["kappa"].as_f64().unwrap();
    assert_eq!(records[0][column].parse::<f64>().unwrap(), kappa);

    place.refuses_for(2, "--order 2 --out waves", "--force");
    place.good(&["--order", "2", "--out", "waves", "--force", "--quiet"]);
    assert!(!place.path("waves/wave-03.npz").exists());
    // Nothing else is replaced.
    fs::create_dir(place.path("mine")).unwrap();
    place.write("mine/notes.txt", "mine");
    place.bad(2, &["--order", "2", "--out", "mine", "--force"]);
    assert_eq!(place.read("mine/notes.txt"), "mine");
}

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

#[test]
fn val_chain_a_launched_wave_keeps_its_shape() {
    let place = Place::of(&["localize"]);
    let found = place.says_json("--launch 2 --cells 100 --out way --json");
    let launch = &found["launch"];
    let number = |key: &str| launch[key].as_f64().unwrap();
    assert_eq!(launch["cells"], 100);
    assert!(
        number("shape_change") < 5.0 * number("stepping_error"),
        "{launch}"
    );
    assert!(
        number("stepping_error") < 1e-10 && number("leak") < 1e-20,
        "{launch}"
    );
    assert_eq!(found, place.json("way/summary.json"));
    let expected = ["figures", "launch.npz", "report.html", "summary.json"];
    assert_eq!(names(&place.path("way")), set(&expected));
    let change = place.array::<f64>("way/launch.npz", "shape_change");
    assert_eq!((change.len(), change[99]), (100, number("shape_change")));
    let said = place.good(&["--launch", "1", "--cells", "5"]);
    contains_all(&said, &["travels 5 cells", "of its energy a cell"]);
}

/// Angles by the published form of the ellipse: 8 degrees are nearly those of order 2.
#[test]
fn val_paper_angles_of_localized_and_most_dispersive_waves() {
    let place = Place::of(&["localize"]);
    let words = "--order 2..3 --angles --material quartz --radius 9mm --cells 80 --json";
    let table = place.says_json(words);
    let rows = &table["orders"];
    let degrees = rows[0]["angle"]["degrees"].as_f64().unwrap();
    assert!((7.0..8.0).contains(&degrees), "{degrees}");
    let [soft, stiff] = [0, 1].map(|i| rows[0]["angle"]["coefficients"][i].as_f64().unwrap());
    let kappa = rows[0]["exact"]["kappa"].as_f64().unwrap();
    assert!((stiff / soft / kappa - 1.0).abs() < 1e-12);
    let most = &rows[0]["most_dispersive"];
    let between = most["angle"]["degrees"].as_f64().unwrap();
    assert!(between < degrees && between > rows[1]["angle"]["degrees"].as_f64().unwrap());
    assert!(most["leak"].as_f64().unwrap() > 1e-3);
    // Its error is that of the ratio; the answer states both.
    let [ratio, error] = [&most["kappa"], &most["error"]].map(|number| number.as_f64().unwrap());
    let aside = most["angle"]["degrees_error"].as_f64().unwrap();
    let [low, high] = [between + aside, between - aside]
        .map(|degrees| stiffness_ratio(degrees, Ellipse::Approximate).unwrap());
    let expected = 2.0 * error * ratio;
    assert!(
        ((high - low) / expected - 1.0).abs() < 0.1,
        "{low} {high} {expected}"
    );
    let answer = table["answer"].as_str().unwrap();
    contains_all(
        answer,
        &["cylinders crossed at 7.", "lose most", "±", "degrees"],
    );
    let direct = &rows[0]["direct"];
    let off = (direct["kappa"].as_f64().unwrap() / kappa - 1.0).abs();
    assert!(off <= direct["error"].as_f64().unwrap() && off < 1e-4);
}
