//! What killed runs have left, and its removal.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::Result;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::durable::remove;
use super::lock::{Found, examine};
use super::working::{lock_of, old_of};
use super::{LOCK, OLD, is_stem};

/// Age from which something that no lock can tell about counts as left.
const DAY: Duration = Duration::from_secs(24 * 60 * 60);

/// Whether somebody may still write something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hold {
    /// No process does.
    Nobody,
    /// A process does.
    Process,
    /// It changed less than a day ago, and nothing tells whether a process of another machine writes
    /// it.
    Recent,
    /// The file system has no locks, or the lock cannot be opened.
    Unknown,
    /// It is an earlier result whose name is not known, not to be removed.
    EarlierResult,
}

/// A working file or directory that was found.
#[derive(Debug)]
pub struct Leftover {
    /// Name that it was to get, if known.
    pub target: Option<OsString>,
    /// Whether it can be removed.
    pub hold: Hold,
    /// Earlier result that gets the name of the target again if that is gone.
    old: Option<PathBuf>,
    /// What is removed, in order.
    parts: Vec<PathBuf>,
    /// Keeps other cleaners away.
    _lock: Option<File>,
}

impl Leftover {
    /// Removes it; an earlier result whose name is free gets that again, which is then returned.
    ///
    /// # Errors
    /// The system's.
    ///
    /// # Panics
    /// If somebody may hold it.
    pub fn remove(self) -> Result<Option<PathBuf>> {
        assert_eq!(self.hold, Hold::Nobody, "removes what nobody holds");
        let mut restored = None;
        if let (Some(old), Some(target)) = (&self.old, &self.target) {
            let target = old.with_file_name(target);
            if fs::symlink_metadata(&target).is_err() {
                fs::rename(old, &target)?;
                restored = Some(target);
            }
        }
        for part in self.old.iter().chain(&self.parts) {
            remove(part)?;
        }
        Ok(restored)
    }

    /// What has the working name `stem` in `folder`.
    fn of(folder: &Path, stem: &str) -> Leftover {
        let working = folder.join(stem);
        let lock = lock_of(&working);
        let old = Some(old_of(&working)).filter(|old| is_there(old));
        let parts = vec![working.clone(), lock.clone()];
        let is_recent = || age(old.iter().chain(&parts)).is_none_or(|age| age < DAY);
        let (mut hold, target, held) = match is_there(&lock) {
            // The lock is there before and after all else.
            false => (Hold::Nobody, None, None),
            true => match examine(&lock) {
                Found::Held => (Hold::Process, None, None),
                Found::Unknown => (Hold::Unknown, None, None),
                Found::Free {
                    is_of_this_machine,
                    target,
                    _lock,
                } => {
                    // Two machines that share a disk may not share locks.
                    let may_be_held = !is_of_this_machine && is_network(folder) && is_recent();
                    let hold = match may_be_held {
                        true => Hold::Recent,
                        false => Hold::Nobody,
                    };
                    (hold, target, Some(_lock))
                }
            },
        };
        if hold == Hold::Nobody && old.is_some() && target.is_none() {
            hold = Hold::EarlierResult;
        }
        Leftover {
            target,
            hold,
            old,
            parts,
            _lock: held,
        }
    }
}

/// Working files and directories in `folder`, those of living processes, too.
///
/// # Errors
/// If the folder cannot be listed.
pub fn leftovers(folder: &Path) -> Result<Vec<Leftover>> {
    let names = names(folder)?;
    Ok(stems(&names)
        .map(|stem| Leftover::of(folder, stem))
        .collect())
}

/// Removes what no living process holds in `folder`, and restores earlier results that killed runs
/// have moved away. What cannot be removed stays: no work depends on it.
pub fn remove_abandoned(folder: &Path) {
    let Ok(names) = names(folder) else { return };
    for stem in stems(&names) {
        let found = Leftover::of(folder, stem);
        if found.hold == Hold::Nobody {
            let _ = found.remove();
        }
    }
}

fn names(folder: &Path) -> Result<Vec<OsString>> {
    let entries = fs::read_dir(folder)?;
    entries.map(|entry| Ok(entry?.file_name())).collect()
}

/// Each working name once.
fn stems(names: &[OsString]) -> impl Iterator<Item = &str> {
    let stems = names.iter().filter_map(|name| stem_of(name));
    stems.collect::<BTreeSet<_>>().into_iter()
}

fn stem_of(name: &OsStr) -> Option<&str> {
    let name = name.to_str()?;
    let stem = name.strip_suffix(LOCK).or(name.strip_suffix(OLD));
    Some(stem.unwrap_or(name)).filter(|stem| is_stem(stem))
}

fn is_there(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok()
}

/// Time since the last change of any of `paths` and what is below them; `None` if not known.
fn age<'a>(paths: impl IntoIterator<Item = &'a PathBuf>) -> Option<Duration> {
    let last = paths.into_iter().flat_map(|path| times(path)).max()?;
    SystemTime::now().duration_since(last).ok()
}

/// Times of the last change of a file, or of a directory and all that is below it.
fn times(path: &Path) -> Box<dyn Iterator<Item = SystemTime>> {
    let Ok(found) = fs::symlink_metadata(path) else {
        return Box::new(std::iter::empty());
    };
    let entries = found.is_dir().then(|| fs::read_dir(path).ok()).flatten();
    let entries = entries.into_iter().flatten().flatten();
    let below = entries.flat_map(|entry| times(&entry.path()));
    Box::new(found.modified().ok().into_iter().chain(below))
}

/// Whether other machines may write to `folder`, too.
#[cfg(target_os = "linux")]
fn is_network(folder: &Path) -> bool {
    /// Magic numbers of `statfs`: NFS, SMB 1 to 3, FUSE, 9P, Lustre, Ceph, GPFS, AFS, BeeGFS and
    /// OCFS2.
    const NETWORK: [u32; 12] = [
        0x6969,
        0x517b,
        0xff53_4d42,
        0xfe53_4d42,
        0x6573_5546,
        0x0102_1997,
        0x0bd0_0bd0,
        0x00c3_6400,
        0x4750_4653,
        0x5346_414f,
        0x1983_0326,
        0x7461_636f,
    ];
    // Of one that does not tell the worst is assumed.
    rustix::fs::statfs(folder).map_or(true, |found| NETWORK.contains(&(found.f_type as u32)))
}

#[cfg(not(target_os = "linux"))]
fn is_network(_: &Path) -> bool {
    true
}
