//! Averages in parts: one process sums a range of the realisations, another one combines the sums.

use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::realisations::{
    Grid, Part, Portion, Realisations, RecordTree, Shots, Sums, TreeNode, first_of, refuse_left_out,
};
use super::{
    Coherence, CoherenceRequest, SpaceTimeEstimate, SpaceTimeRequest, SpectrumEstimate,
    SpectrumRequest,
};
use crate::error::{Error, Result};
use crate::field::Field;
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::system::threads::in_pool;

/// An estimate whose sums over realisations are known in parts.
pub(super) trait Divided {
    type Found;

    fn gaps_and_memory(&self) -> (Gaps, Option<u64>);

    fn threads(&self) -> Option<usize>;

    /// # Errors
    /// [`Error::Request`] for what does not fit the fields, and what cannot be summed in parts.
    fn plan(&self, grid: &Grid) -> Result<Realisations>;

    /// The sums of every tile of the result, all zero.
    fn zeros(&self, grid: &Grid, realisations: &Realisations) -> Vec<Sums>;

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
}

/// The request of an estimate that [`partial`] knows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DividedRequest {
    Spectrum(SpectrumRequest),
    Coherence(CoherenceRequest),
    SpaceTime(SpaceTimeRequest),
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

impl From<SpaceTimeRequest> for DividedRequest {
    fn from(request: SpaceTimeRequest) -> Self {
        DividedRequest::SpaceTime(request)
    }
}

/// What [`combine`] makes of all parts.
#[derive(Debug, Clone)]
pub enum Combined {
    Spectrum(Box<SpectrumEstimate>),
    Coherence(Box<Coherence>),
    SpaceTime(Box<SpaceTimeEstimate>),
}

/// The same expression of the request of each estimate.
macro_rules! of_each {
    ($request:expr, $it:ident => $does:expr) => {
        match $request {
            DividedRequest::Spectrum($it) => $does,
            DividedRequest::Coherence($it) => $does,
            DividedRequest::SpaceTime($it) => $does,
        }
    };
}

/// What a partial result is part of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartialAbout {
    pub request: DividedRequest,
    pub grid: Grid,
    /// Names of the fields, one a record.
    pub fields: Vec<String>,
    pub part: Part,
    /// The segments of all records that are summed: from the first to before the second, segment `s` of
    /// record `r` counted as `r` times the segments of a record, plus `s`.
    pub range: [usize; 2],
    /// What the samples were divided by, a power of two.
    pub unit: f64,
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
/// Those of the estimate; [`Error::Request`] for spectra along space and for a jackknife (which needs each
/// realisation beside the mean of all), for more parts than segments, and for gaps that would be interpolated
/// beyond the part's own samples.
pub fn partial(
    fields: &[&Field],
    request: &DividedRequest,
    part: Part,
    observer: &dyn Observer,
) -> Result<Partial> {
    of_each!(request, it => partial_of(it, request, fields, part, observer))
}

fn partial_of<R: Divided + Sync>(
    request: &R,
    named: &DividedRequest,
    fields: &[&Field],
    part: Part,
    observer: &dyn Observer,
) -> Result<Partial> {
    let grid = Grid::of(first_of(fields)?);
    let realisations = request.plan(&grid)?;
    let segments = realisations.segments.count();
    let range = part.range(fields.len() * segments)?;
    let portions = realisations.portions(range.clone());
    let (gaps, memory) = request.gaps_and_memory();
    refuse_left_out(gaps, "a part of the segments")?;
    let (unit, tiles) = in_pool(request.threads(), || {
        let shots = Shots::new(fields, gaps, memory, realisations.reached(), observer)?;
        request.partial(
            &shots.in_portions(&portions),
            (&grid, &realisations),
            &portions,
        )
    })?;
    let mut nodes = Vec::new();
    let mut sums = Vec::new();
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
        for tile in &tiles {
            sums.extend_from_slice(tile[at].sums.numbers());
        }
    }
    Ok(Partial {
        about: PartialAbout {
            request: named.clone(),
            grid,
            fields: fields.iter().map(|field| field.name.clone()).collect(),
            part,
            range: [range.start, range.end],
            unit,
        },
        nodes,
        sums,
    })
}

