//! Parts to the result of all, or to one part.

use std::borrow::Borrow;
use std::fmt;
use std::ops::Range;

use serde_json::Value;

use super::memory::{Counted, Held, places};
use super::{Combined, Divided, DividedRequest, Partial, PartialAbout, flattened, of_each};
use crate::error::{Error, Result};
use crate::estimates::realisations::{Part, Realisations, RecordTree, SumsShape, TreeNode};
use crate::system::threads::in_pool;

/// The result of all parts, in any order: that of the whole run, bit for bit. `memory`: bytes that the parts and
/// the work may take; `None`: half of the free memory beside the parts. `threads`: worker threads; `None`: one a core.
///
/// # Errors
/// Those of [`Combination`]; [`Error::Threads`].
pub fn combine<P: Borrow<Partial> + Sync>(
    partials: &[P],
    memory: Option<u64>,
    threads: Option<usize>,
) -> Result<Combined> {
    in_pool(threads, || combined(partials, memory))
}

fn combined<P: Borrow<Partial>>(partials: &[P], memory: Option<u64>) -> Result<Combined> {
    let (mut combination, order) =
        Combination::over(named(partials), true, held(partials), memory)?;
    for at in order {
        combination.add(partials[at].borrow())?;
    }
    combination.finish()
}

/// One partial result of several whose segments follow one another, in any order: siblings in the trees become
/// their sums, so that it is smaller than all of them. `memory` as for [`combine`].
///
/// # Errors
/// Those of [`Combination`], but for segments that are missing before and behind.
pub fn join<P: Borrow<Partial>>(partials: &[P], memory: Option<u64>) -> Result<Partial> {
    let (mut combination, order) =
        Combination::over(named(partials), false, held(partials), memory)?;
    let from = combination.next;
    for at in order {
        combination.add(partials[at].borrow())?;
    }
    let segments = combination.realisations.segments.count();
    let trees = combination.trees.into_iter();
    let tiles: Vec<_> = trees.map(RecordTree::into_nodes).collect();
    let about = PartialAbout {
        part: None,
        range: [from, combination.next],
        unit: combination.unit.unwrap_or(1.0),
        ..combination.about
    };
    Ok(flattened(about, &tiles, segments))
}

fn named<P: Borrow<Partial>>(partials: &[P]) -> Vec<(String, PartialAbout)> {
    let about = partials.iter().map(|partial| &partial.borrow().about);
    about.map(|about| (about.name(), about.clone())).collect()
}

/// The bytes of all parts, which the caller has at hand.
fn held<P: Borrow<Partial>>(partials: &[P]) -> Held {
    let bytes = partials
        .iter()
        .map(|partial| partial.borrow().bytes() as u64);
    Held::All(bytes.sum())
}

/// Parts that are combined one after the other, so that one at a time is in memory.
pub struct Combination {
    /// Of the part that begins with each segment.
    names: Vec<(usize, String)>,
    about: PartialAbout,
    realisations: Realisations,
    /// Of so many tiles each.
    tiles: Vec<(SumsShape, usize)>,
    trees: Vec<RecordTree>,
    /// The unit of what is summed; `None` before a part that is not silent.
    unit: Option<f64>,
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
    /// Of parts with their names, and the order in which to [`add`](Self::add) them. `memory`: bytes that the
    /// work may take, one part at a time included; `None`: half of the free memory.
    ///
    /// # Errors
    /// [`Error::Request`] for parts of another request or of other fields, for missing parts, and for those
    /// that are there twice; [`Error::Memory`].
    pub fn new(
        parts: Vec<(String, PartialAbout)>,
        memory: Option<u64>,
    ) -> Result<(Combination, Vec<usize>)> {
        Self::over(parts, true, Held::OneByOne, memory)
    }

