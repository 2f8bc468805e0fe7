//! A channel, and what the properties of several say.

use std::collections::HashMap;

use super::description::Kind;
use super::property::{Stamp, position, split_unit};
use super::samples::Texts;
use super::scale::scaling;
use super::segments::Object;
use crate::rows::{Pieces, Scaling};
use crate::sets::{Traits, only_rising};
use crate::{Attributes, Coordinate, Dimension, Sample, Value};

/// Names of channels that hold the times of others.
const TIMES: [&str; 5] = ["time", "times", "t", "timestamp", "time stamp"];
/// Names of properties that hold the positions of channels.
const POSITIONS: [&str; 5] = ["x", "y", "z", "position", "distance"];
/// Properties that hold the unit of a channel, the first that is there.
const UNITS: [&str; 6] = [
    "unit_string",
    "NI_UnitDescription",
    "units",
    "unit",
    "Units",
    "Unit",
];
/// Properties that are told by dimensions.
const TOLD: [&str; 4] = [
    "wf_increment",
    "wf_start_offset",
    "wf_start_time",
    "wf_xunit_string",
];
/// Attributes that mean something to others; a property of such a name does not.
const RESERVED: [&str; 10] = [
    "units",
    "long_name",
    "_FillValue",
    "missing_value",
    "scale_factor",
    "add_offset",
    "delays",
    "MATLAB_class",
    "start_time",
    "channels",
];

/// A channel of a group.
#[derive(Debug)]
pub(super) struct Channel {
    pub(super) name: String,
    pub(super) properties: Attributes,
    pub(super) pieces: Pieces,
    pub(super) texts: Vec<Texts>,
    pub(super) form: Form,
    pub(super) unit: Option<String>,
}

/// What the samples of a channel become.
#[derive(Debug)]
pub(super) enum Form {
    Numbers(Sample, Scaling),
    Time,
    Other(String),
}

impl Channel {
    /// A channel below a group and a file with these properties.
    pub(super) fn new(name: String, object: Object, above: [&Attributes; 2]) -> Channel {
        let properties = object.properties;
        let scaled = |sample, scaler: Option<u32>| {
            let places = [&properties].into_iter().chain(above);
            let mut stated = places.map(|place| scaling(place, scaler));
            match stated.find(|stated| *stated != Ok(None)) {
                Some(Err(kind)) => Form::Other(format!("samples with a scaling of type {kind}")),
                Some(Ok(Some(scaling))) => Form::Numbers(sample, scaling),
                _ if scaler.is_some() => {
                    Form::Other("samples of a DAQmx device without a scaling".into())
                }
                _ => Form::Numbers(sample, Scaling::default()),
            }
        };
        let form = match object.kind {
            Some(Kind::Number(sample)) => scaled(sample, None),
            Some(Kind::Device(sample, scaler)) => scaled(sample, Some(scaler)),
            Some(Kind::Time) => Form::Time,
            Some(Kind::Text) => Form::Other("text".into()),
            Some(Kind::Other(what)) => Form::Other(what.into()),
            None => Form::Other("no samples".into()),
        };
        let unit = UNITS.iter().find_map(|unit| properties.text(unit));
        let unit = unit.or(split_unit(&name).1).map(str::to_owned);
        Channel {
            name,
            properties,
            pieces: object.pieces,
            texts: object.texts,
            form,
            unit,
        }
    }

    pub(super) fn len(&self) -> u64 {
        let texts = self.texts.iter().map(|chunk| chunk.count);
        self.pieces.len() + texts.sum::<u64>()
    }

    /// Whether it holds the times of others.
    pub(super) fn is_time(&self) -> bool {
        let name = split_unit(&self.name).0.to_ascii_lowercase();
        match self.form {
            Form::Time => true,
            Form::Numbers(..) => TIMES.contains(&name.as_str()),
            Form::Other(_) => false,
        }
    }

    /// Why it is no part of a variable of several channels, if it is not.
    pub(super) fn is_alone(&self) -> Option<&str> {
        match &self.form {
            Form::Other(what) => Some(what),
            Form::Numbers(..) if self.len() > 0 => None,
            _ => Some("no samples"),
        }
    }

    /// What it must share with others of the same variable.
    pub(super) fn traits(&self) -> Traits {
        // Numbers that a double does not hold, or that are no measurement, stay apart.
        let sample = match self.unscaled() {
            Some(sample @ (Sample::Bool | Sample::I64 | Sample::U64)) => sample.name(),
            _ => "number",
        };
        let times = match self.even() {
            Some([origin, step]) => format!("from {origin} by {step} {}", self.time_unit()),
            None => self.time_unit().to_owned(),
        };
        Traits(vec![
            ("unit", self.unit.clone().unwrap_or("none".into())),
            ("number of samples", self.len().to_string()),
            ("times", times),
            ("start", self.start().unwrap_or("none").to_owned()),
            ("type", sample.to_owned()),
        ])
    }

