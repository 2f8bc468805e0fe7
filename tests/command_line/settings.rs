//! Settings files: options that are kept beside a field or in the home configuration.

use std::fs;
use std::process::Output;

use serde_json::Value;
use test_support::place::{Place, names, set, text};

const BASE: [&str; 4] = ["analyze", "wave.npy", "--force", "--json"];

fn summary(output: &Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn analyzed(place: &Place, words: &[&str]) -> Value {
    summary(&place.run(&[&BASE[..], words].concat()))
}

/// The options in effect, each as `key = value: what states it`.
fn in_effect(summary: &Value) -> Vec<String> {
    let settings = summary["provenance"]["settings"].as_array();
    let settings = settings.into_iter().flatten();
    let word = |setting: &Value, key: &str| setting[key].as_str().unwrap().to_owned();
    settings
        .map(|one| {
            let [option, value, by] = ["option", "value", "stated_by"].map(|key| word(one, key));
            format!("{option} = {value}: {by}")
        })
        .collect()
}

#[test]
fn a_file_beside_the_field_sets_options_and_what_is_typed_wins() {
    let place = test_support::pulse::place();
    let settings = "segment = 32\nwindow_time = \"hann\"\n\nfigures = \"none\"\n\
                    only = [\"temporal\", \"spatial\"]\n";
    fs::write(place.path("analysis.toml"), settings).unwrap();
    let output = place.run(&BASE);
    let said = text(&output.stderr);
    assert_eq!(
        said,
        "note: settings of analysis.toml: segment, window_time, figures, only\n"
    );
    let found = summary(&output);
    assert_eq!(found["conventions"]["segment"], 32);
    assert_eq!(found["conventions"]["window"]["time"]["name"], "hann");
    assert!(!place.path("wave-cascade/report.html").exists());
    let expected = [
        "window_time = hann: analysis.toml:2",
        "segment = 32: analysis.toml:1",
        "only = temporal,spatial: analysis.toml:5",
        "figures = none: analysis.toml:4",
    ];
    assert_eq!(in_effect(&found), expected);

    let found = analyzed(&place, &["--segment", "48"]);
    assert_eq!(found["conventions"]["segment"], 48);
    assert!(in_effect(&found).contains(&"segment = 48: command line".to_owned()));
    // The same numbers as with the options on the command line.
    let words = [
        "--settings",
        "none",
        "--segment",
        "32",
        "--window-time",
        "hann",
        "--figures",
        "none",
        "--only",
        "temporal,spatial",
    ];
    let output = place.run(&[&BASE[..], &words].concat());
    assert_eq!(text(&output.stderr), "");
    let [mut typed, mut kept] = [summary(&output), analyzed(&place, &[])];
    for summary in [&mut typed, &mut kept] {
        summary["provenance"].take();
        summary["timings"].take();
    }
    assert_eq!(typed, kept);
}

#[test]
fn what_excludes_a_typed_option_has_no_effect() {
    let place = test_support::pulse::place();
    fs::write(place.path("a.toml"), "dt = 0.02\nfigures = 'none'\n").unwrap();
    let found = analyzed(&place, &["--settings", "a.toml", "--rate", "200"]);
    assert_eq!(found["field"]["dt"], 0.005);
    // A threshold needs `until_arrival`, which the typed times exclude.
    let settings = "until_arrival = true\narrival_threshold = 0.02\nfigures = 'none'\n";
    fs::write(place.path("a.toml"), settings).unwrap();
    let cut = analyzed(&place, &["--settings", "a.toml"]);
    assert!(cut["field"]["shape"][0].as_u64().unwrap() < 96);
    let found = analyzed(&place, &["--settings", "a.toml", "--times", "0:"]);
    assert_eq!(found["field"]["shape"][0], 96);
}

/// Faults with their line, and what the message must hold.
#[test]
fn faults_are_named_with_file_line_and_key() {
    let place = test_support::pulse::place();
    for (settings, line, holds) in [
        (
            "\nsegmnt = 3",
            2,
            &["segmnt: expected a key", "(`segment`?)"][..],
        ),
        ("window-time = 'hann'", 1, &["(`window_time`?)"]),
        (
            "colour = 3",
            1,
            &["colour: expected a key of analysis settings, found"],
        ),
        (
            "dx = '2ms'",
            1,
            &["dx: expected a finite number above 0", "mm", "\"2ms\""],
        ),
        ("dx = [1, 2]", 1, &["dx: expected one value, found [1, 2]"]),
        (
            "layout = 'sideways'",
            1,
            &["layout: expected one of time-site, site-time"],
        ),
        (
            "segment = 'many'",
            1,
            &["segment: expected a whole number", "\"many\""],
        ),
        (
            "segment = 4.5",
            1,
            &["segment: expected a whole number", "4.5"],
        ),
        (
            "threads = 0",
            1,
            &["threads: expected a whole number", "1..=1024", "found 0"],
        ),
        (
            "until_arrival = 1",
            1,
            &["until_arrival: expected true or false, found 1"],
        ),
        (
            "only = []",
            1,
            &["only: expected a list of one value or more"],
        ),
        (
            "only = ['temporal', {}]",
            1,
            &["only: expected a text, a number, or a list"],
        ),
        ("[bands]\nnoise = 1", 1, &["bands: expected a key"]),
        ("dt = 1\nrate = 2", 2, &["expected it or `", "found both"]),
        (
            "overlap = 0.5",
            1,
            &["overlap: expected `segment` beside it, found it alone"],
        ),
        ("out = 'x'", 1, &["out: expected it on the command line"]),
        (
            "settings = 'x'",
            1,
            &["settings: expected it on the command line"],
        ),
        (
            "force = true",
            1,
            &["force: expected it on the command line"],
        ),
        ("dt = ", 1, &["a.toml:1"]),
        (
            "figures = 'none'\nsegment = 97",
            2,
            &["segment: expected 1 to 96", "97"],
        ),
        (
            "figures = ['none', 'png']",
            1,
            &["figures: expected formats"],
        ),
        (
            "\nonly = 'spatial'\nsegment = 16",
            3,
            &["segment: expected `temporal`"],
        ),
    ] {
        fs::write(place.path("a.toml"), settings).unwrap();
        let said = place.bad(2, &["analyze", "wave.npy", "--settings", "a.toml"]);
        let line_is_named = said.contains(&format!("a.toml:{line}:"))
            // Either of two that exclude each other.
            || settings.starts_with("dt = 1\n") && said.contains("a.toml:1:");
        assert!(line_is_named, "{settings}: {said}");
        for word in holds {
            assert!(said.contains(word), "{settings}: {word:?} not in {said}");
        }
        assert!(said.contains("help: "), "{said}");
    }
    let said = place.bad(1, &["analyze", "wave.npy", "--settings", "missing.toml"]);
    assert!(
        said.contains("missing.toml") && said.contains("help: "),
        "{said}"
    );
    fs::write(place.path("a.toml"), b"dt = '\xff'").unwrap();
    let said = place.bad(2, &["analyze", "wave.npy", "--settings", "a.toml"]);
    assert!(said.contains("a.toml: expected text in UTF-8"), "{said}");
    // A fault of what is typed remains one.
    fs::write(place.path("a.toml"), "segment = 16").unwrap();
    let said = place.bad(
        2,
        &["analyze", "wave.npy", "--settings", "a.toml", "--dx", "-1"],
    );
    assert!(
        said.contains("'-1' for '--dx") && !said.contains("a.toml"),
        "{said}"
    );
}

#[test]
fn styles_beside_the_field_and_at_home_are_used_in_this_order() {
    let place = test_support::pulse::place();
    let home = place.path("home");
    fs::create_dir_all(home.join("cascade")).unwrap();
    let formats = |words: &[&str]| {
        let mut command = place.command([&["analyze", "wave.npy", "--force"][..], words].concat());
        let output = command.env("XDG_CONFIG_HOME", &home).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let figures = place.path("wave-cascade/figures");
        let drawn = if figures.exists() {
            names(&figures)
        } else {
            set(&[])
        };
        let ends = |with: &str| drawn.iter().any(|name| name.ends_with(with));
        ([ends("png"), ends("svg")], text(&output.stderr))
    };
    assert_eq!(formats(&[]), ([true, true], String::new()));
    fs::write(home.join("cascade/style.toml"), "figures = 'svg'\n").unwrap();
    assert_eq!(formats(&[]), ([false, true], String::new()));
    fs::write(place.path("style.toml"), "figures = ['png']\n").unwrap();
    let note = "note: settings of style.toml: figures\n";
    assert_eq!(formats(&[]), ([true, false], note.to_owned()));
    fs::write(place.path("analysis.toml"), "figures = ['png', 'svg']\n").unwrap();
    assert_eq!(formats(&[]).0, [true, true]);
    assert_eq!(formats(&["--figures", "svg"]).0, [false, true]);
    assert_eq!(formats(&["--figures", "none"]).0, [false, false]);
    fs::remove_file(place.path("analysis.toml")).unwrap();
    fs::remove_file(place.path("style.toml")).unwrap();

    // A budget has the style, too, and other commands do not mind a faulty one.
    let run = "simulate --sites 4 --end-time 4 --samples 65 --quiet --out run.npz";
    place.good(&run.split(' ').collect::<Vec<_>>());
    let with_home = |words: &[&str]| {
        place
            .command(words)
            .env("XDG_CONFIG_HOME", &home)
            .output()
            .unwrap()
    };
    assert_eq!(
        with_home(&["budget", "run.npz", "--quiet"]).status.code(),
        Some(0)
    );
    assert!(
        names(&place.path("run-budget/figures"))
            .iter()
            .all(|name| name.ends_with("svg"))
    );
    fs::write(home.join("cascade/style.toml"), "figures = 'gif'\n").unwrap();
    for words in [
        &["analyze", "wave.npy", "--force"][..],
        &["budget", "run.npz", "--force"],
    ] {
        let output = with_home(words);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            said.contains("cascade/style.toml:1: figures: expected one of"),
            "{said}"
        );
    }
    fs::write(home.join("cascade/style.toml"), "segment = 3\n").unwrap();
    let said = text(&with_home(&["analyze", "wave.npy", "--force"]).stderr);
    assert!(
        said.contains("a key of styles; those of analyses stand in"),
        "{said}"
    );
    assert_eq!(with_home(&["scene"]).status.code(), Some(0));
}

