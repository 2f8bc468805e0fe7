//! Records: a header and the samples behind it.

use std::fmt::Display;
use std::ops::Range;

use jiff::civil::{Date, Time};
use jiff::tz::Offset;

use super::steim::{self, Steim};
use crate::cursor::beginning;
use crate::{ByteOrder, Error, Result, Sample, Strided, time};

/// Bytes of the headers of versions 2 and 3.
const HEADER_2: usize = 48;
const HEADER_3: usize = 40;
/// Places of the checksum, CRC-32C, in a record of version 3.
const CHECKSUM: Range<usize> = 28..32;
const WAY_OUT: &str = "write it anew with `Stream.write(path, format=\"MSEED\")` of ObsPy";

/// A record, without the name of its trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Record {
    /// Its first byte.
    pub at: usize,
    /// Of all of it.
    pub bytes: usize,
    /// Nanoseconds since 1970-01-01.
    pub start: i64,
    /// In Hz; 0 for what is no series of samples.
    pub rate: f64,
    pub count: usize,
    pub encoding: Encoding,
    order: ByteOrder,
    /// First byte of the samples, and their number of bytes.
    data: (usize, usize),
    /// That of version 3.
    checksum: Option<u32>,
}

/// How samples are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Encoding {
    Plain(Sample),
    Steim(Steim),
    Text,
    Other(u8),
}

impl Encoding {
    fn of(code: u8) -> Encoding {
        match code {
            0 => Encoding::Text,
            1 => Encoding::Plain(Sample::I16),
            3 => Encoding::Plain(Sample::I32),
            4 => Encoding::Plain(Sample::F32),
            5 => Encoding::Plain(Sample::F64),
            10 => Encoding::Steim(Steim::One),
            11 => Encoding::Steim(Steim::Two),
            other => Encoding::Other(other),
        }
    }

    /// The type of decoded samples.
    pub(super) fn sample(self) -> Option<Sample> {
        match self {
            Encoding::Plain(Sample::I16) | Encoding::Steim(_) => Some(Sample::I32),
            Encoding::Plain(sample) => Some(sample),
            _ => None,
        }
    }

    pub(super) fn name(self) -> String {
        match self {
            Encoding::Plain(sample) => sample.name().into(),
            Encoding::Steim(Steim::One) => "Steim-1".into(),
            Encoding::Steim(Steim::Two) => "Steim-2".into(),
            Encoding::Text => "text".into(),
            Encoding::Other(code) => format!("encoding {code}"),
        }
    }

    /// Most samples in so many bytes.
    fn most(self, bytes: usize) -> usize {
        match self {
            Encoding::Plain(sample) => bytes / sample.bytes(),
            Encoding::Steim(steim) => bytes / steim::FRAME * 15 * steim.most_in_word(),
            _ => usize::MAX,
        }
    }
}

/// Whether a header of version 2 begins here.
pub(super) fn is_version_2(bytes: &[u8]) -> bool {
    let is_number = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b' ' | 0);
    bytes.len() >= HEADER_2
        && bytes[..6].iter().all(is_number)
        && matches!(bytes[6], b'D' | b'R' | b'Q' | b'M')
        && matches!(bytes[7], b' ' | 0)
        && bytes[24] <= 23
        && bytes[25] <= 59
        && bytes[26] <= 60
}

/// Whether a header of version 3 begins here.
pub(super) fn is_version_3(bytes: &[u8]) -> bool {
    bytes.len() >= HEADER_3
        && bytes.starts_with(b"MS\x03")
        && bytes[12] <= 23
        && bytes[13] <= 59
        && bytes[14] <= 60
}

/// Whether the headers of a SEED volume begin here.
pub(super) fn is_volume(bytes: &[u8]) -> bool {
    bytes.len() >= 8
        && bytes[..6].iter().all(u8::is_ascii_digit)
        && matches!(bytes[6], b'V' | b'A' | b'S' | b'T')
        && matches!(bytes[7], b' ' | b'*')
}

/// The record at byte `at` and the name of its trace: `network.station.location.channel`.
pub(super) fn read(bytes: &[u8], at: usize) -> Result<(Record, String)> {
    let rest = &bytes[at..];
    let (record, name) = match () {
        _ if is_version_3(rest) => version_3(rest, at)?,
        _ if is_version_2(rest) => version_2(rest, at)?,
        _ if is_volume(rest) => {
            return Err(Error::unsupported("headers of a SEED volume", WAY_OUT));
        }
        _ => {
            let (place, expected) = (format!("byte {at}"), "a record of miniSEED");
            return Err(Error::damaged(place, expected, beginning(rest)));
        }
    };
    let (bytes, most) = (record.data.1, record.encoding.most(record.data.1));
    match record.count <= most {
        true => Ok((record, name)),
        false => {
            let expected = format!("{} samples within {bytes} bytes", record.count);
            Err(damaged(at, expected, most))
        }
    }
}

