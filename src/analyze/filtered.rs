//! A field filtered in frequency and wavenumber.

mod blocks;

use ndarray::{Array2, ArrayView2, s};

use crate::error::{Error, Result};
use crate::field::{Field, Storage};
use crate::numeric::pieces;
use crate::observer::Observer;
use crate::system::memory::{available_memory, try_filled};
use crate::transform::{Passband, SpaceTimeFilter};

/// Bytes of a field that are read at once.
const READ_BYTES: usize = 8 << 20;

/// A field that has passed a filter.
#[derive(Debug, Clone)]
pub struct Filtered {
    pub field: Field,
    /// `sum v^2` of the samples before and after.
    pub energy_before: f64,
    pub energy_after: f64,
}

/// The part of a field that passes a filter, and the share of its energy.
///
/// `v` is multiplied by a gain of 1 or 0 in (k, f) ([`SpaceTimeFilter`]); with `pad`, the field is
/// first padded with zeros to twice its length along both axes, so that the periodic extension does
/// not wrap waves around.
///
/// A field whose transform does not fit into `memory` is filtered in blocks through two scratch files, each as long
/// as the padded field, with the same bits.
///
/// # Errors
/// [`Error::Request`] for bands with edges in the wrong order; [`Error::NonFinite`] for samples
/// that are not numbers; [`Error::Memory`] for memory that does not hold eight records, and
/// [`Error::Refused`] where the system has less memory than was allowed; [`Error::Cancelled`], which is noticed
/// while samples are read, and before and behind the transform.
pub fn filtered(
    field: &Field,
    band: &Passband,
    pad: bool,
    memory: Option<u64>,
    observer: &dyn Observer,
) -> Result<Filtered> {
    band.check()?;
    let (times, sites) = (field.n_times(), field.n_sites());
    let twice = if pad { 2 } else { 1 };
    let shape = (twice * times, twice * sites);
    let allowed = memory.unwrap_or_else(available_memory);
    let (samples, energies) = match bytes_at_once(shape) <= allowed {
        true => at_once(field, band, shape, observer)?,
        false => blocks::filtered(field, band, shape, allowed, observer)?,
    };
    let mut found = Field::of_storage(samples, (times, sites));
    found.time = field.time.clone();
    found.space = field.space.clone();
    found.quantity = field.quantity;
    found.unit = field.unit.clone();
    found.dispersion = field.dispersion.clone();
    found.name = format!("{}, filtered", field.name);
    Ok(Filtered {
        field: found,
        energy_before: energies.before.iter().sum(),
        energy_after: energies.after.iter().sum(),
    })
}

/// `sum v^2` of each site.
struct Energies {
    before: Vec<f64>,
    after: Vec<f64>,
}

/// Samples, half as many complex bins, and the result; then scratch of each thread.
fn bytes_at_once(shape: (usize, usize)) -> u64 {
    let arrays = (shape.0 as u64)
        .saturating_mul(shape.1 as u64)
        .saturating_mul(8 * 3);
    arrays.saturating_add(working_bytes(shape))
}

/// Scratch of all threads.
fn working_bytes(shape: (usize, usize)) -> u64 {
    rayon::current_num_threads() as u64 * SpaceTimeFilter::<f64>::working_bytes(shape)
}

/// A field that fits into memory.
fn at_once(
    field: &Field,
    band: &Passband,
    shape: (usize, usize),
    observer: &dyn Observer,
) -> Result<(Storage, Energies)> {
    let (times, sites) = (field.n_times(), field.n_sites());
    let values = read_padded(field, shape, observer)?;
    let samples = values.slice(s![..times, ..sites]);
    let mut gaps = Gaps::default();
    gaps.look(samples, 0);
    gaps.check(field)?;
    let before = energies(samples);
    let filter = SpaceTimeFilter::new(shape);
    let steps = (field.time.step, field.space.step);
    observer.stage("filtering", 1);
    let passed = filter.apply(values.view(), steps, band)?;
    observer.go_on()?;
    drop(values);
    let passed = match shape == (times, sites) {
        true => passed,
        false => passed.slice(s![..times, ..sites]).to_owned(),
    };
    let after = energies(passed.view());
    Ok((Storage::from_array(passed), Energies { before, after }))
}

