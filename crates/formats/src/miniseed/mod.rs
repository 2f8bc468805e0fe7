//! miniSEED, versions 2 and 3: records of traces.

mod record;
mod steim;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::{
    Attributes, Block, Bytes, Container, Coordinate, Decoder, Dimension, Error, Format, Options,
    Place, Remark, Result, Sample, SampleType, Value, Variable, time,
};
use record::{Encoding, Record};

/// Sampling rates that differ less are equal, as in libmseed.
const RATE_TOLERANCE: f64 = 1e-4;
const WAY_OUT: &str = "fill or cut the traces with `Stream.merge` and `Stream.trim` of ObsPy";

/// The format of a file with this extension (lower case) and these bytes, if it is one of this module.
pub(crate) fn detect(extension: &str, bytes: &[u8]) -> Option<Format> {
    let is_record = record::is_version_2(bytes) || record::is_version_3(bytes);
    let is_named = matches!(extension, "mseed" | "miniseed" | "msd" | "mseed3");
    (is_record || is_named || record::is_volume(bytes)).then_some(Format::MiniSeed)
}

/// Records of one name that follow one another.
#[derive(Debug)]
struct Trace {
    name: String,
    /// Each behind the number of samples before it.
    records: Vec<(u64, Record)>,
    len: u64,
}

/// What traces of one variable have in common.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Key {
    sample: Sample,
    rate: u64,
    start: i64,
    len: u64,
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let held = Arc::clone(&bytes);
    let found = Found::read((*held).as_ref(), options)?;
    let mut attributes = Attributes::default();
    if found.skipped > 0 {
        let skipped = i64::try_from(found.skipped).unwrap_or(i64::MAX);
        attributes.insert("skipped_records", Value::Integers(vec![skipped]));
    }
    let mut sets: Vec<Vec<Trace>> = Vec::new();
    let mut places: HashMap<Key, usize> = HashMap::new();
    let mut others = Vec::new();
    for (name, records) in found.traces {
        match Trace::joined(name, records)? {
            Ok(trace) => {
                let place = *places.entry(trace.key()).or_insert(sets.len());
                if place == sets.len() {
                    sets.push(Vec::new());
                }
                sets[place].push(trace);
            }
            Err(other) => others.push(other),
        }
    }
    let several = sets.iter().filter(|set| set.len() > 1).count();
    let mut number = 0;
    let (mut variables, mut remarks) = (Vec::new(), Vec::new());
    for set in &sets {
        if set.len() > 1 {
            let text = left_out(set, &sets, &others);
            let variable = Some(variables.len());
            remarks.extend(text.map(|text| Remark { variable, text }));
        }
        let path = match &set[..] {
            [trace] => format!("/{}", trace.name),
            _ if several == 1 => "/traces".to_owned(),
            _ => {
                number += 1;
                format!("/traces/{number}")
            }
        };
        variables.push(variable(path, set));
    }
    variables.extend(others);
    let decoder = MiniSeedDecoder {
        bytes: Arc::clone(&held),
        sets,
    };
    let mut container = Container::new(format, bytes, Some(Box::new(decoder)));
    container.attributes = attributes;
    container.variables = variables;
    container.remarks = remarks;
    Ok(container)
}

/// What is said of a set of traces about others of the file that are no part of it.
fn left_out(set: &[Trace], sets: &[Vec<Trace>], others: &[Variable]) -> Option<String> {
    let own = set[0].key();
    let apart = sets.iter().flatten().filter_map(|trace| {
        let key = trace.key();
        let why = match () {
            _ if key == own => return None,
            _ if key.rate != own.rate => {
                let rates = [key.rate, own.rate].map(f64::from_bits);
                format!("{} Hz, not {}", rates[0], rates[1])
            }
            _ if key.start != own.start => format!("starts at {}", time::text(key.start)),
            _ if key.len != own.len => format!("{} samples, not {}", key.len, own.len),
            _ => format!("{}, not {}", key.sample.name(), own.sample.name()),
        };
        Some(format!("{} ({why})", trace.name))
    });
    let others = others.iter().filter_map(|other| match &other.sample_type {
        SampleType::Other(what) if what != "text" => {
            Some(format!("{} ({what})", other.path.trim_start_matches('/')))
        }
        _ => None,
    });
    Remark::listing("traces that are left out:", apart.chain(others))
}

/// The records of a file by the names of their traces, in the order of the file.
struct Found {
    traces: Vec<(String, Vec<Record>)>,
    /// Records without samples.
    skipped: u64,
}

impl Found {
    fn read(bytes: &[u8], options: &Options) -> Result<Found> {
        let mut found = Found {
            traces: Vec::new(),
            skipped: 0,
        };
        let mut places: HashMap<String, usize> = HashMap::new();
        let mut used = 0u64;
        let mut at = 0;
        while at < bytes.len() {
            // Volumes are padded with zeros.
            if bytes[at] == 0 && at > 0 && bytes[at..].iter().all(|byte| *byte == 0) {
                break;
            }
            let (record, name) = record::read(bytes, at)?;
            at += record.bytes;
            if record.count == 0 {
                found.skipped += 1;
                continue;
            }
            let place = *places.entry(name.clone()).or_insert(found.traces.len());
            if place == found.traces.len() {
                used += 4 * name.len() as u64 + 512;
                found.traces.push((name, Vec::new()));
            }
            used += 2 * size_of::<(u64, Record)>() as u64;
            if let Some(allowed) = options.memory.filter(|allowed| used > *allowed) {
                return Err(Error::Memory {
                    what: "the places of the records of a miniSEED file".into(),
                    needed: used,
                    allowed,
                });
            }
            found.traces[place].1.push(record);
        }
        if found.traces.is_empty() {
            return Err(Error::damaged("the file", "a record with samples", "none"));
        }
        Ok(found)
    }
}

