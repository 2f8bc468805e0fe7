//! `--part` and `--merge` as a stranger runs them.

use std::fs;

use test_support::contains_all;
use test_support::fields::noise;
use test_support::place::Place;

#[test]
fn regress_merged_parts_are_the_whole() {
    let place = Place::new();
    place.save("field.npy", &noise(1501, 6));
    for (name, options, whole) in [
        ("spectrum", "--segment 128", "--no-jackknife"),
        ("coherence", "--segment 100 --reference 2", ""),
    ] {
        let line = format!("{name} field.npy {options} --figures none --force");
        place.says(&format!("{line} {whole} --out whole"));
        for (part, out) in [("3/3", "c"), ("1/3", "a"), ("2/3", "b")] {
            place.says(&format!("{line} --part {part} --out {out}"));
        }
        let merge = format!("{name} --out merged --figures none --force --merge");
        place.says(&format!("{merge} c a b"));
        let [merged, whole] = ["merged", "whole"].map(|of| format!("{of}/{name}.npz"));
        let names = place.arrays(&merged);
        assert!(names.len() > 3);
        // Noise is read off the beginning of whole records, and is not among them.
        for array in &names {
            let [a, b] = [&merged, &whole].map(|of| place.array::<f64>(of, array));
            let far = a
                .iter()
                .zip(&b)
                .find(|(a, b)| (*a - *b).abs() > 1e-12 * b.abs());
            assert_eq!(far, None, "{array}");
        }
        let said = place.refuses(2, &format!("{merge} c a"));
        assert!(said.contains("--merge") && said.contains("2/3"), "{said}");
        // Sums that exceed the memory allowed are refused before they are read.
        let said = place.refuses(2, &format!("{merge} a b c --memory 1kB"));
        contains_all(&said, &["memory", "--memory"]);
    }
    let summary = place.json("a/summary.json");
    assert_eq!(summary["schema"], "cascade.part/3");
    assert_eq!(summary["range"][0], 0);
}

#[test]
fn regress_what_is_no_part_is_refused() {
    let place = Place::new();
    place.save("field.npy", &noise(400, 3));
    place.says("coherence field.npy --segment 64 --part 1/1 --out part");
    // A part that was damaged.
    let path = place.path("part/part.npz");
    let mut bytes = fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&path, bytes).unwrap();
    place.refuses_for(1, "coherence --merge part --out out", "part.npz");
}
