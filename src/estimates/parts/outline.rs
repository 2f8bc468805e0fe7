//! What is known of the result of parts before any sample is read.

use super::memory::allow;
use super::{Combined, Divided, DividedRequest};
use crate::error::Result;
use crate::estimates::realisations::Grid;
use crate::field::Field;
use crate::system::memory::half_of_free_memory;
use crate::transform::Segments;

/// The segments of a record, and a result whose axes, units and kinds of arrays are those of any other one.
#[derive(Debug, Clone)]
pub struct Outline {
    pub segments: Segments,
    /// Of a record of zeros, counted as steady.
    pub result: Combined,
}

/// The outline of an estimate of one record of `times` samples, at the sites and of the steps of `field`, whose
/// samples are not read. It takes as much memory as the result, whatever the sums would take.
///
/// # Errors
/// Those of [`super::partial`] for what does not fit the record; [`crate::Error::Memory`] for a result that exceeds
/// the memory of the request.
pub fn outline(field: &Field, times: usize, request: &DividedRequest) -> Result<Outline> {
    let grid = Grid {
        times,
        ..Grid::of(field)
    };
    let (segments, result) = match request {
        DividedRequest::Spectrum(it) => {
            let (segments, found) = silent(it, &grid)?;
            (segments, Combined::Spectrum(Box::new(found)))
        }
        DividedRequest::Coherence(it) => {
            let (segments, found) = silent(it, &grid)?;
            (segments, Combined::Coherence(Box::new(found)))
        }
    };
    Ok(Outline { segments, result })
}

fn silent<R: Divided>(request: &R, grid: &Grid) -> Result<(Segments, R::Found)> {
    let realisations = request.plan(grid)?;
    let known = (grid, &realisations);
    let (_, memory) = request.gaps_and_memory();
    let needed = realisations
        .bytes()
        .saturating_add(request.finishing(known).result);
    let allowed = memory.unwrap_or_else(half_of_free_memory);
    allow("the outline of this result", needed, allowed)?;
    let found = request.silent(known)?;
    Ok((realisations.segments, found))
}
