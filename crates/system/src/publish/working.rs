//! A file or directory while it is written.

use std::fs::{self, File};
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};

use super::abandoned::remove_abandoned;
use super::durable::{remove, rename_at_once, rename_new, sync_directory, sync_tree};
use super::{LOCK, OLD, beside, is_there, lock};

/// How often a folder is made that another run removes in the same moment.
const TRIES: usize = 8;

/// A file or directory that is written beside its target under a random name and then gets the name
/// of the target.
///
/// Three names belong together: `.cascade-partial-0123456789abcdef` is what is written,
/// `.lock` behind it is a file that the owner created exclusively and keeps locked, and `.old` is an
/// earlier result between two renames, where the system cannot exchange names at once. The lock file
/// exists before and after the others, so what is found without a locked one belongs to nobody. It
/// holds the name of the target: a run that finds an `.old` whose target is gone restores it.
///
/// Dropped before [`Working::publish`], it removes what was written, and the folders it made for it.
#[derive(Debug)]
pub struct Working {
    target: PathBuf,
    /// Folder of the target and of the working file.
    folder: PathBuf,
    path: PathBuf,
    /// Open, and so locked, as long as this lives.
    lock: File,
    /// Folders that were not there, innermost first.
    made: Vec<PathBuf>,
    state: State,
}

/// What has the name of the target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// What had it before, if anything.
    Unpublished,
    /// What was written.
    Published,
    /// What was written; what had it before has the working name.
    Swapped,
}

impl Working {
    /// Reserves a name beside `target`; makes the folders that are missing, and removes what killed
    /// runs have left in the folder.
    ///
    /// # Errors
    /// The system's.
    pub fn reserve(target: &Path) -> Result<Working> {
        let name = target.file_name().ok_or(ErrorKind::InvalidInput)?;
        let folder = folder_of(target);
        let mut made: Vec<PathBuf> = Vec::new();
        let mut tries = 1..TRIES;
        let (lock, path) = loop {
            let missing = folder.ancestors().take_while(|path| !is_there(path));
            made.extend(missing.map(Path::to_owned));
            match fs::create_dir_all(&folder).and_then(|()| lock::create(&folder, name)) {
                Ok(created) => break created,
                // Another run that failed has just removed the folder it had made.
                Err(error) if error.kind() == ErrorKind::NotFound && tries.next().is_some() => {}
                Err(error) => {
                    remove_empty(&made);
                    return Err(error);
                }
            }
        };
        remove_abandoned(&folder);
        Ok(Working {
            target: target.to_owned(),
            folder,
            path,
            lock,
            made,
            state: State::Unpublished,
        })
    }

    /// That something could be written beside `target`, without making folders that are missing.
    ///
    /// # Errors
    /// The system's.
    pub fn check(target: &Path) -> Result<()> {
        let name = target.file_name().ok_or(ErrorKind::InvalidInput)?;
        let folder = folder_of(target);
        let there = folder.ancestors().find(|path| is_there(path));
        let there = there.filter(|path| !path.as_os_str().is_empty());
        let (_lock, working) = lock::create(there.unwrap_or(Path::new(".")), name)?;
        remove_abandoned(&folder);
        fs::remove_file(beside(&working, LOCK))
    }

    /// Where to write.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Creates the file to be written.
    ///
    /// # Errors
    /// The system's.
    pub fn create_file(&self) -> Result<File> {
        File::create_new(&self.path)
    }

    /// Creates the directory to be filled.
    ///
    /// # Errors
    /// The system's.
    pub fn create_directory(&self) -> Result<()> {
        fs::create_dir(&self.path)
    }

    /// Gives what was written the name of the target, in place of a file or an empty directory of
    /// that name. It is on the disk, with its name, when this returns.
    ///
    /// # Errors
    /// The system's. An older target is untouched unless only the last sync failed.
    pub fn publish(&mut self) -> Result<()> {
        self.give_name(State::Published, |it| fs::rename(&it.path, &it.target))
    }

    /// As [`Working::publish`], in place of nothing.
    ///
    /// # Errors
    /// The system's, [`ErrorKind::AlreadyExists`] where something has the name of the target.
    pub fn publish_new(&mut self) -> Result<()> {
        self.give_name(State::Published, |it| rename_new(&it.path, &it.target))
    }

    /// Waits until no other process that does the same gives several files in the folder of the target their
    /// names, and keeps others waiting as long as the result lives.
    pub fn lock_names(&self) -> Option<File> {
        let folder = File::open(&self.folder).ok()?;
        folder.lock().is_ok().then_some(folder)
    }

    /// Exchanges what was written with the target, which is there. When dropped, the old one goes.
    ///
    /// # Errors
    /// The system's, with the target as it was; or, where names cannot be exchanged at once, the
    /// place to which the old target was moved.
    pub fn swap(&mut self) -> Result<()> {
        self.give_name(State::Swapped, Working::exchange)
    }

