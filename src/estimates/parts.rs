//! Averages in parts: one process sums a range of the realisations, another one combines the sums.

mod combination;

use serde::{Deserialize, Serialize};

use super::realisations::{
    Grid, Part, Portion, Realisations, Shots, Sums, SumsShape, first_of, refuse_left_out,
};
use super::{Coherence, CoherenceRequest, SpectrumEstimate, SpectrumRequest, spectrum};
use crate::error::Result;
use crate::field::Field;
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::system::threads::in_pool;

pub use combination::{Combination, Outline, combine, join, outline};

/// An estimate of the fields on a grid, whose sums over realisations are known in parts.
pub(super) trait Divided {
    /// Of the sums of a tile.
    fn shape(&self) -> SumsShape;

    /// Bytes of the result, and of what is made on the way from the sums to it.
    fn result_bytes(&self) -> u64;

    /// The sums of every tile over these portions.
    fn sums(&self, shots: &Shots<'_>, portions: &[Portion]) -> Result<Vec<Sums>>;

    /// The result of the sums of all parts.
    fn combine(&self, sums: Vec<Sums>) -> Result<Combined>;
}

/// The request of an estimate that [`partial`] knows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DividedRequest {
    Spectrum(SpectrumRequest),
    Coherence(CoherenceRequest),
}

impl From<SpectrumRequest> for DividedRequest {
    fn from(request: SpectrumRequest) -> Self {
        DividedRequest::Spectrum(request)
    }
}

impl From<CoherenceRequest> for DividedRequest {
    fn from(request: CoherenceRequest) -> Self {
        DividedRequest::Coherence(request)
    }
}

/// What [`combine`] makes of all parts.
#[derive(Debug, Clone)]
pub enum Combined {
    Spectrum(Box<SpectrumEstimate>),
    Coherence(Box<Coherence>),
}

impl DividedRequest {
    /// Gaps, bytes of working memory, worker threads.
    fn choices(&self) -> (Gaps, Option<u64>, Option<usize>) {
        match self {
            DividedRequest::Spectrum(it) => (it.gaps, it.memory, it.threads),
            DividedRequest::Coherence(it) => (it.gaps, it.memory, it.threads),
        }
    }

    /// # Errors
    /// [`crate::Error::Request`] for what does not fit the fields, and what cannot be summed in parts.
    fn plan(&self, grid: &Grid) -> Result<Realisations> {
        match self {
            DividedRequest::Spectrum(it) => it.plan_in_parts(grid),
            DividedRequest::Coherence(it) => it.plan(grid),
        }
    }

    fn pass<'a>(
        &'a self,
        realisations: &'a Realisations,
        grid: &'a Grid,
        records: usize,
    ) -> Box<dyn Divided + 'a> {
        match self {
            DividedRequest::Spectrum(it) => {
                Box::new(spectrum::Pass::new(it, realisations, grid, records))
            }
            DividedRequest::Coherence(it) => Box::new(it.pass(realisations, grid, records)),
        }
    }
}

/// What a partial result is part of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartialAbout {
    pub request: DividedRequest,
    pub grid: Grid,
    /// Names of the fields, one a record.
    pub fields: Vec<String>,
    /// `None` where it is one of no certain number: a block, or parts that were joined.
    pub part: Option<Part>,
    /// The segments of all records that are summed: from the first to before the second, segment `s` of
    /// record `r` counted as `r` times the segments of a record, plus `s`.
    pub range: [usize; 2],
}

impl PartialAbout {
    fn name(&self) -> String {
        let [from, end] = self.range;
        match self.part {
            Some(part) => format!("part {part}"),
            None => format!("segments {from} to {}", end.saturating_sub(1)),
        }
    }
}

/// Sums over a part of the realisations.
#[derive(Debug, Clone, PartialEq)]
pub struct Partial {
    pub about: PartialAbout,
    /// The state of all tiles.
    pub sums: Vec<f64>,
}

impl Partial {
    /// Bytes of the sums.
    pub fn bytes(&self) -> usize {
        8 * self.sums.len()
    }

