//! Averages in parts: one process sums a range of the realisations, another one combines the sums.

mod combination;
mod memory;
mod outline;

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::realisations::{
    Grid, Part, Portion, Realisations, RecordTree, Shots, SumsShape, TreeNode, first_of,
    refuse_left_out,
};
use super::{Coherence, CoherenceRequest, SpectrumEstimate, SpectrumRequest};
use crate::error::Result;
use crate::field::Field;
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::system::threads::in_pool;

pub use combination::{Combination, combine, join};
pub(super) use memory::Finishing;
pub use outline::{Outline, outline};

/// An estimate whose sums over realisations are known in parts.
pub(super) trait Divided {
    type Found;

    fn gaps_and_memory(&self) -> (Gaps, Option<u64>);

    fn threads(&self) -> Option<usize>;

    /// # Errors
    /// [`crate::Error::Request`] for what does not fit the fields, and what cannot be summed in parts.
    fn plan(&self, grid: &Grid) -> Result<Realisations>;

    /// Blocks of the sums of the tiles of the result, in order: of so many tiles each.
    fn tiles(&self, grid: &Grid, realisations: &Realisations) -> Vec<(SumsShape, usize)>;

    /// What [`Self::combine`] holds.
    fn finishing(&self, known: (&Grid, &Realisations)) -> Finishing;

    /// Whether the energy of a record is that about its mean.
    fn about_mean(&self) -> bool;

    /// The nodes of every tile over these portions, and the unit of the samples.
    fn partial(
        &self,
        shots: &Shots<'_>,
        known: (&Grid, &Realisations),
        portions: &[Portion],
    ) -> Result<(f64, Vec<Vec<TreeNode>>)>;

    /// The result of the sums of all parts.
    fn combine(
        &self,
        known: (&Grid, &Realisations),
        records: usize,
        trees: Vec<RecordTree>,
        unit: f64,
    ) -> Result<Self::Found>;

    /// The result of a record of zeros, counted as steady, without the sums of all tiles.
    fn silent(&self, known: (&Grid, &Realisations)) -> Result<Self::Found>;
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

/// The same expression of the request of each estimate.
macro_rules! of_each {
    ($request:expr, $it:ident => $does:expr) => {
        match $request {
            DividedRequest::Spectrum($it) => $does,
            DividedRequest::Coherence($it) => $does,
        }
    };
}
use of_each;

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
    /// What the samples were divided by, a power of two.
    pub unit: f64,
}

impl PartialAbout {
    fn name(&self) -> String {
        match self.part {
            Some(part) => format!("part {part}"),
            None => format!(
                "segments {} to {}",
                self.range[0],
                self.range[1].saturating_sub(1)
            ),
        }
    }
}

/// Place of a node in the trees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NodePlace {
    /// The record whose segments are the leaves; `None` where records are.
    pub record: Option<usize>,
    pub level: u32,
    pub index: usize,
}

impl NodePlace {
    /// The segments of all records that it sums.
    fn range(self, segments: usize) -> Option<Range<usize>> {
        let leaves = 1_usize.checked_shl(self.level)?;
        let first = self.index.checked_mul(leaves)?;
        let end = first.checked_add(leaves)?;
        match self.record {
            Some(record) => {
                let before = record.checked_mul(segments)?;
                (end <= segments).then_some(before + first..before + end)
            }
            None => Some(first.checked_mul(segments)?..end.checked_mul(segments)?),
        }
    }
}

/// Sums over a part of the realisations.
#[derive(Debug, Clone, PartialEq)]
pub struct Partial {
    pub about: PartialAbout,
    pub(crate) nodes: Vec<NodePlace>,
    /// Of all tiles, node by node.
    pub(crate) sums: Vec<f64>,
}

impl Partial {
    /// Bytes of the sums.
    pub fn bytes(&self) -> usize {
        8 * self.sums.len()
    }
}

/// Sums over a part of the realisations of an estimate.
///
/// # Equation
/// The segments of a record are the leaves of a binary tree, and so are the records: the node `(l, i)` is the
/// sum over the leaves `i 2^l` to `(i + 1) 2^l - 1`, made of its two halves. A part holds the complete nodes of
/// its range, at most two of a level. Since a node has the same bits wherever it is made, the combined result
/// has those of the whole run, if no square of a sample leaves the range of numbers.
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
    let share = Share::Part(part);
    of_each!(request, it => partial_of(it, request, fields, &share, observer))
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
/// As [`partial`], whose bits its sums have. `field` holds the samples from `place.first` on. Blocks that hold
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
    let share = Share::Block(place);
    of_each!(request, it => partial_of(it, request, &[field], &share, observer))
}

/// Which realisations are summed.
enum Share {
    Part(Part),
    Block(BlockPlace),
}

fn partial_of<R: Divided + Sync>(
    request: &R,
    named: &DividedRequest,
    fields: &[&Field],
    share: &Share,
    observer: &dyn Observer,
) -> Result<Partial> {
    let first = first_of(fields)?;
    let mut grid = Grid::of(first);
    if let Share::Block(place) = share {
        grid.times = place.record;
    }
    let realisations = request.plan(&grid)?;
    let segments = realisations.segments.count();
    let (part, range, portions) = match share {
        Share::Part(part) => {
            let range = part.range(fields.len() * segments)?;
            (Some(*part), range.clone(), realisations.portions(range))
        }
        Share::Block(place) => {
            let samples = place.first..place.first.saturating_add(first.n_times());
            let portion = realisations.portion_of_block(samples)?;
            (None, portion.segments.clone(), vec![portion])
        }
    };
    let (gaps, memory) = request.gaps_and_memory();
    refuse_left_out(gaps, "a part of the segments")?;
    let (unit, tiles) = in_pool(request.threads(), || {
        let mut shots = Shots::new(fields, gaps, memory, realisations.reached(), observer)?;
        if let Share::Block(place) = share {
            shots = shots.of_block(place.first, place.record);
        }
        request.partial(
            &shots.in_portions(&portions),
            (&grid, &realisations),
            &portions,
        )
    })?;
    let about = PartialAbout {
        request: named.clone(),
        grid,
        fields: fields.iter().map(|field| field.name.clone()).collect(),
        part,
        range: [range.start, range.end],
        unit,
    };
    Ok(flattened(about, &tiles, segments))
}

/// A partial result of the nodes of all tiles.
fn flattened(about: PartialAbout, tiles: &[Vec<TreeNode>], segments: usize) -> Partial {
    let mut nodes = Vec::new();
    let all = tiles.iter().flatten();
    let mut sums = Vec::with_capacity(all.map(|node| node.sums.numbers().len()).sum());
    let places = tiles.first().into_iter().flatten().enumerate();
    let mut order: Vec<(usize, NodePlace)> = places
        .map(|(at, node)| {
            let (record, level, index) = (node.record, node.level, node.index);
            let place = NodePlace {
                record,
                level,
                index,
            };
            (at, place)
        })
        .collect();
    order.sort_by_key(|(_, place)| place.range(segments).map(|range| range.start));
    for (at, place) in order {
        nodes.push(place);
        for tile in tiles {
            sums.extend_from_slice(tile[at].sums.numbers());
        }
    }
    Partial { about, nodes, sums }
}