/// The result of all parts, in any order: that of the whole run, bit for bit.
///
/// # Errors
/// Those of [`Combination`].
pub fn combine(partials: &[Partial]) -> Result<Combined> {
    let named = |partial: &Partial| {
        (
            format!("part {}", partial.about.part),
            partial.about.clone(),
        )
    };
    let (mut combination, order) = Combination::new(partials.iter().map(named).collect())?;
    for at in order {
        combination.add(&partials[at])?;
    }
    combination.finish()
}

/// Parts that are combined one after the other, so that one at a time is in memory.
pub struct Combination {
    names: Vec<String>,
    about: PartialAbout,
    realisations: Realisations,
    zeros: Vec<Sums>,
    trees: Vec<RecordTree>,
    /// The next segment of all records.
    next: usize,
}

impl fmt::Debug for Combination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Combination")
            .field("about", &self.about)
            .field("next", &self.next)
            .finish_non_exhaustive()
    }
}

fn refuse<T>(expected: String, found: String) -> Result<T> {
    Err(Error::Request {
        option: "merge",
        expected,
        found,
    })
}

impl Combination {
    /// Of parts with their names, and the order in which to [`add`](Self::add) them.
    ///
    /// # Errors
    /// [`Error::Request`] for parts of another request or of other fields, for missing parts, and for those
    /// that are there twice.
    pub fn new(parts: Vec<(String, PartialAbout)>) -> Result<(Combination, Vec<usize>)> {
        let mut order: Vec<usize> = (0..parts.len()).collect();
        order.sort_by_key(|&at| parts[at].1.range);
        let Some(&first) = order.first() else {
            return refuse("at least one part".into(), "none".into());
        };
        let about = parts[first].1.clone();
        for (name, other) in &parts {
            if let Some(difference) = difference(&about, other) {
                let expected = format!("parts of one result, as {}", parts[first].0);
                return refuse(expected, format!("{difference} in {name}"));
            }
        }
        let realisations = of_each!(&about.request, it => it.plan(&about.grid))?;
        let all = about.fields.len() * realisations.segments.count();
        let mut next = 0;
        let mut before = "";
        for &at in &order {
            let (name, [from, end]) = (&parts[at].0, parts[at].1.range);
            if from >= end || end > all {
                let expected = format!("segments among the {all} of all records");
                return refuse(expected, format!("{from} to {end} in {name}"));
            }
            if from < next {
                let found = format!(
                    "segments {from} to {} in {before} and {name}",
                    next.min(end) - 1
                );
                return refuse("each part once".into(), found);
            }
            if from > next {
                return missing(&parts, next..from, all);
            }
            (next, before) = (end, name);
        }
        if next < all {
            return missing(&parts, next..all, all);
        }
        let zeros = of_each!(&about.request, it => it.zeros(&about.grid, &realisations));
        let mut trees = Vec::new();
        trees.resize_with(zeros.len(), RecordTree::default);
        let combination = Combination {
            names: parts.into_iter().map(|(name, _)| name).collect(),
            about,
            realisations,
            zeros,
            trees,
            next: 0,
        };
        Ok((combination, order))
    }

