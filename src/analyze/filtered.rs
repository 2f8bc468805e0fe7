//! A field filtered in frequency and wavenumber.

use ndarray::{Array2, s};

use crate::chain::available_memory;
use crate::error::{Error, Result};
use crate::field::Field;
use crate::transform::{Passband, SpaceTimeFilter};

/// A field that has passed a filter.
#[derive(Debug, Clone)]
pub struct Filtered {
    pub field: Field,
    /// `sum v^2` of the samples before and after.
    pub energy_before: f64,
    pub energy_after: f64,
}

/// What of a field passes a filter, and what is left of its energy.
///
/// `v` is multiplied by a gain of 1 or 0 in (k, f) ([`SpaceTimeFilter`]); with `pad`, the field is
/// first extended by as many zeros again along both axes, so that what leaves at one end does not
/// enter at the other.
///
/// # Errors
/// [`Error::Request`] for bands that end before they begin; [`Error::NonFinite`] for samples that are
/// not numbers; [`Error::Memory`] for a field whose transform does not fit.
pub fn filtered(
    field: &Field,
    band: &Passband,
    pad: bool,
    memory: Option<u64>,
) -> Result<Filtered> {
    band.check()?;
    let (times, sites) = (field.n_times(), field.n_sites());
    let twice = if pad { 2 } else { 1 };
    let shape = (twice * times, twice * sites);
    // Samples, half as many complex bins, and the result.
    let needed = (shape.0 as u64)
        .saturating_mul(shape.1 as u64)
        .saturating_mul(8 * 3 + 8);
    let allowed = memory.unwrap_or_else(available_memory);
    if needed > allowed {
        return Err(Error::Memory {
            what: "the transform of the field",
            needed,
            allowed,
        });
    }
    let mut row = vec![0.0; times * sites];
    field.read_time_major(0..times, 0..sites, &mut row);
    check_finite(field, &row)?;
    let mut values = Array2::zeros(shape);
    for (mut to, from) in values.rows_mut().into_iter().zip(row.chunks_exact(sites)) {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
    }
    let filter = SpaceTimeFilter::new(shape);
    let steps = (field.time.step, field.space.step);
    let passed = filter.apply(values.view(), steps, band)?;
    let passed = passed.slice(s![..times, ..sites]).to_owned();
    let energy = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
    let energy_before = energy(&mut row.iter().copied());
    let energy_after = energy(&mut passed.iter().copied());
    let mut found = Field::from_array(passed);
    found.time = field.time.clone();
    found.space = field.space.clone();
    found.quantity = field.quantity;
    found.unit = field.unit.clone();
    found.name = format!("{}, filtered", field.name);
    Ok(Filtered {
        field: found,
        energy_before,
        energy_after,
    })
}

fn check_finite(field: &Field, values: &[f64]) -> Result<()> {
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
