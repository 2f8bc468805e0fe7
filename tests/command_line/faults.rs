//! Each call to the file system fails in turn: what is there is the old result or the new one.
#![cfg(target_os = "linux")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use test_support::place::{Place, text};
use test_support::power::{Content, Replay};
use test_support::preload::{self, Fault, Record};

/// Commands, each with what it writes: `result`, `part.*` or `run.*`.
const CASES: [&str; 13] = [
    "analyze wave.npy --out result --figures none --threads 1",
    "analyze wave.npy --out result --only spatial --figures png --threads 1",
    "analyze chain.npz --out result --only spatial --figures none --threads 1",
    "filter wave.npy --out part.npz --frequency 0:2 --threads 1",
    "filter wave.npy --out part.npy --frequency 0:2 --threads 1",
    "analyze wave.npy --out result --only spatial --figures none --threads 1 --format netcdf",
    "convert wave.npy part.nc --dt 1ms",
    "convert chain.npz part.csv --variable force",
    "simulate --sites 4 --samples 8 --out run.npz",
    "simulate --sites 4 --samples 8 --out run.nc",
    "budget chain.npz --out result --only frequency --from-samples --figures none",
    "compare chain.npz chain.npz --out result --only frequency --from-samples --figures none",
    "localize --order 1 --out result --threads 1",
];

fn result(words: &str) -> &str {
    let all = ["result", "part.", "run."];
    let is_it = |word: &&str| all.iter().any(|of| word.starts_with(of));
    words.split(' ').find(is_it).unwrap()
}

/// Files by their paths.
type Files = BTreeMap<String, Vec<u8>>;

/// What a run left of which a call failed.
struct Failed<'a> {
    code: Option<i32>,
    said: &'a str,
    /// What ran and failed.
    context: &'a str,
    before: &'a Files,
    /// What it would have left.
    whole: &'a Files,
}

/// Runs a command once for each of its calls, which fails, from the same beginning; how many failed, or `None` where this cannot
/// be done.
fn each_failure(place: &Place, words: &[&str], check: impl Fn(Failed)) -> Option<usize> {
    let before = files(place.folder());
    let (output, record) = preload::run(place, words, None)?;
    assert!(output.status.success(), "{words:?}: {output:?}");
    let whole = files(place.folder());
    let numbers = numbers(&record);
    for &n in &numbers {
        restore(place.folder(), &before);
        let fault = [Fault::Full, Fault::Disk][n % 2];
        let (output, record) = preload::run(place, words, Some((n, fault)))?;
        let failed = record.iter().find(|call| call[0] == "fail");
        let (status, said) = (output.status, text(&output.stderr));
        let context = format!("{words:?}, call {n}, {failed:?}: {status:?}\n{said}");
        assert!(matches!(status.code(), Some(0 | 1)), "{context}");
        assert!(!said.contains("panicked"), "{context}");
        check(Failed {
            code: status.code(),
            said: &said,
            context: &context,
            before: &before,
            whole: &whole,
        });
    }
    println!("{words:?}: {} calls failed, one a run", numbers.len());
    Some(numbers.len())
}

/// Paths of the files below a path.
fn paths(path: &Path) -> Vec<String> {
    files(path).into_keys().collect()
}

/// Asserts that no working file is among these.
#[track_caller]
fn has_no_partial(left: &[String], context: &str) {
    let is_partial = |name: &String| name.contains(".cascade-partial");
    assert!(!left.iter().any(is_partial), "{context}: {left:?}");
}

/// The command once more, with a good end.
#[track_caller]
fn again(place: &Place, words: &[&str], context: &str) {
    let output = place.run(words);
    assert!(output.status.success(), "{context}: {output:?}");
}

/// Files below a path, by their paths.
fn files(path: &Path) -> Files {
    let mut found = BTreeMap::new();
    if path.is_dir() {
        for entry in fs::read_dir(path).unwrap() {
            found.extend(files(&entry.unwrap().path()));
        }
    } else if path.exists() {
        found.insert(path.display().to_string(), fs::read(path).unwrap());
    }
    found
}

/// Names of files, and the bytes of those that are the same in every run.
fn outline(files: &Files) -> BTreeMap<String, Option<Vec<u8>>> {
    let ends = ["spectra.npz", "part.npz", ".npy", "part.nc", "part.csv"];
    let is_fixed = |name: &str| ends.iter().any(|end| name.ends_with(end));
    let outline = files.iter().map(|(name, bytes)| {
        let fixed = is_fixed(name).then(|| bytes.clone());
        (name.clone(), fixed)
    });
    outline.collect()
}

