//! A journal of long work: finished members are on disk, so the work survives being killed.
//!
//! A directory holds the request in one file, and `members.jsonl` with one line for each finished
//! member, in order of completion: `["HASH",MEMBER,OUTCOME]`. The hash (BLAKE3) covers the request and the rest of
//! the line. A line is written in one piece; one that is incomplete, damaged or of another request counts for nothing,
//! and its member is computed again.

use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::{ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard};
use std::time::Duration;

use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{lock, publish};
use crate::observer::{CancelOnly, Observer};
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
}

/// The name of a member.
pub(crate) trait Key: Measures + Ord + Sync {}
impl<K: Measures + Ord + Sync> Key for K {}

/// The result of a member.
pub(crate) trait Measures: Clone + Send + Serialize + DeserializeOwned {}
impl<M: Clone + Send + Serialize + DeserializeOwned> Measures for M {}

/// What became of a member.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome<M> {
    Done(M),
    /// Why its run failed.
    Failed(String),
}

impl<M> Outcome<M> {
    pub fn done(&self) -> Option<&M> {
        match self {
            Outcome::Done(measures) => Some(measures),
            Outcome::Failed(_) => None,
        }
    }
}

/// The members that are known, by their names.
pub type Outcomes<K, M> = BTreeMap<K, Outcome<M>>;

/// Members that are computed once, and saved where there is a directory; no other process can add to it meanwhile.
#[derive(Debug)]
pub(crate) struct Journal<K, M> {
    saved: Option<Saved>,
    outcomes: Mutex<Outcomes<K, M>>,
    computed: AtomicUsize,
}

#[derive(Debug)]
struct Saved {
    path: PathBuf,
    file: Mutex<File>,
    request: Hash,
}

/// Of a request, the key of the hashes of its lines.
type Hash = [u8; blake3::KEY_LEN];

impl<K: Key, M: Measures> Journal<K, M> {
    /// Opens the directory of the work, or creates it, and reads the finished members. Without one nothing is saved.
    ///
    /// # Errors
    /// [`Error::OutputInUse`] for a directory that holds something else, [`Error::Busy`], [`Error::Read`] and
    /// [`Error::Write`].
    pub(crate) fn open<A: StoredRequest>(
        directory: Option<&Path>,
        asked: &A,
    ) -> Result<Journal<K, M>> {
        let opened = directory.map(|directory| Saved::open(directory, asked));
        let (saved, outcomes) = opened.transpose()?.unzip();
        Ok(Journal {
            saved,
            outcomes: Mutex::new(outcomes.unwrap_or_default()),
            computed: AtomicUsize::new(0),
        })
    }

    /// What became of a member, if that is known.
    pub(crate) fn known(&self, member: &K) -> Option<Outcome<M>> {
        lock(&self.outcomes).get(member).cloned()
    }

