//! A run to a run file.

use std::path::Path;

use ndarray::Array2;

use super::super::Archive;
use super::RUN_SCHEMA;
use crate::arrays::Precision;
use crate::chain::scene::{Setup, Units};
use crate::chain::{Law, Run};
use crate::error::{Error, Result};
use crate::observer::Observer;

pub(super) fn all(path: &Path, setup: &Setup, run: &Run, observer: &dyn Observer) -> Result<()> {
    let archive = Archive::create(path, Precision::F64)?;
    let units = UnitNames::of(setup);
    archive.append_text("schema", RUN_SCHEMA)?;
    let line = |name: &str, values: &[f64], unit: Option<&str>| {
        if values.is_empty() {
            return Ok(());
        }
        archive.append(name, &[values.len()], values)?;
        append_unit(&archive, name, unit)
    };
    // A new array is contiguous, in order.
    line("time", run.time.as_slice().unwrap_or_default(), units.time)?;
    observer.stage("writing", 5);
    let table = |name: &str, array: Option<&Array2<f64>>, unit: Option<&str>| {
        observer.advance(1);
        if observer.cancelled() {
            return Err(Error::Cancelled);
        }
        let Some(array) = array.filter(|array| array.ncols() > 0) else {
            return Ok(());
        };
        let values = array.as_slice().unwrap_or_default();
        archive.append(name, &[array.nrows(), array.ncols()], values)?;
        append_unit(&archive, name, unit)
    };
    table("velocity", Some(&run.velocity), units.speed)?;
    table("displacement", run.displacement.as_ref(), units.length)?;
    table("force", run.force.as_ref(), units.force)?;
    table("energy_passed", run.energy_passed.as_ref(), units.energy)?;
    table("energy_lost", run.energy_lost.as_ref(), units.energy)?;
    if let Some(input) = &run.energy_input {
        line(
            "energy_input",
            input.as_slice().unwrap_or_default(),
            units.energy,
        )?;
    }
    let chain = &run.chain;
    line("mass", &chain.mass, units.mass)?;
    line(
        "contact_coefficient",
        &chain.coefficient,
        units.coefficient.as_deref(),
    )?;
    if let Some(pitch) = setup.pitch {
        let places = |n: usize, first: f64| -> Vec<f64> {
            (0..n).map(|j| pitch * (j as f64 + first)).collect()
        };
        line("position", &places(chain.n_sites(), 0.0), units.length)?;
        line(
            "contact_position",
            &places(chain.n_contacts(), 0.5),
            units.length,
        )?;
    }
    archive.append_text("scene", &setup.text)?;
    let report = serde_json::to_string(&run.report).map_err(|error| Error::Write {
        path: path.to_owned(),
        action: "write the report to",
        source: error.into(),
    })?;
    archive.append_text("report", &report)?;
    archive.finish()
}

fn append_unit(archive: &Archive, name: &str, unit: Option<&str>) -> Result<()> {
    match unit {
        Some(unit) => archive.append_text(&format!("{name}_unit"), unit),
        None => Ok(()),
    }
}

/// The units of a run, where it has any.
#[derive(Default)]
struct UnitNames {
    time: Option<&'static str>,
    length: Option<&'static str>,
    speed: Option<&'static str>,
    force: Option<&'static str>,
    energy: Option<&'static str>,
    mass: Option<&'static str>,
    coefficient: Option<String>,
}

impl UnitNames {
    fn of(setup: &Setup) -> UnitNames {
        match setup.units {
            Units::None => UnitNames::default(),
            Units::Si => UnitNames {
                time: Some("s"),
                length: Some("m"),
                speed: Some("m/s"),
                force: Some("N"),
                energy: Some("J"),
                mass: Some("kg"),
                coefficient: Some(match setup.simulation.chain.law {
                    Law::Hertz => "N/m^1.5".into(),
                    Law::Power { exponent } => format!("N/m^{exponent}"),
                    Law::Spring { .. } => "N/m".into(),
                }),
            },
        }
    }
}
