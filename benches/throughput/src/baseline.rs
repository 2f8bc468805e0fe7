//! Saved baselines of throughput, and their comparison with current results.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use wavecascade_system::publish::write_whole;

use crate::{Error, Result};
use crate::{Machine, Versions};

/// Schema of a baseline file.
const SCHEMA: &str = "cascade-throughput/1";

/// Contents of a baseline file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    schema: String,
    /// By machine, versions and rounds; each case occurs once per machine.
    pub ratios: Vec<Ratios>,
    /// By architecture, build and versions; each case occurs once per architecture and build.
    pub instructions: Vec<Instructions>,
}

/// Time of `rustfft` relative to ours, by case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ratios {
    pub machine: Machine,
    pub versions: Versions,
    /// Number of rounds over which the medians are taken.
    pub rounds: usize,
    pub ratio_to_rustfft: BTreeMap<String, f64>,
}

/// Instructions per sample, by case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Instructions {
    pub architecture: String,
    /// `release` or `debug`.
    pub build: String,
    pub versions: Versions,
    pub per_sample: BTreeMap<String, f64>,
}

impl Instructions {
    /// Of this build.
    pub fn here(versions: Versions, per_sample: BTreeMap<String, f64>) -> Instructions {
        Instructions {
            architecture: std::env::consts::ARCH.into(),
            build: crate::machine::build().into(),
            versions,
            per_sample,
        }
    }

    /// Whether both have the same architecture and build.
    fn is_like(&self, other: &Instructions) -> bool {
        self.architecture == other.architecture && self.build == other.build
    }

    /// Whether these are counts of this architecture and build.
    fn is_of_here(&self) -> bool {
        self.architecture == std::env::consts::ARCH && self.build == crate::machine::build()
    }
}

impl Default for Baseline {
    fn default() -> Self {
        Baseline {
            schema: SCHEMA.into(),
            ratios: Vec::new(),
            instructions: Vec::new(),
        }
    }
}

impl Baseline {
    /// # Errors
    /// [`Error::File`]; [`Error::Baseline`] where the file is no baseline, or not all of one.
    pub fn read(path: &Path) -> Result<Baseline> {
        let text = std::fs::read_to_string(path).map_err(Error::file("read", path))?;
        Baseline::parse(path, &text)
    }

    /// The baseline in `text`, which messages call `path`.
    ///
    /// # Errors
    /// [`Error::Baseline`].
    pub fn parse(path: &Path, text: &str) -> Result<Baseline> {
        let fault = |reason: String| Error::Baseline {
            path: path.to_owned(),
            reason,
        };
        let mut reader = serde_json::Deserializer::from_str(text);
        let baseline: Baseline = serde_path_to_error::deserialize(&mut reader)
            .map_err(|error| fault(format!("at {}: {}", error.path(), error.inner())))?;
        if baseline.schema != SCHEMA {
            let found = &baseline.schema;
            return Err(fault(format!("expected schema {SCHEMA}, found {found}")));
        }
        let ratios = baseline.ratios.iter().flat_map(|r| &r.ratio_to_rustfft);
        let counts = baseline.instructions.iter().flat_map(|i| &i.per_sample);
        match ratios
            .chain(counts)
            .find(|(_, value)| !(value.is_normal() && **value > 0.0))
        {
            Some((case, value)) => Err(fault(format!(
                "{case}: expected a number above 0, found {value}"
            ))),
            None => Ok(baseline),
        }
    }

    /// Writes the file atomically.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self);
        let text = text.map_err(|error| Error::file("write", path)(error.into()))? + "\n";
        write_whole(path, text.as_bytes()).map_err(Error::file("write", path))
    }

    /// Ratios on a machine, by case; empty for an unknown machine.
    pub fn ratios_on(&self, machine: &Machine) -> BTreeMap<String, f64> {
        let on = self.ratios.iter().filter(|r| r.machine == *machine);
        on.flat_map(|r| r.ratio_to_rustfft.clone()).collect()
    }

    /// Counts of this build's architecture and profile.
    pub fn instructions_here(&self) -> impl Iterator<Item = &Instructions> {
        self.instructions.iter().filter(|i| i.is_of_here())
    }

    /// Replaces the known ratios of the given cases on their machine. Other cases keep their ratios
    /// and versions.
    pub fn set_ratios(&mut self, found: Ratios) {
        for known in &mut self.ratios {
            if known.machine == found.machine {
                let cases = &found.ratio_to_rustfft;
                known
                    .ratio_to_rustfft
                    .retain(|case, _| !cases.contains_key(case));
            }
        }
        self.ratios.retain(|r| !r.ratio_to_rustfft.is_empty());
        let alike = |r: &&mut Ratios| {
            (&r.machine, &r.versions, r.rounds) == (&found.machine, &found.versions, found.rounds)
        };
        match self.ratios.iter_mut().find(alike) {
            Some(known) => known.ratio_to_rustfft.extend(found.ratio_to_rustfft),
            None => self.ratios.push(found),
        }
    }

    /// The same for the counts of an architecture and build.
    pub fn set_instructions(&mut self, found: Instructions) {
        for known in &mut self.instructions {
            if known.is_like(&found) {
                let cases = &found.per_sample;
                known.per_sample.retain(|case, _| !cases.contains_key(case));
            }
        }
        self.instructions.retain(|i| !i.per_sample.is_empty());
        let alike = |i: &&mut Instructions| i.is_like(&found) && i.versions == found.versions;
        match self.instructions.iter_mut().find(alike) {
            Some(known) => known.per_sample.extend(found.per_sample),
            None => self.instructions.push(found),
        }
    }
}

