//! A field block by block, in an order that suits its file.

use std::ops::Range;

use crate::error::Result;
use crate::field::Field;
use crate::observer::Observer;

/// Samples of a block.
const SAMPLES: usize = 1 << 20;
/// Sites of a block where records are contiguous: pieces of records and of profiles are both some pages
/// long.
const SITES: usize = 1 << 10;

/// Hands all samples over in blocks of `times` and `sites`, time-major.
///
/// # Errors
/// Those of `put`; [`crate::Error::Cancelled`].
pub(super) fn each_block(
    field: &Field,
    observer: &dyn Observer,
    put: impl FnMut(Range<usize>, Range<usize>, &[f64]) -> Result<()>,
) -> Result<()> {
    let (n_times, n_sites) = (field.n_times(), field.n_sites());
    let sites = match field.is_time_major() {
        true => n_sites.min(SAMPLES),
        false => n_sites.min(SITES),
    };
    let times = (SAMPLES / sites.max(1)).clamp(1, n_times.max(1));
    // A short record leaves room for more sites.
    let sites = (SAMPLES / times).clamp(1, n_sites.max(1));
    blocks(field, [times, sites], observer, put)
}

/// The same in blocks that hold all sites.
///
/// # Errors
/// As [`each_block`].
pub(super) fn each_profile(
    field: &Field,
    observer: &dyn Observer,
    mut put: impl FnMut(Range<usize>, &[f64]) -> Result<()>,
) -> Result<()> {
    let sites = field.n_sites();
    let times = (SAMPLES / sites.max(1)).clamp(1, field.n_times().max(1));
    let whole = |times, _, values: &[f64]| put(times, values);
    blocks(field, [times, sites], observer, whole)
}

fn blocks(
    field: &Field,
    [times, sites]: [usize; 2],
    observer: &dyn Observer,
    mut put: impl FnMut(Range<usize>, Range<usize>, &[f64]) -> Result<()>,
) -> Result<()> {
    let (n_times, n_sites) = (field.n_times(), field.n_sites());
    let count = n_times.div_ceil(times) * n_sites.div_ceil(sites);
    observer.stage("writing", count as u64);
    let mut block = vec![0.0; times * sites];
    for site in (0..n_sites).step_by(sites) {
        for time in (0..n_times).step_by(times) {
            observer.go_on()?;
            let times = time..n_times.min(time + times);
            let sites = site..n_sites.min(site + sites);
            let block = &mut block[..times.len() * sites.len()];
            field.read_releasing(times.clone(), sites.clone(), block);
            field.release_block(times.clone(), sites.clone());
            put(times, sites, block)?;
            observer.advance(1);
        }
    }
    Ok(())
}
