//! `cascade analyze` of several fields in one call.

use std::fs;

use serde_json::Value;
use test_support::place::{Place, names, set, text};
use test_support::pulse::{SIDECAR, wave};

/// Three fields, of which the last is none.
fn fields() -> Place {
    let place = Place::new();
    for name in ["one", "two"] {
        place.save(&format!("{name}.npy"), &wave(96, 12));
        fs::write(place.path(format!("{name}.toml")), SIDECAR).unwrap();
    }
    fs::write(place.path("bad.npy"), "no array").unwrap();
    place
}

fn index(place: &Place, out: &str) -> Vec<Value> {
    let index = place.json(&format!("{out}/index.json"));
    assert_eq!(index["schema"], "cascade.fields/2");
    index["fields"].as_array().unwrap().clone()
}

#[test]
fn each_field_has_a_directory_and_one_page_lists_them() {
    let place = fields();
    let mut command = place.command(["analyze", "one.npy", "bad.npy", "two.npy", "--out", "all"]);
    let output = command.env_remove("COLUMNS").output().unwrap();
    let (said, told) = (text(&output.stderr), text(&output.stdout));
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("error: 1 of 3 fields have no result"),
        "{said}"
    );
    assert!(
        told.starts_with("3 fields: 2 ") && told.contains(", 1 without a result\n"),
        "{told}"
    );
    for word in ["one", "two", "all/index.html"] {
        assert!(told.contains(word), "{word}: {told}");
    }
    for word in ["bad.npy: expected", "numpy.save"] {
        assert!(
            told.contains(word) || said.contains(word),
            "{word}: {told}{said}"
        );
    }
    assert!(told.lines().count() <= 12, "{told}");
    assert!(
        told.lines().all(|line| line.chars().count() <= 80),
        "{told}"
    );
    let expected = ["headlines.csv", "index.html", "index.json", "one", "two"];
    assert_eq!(names(&place.path("all")), set(&expected));
    // The results are those of single calls.
    place.good(&["analyze", "one.npy", "--out", "single", "--quiet"]);
    let spectra = |place: &Place, of: &str| fs::read(place.path(of).join("spectra.npz")).unwrap();
    assert_eq!(spectra(&place, "all/one"), spectra(&place, "single"));
    let page = fs::read_to_string(place.path("all/index.html")).unwrap();
    for word in [
        "href=\"one/report.html\"",
        "href=\"two/report.html\"",
        "bad.npy",
    ] {
        assert!(page.contains(word), "{word}");
    }
    assert!(page.len() < 40_000, "{} bytes", page.len());

    let rows = index(&place, "all");
    let headlines = &rows[0]["headlines"];
    let summary = place.json("all/one/summary.json");
    assert_eq!(
        headlines["toward_plus_x"],
        summary["answer"]["direction"]["toward_plus_x"]
    );
    for (kind, numbers) in [
        (
            "frequency",
            &["verdict", "up", "up_at", "down", "down_at"][..],
        ),
        ("wavenumber", &["verdict", "up", "down", "reason"]),
    ] {
        for number in numbers {
            let answer = &summary["answer"][kind][number];
            assert_eq!(&headlines[kind][number], answer, "{kind} {number}");
        }
    }
    let frequency = &summary["answer"]["frequency"];
    for number in ["energy_ratio", "from", "to"] {
        assert_eq!(headlines[number], frequency[number], "{number}");
    }
    assert!(rows[1]["failed"].as_str().unwrap().contains("bad.npy"));
    let table = fs::read_to_string(place.path("all/headlines.csv")).unwrap();
    assert_eq!(table.lines().count(), 4, "{table}");
    assert!(
        table.starts_with("field,name,times,sites,frequency_unit,"),
        "{table}"
    );
}

#[test]
fn results_are_replaced_as_a_whole_and_only_if_asked_for() {
    let place = fields();
    let base = [
        "analyze",
        "one.npy",
        "two.npy",
        "--out",
        "all",
        "--figures",
        "none",
        "--quiet",
    ];
    place.good(&base);
    assert!(place.bad(2, &base).contains("--force"));
    let words = [
        "analyze",
        "two.npy",
        "bad.npy",
        "--out",
        "all",
        "--figures",
        "none",
        "--force",
    ];
    let output = place.run(&[&words[..], &["--quiet"]].concat());
    assert_eq!(output.status.code(), Some(1));
    assert!(
        text(&output.stderr).contains("error: bad.npy: expected"),
        "{output:?}"
    );
    let expected = ["headlines.csv", "index.html", "index.json", "two"];
    assert_eq!(names(&place.path("all")), set(&expected));
    let index_page = fs::read_to_string(place.path("all/index.html")).unwrap();
    assert!(
        index_page.contains("href=\"two/summary.json\""),
        "without figures there is no page"
    );
    // What somebody else has put there is not ours.
    fs::write(place.path("all/notes.txt"), "mine").unwrap();
    assert!(place.bad(2, &words).contains("notes.txt"));
    fs::create_dir(place.path("data")).unwrap();
    fs::write(place.path("data/notes.txt"), "mine").unwrap();
    let words = ["analyze", "one.npy", "two.npy", "--out", "data", "--force"];
    assert!(place.bad(2, &words).contains("data"));
    // Where nothing succeeds, nothing is left.
    fs::write(place.path("worse.npy"), "no array").unwrap();
    let output = place.run(&["analyze", "bad.npy", "worse.npy"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(!place.path("fields-cascade").exists());
}

#[test]
fn patterns_that_a_shell_has_left_are_expanded() {
    let place = fields();
    fs::remove_file(place.path("bad.npy")).unwrap();
    place.good(&["analyze", "*.npy", "--figures", "none", "--quiet"]);
    assert_eq!(index(&place, "fields-cascade").len(), 2);
    // One file is a field as if its name were typed.
    place.good(&["analyze", "on?.npy", "--figures", "none", "--quiet"]);
    assert!(place.path("one-cascade/summary.json").exists());
    for pattern in ["*.bogus", "[.npy"] {
        let said = place.bad(2, &["analyze", pattern]);
        assert!(said.contains(pattern) && said.contains("help: "), "{said}");
    }
}

#[test]
fn fields_of_one_name_get_that_of_their_folders() {
    let place = fields();
    for folder in ["a", "b", "b/c"] {
        fs::create_dir(place.path(folder)).unwrap();
        fs::copy(place.path("one.npy"), place.path(folder).join("one.npy")).unwrap();
    }
    let words = [
        "analyze",
        "a/one.npy",
        "b/one.npy",
        "b/c/one.npy",
        "two.npy",
    ];
    place.good(&[&words[..], &["--figures", "none", "--quiet"]].concat());
    let found: Vec<Value> = index(&place, "fields-cascade");
    let found: Vec<&str> = found
        .iter()
        .map(|row| row["name"].as_str().unwrap())
        .collect();
    assert_eq!(found, ["a-one", "b-one", "c-one", "two"]);
    for twice in [["one.npy", "./one.npy"], ["a/one.npy", "b/../a/one.npy"]] {
        let said = place.bad(2, &[&["analyze"][..], &twice].concat());
        assert!(said.contains("twice"), "{said}");
    }
}

#[test]
fn several_fields_are_planned_one_by_one() {
    let place = fields();
    let plans = place.good(&["analyze", "one.npy", "two.npy", "--plan"]);
    assert!(
        plans.contains("one.npy\n") && plans.contains("two.npy\n"),
        "{plans}"
    );
}
