//! The memory that limits of a container or of the process leave, from the files of Linux.

use std::fs::read_to_string;
use std::path::{Path, PathBuf};

/// What the files under a root say: `/`, or in tests a copy of the few files that are read.
#[derive(Debug, Clone)]
pub(crate) struct Limits {
    root: PathBuf,
}

/// The files of one version of control groups.
struct Version {
    /// Limits, of which the least counts.
    limits: &'static [&'static str],
    usage: &'static str,
    /// Lines of `memory.stat` with the page cache, which is given back where memory is short.
    cache: [&'static str; 2],
    /// Where the hierarchy may be mounted.
    mounts: &'static [&'static str],
}

const SECOND: Version = Version {
    limits: &["memory.max", "memory.high"],
    usage: "memory.current",
    cache: ["inactive_file", "active_file"],
    mounts: &["sys/fs/cgroup", "sys/fs/cgroup/unified"],
};

const FIRST: Version = Version {
    limits: &["memory.limit_in_bytes"],
    usage: "memory.usage_in_bytes",
    cache: ["total_inactive_file", "total_active_file"],
    mounts: &["sys/fs/cgroup/memory"],
};

impl Limits {
    pub fn of_system() -> Limits {
        Limits::under(Path::new("/"))
    }

    pub fn under(root: &Path) -> Limits {
        Limits { root: root.into() }
    }

    /// Bytes that may still be used: the least of what the machine has, each control group above
    /// the process leaves, and `ulimit -v` and `ulimit -d` leave. `None` where nothing is known.
    pub fn free(&self) -> Option<u64> {
        let all = [self.machine(), self.groups(), self.address_space()];
        all.into_iter().flatten().min()
    }

    fn machine(&self) -> Option<u64> {
        self.kibibytes("proc/meminfo", "MemAvailable:")
    }

    /// A line of a file of `/proc` in kB, as bytes.
    fn kibibytes(&self, file: &str, name: &str) -> Option<u64> {
        let text = read_to_string(self.root.join(file)).ok()?;
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        let kibibytes: u64 = line.split_whitespace().next()?.parse().ok()?;
        Some(kibibytes.saturating_mul(1024))
    }

    fn groups(&self) -> Option<u64> {
        let text = read_to_string(self.root.join("proc/self/cgroup")).ok()?;
        let left = text.lines().filter_map(|line| {
            // hierarchy:controllers:path; the second version has no controllers here.
            let mut parts = line.splitn(3, ':').skip(1);
            let (controllers, path) = (parts.next()?, parts.next()?);
            let version = match controllers {
                "" => SECOND,
                _ if controllers.split(',').any(|name| name == "memory") => FIRST,
                _ => return None,
            };
            self.least_above(&version, path)
        });
        left.min()
    }

    /// The least that the group at `path` and those above it leave. In a container the path may be
    /// that on the host, while its own group is mounted as the root: what is missing is passed over.
    fn least_above(&self, version: &Version, path: &str) -> Option<u64> {
        let mounts = version.mounts.iter().map(|mount| self.root.join(mount));
        let left = mounts.flat_map(|mount| {
            let group = mount.join(path.trim_start_matches('/'));
            let above: Vec<PathBuf> = group
                .ancestors()
                .take_while(|folder| folder.starts_with(&mount))
                .map(Path::to_path_buf)
                .collect();
            above
        });
        left.filter_map(|folder| version.left_in(&folder)).min()
    }

    /// What `ulimit -v` and `ulimit -d` leave.
    fn address_space(&self) -> Option<u64> {
        let text = read_to_string(self.root.join("proc/self/limits")).ok()?;
        let left = |limit: &str, used: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(limit))?;
            // `unlimited` is no number.
            let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
            let used = self.kibibytes("proc/self/status", used).unwrap_or(0);
            Some(limit.saturating_sub(used))
        };
        let [space, data] = [
            left("Max address space", "VmSize:"),
            left("Max data size", "VmData:"),
        ];
        space.into_iter().chain(data).min()
    }
}

