//! The channels of a group as variables.

use std::collections::{HashMap, HashSet};

use super::decode::{Channels, Source, Stored};
use super::pieces::Pieces;
use super::property::{Properties, Property, Stamp, split_unit};
use super::scale::{Foreign, Scaling};
use super::segments::{Kind, Object, Texts};
use crate::{Attributes, Coordinate, Dimension, Place, Sample, SampleType, Value, Variable, time};

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
    name: String,
    properties: Properties,
    pieces: Pieces,
    texts: Vec<Texts>,
    form: Form,
    axis: Axis,
    unit: Option<String>,
}

/// What the samples of a channel become.
#[derive(Debug)]
enum Form {
    Numbers(Sample, Option<Scaling>),
    Time,
    Text,
    Other(String),
}

/// The times of samples, as the properties of a waveform state them.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Axis {
    /// Bits of origin and step; none without a step.
    even: Option<[u64; 2]>,
    unit: String,
    start: Option<Stamp>,
}

/// What channels of one variable have in common.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Key {
    sample: Sample,
    is_scaled: bool,
    len: u64,
    axis: Axis,
    unit: Option<String>,
}

/// All variables of a file and where their samples come from.
#[derive(Debug, Default)]
pub(super) struct Listing {
    pub variables: Vec<Variable>,
    pub sources: Vec<Source>,
    /// Paths and places of texts.
    pub texts: Vec<(String, Vec<Texts>)>,
    paths: HashSet<String>,
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

    fn len(&self) -> u64 {
        let texts = self.texts.iter().map(|chunk| chunk.count);
        self.pieces.len() + texts.sum::<u64>()
    }

    /// Whether it holds the times of others.
    fn is_time(&self) -> bool {
        let name = split_unit(&self.name).0.to_ascii_lowercase();
        match self.form {
            Form::Time => true,
            Form::Numbers(..) => TIMES.contains(&name.as_str()),
            _ => false,
        }
    }

    /// What it must share with others of the same variable; none for one of its own.
    fn key(&self) -> Option<Key> {
        match &self.form {
            Form::Numbers(sample, scaling) if self.len() > 0 => Some(Key {
                sample: *sample,
                is_scaled: scaling.is_some(),
                len: self.len(),
                axis: self.axis.clone(),
                unit: self.unit.clone(),
            }),
            _ => None,
        }
    }
}

