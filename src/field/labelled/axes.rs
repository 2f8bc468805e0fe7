//! What the coordinates of a dimension say: origin, step, unit, and the time at which it starts.

use wavecascade_formats::{Attributes, Container, Coordinate, Result};

use super::super::Note;
use super::super::coordinates::{Coordinates, Evenness, Listed};
use super::choose::Place;
use super::{scaling, unpacked};
use crate::error::InputFault;
use crate::measure::{self, Time};

/// Coordinates of an axis, and the notes on them.
pub(super) type Found = (Listed, Vec<Note>);

/// The coordinates of a dimension. Those whose step is stated elsewhere, and which have no `rules`, need not
/// be even.
///
/// # Errors
/// Coordinates that the rules refuse.
pub(super) fn coordinates(
    container: &Container,
    axis: &'static str,
    place: Option<&Place>,
    rules: Option<Evenness>,
) -> std::result::Result<Found, AxisFault> {
    let Some(place) = place else {
        return Ok(Default::default());
    };
    match &place.coordinate {
        None => Ok(Default::default()),
        Some(Coordinate::Even { origin, step, unit }) => {
            let even = Coordinates {
                origin: Some(*origin),
                step: Some(*step).filter(|step| *step > 0.0 && step.is_finite()),
                unit: unit.clone(),
            };
            let even = Listed {
                even,
                ..Listed::default()
            };
            Ok((even, Vec::new()))
        }
        Some(Coordinate::Listed(i)) => listed(container, axis, *i, rules),
    }
}

/// Why an axis cannot be read.
#[derive(Debug)]
pub(super) enum AxisFault {
    Container(wavecascade_formats::Error),
    Input(InputFault),
}

impl From<wavecascade_formats::Error> for AxisFault {
    fn from(fault: wavecascade_formats::Error) -> Self {
        AxisFault::Container(fault)
    }
}

fn listed(
    container: &Container,
    axis: &'static str,
    i: usize,
    rules: Option<Evenness>,
) -> std::result::Result<Found, AxisFault> {
    let variable = &container.variables[i];
    let attributes = &variable.attributes;
    let sample = variable.sample_type.number();
    let mut notes = Vec::new();
    let (values, unit, rounding) = match Since::of(attributes) {
        Some(since) => {
            // Counted from the first, so that no digits go to the years before it.
            let (values, first) = from_first(container, i)?;
            let (scale, offset) = scaling(attributes);
            notes.push(Note::Start {
                time: since.time(first.unpacked(scale, offset)),
            });
            let values = values.into_iter().map(|v| scale * v / since.divisor);
            let values = values.collect();
            (values, Some(since.unit.to_owned()), None)
        }
        None => {
            let values = unpacked(container, i)?;
            let unit = attributes.text("units").map(str::to_owned);
            (values, unit, Some(()))
        }
    };
    let rounding = match rounding {
        Some(()) => sample.map_or(0.0, |sample| sample.spacing(&values)),
        // Differences of large numbers are as exact as those.
        None => rounding_since(container, i)?,
    };
    let known = (rounding, attributes.number("step"));
    let mut listed = Coordinates::listed(axis, &values, known, rules)
        .map_err(|uneven| AxisFault::Input(uneven.fault(axis)))?;
    listed.even.unit = unit;
    notes.extend(listed.note.take());
    Ok((listed, notes))
}

/// The numbers of a variable less the first one, exact for integers, and the first one.
fn from_first(container: &Container, i: usize) -> Result<(Vec<f64>, First)> {
    if let Some(integers) = container.integers(i)? {
        let first = integers.first().copied().unwrap_or(0);
        let values = integers.iter().map(|v| v.wrapping_sub(first) as f64);
        return Ok((values.collect(), First::Integer(first)));
    }
    let numbers = container.numbers(i)?;
    let first = numbers.first().copied().unwrap_or(0.0);
    let values = numbers.iter().map(|v| v - first).collect();
    Ok((values, First::Float(first)))
}

