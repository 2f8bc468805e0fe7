//! Parts to the result of all, or to one part.

use std::borrow::Borrow;
use std::collections::BTreeSet;
use std::fmt;

use serde_json::Value;

use super::{Combined, DividedRequest, Partial, PartialAbout, begun};
use crate::error::{Error, Result};
use crate::estimates::realisations::{Grid, Realisations, Sums, SumsShape};
use crate::field::Field;
use crate::system::check_memory;
use crate::system::memory::half_of_free_memory;
use crate::system::threads::in_pool;
use crate::transform::Segments;

/// The result of all parts, in any order: that of the whole run but for rounding. `memory`: bytes that the parts and
/// the work may take; `None`: half of the free memory beside the parts. `threads`: worker threads; `None`: one a core.
///
/// # Errors
/// Those of [`Combination`]; [`Error::Threads`].
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
    let about = PartialAbout {
        part: None,
        range: [all.first, all.next],
        unit: all.unit.unwrap_or(1.0),
        ..all.about
    };
    let segments = all.realisations.segments.count();
    Ok(Partial::new(about, all.sums, segments))
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
pub struct Combination {
    /// Of the part that begins with each segment.
    names: Vec<(usize, String)>,
    about: PartialAbout,
    realisations: Realisations,
    shape: SumsShape,
    /// Of each tile.
    sums: Vec<Sums>,
    /// The unit of what is summed; `None` before a part that is not silent.
    unit: Option<f64>,
    /// The first segment of all records that is summed, and the next one to be.
    first: usize,
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

fn refuse<T>(expected: impl Into<String>, found: impl ToString) -> Result<T> {
    Err(Error::request("merge", expected, found))
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
        let Some(&first) = order.first() else {
            return refuse("at least one part", "none");
        };
        let about = parts[first].1.clone();
        for (name, other) in &parts {
            if let Some(difference) = difference(&about, other) {
                let expected = format!("parts of one result, as {}", parts[first].0);
                return refuse(expected, format!("{difference} in {name}"));
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
            let (name, [from, end]) = (&parts[at].0, parts[at].1.range);
            let unit = parts[at].1.unit;
            if from >= end || end > all || !(unit > 0.0 && unit.is_finite()) {
                let expected =
                    format!("segments among the {all} of all records, and a unit above 0");
                return refuse(expected, format!("{from} to {end}, and {unit}, in {name}"));
            }
            if from < next {
                let last = next.min(end) - 1;
                let found = format!("segments {from} to {last} in {before} and {name}");
                return refuse("each part once", found);
            }
            if from > next {
                return missing(&parts, [next, from], all);
            }
            (next, before) = (end, name);
        }
        if is_all && next < all {
            return missing(&parts, [next, all], all);
        }
        let state = shape.bytes().saturating_mul(about.grid.tiles() as u64);
        if state == 0 {
            return refuse("a field with sites", "none");
        }
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
        let names = parts.into_iter();
        let names = names.map(|(name, about)| (about.range[0], name)).collect();
        let combination = Combination {
            names,
            realisations,
            shape,
            sums: vec![Sums::zeros(shape); about.grid.tiles()],
            about,
            unit: None,
            first: start,
            next: start,
        };
        Ok((combination, order))
    }

    /// Adds the part that follows.
    ///
    /// # Errors
    /// [`Error::Request`] for a part that does not follow, and sums that are not those of its request.
    pub fn add(&mut self, partial: &Partial) -> Result<()> {
        let [from, end] = partial.about.range;
        let begun = begun(&(from..end), self.realisations.segments.count());
        let width = self.shape.numbers(begun.len());
        if from != self.next || partial.sums.len() != width * self.sums.len() {
            let (count, next) = (width * self.sums.len(), self.next);
            let expected = format!("{count} sums from segment {next} on");
            let name = self.names.iter().find(|(first, _)| *first == from);
            let name = name.map_or("a part", |(_, name)| name);
            let found = format!("{} from {from} on in {name}", partial.sums.len());
            return refuse(expected, found);
        }
        let read = |numbers| Sums::read(self.shape, &begun, numbers);
        let mut tiles: Vec<Sums> = partial.sums.chunks_exact(width).map(read).collect();
        // Sums are in the largest of all units, so that nothing leaves the range of numbers but what is too small to
        // count; the unit of silence says nothing.
        if !tiles.iter().all(Sums::is_silent) {
            let unit = partial.about.unit;
            let largest = self.unit.map_or(unit, |before| before.max(unit));
            let before = self.unit.unwrap_or(largest);
            for (tiles, unit) in [(&mut self.sums, before), (&mut tiles, unit)] {
                tiles
                    .iter_mut()
                    .for_each(|tile| tile.rescale(unit / largest));
            }
            self.unit = Some(largest);
        }
        let (samples, about_mean) = (self.realisations.reached(), self.realisations.about_mean());
        for (sums, tile) in self.sums.iter_mut().zip(tiles) {
            sums.merge(tile, samples, about_mean);
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
            return refuse("all parts", found);
        }
        let (request, grid) = (&self.about.request, &self.about.grid);
        let pass = request.pass(&self.realisations, grid, records);
        pass.combine(self.sums, self.unit.unwrap_or(1.0))
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
    let result = pass.combine(sums, 1.0)?;
    Ok(Outline {
        segments: realisations.segments,
        result,
    })
}

/// The parts without which a range of segments is unknown.
fn missing<T>(parts: &[(String, PartialAbout)], [from, end]: [usize; 2], all: usize) -> Result<T> {
    let numbered = parts.iter().map(|(_, about)| about.part);
    let of = parts[0].1.part.map_or(0, |part| part.of);
    let numbers: Option<BTreeSet<usize>> = numbered
        .map(|part| part.filter(|part| part.of == of && of <= all))
        .map(|part| part.map(|part| part.number))
        .collect();
    let found = match numbers {
        Some(numbers) => {
            let lacking = (1..=of).filter(|number| !numbers.contains(number)).take(8);
            let lacking: Vec<String> = lacking.map(|number| format!("{number}/{of}")).collect();
            format!("no part {}", lacking.join(", "))
        }
        None => format!("no segments {from} to {}", end - 1),
    };
    refuse("all parts of one result", found)
}

/// What differs between the results that two parts belong to.
fn difference(a: &PartialAbout, b: &PartialAbout) -> Option<String> {
    let mut other = PartialAbout {
        part: a.part,
        range: a.range,
        unit: a.unit,
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
    if let (Value::Object(a), Value::Object(b)) = (a, b) {
        let of = |map: &serde_json::Map<String, Value>, key: &str| {
            map.get(key).cloned().unwrap_or(Value::Null)
        };
        let mut keys = a.keys().chain(b.keys());
        return keys.find_map(|key| differing(key, &of(a, key), &of(b, key)));
    }
    Some(format!("{key} {b} in place of {a}"))
}