/// What is wrong with the record at byte `at`.
pub(super) fn damaged(at: usize, expected: impl Display, found: impl Display) -> Error {
    Error::damaged(format!("the record at byte {at}"), expected, found)
}

/// Nanoseconds since 1970-01-01; none before 1677 and after 2262.
fn nanoseconds(year: u16, day: u16, [hour, minute, second]: [u8; 3], fraction: i64) -> Option<i64> {
    let first = Date::new(i16::try_from(year).ok()?, 1, 1).ok()?;
    let first = first.to_datetime(Time::midnight());
    let first = Offset::UTC.to_timestamp(first).ok()?.as_second();
    let [day, hour] = [i64::from(day) - 1, i64::from(hour)];
    let minutes = (24 * day + hour) * 60 + i64::from(minute);
    let seconds = first + minutes * 60 + i64::from(second);
    seconds.checked_mul(time::PER_SECOND)?.checked_add(fraction)
}

fn version_2(rest: &[u8], at: usize) -> Result<(Record, String)> {
    let is_date = |order: &ByteOrder| {
        let [year, day] = [20, 22].map(|at| order.unsigned(&rest[at..at + 2]));
        (1900..=2100).contains(&year) && (1..=366).contains(&day)
    };
    let orders = [ByteOrder::Big, ByteOrder::Little];
    let order = orders.into_iter().find(is_date);
    let year = || ByteOrder::Big.unsigned(&rest[20..22]);
    let order = order.ok_or_else(|| damaged(at, "a year from 1900 to 2100", year()))?;
    let u16_at = |at: usize| order.unsigned(&rest[at..at + 2]) as u16;
    let (mut storage, mut stated, mut microseconds) = (None, None, 0);
    let mut next = usize::from(u16_at(46));
    let mut last = 0;
    while next > last && rest.len() >= next + 8 {
        let blockette = &rest[next..next + 8];
        match u16_at(next) {
            1000 => storage = Some([blockette[4], blockette[5], blockette[6]]),
            1001 => microseconds = i64::from(blockette[5].cast_signed()),
            100 => stated = Some(Sample::F32.to_f64(order, &blockette[4..])),
            _ => {}
        }
        last = next;
        next = usize::from(u16_at(next + 2));
    }
    let Some([encoding, data_order, power]) = storage else {
        let what = "a record without blockette 1000";
        return Err(Error::unsupported(what, WAY_OUT));
    };
    if !(7..=20).contains(&power) {
        let found = format!("2^{power} bytes");
        return Err(damaged(at, "a length from 2^7 to 2^20", found));
    }
    let bytes = 1usize << power;
    if rest.len() < bytes {
        let found = format!("{} bytes", rest.len());
        return Err(damaged(at, format!("{bytes} bytes"), found));
    }
    let from = usize::from(u16_at(44));
    let count = usize::from(u16_at(30));
    // Behind the fixed header and the last blockette.
    let header = (last + 8).max(HEADER_2);
    if count > 0 && from < header {
        let expected = format!("samples behind the {header} bytes of the header");
        return Err(damaged(at, expected, format!("samples from byte {from}")));
    }
    // A record without samples has no place for them.
    let length = bytes.checked_sub(from).filter(|_| count > 0).unwrap_or(0);
    // In 0.1 ms, unless the start has it already.
    let correction = match rest[36] & 2 {
        0 => i64::from(order.unsigned(&rest[40..44]) as u32 as i32),
        _ => 0,
    };
    let fraction = (i64::from(u16_at(28)) + correction) * 100_000 + microseconds * 1000;
    let clock = [rest[24], rest[25], rest[26]];
    let start = nanoseconds(u16_at(20), u16_at(22), clock, fraction);
    let start = start.ok_or_else(|| damaged(at, "a time", "one beyond 2262"))?;
    let nominal = || rate(u16_at(32).cast_signed(), u16_at(34).cast_signed());
    let record = Record {
        at,
        bytes,
        start,
        rate: stated.unwrap_or_else(nominal),
        count,
        encoding: Encoding::of(encoding),
        order: match data_order {
            0 => ByteOrder::Little,
            _ => ByteOrder::Big,
        },
        data: (from, length),
        checksum: None,
    };
    let code = |range: Range<usize>| {
        let code = String::from_utf8_lossy(&rest[range]);
        code.trim_matches([' ', '\0']).to_owned()
    };
    let codes = [code(18..20), code(8..13), code(13..15), code(15..18)];
    Ok((record, codes.join(".")))
}

