//! Options that choose the part of each axis that figures show.

use clap::Args;
use wavecascade::analyze::{Show, ShowAxis};
use wavecascade::measure::{
    Dimension, Frequency, Length, Measure, Time, Wavenumber, cycles_per, units,
};
use wavecascade::{Error, Field};

/// What is typed of an axis: `all`, an upper end, or both ends, of which one may be left out.
#[derive(Debug, Clone, Copy)]
pub enum Limits<D: Dimension> {
    All,
    UpTo(Measure<D>),
    Between(Option<Measure<D>>, Option<Measure<D>>),
}

/// Reads `all`, `HIGH` or `LOW:HIGH`, with units.
fn limits<D: Dimension>(text: &str) -> Result<Limits<D>, String> {
    let expected = || {
        format!(
            "expected HIGH, LOW:HIGH or all; numbers are in the unit of the axis, or have their own \
             ({})",
            units::<D>()
        )
    };
    let number = |text: &str| Measure::<D>::read(text).map_err(|_| expected());
    let end = |text: &str| match text.trim() {
        "" => Ok(None),
        text => number(text).map(Some),
    };
    match text.split_once(':') {
        None if text.trim() == "all" => Ok(Limits::All),
        None => number(text).map(Limits::UpTo),
        Some((low, high)) => match (end(low)?, end(high)?) {
            (None, None) => Err(expected()),
            (low, high) => Ok(Limits::Between(low, high)),
        },
    }
}

/// Options of the display limits.
#[derive(Debug, Args)]
#[command(next_help_heading = "Display limits of figures and report")]
pub struct ShowArgs {
    /// Frequencies that are shown, in cycles per unit of time, or with their unit (2kHz): the upper
    /// end, both ends, or all [default: up to where 99.9 % of the energy lies].
    #[arg(long, value_name = "[LOW:]HIGH", value_parser = limits::<Frequency>,
          allow_hyphen_values = true)]
    pub show_frequency: Option<Limits<Frequency>>,
    /// Wavenumbers that are shown, in rad per unit of length; one value stands for both signs
    /// [default: up to where 99.9 % of the energy lies].
    #[arg(long, value_name = "[LOW:]HIGH", value_parser = limits::<Wavenumber>,
          allow_hyphen_values = true)]
    pub show_wavenumber: Option<Limits<Wavenumber>>,
    /// Times that are shown [default: all but ends without motion].
    #[arg(long, value_name = "[FROM:]TO", value_parser = limits::<Time>,
          allow_hyphen_values = true)]
    pub show_time: Option<Limits<Time>>,
    /// Positions that are shown [default: all but ends without motion].
    #[arg(long, value_name = "[FROM:]TO", value_parser = limits::<Length>,
          allow_hyphen_values = true)]
    pub show_space: Option<Limits<Length>>,
}

impl ShowArgs {
    /// The limits in the units of the field's axes.
    pub fn of_field(&self, field: &Field) -> Result<Show, Error> {
        let (time, length) = (field.time.unit.as_deref(), field.space.unit.as_deref());
        let frequency = time.map(cycles_per);
        let wavenumber = length.map(|unit| format!("rad/{unit}"));
        Ok(Show {
            frequency: axis("show-frequency", self.show_frequency, frequency.as_deref())?,
            wavenumber: axis(
                "show-wavenumber",
                self.show_wavenumber,
                wavenumber.as_deref(),
            )?,
            time: axis("show-time", self.show_time, time)?,
            space: axis("show-space", self.show_space, length)?,
        })
    }
}

/// `FROM:TO`, each in the unit of the axis or with its own; an end that is left out is infinite.
#[derive(Debug, Clone, Copy)]
pub struct Ends<D: Dimension>(Option<Measure<D>>, Option<Measure<D>>);

