//! What the coordinates of a dimension say: origin, step, unit, and the time at which it starts.

use wavecascade_formats::{Coordinate, Sample};

use super::super::Note;
use super::super::beside::{AxisBeside, Given, Listing};
use super::super::coordinates::{Coordinates, Listed};
use super::Arrays;
use super::choose::Place;
use crate::error::Result;
use crate::measure::{self, Dimension, Time};

/// The axis of a dimension, by its coordinates and what is stated beside them.
///
/// # Errors
/// Coordinates that are not even, or contradict another clock or a stated step.
pub(super) fn axis<D: Dimension + Copy>(
    arrays: &Arrays,
    beside: &AxisBeside<D>,
    place: Option<&Place>,
    notes: &mut Vec<Note>,
) -> Result<Listed> {
    let Some(place) = place else {
        return Ok(beside.axis(None, notes)?);
    };
    let given = match &place.coordinate {
        None => None,
        Some(Coordinate::Even { origin, step, unit }) => {
            let even = Coordinates {
                origin: Some(*origin),
                step: Some(*step).filter(|step| *step > 0.0 && step.is_finite()),
                unit: unit.clone(),
            };
            Some(Given::Even(even))
        }
        Some(Coordinate::Listed(i)) => {
            let all = std::iter::once(i).chain(&place.others);
            let all = all.map(|i| listing(arrays, *i, place.is_time));
            Listing::best(all.collect::<Result<_>>()?)?.map(Given::Listed)
        }
    };
    Ok(beside.axis(given, notes)?)
}

fn listing(arrays: &Arrays, i: usize, is_time: bool) -> Result<Listing> {
    let variable = arrays.variable(i);
    let sample = variable.sample_type.number();
    let integers = match sample.is_some_and(Sample::is_float) {
        true => None,
        false => arrays.container.integers(i)?,
    };
    let stored: Vec<f64> = match &integers {
        Some(integers) => integers.iter().map(|&v| v as f64).collect(),
        None => arrays.container.numbers(i)?,
    };
    let (scale, offset) = arrays.own(i).linear();
    let rounding = sample.map_or(0.0, |sample| sample.spacing(&stored)) * scale.abs();
    let place = variable.path.trim_start_matches('/').to_owned();
    let may_count = is_time && arrays.source.stated.time_unit.is_none();
    let stored = (&stored[..], integers.as_deref());
    let found = counted(stored, [scale, offset], rounding, arrays.unit(i), may_count);
    let step = variable.attributes.number("step");
    Ok(Listing {
        place,
        step: step.filter(|_| found.start.is_none()),
        ..found
    })
}

/// Coordinates `scale * stored + offset`, as floats and exactly where they are integers: counted from the first where their
/// unit counts from a date, or where they `may_count` so without one.
pub(in crate::field) fn counted(
    (stored, integers): (&[f64], Option<&[i64]>),
    [scale, offset]: [f64; 2],
    rounding: f64,
    unit: Option<String>,
    may_count: bool,
) -> Listing {
    let unit = unit.or_else(|| may_count.then(|| since_1970(stored)).flatten());
    let Some(since) = unit.as_deref().and_then(Since::parse) else {
        return Listing {
            values: stored.iter().map(|v| scale * v + offset).collect(),
            rounding,
            unit,
            ..Listing::default()
        };
    };
    // No digits go to the years before the first. Differences of large numbers are as exact as those; integers have no
    // rounding.
    let (apart, rounding) = match integers {
        Some(integers) => {
            let first = integers.first().copied().unwrap_or(0);
            let apart = integers.iter();
            let apart = apart.map(|v| scale * v.wrapping_sub(first) as f64);
            (apart.collect(), 0.0)
        }
        None => {
            let apart = stored.iter().map(|v| scale * (v - stored[0]));
            let rounding = rounding.max(Sample::F64.spacing(stored) * scale.abs());
            (apart.collect(), rounding)
        }
    };
    // An integer that is not packed stays one.
    let first = match integers.and_then(<[i64]>::first) {
        Some(first) if (scale, offset) == (1.0, 0.0) => first.to_string(),
        _ => (scale * stored.first().copied().unwrap_or(0.0) + offset).to_string(),
    };
    since.listing(apart, rounding, &first)
}

/// The unit of times without one that can only count from 1970: in seconds and their fractions, 2001 to 2286.
fn since_1970(values: &[f64]) -> Option<String> {
    let units = ["seconds", "milliseconds", "microseconds", "nanoseconds"];
    let (first, last) = (values.first()?, values.last()?);
    let fits = |(_, least): &(&str, f64)| {
        let range = *least..10.0 * least;
        range.contains(first) && range.contains(last)
    };
    let mut least = units.into_iter().zip([1e9, 1e12, 1e15, 1e18]);
    Some(format!("{} since 1970-01-01", least.find(fits)?.0))
}

/// `seconds since 2026-01-01`, as the CF conventions write times.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Since<'a> {
    /// The unit of the axis.
    unit: &'static str,
    /// Counts in that unit.
    divisor: f64,
    date: &'a str,
    /// The unit as it is written.
    counts: &'a str,
}

impl<'a> Since<'a> {
    /// Nanoseconds and finer fractions of a second become seconds, which measurements are told in.
    fn parse(units: &'a str) -> Option<Since<'a>> {
        let (counts, date) = units.split_once(" since ")?;
        let lower = counts.trim().to_ascii_lowercase();
        let singular = lower.strip_suffix('s').unwrap_or(&lower);
        let known = measure::symbol::<Time>(&lower).or(measure::symbol::<Time>(singular));
        let (unit, divisor) = match known.unwrap_or(singular) {
            "day" | "d" => ("h", 1.0 / 24.0),
            "ns" => ("s", 1e9),
            "us" | "u" => ("s", 1e6),
            "ms" | "m" => ("s", 1e3),
            _ => (known?, 1.0),
        };
        Some(Since {
            unit,
            divisor,
            date: date.trim(),
            counts: counts.trim(),
        })
    }

    /// Coordinates that are `apart` from the first, all in the counts of the unit.
    fn listing(&self, apart: Vec<f64>, rounding: f64, first: &str) -> Listing {
        Listing {
            values: apart.iter().map(|v| v / self.divisor).collect(),
            rounding: rounding / self.divisor,
            unit: Some(self.unit.to_owned()),
            start: Some(self.time(first)),
            ..Listing::default()
        }
    }

    /// The time of the first sample in words.
    fn time(&self, first: &str) -> String {
        match first {
            "0" | "-0" => self.date.to_owned(),
            first => format!("{} + {first} {}", self.date, self.counts),
        }
    }
}
