//! The channels of a group as variables.

use std::collections::{HashMap, HashSet};

use super::channel::{Channel, Form, Key, Positions, attributes};
use super::decode::{Channels, OneChannel, Source, Stored};
use super::pieces::Run;
use super::samples::Texts;
use super::scale::Scaling;
use crate::{
    Attributes, Coordinate, Dimension, Place, Remark, Sample, SampleType, Value, Variable, time,
};

/// All variables of a file and where their samples come from.
#[derive(Debug, Default)]
pub(super) struct Listing {
    pub variables: Vec<Variable>,
    pub sources: Vec<Source>,
    /// Paths and places of texts.
    pub texts: Vec<(String, Vec<Texts>)>,
    pub remarks: Vec<Remark>,
    paths: HashSet<String>,
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
        let remarks: Vec<Option<String>> = (0..sets.len()).map(|set| remark(&sets, set)).collect();
        let mut number = 0;
        for (set, remark) in sets.into_iter().zip(remarks) {
            let variable = Some(self.variables.len());
            self.remarks
                .extend(remark.map(|text| Remark { variable, text }));
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
            Form::Numbers(..) => {
                let (sample, channels, place) = numbers(&path, channels, &mut attributes);
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
                        .map(|channel| OneChannel {
                            pieces: channel.pieces,
                            sample: Sample::I64,
                            scaling: Scaling::default(),
                        })
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

/// What is said of a set of channels about others of its group that are no part of it, and about some of
/// another type that are.
fn remark(sets: &[Vec<Channel>], set: usize) -> Option<String> {
    let channels = &sets[set];
    let key = channels[0].key().filter(|_| channels.len() > 1)?;
    let others = sets.iter().enumerate().filter(|(other, _)| *other != set);
    let apart = others.flat_map(|(_, others)| others).filter_map(|channel| {
        let why = key.differs(channel)?;
        Some(format!("{:?} ({why})", channel.name))
    });
    let apart = Remark::listing("channels of the group that are left out:", apart);
    let is_float = |sample: &Sample| matches!(sample, Sample::F16 | Sample::F32 | Sample::F64);
    let integer = |channel: &Channel| match channel.form {
        Form::Numbers(sample, None) if !is_float(&sample) => Some(sample),
        _ => None,
    };
    let is_mixed = channels.iter().any(|channel| integer(channel).is_none());
    let integers = channels.iter().filter(|_| is_mixed).filter_map(|channel| {
        let sample = integer(channel)?.name();
        Some(format!("{:?} ({sample})", channel.name))
    });
    let integers = Remark::listing("unscaled integers beside floats:", integers);
    let said: Vec<String> = [apart, integers].into_iter().flatten().collect();
    (!said.is_empty()).then(|| said.join("; "))
}

/// The samples of channels of numbers: in place if all lie at even distances and are of one type and scaled
/// alike.
fn numbers(
    path: &str,
    channels: Vec<Channel>,
    attributes: &mut Attributes,
) -> (Sample, Channels, Place) {
    let of = |channel: &Channel| match &channel.form {
        Form::Numbers(sample, scaling) => (*sample, scaling.clone().unwrap_or_default()),
        _ => (Sample::F64, Scaling::default()),
    };
    let first = of(&channels[0]);
    let is_alike = channels.iter().all(|channel| of(channel) == first);
    let (sample, scaling) = first;
    let stored = match scaling.linear().filter(|_| is_alike) {
        Some([slope, intercept]) => {
            if [slope, intercept] != [1.0, 0.0] {
                attributes.insert("scale_factor", Value::Numbers(vec![slope]));
                attributes.insert("add_offset", Value::Numbers(vec![intercept]));
            }
            Stored::Number(sample)
        }
        None => Stored::Scaled,
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
        Stored::Number(sample) => sample,
        _ => Sample::F64,
    };
    let channels = Channels {
        path: path.to_owned(),
        channels: channels
            .into_iter()
            .map(|channel| {
                let (sample, scaling) = of(&channel);
                OneChannel {
                    pieces: channel.pieces,
                    sample,
                    scaling,
                }
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
    let alike = |run: &Run| run.order == first.order && (first.count == 1 || run.step == step);
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