    /// Of all segments, or of some that follow one another.
    fn over(
        parts: Vec<(String, PartialAbout)>,
        is_all: bool,
        held: Held,
        memory: Option<u64>,
    ) -> Result<(Combination, Vec<usize>)> {
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
        let segments = realisations.segments.count();
        let Some(all) = about.fields.len().checked_mul(segments) else {
            return refuse(
                "fewer segments".into(),
                format!("{segments} of each record"),
            );
        };
        let start = if is_all { 0 } else { about.range[0] };
        let mut next = start;
        let mut before = "";
        for &at in &order {
            let (name, [from, end]) = (&parts[at].0, parts[at].1.range);
            if from >= end || end > all {
                let expected = format!("segments among the {all} of all records");
                return refuse(expected, format!("{from} to {end} in {name}"));
            }
            let unit = parts[at].1.unit;
            if !(unit > 0.0 && unit.is_finite()) {
                return refuse("a unit above 0".into(), format!("{unit} in {name}"));
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
        if is_all && next < all {
            return missing(&parts, next..all, all);
        }
        let known = (&about.grid, &realisations);
        let tiles = of_each!(&about.request, it => it.tiles(known.0, known.1));
        if tiles
            .iter()
            .all(|(shape, count)| shape.numbers() == 0 || *count == 0)
        {
            return refuse("a field with sites".into(), "none".into());
        }
        let counted = Counted::new(
            order.iter().map(|&at| parts[at].1.range),
            (&realisations, &tiles),
            held,
        );
        match is_all {
            true => {
                let finishing = of_each!(&about.request, it => it.finishing(known));
                counted.check("the result of these parts", finishing, memory)?;
            }
            false => counted.check_joined("one part of these", memory)?,
        }
        let mut trees = Vec::new();
        trees.resize_with(tiles.iter().map(|tiles| tiles.1).sum(), RecordTree::default);
        let combination = Combination {
            names: parts
                .into_iter()
                .map(|(name, about)| (about.range[0], name))
                .collect(),
            about,
            realisations,
            tiles,
            trees,
            unit: None,
            next: start,
        };
        Ok((combination, order))
    }

    /// Adds the part that follows.
    ///
    /// # Errors
    /// [`Error::Request`] for a part that does not follow, and sums that are not those of its request.
    pub fn add(&mut self, partial: &Partial) -> Result<()> {
        let width: usize = self.shapes().map(SumsShape::numbers).sum();
        let segments = self.realisations.segments.count();
        let [from, end] = partial.about.range;
        let (mut covered, mut nodes) = (from, 0);
        for node in &partial.nodes {
            match node.range(segments) {
                Some(range) if range.start == covered => covered = range.end,
                _ => break,
            }
            nodes += 1;
        }
        // In as few nodes as there can be: more of them would take more memory than was counted.
        let is_whole = covered == end
            && nodes == partial.nodes.len()
            && nodes == places(from..end, segments).len()
            && partial.sums.len() == width * partial.nodes.len();
        if from != self.next || !is_whole {
            let expected = format!(
                "the sums over segments {} and on, {width} a node",
                self.next
            );
            let name = self.names.iter().find(|(first, _)| *first == from);
            let found = format!(
                "{} nodes of segments {from} to {covered}, {} sums in {}",
                partial.nodes.len(),
                partial.sums.len(),
                name.map_or("a part", |(_, name)| name)
            );
            return refuse(expected, found);
        }
        let about_mean = of_each!(&self.about.request, it => it.about_mean());
        let factor = self.factor(partial);
        let shapes: Vec<SumsShape> = self.shapes().collect();
        for (place, numbers) in partial.nodes.iter().zip(partial.sums.chunks_exact(width)) {
            let mut numbers = numbers;
            for (tree, shape) in self.trees.iter_mut().zip(&shapes) {
                let (own, others) = numbers.split_at(shape.numbers());
                numbers = others;
                let mut sums = shape.zeros();
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

    /// Of each tile.
    fn shapes(&self) -> impl Iterator<Item = SumsShape> {
        let tiles = self.tiles.iter();
        tiles.flat_map(|(shape, count)| std::iter::repeat_n(*shape, *count))
    }

    /// Whether these are sums over zeros, whose unit says nothing.
    fn is_silent(&self, partial: &Partial) -> bool {
        let mut numbers = &partial.sums[..];
        partial.nodes.iter().all(|_| {
            self.shapes().all(|shape| {
                let (own, others) = numbers.split_at(shape.numbers());
                numbers = others;
                shape.are_silent(own)
            })
        })
    }

    /// What the samples of a part are multiplied by to be in the unit of what is summed: the largest of all units, so
    /// that nothing leaves the range of numbers but what is too small to count.
    fn factor(&mut self, partial: &Partial) -> f64 {
        let unit = partial.about.unit;
        match self.unit {
            Some(largest) if unit <= largest => unit / largest,
            _ if self.is_silent(partial) => 1.0,
            before => {
                self.unit = Some(unit);
                if let Some(before) = before {
                    let sums = self.trees.iter_mut().flat_map(RecordTree::sums_mut);
                    sums.for_each(|sums| sums.rescale(before / unit));
                }
                1.0
            }
        }
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
        let (trees, unit) = (self.trees, self.unit.unwrap_or(1.0));
        Ok(match &self.about.request {
            DividedRequest::Spectrum(it) => {
                Combined::Spectrum(Box::new(it.combine(known, records, trees, unit)?))
            }
            DividedRequest::Coherence(it) => {
                Combined::Coherence(Box::new(it.combine(known, records, trees, unit)?))
            }
        })
    }
}

/// The parts without which a range of segments is unknown.
fn missing<T>(parts: &[(String, PartialAbout)], range: Range<usize>, all: usize) -> Result<T> {
    let of_first = parts[0].1.part.map(|part| part.of);
    let mut others = parts.iter();
    let is_regular = others.all(|(_, about)| about.part.map(|part| part.of) == of_first);
    let of = of_first.filter(|of| is_regular && *of <= all);
    let of = of.unwrap_or(0);
    let lacks = |number: &usize| {
        let own = Part {
            number: *number,
            of,
        }
        .range(all);
        own.is_ok_and(|own| own.start < range.end && own.end > range.start)
    };
    let numbers: Vec<String> = (1..=of)
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
    if (&a.request, &a.grid, &a.fields) == (&b.request, &b.grid, &b.fields) {
        return None;
    }
    let json = |value: serde_json::Result<Value>| value.unwrap_or(Value::Null);
    // Blocks have coordinates of their own, which round.
    let is_near = |x: f64, y: f64, scale: f64| (x - y).abs() <= 1e-6 * scale.abs();
    let steps = [(&a.grid.time, &b.grid.time), (&a.grid.space, &b.grid.space)];
    let is_like = steps.iter().all(|(a, b)| is_near(a.step, b.step, a.step))
        && is_near(a.grid.space.origin, b.grid.space.origin, a.grid.space.step);
    let grid = |about: &PartialAbout| {
        let mut grid = about.grid.clone();
        grid.time.origin = a.grid.time.origin;
        if is_like {
            grid.time.step = a.grid.time.step;
            (grid.space.origin, grid.space.step) = (a.grid.space.origin, a.grid.space.step);
        }
        grid
    };
    let of = |about: &PartialAbout| {
        [
            json(serde_json::to_value(&about.request)),
            json(serde_json::to_value(grid(about))),
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
