//! The channels of a group as variables.

use std::collections::{HashMap, HashSet};

use super::channel::{Channel, Form, Positions, attributes};
use super::property::Stamp;
use super::samples::Texts;
use crate::container::{Block, Decoder};
use crate::rows::{Pieces, Record, Rows, Scaling};
use crate::sets::{Sets, Traits, others, sets, variables};
use crate::{
    Bytes, Container, Coordinate, Dimension, Error, Place, Remark, Result, Sample, SampleType,
    Value, Variable, time,
};

/// Adds the variables of groups to a container.
pub(super) struct Listing<'a> {
    pub file: &'a Bytes,
    pub container: &'a mut Container,
    pub paths: HashSet<String>,
}

impl Listing<'_> {
    /// Adds the variables of a group.
    pub(super) fn add(&mut self, group: &str, channels: Vec<Channel>) -> Result<()> {
        // The only channel of times of each length.
        let mut times: HashMap<u64, Option<usize>> = HashMap::new();
        let path_of = |channel: &Channel| format!("/{group}/{}", channel.name);
        let all = channels.into_iter();
        let (of_time, others): (Vec<_>, Vec<_>) = all.partition(Channel::is_time);
        for channel in of_time {
            let place = self.container.variables.len();
            let found = times.entry(channel.len());
            found
                .and_modify(|found| *found = None)
                .or_insert(Some(place));
            self.add_set(path_of(&channel), vec![channel], None)?;
        }
        let all = others.into_iter();
        let (alone, together): (Vec<_>, Vec<_>) = all.partition(|one| one.is_alone().is_some());
        let together = together.into_iter();
        let together = together.map(|channel| (channel.traits(), channel));
        let remark =
            |sets: &Sets<Channel>, traits: &Traits| remark(&sets[traits], sets, traits, &alone);
        for set in variables(sets(together), &format!("/{group}"), path_of, remark) {
            self.container.remark_on_next(set.remark);
            let listed = times.get(&set.arrays[0].len()).copied().flatten();
            self.add_set(set.path, set.arrays, listed)?;
        }
        for channel in alone {
            let listed = times.get(&channel.len()).copied().flatten();
            self.add_set(path_of(&channel), vec![channel], listed)?;
        }
        Ok(())
    }

    /// Adds the variable of channels that are alike, and those of their positions.
    fn add_set(
        &mut self,
        path: String,
        mut channels: Vec<Channel>,
        times: Option<usize>,
    ) -> Result<()> {
        let path = self.unused(path);
        let place = self.container.variables.len();
        let time = channels[0].dimension(times);
        let mut variable = Variable::new(path.clone(), vec![time], Sample::F64);
        variable.attributes = attributes(&channels);
        let positions = match channels.len() {
            1 => Positions::default(),
            _ => Positions::of(&channels),
        };
        let bare = Dimension::new(channels.len() as u64).named("channel");
        let mut channel = bare.clone();
        let coordinate = positions.coordinate;
        channel.coordinate = coordinate.map(|axis| Coordinate::Listed(place + 1 + axis));
        if let Some(differ) = positions.differ {
            let text = format!("the units of the property {differ} of the channels differ");
            variable.attributes.insert_text("positions", text);
        }
        match &channels[0].form {
            Form::Numbers(..) => {
                let rows = numbers(self.file, channels, &mut variable);
                if rows.records.len() > 1 {
                    let at = if rows.is_time_first { 1 } else { 0 };
                    variable.dimensions.insert(at, channel);
                }
                self.container.push_decoded(variable, rows);
            }
            Form::Time => {
                variable.attributes.insert_text("units", time::UNIT);
                variable.sample_type = SampleType::Number(Sample::I64);
                let pieces = std::mem::take(&mut channels[0].pieces);
                let file = Bytes::clone(self.file);
                let times = Times { path, file, pieces };
                self.container.push_decoded(variable, times);
                return Ok(());
            }
            Form::Other(what) => {
                let chunks = &channels[0].texts;
                if let Some(texts) = texts((**self.file).as_ref(), chunks)?
                    && !chunks.is_empty()
                {
                    self.container.attributes.insert(path, Value::Texts(texts));
                }
                variable.sample_type = SampleType::Other(what.clone());
                self.container.push(variable);
                return Ok(());
            }
        }
        for (name, unit, values) in positions.listed {
            let path = self.unused(format!("{path}/{name}"));
            let unit = unit.unwrap_or_default();
            self.container.push_floats(path, &bare, &unit, values);
        }
        Ok(())
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
fn remark(
    channels: &[Channel],
    sets: &Sets<Channel>,
    traits: &Traits,
    alone: &[Channel],
) -> Option<String> {
    let name = |channel: &Channel| format!("{:?}", channel.name);
    let unread = alone.iter().filter_map(|channel| {
        let why = channel.is_alone().filter(|why| *why != "text")?;
        Some(format!("{} ({why})", name(channel)))
    });
    let apart = others(sets, traits, name).chain(unread);
    let apart = Remark::listing("channels of the group that are left out:", apart);
    let integer = |channel: &Channel| channel.unscaled().filter(|sample| !sample.is_float());
    let is_mixed = channels.iter().any(|channel| integer(channel).is_none());
    let integers = channels.iter().filter(|_| is_mixed).filter_map(|channel| {
        let sample = integer(channel)?.name();
        Some(format!("{} ({sample})", name(channel)))
    });
    let integers = Remark::listing("unscaled integers beside floats:", integers);
    let said: Vec<String> = [apart, integers].into_iter().flatten().collect();
    (!said.is_empty()).then(|| said.join("; "))
}

/// The samples of channels of numbers: as they are stored if all are of one type and scaled alike, else scaled.
fn numbers(file: &Bytes, channels: Vec<Channel>, variable: &mut Variable) -> Rows {
    let of = |channel: &Channel| match &channel.form {
        Form::Numbers(sample, scaling) => (*sample, scaling.clone()),
        _ => (Sample::F64, Scaling::default()),
    };
    let first = of(&channels[0]);
    let is_alike = channels.iter().all(|channel| of(channel) == first);
    let linear = first.1.linear().filter(|_| is_alike);
    if let Some([slope, intercept]) = linear.filter(|linear| *linear != [1.0, 0.0]) {
        let attributes = &mut variable.attributes;
        attributes.insert("scale_factor", Value::Numbers(vec![slope]));
        attributes.insert("add_offset", Value::Numbers(vec![intercept]));
    }
    let records = channels.into_iter().map(|channel| {
        let (sample, scaling) = of(&channel);
        Record {
            pieces: channel.pieces,
            sample: Some(sample),
            scaling: linear.map_or(scaling, |_| Scaling::default()),
            held: None,
        }
    });
    let mut rows = Rows {
        path: variable.path.clone(),
        file: Bytes::clone(file),
        records: records.collect(),
        sample: linear.map_or(Sample::F64, |_| first.0),
        is_time_first: false,
    };
    let is_single = rows.records.len() == 1;
    variable.sample_type = SampleType::Number(rows.sample);
    variable.place = match rows.strided() {
        Some(mut strided) => {
            strided.strides.drain(..usize::from(is_single));
            Place::Strided(strided)
        }
        None => {
            // Samples of other channels between those of one are best read together.
            let size = first.0.bytes() as u64;
            let (count, is_between) = rows.records[0].pieces.first_chunk(size);
            rows.is_time_first = is_between && !is_single;
            let rows = if rows.is_time_first { count } else { 1 };
            Place::Encoded { rows }
        }
    };
    rows
}

/// Texts of a channel that are listed; longer ones are only named.
const MOST_TEXT: u64 = 1 << 20;

/// The times of a channel, read as nanoseconds since 1970.
struct Times {
    path: String,
    file: Bytes,
    pieces: Pieces,
}

impl Decoder for Times {
    fn read(&self, block: Block, out: &mut [u8]) -> Result<()> {
        let bytes = (*self.file).as_ref();
        let mut out = out.chunks_exact_mut(8);
        for run in self.pieces.runs(block[0].clone()) {
            for (i, out) in (0..run.count).zip(&mut out) {
                let from = (run.start + i * run.step) as usize;
                let stamp = Stamp::read(run.order, &bytes[from..]);
                let nanoseconds = stamp.nanoseconds().ok_or_else(|| {
                    let place = format!("variable {}", self.path);
                    let found = format!("{} s since 1904", stamp.seconds);
                    Error::damaged(place, "times from 1677 to 2262", found)
                })?;
                out.copy_from_slice(&nanoseconds.to_ne_bytes());
            }
        }
        Ok(())
    }
}

/// The texts of a channel; none if they are long.
fn texts(bytes: &[u8], chunks: &[Texts]) -> Result<Option<Vec<String>>> {
    if chunks.iter().map(|chunk| chunk.bytes).sum::<u64>() > MOST_TEXT {
        return Ok(None);
    }
    let mut texts = Vec::new();
    for chunk in chunks {
        let all = &bytes[chunk.start as usize..][..chunk.bytes as usize];
        let (ends, characters) = all.split_at(4 * chunk.count as usize);
        let mut from = 0;
        for end in ends.chunks_exact(4) {
            let to = chunk.order.unsigned(end) as usize;
            let Some(text) = characters.get(from..to) else {
                let expected = format!("texts of {} bytes", characters.len());
                let place = format!("the texts at byte {}", chunk.start);
                return Err(Error::damaged(place, expected, format!("{from} to {to}")));
            };
            texts.push(String::from_utf8_lossy(text).into_owned());
            from = to;
        }
    }
    Ok(Some(texts))
}
