//! What a sweep has computed so far, kept so that it survives being killed.
//!
//! A directory holds `sweep.json`, what is swept, and `members.jsonl`, a line a member that is done,
//! in the order in which they were. A line is written at once and counts when its end is there; a
//! line cut short is taken off when the sweep goes on.

use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use super::axis::{self, Axis};
use super::measures::Measures;
use crate::{Error, Result};

pub(super) const REQUEST: &str = "sweep.json";
const MEMBERS: &str = "members.jsonl";

/// What is swept: equal requests have equal members.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Results of different versions are not mixed.
    pub version: String,
    /// The scene that is varied, as its text.
    pub scene: String,
    pub vary: Vec<Axis>,
}

/// What became of a member.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    Done(Measures),
    /// Why its run failed.
    Failed(String),
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    member: usize,
    outcome: Outcome,
}

/// The members that are known, by their index in the product of the axes.
pub type Outcomes = BTreeMap<usize, Outcome>;

/// An open directory; no other process can add to it meanwhile.
#[derive(Debug)]
pub(super) struct Ledger {
    path: PathBuf,
    file: Mutex<File>,
}

impl Ledger {
    /// Opens the directory of a sweep, made where nothing is there, with what is known already.
    pub(super) fn open(
        directory: &Path,
        request: &Request,
        members: usize,
    ) -> Result<(Ledger, Outcomes)> {
        let occupied = |found: String| Error::Occupied {
            path: directory.to_owned(),
            found,
        };
        let is_new = match fs::read_dir(directory) {
            // One that was killed before it began has left its request half-written.
            Ok(entries) => entries.flatten().all(|entry| {
                let name = entry.file_name();
                name.to_string_lossy().starts_with(&partial_prefix(REQUEST))
            }),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => true,
            Err(error) if error.kind() == std::io::ErrorKind::NotADirectory => {
                return Err(occupied("is a file".into()));
            }
            Err(error) => return Err(Error::read("read", directory)(error)),
        };
        if is_new {
            fs::create_dir_all(directory).map_err(Error::write("create", directory))?;
            write_whole(directory, REQUEST, &to_json(request)?)?;
        } else {
            let found = read_request(directory)?
                .ok_or_else(|| occupied("holds something other than a sweep".into()))?;
            if let Some(difference) = difference(&found, request) {
                return Err(occupied(format!("holds another sweep: {difference}")));
            }
        }
        let path = directory.join(MEMBERS);
        let mut file = File::options()
            .read(true)
            .append(true)
            .create(true)
            .open(&path)
            .map_err(Error::write("open", &path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(Error::Busy {
                    path: directory.to_owned(),
                });
            }
            // A file system without locks: the user keeps two processes apart.
            Err(TryLockError::Error(_)) => {}
        }
        let (outcomes, whole) = parse(&mut file, &path, members)?;
        file.set_len(whole).map_err(Error::write("cut", &path))?;
        let file = Mutex::new(file);
        Ok((Ledger { path, file }, outcomes))
    }

    /// Adds a member that is done.
    pub(super) fn add(&self, member: usize, outcome: &Outcome) -> Result<()> {
        let line = Line {
            member,
            outcome: outcome.clone(),
        };
        let mut text = to_json(&line)?;
        text.push('\n');
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let before = file.seek(SeekFrom::End(0));
        let written = before.and_then(|end| {
            file.write_all(text.as_bytes()).inspect_err(|_| {
                // What was written of the line must not be continued by the next one.
                let _ = file.set_len(end);
            })
        });
        written.map_err(Error::write("append to", &self.path))
    }

    /// Sees to it that what was added is on the disk.
    pub(super) fn settle(&self) -> Result<()> {
        let file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.sync_data().map_err(Error::write("write", &self.path))
    }
}

