//! The program with recorded file operations, one of which fails.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use crate::place::Place;

/// Calls that were made, in order; one is `[name, path, other path, number]`.
pub type Record = Vec<[String; 4]>;

/// An error that calls fail with, by its number on Linux.
#[derive(Debug, Clone, Copy)]
pub enum Fault {
    /// The disk cannot be read or written.
    Disk = 5,
    /// The disk is full.
    Full = 28,
}

/// The preloaded library; `None`, with a line, where it cannot be compiled.
fn library() -> Option<&'static Path> {
    static BUILT: OnceLock<Option<(tempfile::TempDir, PathBuf)>> = OnceLock::new();
    let built = BUILT.get_or_init(|| {
        let folder = tempfile::tempdir().ok()?;
        let library = folder.path().join("preload.so");
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/src/preload.c");
        let compiled = Command::new("cc")
            .args(["-shared", "-fPIC", "-O1", "-o"])
            .args([library.as_os_str(), source.as_ref(), "-ldl".as_ref()])
            .arg("-lpthread")
            .status();
        let is_built = compiled.is_ok_and(|status| status.success());
        is_built.then_some((folder, library))
    });
    match built {
        Some((_, library)) => Some(library),
        None => {
            eprintln!("SKIPPED: this machine has no `cc` to compile a preloaded library with");
            None
        }
    }
}

/// Runs the program with its calls recorded, of which the n-th fails; `None` where this cannot be
/// done.
pub fn run(
    place: &Place,
    words: &[&str],
    fails: Option<(usize, Fault)>,
) -> Option<(Output, Record)> {
    let variables = fails.map(|(n, fault)| {
        let (n, error) = (n.to_string(), (fault as i32).to_string());
        [("CASCADE_TEST_FAIL", n), ("CASCADE_TEST_ERRNO", error)]
    });
    let (output, mut record) = recorded(place, words, variables.as_slice().as_flattened())?;
    record.retain(|call| call[0] != "asked");
    Some((output, record))
}

/// Runs the program with its n-th request for memory refused, of those for 8 KiB and more; also returns
/// how many there were. `None` where this cannot be done.
pub fn refusing(place: &Place, words: &[&str], n: Option<usize>) -> Option<(Output, usize)> {
    let variable = n.map(|n| ("CASCADE_TEST_REFUSE", n.to_string()));
    let (output, record) = recorded(place, words, variable.as_slice())?;
    let asked = record.iter().rfind(|call| call[0] == "asked");
    Some((output, asked.map_or(0, |call| call[1].parse().unwrap())))
}

/// Runs the program beside the preloaded library, with these variables.
fn recorded(
    place: &Place,
    words: &[&str],
    variables: &[(&str, String)],
) -> Option<(Output, Record)> {
    let library = library()?;
    let log = tempfile::NamedTempFile::new().ok()?;
    let mut command = place.command(words);
    command
        .env("LD_PRELOAD", library)
        .env("CASCADE_TEST_ROOT", place.folder())
        .env("CASCADE_TEST_LOG", log.path())
        .envs(variables.iter().map(|(name, value)| (name, value)));
    let output = command.output().unwrap();
    let text = fs::read_to_string(log.path()).unwrap();
    let parts = |line: &str| {
        let mut parts = line.split('\t').map(str::to_owned);
        [(); 4].map(|()| parts.next().unwrap_or_default())
    };
    Some((output, text.lines().map(parts).collect()))
}
