//! Scenes that say too little, too much, or what cannot be: each fault names file, line and key.

use std::fs;
use std::process::Output;

use assert_cmd::Command;

/// A good scene of two lines.
const GOOD: &str = "sites = 8\nend_time = 4.0\n";
/// A good one in SI, of six lines.
const SI: &str = "sites = 8\nmaterial = 'quartz'\nradius = '9 mm'\nlength = '18 mm'\nangle = 30\n\
                  striker_velocity = 0.88\n";

/// The table of faults, a row each.
const FAULTS: &str = include_str!("scene_faults.txt");

/// Base, lines after it, line at fault, key, words of the message.
fn faults() -> impl Iterator<Item = [&'static str; 5]> {
    let rows = FAULTS
        .lines()
        .filter(|row| !row.is_empty() && !row.starts_with('#'));
    rows.map(|row| {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        cells.try_into().unwrap_or_else(|cells| panic!("{cells:?}"))
    })
}

fn simulate(place: &std::path::Path, words: &[&str]) -> Output {
    let mut command = Command::cargo_bin("cascade").unwrap();
    command.current_dir(place).arg("simulate").args(words);
    command.output().unwrap()
}

#[test]
fn every_fault_is_named_with_file_line_and_key() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("scene.toml");
    let mut wrong = Vec::new();
    for [base, more, line, key, words] in faults() {
        let base = base.replace("GOOD", GOOD).replace("SI", SI);
        let text = format!("{base}{more}\n").replace("\\n", "\n");
        fs::write(&path, &text).unwrap();
        let output = simulate(place.path(), &["scene.toml", "--out", "run.npz"]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let line = match line {
            "0" => String::new(),
            line => format!("{line}:"),
        };
        let start = format!("error: scene.toml:{line} {key}");
        // What follows the key ends it, or names a part of it.
        let rest = said.strip_prefix(&start);
        let named = rest.is_some_and(|rest| key.is_empty() || rest.starts_with([':', '[', '.']));
        let good = output.status.code() == Some(2) && named && said.contains(words);
        if !good || said.contains("panicked") {
            wrong.push(format!("{text}expected {start} ... {words}\nsaid {said}"));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} of {}:\n{}",
        wrong.len(),
        faults().count(),
        wrong.join("\n")
    );
    let names: Vec<_> = fs::read_dir(place.path()).unwrap().collect();
    assert_eq!(names.len(), 1, "only the scene is there");
}

#[test]
fn files_that_are_no_scenes_are_refused() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(place.path().join(name), bytes).unwrap();
    write("binary.toml", &[0xff, 0xfe, 0, 1]);
    write("empty.toml", b"");
    write(
        "deep.toml",
        format!("a = {}", "[".repeat(100_000)).as_bytes(),
    );
    write(
        "dots.toml",
        format!("{}b = 1", "a.".repeat(100_000)).as_bytes(),
    );
    write("long.toml", "# comment\n".repeat(1_000_000).as_bytes());
    fs::create_dir(place.path().join("folder.toml")).unwrap();
    for (name, code) in [
        ("binary.toml", 2),
        ("empty.toml", 2),
        ("deep.toml", 2),
        ("dots.toml", 2),
        ("long.toml", 2),
        ("folder.toml", 1),
        ("absent.toml", 1),
    ] {
        let output = simulate(place.path(), &[name]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{name}: {said}");
        assert!(said.starts_with("error: "), "{name}: {said}");
        assert!(said.contains(name) && said.len() < 1000, "{name}: {said}");
    }
}