    /// The type of its numbers, if they are those that are stored.
    pub(super) fn unscaled(&self) -> Option<Sample> {
        match &self.form {
            Form::Numbers(sample, scaling) if scaling.0.is_empty() => Some(*sample),
            _ => None,
        }
    }

    /// Origin and step of its samples, as the properties of a waveform state them.
    fn even(&self) -> Option<[f64; 2]> {
        let step = self.properties.number("wf_increment")?;
        let origin = self.properties.number("wf_start_offset").unwrap_or(0.0);
        let is_even = step.is_finite() && step > 0.0 && origin.is_finite();
        is_even.then_some([origin, step])
    }

    fn time_unit(&self) -> &str {
        self.properties.text("wf_xunit_string").unwrap_or("s")
    }

    fn start(&self) -> Option<&str> {
        let start = self.properties.text("wf_start_time");
        start.filter(|start| !start.starts_with(Stamp::NONE))
    }

    /// The dimension of its samples, along `listed` if nothing else is stated.
    pub(super) fn dimension(&self, listed: Option<usize>) -> Dimension {
        let unit = self.time_unit();
        let name = match self.even() {
            None if listed.is_none() => "sample",
            // Of a spectrum, for instance.
            Some(_) if !matches!(unit, "s" | "ms" | "us" | "ns") => "abscissa",
            _ => "time",
        };
        let even = self.even();
        let even = even.map(|[origin, step]| Coordinate::even(origin, step, unit));
        Dimension {
            coordinate: even.or(listed.map(Coordinate::Listed)),
            ..Dimension::new(self.len()).named(name)
        }
    }
}

/// Positions of channels.
#[derive(Debug, Default)]
pub(super) struct Positions {
    /// Name, unit and values; NaN for a channel without one.
    pub(super) listed: Vec<(&'static str, Option<String>, Vec<f64>)>,
    /// Which of them is the coordinate of the channels.
    pub(super) coordinate: Option<usize>,
    /// One that has several units.
    pub(super) differ: Option<&'static str>,
}

impl Positions {
    pub(super) fn of(channels: &[Channel]) -> Positions {
        let mut positions = Positions::default();
        for axis in POSITIONS {
            let all = channels
                .iter()
                .map(|channel| position(&channel.properties, axis));
            let all: Vec<Option<(f64, Option<&str>)>> = all.collect();
            let mut units = all.iter().flatten().map(|(_, unit)| *unit);
            let Some(unit) = units.next() else { continue };
            if units.any(|other| other != unit) {
                positions.differ = Some(axis);
                continue;
            }
            let values = all
                .iter()
                .map(|one| one.map_or(f64::NAN, |(value, _)| value));
            let unit = unit.map(str::to_owned);
            positions.listed.push((axis, unit, values.collect()));
        }
        let rising = only_rising(positions.listed.iter().map(|(_, _, values)| &values[..]));
        positions.coordinate = rising.filter(|_| positions.differ.is_none());
        positions
    }
}

/// What the properties of channels say: once if they agree, else one value a channel.
pub(super) fn attributes(channels: &[Channel]) -> Attributes {
    let mut attributes = Attributes::default();
    let first = &channels[0];
    if channels.len() > 1 {
        let names = channels.iter().map(|channel| channel.name.clone());
        attributes.insert("channels", Value::Texts(names.collect()));
    }
    if !matches!(first.form, Form::Time) {
        attributes.insert_text("units", first.unit.clone().unwrap_or_default());
    }
    attributes.insert_text("start_time", first.start().unwrap_or_default());
    let mut units = UNITS.iter();
    let unit = units.find(|unit| first.properties.text(unit).is_some());
    let mut counts: HashMap<&str, usize> = HashMap::new();
    let names = channels
        .iter()
        .flat_map(|channel| channel.properties.0.keys());
    names.for_each(|name| *counts.entry(name).or_default() += 1);
    for channel in channels {
        for (name, value) in &channel.properties.0 {
            if TOLD.contains(&name.as_str()) || unit == Some(&name.as_str()) {
                continue;
            }
            let is_everywhere = counts.get(name.as_str()) == Some(&channels.len());
            if !is_everywhere {
                attributes.insert(format!("{}/{name}", channel.name), value.clone());
            } else if std::ptr::eq(channel, first) {
                let values = channels.iter().map(|other| &other.properties);
                let values: Vec<&Value> = values.filter_map(|all| all.get(name)).collect();
                let name = match name.as_str() {
                    "description" if values.iter().all(|one| *one == value) => "long_name".into(),
                    name if RESERVED.contains(&name) => format!("property {name}"),
                    name => name.to_owned(),
                };
                if let Some(value) = Value::together(&values) {
                    attributes.insert(name, value);
                }
            }
        }
    }
    attributes
}
