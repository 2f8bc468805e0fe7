//! A second opinion on what was read of a file: how many records and samples it holds by a count of its own, and the
//! same samples by other paths.
//!
//! Counts follow the descriptions of the formats and share no code with the readers. They know less: a count that
//! cannot be made is no opinion.

use std::collections::BTreeSet;
use std::ops::Range;

use wavecascade_formats::{ByteOrder, Container, Format, Place, SampleType, Variable};

/// Most samples of a variable that are read again.
const FEW: u64 = 1 << 14;

/// Where what was read and the second opinion differ.
pub fn disagreement(container: &Container, bytes: &[u8]) -> Option<String> {
    counts(container, bytes).or_else(|| other_paths(container, bytes))
}

/// What is compared of a format.
enum Count {
    /// Records, all of them in some variable.
    Records(u64),
    /// Samples of all records.
    Samples(u64),
}

fn counts(container: &Container, bytes: &[u8]) -> Option<String> {
    let count = match container.format {
        Format::Uff => Count::Records(uff(bytes)?),
        Format::Tdms => Count::Records(tdms(bytes)?),
        Format::MiniSeed => Count::Samples(miniseed(bytes)?),
        Format::SegY => Count::Samples(segy(bytes)?),
        Format::SeismicUnix => Count::Samples(seismic_unix(bytes)?),
        Format::Lammps => Count::Records(lammps(bytes)),
        _ => return None,
    };
    let variables = || container.variables.iter();
    match count {
        Count::Samples(expected) => {
            let has_all = variables().all(|variable| variable.sample_type.number().is_some());
            let of_traces = variables().filter(|variable| {
                container.format == Format::MiniSeed || variable.path == "/traces"
            });
            let found: u64 = of_traces.filter_map(Variable::count).sum();
            let differ = has_all && found != expected;
            differ.then(|| format!("{found} samples were read of {expected}"))
        }
        Count::Records(expected) => {
            let of = |variable: &Variable| records(container.format, variable);
            let found = match container.format {
                Format::Lammps => variables().map(of).max().unwrap_or(0),
                _ => variables().map(of).sum(),
            };
            // Of a file whose samples are cut off nothing can be read.
            if found != expected && found > 0 {
                return Some(format!("{found} records were read of {expected}"));
            }
            // A variable without the records of another one says so.
            let silent = variables().enumerate().find(|(at, variable)| {
                let n = of(variable);
                let said = container.remarks.iter().any(|r| r.variable == Some(*at));
                container.format == Format::Uff
                    && n > 1
                    && n < expected
                    && !said
                    && is_like(container, *at)
            });
            silent.map(|(_, variable)| {
                format!(
                    "{} has {} of {expected} records, and nothing is said",
                    variable.path,
                    of(variable)
                )
            })
        }
    }
}

/// Whether another variable measures the same, so that its records belong to this one.
fn is_like(container: &Container, at: usize) -> bool {
    let own = &container.variables[at];
    let is_record = |variable: &Variable| variable.path.starts_with("/records");
    let mut others = container.variables.iter().enumerate();
    let function = |variable: &Variable| format!("{:?}", variable.attributes.get("function_type"));
    is_record(own)
        && others.any(|(other, variable)| {
            other != at && is_record(variable) && function(variable) == function(own)
        })
}

/// Records of a variable; none of one that describes the records of another.
fn records(format: Format, variable: &Variable) -> u64 {
    let len = |name: &str| {
        let mut dimensions = variable.dimensions.iter();
        let found = dimensions.find(|d| d.name.as_deref() == Some(name));
        found.map(|dimension| dimension.len)
    };
    let is_list = variable.dimensions.len() == 1;
    let is_none = ["text", "no samples"]
        .map(|what| SampleType::Other(what.into()))
        .contains(&variable.sample_type);
    match format {
        Format::Uff => match variable.path.starts_with("/records") {
            true => len("record").unwrap_or(0),
            false => 0,
        },
        Format::Tdms if is_none => 0,
        Format::Tdms => match (len("channel"), is_list) {
            (Some(_), true) => 0,
            (Some(channels), false) => channels,
            (None, _) => 1,
        },
        _ => len("time").unwrap_or(0),
    }
}

