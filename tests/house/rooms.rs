//! The map of `DESIGN.md` lists the rooms of the library from the bottom up. Every room may use those
//! above it in the list, which lie below it in the house, and no others.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Rooms in the order of the map; the program is not one of the library's.
pub fn listed() -> Vec<String> {
    let text = fs::read_to_string(root().join("DESIGN.md")).unwrap();
    let rows = text.lines().filter_map(|line| line.strip_prefix("| `src/"));
    let names = rows.filter_map(|row| row.split_once('`').map(|(name, _)| name));
    let names = names.map(|name| name.trim_end_matches('/').trim_end_matches(".rs"));
    names
        .filter(|name| !name.starts_with("bin"))
        .map(str::to_owned)
        .collect()
}

/// Files below a folder whose names end so; not what was built, nor what git keeps.
pub fn files(folder: &Path, ends: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            found.extend(files(&path, ends));
        } else if ends.iter().any(|end| name.ends_with(end)) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The code without comments.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let lines = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// Rooms that code names after `crate::`, in paths and in lists of imports.
fn named(code: &str) -> BTreeSet<String> {
    let mut rooms = BTreeSet::new();
    for after in code.split("crate::").skip(1) {
        let names: Vec<&str> = match after.strip_prefix('{') {
            None => vec![after],
            // A list has further lists in it; names at its own level begin after `{` and `,`.
            Some(list) => {
                let mut depth = 0;
                let mut starts = vec![0];
                for (at, byte) in list.bytes().enumerate() {
                    match byte {
                        b'{' => depth += 1,
                        b'}' if depth == 0 => break,
                        b'}' => depth -= 1,
                        b',' if depth == 0 => starts.push(at + 1),
                        _ => {}
                    }
                }
                starts
                    .into_iter()
                    .map(|at| list[at..].trim_start())
                    .collect()
            }
        };
        for name in names {
            let end = name.find(|c: char| !c.is_alphanumeric() && c != '_');
            let room = match &name[..end.unwrap_or(name.len())] {
                "Error" | "Result" => "error",
                "Field" => "field",
                room => room,
            };
            rooms.insert(room.to_owned());
        }
    }
    rooms.remove("");
    rooms
}

fn room_of(path: &Path) -> String {
    let inside = path.strip_prefix(root().join("src")).unwrap();
    let first = inside.components().next().unwrap().as_os_str();
    first.to_string_lossy().trim_end_matches(".rs").to_owned()
}

#[test]
fn every_room_is_on_the_map_once() {
    let listed = listed();
    let unique: BTreeSet<String> = listed.iter().cloned().collect();
    assert_eq!(unique.len(), listed.len(), "{listed:?}");
    let sources = files(&root().join("src"), &[".rs"]);
    let rooms: BTreeSet<String> = sources.iter().map(|path| room_of(path)).collect();
    let rooms: BTreeSet<String> = rooms
        .into_iter()
        .filter(|room| room != "lib" && room != "bin")
        .collect();
    assert_eq!(rooms, unique);
}

/// Every file of a room, with the room and what its code names.
pub fn uses() -> Vec<(PathBuf, String, BTreeSet<String>)> {
    let sources = files(&root().join("src"), &[".rs"]);
    let used = |path: PathBuf| {
        let (room, used) = (room_of(&path), named(&code(&path)));
        (path, room, used)
    };
    sources.into_iter().map(used).collect()
}

#[test]
fn no_arrow_points_up() {
    let listed = listed();
    let place = |room: &str| listed.iter().position(|name| name == room);
    let mut wrong = Vec::new();
    for (path, room, used) in uses() {
        let Some(own) = place(&room) else {
            continue;
        };
        for used in used {
            match place(&used) {
                Some(other) if other <= own => {}
                Some(_) => wrong.push(format!("{}: {used} lies above {room}", path.display())),
                None => wrong.push(format!("{}: {used} is no room", path.display())),
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
