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

/// Hands all samples over in blocks of `times` and `sites`, time-major; of all sites, if so.
///
/// # Errors
/// Those of `put`; [`crate::Error::Cancelled`].
pub(super) fn each_block(
    field: &Field,
    of_all_sites: bool,
    observer: &dyn Observer,
    mut put: impl FnMut(Range<usize>, Range<usize>, &[f64]) -> Result<()>,
) -> Result<()> {
    let (n_times, n_sites) = (field.n_times(), field.n_sites());
    let sites = match (of_all_sites, field.is_time_major()) {
        (true, _) => n_sites,
        (false, true) => n_sites.min(SAMPLES),
        (false, false) => n_sites.min(SITES),
    };
    let times = (SAMPLES / sites.max(1)).clamp(1, n_times.max(1));
    // A short record leaves room for more sites.
    let sites = (SAMPLES / times).clamp(sites.max(1), n_sites.max(1));
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
