//! Parts to the result of all, or to one part.

use std::borrow::Borrow;
use std::collections::BTreeSet;

use serde_json::Value;

use super::{Combined, DividedRequest, Partial, PartialAbout};
use crate::error::{Error, Result};
use crate::estimates::realisations::{Grid, Part, Realisations, Sums, SumsShape};
use crate::field::Field;
use crate::system::check_memory;
use crate::system::memory::half_of_free_memory;
use crate::system::threads::in_pool;
use crate::transform::Segments;

/// The result of all parts, in any order: that of the whole run but for rounding. `memory`: bytes that the parts and
/// the work may take; `None`: half of the free memory beside the parts. `threads`: worker threads; `None`: one a core.
///
/// # Errors
/// Those of [`Combination`]; [`Error::Failed`].
pub fn combine<P: Borrow<Partial> + Sync>(
    partials: &[P],
    memory: Option<u64>,
    threads: Option<usize>,
) -> Result<Combined> {
    in_pool(threads, || merged(partials, true, memory)?.finish())
}

/// One partial result of several whose segments follow one another, in any order, as large as one of them. `memory`
/// as for [`combine`].
///
/// # Errors
/// Those of [`Combination`], but for segments that are missing before and behind.
pub fn join<P: Borrow<Partial>>(partials: &[P], memory: Option<u64>) -> Result<Partial> {
    let all = merged(partials, false, memory)?;
    Ok(Partial::new(all.about, all.sums))
}

fn merged<P: Borrow<Partial>>(
    partials: &[P],
    is_all: bool,
    memory: Option<u64>,
) -> Result<Combination> {
    let about = partials.iter().map(|partial| &partial.borrow().about);
    let named = about.map(|about| (about.name(), about.clone())).collect();
    let bytes = partials.iter();
    let bytes = bytes.map(|partial| partial.borrow().bytes() as u64);
    let (mut combination, order) = Combination::over(named, is_all, bytes.sum(), memory)?;
    for at in order {
        combination.add(partials[at].borrow())?;
    }
    Ok(combination)
}

/// Parts that are combined one after the other, so that one at a time is in memory.
#[derive(Debug)]
pub struct Combination {
    /// Of what is summed already.
    about: PartialAbout,
    realisations: Realisations,
    shape: SumsShape,
    /// Of each tile.
    sums: Vec<Sums>,
}

fn require(is_so: bool, expected: impl Into<String>, found: impl ToString) -> Result<()> {
    Error::require(is_so, "merge", expected, found)
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
        Self::over(parts, true, 0, memory)
    }

    /// Of all segments, or of some that follow one another; of parts of which so many bytes are in memory.
    fn over(
        parts: Vec<(String, PartialAbout)>,
        is_all: bool,
        held: u64,
        memory: Option<u64>,
    ) -> Result<(Combination, Vec<usize>)> {
        let mut order: Vec<usize> = (0..parts.len()).collect();
        order.sort_by_key(|&at| parts[at].1.range);
        require(!parts.is_empty(), "at least one part", "none")?;
        let (first, about) = parts[order[0]].clone();
        for (name, other) in &parts {
            if let Some(difference) = difference(&about, other) {
                let expected = format!("parts of one result, as {first}");
                require(false, expected, format!("{difference} in {name}"))?;
            }
        }
        let realisations = about.request.plan(&about.grid)?;
        let (request, records) = (&about.request, about.fields.len());
        let pass = request.pass(&realisations, &about.grid, records);
        let shape = pass.shape();
        let segments = realisations.segments.count();
        let all = records.saturating_mul(segments);
        let start = if is_all { 0 } else { about.range[0] };
        let mut next = start;
        let mut before = "";
        for &at in &order {
            let (name, PartialAbout { range, .. }) = &parts[at];
            let [from, end] = *range;
            let is_one = from < end && end <= all;
            let expected = format!("segments among the {all} of all records");
            require(is_one, expected, format!("{from} to {end} in {name}"))?;
            let last = next.min(end).saturating_sub(1);
            let found = format!("segments {from} to {last} in {before} and {name}");
            require(from >= next, "each part once", found)?;
            none_missing(&parts, [next, from], all)?;
            (next, before) = (end, name);
        }
        let end = if is_all { all } else { next };
        none_missing(&parts, [next, end], all)?;
        let state = shape.bytes().saturating_mul(about.grid.tiles() as u64);
        require(state > 0, "a field with sites", "none")?;
        let result = match is_all {
            true => pass.result_bytes(),
            // The part that is made of the sums.
            false => state,
        };
        let of_parts = if held > 0 { held } else { state };
        // A tile is put together beside the others.
        let needed = [state, of_parts, result, shape.bytes(), realisations.bytes()];
        let needed = needed.into_iter().fold(0, u64::saturating_add);
        // What the caller holds is no longer free.
        let allowed = memory.unwrap_or_else(|| half_of_free_memory().saturating_add(held));
        check_memory("the result of these parts", needed, Some(allowed))?;
        drop(pass);
        let combination = Combination {
            realisations,
            shape,
            sums: vec![Sums::zeros(shape); about.grid.tiles()],
            about: PartialAbout {
                part: None,
                range: [start, start],
                ..about
            },
        };
        Ok((combination, order))
    }

    /// Adds the part that follows.
    ///
    /// # Errors
    /// [`Error::Request`] for a part that does not follow, and sums that are not those of its request.
    pub fn add(&mut self, partial: &Partial) -> Result<()> {
        let [from, end] = partial.about.range;
        let [_, next] = self.about.range;
        let (range, name) = (from..end, partial.about.name());
        let width = self.shape.numbers(&range);
        let count = width * self.sums.len();
        let is_next = from == next && partial.sums.len() == count;
        let expected = format!("{count} sums from segment {next} on");
        let found = format!("{} from {from} on in {name}", partial.sums.len());
        require(is_next, expected, found)?;
        let tiles = partial.sums.chunks_exact(width);
        for (sums, numbers) in self.sums.iter_mut().zip(tiles) {
            sums.merge(Sums::read(self.shape, &range, numbers));
        }
        self.about.range[1] = end;
        Ok(())
    }

    /// The result.
    ///
    /// # Errors
    /// [`Error::Request`] before all parts are added.
    pub fn finish(self) -> Result<Combined> {
        let (records, [_, next]) = (self.about.fields.len(), self.about.range);
        let all = records * self.realisations.segments.count();
        let found = format!("those of {next} of {all} segments");
        require(next == all, "all parts", found)?;
        let (request, grid) = (&self.about.request, &self.about.grid);
        let pass = request.pass(&self.realisations, grid, records);
        pass.combine(self.sums)
    }
}

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
/// Those of [`super::partial`] for what does not fit the record; [`Error::Memory`] for a result that exceeds
/// the memory of the request.
pub fn outline(field: &Field, times: usize, request: &DividedRequest) -> Result<Outline> {
    let grid = Grid {
        times,
        ..Grid::of(field)
    };
    let realisations = request.plan(&grid)?;
    let pass = request.pass(&realisations, &grid, 1);
    let state = pass.shape().bytes().saturating_mul(grid.tiles() as u64);
    let needed = [pass.result_bytes(), realisations.bytes()];
    let needed = needed.into_iter().fold(state, u64::saturating_add);
    check_memory("the outline of this result", needed, request.choices().1)?;
    let sums = vec![Sums::of_silence(pass.shape()); grid.tiles()];
    let result = pass.combine(sums)?;
    Ok(Outline {
        segments: realisations.segments,
        result,
    })
}

