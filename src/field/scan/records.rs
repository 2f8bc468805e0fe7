//! The record of one file, with its reference.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::super::align::Alignment;
use super::super::options::OpenOptions;
use super::super::{Field, Note};
use super::Scan;
use super::correlate::{Delay, delay};
use super::position::{fault_of, misfit};
use crate::error::{Error, Fault, InputFault, Result};

/// What is known of a file before its record is taken.
#[derive(Debug)]
pub(super) struct Head {
    pub(super) path: PathBuf,
    /// Without its samples.
    pub(super) field: Field,
    /// Of the reference channel, if there is one.
    pub(super) delay: Option<Delay>,
}

/// One channel of an opened file.
struct Channel {
    field: Field,
    site: usize,
}

impl Channel {
    fn samples(&self) -> Vec<f64> {
        let mut record = vec![0.0; self.field.n_times()];
        let site = self.site..self.site + 1;
        self.field
            .read_site_major(0..record.len(), site, &mut record);
        record
    }
}

/// The heads of all files, in their order.
pub(super) fn heads(scan: &Scan, paths: &[&PathBuf], options: &OpenOptions) -> Result<Vec<Head>> {
    let options = OpenOptions {
        hash: false,
        ..options.clone()
    };
    let reference = |path: &Path| match &scan.reference {
        Some(name) => channel(path, name, &options).map(|channel| Some(channel.samples())),
        None => Ok(None),
    };
    let first = reference(paths[0])?;
    let head = |path: &&PathBuf| {
        let field = record(scan, path, &options)?.field.without_samples();
        let delay = match (&first, reference(path)?) {
            (Some(first), Some(record)) => Some(known_delay(scan, path, first, &record)?),
            _ => None,
        };
        Ok(Head {
            path: path.to_path_buf(),
            field,
            delay,
        })
    };
    let all: Vec<Result<Head>> = paths.par_iter().map(head).collect();
    // The first fault in the order of the sites.
    all.into_iter().collect()
}

/// The delay of a record of the reference against the first one, if both are alike.
fn known_delay(scan: &Scan, path: &Path, first: &[f64], record: &[f64]) -> Result<Delay> {
    let delay = delay(first, record);
    let delay = delay.ok_or_else(|| {
        let expected = "finite samples in the reference channel that are not all equal";
        let advice = "name another `--reference`, or leave the file out";
        fault_of(path, Fault::expected(expected, "others", advice))
    })?;
    match delay.coefficient < scan.least_correlation {
        false => Ok(delay),
        true => {
            let least = scan.least_correlation;
            let expected = format!(
                "a correlation coefficient of at least {least} with the reference of the first file"
            );
            let (found, samples) = (delay.coefficient, delay.samples);
            let found = format!("{found:.3} at a delay of {samples} samples");
            let advice = "check file and channel; `--least-correlation` accepts a weaker one";
            Err(fault_of(path, Fault::expected(expected, found, advice)))
        }
    }
}

/// The common part of record `n`, and the hash of its file.
pub(super) fn aligned(
    scan: &Scan,
    head: &Head,
    alignment: &Alignment,
    n: usize,
    options: &OpenOptions,
) -> Result<(Vec<f64>, String)> {
    let options = OpenOptions {
        hash: true,
        ..options.clone()
    };
    let channel = record(scan, &head.path, &options)?;
    let mut out = vec![0.0; alignment.n_times];
    let read = |from: usize, out: &mut [f64]| {
        let (times, site) = (from..from + out.len(), channel.site..channel.site + 1);
        channel.field.read_site_major(times, site, out);
    };
    alignment.record(n, read, &mut out);
    // Nothing was written to the file since its head was read.
    head.field.check_unchanged()?;
    Ok((out, channel.field.content_hash.unwrap_or_default()))
}