#[test]
fn a_sidecar_of_that_name_is_no_settings_file() {
    let place = Place::new();
    place.save("analysis.npy", &test_support::pulse::wave(96, 12));
    fs::write(place.path("analysis.toml"), "dt = 0.5\ndx = 2.0\n").unwrap();
    let said = place.good(&["analyze", "analysis.npy", "--figures", "none"]);
    assert!(said.contains("dt 0.5"), "{said}");
}

#[test]
fn template_schema_and_check_know_every_option() {
    let place = test_support::pulse::place();
    let template = place.good(&["settings"]);
    let keys = |template: &str| -> Vec<String> {
        let lines = template.lines().filter_map(|line| line.strip_prefix('#'));
        let keys = lines.filter(|line| line.starts_with(|c: char| c.is_ascii_lowercase()));
        let keys = keys.filter_map(|line| Some(line.split_once(" = ")?.0.to_owned()));
        keys.collect()
    };
    let known = keys(&template);
    let schema: Value = serde_json::from_str(&place.good(&["settings", "--schema"])).unwrap();
    let properties = schema["properties"].as_object().unwrap();
    assert_eq!(properties.keys().cloned().collect::<Vec<_>>(), known);
    // Every option of the help is a key, but for those of a call.
    let help = place.good(&["analyze", "--help"]);
    let words = help.split_whitespace();
    let options = words.filter_map(|word| word.strip_prefix("--"));
    let name = |option: &str| {
        option
            .trim_end_matches(|c: char| !c.is_alphanumeric())
            .to_owned()
    };
    for option in options
        .map(name)
        .filter(|option| help.contains(&format!("  --{option}")))
    {
        let of_a_call = [
            "settings", "out", "force", "plan", "json", "quiet", "max-time", "help",
        ];
        let of_a_scan = [
            "position-from",
            "channel",
            "reference",
            "least-correlation",
            "equal-positions",
        ];
        let is_key = known.contains(&option.replace('-', "_"));
        let is_none = of_a_call.contains(&&*option) || of_a_scan.contains(&&*option);
        assert!(is_key || is_none, "{option}");
    }
    // Defaults and examples are accepted, one by one: some exclude each other.
    let lines: Vec<&str> = template
        .lines()
        .filter_map(|line| line.strip_prefix('#'))
        .collect();
    let mut before = "";
    for line in lines {
        let is_key = known
            .iter()
            .any(|key| line.starts_with(&format!("{key} = ")));
        if is_key && !before.ends_with("Form:") {
            let needed = match line.split_once(" = ").unwrap().0 {
                "overlap" => "segment = 16\n",
                // Letters of papers are small enough for a column.
                "figure_size" => "style = \"paper\"\n",
                "arrival_threshold" => "until_arrival = true\n",
                "short_space_segment" | "short_space_hop" => "short_time_times = 0.1\n",
                _ => "",
            };
            fs::write(place.path("one.toml"), format!("{needed}{line}\n")).unwrap();
            place.good(&["settings", "--check", "one.toml"]);
        }
        before = line;
    }
    // All of it is a comment.
    fs::write(place.path("whole.toml"), &template).unwrap();
    assert!(
        place
            .good(&["settings", "--check", "whole.toml"])
            .contains("no key")
    );

    let style = place.good(&["settings", "style"]);
    assert!(keys(&style).contains(&"figures".to_owned()) && !style.contains("segment"));
    fs::write(place.path("style.toml"), "figures = 'svg'\n").unwrap();
    let checked = place.good(&["settings", "--check", "style.toml", "--json"]);
    assert_eq!(checked, "{\n  \"figures\": \"svg\"\n}\n");
    fs::write(place.path("wrong.toml"), "segmnt = 64\n").unwrap();
    let said = place.bad(2, &["settings", "analysis", "--check", "wrong.toml"]);
    assert!(said.contains("wrong.toml:1:"), "{said}");
}