    /// Adds the part that follows.
    ///
    /// # Errors
    /// [`Error::Request`] for a part that does not follow, and sums that are not those of its request.
    pub fn add(&mut self, partial: &Partial) -> Result<()> {
        let width: usize = self.zeros.iter().map(|sums| sums.numbers().len()).sum();
        let segments = self.realisations.segments.count();
        let [from, end] = partial.about.range;
        let mut covered = from;
        for node in &partial.nodes {
            match node.range(segments) {
                Some(range) if range.start == covered => covered = range.end,
                _ => break,
            }
        }
        let is_whole = covered == end && partial.sums.len() == width * partial.nodes.len();
        if from != self.next || !is_whole {
            let expected = format!(
                "the sums over segments {} and on, {width} a node",
                self.next
            );
            let name = self
                .names
                .iter()
                .find(|name| name.contains(&partial.about.part.to_string()));
            let found = format!(
                "{} nodes of segments {from} to {covered}, {} sums in {}",
                partial.nodes.len(),
                partial.sums.len(),
                name.map_or("a part", |name| name)
            );
            return refuse(expected, found);
        }
        let about_mean = of_each!(&self.about.request, it => it.about_mean());
        let factor = partial.about.unit / self.about.unit;
        for (place, numbers) in partial.nodes.iter().zip(partial.sums.chunks_exact(width)) {
            let mut numbers = numbers;
            for (tree, zeros) in self.trees.iter_mut().zip(&self.zeros) {
                let (own, others) = numbers.split_at(zeros.numbers().len());
                numbers = others;
                let mut sums = zeros.clone();
                sums.set(own);
                if factor != 1.0 {
                    sums.rescale(factor);
                }
                let node = TreeNode {
                    record: place.record,
                    level: place.level,
                    index: place.index,
                    sums,
                };
                tree.push(node, segments, about_mean);
            }
        }
        self.next = end;
        Ok(())
    }

    /// The result.
    ///
    /// # Errors
    /// [`Error::Request`] before all parts are added.
    pub fn finish(self) -> Result<Combined> {
        let records = self.about.fields.len();
        let all = records * self.realisations.segments.count();
        if self.next != all {
            let found = format!("those of {} of {all} segments", self.next);
            return refuse("all parts".into(), found);
        }
        let known = (&self.about.grid, &self.realisations);
        let (trees, unit) = (self.trees, self.about.unit);
        Ok(match &self.about.request {
            DividedRequest::Spectrum(it) => {
                Combined::Spectrum(Box::new(it.combine(known, records, trees, unit)?))
            }
            DividedRequest::Coherence(it) => {
                Combined::Coherence(Box::new(it.combine(known, records, trees, unit)?))
            }
            DividedRequest::SpaceTime(it) => {
                Combined::SpaceTime(Box::new(it.combine(known, records, trees, unit)?))
            }
        })
    }
}

/// The parts without which a range of segments is unknown.
fn missing<T>(parts: &[(String, PartialAbout)], range: Range<usize>, all: usize) -> Result<T> {
    let of = parts[0].1.part.of;
    let is_regular = parts.iter().all(|(_, about)| about.part.of == of);
    let lacks = |number: &usize| {
        let own = Part {
            number: *number,
            of,
        }
        .range(all);
        own.is_ok_and(|own| own.start < range.end && own.end > range.start)
    };
    let numbers: Vec<String> = (1..=of)
        .filter(|_| is_regular)
        .filter(lacks)
        .take(8)
        .map(|number| format!("{number}/{of}"))
        .collect();
    let found = match numbers.is_empty() {
        true => format!("no segments {} to {}", range.start, range.end - 1),
        false => format!("no part {}", numbers.join(", ")),
    };
    refuse("all parts of one result".into(), found)
}

/// What differs between the results that two parts belong to.
fn difference(a: &PartialAbout, b: &PartialAbout) -> Option<String> {
    let json = |value: serde_json::Result<Value>| value.unwrap_or(Value::Null);
    let of = |about: &PartialAbout| {
        [
            json(serde_json::to_value(&about.request)),
            json(serde_json::to_value(&about.grid)),
            json(serde_json::to_value(&about.fields)),
        ]
    };
    let names = ["", "", "fields"];
    let pairs = of(a).into_iter().zip(of(b)).zip(names);
    pairs
        .filter_map(|((a, b), name)| differing(name, &a, &b))
        .next()
}

/// The first key whose values differ, with the second of them.
fn differing(key: &str, a: &Value, b: &Value) -> Option<String> {
    if a == b {
        return None;
    }
    if let (Value::Object(a), Value::Object(b)) = (a, b) {
        let keys = a.keys().chain(b.keys());
        return keys
            .filter_map(|key| {
                let of = |map: &serde_json::Map<String, Value>| {
                    map.get(key).cloned().unwrap_or(Value::Null)
                };
                differing(key, &of(a), &of(b))
            })
            .next();
    }
    Some(format!("{key} {b} in place of {a}"))
}
