//! Throughput once recorded, and what is found now beside it.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Machine, Versions};
use crate::error::{Error, Result};

/// The form of a baseline's file.
const SCHEMA: &str = "cascade-throughput/1";

/// What a file of records holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    schema: String,
    /// One a machine.
    pub ratios: Vec<Ratios>,
    /// One an architecture and build.
    pub instructions: Vec<Instructions>,
}

/// How many times as long `rustfft` takes, by case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ratios {
    pub machine: Machine,
    pub versions: Versions,
    /// Rounds of which they are medians.
    pub rounds: usize,
    pub ratio_to_rustfft: BTreeMap<String, f64>,
}

/// Instructions a sample, by case.
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
    pub fn here(per_sample: BTreeMap<String, f64>) -> Instructions {
        Instructions {
            architecture: std::env::consts::ARCH.into(),
            build: super::machine::build().into(),
            versions: Versions::here(),
            per_sample,
        }
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
    /// The one in the repository, `benches/baseline.json`.
    ///
    /// # Errors
    /// As [`Baseline::read`]; a test holds that there is none.
    pub fn shipped() -> Result<Baseline> {
        let text = include_str!("../../benches/baseline.json");
        Baseline::parse("benches/baseline.json".as_ref(), text)
    }

    /// # Errors
    /// [`Error::Read`]; [`Error::Baseline`] where the file is no baseline, or not all of one.
    pub fn read(path: &Path) -> Result<Baseline> {
        let text = std::fs::read_to_string(path).map_err(Error::read("read", path))?;
        Baseline::parse(path, &text)
    }

    fn parse(path: &Path, text: &str) -> Result<Baseline> {
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

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, path: &Path) -> Result<()> {
        let name = path
            .file_name()
            .and_then(|name| name.to_str())
            .ok_or_else(|| Error::Request {
                option: "record",
                expected: "the path of a file".into(),
                found: path.display().to_string(),
            })?;
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        let text = serde_json::to_string_pretty(self);
        let text = text.map_err(|error| Error::write("write", path)(error.into()))? + "\n";
        crate::ledger::write_whole(folder.unwrap_or(".".as_ref()), name, text.as_bytes())?;
        Ok(())
    }

    /// Ratios on this machine, by case.
    pub fn ratios_on(&self, machine: &Machine) -> Option<&BTreeMap<String, f64>> {
        let found = self.ratios.iter().find(|r| r.machine == *machine);
        found.map(|r| &r.ratio_to_rustfft)
    }

    /// Counts of a build like this one.
    pub fn instructions_here(&self) -> Option<&Instructions> {
        let here = Instructions::here(BTreeMap::new());
        let like = |i: &&Instructions| i.architecture == here.architecture && i.build == here.build;
        self.instructions.iter().find(like)
    }

    /// Puts ratios in the place of what was known of their machine.
    pub fn set_ratios(&mut self, found: Ratios) {
        self.ratios.retain(|r| r.machine != found.machine);
        self.ratios.push(found);
    }

    /// Puts counts in the place of what was known of their architecture and build.
    pub fn set_instructions(&mut self, found: Instructions) {
        let like =
            |i: &Instructions| i.architecture == found.architecture && i.build == found.build;
        self.instructions.retain(|i| !like(i));
        self.instructions.push(found);
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
    /// Of ratios to `rustfft`, of which the larger is the better.
    pub fn of_ratios(case: &str, baseline: f64, found: f64) -> Comparison {
        Comparison {
            case: case.into(),
            baseline,
            found,
            kept: found / baseline,
        }
    }

    /// Of instructions, of which the fewer is the better.
    pub fn of_counts(case: &str, baseline: f64, found: f64) -> Comparison {
        Comparison {
            kept: baseline / found,
            ..Comparison::of_ratios(case, baseline, found)
        }
    }

    /// Whether more than [`super::LARGEST_LOSS`] is lost.
    pub fn is_loss(&self) -> bool {
        self.kept.is_nan() || self.kept < 1.0 - super::LARGEST_LOSS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_baseline_can_be_read() {
        Baseline::shipped().unwrap();
    }

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

    #[test]
    fn a_machine_has_one_entry() {
        let mut baseline = Baseline::default();
        for value in [1.0, 2.0] {
            baseline.set_ratios(Ratios {
                machine: Machine::here(),
                versions: Versions::here(),
                rounds: 3,
                ratio_to_rustfft: BTreeMap::from([("case".to_owned(), value)]),
            });
            baseline.set_instructions(Instructions::here(BTreeMap::from([(
                "case".to_owned(),
                value,
            )])));
        }
        assert_eq!(baseline.ratios_on(&Machine::here()).unwrap()["case"], 2.0);
        assert_eq!(
            baseline.instructions_here().unwrap().per_sample["case"],
            2.0
        );
        assert_eq!((baseline.ratios.len(), baseline.instructions.len()), (1, 1));
        let other = Machine {
            cpu: "another".into(),
            ..Machine::here()
        };
        assert_eq!(baseline.ratios_on(&other), None);
    }
}
