//! A run file back to a run, checked against its scene.

use std::path::Path;

use ndarray::{Array1, Array2};

use super::{RUN_SCHEMA, RunFile};
use crate::chain::scene::{SceneSource, Setup};
use crate::chain::{Run, RunReport};
use crate::error::{InputFault, Result};
use crate::field::{Members, read_members};

/// By how much masses and coefficients may differ from those that the scene gives on another
/// machine, relative to their size.
const SAME: f64 = 1e-12;

pub(super) fn run_file(path: &Path) -> Result<RunFile> {
    read_members(path, |members| {
        let mut setup = read_setup(path, members)?;
        let report = text(members, "report")?;
        let report: RunReport = serde_json::from_str(&report).map_err(|error| {
            let reason = error.to_string();
            members.fault("report", InputFault::RunReport { reason })
        })?;
        let chain = &mut setup.simulation.chain;
        chain.mass = stated(members, "mass", &chain.mass)?;
        chain.coefficient = stated(members, "contact_coefficient", &chain.coefficient)?;
        let run = read_run(members, &setup, report)?;
        Ok(RunFile { setup, run })
    })
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

fn text(members: &mut Members, name: &'static str) -> Result<String> {
    let found = members.text(name)?;
    found.ok_or_else(|| members.fault("", InputFault::NoRun { missing: name }))
}

fn read_setup(path: &Path, members: &mut Members) -> Result<Setup> {
    let schema = text(members, "schema")?;
    if schema != RUN_SCHEMA {
        let reason = format!("the layout {schema:?} in place of {RUN_SCHEMA:?}");
        return Err(members.fault("schema", InputFault::RunReport { reason }));
    }
    let scene = text(members, "scene")?;
    SceneSource::new(Some(path), scene).setup()
}

fn read_run(members: &mut Members, setup: &Setup, report: RunReport) -> Result<Run> {
    let simulation = &setup.simulation;
    let chain = simulation.chain.clone();
    let (samples, n, m) = (simulation.samples, chain.n_sites(), chain.n_contacts());
    let record = simulation.record;
    let lost = record.energy && chain.losses.any();
    let input = record.energy && simulation.drive.is_some();
    let mut optional = |name, wanted: bool, columns| match wanted && columns > 0 {
        true => matrix(members, name, samples, columns).map(Some),
        false => Ok(wanted.then(|| Array2::zeros((samples, 0)))),
    };
    let displacement = optional("displacement", record.displacement, n)?;
    let force = optional("force", record.force, m)?;
    let energy_passed = optional("energy_passed", record.energy, m)?;
    let energy_lost = optional("energy_lost", lost, n)?;
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
        chain,
        drive: simulation.drive,
        report,
    })
}

fn vector(members: &mut Members, name: &'static str, length: usize) -> Result<Vec<f64>> {
    shaped(members, name, &[length as u64])
}

fn matrix(members: &mut Members, name: &'static str, n: usize, m: usize) -> Result<Array2<f64>> {
    let values = shaped(members, name, &[n as u64, m as u64])?;
    Array2::from_shape_vec((n, m), values).map_err(|error| {
        let reason = error.to_string();
        members.fault(name, InputFault::RunReport { reason })
    })
}

/// The samples of a member of exactly this shape.
fn shaped(members: &mut Members, name: &'static str, expected: &[u64]) -> Result<Vec<f64>> {
    let Some((shape, values)) = members.array(name)? else {
        return Err(members.fault("", InputFault::NoRun { missing: name }));
    };
    if shape != expected {
        let fault = InputFault::RunShape {
            expected: expected.to_vec(),
            found: shape,
        };
        return Err(members.fault(name, fault));
    }
    Ok(values)
}

/// Values of the file that the scene gives too.
fn stated(members: &mut Members, name: &'static str, given: &[f64]) -> Result<Vec<f64>> {
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
            let fault = InputFault::RunScene { what: name, index };
            Err(members.fault(name, fault))
        }
        None => Ok(values),
    }
}