/// A case now and in the baseline.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    pub case: String,
    pub baseline: f64,
    pub found: f64,
    /// Speed now over speed in the baseline.
    pub kept: f64,
}

impl Comparison {
    /// Compares ratios to `rustfft`; larger is better.
    pub fn of_ratios(case: &str, baseline: f64, found: f64) -> Comparison {
        Comparison {
            case: case.into(),
            baseline,
            found,
            kept: found / baseline,
        }
    }

    /// Compares instruction counts; fewer is better.
    pub fn of_counts(case: &str, baseline: f64, found: f64) -> Comparison {
        Comparison {
            kept: baseline / found,
            ..Comparison::of_ratios(case, baseline, found)
        }
    }

    /// Whether more than [`crate::LARGEST_LOSS`] is lost.
    pub fn is_loss(&self) -> bool {
        self.kept.is_nan() || self.kept < 1.0 - crate::LARGEST_LOSS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_may_be_lost() {
        let losses = |compare: fn(&str, f64, f64) -> Comparison, found: [f64; 3]| {
            found.map(|found| compare("case", 10.0, found).is_loss())
        };
        assert_eq!(
            losses(Comparison::of_ratios, [8.9, 9.1, f64::NAN]),
            [true, false, true]
        );
        assert_eq!(
            losses(Comparison::of_counts, [11.2, 11.0, 5.0]),
            [true, false, false]
        );
    }

    fn ratios(case: &str, value: f64, rustc: &str) -> Ratios {
        Ratios {
            machine: Machine::here(),
            versions: Versions {
                cascade: "0.1.0".into(),
                rustfft: "6.4.1".into(),
                realfft: "3.5.0".into(),
                rustc: rustc.into(),
            },
            rounds: 3,
            ratio_to_rustfft: BTreeMap::from([(case.to_owned(), value)]),
        }
    }

    fn counts(case: &str, value: f64, rustc: &str) -> Instructions {
        let ratios = ratios(case, value, rustc);
        Instructions::here(ratios.versions, ratios.ratio_to_rustfft)
    }

    #[test]
    fn only_cases_that_are_found_again_are_replaced() {
        let mut baseline = Baseline::default();
        let cases = [
            ("this", 1.0, "old"),
            ("that", 2.0, "old"),
            ("this", 3.0, "new"),
        ];
        for (case, value, rustc) in cases {
            baseline.set_ratios(ratios(case, value, rustc));
            baseline.set_instructions(counts(case, value, rustc));
        }
        let expected = [("that".to_owned(), 2.0), ("this".to_owned(), 3.0)];
        assert_eq!(
            baseline.ratios_on(&Machine::here()),
            BTreeMap::from(expected)
        );
        // Each case keeps the versions it was measured with.
        let known = [ratios("that", 2.0, "old"), ratios("this", 3.0, "new")];
        assert_eq!(baseline.ratios, known);
        let known = [counts("that", 2.0, "old"), counts("this", 3.0, "new")];
        assert_eq!(baseline.instructions, known);
        assert!(baseline.instructions_here().eq(&known));
        let other = Machine {
            cpu: "another".into(),
            ..Machine::here()
        };
        assert!(baseline.ratios_on(&other).is_empty());
        // Versions whose cases were all measured again are removed.
        baseline.set_ratios(ratios("that", 4.0, "new"));
        baseline.set_instructions(counts("that", 4.0, "new"));
        assert_eq!((baseline.ratios.len(), baseline.instructions.len()), (1, 1));
    }
}
