//! No room grows: lines of code of each, neither blank nor comment, against a table that may only be lowered.

use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;

use crate::rooms::{files, root};

/// A row is lowered when its rooms have shrunk by so much.
const SLACK: usize = 100;

/// Lines of code of the files whose paths begin so; not of tests, benches and examples below them.
fn lines(begin: &str) -> usize {
    let (folder, name) = begin.rsplit_once('/').unwrap();
    let folder = root().join(folder);
    let is_mine = |path: &PathBuf| {
        let inside = path.strip_prefix(&folder).unwrap();
        let is_apart = |part: &OsStr| part == "tests" || part == "benches" || part == "examples";
        inside.to_string_lossy().starts_with(name) && !inside.iter().any(is_apart)
    };
    let is_code = |line: &&str| !line.trim().is_empty() && !line.trim().starts_with("//");
    let count = |path| {
        fs::read_to_string(path)
            .unwrap()
            .lines()
            .filter(is_code)
            .count()
    };
    let all = files(&folder, &[".rs"]).into_iter().filter(is_mine);
    all.map(count).sum()
}

#[test]
fn regress_rooms_do_not_grow() {
    let table = fs::read_to_string(root().join("tests/house/lines.txt")).unwrap();
    for row in table.lines().filter(|row| !row.starts_with('#')) {
        let words: Vec<&str> = row.split_whitespace().collect();
        let most: usize = words[0].parse().unwrap();
        let now = words[1..].iter().map(|begin| lines(begin)).sum();
        assert!(
            (most.saturating_sub(SLACK)..=most).contains(&now),
            "{row}: now {now}"
        );
    }
}