    fn give_name(&mut self, given: State, rename: fn(&Working) -> Result<()>) -> Result<()> {
        sync_tree(&self.path)?;
        rename(self)?;
        self.state = given;
        self.sync_names()
    }

    /// Undoes [`Working::publish`] or [`Working::swap`].
    ///
    /// # Errors
    /// The system's.
    pub fn withdraw(&mut self) -> Result<()> {
        match self.state {
            State::Unpublished => return Ok(()),
            State::Published => fs::rename(&self.target, &self.path)?,
            State::Swapped => self.exchange()?,
        }
        self.state = State::Unpublished;
        self.sync_names()
    }

    fn exchange(&self) -> Result<()> {
        match rename_at_once(&self.path, &self.target, true)? {
            true => Ok(()),
            false => self.swap_by_renames(),
        }
    }

    /// A kill between the renames leaves the old target under a name from which the next run
    /// restores it.
    fn swap_by_renames(&self) -> Result<()> {
        let old = beside(&self.path, OLD);
        // Has the name of the target on the disk.
        self.lock.sync_all()?;
        sync_directory(&self.folder)?;
        fs::rename(&self.target, &old)?;
        if let Err(error) = fs::rename(&self.path, &self.target) {
            return Err(match fs::rename(&old, &self.target) {
                Ok(()) => error,
                Err(_) => Error::other(format!(
                    "{error}; what was there is in {}, and the next run here restores it",
                    old.display()
                )),
            });
        }
        // Its name must be on the disk before the old one goes.
        sync_directory(&self.folder)?;
        fs::rename(&old, &self.path)
    }

    /// Writes the new names to the disk, those of new folders, too.
    fn sync_names(&self) -> Result<()> {
        sync_directory(&self.folder)?;
        for made in &self.made {
            sync_directory(&folder_of(made))?;
        }
        Ok(())
    }
}

impl Drop for Working {
    fn drop(&mut self) {
        let _ = remove(&self.path);
        // An old target that could not be given back needs the lock for its name.
        if !is_there(&beside(&self.path, OLD)) {
            let _ = fs::remove_file(beside(&self.path, LOCK));
        }
        if self.state == State::Unpublished {
            remove_empty(&self.made);
        }
    }
}

fn folder_of(target: &Path) -> PathBuf {
    match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Removes folders, innermost first; one that someone has put something into stays.
fn remove_empty(folders: &[PathBuf]) {
    for folder in folders {
        let _ = fs::remove_dir(folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::publish::durable::synced;

    /// All that was written before its name is given, and all names afterwards: of files and directories, new ones
    /// and such that take the place of others, and folders that were made for them.
    #[test]
    fn regress_what_is_published_is_on_the_disk() {
        let place = tempfile::tempdir().unwrap();
        let ways = [Working::publish, Working::publish_new, Working::swap];
        let names = ["plain", "first", "plain"];
        for parts in [&[""][..], &["", "b", "b/c"]] {
            let above = place.path().join(parts.len().to_string());
            for (publish, name) in ways.into_iter().zip(names) {
                let folder = above.join("new");
                let is_folder_new = !folder.exists();
                let mut working = Working::reserve(&folder.join(name)).unwrap();
                let path = working.path().to_owned();
                if parts.len() > 1 {
                    fs::create_dir_all(path.join("b")).unwrap();
                }
                let file = parts.last().map(|part| path.join(part)).unwrap();
                fs::write(file.components().collect::<PathBuf>(), "1").unwrap();
                synced::take();
                publish(&mut working).unwrap();
                let synced = synced::take();
                let at = |path: &Path| synced.iter().position(|(at, _)| at == path);
                let named = at(&folder).expect("the folder of the target");
                assert!(synced[named].1.contains(&name.into()), "{synced:?}");
                let is_before = |part: &&str| at(&path.join(part)).is_some_and(|at| at < named);
                assert!(parts.iter().all(is_before), "{synced:?}");
                let has_above = at(&above).is_some() && at(place.path()).is_some();
                assert!(has_above || !is_folder_new, "{synced:?}");
            }
        }
        crate::publish::write_whole(&place.path().join("whole"), b"1").unwrap();
        let synced = synced::take();
        assert!(
            synced.len() == 2 && synced[1].1.contains(&"whole".into()),
            "{synced:?}"
        );
    }

    #[test]
    fn regress_two_renames_where_names_cannot_be_exchanged() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("result");
        fs::create_dir(&target).unwrap();
        fs::write(target.join("a"), "old").unwrap();
        let working = Working::reserve(&target).unwrap();
        working.create_directory().unwrap();
        working.swap_by_renames().unwrap();
        assert!(!target.join("a").exists() && working.path().join("a").exists());
        // What was written is gone, so that the second rename fails.
        remove(&working.path).unwrap();
        fs::write(target.join("b"), "new").unwrap();
        working.swap_by_renames().unwrap_err();
        assert!(target.join("b").exists());
        drop(working);
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
    }
}
