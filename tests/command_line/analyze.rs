//! `cascade analyze` as a stranger meets it: what it writes and prints, and where.

use std::collections::BTreeSet;
use std::fs;

use serde_json::{Value, json};
use test_support::contains_all;
use test_support::place::{Place, names, set, text};
use test_support::pulse;

const FIGURES: [&str; 8] = [
    "along-t",
    "along-x",
    "flux-surrogate",
    "short-time",
    "space-time",
    "spacetime-spectrum",
    "spatial-spectrum",
    "temporal-spectrum",
];

#[test]
fn a_run_leaves_a_result_and_names_its_report() {
    let place = pulse::place();
    let mut command = place.command(["analyze", "wave.npy", "--out", "new/result"]);
    let output = command.env("COLUMNS", "100").output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let said = text(&output.stdout);
    assert_eq!(place.names(), set(&["new", "wave.npy", "wave.toml"]));
    assert_eq!(names(&place.path("new")), set(&["result"]));
    let result = place.path("new/result");
    let page = "report.html";
    let expected = ["figures", "plot.py", page, "spectra.npz", "summary.json"];
    assert_eq!(names(&result), set(&expected));
    let pictures = FIGURES.iter().map(|f| format!("{f}.png"));
    assert_eq!(names(&result.join("figures")), pictures.collect());
    let last = said.lines().last().unwrap();
    assert!(last.ends_with("new/result/report.html"), "{last}");
    assert!(said.starts_with("wave: "), "{said}");
    assert!(said.lines().count() <= 12, "a dozen lines:\n{said}");
    let is_short = |line: &str| line.chars().count() <= 100;
    assert!(said.lines().all(is_short), "{said}");
    assert!(!said.contains('\x1b'), "{said}");
}

#[test]
fn the_summary_says_where_it_came_from_and_what_it_read() {
    let place = pulse::place();
    let line = "analyze wave.npy --figures none --sites 2:9 --json";
    let said = place.says(line);
    let file = place.read("wave-cascade/summary.json");
    assert_eq!(said.trim_end(), file.trim_end());
    let summary: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(summary["schema"], "cascade.analyze/4");
    let provenance = &summary["provenance"];
    let command = provenance["command"].as_array().unwrap();
    assert!(command[0].as_str().unwrap().ends_with("cascade"));
    let words: Vec<Value> = line.split(' ').map(Value::from).collect();
    assert_eq!(command[1..], words);
    assert_eq!(provenance["input"], "wave.npy");
    let hash = blake3::hash(&fs::read(place.path("wave.npy")).unwrap());
    assert_eq!(provenance["input_blake3"], hash.to_hex().as_str());
    let field = &summary["field"];
    for (key, expected) in [
        ("shape", json!([96, 7])),
        ("first", json!([0, 2])),
        ("dt", json!(0.01)),
        ("dx", json!(0.5)),
        ("x0", json!(1.0)),
    ] {
        assert_eq!(field[key], expected, "{key}");
    }
    assert_eq!(field["units"]["frequency"], "Hz");
    assert_eq!(field["units"]["wavenumber"], "rad/m");
    for part in ["time", "space", "spacetime"] {
        let residual = summary["parseval"][part].as_f64().unwrap();
        assert!(residual.abs() <= 1e-13, "{part}");
    }
    assert!(summary["direction"]["toward_plus_x"].as_f64().unwrap() > 0.5);
    assert_eq!(place.says("analyze wave.npy --quiet -o quiet"), "");
    assert!(place.path("quiet/report.html").exists());
}

#[test]
fn figures_are_those_asked_for() {
    let place = pulse::place();
    let base = "analyze wave.npy --only temporal,spatial --force --quiet";
    let kinds = |figures: &str| -> BTreeSet<String> {
        place.says(&format!("{base} --figures {figures}"));
        let folder = place.path("wave-cascade/figures");
        if !folder.exists() {
            return BTreeSet::new();
        }
        let ending = |name: String| name.rsplit('.').next().unwrap().to_owned();
        names(&folder).into_iter().map(ending).collect()
    };
    assert_eq!(kinds("png"), set(&["png"]));
    assert_eq!(kinds("svg,svg"), set(&["svg"]));
    assert_eq!(kinds("svg,png"), set(&["png", "svg"]));
    assert_eq!(kinds("none"), set(&[]));
    let drawn = |options: &str| {
        place.says(&format!("{base} --figures svg {options}"));
        let folder = place.path("wave-cascade/figures");
        fs::read_to_string(folder.join("temporal-spectrum.svg")).unwrap()
    };
    let paper = drawn("--style paper --figure-size 8.6x7cm --db 40");
    contains_all(&paper, &["width=\"86.00mm\" height=\"70.00mm\"", "dB re"]);
    assert!(drawn("--colormap gray") != drawn(""));
}

#[test]
fn only_what_is_asked_for_is_there() {
    let place = pulse::place();
    let all = [
        ("temporal", "temporal_spectrum"),
        ("spatial", "spatial_spectrum"),
        ("spacetime", "spacetime_spectrum"),
        ("flux", "kinetic_flux_surrogate"),
        ("short-time", "short_time_spectrum"),
    ];
    for (only, array) in all {
        place.says(&format!(
            "analyze wave.npy --force --figures none --only {only}"
        ));
        let found = place.arrays("wave-cascade/spectra.npz");
        for axis in ["time", "position", "frequency", "wavenumber"] {
            assert!(found.contains(axis), "{only}: {found:?}");
        }
        for (_, other) in all {
            assert_eq!(found.contains(other), other == array, "{only}: {other}");
        }
    }
}

