//! What killed runs have left, and its removal.

use std::collections::BTreeSet;
use std::fs;
use std::io::Result;
use std::path::Path;
use std::time::{Duration, SystemTime};

use super::durable::remove;
use super::lock::Released;
use super::{LOCK, OLD, beside, is_there, stem_of};

/// Age from which something that no lock can tell about counts as left.
const DAY: Duration = Duration::from_secs(24 * 60 * 60);

/// Removes what no living process holds in `folder`, and restores earlier results that killed runs
/// have moved away. What cannot be removed stays: no work depends on it.
pub fn remove_abandoned(folder: &Path) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name());
    let stems: BTreeSet<String> = names
        .filter_map(|name| Some(stem_of(&name)?.into()))
        .collect();
    for stem in stems {
        let _ = remove_one(folder, &folder.join(stem));
    }
}

/// Removes a working file or directory with what belongs to it, unless somebody may still write it.
fn remove_one(folder: &Path, working: &Path) -> Result<()> {
    let (lock, old) = (beside(working, LOCK), beside(working, OLD));
    let parts = [&old, working, &lock];
    let mut released = None;
    // The lock is there before and after all else: what has none belongs to nobody.
    if is_there(&lock) {
        let Some(found) = Released::take(&lock) else {
            return Ok(());
        };
        // Two machines that share a disk may not share locks.
        if !found.is_of_this_machine && is_network(folder) && !is_older(&parts, DAY) {
            return Ok(());
        }
        released = Some(found);
    }
    if is_there(&old) {
        // An earlier result whose name is not known may be the only one.
        let Some(target) = released.as_ref().and_then(|found| found.target.as_ref()) else {
            return Ok(());
        };
        let target = folder.join(target);
        if !is_there(&target) {
            fs::rename(&old, &target)?;
        }
    }
    parts.into_iter().try_for_each(remove)
}

/// Whether all of `paths`, and what is below them, changed longer ago than `age`; no, where the system does not say.
fn is_older(paths: &[&Path], age: Duration) -> bool {
    let last = paths.iter().flat_map(|path| times(path)).max();
    let passed = last.and_then(|last| SystemTime::now().duration_since(last).ok());
    passed.is_some_and(|passed| passed >= age)
}

/// Times of the last change of a file, or of a directory and all that is below it.
fn times(path: &Path) -> Vec<SystemTime> {
    let own = fs::symlink_metadata(path).and_then(|found| found.modified());
    let mut times: Vec<SystemTime> = own.into_iter().collect();
    if !path.is_symlink() {
        let below = fs::read_dir(path).into_iter().flatten().flatten();
        times.extend(below.flat_map(|entry| self::times(&entry.path())));
    }
    times
}

/// Whether other machines may write to `folder`, too.
#[cfg(target_os = "linux")]
fn is_network(folder: &Path) -> bool {
    /// Magic numbers of `statfs`: NFS, SMB 1 to 3, FUSE, 9P, Lustre, Ceph, GPFS, AFS, BeeGFS and
    /// OCFS2.
    const NETWORK: [u32; 12] = [
        0x6969, 0x517b, 0xff534d42, 0xfe534d42, 0x65735546, 0x01021997, 0x0bd00bd0, 0x00c36400,
        0x47504653, 0x5346414f, 0x19830326, 0x7461636f,
    ];
    // Of one that does not tell the worst is assumed.
    rustix::fs::statfs(folder).map_or(true, |found| NETWORK.contains(&(found.f_type as u32)))
}

#[cfg(not(target_os = "linux"))]
fn is_network(_: &Path) -> bool {
    true
}
