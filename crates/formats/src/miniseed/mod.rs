//! miniSEED, versions 2 and 3: records of traces.

mod record;
mod steim;

use std::ops::Range;

use indexmap::IndexMap;
use rayon::prelude::*;

use crate::container::{Block, Decoder};
use crate::cursor::Budget;
use crate::sets::{Sets, Traits, others, sets, variables};
use crate::{
    Bytes, Container, Coordinate, Dimension, Error, Format, Options, Remark, Result, Sample, Value,
    Variable, time,
};
use record::{Encoding, Record};

/// Sampling rates that differ less are equal, as in libmseed.
const RATE_TOLERANCE: f64 = 1e-4;
const WAY_OUT: &str = "fill or cut the traces with `Stream.merge` and `Stream.trim` of ObsPy";

/// The format of these bytes, if it is one of this module.
pub(crate) fn detect(bytes: &[u8]) -> Option<Format> {
    let is_record = record::is_version_2(bytes) || record::is_version_3(bytes);
    (is_record || record::is_volume(bytes)).then_some(Format::MiniSeed)
}

/// Records of one name that follow one another.
#[derive(Debug)]
struct Trace {
    name: String,
    /// Each behind the number of samples before it.
    records: Vec<(u64, Record)>,
    len: u64,
    /// What it holds if it is not read.
    other: Option<String>,
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let mut container = Container::new(format, &bytes);
    let (found, skipped) = records((*bytes).as_ref(), options)?;
    if skipped > 0 {
        let skipped = Value::Integers(vec![skipped]);
        container.attributes.insert("skipped_records", skipped);
    }
    let found = found.into_iter();
    let found = found.map(|(name, records)| Trace::joined(name, records));
    let found = found.collect::<Result<Vec<Trace>>>()?.into_iter();
    let (traces, unread): (Vec<_>, Vec<_>) = found.partition(|trace| trace.other.is_none());
    let traces = traces.into_iter().map(|trace| (trace.traits(), trace));
    let left_out = |sets: &Sets<Trace>, traits: &Traits| {
        let unread = unread.iter().filter_map(|trace| {
            let what = trace.other.as_ref().filter(|what| *what != "text")?;
            Some(format!("{} ({what})", trace.name))
        });
        let apart = others(sets, traits, |trace| trace.name.clone());
        Remark::listing("traces that are left out:", apart.chain(unread))
    };
    let path_of = |trace: &Trace| format!("/{}", trace.name);
    for alike in variables(sets(traces), "/traces", path_of, left_out) {
        container.remark_on_next(alike.remark);
        let variable = variable(alike.path, &alike.arrays);
        let (bytes, set) = (Bytes::clone(&bytes), alike.arrays);
        container.push_decoded(variable, Traces { bytes, set });
    }
    for trace in unread {
        let time = Dimension::new(trace.len).named("time");
        let what = trace.other.unwrap_or_default();
        container.push(Variable::other(
            format!("/{}", trace.name),
            vec![time],
            what,
        ));
    }
    Ok(container)
}

/// The records of a file by the names of their traces, in the order of the file, and how many hold no samples.
fn records(bytes: &[u8], options: &Options) -> Result<(IndexMap<String, Vec<Record>>, i64)> {
    let mut found: IndexMap<String, Vec<Record>> = IndexMap::new();
    let mut skipped = 0;
    let mut budget = Budget::new("the places of the records of a miniSEED file", options);
    let mut at = 0;
    while at < bytes.len() {
        // Volumes are padded with zeros.
        if bytes[at] == 0 && at > 0 && bytes[at..].iter().all(|byte| *byte == 0) {
            break;
        }
        let (record, name) = record::read(bytes, at)?;
        at += record.bytes;
        if record.count == 0 {
            skipped += 1;
            continue;
        }
        if !found.contains_key(&name) {
            budget.take(4 * name.len() as u64 + 512)?;
        }
        budget.take(2 * size_of::<(u64, Record)>() as u64)?;
        found.entry(name).or_default().push(record);
    }
    match found.is_empty() {
        true => Err(Error::damaged("the file", "a record with samples", "none")),
        false => Ok((found, skipped)),
    }
}

impl Trace {
    /// The trace of these records.
    ///
    /// # Errors
    /// Records to be read that do not follow one another.
    fn joined(name: String, mut records: Vec<Record>) -> Result<Trace> {
        records.sort_by_key(|record| record.start);
        let first = records[0];
        let sample = first.encoding.sample();
        let other = records.iter().find(|r| r.encoding.sample() != sample);
        let of = |record: &Record| record.encoding.name();
        let other = match (sample, other) {
            (None, _) if first.encoding == Encoding::Text => Some("text".to_owned()),
            (None, _) => Some(format!("samples in {}", of(&first))),
            (_, Some(other)) => Some(format!("samples in {} and {}", of(&first), of(other))),
            _ => None,
        };
        if other.is_none() {
            if !(first.rate > 0.0 && first.rate.is_finite()) {
                let found = format!("{} Hz", first.rate);
                return Err(record::damaged(first.at, "a sampling rate above 0", found));
            }
            let mut pairs = records.windows(2);
            pairs.try_for_each(|pair| follows(&name, &pair[0], &pair[1]))?;
        }
        let mut len = 0;
        let placed = records.into_iter().map(|record| {
            let before = len;
            len += record.count as u64;
            (before, record)
        });
        Ok(Trace {
            name,
            records: placed.collect(),
            len,
            other,
        })
    }

