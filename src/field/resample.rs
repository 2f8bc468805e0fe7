//! Samples at uneven coordinates become samples at even ones.

use rayon::prelude::*;

use super::Sample;
use super::assembly::Assembly;
use super::interpolate::{Interpolant, Interpolation};
use super::options::OpenOptions;
use super::storage::Storage;
use crate::error::{Error, Result};
use crate::system::memory::try_filled;

/// Bytes of samples that are resampled at once, if a series is not longer.
const BLOCK: usize = 32 << 20;

/// By which method uneven coordinates are made even; an axis without one must be even.
///
/// The even axis has as many samples between the same ends: `t_n = t_0 + n (t_{N-1} - t_0) / (N - 1)`.
/// A step longer than [`Resample::LONGEST_STEP`] medians is a gap and is refused, since what happened within
/// is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Resample {
    /// Along time.
    pub time: Option<Interpolation>,
    /// Along space.
    pub space: Option<Interpolation>,
}

impl Resample {
    /// Longest step that is bridged, in median steps.
    pub const LONGEST_STEP: f64 = 3.0;

    /// One method for whichever axis is uneven.
    pub fn both(method: Interpolation) -> Resample {
        Resample {
            time: Some(method),
            space: Some(method),
        }
    }
}

/// Resamples `count` records, or profiles, a block of them at a time. They become the rows.
pub(super) fn resampled(
    storage: &Storage,
    count: usize,
    interpolant: &Interpolant,
    options: &OpenOptions,
    are_records: bool,
) -> Result<Storage> {
    const WHAT: &str = "the resampled field";
    let (n_in, n_out) = (interpolant.n_nodes(), interpolant.n_places());
    let mut assembly = Assembly::new(WHAT, Sample::F64, [count, n_out], options)?;
    let one = (n_in + n_out) * size_of::<f64>();
    // A small limit is shared with what reads the file.
    let bytes = options
        .memory
        .map_or(BLOCK, |memory| BLOCK.min((memory / 8) as usize));
    let block = (bytes / one.max(1)).clamp(1, count.max(1));
    let needed = (block * one) as u64;
    options.allow("a block of the field that is resampled", needed)?;
    let zeros = |len: usize| {
        let refused = |_| Error::Refused { what: WHAT, needed };
        try_filled(len, 0.0).map_err(refused)
    };
    let (mut input, mut output) = (zeros(block * n_in)?, zeros(block * n_out)?);
    for from in (0..count).step_by(block) {
        let part = from..count.min(from + block);
        let input = &mut input[..part.len() * n_in];
        let output = &mut output[..part.len() * n_out];
        let (times, sites) = match are_records {
            true => (0..n_in, part.clone()),
            false => (part.clone(), 0..n_in),
        };
        storage.read(times.clone(), sites.clone(), are_records, input);
        output
            .par_chunks_exact_mut(n_out)
            .zip(input.par_chunks_exact(n_in))
            .for_each_init(Vec::new, |slopes, (out, values)| {
                interpolant.apply(values, out, slopes);
            });
        storage.release_block(times, sites);
        assembly.write(part.start, output)?;
    }
    assembly.finish(!are_records)
}