#[test]
fn a_plan_writes_nothing() {
    let place = pulse::place();
    let before = place.names();
    let said = place.says("analyze wave.npy --plan");
    contains_all(&said, &["memory", "threads"]);
    let json = place.says("analyze wave.npy --plan --json --threads 3");
    let plan: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(plan["arrays"]["temporal_spectrum"], json!([49, 12]));
    assert_eq!(plan["threads"], 3);
    assert_eq!(plan["times"], json!([0, 96]));
    assert_eq!(place.names(), before);
}

#[test]
fn a_result_is_replaced_only_by_force() {
    let place = pulse::place();
    let line = "analyze wave.npy --figures none --out result";
    fs::create_dir(place.path("result")).unwrap();
    place.says(line);
    let stamp = || place.read("result/summary.json");
    let first = stamp();
    assert!(place.refuses(2, line).contains("--force"));
    assert_eq!(stamp(), first);
    place.says(&format!("{line} --force --only spatial"));
    assert_ne!(stamp(), first);
    assert_eq!(place.names(), set(&["result", "wave.npy", "wave.toml"]));

    // What no run has written is not removed, force or not.
    place.write("result/notes.txt", "mine");
    for taken in ["result", "wave.npy"] {
        place.refuses_for(2, &format!("analyze wave.npy --force --out {taken}"), taken);
    }
    for nameless in [".", "..", "/"] {
        let said = place.refuses(2, &format!("analyze wave.npy --force --out {nameless}"));
        assert!(said.contains("--out"), "{said}");
    }
}

#[test]
fn pictures_end_where_they_are_told_and_say_what_they_leave_out() {
    let place = pulse::place();
    let picture = |options: &str| {
        place.says(&format!("analyze wave.npy --force --figures svg {options}"));
        let figure = place.path("wave-cascade/figures/spacetime-spectrum.svg");
        fs::read_to_string(figure).unwrap()
    };
    // The pulse has energy about 11 Hz of the 50 Hz there are.
    assert!(picture("").contains("of the energy above "));
    let whole = picture("--show-frequency all --show-wavenumber all");
    assert!(!whole.contains("not shown"));
    let part = picture("--show-frequency 10Hz:20Hz --show-wavenumber 4");
    assert!(part.contains("% below 10.4 Hz"), "{part}");
    assert!(part.contains("above 19.8 Hz") && part.contains("beyond ±3.14 rad/m"));
    let [part, whole] = ["20ms:", "all"].map(|time| {
        picture(&format!("--show-time {time} --show-space 1m:4m"));
        place.array::<f64>("wave-cascade/spectra.npz", "spacetime_spectrum")
    });
    assert_eq!(part, whole);
}

/// Cells within six decades of the largest reach over half of both axes.
#[test]
fn pictures_of_the_shipped_scenes_are_filled() {
    let scenes = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/scenes");
    let place = Place::new();
    for scene in ["dimer", "quartz_cylinders"] {
        let path = scenes.join(format!("{scene}.toml"));
        let path = path.to_str().unwrap();
        place.good(&["simulate", path, "--out", "run.npz", "--force"]);
        let field = test_support::made::open(&place, "run.npz");
        let request = wavecascade::analyze::Request::default();
        let (analysis, _) = wavecascade::analyze(&field, &request).unwrap();
        let map = analysis.spacetime_map.as_ref().unwrap().shown();
        let level = 1e-6 * map.values.iter().copied().fold(0.0, f32::max);
        let (rows, columns) = map.values.dim();
        let (mut top, mut left, mut right) = (0, columns, 0);
        for ((row, column), value) in map.values.indexed_iter() {
            if *value > level {
                top = top.max(row + 1);
                (left, right) = (left.min(column), right.max(column + 1));
            }
        }
        assert!(2 * top > rows, "{scene}: {top} of {rows}");
        let width = right - left;
        assert!(2 * width > columns, "{scene}: {width} of {columns}");
        assert!(rows > 60 && columns > 20, "{scene}: {rows} x {columns}");
    }
}

/// The commands that an analysis names at its end, with its options of reading; some need one more word.
#[test]
fn regress_what_is_left_open_is_named_with_commands_that_run() {
    let place = Place::new();
    place.save("noise.npy", &test_support::fields::noise(1024, 20));
    let said = place.says("analyze noise.npy --rate 1kHz --figures none --verbose");
    contains_all(&said, &["cascade COMMAND noise.npy --rate 1kHz\n"]);
    for name in ["ridges", "spectrum", "coherence", "bicoherence"] {
        assert!(said.contains(name), "{name}\n{said}");
        let line = format!("{name} noise.npy --rate 1kHz --figures none --quiet");
        let words: Vec<&str> = line.split(' ').collect();
        assert_eq!(place.run(&words).status.code(), Some(0), "{name}");
    }
    // One pulse has no intervals: repeated records are named.
    let said = pulse::place().says("analyze wave.npy --figures none --verbose");
    assert!(said.contains("repeated"), "{said}");
    assert!(!said.contains("coherence wave.npy"), "{said}");
}