fn restore(place: &Path, before: &Files) {
    for entry in fs::read_dir(place).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => fs::remove_dir_all(path).unwrap(),
            false => fs::remove_file(path).unwrap(),
        }
    }
    for (name, bytes) in before {
        fs::create_dir_all(Path::new(name).parent().unwrap()).unwrap();
        fs::write(name, bytes).unwrap();
    }
}

/// Numbers of the calls that are to fail: all but those in the middle of many writes to one file.
fn numbers(record: &Record) -> Vec<usize> {
    let number = |call: &[String; 4]| call[3].parse::<usize>().unwrap();
    let all = record.last().map_or(0, number);
    let same = record.chunk_by(|a, b| a[..2] == b[..2]);
    let middle = same
        .filter(|calls| calls.len() > 4)
        .flat_map(|calls| &calls[2..calls.len() - 2]);
    let middle: BTreeSet<usize> = middle.map(number).collect();
    (1..=all).filter(|n| !middle.contains(n)).collect()
}

/// What all cases read.
fn inputs_of_cases() -> Place {
    let place = test_support::pulse::place();
    place.says("simulate --sites 4 --samples 8 --out chain.npz");
    place
}

/// The words of a case that begins with its inputs, and with its result to replace.
fn begun<'a>(place: &Place, inputs: &Files, case: &'a str, has_older: bool) -> Vec<&'a str> {
    restore(place.folder(), inputs);
    let mut words: Vec<&str> = case.split(' ').collect();
    if has_older {
        place.good(&words);
        words.push("--force");
    }
    words
}

#[test]
fn regress_any_call_may_fail() {
    let place = inputs_of_cases();
    let inputs = files(place.folder());
    for case in &CASES {
        for has_older in [false, true] {
            let words = begun(&place, &inputs, case, has_older);
            let count = each_failure(&place, &words, |failed| {
                let Failed { said, context, .. } = failed;
                let found = files(place.folder());
                let is_new = outline(&found) == outline(failed.whole);
                if failed.code == Some(0) {
                    assert!(is_new, "{context}");
                } else {
                    assert_eq!(said.matches("error: ").count(), 1, "{context}");
                    assert!(said.starts_with("error: "), "{context}");
                    let is_old = found == *failed.before;
                    assert!(is_old || is_new, "{context}: {:?}", found.keys());
                }
            });
            match count {
                Some(count) => assert!(count > 10, "{case}: {count}"),
                None => return,
            }
        }
    }
}

/// Each request for memory is refused in turn, up to so many a command.
#[test]
#[ignore = "slow"]
fn regress_any_request_for_memory_may_be_refused() {
    const REFUSED: usize = 40;
    let place = inputs_of_cases();
    let inputs = files(place.folder());
    let mut count = 0;
    for case in &CASES {
        let words = begun(&place, &inputs, case, false);
        let Some((output, asked)) = preload::refusing(&place, &words, None) else {
            return;
        };
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(asked > 10, "{words:?}: {asked}");
        let whole = paths(place.folder());
        for n in (1..=asked).step_by(asked.div_ceil(REFUSED)) {
            restore(place.folder(), &inputs);
            let (output, _) = preload::refusing(&place, &words, Some(n)).unwrap();
            let said = text(&output.stderr);
            let status = output.status;
            let context = format!("{words:?}, request {n} of {asked}: {status:?}\n{said}");
            match output.status.code() {
                // It was asked for more than was needed.
                Some(0) => {}
                Some(1 | 2) => {
                    assert_eq!(said.matches("error: ").count(), 1, "{context}");
                    assert!(said.starts_with("error: "), "{context}");
                    assert!(said.contains("help: "), "{context}");
                    let is_absent = files(&place.path(result(case))).is_empty();
                    assert!(is_absent, "{context}");
                }
                _ => panic!("{context}"),
            }
            // What an ended run has left, the next one removes.
            if count % 5 == 0 {
                again(&place, &[&words[..], &["--force"]].concat(), &context);
                assert_eq!(paths(place.folder()), whole, "{context}");
            }
            count += 1;
        }
    }
    println!("{count} requests for memory refused, one a run");
}

