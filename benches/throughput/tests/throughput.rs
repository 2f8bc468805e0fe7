//! The program as a stranger meets it; nothing here depends on how long anything takes.

use std::fs;
use std::path::PathBuf;

use column_fft::{Real, RealToComplexColumns};
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

    fn command(&self, line: &str) -> assert_cmd::Command {
        let mut command = assert_cmd::Command::cargo_bin("throughput").unwrap();
        command.current_dir(self.0.path()).args(line.split(' '));
        command
    }

    #[track_caller]
    fn good(&self, line: &str) -> String {
        let [out, _] = ends(0, &mut self.command(line));
        out
    }

    #[track_caller]
    fn bad(&self, code: i32, line: &str, words: &[&str]) -> String {
        let [_, err] = ends(code, &mut self.command(line));
        has(&err, words);
        err
    }

    /// Records a baseline of these cases; the words that compare them with it.
    #[track_caller]
    fn recorded(&self, cases: &str) -> String {
        self.good(&format!("{cases} --record base.json"));
        format!("{cases} --check --baseline base.json")
    }

    fn known(&self) -> Value {
        json(&fs::read_to_string(self.path("base.json")).unwrap())
    }

    /// Changes the first baseline of this kind in the file.
    fn edit(&self, kind: &str, change: impl FnOnce(&mut Value)) {
        let mut known = self.known();
        change(&mut known[kind][0]);
        fs::write(self.path("base.json"), known.to_string()).unwrap();
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

const SMALL: &str = "--shape 64x9 --rounds 3 --json";

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

/// What a copy of so many bytes takes of the time.
#[track_caller]
fn has_part_of_bound(case: &Value, bytes: f64) {
    let copied = 1e3 * bytes / number(case, "copy_bytes_per_second");
    close(case, "part_of_bound", copied / number(case, "median_ms"));
}

fn expected_error<T: Real>(rows: f64) -> f64 {
    let plan = RealToComplexColumns::<T>::new(rows as usize);
    plan.unwrap().expected_error()
}

/// Every figure can be had again from the times in the JSON.
#[test]
fn val_figures_follow_from_the_times() {
    let place = Place::new();
    let line = "--shape 256x20 --shape 257x9 --threads 2 --rounds 3 --json";
    let said = json(&place.good(line));
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
        let operations = 2.5 * rows * rows.log2() * columns;
        close(case, "gflops", operations / milliseconds / 1e6);
        let clock = ["wall", "thread"][usize::from(case["threads"] == 1)];
        assert!(case["clock"] == clock || cfg!(not(unix)), "{case}");
        let single = case["precision"] == "f32";
        let moved = columns * (rows + 2.0 * ((rows / 2.0).floor() + 1.0));
        has_part_of_bound(case, moved * if single { 4.0 } else { 8.0 });
        for way in ["rustfft", "realfft"] {
            let quotients = times(way).iter().zip(&ours).map(|(t, o)| t / o).collect();
            let ratio = case["ratio_to"][way].as_f64().unwrap();
            assert!((ratio / median(quotients) - 1.0).abs() < 1e-12, "{case}");
        }
        let error = match single {
            true => expected_error::<f32>(rows),
            false => expected_error::<f64>(rows),
        };
        close(case, "expected_error", error);
    }
}

fn times(value: &mut Value, factor: f64) {
    for (_, number) in value.as_object_mut().unwrap() {
        *number = json!(number.as_f64().unwrap() * factor);
    }
}

const KINDS: &str = "--kind columns,plane,short-time --shape 320x10 --precision f64 --rounds 2";

