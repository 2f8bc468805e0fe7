//! A folder of its own to run the program in.
#![allow(dead_code)] // each test uses a part of it

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;

/// A folder that goes with the test, and the words that every command in it begins with.
pub struct Place {
    folder: tempfile::TempDir,
    first: &'static [&'static str],
}

impl Place {
    pub fn new() -> Place {
        Place::of(&[])
    }

    pub fn of(first: &'static [&'static str]) -> Place {
        let folder = tempfile::tempdir().unwrap();
        Place { folder, first }
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder().join(name)
    }

    pub fn names(&self) -> BTreeSet<String> {
        let entries = fs::read_dir(self.folder()).unwrap();
        let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
        entries
            .map(|entry| name(entry).into_string().unwrap())
            .collect()
    }

    pub fn run(&self, words: &[&str]) -> Output {
        let mut command = Command::cargo_bin("cascade").unwrap();
        let words = self.first.iter().chain(words);
        command
            .current_dir(self.folder())
            .args(words)
            .output()
            .unwrap()
    }

    pub fn good(&self, words: &[&str]) -> String {
        let output = self.run(words);
        assert_eq!(output.status.code(), Some(0), "{words:?}: {output:?}");
        assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{words:?}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs to a failure that leaves the place as it was.
    pub fn bad(&self, code: i32, words: &[&str]) -> String {
        let before = self.names();
        let output = self.run(words);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{words:?}: {said}");
        assert!(
            said.starts_with("error: ") && !said.contains("panicked"),
            "{said}"
        );
        assert_eq!(self.names(), before, "{words:?}: {said}");
        said
    }
}
