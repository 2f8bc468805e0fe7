//! A channel, and what the properties of several say.

use std::collections::HashMap;

use super::description::Kind;
use super::pieces::Pieces;
use super::property::{Properties, Property, Stamp, split_unit};
use super::samples::Texts;
use super::scale::{Foreign, Scaling};
use super::segments::Object;
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
    pub(super) properties: Properties,
    pub(super) pieces: Pieces,
    pub(super) texts: Vec<Texts>,
    pub(super) form: Form,
    pub(super) axis: Axis,
    pub(super) unit: Option<String>,
}

/// What the samples of a channel become.
#[derive(Debug)]
pub(super) enum Form {
    Numbers(Sample, Option<Scaling>),
    Time,
    Text,
    Other(String),
}

/// The times of samples, as the properties of a waveform state them.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Axis {
    /// Bits of origin and step; none without a step.
    pub(super) even: Option<[u64; 2]>,
    pub(super) unit: String,
    pub(super) start: Option<Stamp>,
}

/// What channels of one variable have in common.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(super) struct Key {
    /// A type that a double does not hold, or that is no measurement.
    apart: Option<Sample>,
    len: u64,
    pub(super) axis: Axis,
    pub(super) unit: Option<String>,
}

impl Channel {
    /// A channel below a group and a file with these properties.
    pub(super) fn new(name: String, object: Object, above: [&Properties; 2]) -> Channel {
        let properties = object.properties;
        let [of_group, of_file] = above;
        let scaling = |scaler| Scaling::of(&[&properties, of_group, of_file], scaler);
        let foreign = |Foreign(kind)| Form::Other(format!("samples with a scaling of type {kind}"));
        let form = match object.kind {
            Some(Kind::Number(sample)) => match scaling(None) {
                Ok(scaling) => Form::Numbers(sample, scaling),
                Err(other) => foreign(other),
            },
            Some(Kind::Device(sample, scaler)) => match scaling(Some(scaler)) {
                Ok(Some(scaling)) => Form::Numbers(sample, Some(scaling)),
                Ok(None) => Form::Other("samples of a DAQmx device without a scaling".into()),
                Err(other) => foreign(other),
            },
            Some(Kind::Time) => Form::Time,
            Some(Kind::Text) => Form::Text,
            Some(Kind::Other(what)) => Form::Other(what.into()),
            None => Form::Other("no samples".into()),
        };
        let unit = UNITS.iter().find_map(|unit| properties.text(unit));
        let unit = unit.or(split_unit(&name).1).map(str::to_owned);
        Channel {
            axis: Axis::of(&properties),
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
            _ => false,
        }
    }

    /// What it must share with others of the same variable; none for one of its own.
    pub(super) fn key(&self) -> Option<Key> {
        match &self.form {
            Form::Numbers(sample, scaling) if self.len() > 0 => Some(Key {
                apart: Some(*sample).filter(|sample| {
                    scaling.is_none() && matches!(sample, Sample::Bool | Sample::I64 | Sample::U64)
                }),
                len: self.len(),
                axis: self.axis.clone(),
                unit: self.unit.clone(),
            }),
            _ => None,
        }
    }
}

impl Key {
    /// Why a channel is not one of those with this key.
    pub(super) fn differs(&self, channel: &Channel) -> Option<String> {
        let named = |unit: &Option<String>| unit.clone().unwrap_or("none".into());
        let other = match (&channel.form, channel.key()) {
            (Form::Other(what), _) => return Some(what.clone()),
            (Form::Numbers(..), Some(other)) => other,
            (Form::Numbers(..), None) => return Some("no samples".into()),
            _ => return None,
        };
        Some(match () {
            _ if other.unit != self.unit => {
                format!("unit {}, not {}", named(&other.unit), named(&self.unit))
            }
            _ if other.len != self.len => format!("{} samples, not {}", other.len, self.len),
            _ if other.axis != self.axis => "other times".into(),
            _ => {
                let of = |key: &Key| key.apart.map_or("the type of others", Sample::name);
                format!("{}, not {}", of(&other), of(self))
            }
        })
    }
}

impl Axis {
    pub(super) fn of(properties: &Properties) -> Axis {
        let step = properties.number("wf_increment");
        let origin = properties.number("wf_start_offset").unwrap_or(0.0);
        let even = step.filter(|step| step.is_finite() && *step > 0.0 && origin.is_finite());
        let start = match properties.get("wf_start_time") {
            // LabVIEW writes 1904 for none.
            Some(Property::Time(stamp)) if stamp.seconds != 0 => Some(*stamp),
            _ => None,
        };
        Axis {
            even: even.map(|step| [origin, step].map(f64::to_bits)),
            unit: properties.text("wf_xunit_string").unwrap_or("s").to_owned(),
            start,
        }
    }

