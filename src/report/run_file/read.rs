//! A run file back to a run, checked against its scene.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use ndarray::{Array1, Array2};

use super::{RUN_SCHEMA, RunFile};
use crate::chain::scene::{SceneSource, Setup};
use crate::chain::{Run, RunReport};
use crate::error::{Error, Fault, Result, SIMULATE, shape_of};
use crate::field::{Members, check_written, read_members};

/// By how much masses and coefficients may differ from those that the scene gives on another
/// machine, relative to their size.
pub(super) const SAME: f64 = 1e-12;

/// Which arrays of a run are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Arrays {
    All,
    /// Displacements and velocities.
    Motion,
}

/// Where the arrays and texts of a run are.
pub(super) trait Parts {
    fn text(&mut self, name: &str) -> Result<Option<String>>;
    /// Shape and values.
    fn array(&mut self, name: &str) -> Result<Option<(Vec<u64>, Vec<f64>)>>;
    /// A fault of the part of this name, or of the whole for none.
    fn fault(&self, name: &str, fault: Fault) -> Error;
}

impl Parts for Members<'_> {
    fn text(&mut self, name: &str) -> Result<Option<String>> {
        Members::text(self, name)
    }

    fn array(&mut self, name: &str) -> Result<Option<(Vec<u64>, Vec<f64>)>> {
        Members::array(self, name)
    }

    fn fault(&self, name: &str, fault: Fault) -> Error {
        Members::fault(self, name, fault.into())
    }
}

/// Arrays and texts of a run in memory, row-major, of another language.
#[derive(Debug, Default)]
pub struct RunParts {
    /// In messages.
    pub path: PathBuf,
    pub texts: BTreeMap<String, String>,
    /// Shape and values.
    pub arrays: BTreeMap<String, (Vec<u64>, Vec<f64>)>,
}

impl Parts for RunParts {
    fn text(&mut self, name: &str) -> Result<Option<String>> {
        Ok(self.texts.get(name).cloned())
    }

    fn array(&mut self, name: &str) -> Result<Option<(Vec<u64>, Vec<f64>)>> {
        Ok(self.arrays.remove(name))
    }

    fn fault(&self, _: &str, fault: Fault) -> Error {
        Error::input(&self.path)(fault)
    }
}

pub(super) fn run_file(path: &Path, arrays: Arrays) -> Result<RunFile> {
    read_members(path, |members| of_parts(path, members, arrays))
}

pub(super) fn of_parts(path: &Path, members: &mut dyn Parts, arrays: Arrays) -> Result<RunFile> {
    let mut setup = read_setup(path, members)?;
    let report = text(members, "report")?;
    let report: RunReport = serde_json::from_str(&report).map_err(|error| {
        let reason = error.to_string();
        members.fault("report", Fault::report(reason))
    })?;
    let chain = &mut setup.simulation.chain;
    chain.mass = stated(members, "mass", &chain.mass)?;
    chain.coefficient = stated(members, "contact_coefficient", &chain.coefficient)?;
    let run = read_run(members, &setup, report, arrays)?;
    Ok(RunFile { setup, run })
}

pub(super) fn scene_and_step(path: &Path) -> Result<(Setup, f64)> {
    read_members(path, |members| {
        let setup = read_setup(path, members)?;
        let time = vector(members, "time", setup.simulation.samples)?;
        let step = match time[..] {
            [first, second, ..] => second - first,
            _ => f64::NAN,
        };
        Ok((setup, step))
    })
}

fn text(members: &mut dyn Parts, name: &'static str) -> Result<String> {
    let found = members.text(name)?;
    found.ok_or_else(|| members.fault("", no_run(name)))
}

fn no_run(missing: &str) -> Fault {
    let said = format!("expected a run file: the member {missing:?} is not there");
    Fault::new(said, SIMULATE)
}

fn read_setup(path: &Path, members: &mut dyn Parts) -> Result<Setup> {
    let schema = text(members, "schema")?;
    if schema != RUN_SCHEMA {
        let reason = format!("the layout {schema:?} in place of {RUN_SCHEMA:?}");
        return Err(members.fault("schema", Fault::report(reason)));
    }
    let scene = text(members, "scene")?;
    SceneSource::carried(Some(path), scene).setup()
}

