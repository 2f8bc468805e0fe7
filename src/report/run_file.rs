//! Run files: the arrays of a run with the scene that it is a run of, one `.npz` archive.
//!
//! A file appears whole or not at all. What is read back is checked against the scene in the file:
//! every array that the scene records is there, in the shape that it says.

use std::fs;
use std::path::{Path, PathBuf};

use ndarray::{Array1, Array2};

use super::Archive;
use crate::analyze::{Observer, Precision};
use crate::chain::scene::{SceneSource, Setup, Units};
use crate::chain::{Law, Run, RunReport};
use crate::error::{Error, Result};
use crate::field::{InputFault, Members, is_run_file, read_members};

/// Version of the layout of run files, which their member `schema` holds.
pub const RUN_SCHEMA: &str = "cascade.run/1";

/// By how much masses and coefficients may differ from those that the scene gives on another
/// machine, relative to their size.
const SAME: f64 = 1e-12;

/// A run with its scene.
#[derive(Debug, Clone)]
pub struct RunFile {
    pub setup: Setup,
    pub run: Run,
}

impl RunFile {
    /// That a run can be written to `path`, before any work is done.
    ///
    /// # Errors
    /// [`Error::Exists`] if a run is there and is not to be replaced, [`Error::Occupied`] if
    /// something else is; [`Error::Request`] for a path without a name; [`Error::Write`].
    pub fn check(path: &Path, replace: bool) -> Result<()> {
        check_free(path, replace)?;
        // Folders that are missing are made only once there is something to put into them.
        let there = path.ancestors().skip(1).find(|parent| parent.exists());
        let there = there.filter(|parent| !parent.as_os_str().is_empty());
        let probe = partial(there.unwrap_or(Path::new(".")), path);
        fs::write(&probe, "").map_err(Error::write("create", path))?;
        fs::remove_file(&probe).map_err(Error::write("remove", &probe))
    }

    /// Writes a run of `setup` to `path`.
    ///
    /// # Errors
    /// As [`RunFile::check`]; [`Error::Cancelled`] when the observer asks to stop.
    pub fn write(
        path: &Path,
        replace: bool,
        setup: &Setup,
        run: &Run,
        observer: &dyn Observer,
    ) -> Result<()> {
        check_free(path, replace)?;
        let parent = path.parent().unwrap_or(Path::new(""));
        let made: Vec<&Path> = parent.ancestors().take_while(|p| !is_there(p)).collect();
        let working = partial(parent, path);
        let written = fs::create_dir_all(parent)
            .map_err(Error::write("create", parent))
            .and_then(|()| write_all(&working, setup, run, observer))
            .and_then(|()| check_free(path, replace))
            .and_then(|()| fs::rename(&working, path).map_err(Error::write("rename to", path)));
        if written.is_err() {
            let _ = fs::remove_file(&working);
            for parent in made {
                // One that someone else has put something into stays.
                let _ = fs::remove_dir(parent);
            }
        }
        written
    }

    /// Reads a run back.
    ///
    /// # Errors
    /// [`Error::Read`]; [`Error::Input`] for a file that is no run or whose arrays are not what
    /// its scene says; [`Error::Scene`] for a scene that is at fault.
    pub fn read(path: &Path) -> Result<RunFile> {
        read_members(path, |members| {
            let text = |members: &mut Members, name: &'static str| {
                let found = members.text(name)?;
                found.ok_or_else(|| members.fault("", InputFault::NoRun { missing: name }))
            };
            let schema = text(members, "schema")?;
            if schema != RUN_SCHEMA {
                let reason = format!("the layout {schema:?} in place of {RUN_SCHEMA:?}");
                return Err(members.fault("schema", InputFault::RunReport { reason }));
            }
            let scene = text(members, "scene")?;
            let mut setup = SceneSource::new(Some(path), scene).setup()?;
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

fn write_all(path: &Path, setup: &Setup, run: &Run, observer: &dyn Observer) -> Result<()> {
    let archive = Archive::create(path, Precision::F64)?;
    let units = UnitNames::of(setup);
    let arrays: [(&str, Option<&Array2<f64>>, Option<&str>); 5] = [
        ("velocity", Some(&run.velocity), units.speed),
        ("displacement", run.displacement.as_ref(), units.length),
        ("force", run.force.as_ref(), units.force),
        ("energy_passed", run.energy_passed.as_ref(), units.energy),
        ("energy_lost", run.energy_lost.as_ref(), units.energy),
    ];
    observer.stage("writing", arrays.len() as u64);
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
    for (name, array, unit) in arrays {
        observer.advance(1);
        if observer.cancelled() {
            return Err(Error::Cancelled);
        }
        let Some(array) = array.filter(|array| array.ncols() > 0) else {
            continue;
        };
        let values = array.as_slice().unwrap_or_default();
        archive.append(name, &[array.nrows(), array.ncols()], values)?;
        append_unit(&archive, name, unit)?;
    }
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

/// The file that is written before it gets its name.
fn partial(folder: &Path, path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    folder.join(format!(".{name}.partial-{}", std::process::id()))
}

fn is_there(folder: &Path) -> bool {
    folder.as_os_str().is_empty() || folder.exists()
}

/// Refuses a place that is taken.
fn check_free(path: &Path, replace: bool) -> Result<()> {
    if path.file_name().is_none() {
        return Err(Error::Request {
            option: "out",
            expected: "a file with a name".into(),
            found: path.display().to_string(),
        });
    }
    let occupied = |found: &str| {
        Err(Error::Occupied {
            path: path.to_owned(),
            found: found.into(),
        })
    };
    match fs::symlink_metadata(path) {
        Err(_) => Ok(()),
        Ok(found) if !found.is_file() => occupied("is there and is no file"),
        Ok(_) if !is_run_file(path) => occupied("is there and is no run"),
        Ok(_) if replace => Ok(()),
        Ok(_) => Err(Error::Exists {
            path: path.to_owned(),
        }),
    }
}