    /// The dimension of samples, along `listed` if nothing else is stated.
    pub(super) fn dimension(&self, len: u64, listed: Option<usize>) -> Dimension {
        let name = match self.even {
            None if listed.is_none() => "sample",
            // Of a spectrum, for instance.
            Some(_) if !matches!(self.unit.as_str(), "s" | "ms" | "us" | "ns") => "abscissa",
            _ => "time",
        };
        let even = self.even.map(|even| {
            let [origin, step] = even.map(f64::from_bits);
            Coordinate::Even {
                origin,
                step,
                unit: Some(self.unit.clone()),
            }
        });
        Dimension {
            name: Some(name.into()),
            len,
            coordinate: even.or(listed.map(Coordinate::Listed)),
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
            let of = |channel: &Channel| {
                let found = channel.properties.position(axis);
                found.map(|(value, unit)| (value, unit.map(str::to_owned)))
            };
            let all: Vec<_> = channels.iter().map(of).collect();
            let mut units = all.iter().flatten().map(|(_, unit)| unit.clone());
            let Some(unit) = units.next() else { continue };
            if units.any(|other| other != unit) {
                positions.differ = Some(axis);
                continue;
            }
            let values = all
                .into_iter()
                .map(|one| one.map_or(f64::NAN, |(value, _)| value));
            positions.listed.push((axis, unit, values.collect()));
        }
        let varies = |axis: &usize| {
            let values = &positions.listed[*axis].2;
            values.iter().any(|value| *value != values[0])
        };
        let varying: Vec<usize> = (0..positions.listed.len()).filter(varies).collect();
        if let [axis] = varying[..]
            && positions.differ.is_none()
            && positions.listed[axis].2.is_sorted_by(|a, b| a < b)
        {
            positions.coordinate = Some(axis);
        }
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
    if let Some(start) = first.axis.start {
        let text = match Property::Time(start).value() {
            Value::Text(text) => text,
            _ => String::new(),
        };
        attributes.insert_text("start_time", text);
    }
    let unit = UNITS
        .iter()
        .find(|unit| first.properties.text(unit).is_some());
    let mut counts: HashMap<&str, usize> = HashMap::new();
    let all = || channels.iter().flat_map(|channel| &channel.properties.list);
    for (name, _) in all() {
        *counts.entry(name).or_insert(0) += 1;
    }
    let spelled = |name: &str| match RESERVED.contains(&name) {
        true => format!("property {name}"),
        false => name.to_owned(),
    };
    for channel in channels {
        for (name, value) in &channel.properties.list {
            if TOLD.contains(&name.as_str()) || unit == Some(&name.as_str()) {
                continue;
            }
            let is_everywhere = counts.get(name.as_str()) == Some(&channels.len());
            if !is_everywhere {
                let name = format!("{}/{name}", channel.name);
                attributes.insert(name, value.value());
            } else if std::ptr::eq(channel, first) {
                let values = channels
                    .iter()
                    .filter_map(|other| other.properties.get(name));
                let values: Vec<&Property> = values.collect();
                let name = match name.as_str() {
                    "description" if values.iter().all(|one| *one == value) => "long_name".into(),
                    name => spelled(name),
                };
                attributes.insert(name, together(&values));
            }
        }
    }
    attributes
}

/// One value if all are equal, else all of them.
fn together(values: &[&Property]) -> Value {
    if values.windows(2).all(|pair| pair[0] == pair[1]) {
        return values[0].value();
    }
    let integer = |value: &&Property| match value {
        Property::Integer(integer) => Some(*integer),
        _ => None,
    };
    let number = |value: &&Property| value.number();
    let text = |value: &&Property| match value.value() {
        Value::Text(text) => text,
        Value::Integers(numbers) => numbers[0].to_string(),
        Value::Numbers(numbers) => format!("{numbers:?}"),
        Value::Texts(texts) => texts.join(", "),
    };
    let integers = values.iter().map(integer).collect::<Option<Vec<_>>>();
    let numbers = values.iter().map(number).collect::<Option<Vec<_>>>();
    match (integers, numbers) {
        (Some(integers), _) => Value::Integers(integers),
        (None, Some(numbers)) => Value::Numbers(numbers),
        (None, None) => Value::Texts(values.iter().map(text).collect()),
    }
}
