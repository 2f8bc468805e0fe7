//! The memory that limits of a container or of the process leave, from the files of Linux.

use std::fs::read_to_string;
use std::path::Path;

/// Where control groups may be mounted: those of the second version, and those of memory of the first one.
const SECOND: [&str; 2] = ["sys/fs/cgroup", "sys/fs/cgroup/unified"];
const FIRST: [&str; 1] = ["sys/fs/cgroup/memory"];

/// Files of a group, of both versions: limits, of which the least counts, and usage.
const LIMITS: [&str; 3] = ["memory.max", "memory.high", "memory.limit_in_bytes"];
const USAGE: [&str; 2] = ["memory.current", "memory.usage_in_bytes"];

/// Lines of `memory.stat` with the page cache, which is given back where memory is short; the first version has also
/// those of a group without the groups below it.
const CACHE: [[&str; 2]; 2] = [
    ["total_inactive_file ", "inactive_file "],
    ["total_active_file ", "active_file "],
];

/// Bytes that may still be used: the least of what the machine has, each control group above
/// the process leaves, and `ulimit -v` and `ulimit -d` leave. `None` where nothing is known.
/// All from the files under a root: `/`, or in tests a copy of the few files that are read.
pub(crate) fn free(root: &Path) -> Option<u64> {
    let machine = kibibytes(&root.join("proc/meminfo"), "MemAvailable:");
    let all = [machine, left_by_groups(root), left_by_process(root)];
    all.into_iter().flatten().min()
}

/// What follows a name at the start of a line of a file, as a number.
fn number(file: &Path, name: &str) -> Option<u64> {
    let text = read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

/// A line of a file of `/proc` in kB, as bytes.
fn kibibytes(file: &Path, name: &str) -> Option<u64> {
    Some(number(file, name)?.saturating_mul(1024))
}

fn left_by_groups(root: &Path) -> Option<u64> {
    let text = read_to_string(root.join("proc/self/cgroup")).ok()?;
    let left = text.lines().filter_map(|line| {
        // hierarchy:controllers:path; the second version has no controllers here.
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, path) = (parts.next()?, parts.next()?);
        let mounts = match controllers {
            "" => &SECOND[..],
            _ if controllers.split(',').any(|name| name == "memory") => &FIRST,
            _ => return None,
        };
        let mounts = mounts.iter().map(|mount| root.join(mount));
        mounts.filter_map(|mount| least_above(&mount, path)).min()
    });
    left.min()
}

/// The least that the group at `path` and those above it leave. In a container the path may be
/// that on the host, while its own group is mounted as the root: what is missing is passed over.
fn least_above(mount: &Path, path: &str) -> Option<u64> {
    let group = mount.join(path.trim_start_matches('/'));
    let above = group
        .ancestors()
        .take_while(|folder| folder.starts_with(mount));
    above.filter_map(left_in).min()
}

/// What the group of a folder leaves, where it has a limit (`max` is no number).
fn left_in(folder: &Path) -> Option<u64> {
    let of = |file: &&str| number(&folder.join(file), "");
    let limit = LIMITS.iter().filter_map(of).min()?;
    let stat = folder.join("memory.stat");
    let cached = |names: &[&str; 2]| names.iter().find_map(|name| number(&stat, name));
    let cached: u64 = CACHE.iter().filter_map(cached).sum();
    let used = USAGE.iter().find_map(of).unwrap_or(0);
    Some(limit.saturating_sub(used.saturating_sub(cached)))
}

/// What `ulimit -v` and `ulimit -d` leave.
fn left_by_process(root: &Path) -> Option<u64> {
    let [limits, status] = ["limits", "status"].map(|file| root.join("proc/self").join(file));
    let uses = [
        ("Max address space", "VmSize:"),
        ("Max data size", "VmData:"),
    ];
    let left = uses.into_iter().filter_map(|(limit, used)| {
        // `unlimited` is no number.
        Some(number(&limits, limit)?.saturating_sub(kibibytes(&status, used).unwrap_or(0)))
    });
    left.min()
}

#[cfg(test)]
mod tests {
    /// What is free under a root that holds these files: a path and a text a line, `;` for the end of a line in it.
    fn free(name: &str, files: &str) -> Option<u64> {
        let root = std::env::temp_dir().join(format!("limits-{}-{name}", std::process::id()));
        for line in files.lines().filter(|line| !line.trim().is_empty()) {
            let (file, text) = line.trim().split_once(' ').unwrap();
            let path = root.join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text.replace(';', "\n")).unwrap();
        }
        let found = super::free(&root);
        let _ = std::fs::remove_dir_all(&root);
        found
    }

    #[test]
    fn regress_the_least_limit_of_machine_groups_and_process_counts() {
        // 3 MiB of which 1 MiB is used beside the cache; above it 2.5 MiB of which 1 MiB is used.
        let second = "
            proc/meminfo MemTotal:  16000 kB;MemAvailable:    8000 kB;
            proc/self/cgroup 0::/outer/inner;
            sys/fs/cgroup/outer/inner/memory.max 3145728;
            sys/fs/cgroup/outer/inner/memory.high max;
            sys/fs/cgroup/outer/inner/memory.current 2097152;
            sys/fs/cgroup/outer/inner/memory.stat anon 7;inactive_file 1000000;active_file 48576;file 9;
            sys/fs/cgroup/outer/memory.max 2621440;
            sys/fs/cgroup/outer/memory.current 1048576;";
        // The path of the host is not there; the container's own group is the root.
        let first = "
            proc/meminfo MemAvailable:    8000 kB;
            proc/self/cgroup 5:cpu,cpuacct:/docker/ab;4:memory:/docker/ab;0::/docker/ab;
            sys/fs/cgroup/memory/memory.limit_in_bytes 4194304;
            sys/fs/cgroup/memory/memory.usage_in_bytes 3145728;
            sys/fs/cgroup/memory/memory.stat inactive_file 5;total_inactive_file 1048576;total_active_file 0;";
        let unlimited = "
            proc/meminfo MemAvailable:    8000 kB;
            proc/self/cgroup 4:memory:/;0::/;
            sys/fs/cgroup/memory.max max;
            sys/fs/cgroup/memory/memory.limit_in_bytes 9223372036854771712;
            proc/self/limits Max address space         unlimited            unlimited            bytes;";
        let process = "
            proc/meminfo MemAvailable:    8000 kB;
            proc/self/limits Max data size     4096000     unlimited    bytes;Max address space    6144000    unlimited    bytes;
            proc/self/status VmSize:    4000 kB;VmData:    3000 kB;";
        for (name, files, left) in [
            ("second", second, Some(1_572_864)),
            ("first", first, Some(2_097_152)),
            ("unlimited", unlimited, Some(8000 * 1024)),
            ("process", process, Some(4_096_000 - 3_072_000)),
            ("empty", "", None),
        ] {
            assert_eq!(free(name, files), left, "{name}");
        }
    }
}