/// By hand: a plane of 3200 samples and 161 rows of bins; 3 segments of 256 samples and 129 bins.
#[test]
fn val_planes_and_segments_are_measured_as_columns_are() {
    let place = Place::new();
    let said = json(&place.good(&format!("{KINDS} --json")));
    let cases = said["cases"].as_array().unwrap();
    let kinds: Vec<&str> = cases.iter().map(|c| c["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["columns", "plane", "short-time"]);
    let plane = (2.5 * 3200.0 * 3200_f64.log2(), 320 + 2 * 161);
    let segments = (2.5 * 256.0 * 8.0 * 30.0, 320 + 2 * 3 * 129);
    for (case, (operations, row)) in cases[1..].iter().zip([plane, segments]) {
        let milliseconds = number(case, "median_ms");
        close(case, "gflops", operations / milliseconds / 1e6);
        has_part_of_bound(case, f64::from(10 * 8 * row));
        assert!(case["expected_error"].is_null(), "{case}");
        for way in ["cascade", "rustfft", "realfft"] {
            assert_eq!(numbers(&case["times_ms"][way]).len(), 2, "{case}");
        }
        for way in ["rustfft", "realfft"] {
            assert!(case["ratio_to"][way].as_f64().unwrap() > 0.0, "{case}");
        }
    }

    let said = place.good(KINDS);
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
    let check = place.recorded(KINDS);
    let new = [
        "plane 320x10 f64, 1 thread",
        "short-time 320x10 f64, 1 thread",
    ];
    let change = |factor: Option<f64>| {
        place.edit("ratios", |ratios| {
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
    change(Some(1e-3));
    let said = json(&place.good(&format!("{check} --json")));
    assert_eq!(said["check"].as_array().unwrap().len(), 3);
    assert!(said["not_compared"].is_null(), "{said}");

    change(Some(1e4));
    place.bad(1, &check, &["2 of 3 cases", new[0], new[1]]);

    change(None);
    let said = place.good(&check);
    let said = said.lines().find(|line| line.starts_with("not compared"));
    let words = ["base.json has no baseline", "--record FILE", new[0], new[1]];
    has(said.expect("what is not compared"), &words);
    let said = json(&place.good(&format!("{check} --json")));
    assert_eq!(said["check"].as_array().unwrap().len(), 1);
    assert_eq!(said["not_compared"], json!(new));
    // Where nothing can be compared, nothing is said to be kept.
    let plane = check.replace("columns,plane,short-time", "plane");
    place.bad(1, &plane, &[new[0], "--record"]);
}

/// No machine is so uneven that a hundredth or the hundredfold of a ratio could be found.
#[test]
fn a_loss_is_named_and_a_gain_passes() {
    let place = Place::new();
    let check = place.recorded(SMALL);
    let scale = |factor| {
        place.edit("ratios", |ratios| {
            times(&mut ratios["ratio_to_rustfft"], factor)
        })
    };
    scale(0.01);
    let said = json(&place.good(&check));
    assert_eq!(said["check"].as_array().unwrap().len(), 2);

    scale(1e4);
    let [told, said] = ends(1, &mut place.command(&check));
    has(
        &said,
        &["2 of 2 cases", "base.json", "64x9 f64, 1 thread: "],
    );
    has(&said, &["64x9 f32", "rustfft, now", "--record"]);
    // The table is there all the same, and four times the rounds were made.
    let found = json(&told);
    assert_eq!(numbers(&found["cases"][0]["times_ms"]["cascade"]).len(), 12);
}

#[test]
fn a_baseline_of_elsewhere_does_not_count() {
    let place = Place::new();
    let check = place.recorded(SMALL);
    let unknown = ["65x9 f64, 1 thread; 65x9 f32, 1 thread"];
    place.bad(1, &check.replace("64x9", "65x9"), &unknown);
    // A record anew takes the place of the old one, one of another machine stays.
    place.edit("ratios", |ratios| {
        ratios["machine"]["cpu"] = json!("Another 9000")
    });
    let said = place.bad(1, &check, &["has no baseline for", "--record FILE"]);
    assert!(!said.contains("Another 9000"), "{said}");
    for _ in 0..2 {
        place.recorded(SMALL);
    }
    assert_eq!(place.known()["ratios"].as_array().unwrap().len(), 2);
    // One of other cases stands beside it.
    place.recorded(&SMALL.replace("64x9", "65x9"));
    let known = place.known();
    assert_eq!(known["ratios"][0]["machine"]["cpu"], "Another 9000");
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
        for words in ["--check --baseline", "--record"] {
            let line = format!("{SMALL} {words} base.json");
            place.bad(1, &line, &["base.json", named, "help: "]);
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
        place.bad(2, line, &[named]);
    }
}

/// Runs with programs of `place` alone on the path.
#[cfg(unix)]
#[track_caller]
fn with_path(place: &Place, code: i32, line: &str, words: &[&str]) -> [String; 2] {
    let said = ends(code, place.command(line).env("PATH", place.0.path()));
    has(&said[usize::from(code != 0)], words);
    said
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
    let line = "--instructions --shape 10x10 --precision f64";
    let words = [
        "error: cannot count instructions",
        "apt-get install valgrind",
    ];
    with_path(&place, 1, line, &words);

    let script = place.path("valgrind");
    let executable = |text: &str| {
        fs::write(&script, text).unwrap();
        fs::set_permissions(&script, fs::Permissions::from_mode(0o755)).unwrap();
    };
    executable("#!/bin/sh\necho 'out of luck' >&2\nexit 3\n");
    with_path(&place, 1, line, &["out of luck", "--repeat"]);

    executable(STAND_IN);
    let record = format!("{line} --record base.json");
    let [_, said] = with_path(&place, 0, &record, &["5.00 ( 3.00)", "15.00"]);
    assert_eq!(said, "");
    let known = place.known();
    let counts = &known["instructions"][0]["per_sample"];
    assert_eq!(counts["10x10 f64 portable"], 5.0);
    assert_eq!(counts["10x10 f64 rustfft"], 15.0);

    let check = format!("{line} --check --baseline base.json");
    with_path(&place, 0, &check, &[]);
    // Twice as fast once, so half is lost.
    place.edit("instructions", |known| times(&mut known["per_sample"], 0.5));
    let lost = "10x10 f64 portable: 2.500 instructions a sample, now 5.000: 50.0 % lost";
    with_path(&place, 1, &check, &[lost]);
    place.edit("instructions", |known| {
        known["build"] = json!("of another kind")
    });
    with_path(&place, 1, &check, &["has no baseline for"]);
}