fn read_run(
    members: &mut dyn Parts,
    setup: &Setup,
    report: RunReport,
    arrays: Arrays,
) -> Result<Run> {
    let simulation = &setup.simulation;
    let chain = simulation.chain.clone();
    let (samples, n, m) = (simulation.samples, chain.n_sites(), chain.n_contacts());
    let mut record = simulation.record;
    if arrays == Arrays::Motion {
        (record.force, record.energy) = (false, false);
    }
    let lost = record.energy && chain.is_lossy();
    let has_resonators = chain.resonators().is_some();
    let input = record.energy && simulation.drive.is_some();
    let mut optional = |name, wanted: bool, columns| match wanted && columns > 0 {
        true => matrix(members, name, samples, columns).map(Some),
        false => Ok(wanted.then(|| Array2::zeros((samples, 0)))),
    };
    let displacement = optional("displacement", record.displacement, n)?;
    let force = optional("force", record.force, m)?;
    let energy_passed = optional("energy_passed", record.energy, m)?;
    let energy_lost = optional("energy_lost", lost, n)?;
    let resonator_displacement = optional(
        "resonator_displacement",
        has_resonators && record.displacement,
        n,
    )?;
    let resonator_velocity = optional("resonator_velocity", has_resonators, n)?;
    let velocity = matrix(members, "velocity", samples, n)?;
    let energy_input = match input {
        true => Some(Array1::from(vector(members, "energy_input", samples)?)),
        false => None,
    };
    Ok(Run {
        time: Array1::from(vector(members, "time", samples)?),
        velocity,
        displacement,
        force,
        energy_passed,
        energy_lost,
        energy_input,
        resonator_displacement,
        resonator_velocity,
        gradient: None,
        chain,
        drive: simulation.drive.clone(),
        report,
    })
}

fn vector(members: &mut dyn Parts, name: &'static str, length: usize) -> Result<Vec<f64>> {
    shaped(members, name, &[length as u64])
}

fn matrix(members: &mut dyn Parts, name: &'static str, n: usize, m: usize) -> Result<Array2<f64>> {
    let values = shaped(members, name, &[n as u64, m as u64])?;
    Array2::from_shape_vec((n, m), values).map_err(|error| {
        let reason = error.to_string();
        members.fault(name, Fault::report(reason))
    })
}

/// The samples of a member of exactly this shape.
fn shaped(members: &mut dyn Parts, name: &'static str, expected: &[u64]) -> Result<Vec<f64>> {
    let Some((shape, values)) = members.array(name)? else {
        return Err(members.fault("", no_run(name)));
    };
    if shape != expected {
        let expected = format!("shape {}", shape_of(expected));
        let fault = Fault::expected(expected, shape_of(&shape), SIMULATE);
        return Err(members.fault(name, fault));
    }
    let hashes = members.text("hashes")?;
    match check_written(hashes.as_deref(), name, &values) {
        Ok(()) => Ok(values),
        Err(fault) => Err(members.fault(name, fault)),
    }
}

/// Values of the file that the scene gives too.
fn stated(members: &mut dyn Parts, name: &'static str, given: &[f64]) -> Result<Vec<f64>> {
    if given.is_empty() {
        return Ok(Vec::new());
    }
    let values = vector(members, name, given.len())?;
    let differs = |(a, b): (&f64, &f64)| (a - b).abs().partial_cmp(&(SAME * b.abs()));
    let at = values.iter().zip(given).position(|pair| {
        !matches!(
            differs(pair),
            Some(std::cmp::Ordering::Less | std::cmp::Ordering::Equal)
        )
    });
    match at {
        Some(index) => {
            let found = format!("another {name} at index {index}");
            let fault = Fault::expected("what the scene in the file says", found, SIMULATE);
            Err(members.fault(name, fault))
        }
        None => Ok(values),
    }
}
