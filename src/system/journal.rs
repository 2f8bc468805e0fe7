//! A journal of long work: finished members are on disk, so the work survives being killed.
//!
//! A directory holds the request in one file, and `members.jsonl` with one line for each finished
//! member, in order of completion. A line is written in one piece and is valid once its newline is
//! there; an incomplete last line is removed when the work resumes.

use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::publish;
use crate::{Error, Result};

const MEMBERS: &str = "members.jsonl";

/// How often, and after what time, a directory that is in use is tried again.
const LOCK_TRIES: usize = 10;
const LOCK_PAUSE: Duration = Duration::from_millis(20);

/// The request of long work: equal requests have equal members.
pub(crate) trait StoredRequest: Serialize + DeserializeOwned {
    /// The file that holds it.
    const FILE: &'static str;
    /// What messages call the work.
    const WORD: &'static str;

    /// In what another request differs.
    fn difference(&self, asked: &Self) -> Option<String>;
}

/// The name of a member.
pub(crate) trait Key: Clone + Ord + Serialize + DeserializeOwned {}
impl<K: Clone + Ord + Serialize + DeserializeOwned> Key for K {}

/// The result of a member.
pub(crate) trait Measures: Clone + Serialize + DeserializeOwned {}
impl<M: Clone + Serialize + DeserializeOwned> Measures for M {}

/// Checks the name of a member; the error is the reason.
pub(crate) type Check<K> = Box<dyn Fn(&K) -> std::result::Result<(), String>>;

/// What became of a member.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome<M> {
    Done(M),
    /// Why its run failed.
    Failed(String),
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct JournalLine<K, M> {
    member: K,
    outcome: Outcome<M>,
}

/// The members that are known, by their names.
pub type Outcomes<K, M> = BTreeMap<K, Outcome<M>>;

/// An open directory; no other process can add to it meanwhile.
#[derive(Debug)]
pub(crate) struct Journal {
    path: PathBuf,
    file: Mutex<File>,
}

impl Journal {
    /// Opens the directory of a sweep, or creates it, and reads the finished members.
    pub(crate) fn open<A: StoredRequest, K: Key, M: Measures>(
        directory: &Path,
        asked: &A,
        check: &dyn Fn(&K) -> std::result::Result<(), String>,
    ) -> Result<(Journal, Outcomes<K, M>)> {
        let occupied = |found: String| Error::OutputInUse {
            path: directory.to_owned(),
            found,
        };
        let is_new = match fs::read_dir(directory) {
            // One that was killed before it began has left its request half-written.
            Ok(mut entries) => entries
                .all(|entry| entry.is_ok_and(|entry| publish::is_working_name(&entry.file_name()))),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => true,
            Err(error) if error.kind() == std::io::ErrorKind::NotADirectory => {
                return Err(occupied("is a file".into()));
            }
            Err(error) => return Err(Error::read("read", directory)(error)),
        };
        if is_new {
            fs::create_dir_all(directory).map_err(Error::write("create", directory))?;
            write_whole(directory, A::FILE, to_json(asked)?.as_bytes())?;
        } else {
            let found = read_asked::<A>(directory)?
                .ok_or_else(|| occupied(format!("holds something other than a {}", A::WORD)))?;
            if let Some(difference) = found.difference(asked) {
                return Err(occupied(format!("holds another {}: {difference}", A::WORD)));
            }
        }
        let path = directory.join(MEMBERS);
        let mut file = File::options()
            .read(true)
            .append(true)
            .create(true)
            .open(&path)
            .map_err(Error::write("open", &path))?;
        publish::sync_directory(directory).map_err(Error::write("create", &path))?;
        // A process that is just being started by this one holds its files for an instant.
        let mut tries = 0;
        while let Err(TryLockError::WouldBlock) = file.try_lock() {
            tries += 1;
            if tries > LOCK_TRIES {
                return Err(Error::Busy {
                    path: directory.to_owned(),
                });
            }
            std::thread::sleep(LOCK_PAUSE);
        }
        publish::remove_abandoned(directory);
        // A file system without locks: the user keeps two processes apart.
        let (outcomes, whole) = parse(&mut file, &path, check)?;
        file.set_len(whole).map_err(Error::write("cut", &path))?;
        let file = Mutex::new(file);
        Ok((Journal { path, file }, outcomes))
    }

    /// Adds a member that is done.
    pub(crate) fn add<K: Key, M: Measures>(&self, member: &K, outcome: &Outcome<M>) -> Result<()> {
        let line = JournalLine {
            member: member.clone(),
            outcome: outcome.clone(),
        };
        let mut text = to_json(&line)?;
        text.push('\n');
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let before = file.seek(SeekFrom::End(0));
        let written = before.and_then(|end| {
            file.write_all(text.as_bytes()).inspect_err(|_| {
                // The next line must not continue a partly written one.
                let _ = file.set_len(end);
            })
        });
        written.map_err(Error::write("append to", &self.path))
    }

    /// Flushes the added lines to the disk.
    pub(crate) fn sync(&self) -> Result<()> {
        let file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.sync_data().map_err(Error::write("write", &self.path))
    }
}

/// Reads the journal of a directory; `check` validates the names of members.
///
/// # Errors
/// [`Error::Read`] if it cannot be read or holds no journal; [`Error::Damaged`] for an invalid
/// line.
pub(crate) fn read<A: StoredRequest, K: Key, M: Measures>(
    directory: &Path,
    check: impl Fn(&A) -> Result<Check<K>>,
) -> Result<(A, Outcomes<K, M>)> {
    let none = || {
        let none = format!("no {} is there", A::WORD);
        let none = std::io::Error::new(std::io::ErrorKind::NotFound, none);
        Error::read("read", directory)(none)
    };
    let asked = read_asked::<A>(directory)?.ok_or_else(none)?;
    let path = directory.join(MEMBERS);
    let mut file = match File::open(&path) {
        Ok(file) => file,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Ok((asked, Outcomes::new()));
        }
        Err(error) => return Err(Error::read("open", &path)(error)),
    };
    let check = check(&asked)?;
    let (outcomes, _) = parse(&mut file, &path, &*check)?;
    Ok((asked, outcomes))
}

/// The members of a file and the length of its whole lines; the first line of a member counts.
fn parse<K: Key, M: Measures>(
    file: &mut File,
    path: &Path,
    check: &dyn Fn(&K) -> std::result::Result<(), String>,
) -> Result<(Outcomes<K, M>, u64)> {
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
        let line: JournalLine<K, M> =
            serde_json::from_slice(line).map_err(|error| damaged(error.to_string()))?;
        check(&line.member).map_err(damaged)?;
        outcomes.entry(line.member).or_insert(line.outcome);
    }
    Ok((outcomes, whole as u64))
}

fn read_asked<A: StoredRequest>(directory: &Path) -> Result<Option<A>> {
    let path = directory.join(A::FILE);
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(Error::read("read", &path)(error)),
    };
    match serde_json::from_str(&text) {
        Ok(asked) => Ok(Some(asked)),
        Err(error) => Err(Error::Damaged {
            line: error.line(),
            reason: error.to_string(),
            path,
        }),
    }
}

/// Writes a file of a directory.
pub(crate) fn write_whole(directory: &Path, name: &str, bytes: &[u8]) -> Result<PathBuf> {
    let path = directory.join(name);
    publish::write_whole(&path, bytes).map_err(Error::write("write", &path))?;
    Ok(path)
}

fn to_json(value: &impl Serialize) -> Result<String> {
    serde_json::to_string(value).map_err(|error| {
        let path = Path::new(MEMBERS);
        Error::write("encode", path)(error.into())
    })
}
