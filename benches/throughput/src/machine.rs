//! The machine and the versions of a measurement.

use serde::{Deserialize, Serialize};

use column_fft::InstructionSet;

/// What ratios of times depend on besides the code.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    pub cpu: String,
    pub instruction_set: String,
    /// `release`, or `debug` with debug assertions.
    pub build: String,
}

impl Machine {
    /// The current machine.
    pub fn here() -> Machine {
        let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        Machine {
            cpu: cpu(&info),
            instruction_set: set_name(InstructionSet::best()),
            build: build().into(),
        }
    }
}

impl std::fmt::Display for Machine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}, {}, {} build",
            self.cpu, self.instruction_set, self.build
        )
    }
}

/// Versions of the compared libraries and of the compiler.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Versions {
    pub cascade: String,
    pub rustfft: String,
    pub realfft: String,
    pub rustc: String,
}

impl Versions {
    /// Versions of a build: that of cascade, those of the libraries in the text of its `Cargo.lock`,
    /// and that of the compiler.
    pub fn of_build(cascade: &str, lock: &str, rustc: &str) -> Versions {
        Versions {
            cascade: cascade.into(),
            rustfft: locked(lock, "rustfft"),
            realfft: locked(lock, "realfft"),
            rustc: rustc.into(),
        }
    }
}

/// `release`, or `debug` with debug assertions.
pub fn build() -> &'static str {
    match cfg!(debug_assertions) {
        true => "debug",
        false => "release",
    }
}

/// The name of an instruction set on the command line.
pub fn set_name(set: InstructionSet) -> String {
    format!("{set:?}").to_lowercase()
}

fn locked(lock: &str, name: &str) -> String {
    let package = format!("name = \"{name}\"\nversion = \"");
    let version = lock
        .split_once(&package)
        .and_then(|(_, rest)| rest.split_once('"'));
    version.map_or("unknown", |(version, _)| version).into()
}

/// The first processor in `/proc/cpuinfo`. Names are ambiguous (virtual machines shorten them), so
/// family and model are appended.
fn cpu(info: &str) -> String {
    let of = |wanted: &str| {
        let fields = info.lines().filter_map(|line| line.split_once(':'));
        let mut values = fields
            .filter(|(key, _)| key.trim() == wanted)
            .map(|(_, value)| value.trim());
        values.next()
    };
    let numbers = ["cpu family", "model", "CPU implementer", "CPU part"];
    let numbers: Vec<String> = numbers
        .iter()
        .filter_map(|key| Some(format!("{key} {}", of(key)?)))
        .collect();
    let name = of("model name").unwrap_or(std::env::consts::ARCH);
    match numbers.is_empty() {
        true => format!("{name} (unknown model)"),
        false => format!("{name} ({})", numbers.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processors_are_told_apart() {
        let info = "processor\t: 0\ncpu family\t: 25\nmodel\t\t: 17\nmodel name\t: AMD EPYC\n\n\
                    processor\t: 1\nmodel name\t: another\n";
        assert_eq!(cpu(info), "AMD EPYC (cpu family 25, model 17)");
        let arm = "processor\t: 0\nCPU implementer\t: 0x41\nCPU part\t: 0xd0c\n";
        assert!(
            cpu(arm).ends_with("(CPU implementer 0x41, CPU part 0xd0c)"),
            "{}",
            cpu(arm)
        );
        assert!(cpu("").ends_with("(unknown model)"));
    }

    #[test]
    fn versions_are_those_of_the_lock_file() {
        let lock = "[[package]]\nname = \"rustfft\"\nversion = \"6.4.1\"\n";
        let versions = Versions::of_build("0.1.0", lock, "rustc 1.89.0");
        assert_eq!(versions.rustfft, "6.4.1");
        assert_eq!(versions.realfft, "unknown");
    }
}