    fn first(&self) -> &Record {
        &self.records[0].1
    }

    fn sample(&self) -> Sample {
        self.first().encoding.sample().unwrap_or(Sample::I32)
    }

    fn traits(&self) -> Traits {
        let first = self.first();
        Traits(vec![
            ("sampling rate", format!("{} Hz", first.rate)),
            ("start", time::text(first.start)),
            ("number of samples", self.len.to_string()),
            ("type", self.sample().name().into()),
        ])
    }

    /// How much later than by the sampling rate its last record begins, in s.
    fn drift(&self) -> f64 {
        let (before, last) = self.records[self.records.len() - 1];
        let passed = last.start.saturating_sub(self.first().start) as f64 / 1e9;
        passed - before as f64 / self.first().rate
    }

    /// Decodes a range of its samples, records in parallel.
    fn decode(&self, bytes: &[u8], range: Range<u64>, mut out: &mut [u8]) -> Result<()> {
        let size = self.sample().bytes();
        let from = self.records.partition_point(|(at, _)| *at <= range.start);
        let mut parts = Vec::new();
        for (first, record) in &self.records[from.saturating_sub(1)..] {
            if *first >= range.end {
                break;
            }
            let start = range.start.max(*first) - first;
            let end = (range.end - first).min(record.count as u64);
            let (part, rest) = out.split_at_mut((end - start) as usize * size);
            parts.push((record, start as usize..end as usize, part));
            out = rest;
        }
        let decode = |(record, range, part): (&Record, Range<usize>, &mut [u8])| {
            record.decode(bytes, range, part)
        };
        parts.into_par_iter().try_for_each(decode)
    }
}

/// Whether `next` begins where `before` ends, to half a sample.
fn follows(name: &str, before: &Record, next: &Record) -> Result<()> {
    let ratio = before.rate / next.rate;
    let at = || time::text(next.start);
    if (ratio - 1.0).abs() > RATE_TOLERANCE || ratio.is_nan() {
        let rates = format!("from {} to {} Hz", before.rate, next.rate);
        let what = format!("the sampling rate of {name} changes {rates} at {}", at());
        return Err(Error::unsupported(what, WAY_OUT));
    }
    let duration = before.count as f64 / before.rate;
    let passed = next.start.saturating_sub(before.start) as f64 / 1e9;
    let late = passed - duration;
    if late.abs() > 0.5 / before.rate {
        let kind = if late > 0.0 { "a gap" } else { "an overlap" };
        let samples = (late.abs() * before.rate).round();
        let what = format!(
            "{kind} of {samples} samples ({} s) in {name} at {}",
            (late.abs() * 1e9).round() / 1e9,
            at()
        );
        return Err(Error::unsupported(what, WAY_OUT));
    }
    Ok(())
}

/// The variable of traces that have a key in common.
fn variable(path: String, set: &[Trace]) -> Variable {
    let first = set[0].first();
    let mut dimensions = vec![Dimension::new(set.len() as u64).named("trace")];
    dimensions.retain(|_| set.len() > 1);
    let time = Dimension::new(set[0].len).named("time");
    dimensions.push(time.at(Coordinate::even(0.0, 1.0 / first.rate, "s")));
    let mut variable = Variable::new(path, dimensions, set[0].sample());
    let attributes = &mut variable.attributes;
    let names = set.iter().map(|trace| trace.name.clone());
    if set.len() > 1 {
        attributes.insert("traces", Value::Texts(names.collect()));
    }
    let codes = set.iter().map(|trace| trace.name.split('.').collect());
    let codes: Vec<Vec<&str>> = codes.collect();
    let names = ["network", "station", "location", "channel"];
    for (place, name) in names.into_iter().enumerate() {
        let codes = codes.iter().filter(|codes| codes.len() == names.len());
        let codes: Vec<Value> = codes
            .map(|codes| Value::Text(codes[place].into()))
            .collect();
        let said = Value::together(&codes.iter().collect::<Vec<_>>());
        let said =
            said.filter(|said| codes.len() == set.len() && *said != Value::Text(String::new()));
        if let Some(said) = said {
            attributes.insert(name, said);
        }
    }
    attributes.insert_text("start_time", time::text(first.start));
    attributes.insert("sampling_rate", Value::Numbers(vec![first.rate]));
    let all = || set.iter().flat_map(|trace| &trace.records);
    if all().all(|(_, record)| record.encoding == first.encoding) {
        attributes.insert_text("encoding", first.encoding.name());
    }
    let drifts = set.iter().map(Trace::drift);
    let drift = drifts.fold(0.0, |max: f64, d| if d.abs() > max.abs() { d } else { max });
    // Each record begins where the last ends, but all of them together need not.
    if drift.abs() > 0.5 / first.rate {
        attributes.insert("clock_drift", Value::Numbers(vec![drift]));
    }
    variable
}

/// The traces of a variable.
struct Traces {
    bytes: Bytes,
    set: Vec<Trace>,
}

impl Decoder for Traces {
    fn read(&self, block: Block, out: &mut [u8]) -> Result<()> {
        let (traces, times) = match block {
            [traces, times] => (traces.clone(), times.clone()),
            _ => (0..1, block[0].clone()),
        };
        let set = &self.set[traces.start as usize..traces.end as usize];
        let rows = out.chunks_exact_mut(out.len() / set.len());
        for (trace, row) in set.iter().zip(rows) {
            trace.decode((*self.bytes).as_ref(), times.clone(), row)?;
        }
        Ok(())
    }
}