impl Trace {
    /// The trace of these records, or the variable that lists what is not read.
    fn joined(
        name: String,
        mut records: Vec<Record>,
    ) -> Result<std::result::Result<Trace, Variable>> {
        records.sort_by_key(|record| record.start);
        let first = records[0];
        let sample = first.encoding.sample();
        let other = records.iter().find(|r| r.encoding.sample() != sample);
        let what = match (sample, other) {
            (None, _) if first.encoding == Encoding::Text => Some("text".to_owned()),
            (None, _) => Some(format!("samples in {}", first.encoding.name())),
            (Some(_), Some(other)) => {
                let names = [first.encoding.name(), other.encoding.name()];
                Some(format!("samples in {} and {}", names[0], names[1]))
            }
            (Some(_), None) => None,
        };
        if let Some(what) = what {
            let len = records.iter().map(|record| record.count as u64).sum();
            return Ok(Err(Variable {
                path: format!("/{name}"),
                dimensions: vec![Dimension::new(len).named("time")],
                sample_type: SampleType::Other(what),
                attributes: Attributes::default(),
                place: Place::Encoded { rows: 1 },
            }));
        }
        if !(first.rate > 0.0 && first.rate.is_finite()) {
            let place = format!("the record at byte {}", first.at);
            let found = format!("{} Hz", first.rate);
            return Err(Error::damaged(place, "a sampling rate above 0", found));
        }
        let mut len = 0;
        let mut placed: Vec<(u64, Record)> = Vec::with_capacity(records.len());
        for record in records {
            if let Some((_, before)) = placed.last() {
                follows(&name, before, &record)?;
            }
            placed.push((len, record));
            len += record.count as u64;
        }
        Ok(Ok(Trace {
            name,
            records: placed,
            len,
        }))
    }

    fn first(&self) -> &Record {
        &self.records[0].1
    }

    fn key(&self) -> Key {
        let first = self.first();
        Key {
            sample: first.encoding.sample().unwrap_or(Sample::I32),
            rate: first.rate.to_bits(),
            start: first.start,
            len: self.len,
        }
    }

    /// How much later than by the sampling rate its last record begins, in s.
    fn drift(&self) -> f64 {
        let (before, last) = self.records[self.records.len() - 1];
        let passed = last.start.saturating_sub(self.first().start) as f64 / 1e9;
        passed - before as f64 / self.first().rate
    }

    /// Decodes a range of its samples, records in parallel.
    fn decode(
        &self,
        bytes: &[u8],
        range: Range<u64>,
        size: usize,
        mut out: &mut [u8],
    ) -> Result<()> {
        let from = self
            .records
            .partition_point(|(first, _)| *first <= range.start);
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
    let mut attributes = Attributes::default();
    let names = set.iter().map(|trace| trace.name.clone());
    if set.len() > 1 {
        attributes.insert("traces", Value::Texts(names.collect()));
    }
    for (place, code) in ["network", "station", "location", "channel"]
        .into_iter()
        .enumerate()
    {
        let of = |trace: &Trace| {
            let codes: Vec<&str> = trace.name.split('.').collect();
            codes
                .get(place)
                .filter(|_| codes.len() == 4)
                .map(|code| (*code).to_owned())
        };
        let Some(codes) = set.iter().map(of).collect::<Option<Vec<_>>>() else {
            continue;
        };
        match codes.iter().all(|code| *code == codes[0]) {
            true => attributes.insert_text(code, codes[0].clone()),
            false => attributes.insert(code, Value::Texts(codes)),
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
    let mut dimensions = vec![
        Dimension::new(set[0].len)
            .named("time")
            .at(Coordinate::Even {
                origin: 0.0,
                step: 1.0 / first.rate,
                unit: Some("s".into()),
            }),
    ];
    if set.len() > 1 {
        dimensions.insert(0, Dimension::new(set.len() as u64).named("trace"));
    }
    Variable {
        path,
        dimensions,
        sample_type: SampleType::Number(set[0].key().sample),
        attributes,
        place: Place::Encoded { rows: 1 },
    }
}

struct MiniSeedDecoder {
    bytes: Bytes,
    sets: Vec<Vec<Trace>>,
}

impl Decoder for MiniSeedDecoder {
    fn read(&self, variable: usize, block: Block, out: &mut [u8]) -> Result<()> {
        let Some(set) = self.sets.get(variable) else {
            return Ok(());
        };
        let (traces, times) = match block {
            [traces, times] => (traces.clone(), times.clone()),
            _ => (0..1, block[0].clone()),
        };
        let set = &set[traces.start as usize..traces.end as usize];
        let rows = out.chunks_exact_mut(out.len() / set.len());
        for (trace, row) in set.iter().zip(rows) {
            let size = row.len() / (times.end - times.start) as usize;
            trace.decode((*self.bytes).as_ref(), times.clone(), size, row)?;
        }
        Ok(())
    }
}