/// That a range of segments is empty, else the parts without which it is unknown.
fn none_missing(
    parts: &[(String, PartialAbout)],
    [from, end]: [usize; 2],
    all: usize,
) -> Result<()> {
    if from == end {
        return Ok(());
    }
    let of = parts[0].1.part.map_or(0, |part| part.of);
    let number = |part: Part| (part.of == of && of <= all).then_some(part.number);
    let numbers = parts.iter().map(|(_, about)| about.part.and_then(number));
    let numbers: Option<BTreeSet<usize>> = numbers.collect();
    let found = match numbers {
        Some(numbers) => {
            let lacking = (1..=of).filter(|number| !numbers.contains(number)).take(8);
            let lacking: Vec<String> = lacking.map(|number| format!("{number}/{of}")).collect();
            format!("no part {}", lacking.join(", "))
        }
        None => format!("no segments {from} to {}", end - 1),
    };
    require(false, "all parts of one result", found)
}

/// What differs between the results that two parts belong to.
fn difference(a: &PartialAbout, b: &PartialAbout) -> Option<String> {
    let mut other = PartialAbout {
        part: a.part,
        range: a.range,
        ..b.clone()
    };
    // Blocks have coordinates of their own, which round.
    let is_near = |x: f64, y: f64, scale: f64| (x - y).abs() <= 1e-6 * scale.abs();
    let (own, grid) = (&a.grid, &mut other.grid);
    grid.time.origin = own.time.origin;
    if is_near(own.time.step, grid.time.step, own.time.step)
        && is_near(own.space.step, grid.space.step, own.space.step)
        && is_near(own.space.origin, grid.space.origin, own.space.step)
    {
        grid.time.step = own.time.step;
        (grid.space.origin, grid.space.step) = (own.space.origin, own.space.step);
    }
    let json = |about: &PartialAbout| serde_json::to_value(about).unwrap_or(Value::Null);
    differing("", &json(a), &json(&other))
}

/// The first key whose values differ, with the second of them.
fn differing(key: &str, a: &Value, b: &Value) -> Option<String> {
    if a == b {
        return None;
    }
    if let (Value::Object(of_a), Value::Object(of_b)) = (a, b) {
        // `null` of a key that is not there.
        let mut keys = of_a.keys().chain(of_b.keys());
        return keys.find_map(|key| differing(key, &a[key.as_str()], &b[key.as_str()]));
    }
    Some(format!("{key} {b} in place of {a}"))
}