/// What a directory holds of a sweep.
///
/// # Errors
/// [`Error::Read`] where it cannot be read or holds none; [`Error::Damaged`] for a line that is no
/// member.
pub fn read(directory: &Path) -> Result<(Request, Outcomes)> {
    let none = || {
        let none = std::io::Error::new(std::io::ErrorKind::NotFound, "no sweep is there");
        Error::read("read", directory)(none)
    };
    let request = read_request(directory)?.ok_or_else(none)?;
    let path = directory.join(MEMBERS);
    let mut file = match File::open(&path) {
        Ok(file) => file,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Ok((request, Outcomes::new()));
        }
        Err(error) => return Err(Error::read("open", &path)(error)),
    };
    let members = axis::count(&request.vary)?;
    let (outcomes, _) = parse(&mut file, &path, members)?;
    Ok((request, outcomes))
}

/// The members of a file and the length of its whole lines; the first line of a member counts.
fn parse(file: &mut File, path: &Path, members: usize) -> Result<(Outcomes, u64)> {
    let mut text = Vec::new();
    file.seek(SeekFrom::Start(0))
        .and_then(|_| file.read_to_end(&mut text))
        .map_err(Error::read("read", path))?;
    let whole = text
        .iter()
        .rposition(|b| *b == b'\n')
        .map_or(0, |at| at + 1);
    let mut outcomes = Outcomes::new();
    for (number, line) in text[..whole].split_inclusive(|b| *b == b'\n').enumerate() {
        let damaged = |reason: String| Error::Damaged {
            path: path.to_owned(),
            line: number + 1,
            reason,
        };
        let line: Line =
            serde_json::from_slice(line).map_err(|error| damaged(error.to_string()))?;
        if line.member >= members {
            let found = line.member;
            return Err(damaged(format!(
                "expected a member below {members}, found {found}"
            )));
        }
        outcomes.entry(line.member).or_insert(line.outcome);
    }
    Ok((outcomes, whole as u64))
}

fn read_request(directory: &Path) -> Result<Option<Request>> {
    let path = directory.join(REQUEST);
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(Error::read("read", &path)(error)),
    };
    match serde_json::from_str(&text) {
        Ok(request) => Ok(Some(request)),
        Err(error) => Err(Error::Damaged {
            line: error.line(),
            reason: error.to_string(),
            path,
        }),
    }
}

/// In what two requests differ, found in a directory and asked for.
pub(super) fn difference(found: &Request, asked: &Request) -> Option<String> {
    let varies = |request: &Request| {
        let of_axis = |axis: &Axis| {
            let (first, last) = (axis.values.first(), axis.values.last());
            let end = |v: Option<&String>| v.cloned().unwrap_or_default();
            let n = axis.values.len();
            format!(
                "{} from {} to {} in {n} values",
                axis.key,
                end(first),
                end(last)
            )
        };
        let axes: Vec<String> = request.vary.iter().map(of_axis).collect();
        axes.join(", ")
    };
    if found.version != asked.version {
        let (found, asked) = (&found.version, &asked.version);
        Some(format!("it was made by version {found}, this is {asked}"))
    } else if found.vary != asked.vary {
        Some(format!("it varies {}", varies(found)))
    } else if found.scene != asked.scene {
        let line = found
            .scene
            .lines()
            .zip(asked.scene.lines())
            .position(|(a, b)| a != b);
        let shorter = found.scene.lines().count().min(asked.scene.lines().count());
        Some(format!(
            "its scene differs in line {}",
            line.unwrap_or(shorter) + 1
        ))
    } else {
        None
    }
}

fn partial_prefix(name: &str) -> String {
    format!(".{name}.partial-")
}

/// Writes a file beside its place, then renames it.
pub(super) fn write_whole(directory: &Path, name: &str, text: &str) -> Result<PathBuf> {
    let path = directory.join(name);
    let partial = directory.join(partial_prefix(name) + &std::process::id().to_string());
    fs::write(&partial, text).map_err(Error::write("write", &partial))?;
    fs::rename(&partial, &path).map_err(Error::write("rename to", &path))?;
    Ok(path)
}

fn to_json(value: &impl Serialize) -> Result<String> {
    serde_json::to_string(value).map_err(|error| {
        let path = Path::new(MEMBERS);
        Error::write("encode", path)(error.into())
    })
}
