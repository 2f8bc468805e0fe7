//! The program as a stranger meets it; nothing here depends on how long anything takes.

use std::fs;
use std::path::PathBuf;

use column_fft::RealToComplexColumns;
use serde_json::{Value, json};

/// A folder of its own to run the program in.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Place {
        Place(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, words: &[&str]) -> assert_cmd::Command {
        let mut command = assert_cmd::Command::cargo_bin("throughput").unwrap();
        command.current_dir(self.0.path()).args(words);
        command
    }

    fn good(&self, words: &[&str]) -> String {
        let [out, _] = ends(0, &mut self.command(words));
        out
    }

    fn bad(&self, code: i32, words: &[&str]) -> String {
        let [_, err] = ends(code, &mut self.command(words));
        err
    }

    fn known(&self) -> Value {
        json(&fs::read_to_string(self.path("base.json")).unwrap())
    }
}

/// What a command says, also on standard error, that ends with this code.
#[track_caller]
fn ends(code: i32, command: &mut assert_cmd::Command) -> [String; 2] {
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(code), "{command:?}: {output:?}");
    [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap())
}

#[track_caller]
fn has(said: &str, words: &[&str]) {
    for word in words {
        assert!(said.contains(word), "no {word:?} in {said}");
    }
}

fn number(case: &Value, key: &str) -> f64 {
    case[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key}: {case}"))
}

#[track_caller]
fn close(case: &Value, key: &str, expected: f64) {
    let off = (number(case, key) / expected - 1.0).abs();
    assert!(off < 1e-12, "{key}: {case}");
}

const SMALL: [&str; 5] = ["--shape", "64x9", "--rounds", "3", "--json"];

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().unwrap().iter();
    values.map(|v| v.as_f64().unwrap()).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Every figure can be had again from the times in the JSON.
