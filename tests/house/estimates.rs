//! What one estimate takes, by the example of `coherence`: beside its own folder, the files that name it are few.

use std::fs;
use std::path::Path;

use crate::rooms::{files, root};

/// Files outside of its folder: the export, its arguments, the one list of the program, its function in Python; the sums
/// in parts (one of Rust, two of Python), what is plotted first, and two sentences that advise it.
const MOST: usize = 10;

/// Whether code names it as a word; comments do not count.
fn names(path: &Path, estimate: &str) -> bool {
    let mark = if path.extension().is_some_and(|e| e == "rs") {
        "//"
    } else {
        "#"
    };
    let text = fs::read_to_string(path).unwrap();
    text.lines().any(|line| {
        let code = line.split(mark).next().unwrap_or_default();
        let mut words = code.split(|c: char| !c.is_alphanumeric() && c != '_');
        words.any(|word| word == estimate)
    })
}

#[test]
fn regress_an_estimate_is_named_in_few_files() {
    let root = root();
    let folders = ["src", "crates", "python/src", "python/wavecascade"];
    let all = folders.map(|folder| files(&root.join(folder), &[".rs", ".py", ".pyi"]));
    let mut all = all.concat();
    let own = root.join("src/estimates/coherence");
    let is_test = |path: &Path| path.iter().any(|part| part == "tests");
    all.retain(|path| !path.starts_with(&own) && !is_test(path) && names(path, "coherence"));
    assert!(all.len() <= MOST, "{} files name it: {all:#?}", all.len());
    let export = root.join("src/estimates/mod.rs");
    assert!(all.contains(&export), "{all:#?}");
}
