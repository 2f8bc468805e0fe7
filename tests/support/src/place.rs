//! A folder of its own to run the program in.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use ndarray::{Array2, ArrayD};
use ndarray_npy::{NpzReader, ReadableElement, WritableElement, write_npy};
use serde_json::Value;

/// The environment of a user without a configuration of their own, whoever runs the tests.
pub const NO_CONFIGURATION: [(&str, &str); 2] = [
    ("XDG_CONFIG_HOME", "/no-configuration"),
    ("APPDATA", "/no-configuration"),
];

/// A folder that goes with the test, and the words that every command in it begins with.
pub struct Place {
    folder: tempfile::TempDir,
    first: &'static [&'static str],
}

impl Default for Place {
    fn default() -> Self {
        Place::new()
    }
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

    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.folder().join(name)
    }

    pub fn names(&self) -> BTreeSet<String> {
        names(self.folder())
    }

    pub fn save<T: WritableElement>(&self, name: &str, field: &Array2<T>) {
        write_npy(self.path(name), field).unwrap();
    }

    pub fn write(&self, name: impl AsRef<Path>, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).unwrap();
    }

    pub fn read(&self, name: impl AsRef<Path>) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// Asserts that a folder has these files, whose names hold no blanks.
    #[track_caller]
    pub fn has(&self, folder: &str, names: &str) {
        for name in names.split(' ') {
            let path = self.path(folder).join(name);
            assert!(path.exists(), "{folder}/{name}: {:?}", self.names());
        }
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(name)).unwrap()).unwrap()
    }

    /// Names of the arrays in an archive.
    pub fn arrays(&self, archive: &str) -> BTreeSet<String> {
        let names = self.archive(archive).names().unwrap();
        let name = |name: &String| name.trim_end_matches(".npy").to_owned();
        names.iter().map(name).collect()
    }

    pub fn array<T: ReadableElement>(&self, archive: &str, name: &str) -> ArrayD<T> {
        let mut archive = self.archive(archive);
        archive.by_name(&format!("{name}.npy")).unwrap()
    }

    fn archive(&self, name: &str) -> NpzReader<fs::File> {
        NpzReader::new(fs::File::open(self.path(name)).unwrap()).unwrap()
    }

    pub fn command(&self, words: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Command {
        let mut command = Command::cargo_bin("cascade").unwrap();
        command
            .current_dir(self.folder())
            .envs(NO_CONFIGURATION)
            .env_remove("CLICOLOR_FORCE")
            .env_remove("NO_COLOR")
            // Sentences that a test looks for are not wrapped.
            .env("COLUMNS", "1000")
            .args(self.first)
            .args(words);
        command
    }

    pub fn run(&self, words: &[&str]) -> Output {
        self.command(words).output().unwrap()
    }

    /// Runs to a good end and returns standard output.
    pub fn good(&self, words: &[&str]) -> String {
        let output = self.run(words);
        assert_eq!(output.status.code(), Some(0), "{words:?}: {output:?}");
        assert_eq!(text(&output.stderr), "", "{words:?}");
        text(&output.stdout)
    }

    /// [`Place::good`] of a command line whose words hold no blanks.
    pub fn says(&self, line: &str) -> String {
        self.good(&line.split_whitespace().collect::<Vec<_>>())
    }

    /// [`Place::bad`] of such a line.
    pub fn refuses(&self, code: i32, line: &str) -> String {
        self.bad(code, &line.split_whitespace().collect::<Vec<_>>())
    }

    /// The JSON that [`Place::says`] returns.
    pub fn says_json(&self, line: &str) -> Value {
        serde_json::from_str(&self.says(line)).unwrap()
    }

    /// [`Place::refuses`] for a reason that has this word.
    #[track_caller]
    pub fn refuses_for(&self, code: i32, line: &str, named: &str) {
        let said = self.refuses(code, line);
        assert!(said.contains(named), "{line}: no {named:?} in {said}");
    }

    /// Runs to a failure that leaves the place as it was and prints nothing else, and returns
    /// standard error.
    pub fn bad(&self, code: i32, words: &[&str]) -> String {
        let before = self.names();
        let output = self.run(words);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{words:?}: {said}");
        assert_eq!(text(&output.stdout), "", "{words:?}");
        assert!(
            said.starts_with("error: ") && !said.contains("panicked"),
            "{words:?}: {said}"
        );
        assert_eq!(self.names(), before, "{words:?}: {said}");
        said
    }
}

pub fn program() -> PathBuf {
    assert_cmd::cargo::cargo_bin("cascade")
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

pub fn names(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap();
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
    entries
        .map(|entry| name(entry).into_string().unwrap())
        .collect()
}

pub fn set(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|&n| n.to_owned()).collect()
}

/// Waits until a program handles interrupts: one that comes before that ends it without a word.
pub fn wait_for_handler(child: &mut std::process::Child) {
    let status = format!("/proc/{}/status", child.id());
    let handles = || {
        let text = fs::read_to_string(&status).ok()?;
        let caught = text.lines().find_map(|line| line.strip_prefix("SigCgt:"))?;
        let mask = u64::from_str_radix(caught.trim(), 16).ok()?;
        // Signal 2 is the second bit.
        Some(mask & 2 != 0)
    };
    while child.try_wait().unwrap().is_none() {
        match (handles(), cfg!(target_os = "linux")) {
            (Some(true), _) => return,
            // Elsewhere nothing tells.
            (_, false) => return std::thread::sleep(std::time::Duration::from_secs(2)),
            _ => std::thread::yield_now(),
        }
    }
}