/// Data sets 58 and 58b of a universal file.
fn uff(bytes: &[u8]) -> Option<u64> {
    let mut at = 0;
    let mut lines = 0..0;
    let mut next = |at: &mut usize| -> Option<Range<usize>> {
        let rest = bytes.get(*at..).filter(|rest| !rest.is_empty())?;
        let end = rest.iter().position(|b| *b == b'\n');
        lines = *at..*at + end.unwrap_or(rest.len());
        *at = (lines.end + 1).min(bytes.len());
        Some(lines.clone())
    };
    let is_delimiter = |line: &[u8]| line.trim_ascii() == b"-1" && line.starts_with(b"    -1");
    let mut count = 0;
    while let Some(line) = next(&mut at) {
        if !is_delimiter(&bytes[line]) {
            continue;
        }
        let Some(line) = next(&mut at) else { break };
        let line = &bytes[line];
        let id = line.get(..6.min(line.len()))?.trim_ascii();
        let is_function = id == b"58";
        count += u64::from(is_function);
        if is_function && line.get(6).is_some_and(|b| b.eq_ignore_ascii_case(&b'b')) {
            let text = std::str::from_utf8(line.get(31..43)?.trim_ascii()).ok()?;
            for _ in 0..11 {
                next(&mut at)?;
            }
            at = at.checked_add(text.parse::<usize>().ok()?)?;
            // Some programs state half of the bytes of uneven records.
            let rest = bytes.get(at..)?.trim_ascii_start();
            if !rest.starts_with(b"-1") {
                return None;
            }
        }
        // A file may end within its last data set.
        while let Some(line) = next(&mut at) {
            if is_delimiter(&bytes[line]) {
                break;
            }
        }
    }
    Some(count)
}

/// Numbers of a file in one byte order.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    is_big: bool,
}

impl Reader<'_> {
    fn take(&mut self, count: usize) -> Option<&[u8]> {
        let part = self.bytes.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(part)
    }

    fn unsigned(&mut self, count: usize) -> Option<u64> {
        let is_big = self.is_big;
        let part = self.take(count)?;
        let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Some(match is_big {
            true => part.iter().fold(0, add),
            false => part.iter().rev().fold(0, add),
        })
    }

    fn text(&mut self) -> Option<Vec<u8>> {
        let count = self.unsigned(4)?;
        Some(self.take(count as usize)?.to_vec())
    }
}