/// Work in parts keeps what is done: the same command completes it.
#[test]
fn regress_work_in_parts_goes_on_after_any_call_failed() {
    const PARTS: [(&str, &str); 3] = [
        (
            "sweep --vary stiffness_ratio=1,2 --sites 4 --samples 8 --out result",
            "result/table.csv",
        ),
        (
            "attenuate --ratios 2.4 --bodies 5 --lengths 5 --out result --figures none --threads 1",
            "result/curves.csv",
        ),
        (
            "attenuate --against stiffness_ratio=2,3 --sites 5 --out result --figures none --threads 1",
            "result/curves.csv",
        ),
    ];
    let place = inputs_of_cases();
    let inputs = files(place.folder());
    for (words, table) in PARTS {
        let words = begun(&place, &inputs, words, false);
        let count = each_failure(&place, &words, |Failed { context, whole, .. }| {
            has_no_partial(&paths(place.folder()), context);
            again(&place, &words, context);
            let table = place.path(table).display().to_string();
            let found = files(place.folder());
            assert_eq!(found[&table], whole[&table], "{context}");
            let (found, whole) = (found.keys(), whole.keys());
            assert!(found.clone().eq(whole), "{context}: {found:?}");
        });
        match count {
            Some(count) => assert!(count > 20, "{words:?}: {count}"),
            None => return,
        }
    }
}

/// Of several fields, each has a whole result or none; what is listed is there.
#[test]
fn regress_several_fields_are_whole_after_any_call_failed() {
    let words = "analyze wave.npy chain.npz --out result --only spatial --figures none --threads 1";
    let words: Vec<&str> = words.split(' ').collect();
    let place = inputs_of_cases();
    let fields = ["wave", "chain.npz"].map(|name| place.path("result").join(name));
    let count = each_failure(&place, &words, |Failed { context, whole, .. }| {
        has_no_partial(&paths(place.folder()), context);
        let of = |field: &Path| -> Vec<String> {
            let is_of = |name: &&String| Path::new(name).starts_with(field);
            whole.keys().filter(is_of).cloned().collect()
        };
        for field in &fields {
            let (found, whole) = (paths(field), of(field));
            let is_whole = found.is_empty() || found == whole;
            assert!(!whole.is_empty() && is_whole, "{context}: {found:?}");
        }
        if place.path("result/index.json").exists() {
            let listed = place.json("result/index.json").to_string();
            let is_listed = |name: &&str| listed.contains(&format!("\"name\":\"{name}\""));
            let is_any = ["wave", "chain.npz"].iter().any(is_listed);
            assert!(is_any, "{context}: {listed}");
        }
        again(&place, &[&words[..], &["--force"]].concat(), context);
        for field in &fields {
            assert_eq!(paths(field), of(field), "{context}");
        }
    });
    assert!(count.is_none_or(|count| count > 50), "{count:?}");
}

/// Of every point at which the power may be cut, with all the names that the disk may then have.
#[test]
fn regress_a_power_cut_leaves_the_old_or_the_new_result() {
    let place = inputs_of_cases();
    let inputs = files(place.folder());
    let (mut cuts, mut seen) = (0, [0; 2]);
    for (case, has_older) in CASES.iter().flat_map(|case| [(case, false), (case, true)]) {
        // Two files, which are two renames.
        if ["part.npy", "part.csv"].contains(&result(case)) {
            continue;
        }
        let words = begun(&place, &inputs, case, has_older);
        let Some((output, record)) = preload::run(&place, &words, None) else {
            return;
        };
        assert!(output.status.success(), "{words:?}: {output:?}");
        let below = |path: &String| {
            let path = Path::new(path).strip_prefix(place.folder()).unwrap();
            path.display().to_string()
        };
        let before: Vec<String> = match has_older {
            true => files(&place.path(result(case))).keys().map(below).collect(),
            false => Vec::new(),
        };
        let known: Vec<String> = inputs.keys().map(below).chain(before).collect();
        let replay = Replay::new(&known, &record);
        let all = files(&place.path(result(case))).keys().map(below).collect();
        let whole = Content::Whole(all);
        for cut in 0..=replay.calls() {
            for named in 0..=cut {
                let found = replay.after(cut, named, result(case));
                let context = format!("{words:?}, cut {cut}, names {named}");
                match &found {
                    Content::Absent => assert!(!has_older, "{context}"),
                    Content::Old => assert!(has_older, "{context}"),
                    new => assert_eq!(*new, whole, "{context}"),
                }
                seen[usize::from(found == whole)] += 1;
                cuts += 1;
            }
        }
        let end = replay.after(replay.calls(), 0, result(case));
        assert_eq!(end, whole, "{words:?}: not on the disk at the end");
        // The replay would find a sync that is missing.
        let unsynced = record.iter().filter(|call| call[0] != "sync").cloned();
        let replay = Replay::new(&known, &unsynced.collect());
        let end = replay.after(replay.calls(), replay.calls(), result(case));
        assert!(matches!(end, Content::Torn(_)), "{words:?}: {end:?}");
    }
    let [old, new] = seen;
    println!("{cuts} power cuts: {old} old or none, {new} new");
}