    fn new(about: PartialAbout, tiles: Vec<Sums>) -> Partial {
        let mut sums = Vec::new();
        let count = tiles.len();
        for (i, mut tile) in tiles.into_iter().enumerate() {
            tile.write(&mut sums);
            // All are as long as the first.
            if i == 0 {
                sums.reserve_exact((count - 1) * sums.len());
            }
        }
        Partial { about, sums }
    }
}

/// Sums over a part of the realisations of an estimate.
///
/// # Equation
/// The state of the averages: plain sums over the segments of the range in their order, and how the energy of each record is spread. States
/// of parts are added in their order, so the combined result differs from that of the whole run by rounding alone: by less than
/// `2.3e-16` times the number of segments, relative to the sums of squares.
///
/// # Shapes
/// Part `i` of `n` sums segments `(i - 1) N / n` to `i N / n - 1` of the `N` segments of all records, and reads
/// only their samples; the last part of a record reads those behind its last segment, too.
///
/// # Errors
/// Those of the estimate; [`crate::Error::Request`] for spectra along space and for a jackknife (which needs each
/// realisation beside the mean of all), for more parts than segments, and for gaps that would be interpolated
/// beyond the part's own samples.
pub fn partial(
    fields: &[&Field],
    request: &DividedRequest,
    part: Part,
    observer: &dyn Observer,
) -> Result<Partial> {
    let grid = Grid::of(first_of(fields)?);
    let portions = |all: &Realisations| {
        let segments = fields.len() * all.segments.count();
        Ok(all.portions(part.range(segments)?))
    };
    partial_of(fields, request, grid, (Some(part), 0), portions, observer)
}

/// The place of a block of samples in its record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockPlace {
    /// Index in the record of the block's first sample.
    pub first: usize,
    /// Samples of the record.
    pub record: usize,
}

/// Sums over the segments that lie in a block of a record, of which nothing else is at hand.
///
/// As [`partial`]. `field` holds the samples from `place.first` on. Blocks that hold
/// every segment once overlap by what two segments share: the next one begins where the first segment begins
/// that is not in this one. Samples behind the last segment may be left out.
///
/// # Errors
/// Those of [`partial`]; [`crate::Error::Request`] for a block that is not in the record, or that no segment lies
/// in.
pub fn partial_of_block(
    field: &Field,
    place: BlockPlace,
    request: &DividedRequest,
    observer: &dyn Observer,
) -> Result<Partial> {
    let grid = Grid {
        times: place.record,
        ..Grid::of(first_of(&[field])?)
    };
    let samples = place.first..place.first.saturating_add(field.n_times());
    let portions = |all: &Realisations| Ok(vec![all.portion_of_block(samples)?]);
    let about = (None, place.first);
    partial_of(&[field], request, grid, about, portions, observer)
}

/// Of a part, if it is one of a certain number; fields begin with this sample of their records.
fn partial_of(
    fields: &[&Field],
    request: &DividedRequest,
    grid: Grid,
    (part, first): (Option<Part>, usize),
    portions: impl FnOnce(&Realisations) -> Result<Vec<Portion>>,
    observer: &dyn Observer,
) -> Result<Partial> {
    let (gaps, memory, threads) = request.choices();
    let realisations = request.plan(&grid)?;
    let portions = &portions(&realisations)?[..];
    refuse_left_out(gaps, "a part of the segments")?;
    let tiles = in_pool(threads, || {
        let shots = Shots::new(fields, gaps, memory, realisations.reached(), observer)?;
        let shots = shots.in_portions(portions, first, grid.times);
        let pass = request.pass(&realisations, &grid, fields.len());
        pass.sums(&shots, portions)
    })?;
    let (from, to) = (&portions[0], &portions[portions.len() - 1]);
    let [first, last] = [from, to].map(|portion| portion.record * realisations.segments.count());
    let range = [first + from.segments.start, last + to.segments.end];
    let about = PartialAbout {
        request: request.clone(),
        fields: fields.iter().map(|field| field.name.clone()).collect(),
        grid,
        part,
        range,
    };
    Ok(Partial::new(about, tiles))
}