/// Channels of a TDMS file that have an index of samples, texts apart.
fn tdms(bytes: &[u8]) -> Option<u64> {
    const NONE: u64 = 0xffff_ffff;
    const TEXT: u64 = 0x20;
    let size = |kind: u64| {
        Some(match kind {
            1 | 5 | 0x21 => 1,
            2 | 6 => 2,
            3 | 7 | 9 | 0x19 => 4,
            4 | 8 | 0xa | 0x1a | 0x8_000c => 8,
            0x44 | 0x10_000d | 0xb | 0x1b => 16,
            _ => return None,
        })
    };
    let mut channels = BTreeSet::new();
    let mut start = 0usize;
    while bytes.len().saturating_sub(start) >= 28 {
        let lead = &bytes[start..start + 28];
        if !lead.starts_with(b"TDSm") {
            return None;
        }
        let flags = u32::from_le_bytes(lead[4..8].try_into().ok()?);
        let is_big = flags & 1 << 6 != 0;
        let mut reader = Reader {
            bytes,
            at: start + 12,
            is_big,
        };
        let next = reader.unsigned(8)?;
        reader.at = start + 28;
        if flags & 1 << 1 != 0 {
            for _ in 0..reader.unsigned(4)? {
                let path = reader.text()?;
                match reader.unsigned(4)? {
                    NONE | 0 => {}
                    // Raw data of a device, with scalers behind it.
                    0x1169 | 0x1269 | 0x6912_0000.. => return None,
                    _ => {
                        let kind = reader.unsigned(4)?;
                        reader.unsigned(4)?;
                        reader.unsigned(8)?;
                        if kind == TEXT {
                            reader.unsigned(8)?;
                        }
                        let is_channel = path.windows(3).any(|part| part == b"'/'");
                        if is_channel && kind != TEXT {
                            channels.insert(path);
                        }
                    }
                }
                for _ in 0..reader.unsigned(4)? {
                    reader.text()?;
                    match reader.unsigned(4)? {
                        TEXT => drop(reader.text()?),
                        kind => drop(reader.take(size(kind)?)?),
                    }
                }
            }
        }
        // The last segment of a file that was cut off has no length.
        let Some(end) = start
            .checked_add(28)?
            .checked_add(usize::try_from(next).ok()?)
        else {
            break;
        };
        if end <= start {
            return None;
        }
        start = end;
    }
    Some(channels.len() as u64)
}

/// Samples that the headers of all records of a miniSEED file state.
fn miniseed(bytes: &[u8]) -> Option<u64> {
    let (mut at, mut sum) = (0usize, 0u64);
    while at < bytes.len() {
        let rest = &bytes[at..];
        if rest.starts_with(b"MS\x03") {
            let mut reader = Reader {
                bytes: rest,
                at: 24,
                is_big: false,
            };
            sum = sum.checked_add(reader.unsigned(4)?)?;
            reader.at = 33;
            let parts = [
                reader.unsigned(1)?,
                reader.unsigned(2)?,
                reader.unsigned(4)?,
            ];
            at = at
                .checked_add(40)?
                .checked_add(parts.iter().sum::<u64>() as usize)?;
            continue;
        }
        let is_record = rest.get(6).is_some_and(|b| b"DRQM".contains(b))
            && rest.get(..6)?.iter().all(u8::is_ascii_digit);
        if !is_record {
            return None;
        }
        let year = u16::from_be_bytes([*rest.get(20)?, *rest.get(21)?]);
        let is_big = (1900..2100).contains(&year);
        let mut reader = Reader {
            bytes: rest,
            at: 30,
            is_big,
        };
        sum = sum.checked_add(reader.unsigned(2)?)?;
        reader.at = 46;
        let mut blockette = reader.unsigned(2)? as usize;
        let mut length = None;
        while blockette >= 48 && length.is_none() {
            reader.at = blockette;
            let (kind, next) = (reader.unsigned(2)?, reader.unsigned(2)? as usize);
            if kind == 1000 {
                length = Some(1usize.checked_shl(u32::from(*rest.get(blockette + 6)?))?);
            }
            blockette = if next > blockette { next } else { 0 };
        }
        at = at.checked_add(length?)?;
    }
    Some(sum)
}

/// Samples of a SEG-Y file of traces of one length.
fn segy(bytes: &[u8]) -> Option<u64> {
    let headers = bytes.get(3200..3600)?;
    let format = u16::from_be_bytes([headers[24], headers[25]]);
    if !(1..=16).contains(&format) {
        return None;
    }
    let samples = u64::from(u16::from_be_bytes([headers[20], headers[21]]));
    let size = match format {
        1 | 2 | 4 | 5 | 10 => 4,
        3 | 11 => 2,
        6 | 9 | 12 => 8,
        8 | 16 => 1,
        _ => return None,
    };
    let extended = u64::from(u16::from_be_bytes([headers[304], headers[305]]));
    let length = (bytes.len() as u64).checked_sub(3600 + 3200 * extended)?;
    let trace = 240 + samples * size;
    // Revision 2 states more than 65535 samples elsewhere, and trailers follow the traces.
    let is_plain = samples > 0 && length % trace == 0 && headers[300] < 2;
    is_plain.then(|| length / trace * samples)
}

