//! Values in the units of a field's axes, and the options that choose the part of each axis that figures show.

use clap::Args;
use wavecascade::analyze::{Show, ShowAxis};
use wavecascade::measure::{
    Dimension, Frequency, Length, Measure, Time, Wavenumber, cycles_per, units,
};
use wavecascade::{Error, Field};

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
    Ok(Ends(end(from)?, end(to)?))
}

/// What is typed of an axis: an upper end, or both ends; none of `all`.
#[derive(Debug, Clone, Copy)]
pub enum Limits<D: Dimension> {
    UpTo(Measure<D>),
    Between(Ends<D>),
}

/// Reads `all`, `HIGH` or `LOW:HIGH`, with units.
fn limits<D: Dimension>(text: &str) -> Result<Limits<D>, String> {
    let read = match text.trim() {
        "all" => Some(Limits::Between(Ends(None, None))),
        ":" => None,
        text if text.contains(':') => ends(text).ok().map(Limits::Between),
        text => Measure::read(text).ok().map(Limits::UpTo),
    };
    read.ok_or_else(|| {
        format!(
            "expected HIGH, LOW:HIGH or all; numbers are in the unit of the axis, or have their own ({})",
            units::<D>()
        )
    })
}

/// Units of the axes of a field and of its samples, where they have one.
#[derive(Debug, Default)]
pub struct AxisUnits<'a> {
    pub time: Option<&'a str>,
    pub length: Option<&'a str>,
    pub samples: Option<&'a str>,
}

impl<'a> AxisUnits<'a> {
    pub fn of(field: &'a Field) -> AxisUnits<'a> {
        AxisUnits {
            time: field.time.unit.as_deref(),
            length: field.space.unit.as_deref(),
            samples: field.unit.as_deref(),
        }
    }

    /// The unit that a quantity of dimension `D` has here.
    fn unit<D: Dimension>(&self) -> Option<String> {
        match D::UNITS[0].0 {
            "s" => self.time.map(str::to_owned),
            "m" => self.length.map(str::to_owned),
            "Hz" => self.time.map(cycles_per),
            "rad/m" => self.length.map(|unit| format!("rad/{unit}")),
            _ => self.samples.map(str::to_owned),
        }
    }

    /// A measure as a number in the unit that it has here.
    ///
    /// # Errors
    /// For a measure with a unit of its own where there is none, or one of unknown size.
    pub fn number<D: Dimension>(
        &self,
        option: &'static str,
        measure: Measure<D>,
    ) -> Result<f64, Error> {
        let found = format!("{measure:?}");
        let unit = self.unit::<D>();
        let value = match &unit {
            Some(unit) => measure.in_unit(unit),
            None if measure.has_unit => None,
            None => Some(measure.value),
        };
        let expected = || match unit {
            Some(unit) => format!("a number in {unit}, the unit of the axis"),
            None => "a number, since the axis has no unit".into(),
        };
        value.ok_or_else(|| Error::request(option, expected(), found))
    }

    /// The same, where one is stated.
    pub fn stated<D: Dimension>(
        &self,
        option: &'static str,
        measure: Option<Measure<D>>,
    ) -> Result<Option<f64>, Error> {
        measure
            .map(|measure| self.number(option, measure))
            .transpose()
    }

    /// Both ends; one that is left out is infinite.
    pub fn ends<D: Dimension>(
        &self,
        option: &'static str,
        Ends(from, to): Ends<D>,
    ) -> Result<(f64, f64), Error> {
        let from = self.stated(option, from)?.unwrap_or(f64::NEG_INFINITY);
        let to = self.stated(option, to)?.unwrap_or(f64::INFINITY);
        let found = format!("{from}:{to}");
        Error::require(from <= to, option, "the lower end first", found)?;
        Ok((from, to))
    }

    /// The part of an axis that is shown.
    fn shown<D: Dimension>(
        &self,
        option: &'static str,
        typed: Option<Limits<D>>,
    ) -> Result<ShowAxis, Error> {
        Ok(match typed {
            None => ShowAxis::Auto,
            Some(Limits::UpTo(high)) => ShowAxis::UpTo(self.number(option, high)?),
            Some(Limits::Between(ends)) => {
                let (low, high) = self.ends(option, ends)?;
                ShowAxis::Interval { low, high }
            }
        })
    }
}

/// Options of the display limits.
#[derive(Debug, Args)]
#[command(next_help_heading = "Display limits of figures and report")]
pub struct ShowArgs {
    /// Frequencies that are shown, in cycles per unit of time, or with their unit (2kHz): the upper
    /// end, both ends, or all [default: up to where 99.9 % of the energy lies].
    #[arg(long, value_name = "[LOW:]HIGH", value_parser = limits::<Frequency>)]
    pub show_frequency: Option<Limits<Frequency>>,
    /// Wavenumbers that are shown, in rad per unit of length; one value stands for both signs
    /// [default: up to where 99.9 % of the energy lies].
    #[arg(long, value_name = "[LOW:]HIGH", value_parser = limits::<Wavenumber>)]
    pub show_wavenumber: Option<Limits<Wavenumber>>,
    /// Times that are shown [default: all but ends without motion].
    #[arg(long, value_name = "[FROM:]TO", value_parser = limits::<Time>)]
    pub show_time: Option<Limits<Time>>,
    /// Positions that are shown [default: all but ends without motion].
    #[arg(long, value_name = "[FROM:]TO", value_parser = limits::<Length>)]
    pub show_space: Option<Limits<Length>>,
}

impl ShowArgs {
    /// The limits in the units of the field's axes.
    pub fn in_units(&self, units: &AxisUnits) -> Result<Show, Error> {
        Ok(Show {
            frequency: units.shown("show-frequency", self.show_frequency)?,
            wavenumber: units.shown("show-wavenumber", self.show_wavenumber)?,
            time: units.shown("show-time", self.show_time)?,
            space: units.shown("show-space", self.show_space)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_an_end_two_ends_or_all() {
        let read = limits::<Frequency>;
        assert!(matches!(read("all"), Ok(Limits::Between(Ends(None, None)))));
        assert!(matches!(read("2kHz"), Ok(Limits::UpTo(high)) if high.value == 2000.0));
        let between = read("1kHz:");
        assert!(
            matches!(between, Ok(Limits::Between(Ends(Some(low), None))) if low.value == 1000.0)
        );
        for wrong in [":", "", "high", "1:2:3", "3 mm", "nan"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