    /// The members that are known.
    pub(crate) fn outcomes(&self) -> MutexGuard<'_, Outcomes<K, M>> {
        lock(&self.outcomes)
    }

    /// How many members were computed by this process.
    pub(crate) fn computed(&self) -> usize {
        self.computed.load(Relaxed)
    }

    /// What became of a member, which is run and saved unless that is known.
    ///
    /// # Errors
    /// What is no fault of the member: [`Error::Cancelled`], [`Error::Memory`], [`Error::Write`]; any other error
    /// becomes the outcome.
    pub(crate) fn member(&self, member: &K, run: impl FnOnce() -> Result<M>) -> Result<Outcome<M>> {
        if let Some(known) = self.known(member) {
            return Ok(known);
        }
        let outcome = match run() {
            Ok(measures) => Outcome::Done(measures),
            Err(error @ (Error::Cancelled | Error::Memory { .. })) => return Err(error),
            Err(error) => Outcome::Failed(error.to_string()),
        };
        self.add(member, outcome.clone())?;
        Ok(outcome)
    }

    /// Computes the members that are not known, in parallel on the current pool; one unit of progress each.
    ///
    /// # Errors
    /// As [`Journal::member`]; where results are saved, [`Error::Paused`] in place of [`Error::Cancelled`].
    pub(crate) fn each<T: Sync>(
        &self,
        stage: &'static str,
        members: &[T],
        observer: &dyn Observer,
        run: impl Fn(&T, &dyn Observer) -> Result<()> + Sync,
    ) -> Result<()> {
        observer.stage(stage, members.len() as u64);
        let result = members.par_iter().try_for_each(|member| {
            observer.go_on()?;
            run(member, &CancelOnly(observer))?;
            observer.advance(1);
            Ok(())
        });
        result.map_err(|error| self.paused(error, members.len()))
    }

    /// [`Error::Paused`] in place of [`Error::Cancelled`], where results are saved.
    pub(crate) fn paused(&self, error: Error, members: usize) -> Error {
        let known = self.outcomes().len();
        match error {
            Error::Cancelled if self.saved.is_some() => Error::Paused {
                known,
                members: members.max(known),
            },
            error => error,
        }
    }

    /// Adds a member that is done.
    pub(crate) fn add(&self, member: &K, outcome: Outcome<M>) -> Result<()> {
        if let Some(saved) = &self.saved {
            saved.append(&to_json(&(member, &outcome))?)?;
        }
        self.computed.fetch_add(1, Relaxed);
        self.outcomes().entry(member.clone()).or_insert(outcome);
        Ok(())
    }

    /// Flushes the added lines to the disk.
    pub(crate) fn sync(&self) -> Result<()> {
        let Some(saved) = &self.saved else {
            return Ok(());
        };
        let synced = lock(&saved.file).sync_data();
        synced.map_err(Error::write("write", &saved.path))
    }
}

impl Saved {
    fn open<A: StoredRequest, K: Key, M: Measures>(
        directory: &Path,
        asked: &A,
    ) -> Result<(Saved, Outcomes<K, M>)> {
        let occupied = |found: String| Error::OutputInUse {
            path: directory.to_owned(),
            found,
        };
        let listed = fs::read_dir(directory);
        if listed
            .as_ref()
            .is_err_and(|error| error.kind() == ErrorKind::NotADirectory)
        {
            return Err(occupied("is a file".into()));
        }
        // One that was killed before it began has left its request half-written.
        let mut entries = if_there(listed, directory)?.into_iter().flatten();
        let is_new =
            entries.all(|entry| entry.is_ok_and(|it| publish::is_working_name(&it.file_name())));
        if is_new {
            fs::create_dir_all(directory).map_err(Error::write("create", directory))?;
            write_whole(directory, A::FILE, to_json(asked)?.as_bytes())?;
        } else {
            let found = read_asked::<A>(directory)?
                .ok_or_else(|| occupied(format!("holds something other than a {}", A::WORD)))?;
            if let Some(difference) = difference(&found, asked) {
                return Err(occupied(format!("holds another {}: {difference}", A::WORD)));
            }
        }
        let path = directory.join(MEMBERS);
        let file = File::options().append(true).create(true).open(&path);
        let file = file.map_err(Error::write("open", &path))?;
        publish::sync_directory(directory).map_err(Error::write("create", &path))?;
        // A process that is just being started by this one holds its files for an instant. Where the file system has no
        // locks, the user keeps two processes apart.
        let is_ours = || !matches!(file.try_lock(), Err(TryLockError::WouldBlock));
        let mut pauses = (0..LOCK_TRIES).map(|_| std::thread::sleep(LOCK_PAUSE));
        if !is_ours() && !pauses.any(|()| is_ours()) {
            let path = directory.to_owned();
            return Err(Error::Busy { path });
        }
        publish::remove_abandoned(directory);
        let request = hash_of(asked)?;
        let text = fs::read(&path).map_err(Error::read("read", &path))?;
        let (outcomes, whole) = parse(&text, &request);
        file.set_len(whole).map_err(Error::write("cut", &path))?;
        let file = Mutex::new(file);
        let saved = Saved {
            path,
            file,
            request,
        };
        Ok((saved, outcomes))
    }