impl Version {
    /// What the group of a folder leaves, where it has a limit (`max` is no number).
    fn left_in(&self, folder: &Path) -> Option<u64> {
        let number = |file: &str| -> Option<u64> {
            let text = read_to_string(folder.join(file)).ok()?;
            text.trim().parse().ok()
        };
        let limit = self.limits.iter().filter_map(|file| number(file)).min()?;
        let stat = read_to_string(folder.join("memory.stat")).unwrap_or_default();
        let cached = |line: &str| -> Option<u64> {
            let (name, bytes) = line.split_once(' ')?;
            let bytes = bytes.trim().parse().ok()?;
            self.cache.contains(&name).then_some(bytes)
        };
        let cache: u64 = stat.lines().filter_map(cached).sum();
        let used = number(self.usage).unwrap_or(0).saturating_sub(cache);
        Some(limit.saturating_sub(used))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Files under a root of their own; the last owner removes them.
    struct Root(PathBuf);

    impl Root {
        fn with(name: &str, files: &[(&str, &str)]) -> Root {
            let root = std::env::temp_dir().join(format!("limits-{}-{name}", std::process::id()));
            for (file, text) in files {
                let path = root.join(file);
                std::fs::create_dir_all(path.parent().unwrap()).unwrap();
                std::fs::write(path, text).unwrap();
            }
            Root(root)
        }

        fn free(&self) -> Option<u64> {
            Limits::under(&self.0).free()
        }
    }

    impl Drop for Root {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    const MACHINE: (&str, &str) = (
        "proc/meminfo",
        "MemTotal:  16000 kB\nMemAvailable:    8000 kB\n",
    );

    #[test]
    fn regress_the_least_limit_above_the_process_counts() {
        // 3 MiB of which 1 MiB is used beside the cache; above it 2.5 MiB of which 1 MiB is used.
        let second = Root::with(
            "second",
            &[
                MACHINE,
                ("proc/self/cgroup", "0::/outer/inner\n"),
                ("sys/fs/cgroup/outer/inner/memory.max", "3145728\n"),
                ("sys/fs/cgroup/outer/inner/memory.high", "max\n"),
                ("sys/fs/cgroup/outer/inner/memory.current", "2097152\n"),
                (
                    "sys/fs/cgroup/outer/inner/memory.stat",
                    "anon 7\ninactive_file 1000000\nactive_file 48576\nfile 9\n",
                ),
                ("sys/fs/cgroup/outer/memory.max", "2621440\n"),
                ("sys/fs/cgroup/outer/memory.current", "1048576\n"),
            ],
        );
        assert_eq!(second.free(), Some(1_572_864));

        // The path of the host is not there; the container's own group is the root.
        let first = Root::with(
            "first",
            &[
                MACHINE,
                (
                    "proc/self/cgroup",
                    "5:cpu,cpuacct:/docker/ab\n4:memory:/docker/ab\n0::/docker/ab\n",
                ),
                ("sys/fs/cgroup/memory/memory.limit_in_bytes", "4194304\n"),
                ("sys/fs/cgroup/memory/memory.usage_in_bytes", "3145728\n"),
                (
                    "sys/fs/cgroup/memory/memory.stat",
                    "inactive_file 5\ntotal_inactive_file 1048576\ntotal_active_file 0\n",
                ),
            ],
        );
        assert_eq!(first.free(), Some(2_097_152));
    }

    #[test]
    fn regress_without_limits_the_machine_counts() {
        let unlimited = Root::with(
            "unlimited",
            &[
                MACHINE,
                ("proc/self/cgroup", "4:memory:/\n0::/\n"),
                ("sys/fs/cgroup/memory.max", "max\n"),
                (
                    "sys/fs/cgroup/memory/memory.limit_in_bytes",
                    "9223372036854771712\n",
                ),
                (
                    "proc/self/limits",
                    "Max address space         unlimited            unlimited            bytes\n",
                ),
            ],
        );
        assert_eq!(unlimited.free(), Some(8000 * 1024));
        assert_eq!(Root::with("empty", &[]).free(), None);
    }

    #[test]
    fn regress_limits_of_the_process_count() {
        let limited = Root::with(
            "process",
            &[
                MACHINE,
                (
                    "proc/self/limits",
                    "Limit                     Soft Limit           Hard Limit           Units\n\
                     Max data size             4096000              unlimited            bytes\n\
                     Max address space         6144000              unlimited            bytes\n",
                ),
                (
                    "proc/self/status",
                    "VmSize:\t    4000 kB\nVmData:\t    3000 kB\n",
                ),
            ],
        );
        assert_eq!(limited.free(), Some(4_096_000 - 3_072_000));
    }
}
