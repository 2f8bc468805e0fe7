//! A run to a run file.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use super::super::{Archive, ArrayFile, ArrayLabels, Attribute, NetCdf};
use super::RUN_SCHEMA;
use super::read::SAME;
use crate::arrays::Precision;
use crate::chain::scene::{SceneSource, Setup, Units};
use crate::chain::{Chain, Run};
use crate::error::{Error, Result};
use crate::field::array_hash;
use crate::observer::Observer;

/// Refuses a run of another chain than that of the scene's text, from which a reader makes it.
pub(super) fn check(path: &Path, setup: &Setup, run: &Run) -> Result<()> {
    let (chain, samples) = SceneSource::carried(None, &*setup.text).chain()?;
    let times = run.time.len();
    let found = match times == samples {
        true => difference(&run.chain, &chain),
        false => Some(format!("{times} samples in place of {samples}")),
    };
    match found {
        Some(found) => Err(Error::Unfit {
            path: path.to_owned(),
            expected: "a run of what its scene describes".into(),
            found,
        }),
        None => Ok(()),
    }
}

/// How a chain differs from that of its scene.
fn difference(chain: &Chain, scene: &Chain) -> Option<String> {
    let values = |what: &str, own: &[f64], given: &[f64]| {
        if own.len() != given.len() {
            return Some(format!("{} {what} in place of {}", own.len(), given.len()));
        }
        let is_same = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME * b.abs();
        let j = own.iter().zip(given).position(|pair| !is_same(pair))?;
        Some(format!("{what}[{j}] = {} in place of {}", own[j], given[j]))
    };
    let laws = || {
        let mut contacts = 0..chain.n_contacts();
        let j = contacts.find(|j| chain.law.of(*j) != scene.law.of(*j))?;
        let [own, given] = [chain, scene].map(|chain| chain.law.of(j).text());
        Some(format!(
            "the law `{own}` of contact {j} in place of `{given}`"
        ))
    };
    let others = || {
        let others = [
            ("ends", chain.ends != scene.ends),
            (
                "law at the wall before site 0",
                chain.law.before_first() != scene.law.before_first(),
            ),
            (
                "precompression",
                chain.precompression != scene.precompression,
            ),
            ("losses", chain.losses != scene.losses),
            (
                "gravity, ground or resonators",
                chain.on_site != scene.on_site,
            ),
        ];
        let (what, _) = others.into_iter().find(|(_, differs)| *differs)?;
        Some(format!("other {what}"))
    };
    values("masses", &chain.mass, &scene.mass)
        .or_else(|| values("coefficients", &chain.coefficient, &scene.coefficient))
        .or_else(laws)
        .or_else(others)
}

pub(super) fn archive(
    path: &Path,
    setup: &Setup,
    run: &Run,
    observer: &dyn Observer,
) -> Result<()> {
    let archive = Archive::create(path, Precision::F64)?;
    archive.append_text("schema", RUN_SCHEMA)?;
    let hashes = each_array(setup, run, observer, &mut |labels, values| {
        archive.append(labels, values)?;
        match labels.unit {
            "" => Ok(()),
            unit => archive.append_text(&format!("{}_unit", labels.name), unit),
        }
    })?;
    archive.append_text("scene", &setup.text)?;
    if let Some(gradient) = &run.gradient {
        archive.append_text("gradient_parameters", &gradient.names())?;
    }
    archive.append_text("report", &json(path, &run.report)?)?;
    archive.append_text("hashes", &json(path, &hashes)?)?;
    archive.finish()
}

/// The same arrays with named dimensions. Scene and report are attributes.
pub(super) fn netcdf(path: &Path, setup: &Setup, run: &Run, observer: &dyn Observer) -> Result<()> {
    let file = NetCdf::create(path, Precision::F64)?;
    labelled(path, setup, run, &file, observer)?;
    file.finish()
}

/// The same to what takes labelled arrays; messages call it `path`.
pub(super) fn labelled(
    path: &Path,
    setup: &Setup,
    run: &Run,
    file: &dyn ArrayFile,
    observer: &dyn Observer,
) -> Result<()> {
    let text = |text: &str| Attribute::Text(text.into());
    file.attribute("schema", text(RUN_SCHEMA));
    file.attribute(
        "source",
        text(concat!("cascade ", env!("CARGO_PKG_VERSION"))),
    );
    file.attribute("scene", text(&setup.text));
    file.attribute("report", text(&json(path, &run.report)?));
    if let Some(gradient) = &run.gradient {
        file.attribute("gradient_parameters", text(&gradient.names()));
    }
    let (times, sites) = run.velocity.dim();
    file.attribute("shape", text(&format!("{times} x {sites}")));
    if let Ok(site) = run.struck().try_into() {
        file.attribute("struck_site", Attribute::Integer(site));
    }
    let hashes = each_array(setup, run, observer, &mut |labels, values| {
        file.append(labels, values)?;
        if labels.axes.len() > 1 {
            // Without this, the number that NetCDF leaves in what was never written is a gap.
            let gap = Attribute::Number(f64::NAN);
            file.describe(labels.name, vec![("_FillValue", gap)]);
        }
        Ok(())
    })?;
    file.attribute("hashes", text(&json(path, &hashes)?));
    Ok(())
}

