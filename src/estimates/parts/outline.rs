//! What is known of the result of parts before any sample is read.

use super::{Combined, Divided, DividedRequest};
use crate::error::Result;
use crate::estimates::realisations::{Grid, RecordTree};
use crate::field::Field;
use crate::transform::Segments;

/// The segments of a record, and a result whose axes, units and kinds of arrays are those of any other one.
#[derive(Debug, Clone)]
pub struct Outline {
    pub segments: Segments,
    /// Of a record of zeros, counted as steady.
    pub result: Combined,
}

/// The outline of an estimate of one record of `times` samples, at the sites and of the steps of `field`, whose
/// samples are not read.
///
/// # Errors
/// Those of [`super::partial`] for what does not fit the record.
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
        DividedRequest::SpaceTime(it) => {
            let (segments, found) = silent(it, &grid)?;
            (segments, Combined::SpaceTime(Box::new(found)))
        }
        DividedRequest::Bicoherence(it) => {
            let (segments, found) = silent(it, &grid)?;
            (segments, Combined::Bicoherence(Box::new(found)))
        }
    };
    Ok(Outline { segments, result })
}

fn silent<R: Divided>(request: &R, grid: &Grid) -> Result<(Segments, R::Found)> {
    let realisations = request.plan(grid)?;
    let zeros = request.zeros(grid, &realisations).into_iter();
    let trees = zeros.map(|sums| RecordTree::of_total(sums.of_silence(1)));
    let found = request.combine((grid, &realisations), 1, trees.collect(), 1.0)?;
    Ok((realisations.segments, found))
}