impl Axis {
    fn of(properties: &Properties) -> Axis {
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
    fn dimension(&self, len: u64, listed: Option<usize>) -> Dimension {
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

impl Listing {
    /// Adds the variables of a group.
    pub(super) fn add(&mut self, group: &str, channels: Vec<Channel>) {
        // The only channel of times of each length.
        let mut times: HashMap<u64, Option<usize>> = HashMap::new();
        let (of_time, others) = channels
            .into_iter()
            .partition::<Vec<_>, _>(Channel::is_time);
        for channel in of_time {
            let place = self.variables.len();
            let once = |found: &mut Option<usize>| *found = None;
            let len = channel.len();
            times.entry(len).and_modify(once).or_insert(Some(place));
            self.add_set(format!("/{group}/{}", channel.name), vec![channel], None);
        }
        let mut sets: Vec<Vec<Channel>> = Vec::new();
        let mut places: HashMap<Key, usize> = HashMap::new();
        for channel in others {
            match channel
                .key()
                .map(|key| *places.entry(key).or_insert(sets.len()))
            {
                Some(place) if place < sets.len() => sets[place].push(channel),
                _ => sets.push(vec![channel]),
            }
        }
        let several = sets.iter().filter(|set| set.len() > 1).count();
        let mut number = 0;
        for set in sets {
            let path = match &set[..] {
                [channel] => format!("/{group}/{}", channel.name),
                _ if several == 1 => format!("/{group}"),
                _ => {
                    number += 1;
                    format!("/{group}/{number}")
                }
            };
            let listed = times.get(&set[0].len()).copied().flatten();
            self.add_set(path, set, listed);
        }
    }

    /// Adds the variable of channels that have a key in common, and those of their positions.
    fn add_set(&mut self, path: String, channels: Vec<Channel>, times: Option<usize>) {
        let first = &channels[0];
        let time = first.axis.dimension(first.len(), times);
        let mut attributes = attributes(&channels);
        let positions = match channels.len() {
            1 => Positions::default(),
            _ => Positions::of(&channels),
        };
        let place = self.variables.len();
        let channel = Dimension {
            coordinate: positions
                .coordinate
                .map(|axis| Coordinate::Listed(place + 1 + axis)),
            ..Dimension::new(channels.len() as u64).named("channel")
        };
        if let Some(differ) = positions.differ {
            let text = format!("the units of the property {differ} of the channels differ");
            attributes.insert_text("positions", text);
        }
        let path = self.unused(path);
        let mut dimensions = vec![time];
        let (sample_type, source, place) = match &first.form {
            Form::Numbers(sample, _) => {
                let (sample, channels, place) = numbers(&path, *sample, channels, &mut attributes);
                if let [_, _, ..] = channels.channels[..] {
                    let at = if channels.is_time_first { 1 } else { 0 };
                    dimensions.insert(at, channel.clone());
                }
                (
                    SampleType::Number(sample),
                    Source::Channels(channels),
                    place,
                )
            }
            Form::Time => {
                attributes.insert_text("units", time::UNIT);
                let source = Channels {
                    path: path.clone(),
                    channels: channels
                        .into_iter()
                        .map(|channel| (channel.pieces, Scaling::default()))
                        .collect(),
                    stored: Stored::Time,
                    is_time_first: false,
                };
                let encoded = Place::Encoded { rows: 1 };
                (
                    SampleType::Number(Sample::I64),
                    Source::Channels(source),
                    encoded,
                )
            }
            form => {
                let what = match form {
                    Form::Other(what) => what.clone(),
                    _ => "text".to_owned(),
                };
                let texts = channels.into_iter().map(|channel| channel.texts);
                let texts = texts.filter(|texts| !texts.is_empty());
                self.texts.extend(texts.map(|texts| (path.clone(), texts)));
                (
                    SampleType::Other(what),
                    Source::None,
                    Place::Encoded { rows: 1 },
                )
            }
        };
        self.variables.push(Variable {
            path: path.clone(),
            dimensions,
            sample_type,
            attributes,
            place,
        });
        self.sources.push(source);
        for (name, unit, values) in positions.listed {
            let mut attributes = Attributes::default();
            attributes.insert_text("units", unit.unwrap_or_default());
            let along = Dimension {
                coordinate: None,
                ..channel.clone()
            };
            let path = self.unused(format!("{path}/{name}"));
            self.variables.push(Variable {
                path,
                dimensions: vec![along],
                sample_type: SampleType::Number(Sample::F64),
                attributes,
                place: Place::Encoded { rows: channel.len },
            });
            self.sources.push(Source::Held(values));
        }
    }

    /// The path, changed if a variable has it.
    fn unused(&mut self, mut path: String) -> String {
        while !self.paths.insert(path.clone()) {
            path.push('\'');
        }
        path
    }
}

/// The samples of channels of numbers: in place if all lie at even distances and are scaled alike.
fn numbers(
    path: &str,
    sample: Sample,
    channels: Vec<Channel>,
    attributes: &mut Attributes,
) -> (Sample, Channels, Place) {
    let scaling = |channel: &Channel| match &channel.form {
        Form::Numbers(_, Some(scaling)) => scaling.clone(),
        _ => Scaling::default(),
    };
    let first = scaling(&channels[0]);
    let is_alike = channels.iter().all(|channel| scaling(channel) == first);
    let stored = match first.linear().filter(|_| is_alike) {
        Some([slope, intercept]) => {
            if [slope, intercept] != [1.0, 0.0] {
                attributes.insert("scale_factor", Value::Numbers(vec![slope]));
                attributes.insert("add_offset", Value::Numbers(vec![intercept]));
            }
            Stored::Number(sample)
        }
        None => Stored::Scaled(sample),
    };
    let in_place = strided(sample, &channels).filter(|_| stored == Stored::Number(sample));
    let (count, is_between) = channels[0].pieces.first_chunk(sample.bytes() as u64);
    let (is_time_first, place) = match in_place {
        Some((is_time_first, place)) => (is_time_first, place),
        None => {
            let is_time_first = is_between && channels.len() > 1;
            let rows = if is_time_first { count } else { 1 };
            (is_time_first, Place::Encoded { rows })
        }
    };
    let decoded = match stored {
        Stored::Scaled(_) => Sample::F64,
        _ => sample,
    };
    let channels = Channels {
        path: path.to_owned(),
        channels: channels
            .into_iter()
            .map(|channel| {
                let scaling = scaling(&channel);
                (channel.pieces, scaling)
            })
            .collect(),
        stored,
        is_time_first,
    };
    (decoded, channels, place)
}

/// Where samples lie in the file, if they do at even distances, and whether those of a time are closer.
fn strided(sample: Sample, channels: &[Channel]) -> Option<(bool, Place)> {
    let size = sample.bytes() as u64;
    let runs = channels.iter().map(|channel| channel.pieces.only_run());
    let runs = runs.collect::<Option<Vec<_>>>()?;
    let first = runs[0];
    // A single sample has no step.
    let step = if first.count == 1 { size } else { first.step };
    let alike = |run: &super::pieces::Run| {
        run.order == first.order && (first.count == 1 || run.step == step)
    };
    let across = match runs.get(1) {
        Some(second) => second.start.checked_sub(first.start)?,
        None => size,
    };
    let is_even = runs
        .windows(2)
        .all(|pair| pair[1].start.checked_sub(pair[0].start) == Some(across));
    if !is_even || !runs.iter().all(alike) {
        return None;
    }
    let is_time_first = channels.len() > 1 && across < step;
    let strides = match (channels.len(), is_time_first) {
        (1, _) => vec![step],
        (_, true) => vec![step, across],
        (_, false) => vec![across, step],
    };
    let place = Place::Strided {
        start: first.start,
        strides,
        order: first.order,
    };
    Some((is_time_first, place))
}

/// Positions of channels.
#[derive(Debug, Default)]
struct Positions {
    /// Name, unit and values; NaN for a channel without one.
    listed: Vec<(&'static str, Option<String>, Vec<f64>)>,
    /// Which of them is the coordinate of the channels.
    coordinate: Option<usize>,
    /// One that has several units.
    differ: Option<&'static str>,
}

impl Positions {
    fn of(channels: &[Channel]) -> Positions {
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
fn attributes(channels: &[Channel]) -> Attributes {
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
