//! Where the samples of a variable are: in the file as they lie, else decoded into memory or, where that
//! is not allowed, into a scratch file.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use wavecascade_formats::{Place, Sample};

use super::super::assembly::ScratchFile;
use super::super::file_bytes::FileBytes;
use super::super::open::FileSource;
use super::super::storage::{Bytes, Storage};
use super::Arrays;
use super::choose::Choice;
use crate::error::{Error, InputFault, Result};
use crate::system::memory::{half_of_free_memory, try_filled};

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
    let too_large = || InputFault::TooLarge {
        shape: variable.shape(),
        sample_bytes: sample.bytes(),
    };
    let row = width.checked_mul(sample.bytes()).ok_or_else(too_large)?;
    let length = row.checked_mul(rows).ok_or_else(too_large)?;
    // A short file may claim any length.
    let most = container.most_bytes();
    if length as u64 > most {
        let claimed = length as u64;
        return Err(InputFault::Overclaimed { claimed, most }.into());
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
    let slab_rows = fitting.next_multiple_of(chunk).max(chunk).min(rows as u64) as usize;
    let slab_of = |slab: usize| {
        let from = slab * slab_rows;
        let mut block = block.clone();
        block[slow] = from as u64..rows.min(from + slab_rows) as u64;
        block
    };
    let read =
        |slab: usize, out: &mut [u8]| Ok(container.read(choice.variable, &slab_of(slab), out)?);
    let allowed = source.options.memory.unwrap_or_else(half_of_free_memory);
    let bytes = if length as u64 <= allowed {
        let refused = |_| Error::Refused {
            what: "the decoded field",
            needed: length as u64,
        };
        let mut all = try_filled(length, 0u8).map_err(refused)?;
        all.par_chunks_mut(slab_rows * row)
            .enumerate()
            .try_for_each(|(slab, out)| read(slab, out))?;
        Bytes::Unpacked(Arc::new(all))
    } else {
        Bytes::Spilled(spilled(source, length, slab_rows * row, read)?)
    };
    Ok(Storage::in_rows(bytes, sample, width, rows_are_times))
}

/// Decodes slab by slab to an unnamed file, which disappears when it is closed, however the program
/// ends.
fn spilled(
    source: &FileSource,
    length: usize,
    slab: usize,
    read: impl Fn(usize, &mut [u8]) -> Result<()>,
) -> Result<Arc<FileBytes>> {
    source.allow("a part of the field that is decoded at once", slab as u64)?;
    let file = ScratchFile::new(length as u64)?;
    let refused = |_| Error::Refused {
        what: "a part of the field that is decoded at once",
        needed: slab as u64,
    };
    let mut out = try_filled(slab, 0u8).map_err(refused)?;
    for (n, from) in (0..length).step_by(slab).enumerate() {
        let out = &mut out[..slab.min(length - from)];
        read(n, out)?;
        file.write(from as u64, out)?;
    }
    file.finish()
}