/// Reads `FROM:TO`, with units.
pub fn ends<D: Dimension>(text: &str) -> Result<Ends<D>, String> {
    let expected = || {
        format!(
            "expected FROM:TO, of which one may be left out; numbers are in the unit of the axis, or have their own ({})",
            units::<D>()
        )
    };
    let end = |text: &str| match text.trim() {
        "" | "inf" | "-inf" => Ok(None),
        text => Measure::<D>::read(text).map(Some).map_err(|_| expected()),
    };
    let (from, to) = text.split_once(':').ok_or_else(expected)?;
    let (from, to) = (end(from)?, end(to)?);
    match (&from, &to) {
        (Some(from), Some(to)) if from.has_unit == to.has_unit && from.value > to.value => {
            Err(format!("{}, the lower one first", expected()))
        }
        _ => Ok(Ends(from, to)),
    }
}

impl<D: Dimension + Copy> Ends<D> {
    /// Both ends as numbers in the unit of an axis.
    pub fn of_axis(self, option: &'static str, unit: Option<&str>) -> Result<(f64, f64), Error> {
        let end = |end: Option<Measure<D>>, open: f64| {
            end.map_or(Ok(open), |end| of_axis(option, end, unit))
        };
        Ok((end(self.0, f64::NEG_INFINITY)?, end(self.1, f64::INFINITY)?))
    }
}

/// Units of the axes of a field, of its frequencies and its wavenumbers, where they have one.
pub struct AxisUnits {
    pub time: Option<String>,
    pub frequency: Option<String>,
    pub wavenumber: Option<String>,
}

impl AxisUnits {
    pub fn of(field: &Field) -> AxisUnits {
        AxisUnits {
            time: field.time.unit.clone(),
            frequency: field.time.unit.as_deref().map(cycles_per),
            wavenumber: field
                .space
                .unit
                .as_deref()
                .map(|unit| format!("rad/{unit}")),
        }
    }
}

/// A number in the unit of an axis, where one is stated.
pub fn stated<D: Dimension>(
    option: &'static str,
    measure: Option<Measure<D>>,
    unit: Option<&str>,
) -> Result<Option<f64>, Error> {
    let number = measure.map(|measure| of_axis(option, measure, unit));
    number.transpose()
}

/// A number in the unit of an axis, which a field may not have.
pub fn of_axis<D: Dimension>(
    option: &'static str,
    measure: Measure<D>,
    unit: Option<&str>,
) -> Result<f64, Error> {
    let found = format!("{measure:?}");
    let value = match unit {
        Some(unit) => measure.in_unit(unit),
        None if measure.has_unit => None,
        None => Some(measure.value),
    };
    value.ok_or_else(|| Error::Request {
        option,
        expected: match unit {
            Some(unit) => format!("a number in {unit}, the unit of the axis"),
            None => "a number, since the axis has no unit".into(),
        },
        found,
    })
}

fn axis<D: Dimension + Copy>(
    option: &'static str,
    typed: Option<Limits<D>>,
    unit: Option<&str>,
) -> Result<ShowAxis, Error> {
    let number = |measure: Measure<D>| of_axis(option, measure, unit);
    let end = |measure: Option<Measure<D>>, open: f64| measure.map_or(Ok(open), number);
    Ok(match typed {
        None => ShowAxis::Auto,
        Some(Limits::All) => ShowAxis::WHOLE,
        Some(Limits::UpTo(high)) => ShowAxis::UpTo(number(high)?),
        Some(Limits::Between(low, high)) => ShowAxis::Interval {
            low: end(low, f64::NEG_INFINITY)?,
            high: end(high, f64::INFINITY)?,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_an_end_two_ends_or_all() {
        let read = limits::<Frequency>;
        assert!(matches!(read("all"), Ok(Limits::All)));
        assert!(matches!(read("2kHz"), Ok(Limits::UpTo(high)) if high.value == 2000.0));
        let between = read("1kHz:");
        assert!(matches!(between, Ok(Limits::Between(Some(low), None)) if low.value == 1000.0));
        for wrong in [":", "", "high", "1:2:3", "3 mm", "nan"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
