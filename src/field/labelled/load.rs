//! Where the samples of a variable are: in the file as they lie, else decoded into memory or, where that
//! is not allowed, into a scratch file.

use std::ops::Range;

use wavecascade_formats::{Place, Sample};

use super::super::assembly::Assembly;
use super::super::storage::Storage;
use super::Arrays;
use super::choose::Choice;
use crate::error::{DAMAGED, Fault, Result, shape_of};

/// Bytes that are decoded at once, if a chunk is not longer.
const SLAB: u64 = 32 << 20;

/// The samples `(time, site)` that `choice` names.
pub(super) fn storage(arrays: &Arrays, choice: &Choice) -> Result<Storage> {
    let sites = choice.sites.as_ref().map(|sites| sites.dimension);
    let dimensions = [Some(choice.times.dimension), sites];
    match arrays.piece(choice.variable, dimensions, &choice.fixed)? {
        Some(storage) => Ok(storage),
        None => decoded(arrays, choice),
    }
}

/// The samples decoded, in the order of their dimensions.
fn decoded(arrays: &Arrays, choice: &Choice) -> Result<Storage> {
    let (source, container) = (arrays.source, &arrays.container);
    let [n_times, n_sites] = choice.shape(arrays);
    let variable = arrays.variable(choice.variable);
    let sample = variable.sample_type.number().unwrap_or(Sample::F64);
    let (times, sites) = (&choice.times, choice.sites.as_ref());
    let rows_are_times = sites.is_none_or(|sites| times.dimension < sites.dimension);
    let (slow, rows, width) = match (rows_are_times, sites) {
        (false, Some(sites)) => (sites.dimension, n_sites, n_times),
        _ => (times.dimension, n_times, n_sites),
    };
    let too_large = || {
        let (shape, bytes) = (shape_of(&variable.shape()), sample.bytes());
        let found = format!("shape {shape} of {bytes}-byte samples");
        Fault::expected("an array that can be addressed", found, DAMAGED)
    };
    let row = width.checked_mul(sample.bytes()).ok_or_else(too_large)?;
    let length = row.checked_mul(rows).ok_or_else(too_large)?;
    // A short file may claim any length.
    let most = container.most_bytes();
    if length as u64 > most {
        return Err(Fault::overclaimed(length as u64, most).into());
    }
    let mut block: Vec<Range<u64>> = variable.dimensions.iter().map(|d| 0..d.len).collect();
    for &(d, index) in &choice.fixed {
        block[d] = index..index + 1;
    }
    let chunk = match &variable.place {
        Place::Encoded { rows } if slow == 0 => (*rows).max(1),
        _ => 1,
    };
    let fitting = (SLAB / (row as u64).max(1)).max(1);
    let at_once = fitting.next_multiple_of(chunk).max(chunk).min(rows as u64) as usize;
    let shape = [rows, width];
    let mut assembly = Assembly::new("the decoded field", sample, shape, source.options)?;
    if !assembly.is_in_memory() {
        let part = (at_once * row) as u64;
        source.allow("a part of the field that is decoded at once", part)?;
    }
    assembly.fill(at_once, |part, out| {
        let mut block = block.clone();
        block[slow] = part.start as u64..part.end as u64;
        Ok(container.read(choice.variable, &block, out)?)
    })?;
    assembly.finish(rows_are_times)
}
