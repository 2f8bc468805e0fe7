//! Files and directories that appear whole or not at all: what others see at any time, and what a
//! killed process leaves.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use wavecascade_system::publish::{
    Working, final_path, is_working_name, remove_abandoned, write_whole,
};

const STEM: &str = ".cascade-partial-0123456789abcdef";

fn names(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap();
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
    entries.map(|e| name(e).into_string().unwrap()).collect()
}

fn set(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|&n| n.to_owned()).collect()
}

/// A directory under construction with one file.
fn begun(target: &Path, text: &str) -> Working {
    let working = Working::reserve(target).unwrap();
    working.create_directory().unwrap();
    fs::write(working.path().join("a"), text).unwrap();
    working
}

/// What a process that was killed leaves: the files of a living one, without its lock.
fn killed(folder: &Path, target: &str) {
    fs::create_dir(folder.join(STEM)).unwrap();
    fs::write(folder.join(STEM).join("a"), "half").unwrap();
    let lock = folder.join(STEM.to_owned() + ".lock");
    fs::write(lock, format!("\n{target}")).unwrap();
}

#[test]
fn regress_a_name_is_that_of_a_whole_result_and_nothing_else_stays() {
    let place = tempfile::tempdir().unwrap();
    let target = place.path().join("new/folder/result");
    drop(begun(&target, "dropped"));
    assert_eq!(names(place.path()), set(&[]));

    let (mut first, mut second) = (begun(&target, "first"), begun(&target, "second"));
    assert_ne!(first.path(), second.path());
    first.publish().unwrap();
    // A directory that is there is replaced by an exchange alone.
    second.publish().unwrap_err();
    assert_eq!(fs::read(target.join("a")).unwrap(), b"first");
    second.swap().unwrap();
    assert_eq!(fs::read(target.join("a")).unwrap(), b"second");
    second.withdraw().unwrap();
    assert_eq!(fs::read(target.join("a")).unwrap(), b"first");
    second.swap().unwrap();
    drop((first, second));
    assert_eq!(fs::read(target.join("a")).unwrap(), b"second");
    assert_eq!(names(target.parent().unwrap()), set(&["result"]));
}

#[test]
fn regress_a_new_name_is_given_once() {
    let place = tempfile::tempdir().unwrap();
    for is_file in [true, false] {
        let target = place.path().join(format!("result-{is_file}"));
        let begun = |text: &str| match is_file {
            true => {
                let working = Working::reserve(&target).unwrap();
                fs::write(working.path(), text).unwrap();
                working
            }
            false => begun(&target, text),
        };
        let (mut first, mut second) = (begun("first"), begun("second"));
        second.publish_new().unwrap();
        let refused = first.publish_new().unwrap_err();
        assert_eq!(refused.kind(), std::io::ErrorKind::AlreadyExists);
        let path = if is_file {
            target.clone()
        } else {
            target.join("a")
        };
        assert_eq!(fs::read(path).unwrap(), b"second");
    }
    assert_eq!(names(place.path()), set(&["result-false", "result-true"]));
}

#[test]
fn regress_names_as_long_as_the_system_allows() {
    let place = tempfile::tempdir().unwrap();
    let name = "n".repeat(255);
    write_whole(&place.path().join(&name), b"1").unwrap();
    assert_eq!(names(place.path()), set(&[&name]));
    write_whole(&place.path().join("n".repeat(256)), b"1").unwrap_err();
    assert_eq!(names(place.path()), set(&[&name]));
}

#[test]
fn regress_what_is_written_is_called_by_its_final_name() {
    let place = tempfile::tempdir().unwrap();
    let target = place.path().join("result");
    let working = begun(&target, "1");
    assert_eq!(final_path(working.path()), target);
    assert_eq!(final_path(&working.path().join("b/c")), target.join("b/c"));
    assert_eq!(final_path(&target), target);
    assert!(is_working_name(working.path().file_name().unwrap()));
    assert!(!is_working_name("result".as_ref()));
}

#[test]
fn regress_only_what_no_process_holds_is_removed() {
    let place = tempfile::tempdir().unwrap();
    let alive = begun(&place.path().join("alive"), "1");
    killed(place.path(), "result");
    // The next run in the same folder removes it, whatever its own target.
    let before = names(place.path());
    drop(begun(&place.path().join("other"), "2"));
    let removed = &before - &names(place.path());
    assert_eq!(removed, set(&[STEM, &format!("{STEM}.lock")]));
    assert!(alive.path().join("a").exists());
}

#[test]
fn regress_an_earlier_result_between_two_renames_is_restored() {
    let place = tempfile::tempdir().unwrap();
    let (target, old) = (place.path().join("result"), format!("{STEM}.old"));
    let moved_away = || {
        fs::create_dir(place.path().join(&old)).unwrap();
        fs::write(place.path().join(&old).join("a"), "old").unwrap();
    };
    killed(place.path(), "result");
    moved_away();
    remove_abandoned(place.path());
    assert_eq!(names(place.path()), set(&["result"]));
    assert_eq!(fs::read(target.join("a")).unwrap(), b"old");

    // The new one has its name already.
    killed(place.path(), "result");
    moved_away();
    fs::write(target.join("a"), "new").unwrap();
    remove_abandoned(place.path());
    assert_eq!(names(place.path()), set(&["result"]));
    assert_eq!(fs::read(target.join("a")).unwrap(), b"new");

    // Without its name nothing says whether it is the only one.
    moved_away();
    remove_abandoned(place.path());
    assert_eq!(names(place.path()), set(&["result", &old]));

    // A name that leads elsewhere is none.
    killed(place.path(), "../elsewhere");
    remove_abandoned(place.path());
    assert!(place.path().join(&old).exists());
}

/// Cleaners lock what they look at, also before its owner does.
#[test]
fn regress_owners_and_cleaners_at_once() {
    let place = tempfile::tempdir().unwrap();
    let stopped = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while !stopped.load(Ordering::Relaxed) {
                    remove_abandoned(place.path());
                }
            });
        }
        let write = |target: &Path, turn: i32| {
            let mut working = Working::reserve(target)?;
            working.create_file()?;
            fs::write(working.path(), turn.to_string())?;
            // Without the syncs, which would leave the cleaners alone most of the time.
            match turn % 20 {
                0 => working.publish(),
                _ => Ok(()),
            }
        };
        let writers: Vec<_> = ["result-0", "result-1"]
            .map(|name| {
                let target = place.path().join(name);
                scope.spawn(move || (0..600).try_for_each(|turn| write(&target, turn)))
            })
            .into();
        let done: Vec<_> = writers.into_iter().map(|writer| writer.join()).collect();
        stopped.store(true, Ordering::Relaxed);
        done.into_iter().for_each(|done| done.unwrap().unwrap());
    });
    assert_eq!(names(place.path()), set(&["result-0", "result-1"]));
}