/// `sum v^2` of each site, in the order of time.
fn energies(values: ArrayView2<f64>) -> Vec<f64> {
    let mut sums = vec![0.0; values.ncols()];
    for row in values.rows() {
        sums.iter_mut().zip(row).for_each(|(sum, v)| *sum += v * v);
    }
    sums
}

/// The samples of a field in an array of at least its shape, zeros behind them. Pages of a mapped
/// file are let go of as they are read.
fn read_padded(
    field: &Field,
    shape: (usize, usize),
    observer: &dyn Observer,
) -> Result<Array2<f64>> {
    let (times, sites) = (field.n_times(), field.n_sites());
    let values = zeros(shape.0 * shape.1, "the field")?;
    let mut values = Array2::from_shape_vec(shape, values).expect("a length of this shape");
    let rows = (READ_BYTES / (8 * sites)).clamp(1, times);
    let mut block = vec![0.0; rows * sites];
    observer.stage("reading", times as u64);
    for of in pieces(times, rows) {
        let count = of.len();
        let block = &mut block[..count * sites];
        field.read_time_major(of.clone(), 0..sites, block);
        let block = ArrayView2::from_shape((count, sites), &*block);
        let mut into = values.slice_mut(s![of, ..sites]);
        into.assign(&block.expect("a length of this shape"));
        field.release_pages();
        observer.advance(count as u64);
        observer.go_on()?;
    }
    Ok(values)
}

fn zeros<T: Copy + Default>(len: usize, what: &'static str) -> Result<Vec<T>> {
    try_filled(len, T::default()).map_err(|_| Error::Refused {
        what,
        needed: (len * size_of::<T>()) as u64,
    })
}

/// Samples that are no numbers.
#[derive(Default)]
struct Gaps {
    count: u64,
    first: Option<(usize, usize)>,
    sites: usize,
}

impl Gaps {
    /// Looks at the records of some sites, from site `from` on.
    fn look(&mut self, records: ArrayView2<f64>, from: usize) {
        let mut sites = vec![false; records.ncols()];
        for (time, row) in records.rows().into_iter().enumerate() {
            for (site, _) in row.iter().enumerate().filter(|(_, v)| !v.is_finite()) {
                let at = (time, from + site);
                self.count += 1;
                self.first = Some(self.first.map_or(at, |first| first.min(at)));
                sites[site] = true;
            }
        }
        self.sites += sites.iter().filter(|bad| **bad).count();
    }

    fn check(&self, field: &Field) -> Result<()> {
        let Some(first) = self.first else {
            return Ok(());
        };
        Err(Error::NonFinite {
            name: field.name.clone(),
            count: self.count,
            first,
            sites: self.sites,
            n_sites: field.n_sites(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::threads::in_pool;

    /// By hand: rows of 512 samples are 4096 bytes apart, so that each thread copies 8 lines of
    /// each of the 4096 rows. Beside them and the scratch there, 64 x 64 points in tiles of w
    /// columns, it holds a tile's sums, their transforms and scratch for the inverse.
    #[test]
    fn val_working_space_of_all_threads_counts() {
        let plan = crate::transform::RealToComplexColumns::<f64>::new(4096).unwrap();
        let width = plan.width() as u64;
        // With a cache line for the alignment.
        let scratch = 2 * width * (64 + 33 * 66) * 8 + 64;
        let back = width * (4096 + 2 * 2049) * 8 + scratch;
        let arrays = 4096 * 512 * 24;
        for threads in [1, 3] {
            let expected = arrays + threads * ((2 << 20) + scratch + back);
            let counted = in_pool(Some(threads as usize), || Ok(bytes_at_once((4096, 512))));
            assert_eq!(counted.unwrap(), expected);
        }
    }
}
