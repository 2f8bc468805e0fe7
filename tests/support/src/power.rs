//! A disk that loses what was not synced, replayed from a record of calls.
//!
//! A sync of a file has its bytes on the disk, one of a directory the names in it. Of what was not
//! synced the disk may have nothing, or the names up to any point: file systems keep their order, but
//! write bytes when they like.

use std::collections::BTreeMap;

use crate::preload::Record;

/// A file or directory, whatever its name.
type Node = usize;

#[derive(Debug, Clone, Default)]
struct Names(BTreeMap<(Node, String), Node>);

/// A change of names in a directory.
#[derive(Debug, Clone)]
enum Change {
    Add(Node),
    Remove,
    /// To another name in the same directory.
    Rename(String),
    Exchange(String),
}

/// What the names and bytes are after a power cut.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Content {
    Absent,
    /// Files that were there before the first call, by name; none has changed.
    Old,
    /// Whole files of the record, by their paths below.
    Whole(Vec<String>),
    /// A file whose bytes are not all on the disk.
    Torn(String),
}

const ROOT: Node = 0;

/// A record of calls, from which a power cut at any point is replayed.
#[derive(Debug, Default)]
pub struct Replay {
    /// Each change with the number of its call, its directory and its name.
    changes: Vec<(usize, Node, String, Change)>,
    /// Calls that wrote to a file, and that synced it.
    written: BTreeMap<Node, Vec<usize>>,
    synced: BTreeMap<Node, Vec<usize>>,
    before: Names,
    /// Nodes that were there before the first call.
    old: Node,
    calls: usize,
}

impl Names {
    fn find(&self, path: &str) -> Option<Node> {
        if path == "." {
            return Some(ROOT);
        }
        let parts = path.split('/');
        parts.into_iter().try_fold(ROOT, |folder, name| {
            self.0.get(&(folder, name.to_owned())).copied()
        })
    }

    fn apply(&mut self, folder: Node, name: &str, change: &Change) {
        let key = (folder, name.to_owned());
        match change {
            Change::Add(node) => drop(self.0.insert(key, *node)),
            Change::Remove => drop(self.0.remove(&key)),
            Change::Rename(to) => {
                if let Some(node) = self.0.remove(&key) {
                    self.0.insert((folder, to.clone()), node);
                }
            }
            Change::Exchange(with) => {
                let other = (folder, with.clone());
                let (a, b) = (self.0.remove(&key), self.0.remove(&other));
                self.0.extend(a.map(|node| (other, node)));
                self.0.extend(b.map(|node| (key, node)));
            }
        }
    }

    /// Files below a node, with their paths.
    fn files(&self, node: Node, path: &str, found: &mut Vec<(String, Node)>) {
        let entries = self.0.iter().filter(|((folder, _), _)| *folder == node);
        let before = found.len();
        for ((_, name), child) in entries {
            self.files(*child, &format!("{path}/{name}"), found);
        }
        if found.len() == before {
            found.push((path.to_owned(), node));
        }
    }
}

fn split(path: &str) -> (&str, &str) {
    path.rsplit_once('/').unwrap_or((".", path))
}

impl Replay {
    /// Of calls that began with files at `paths`.
    pub fn new(paths: &[String], record: &Record) -> Replay {
        let mut replay = Replay::default();
        let mut nodes = ROOT;
        let mut names = Names::default();
        for path in paths {
            let mut folder = ROOT;
            for name in path.split('/') {
                folder = *names.0.entry((folder, name.to_owned())).or_insert_with(|| {
                    nodes += 1;
                    nodes
                });
            }
        }
        replay.before = names.clone();
        replay.old = nodes;
        for [call, path, other, _] in record {
            let (folder, name) = split(path);
            let change = match call.as_str() {
                "create" | "mkdir" => {
                    nodes += 1;
                    Change::Add(nodes)
                }
                "remove" => Change::Remove,
                "rename" => Change::Rename(split(other).1.to_owned()),
                "exchange" => Change::Exchange(split(other).1.to_owned()),
                word @ ("write" | "sync") => {
                    let node = names.find(path).expect("a file that is there");
                    let all = match word {
                        "write" => &mut replay.written,
                        _ => &mut replay.synced,
                    };
                    all.entry(node).or_default().push(replay.calls);
                    replay.calls += 1;
                    continue;
                }
                _ => continue,
            };
            let folder = names.find(folder).expect("a folder that is there");
            names.apply(folder, name, &change);
            let name = name.to_owned();
            replay.changes.push((replay.calls, folder, name, change));
            replay.calls += 1;
        }
        replay
    }

    /// Number of calls that matter.
    pub fn calls(&self) -> usize {
        self.calls
    }

    /// What has the name `target` after a cut before call `cut`, where the disk has the names up to
    /// call `named` and those that were synced.
    pub fn after(&self, cut: usize, named: usize, target: &str) -> Content {
        let mut names = self.before.clone();
        let last = |all: &BTreeMap<Node, Vec<usize>>, node: Node| {
            let calls = all.get(&node).into_iter().flatten();
            calls.copied().filter(|call| *call < cut).max()
        };
        for (call, folder, name, change) in &self.changes {
            let is_synced = last(&self.synced, *folder).is_some_and(|sync| sync > *call);
            if *call < cut && (*call < named || is_synced) {
                names.apply(*folder, name, change);
            }
        }
        let Some(node) = names.find(target) else {
            return Content::Absent;
        };
        let mut files = Vec::new();
        names.files(node, target, &mut files);
        if files.iter().all(|(_, node)| *node <= self.old) {
            return Content::Old;
        }
        let is_torn = |node: Node| last(&self.written, node) > last(&self.synced, node);
        match files.iter().find(|(_, node)| is_torn(*node)) {
            Some((path, _)) => Content::Torn(path.clone()),
            None => Content::Whole(files.into_iter().map(|(path, _)| path).collect()),
        }
    }
}