/// Samples of a Seismic Unix file.
fn seismic_unix(bytes: &[u8]) -> Option<u64> {
    let header = bytes.get(..240)?;
    let length = bytes.len() as u64;
    let read = [u16::from_le_bytes, u16::from_be_bytes];
    let fitting = read
        .iter()
        .map(|read| u64::from(read([header[114], header[115]])));
    let mut fitting =
        fitting.filter(|samples| *samples > 0 && length.is_multiple_of(240 + 4 * samples));
    let samples = fitting.next()?;
    // Of a file that fits in both byte orders there is no opinion.
    fitting
        .next()
        .is_none()
        .then(|| length / (240 + 4 * samples) * samples)
}

/// Snapshots of a LAMMPS dump.
fn lammps(bytes: &[u8]) -> u64 {
    let lines = bytes.split(|byte| *byte == b'\n');
    lines
        .filter(|line| line.trim_ascii() == b"ITEM: TIMESTEP")
        .count() as u64
}

/// Variables read at once, in blocks, and where they lie in the file as they are.
fn other_paths(container: &Container, bytes: &[u8]) -> Option<String> {
    for (at, variable) in container.variables.iter().enumerate() {
        let SampleType::Number(sample) = variable.sample_type else {
            continue;
        };
        let shape = variable.shape();
        if variable.count().is_none_or(|count| count > FEW) || shape.contains(&0) {
            continue;
        }
        let size = sample.bytes();
        let read = |block: &[Range<u64>]| {
            let count: u64 = block.iter().map(|range| range.end - range.start).product();
            let mut out = vec![0; count as usize * size];
            container.read(at, block, &mut out).ok().map(|()| out)
        };
        let whole: Vec<Range<u64>> = shape.iter().map(|len| 0..*len).collect();
        let Some(all) = read(&whole) else { continue };
        for axis in 0..shape.len() {
            let middle = shape[axis].div_ceil(3);
            for part in [0..middle, middle..shape[axis]] {
                let mut block = whole.clone();
                block[axis] = part.clone();
                let Some(found) = read(&block) else {
                    return Some(format!(
                        "{}: {part:?} of axis {axis} is not read",
                        variable.path
                    ));
                };
                if found != cut(&all, &shape, axis, part.clone(), size) {
                    return Some(format!(
                        "{}: {part:?} of axis {axis} differs",
                        variable.path
                    ));
                }
            }
        }
        let strided = match &variable.place {
            Place::Strided(strided) if strided.is_in_file => strided,
            _ => continue,
        };
        for (n, one) in all.chunks_exact(size).enumerate() {
            let (mut rest, mut place) = (n as u64, strided.start);
            for (len, stride) in shape.iter().zip(&strided.strides).rev() {
                place += rest % len * stride;
                rest /= len;
            }
            let Some(stored) = bytes.get(place as usize..place as usize + size) else {
                return Some(format!("{}: sample {n} is not in the file", variable.path));
            };
            let mut stored = stored.to_vec();
            if strided.order != ByteOrder::NATIVE {
                stored.reverse();
            }
            if stored != one {
                return Some(format!("{}: sample {n} is another one", variable.path));
            }
        }
    }
    None
}

/// The part of an array whose index along `axis` is in a range.
fn cut(all: &[u8], shape: &[u64], axis: usize, part: Range<u64>, size: usize) -> Vec<u8> {
    let inner = shape[axis + 1..].iter().product::<u64>() as usize * size;
    let outer = all.chunks_exact(shape[axis] as usize * inner);
    let range = part.start as usize * inner..part.end as usize * inner;
    outer
        .flat_map(|row| row[range.clone()].iter().copied())
        .collect()
}
