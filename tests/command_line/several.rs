//! `cascade analyze` of several fields in one call.

use std::fs;

use serde_json::Value;
use test_support::contains_all;
use test_support::place::{Place, names, set, text};
use test_support::pulse::{SIDECAR, wave};

/// Three fields, of which the last is none.
fn fields() -> Place {
    let place = Place::new();
    for name in ["one", "two"] {
        place.save(&format!("{name}.npy"), &wave(96, 12));
        place.write(format!("{name}.toml"), SIDECAR);
    }
    place.write("bad.npy", "no array");
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
    assert!(said.contains("1 of 3 fields"), "{said}");
    contains_all(&told, &["one", "two", "all/index.html"]);
    assert!(told.lines().count() <= 12, "{told}");
    let is_short = |line: &str| line.chars().count() <= 80;
    assert!(told.lines().all(is_short), "{told}");
    let expected = ["headlines.csv", "index.html", "index.json", "one", "two"];
    assert_eq!(names(&place.path("all")), set(&expected));
    // The results are those of single calls.
    place.says("analyze one.npy --out single --quiet");
    let spectra = |of: &str| fs::read(place.path(of).join("spectra.npz")).unwrap();
    assert_eq!(spectra("all/one"), spectra("single"));
    let page = place.read("all/index.html");
    for word in ["href=\"one/report.html\"", "href=\"two/report.html\""] {
        assert!(page.contains(word), "{word}");
    }
    assert!(page.len() < 40_000, "{} bytes", page.len());

    let rows = index(&place, "all");
    let headlines = &rows[0]["headlines"];
    let answer = &place.json("all/one/summary.json")["moved"];
    let direction = &answer["direction"]["toward_plus_x"];
    assert_eq!(&headlines["toward_plus_x"], direction);
    for kind in ["frequency", "wavenumber"] {
        for number in ["verdict", "up", "down"] {
            let found = &headlines[kind][number];
            assert_eq!(found, &answer[kind][number], "{kind} {number}");
        }
    }
    assert!(rows[1]["failed"].as_str().unwrap().contains("bad.npy"));
    let table = place.read("all/headlines.csv");
    assert_eq!(table.lines().count(), 4, "{table}");
}

#[test]
fn results_are_replaced_as_a_whole_and_only_if_asked_for() {
    let place = fields();
    let line = "analyze one.npy two.npy --out all --figures none --quiet";
    place.says(line);
    assert!(place.refuses(2, line).contains("--force"));
    let again = "analyze two.npy bad.npy --out all --figures none --force";
    let words: Vec<&str> = again.split(' ').collect();
    assert_eq!(place.run(&words).status.code(), Some(1));
    let expected = ["headlines.csv", "index.html", "index.json", "two"];
    assert_eq!(names(&place.path("all")), set(&expected));
    // What somebody else has put there is not ours.
    place.write("all/notes.txt", "mine");
    assert!(place.refuses(2, again).contains("notes.txt"));
    // Where nothing succeeds, nothing is left.
    place.write("worse.npy", "no array");
    let output = place.run(&["analyze", "bad.npy", "worse.npy"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(!place.path("fields-cascade").exists());
}

#[test]
fn patterns_that_a_shell_has_left_are_expanded() {
    let place = fields();
    fs::remove_file(place.path("bad.npy")).unwrap();
    place.says("analyze *.npy --figures none --quiet");
    assert_eq!(index(&place, "fields-cascade").len(), 2);
    // One file is a field as if its name were typed.
    place.says("analyze on?.npy --figures none --quiet");
    assert!(place.path("one-cascade/summary.json").exists());
    let plans = place.says("analyze one.npy two.npy --plan");
    contains_all(&plans, &["one.npy\n", "two.npy\n"]);
}

#[test]
fn fields_of_one_name_get_that_of_their_folders() {
    let place = fields();
    for folder in ["a", "b", "b/c"] {
        fs::create_dir(place.path(folder)).unwrap();
        fs::copy(place.path("one.npy"), place.path(folder).join("one.npy")).unwrap();
    }
    place.says("analyze a/one.npy b/one.npy b/c/one.npy two.npy --figures none --quiet");
    let found = index(&place, "fields-cascade");
    let found: Vec<&Value> = found.iter().map(|row| &row["name"]).collect();
    assert_eq!(found, ["a-one", "b-one", "c-one", "two"]);
    for twice in ["one.npy ./one.npy", "a/one.npy b/../a/one.npy"] {
        place.refuses_for(2, &format!("analyze {twice}"), "twice");
    }
}