/// The record of a file: the stated channel, the only one, or the one beside the reference.
fn record(scan: &Scan, path: &Path, options: &OpenOptions) -> Result<Channel> {
    if let Some(name) = &scan.channel {
        return channel(path, name, options);
    }
    let field = Field::open(path, options)?;
    let site = match (field.n_sites(), &scan.reference) {
        (1, _) => Some(0),
        (2, Some(name)) => column(&field, name).map(|reference| 1 - reference),
        _ => None,
    };
    let site = site.ok_or_else(|| several(path, field.n_sites()))?;
    Ok(Channel { field, site })
}

fn several(path: &Path, found: usize) -> Error {
    let advice = "name the record with `--channel` (a name, or a number from 0) or `--variable`; several files \
                  with a field each are analyzed without `--position-from`";
    misfit(path, Fault::expected("one record", found, advice))
}

/// The channel of this name: an array of the file, else a column by its name or its number.
fn channel(path: &Path, name: &str, options: &OpenOptions) -> Result<Channel> {
    let by_array = OpenOptions {
        variable: Some(name.to_owned()),
        ..options.clone()
    };
    let opened = match name.parse::<usize>() {
        Ok(_) => None,
        Err(_) => array(path, &by_array)?,
    };
    if let Some(field) = opened {
        return match field.n_sites() {
            1 => Ok(Channel { field, site: 0 }),
            found => Err(several(path, found)),
        };
    }
    let field = Field::open(path, options)?;
    let site = column(&field, name).ok_or_else(|| {
        let numbered = (0..field.n_sites()).map(|site| site.to_string());
        let found: Vec<String> = match field.channels.is_empty() {
            true => numbered.collect(),
            false => field.channels.clone(),
        };
        let advice = "name one of them, or count them from 0";
        let expected = format!("the channel {name:?}");
        misfit(path, Fault::expected(expected, found.join(", "), advice))
    })?;
    Ok(Channel { field, site })
}

/// The array that the options name; `None` if the file has none of that name.
fn array(path: &Path, options: &OpenOptions) -> Result<Option<Field>> {
    match Field::open(path, options) {
        Ok(field) => Ok(Some(field)),
        Err(Error::Request {
            option: "variable", ..
        }) => Ok(None),
        Err(Error::Input {
            fault: InputFault::NoSuchVariable { .. },
            ..
        }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// The site of the column of this name or number.
fn column(field: &Field, name: &str) -> Option<usize> {
    let named = field.channels.iter().position(|channel| channel == name);
    named.or_else(|| name.parse().ok().filter(|&site| site < field.n_sites()))
}

/// That all records have the step, the unit and the quantity of the first.
pub(super) fn check_alike(heads: &[Head], jitter: f64) -> Result<()> {
    let first = &heads[0].field;
    for Head { path, field, .. } in heads {
        let unit = |unit: &Option<String>| unit.clone().unwrap_or_else(|| "not stated".into());
        // Over the whole record, less than a jitter.
        let drift = (field.time.step - first.time.step).abs() * field.n_times as f64;
        let is_one_step = drift <= jitter.max(1e-6) * first.time.step;
        let said = |of: &Field| {
            [
                ("the unit of time", unit(&of.time.unit)),
                ("the step", of.time.step.to_string()),
                ("the quantity", of.quantity.name().to_owned()),
                ("the unit", unit(&of.unit)),
            ]
        };
        let mut pairs = said(first).into_iter().zip(said(field));
        let differs = |(a, b): &((_, _), (_, _))| a != b && !(a.0 == "the step" && is_one_step);
        if let Some(((what, expected), (_, found))) = pairs.find(differs) {
            let expected = format!("{what} {expected} as in the first file");
            let advice =
                "leave the file out, or write it anew with the step and unit of the others";
            return Err(fault_of(path, Fault::expected(expected, found, advice)));
        }
    }
    Ok(())
}

/// What was concluded about the files: of each kind what was said first.
pub(super) fn notes(heads: &[Head]) -> Vec<Note> {
    let mut notes: Vec<Note> = Vec::new();
    for note in heads.iter().flat_map(|head| &head.field.notes) {
        if notes.iter().all(|known| known.code != note.code) {
            notes.push(note.clone());
        }
    }
    notes
}