/// A positive factor is a rate, a negative one a period; a positive multiplier multiplies, a negative one
/// divides.
fn rate(factor: i16, multiplier: i16) -> f64 {
    let rate = match factor {
        0.. => f64::from(factor),
        _ => -1.0 / f64::from(factor),
    };
    match multiplier {
        0 => rate,
        1.. => rate * f64::from(multiplier),
        _ => -(rate / f64::from(multiplier)),
    }
}

fn version_3(rest: &[u8], at: usize) -> Result<(Record, String)> {
    let little = |range: Range<usize>| ByteOrder::Little.unsigned(&rest[range]);
    let length = |range| little(range) as usize;
    let (name, extra, data) = (usize::from(rest[33]), length(34..36), length(36..40));
    let from = HEADER_3 + name + extra;
    let bytes = from.checked_add(data).filter(|bytes| *bytes <= rest.len());
    let bytes = bytes.ok_or_else(|| {
        let found = format!("{} bytes", rest.len());
        damaged(at, format!("{from} and {data} bytes"), found)
    })?;
    let clock = [rest[12], rest[13], rest[14]];
    let (year, day) = (little(8..10) as u16, little(10..12) as u16);
    let fraction = little(4..8) as i64;
    let start = nanoseconds(year, day, clock, fraction);
    let start = start.filter(|_| (1..=366).contains(&day) && fraction < time::PER_SECOND);
    let start = start.ok_or_else(|| {
        let found = format!("day {day} of {year} and {fraction} ns");
        damaged(at, "a time from 1677 to 2262", found)
    })?;
    let stated = Sample::F64.to_f64(ByteOrder::Little, &rest[16..24]);
    let encoding = Encoding::of(rest[15]);
    let record = Record {
        at,
        bytes,
        start,
        // A negative one is a period.
        rate: if stated < 0.0 { -1.0 / stated } else { stated },
        count: length(24..28),
        encoding,
        order: match encoding {
            Encoding::Steim(_) => ByteOrder::Big,
            _ => ByteOrder::Little,
        },
        data: (from, data),
        checksum: Some(little(CHECKSUM) as u32),
    };
    let name = String::from_utf8_lossy(&rest[HEADER_3..HEADER_3 + name]);
    Ok((record, codes(name.trim_matches([' ', '\0']))))
}

/// `FDSN:NET_STA_LOC_B_H_Z` as `NET.STA.LOC.BHZ`; others as they are.
fn codes(name: &str) -> String {
    let Some(codes) = name.strip_prefix("FDSN:") else {
        return name.to_owned();
    };
    match codes.split('_').collect::<Vec<_>>()[..] {
        [network, station, location, band, source, position] => {
            let is_short = [band, source, position].iter().all(|code| code.len() <= 1);
            let between = if is_short { "" } else { "_" };
            let channel = [band, source, position].join(between);
            [network, station, location, &channel].join(".")
        }
        _ => name.to_owned(),
    }
}

impl Record {
    /// Decodes the samples of `range` to `out`, in native byte order.
    pub(super) fn decode(&self, bytes: &[u8], range: Range<usize>, out: &mut [u8]) -> Result<()> {
        let record = &bytes[self.at..self.at + self.bytes];
        if let Some(stated) = self.checksum {
            // That of a record with zeros in its place.
            let sum = crc32c::crc32c(&record[..CHECKSUM.start]);
            let sum = crc32c::crc32c_append(sum, &[0; 4]);
            let found = crc32c::crc32c_append(sum, &record[CHECKSUM.end..]);
            if found != stated {
                let expected = format!("the checksum {stated:#010x}");
                return Err(damaged(self.at, expected, format!("{found:#010x}")));
            }
        }
        let data = &record[self.data.0..self.data.0 + self.data.1];
        match self.encoding {
            Encoding::Steim(kind) => {
                let samples = steim::decode(kind, self.order, data, self.count);
                let samples =
                    samples.map_err(|(expected, found)| damaged(self.at, expected, found))?;
                for (one, sample) in out.chunks_exact_mut(4).zip(&samples[range]) {
                    one.copy_from_slice(&sample.to_ne_bytes());
                }
            }
            Encoding::Plain(sample) => {
                let to = self.encoding.sample().unwrap_or(sample);
                let samples = Strided::new(0, vec![sample.bytes() as u64], self.order);
                let block = range.start as u64..range.end as u64;
                let block = std::slice::from_ref(&block);
                let copied = samples.copy(data, block, [sample, to], out);
                copied.map_err(|found| damaged(self.at, "samples", found))?;
            }
            Encoding::Text | Encoding::Other(_) => {}
        }
        Ok(())
    }
}