/// Rounding of floats that count from long ago; integers have none.
fn rounding_since(container: &Container, i: usize) -> Result<f64> {
    if container.integers(i)?.is_some() {
        return Ok(0.0);
    }
    let attributes = &container.variables[i].attributes;
    let divisor = Since::of(attributes).map_or(1.0, |since| since.divisor);
    let (scale, _) = scaling(attributes);
    let numbers = container.numbers(i)?;
    let sample = container.variables[i].sample_type.number();
    Ok(sample.map_or(0.0, |sample| sample.spacing(&numbers)) * scale.abs() / divisor)
}

/// Values that count from a date, by their unit, from the first one on, with their rounding and their unit; and the
/// time of the first.
pub(in crate::field) fn dated(
    values: &[f64],
    rounding: f64,
    unit: &str,
) -> Option<(Vec<f64>, f64, &'static str, String)> {
    let since = Since::parse(unit)?;
    let first = values.first().copied().unwrap_or(0.0);
    let apart = values.iter().map(|v| (v - first) / since.divisor).collect();
    let start = since.time(First::Float(first));
    Some((apart, rounding / since.divisor, since.unit, start))
}

#[derive(Debug, Clone, Copy)]
enum First {
    Integer(i64),
    Float(f64),
}

impl First {
    /// The number that a packed one stands for; an integer that is not packed stays one.
    fn unpacked(self, scale: f64, offset: f64) -> First {
        match self {
            First::Integer(first) if (scale, offset) != (1.0, 0.0) => {
                First::Float(scale * first as f64 + offset)
            }
            First::Float(first) => First::Float(scale * first + offset),
            first => first,
        }
    }
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
    fn of(attributes: &'a Attributes) -> Option<Since<'a>> {
        Since::parse(attributes.text("units")?)
    }

    /// Nanoseconds and finer fractions of a second become seconds, which measurements are told in.
    fn parse(units: &'a str) -> Option<Since<'a>> {
        let (counts, date) = units.split_once(" since ")?;
        let lower = counts.trim().to_ascii_lowercase();
        let singular = lower.strip_suffix('s').unwrap_or(&lower);
        let (unit, divisor) = match singular {
            "day" | "d" => ("h", 1.0 / 24.0),
            "nanosecond" | "n" => ("s", 1e9),
            "microsecond" | "u" => ("s", 1e6),
            "millisecond" | "m" => ("s", 1e3),
            _ => (
                measure::symbol::<Time>(&lower).or(measure::symbol::<Time>(singular))?,
                1.0,
            ),
        };
        let (unit, divisor) = match unit {
            "ns" => ("s", 1e9),
            "us" => ("s", 1e6),
            "ms" => ("s", 1e3),
            unit => (unit, divisor),
        };
        Some(Since {
            unit,
            divisor,
            date: date.trim(),
            counts: counts.trim(),
        })
    }

    /// The time of the first sample in words.
    fn time(&self, first: First) -> String {
        let (is_zero, first) = match first {
            First::Integer(first) => (first == 0, first.to_string()),
            First::Float(first) => (first == 0.0, first.to_string()),
        };
        match is_zero {
            true => self.date.to_owned(),
            false => format!("{} + {first} {}", self.date, self.counts),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_since_a_date() {
        for (units, unit, divisor, date) in [
            ("seconds since 1970-01-01", "s", 1.0, "1970-01-01"),
            (
                "nanoseconds since 2026-01-01T00:00:00",
                "s",
                1e9,
                "2026-01-01T00:00:00",
            ),
            ("ms since 2000-01-01 12:00", "s", 1e3, "2000-01-01 12:00"),
            ("days since 1900-01-01", "h", 1.0 / 24.0, "1900-01-01"),
            ("hours since 1900-01-01", "h", 1.0, "1900-01-01"),
        ] {
            let since = Since::parse(units).unwrap();
            assert_eq!(
                (since.unit, since.divisor, since.date),
                (unit, divisor, date)
            );
        }
        assert_eq!(Since::parse("seconds"), None);
        assert_eq!(Since::parse("parsecs since noon"), None);
        let since = Since::parse("ns since 1970-01-01").unwrap();
        assert_eq!(since.time(First::Integer(5)), "1970-01-01 + 5 ns");
    }
}
