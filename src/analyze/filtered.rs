//! A field filtered in frequency and wavenumber.

use ndarray::{Array2, ArrayView2, s};

use crate::error::{Error, Result};
use crate::field::Field;
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
/// # Errors
/// [`Error::Request`] for bands with edges in the wrong order; [`Error::NonFinite`] for samples
/// that are not numbers; [`Error::Memory`] for a field whose transform does not fit, and
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
    // Samples, half as many complex bins, and the result; then scratch of each thread.
    let arrays = (shape.0 as u64)
        .saturating_mul(shape.1 as u64)
        .saturating_mul(8 * 3);
    let allowed = memory.unwrap_or_else(available_memory);
    let fits = |needed| match needed > allowed {
        true => Err(Error::Memory {
            what: "the transform of the field",
            needed,
            allowed,
        }),
        false => Ok(()),
    };
    fits(arrays)?;
    let working = SpaceTimeFilter::<f64>::working_bytes(shape);
    fits(arrays + rayon::current_num_threads() as u64 * working)?;
    let values = read_padded(field, shape, observer)?;
    let samples = values.slice(s![..times, ..sites]);
    check_finite(field, samples)?;
    let energy = |values: ArrayView2<f64>| values.iter().map(|v| v * v).sum::<f64>();
    let energy_before = energy(samples);
    let filter = SpaceTimeFilter::new(shape);
    let steps = (field.time.step, field.space.step);
    observer.stage("filtering", 1);
    let passed = filter.apply(values.view(), steps, band)?;
    check(observer)?;
    drop(values);
    let passed = match pad {
        true => passed.slice(s![..times, ..sites]).to_owned(),
        false => passed,
    };
    let energy_after = energy(passed.view());
    let mut found = Field::from_array(passed);
    found.time = field.time.clone();
    found.space = field.space.clone();
    found.quantity = field.quantity;
    found.unit = field.unit.clone();
    found.dispersion = field.dispersion.clone();
    found.name = format!("{}, filtered", field.name);
    Ok(Filtered {
        field: found,
        energy_before,
        energy_after,
    })
}

/// The samples of a field in an array of at least its shape, zeros behind them. Pages of a mapped
/// file are let go of as they are read.
fn read_padded(
    field: &Field,
    shape: (usize, usize),
    observer: &dyn Observer,
) -> Result<Array2<f64>> {
    let (times, sites) = (field.n_times(), field.n_sites());
    let len = shape.0 * shape.1;
    let values = try_filled(len, 0.0).map_err(|_| Error::Refused {
        what: "the field",
        needed: 8 * len as u64,
    })?;
    let mut values = Array2::from_shape_vec(shape, values).expect("a length of this shape");
    let rows = (READ_BYTES / (8 * sites)).clamp(1, times);
    let mut block = vec![0.0; rows * sites];
    observer.stage("reading", times as u64);
    for from in (0..times).step_by(rows) {
        let to = times.min(from + rows);
        let block = &mut block[..(to - from) * sites];
        field.read_time_major(from..to, 0..sites, block);
        let into = values.rows_mut().into_iter().skip(from);
        for (mut into, row) in into.zip(block.chunks_exact(sites)) {
            into.iter_mut().zip(row).for_each(|(to, from)| *to = *from);
        }
        field.release_pages();
        observer.advance((to - from) as u64);
        check(observer)?;
    }
    Ok(values)
}

fn check(observer: &dyn Observer) -> Result<()> {
    match observer.cancelled() {
        true => Err(Error::Cancelled),
        false => Ok(()),
    }
}

fn check_finite(field: &Field, values: ArrayView2<f64>) -> Result<()> {
    let n = field.n_sites();
    let bad = || values.iter().enumerate().filter(|(_, v)| !v.is_finite());
    let Some((first, _)) = bad().next() else {
        return Ok(());
    };
    let mut sites = vec![false; n];
    bad().for_each(|(at, _)| sites[at % n] = true);
    Err(Error::NonFinite {
        name: field.name.clone(),
        count: bad().count() as u64,
        first: (first / n, first % n),
        sites: sites.iter().filter(|bad| **bad).count(),
        n_sites: n,
    })
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
        let field = Field::from_array(Array2::zeros((4096, 512)));
        let plan = crate::transform::RealToComplexColumns::<f64>::new(4096).unwrap();
        let width = plan.width() as u64;
        // With a cache line for the alignment.
        let scratch = 2 * width * (64 + 33 * 66) * 8 + 64;
        let back = width * (4096 + 2 * 2049) * 8 + scratch;
        let arrays = 4096 * 512 * 24;
        for threads in [1, 3] {
            let expected = arrays + threads * ((2 << 20) + scratch + back);
            let with = |memory| {
                in_pool(Some(threads as usize), || {
                    filtered(
                        &field,
                        &Passband::default(),
                        false,
                        Some(memory),
                        &crate::observer::Silent,
                    )
                })
            };
            match with(expected - 1) {
                Err(Error::Memory { needed, .. }) => assert_eq!(needed, expected),
                other => panic!("{other:?}"),
            }
            assert!(with(expected).is_ok());
        }
    }
}