fn json(path: &Path, value: &impl Serialize) -> Result<String> {
    serde_json::to_string(value).map_err(|error| Error::Write {
        path: path.to_owned(),
        action: "write the report to",
        source: error.into(),
    })
}

type Add<'a> = &'a mut dyn FnMut(&ArrayLabels, &[f64]) -> Result<()>;

/// Hands over every array of a run; their hashes by their names.
fn each_array(
    setup: &Setup,
    run: &Run,
    observer: &dyn Observer,
    add: Add,
) -> Result<BTreeMap<String, String>> {
    let mut hashes = BTreeMap::new();
    let mut add = |labels: &ArrayLabels, values: &[f64]| {
        hashes.insert(labels.name.to_owned(), array_hash(values));
        add(labels, values)
    };
    arrays(setup, run, observer, &mut add)?;
    Ok(hashes)
}

fn arrays(setup: &Setup, run: &Run, observer: &dyn Observer, add: Add) -> Result<()> {
    // A run without units has none of these.
    let unit = |of: &'static str| match setup.units {
        Units::None => "",
        Units::Si => of,
    };
    // A new array is contiguous, in order.
    let time = run.time.as_slice().unwrap_or_default();
    line(add, ["time", "time"], time, unit("s"))?;
    observer.stage("writing", 7);
    let resonators = [&run.resonator_displacement, &run.resonator_velocity];
    for (name, axis, array, unit) in [
        ("velocity", SITES, Some(&run.velocity), unit("m/s")),
        ("displacement", SITES, run.displacement.as_ref(), unit("m")),
        ("force", CONTACTS, run.force.as_ref(), unit("N")),
        (
            "energy_passed",
            CONTACTS,
            run.energy_passed.as_ref(),
            unit("J"),
        ),
        ("energy_lost", SITES, run.energy_lost.as_ref(), unit("J")),
        (
            "resonator_displacement",
            SITES,
            resonators[0].as_ref(),
            unit("m"),
        ),
        (
            "resonator_velocity",
            SITES,
            resonators[1].as_ref(),
            unit("m/s"),
        ),
    ] {
        observer.advance(1);
        observer.go_on()?;
        let Some(array) = array.filter(|array| array.ncols() > 0) else {
            continue;
        };
        let axes = [("time", array.nrows()), (axis, array.ncols())];
        let labels = ArrayLabels {
            unit,
            ..ArrayLabels::of(name, &axes)
        };
        add(&labels, array.as_slice().unwrap_or_default())?;
    }
    if let Some(input) = &run.energy_input {
        let input = input.as_slice().unwrap_or_default();
        line(add, ["energy_input", "time"], input, unit("J"))?;
    }
    if let Some(gradient) = &run.gradient {
        let (parameters, times, sites) = gradient.velocity.dim();
        let axes = [("parameter", parameters), ("time", times), (SITES, sites)];
        for (name, array) in [
            ("gradient_velocity", &gradient.velocity),
            ("gradient_displacement", &gradient.displacement),
        ] {
            let labels = ArrayLabels {
                about: "per unit of the parameter, in the order of `gradient_parameters`",
                ..ArrayLabels::of(name, &axes)
            };
            add(&labels, array.as_slice().unwrap_or_default())?;
        }
        line(add, ["gradient_error", "parameter"], &gradient.error, "")?;
    }
    let chain = &run.chain;
    line(add, ["mass", SITES], &chain.mass, unit("kg"))?;
    if let Some(all) = &chain.on_site.resonators {
        line(add, ["resonator_mass", SITES], &all.mass, unit("kg"))?;
        line(
            add,
            ["resonator_stiffness", SITES],
            &all.stiffness,
            unit("N/m"),
        )?;
    }
    let coefficient = match setup.units {
        Units::None => String::new(),
        Units::Si => setup.simulation.chain.law.coefficient_unit(),
    };
    let name = ["contact_coefficient", CONTACTS];
    line(add, name, &chain.coefficient, &coefficient)?;
    let Some(pitch) = setup.pitch else {
        return Ok(());
    };
    for (name, n, first) in [
        (SITES, chain.n_sites(), 0.0),
        (CONTACTS, chain.n_contacts(), 0.5),
    ] {
        let places: Vec<f64> = (0..n).map(|j| pitch * (j as f64 + first)).collect();
        line(add, [name, name], &places, unit("m"))?;
    }
    Ok(())
}

/// Axes of sites and of contacts.
const SITES: &str = "position";
const CONTACTS: &str = "contact_position";

/// Hands over an array of one dimension, unless it is empty.
fn line(add: Add, [name, axis]: [&str; 2], values: &[f64], unit: &str) -> Result<()> {
    if values.is_empty() {
        return Ok(());
    }
    let axes = [(axis, values.len())];
    let labels = ArrayLabels {
        unit,
        ..ArrayLabels::of(name, &axes)
    };
    add(&labels, values)
}