    /// Adds a line: a JSON array, whose first element is to be the hash of the others.
    fn append(&self, array: &str) -> Result<()> {
        let rest = &array[1..];
        let hash = blake3::keyed_hash(&self.request, rest.as_bytes()).to_hex();
        let line = format!("[\"{hash}\",{rest}\n");
        let mut file = lock(&self.file);
        let before = file.seek(SeekFrom::End(0));
        let written = before.and_then(|end| {
            file.write_all(line.as_bytes()).inspect_err(|_| {
                // The next line must not continue a partly written one.
                let _ = file.set_len(end);
            })
        });
        written.map_err(Error::write("append to", &self.path))
    }
}

/// The request and the members of a directory.
///
/// # Errors
/// [`Error::Read`] if it cannot be read or holds no journal; [`Error::Damaged`] where it has lines, and none of this
/// request.
pub(crate) fn read<A: StoredRequest, K: Key, M: Measures>(
    directory: &Path,
) -> Result<(A, Outcomes<K, M>)> {
    let none = std::io::Error::new(ErrorKind::NotFound, format!("no {} is there", A::WORD));
    let asked = read_asked::<A>(directory)?.ok_or_else(|| Error::read("read", directory)(none))?;
    let path = directory.join(MEMBERS);
    let text = if_there(fs::read(&path), &path)?.unwrap_or_default();
    let (outcomes, whole) = parse(&text, &hash_of(&asked)?);
    if outcomes.is_empty() && whole > 0 {
        return Err(Error::Damaged {
            path,
            line: 1,
            reason: format!("expected members of the request in {}, found none", A::FILE),
        });
    }
    Ok((asked, outcomes))
}

/// What was read of a file; `None` where there is none.
fn if_there<T>(read: std::io::Result<T>, path: &Path) -> Result<Option<T>> {
    match read {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        read => read.map(Some).map_err(Error::read("read", path)),
    }
}

/// The members of a text and the length of its whole lines; the first line of a member counts.
fn parse<K: Key, M: Measures>(text: &[u8], request: &Hash) -> (Outcomes<K, M>, u64) {
    let ends = text.iter().rposition(|b| *b == b'\n');
    let whole = ends.map_or(0, |at| at + 1);
    let mut outcomes = Outcomes::new();
    let lines = text[..whole].split(|b| *b == b'\n');
    for (member, outcome) in lines.filter_map(|line| member_of(line, request)) {
        outcomes.entry(member).or_insert(outcome);
    }
    (outcomes, whole as u64)
}

/// The member of a line; `None` where its hash is another.
fn member_of<K: Key, M: Measures>(line: &[u8], request: &Hash) -> Option<(K, Outcome<M>)> {
    let line = std::str::from_utf8(line).ok()?.strip_prefix("[\"")?;
    let (hash, rest) = line.split_once("\",")?;
    let is_whole = *blake3::keyed_hash(request, rest.as_bytes()).to_hex() == *hash;
    let read = || serde_json::from_str(&format!("[{rest}")).ok();
    is_whole.then(read)?
}

/// In what two requests differ, by the names of their fields.
pub(crate) fn difference<A: StoredRequest>(found: &A, asked: &A) -> Option<String> {
    let [found, asked] = [found, asked].map(|request| serde_json::to_value(request).ok());
    let fields = found.as_ref()?.as_object()?.iter();
    let differing =
        fields.filter(|(field, value)| asked.as_ref().and_then(|a| a.get(field)) != Some(value));
    let differing: Vec<&str> = differing.map(|(field, _)| field.as_str()).collect();
    (!differing.is_empty()).then(|| format!("it differs in {}", differing.join(", ")))
}

fn hash_of(asked: &impl StoredRequest) -> Result<Hash> {
    Ok(blake3::hash(to_json(asked)?.as_bytes()).into())
}

fn read_asked<A: StoredRequest>(directory: &Path) -> Result<Option<A>> {
    let path = directory.join(A::FILE);
    let Some(text) = if_there(fs::read_to_string(&path), &path)? else {
        return Ok(None);
    };
    let asked = serde_json::from_str(&text).map_err(|error| Error::Damaged {
        line: error.line(),
        reason: error.to_string(),
        path,
    })?;
    Ok(Some(asked))
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