#[test]
fn val_figures_follow_from_the_times() {
    let place = Place::new();
    let words = ["--shape", "256x20", "--shape", "257x9", "--threads", "2"];
    let said = json(&place.good(&[&words[..], &["--rounds", "3", "--json"]].concat()));
    for key in ["cpu", "instruction_set", "build"] {
        assert!(said["machine"][key].is_string(), "{said}");
    }
    for key in ["cascade", "rustfft", "realfft", "rustc"] {
        assert!(said["versions"][key].is_string(), "{said}");
    }
    let cases = said["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 2 * 2 * 2, "shapes, precisions, threads");
    for case in cases {
        let (rows, columns) = (number(case, "rows"), number(case, "columns"));
        let times = |way: &str| numbers(&case["times_ms"][way]);
        let ours = times("cascade");
        assert_eq!(ours.len(), 3);
        close(case, "median_ms", median(ours.clone()));
        let milliseconds = number(case, "median_ms");
        close(
            case,
            "gflops",
            2.5 * rows * rows.log2() * columns / milliseconds / 1e6,
        );
        let clock = if case["threads"] == 1 {
            "thread"
        } else {
            "wall"
        };
        assert!(case["clock"] == clock || cfg!(not(unix)), "{case}");
        let single = case["precision"] == "f32";
        let bytes =
            columns * (rows + 2.0 * ((rows / 2.0).floor() + 1.0)) * if single { 4.0 } else { 8.0 };
        close(
            case,
            "part_of_bound",
            1e3 * bytes / number(case, "copy_bytes_per_second") / milliseconds,
        );
        for way in ["rustfft", "realfft"] {
            let quotients = times(way).iter().zip(&ours).map(|(t, o)| t / o).collect();
            let ratio = case["ratio_to"][way].as_f64().unwrap();
            assert!((ratio / median(quotients) - 1.0).abs() < 1e-12, "{case}");
        }
        let error = match single {
            true => RealToComplexColumns::<f32>::new(rows as usize)
                .unwrap()
                .expected_error(),
            false => RealToComplexColumns::<f64>::new(rows as usize)
                .unwrap()
                .expected_error(),
        };
        close(case, "expected_error", error);
    }
}

/// Changes the first baseline of ratios in a file.
fn edit(place: &Place, change: impl Fn(&mut Value)) {
    let path = place.path("base.json");
    let mut known = place.known();
    change(&mut known["ratios"][0]);
    fs::write(path, known.to_string()).unwrap();
}

fn times(value: &mut Value, factor: f64) {
    for (_, number) in value.as_object_mut().unwrap() {
        *number = json!(number.as_f64().unwrap() * factor);
    }
}

const KINDS: [&str; 8] = [
    "--kind",
    "columns,plane,short-time",
    "--shape",
    "320x10",
    "--precision",
    "f64",
    "--rounds",
    "2",
];

/// By hand: a plane of 3200 samples and 161 rows of bins; 3 segments of 256 samples and 129 bins.
#[test]
fn val_planes_and_segments_are_measured_as_columns_are() {
    let place = Place::new();
    let said = json(&place.good(&[&KINDS[..], &["--json"]].concat()));
    let cases = said["cases"].as_array().unwrap();
    let kinds: Vec<&str> = cases.iter().map(|c| c["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["columns", "plane", "short-time"]);
    let plane = (2.5 * 3200.0 * 3200_f64.log2(), 320 + 2 * 161);
    let segments = (2.5 * 256.0 * 8.0 * 30.0, 320 + 2 * 3 * 129);
    for (case, (operations, row)) in cases[1..].iter().zip([plane, segments]) {
        let milliseconds = number(case, "median_ms");
        close(case, "gflops", operations / milliseconds / 1e6);
        let bytes = f64::from(10 * 8 * row);
        close(
            case,
            "part_of_bound",
            1e3 * bytes / number(case, "copy_bytes_per_second") / milliseconds,
        );
        assert!(case["expected_error"].is_null(), "{case}");
        for way in ["cascade", "rustfft", "realfft"] {
            assert_eq!(numbers(&case["times_ms"][way]).len(), 2, "{case}");
        }
        for way in ["rustfft", "realfft"] {
            assert!(case["ratio_to"][way].as_f64().unwrap() > 0.0, "{case}");
        }
    }

    let said = place.good(&KINDS);
    for kind in kinds {
        let mut lines = said.lines().filter(|line| line.contains(" 320x10 "));
        let line = lines.find(|line| line.trim_start().starts_with(kind));
        let line = line.unwrap_or_else(|| panic!("{kind}: {said}"));
        assert_eq!(line.split_whitespace().count(), 4 + 4 + 2 * 2, "{line}");
        assert!(!line.contains("NaN"), "{line}");
    }
}

/// What a baseline does not know is named and not compared; what it knows must be kept.
#[test]
fn planes_and_segments_have_a_baseline_of_their_own() {
    let place = Place::new();
    place.good(&[&KINDS[..], &["--record", "base.json"]].concat());
    let new = [
        "plane 320x10 f64, 1 thread",
        "short-time 320x10 f64, 1 thread",
    ];
    let change = |factor: Option<f64>| {
        edit(&place, |ratios| {
            let ratios = ratios["ratio_to_rustfft"].as_object_mut().unwrap();
            assert_eq!(ratios.len(), 3);
            ratios["320x10 f64, 1 thread"] = json!(1e-3);
            for case in new {
                match factor {
                    Some(factor) => ratios[case] = json!(factor),
                    None => drop(ratios.remove(case).unwrap()),
                }
            }
        });
    };
    let check = [&KINDS[..], &["--check", "--baseline", "base.json"]].concat();
    change(Some(1e-3));
    let said = json(&place.good(&[&check[..], &["--json"]].concat()));
    assert_eq!(said["check"].as_array().unwrap().len(), 3);
    assert!(said["not_compared"].is_null(), "{said}");

    change(Some(1e4));
    let said = place.bad(1, &check);
    for word in ["2 of 3 cases", new[0], new[1]] {
        assert!(said.contains(word), "{word}: {said}");
    }

    change(None);
    let said = place.good(&check);
    let said = said.lines().find(|line| line.starts_with("not compared"));
    let said = said.expect("what is not compared");
    for word in ["base.json has no baseline", "--record FILE", new[0], new[1]] {
        assert!(said.contains(word), "{word}: {said}");
    }
    let said = json(&place.good(&[&check[..], &["--json"]].concat()));
    assert_eq!(said["check"].as_array().unwrap().len(), 1);
    assert_eq!(said["not_compared"], json!(new));
    // Where nothing can be compared, nothing is said to be kept.
    let said = place.bad(1, &[&["--kind", "plane"], &check[2..]].concat());
    has(&said, &[new[0], "--record"]);
}

/// No machine is so uneven that a hundredth or the hundredfold of a ratio could be found.
#[test]
fn a_loss_is_named_and_a_gain_passes() {
    let place = Place::new();
    place.good(&[&SMALL[..], &["--record", "base.json"]].concat());
    let check = [&SMALL[..], &["--check", "--baseline", "base.json"]].concat();
    edit(&place, |ratios| {
        times(&mut ratios["ratio_to_rustfft"], 0.01)
    });
    let said = json(&place.good(&check));
    assert_eq!(said["check"].as_array().unwrap().len(), 2);

    edit(&place, |ratios| times(&mut ratios["ratio_to_rustfft"], 1e4));
    let [told, said] = ends(1, &mut place.command(&check));
    has(
        &said,
        &[
            "2 of 2 cases",
            "base.json",
            "64x9 f64, 1 thread: ",
            "64x9 f32",
            "rustfft, now",
            "--record",
        ],
    );
    // The table is there all the same, and four times the rounds were made.
    let found = json(&told);
    assert_eq!(numbers(&found["cases"][0]["times_ms"]["cascade"]).len(), 12);
}

#[test]
fn a_baseline_of_elsewhere_does_not_count() {
    let place = Place::new();
    place.good(&[&SMALL[..], &["--record", "base.json"]].concat());
    let check = [&SMALL[..], &["--check", "--baseline", "base.json"]].concat();
    let other = [&["--shape", "65x9"], &check[2..]].concat();
    let said = place.bad(1, &other);
    has(&said, &["65x9 f64, 1 thread; 65x9 f32, 1 thread"]);
    // A record anew takes the place of the old one, one of another machine stays.
    edit(&place, |ratios| {
        ratios["machine"]["cpu"] = json!("Another 9000")
    });
    let said = place.bad(1, &check);
    has(&said, &["has no baseline for", "--record FILE"]);
    assert!(!said.contains("Another 9000"), "{said}");
    for _ in 0..2 {
        place.good(&[&SMALL[..], &["--record", "base.json"]].concat());
    }
    let known = place.known();
    assert_eq!(known["ratios"].as_array().unwrap().len(), 2);
    // One of other cases stands beside it.
    let other = [&["--shape", "65x9"], &SMALL[2..]].concat();
    place.good(&[&other[..], &["--record", "base.json"]].concat());
    edit(&place, |ratios| {
        assert_eq!(ratios["machine"]["cpu"], "Another 9000")
    });
    let known = place.known();
    let cases = known["ratios"][1]["ratio_to_rustfft"].as_object().unwrap();
    let cases: Vec<&str> = cases.keys().map(|case| &**case).collect();
    let expected = ["64x9 f32", "64x9 f64", "65x9 f32", "65x9 f64"];
    assert_eq!(cases, expected.map(|case| format!("{case}, 1 thread")));
}

#[test]
fn a_damaged_baseline_is_named() {
    let place = Place::new();
    let other = r#"{"schema": "something/1", "ratios": [], "instructions": []}"#;
    for (text, named) in [
        ("not JSON", "line 1"),
        ("{}", "schema"),
        (other, "something/1"),
    ] {
        fs::write(place.path("base.json"), text).unwrap();
        for words in [
            &["--check", "--baseline", "base.json"][..],
            &["--record", "base.json"],
        ] {
            let said = place.bad(1, &[&SMALL[..], words].concat());
            has(&said, &["base.json", named, "help: "]);
            assert_eq!(fs::read_to_string(place.path("base.json")).unwrap(), text);
        }
    }
}

#[test]
fn what_cannot_be_is_said() {
    let place = Place::new();
    for (line, named) in [
        ("--shape 3x", "ROWSxCOLUMNS"),
        ("--shape 99999999x99999", "free memory"),
        ("--kind short-time --shape 255x9", "at least 256 rows"),
        ("--kind segments", "short-time"),
        ("--threads 0", "--threads"),
        ("--check --record base.json", "--record"),
        ("--record none/base.json", "none/base.json"),
    ] {
        let said = place.bad(2, &line.split(' ').collect::<Vec<_>>());
        assert!(said.contains(named), "{line}: {said}");
    }
}

/// Runs with programs of `place` alone on the path.
#[cfg(unix)]
#[track_caller]
fn with_path(place: &Place, code: i32, words: &[&str]) -> [String; 2] {
    ends(code, place.command(words).env("PATH", place.0.path()))
}

/// A valgrind that counts 1000 instructions and for each transform 500 more, for `rustfft` 1500.
#[cfg(unix)]
const STAND_IN: &str = r#"#!/bin/sh
while [ "$1" != "--repeat" ]; do shift; done
each=500
[ "$4" = rustfft ] && each=1500
echo "==1== Command: refs: 7" >&2
echo "==1== I   refs:      $((1000 + each * $2 / 1000)),$((each * $2 % 1000 + 100))" >&2
"#;

#[cfg(unix)]
#[test]
fn val_counts_are_the_difference_of_two_runs() {
    use std::os::unix::fs::PermissionsExt;

    let place = Place::new();
    let words = ["--instructions", "--shape", "10x10", "--precision", "f64"];
    let [_, said] = with_path(&place, 1, &words);
    has(
        &said,
        &[
            "error: cannot count instructions",
            "valgrind",
            "apt-get install valgrind",
        ],
    );

    let script = place.path("valgrind");
    let executable = |text: &str| {
        fs::write(&script, text).unwrap();
        fs::set_permissions(&script, fs::Permissions::from_mode(0o755)).unwrap();
    };
    executable("#!/bin/sh\necho 'out of luck' >&2\nexit 3\n");
    let [_, said] = with_path(&place, 1, &words);
    has(&said, &["out of luck", "--repeat"]);

    executable(STAND_IN);
    let record = [&words[..], &["--record", "base.json"]].concat();
    let [told, said] = with_path(&place, 0, &record);
    assert_eq!(said, "");
    has(&told, &["5.00 ( 3.00)", "15.00"]);
    let known = place.known();
    let counts = &known["instructions"][0]["per_sample"];
    assert_eq!(counts["10x10 f64 portable"], 5.0);
    assert_eq!(counts["10x10 f64 rustfft"], 15.0);

    let check = [&words[..], &["--check", "--baseline", "base.json"]].concat();
    with_path(&place, 0, &check);
    // Twice as fast once, so half is lost.
    let mut doubled = known.clone();
    times(&mut doubled["instructions"][0]["per_sample"], 0.5);
    fs::write(place.path("base.json"), doubled.to_string()).unwrap();
    let [_, said] = with_path(&place, 1, &check);
    has(
        &said,
        &["10x10 f64 portable: 2.500 instructions a sample, now 5.000: 50.0 % lost"],
    );
    doubled["instructions"][0]["build"] = json!("of another kind");
    fs::write(place.path("base.json"), doubled.to_string()).unwrap();
    let [_, said] = with_path(&place, 1, &check);
    has(&said, &["has no baseline for"]);
}
