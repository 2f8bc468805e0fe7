//! Scenes that say too little, too much, or what cannot be: each fault names file, line and key.

use test_support::place::Place;
use test_support::scenes::rows;

/// A good scene of two lines.
const GOOD: &str = "sites = 8\nend_time = 4.0\n";
/// A good one in SI, of six lines.
const SI: &str = "sites = 8\nmaterial = 'quartz'\nradius = '9 mm'\nlength = '18 mm'\nangle = 30\n\
                  striker_velocity = 0.88\n";

#[test]
fn every_fault_is_named_with_file_line_and_key() {
    let place = Place::new();
    let mut wrong = Vec::new();
    for [base, more, line, key, words] in rows(include_str!("scene_faults.txt")) {
        let base = base.replace("GOOD", GOOD).replace("SI", SI);
        let text = format!("{base}{more}\n");
        place.write("scene.toml", &text);
        let said = place.refuses(2, "simulate scene.toml --out run.npz");
        let line = match line.as_str() {
            "0" => String::new(),
            line => format!("{line}:"),
        };
        let start = format!("error: scene.toml:{line} {key}");
        // What follows the key ends it, or names a part of it.
        let rest = said.strip_prefix(&start);
        let named = rest.is_some_and(|rest| key.is_empty() || rest.starts_with([':', '[', '.']));
        if !named || !said.contains(&words) {
            wrong.push(format!("{text}expected {start} ... {words}\nsaid {said}"));
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn files_that_are_no_scenes_are_refused() {
    let place = Place::new();
    std::fs::create_dir(place.path("folder.toml")).unwrap();
    for (name, bytes) in [
        ("binary.toml", vec![0xff, 0xfe, 0, 1]),
        ("empty.toml", Vec::new()),
        (
            "deep.toml",
            format!("a = {}", "[".repeat(100_000)).into_bytes(),
        ),
        (
            "dots.toml",
            format!("{}b = 1", "a.".repeat(100_000)).into_bytes(),
        ),
        ("long.toml", "# comment\n".repeat(1_000_000).into_bytes()),
    ] {
        place.write(name, bytes);
    }
    for (code, name) in [
        (2, "binary.toml"),
        (2, "empty.toml"),
        (2, "deep.toml"),
        (2, "dots.toml"),
        (2, "long.toml"),
        (1, "folder.toml"),
        (1, "absent.toml"),
    ] {
        let said = place.refuses(code, &format!("simulate {name}"));
        assert!(said.contains(name) && said.len() < 1000, "{name}: {said}");
    }
}
