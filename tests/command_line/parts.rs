//! `--part` and `--merge` as a stranger runs them.

use ndarray_npy::NpzReader;
use test_support::fields::noise;
use test_support::place::Place;

/// The bytes of the arrays of a result.
fn arrays(place: &Place, directory: &str, file: &str) -> Vec<(String, Vec<u64>)> {
    let file = std::fs::File::open(place.path(format!("{directory}/{file}"))).unwrap();
    let mut archive = NpzReader::new(file).unwrap();
    let names = archive.names().unwrap();
    let mut found = Vec::new();
    for name in names {
        let values: ndarray::ArrayD<f64> = archive.by_name(&name).unwrap();
        found.push((name, values.iter().map(|v| v.to_bits()).collect()));
    }
    found
}

#[test]
fn regress_merged_parts_are_the_whole() {
    let place = Place::new();
    place.save("field.npy", &noise(1501, 6));
    for (name, words) in [
        ("spectrum", "spectrum field.npy --segment 128"),
        (
            "coherence",
            "coherence field.npy --segment 100 --reference 2",
        ),
    ] {
        let words: Vec<&str> = words
            .split(' ')
            .chain(["--figures", "none", "--force"])
            .collect();
        let archive = format!("{name}.npz");
        let whole: &[&str] = match name {
            "spectrum" => &["--no-jackknife"],
            _ => &[],
        };
        place.good(&[&words[..], &["--out", "whole"], whole].concat());
        let mut merge = vec![
            name,
            "--out",
            "merged",
            "--figures",
            "none",
            "--force",
            "--merge",
        ];
        for (part, out) in [("3/3", "c"), ("1/3", "a"), ("2/3", "b")] {
            place.good(&[&words[..], &["--part", part, "--out", out]].concat());
            merge.push(out);
        }
        place.good(&merge);
        let merged = arrays(&place, "merged", &archive);
        assert!(merged.len() > 3);
        let mut whole = arrays(&place, "whole", &archive);
        // Noise is read off the beginning of whole records.
        whole.retain(|(name, _)| merged.iter().any(|(own, _)| own == name));
        assert_eq!(merged, whole);
        merge.pop();
        let said = place.bad(2, &merge);
        assert!(
            said.contains("--merge") && said.contains("no part 2/3"),
            "{said}"
        );
    }
    let summary = place.json("a/summary.json");
    assert_eq!(summary["schema"], "cascade.part/1");
    assert_eq!(summary["range"][0], 0);
}

/// Parts whose sums exceed the memory allowed are refused before they are read.
#[test]
fn regress_a_merge_in_too_little_memory_is_refused() {
    let place = Place::new();
    place.save("field.npy", &noise(600, 64));
    for (name, words) in [
        (
            "spectrum",
            "spectrum field.npy --segment 100 --multitaper 3,5",
        ),
        ("coherence", "coherence field.npy --segment 100"),
    ] {
        let words: Vec<&str> = words.split(' ').chain(["--force"]).collect();
        for (part, out) in [("1/2", "a"), ("2/2", "b")] {
            place.good(&[&words[..], &["--part", part, "--out", out]].concat());
        }
        let merge = [
            name,
            "--merge",
            "a",
            "b",
            "--out",
            "merged",
            "--figures",
            "none",
            "--force",
            "--memory",
        ];
        let said = place.bad(2, &[&merge[..], &["200kB"]].concat());
        for expected in [
            " of these parts needs ",
            " of memory, allowed are 195.32 KiB",
            "raise `--memory`",
        ] {
            assert!(said.contains(expected), "{words:?}: {said}");
        }
        assert!(!place.path("merged").exists());
        place.good(&[&merge[..], &["40MB"]].concat());
        std::fs::remove_dir_all(place.path("merged")).unwrap();
    }
}

#[test]
fn regress_what_is_no_part_is_refused() {
    let place = Place::new();
    place.save("field.npy", &noise(400, 3));
    place.good(&[
        "coherence",
        "field.npy",
        "--segment",
        "64",
        "--part",
        "1/1",
        "--out",
        "part",
    ]);
    for (words, named) in [
        ("spectrum field.npy --part 0/3", "3/64"),
        ("spectrum field.npy --part 3", "3/64"),
        ("spectrum field.npy --segment 200 --part 1/4", "--part"),
        ("spectrum field.npy --along space --part 1/2", "--along"),
        ("spectrum field.npy --along both --part 1/2", "--along"),
        ("spectrum field.npy --space-window hann", "--space-window"),
        ("spectrum --merge part", "--out"),
        ("spectrum --merge part --out out", "cascade spectrum"),
        ("coherence --merge part --out out --segment 64", "--segment"),
        ("coherence --merge part --out out --gaps mask", "--gaps"),
        ("coherence --merge part --out out --memory 0", "--memory"),
        (
            "coherence --merge part --out out --reference 1",
            "--reference",
        ),
        ("spectrum --merge part --out out --along both", "--along"),
        ("spectrum", "FIELD"),
        ("analyze field.npy --part 3/64", "cascade spectrum FIELD"),
        ("analyze --merge part", "cascade spectrum FIELD"),
    ] {
        let words: Vec<&str> = words.split(' ').collect();
        let said = place.bad(2, &words);
        assert!(said.contains(named), "{words:?}: {said}");
    }
    let said = place.bad(1, &["coherence", "--merge", "field.npy", "--out", "out"]);
    assert!(said.contains("field.npy"), "{said}");
    // A part that was damaged.
    let path = place.path("part/part.npz");
    let mut bytes = std::fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    let said = place.bad(1, &["coherence", "--merge", "part", "--out", "out"]);
    assert!(said.contains("part.npz"), "{said}");
}
