//! Where traces and the fields of their headers lie.

use crate::cursor::beginning;
use crate::{ByteOrder, Error, Result, Sample};

/// Bytes of a trace header.
pub(super) const HEADER: usize = 240;
/// Bytes of the textual and the binary header.
pub(super) const FILE_HEADER: usize = 3600;

/// Traces of equal length, one behind the other.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub order: ByteOrder,
    pub sample: Sample,
    /// Byte of the first trace header.
    pub start: usize,
    pub traces: usize,
    /// Samples of a trace.
    pub samples: usize,
    /// 0 to 2; none for Seismic Unix.
    pub revision: Option<u8>,
    /// Sample intervals in us, with where they are stated: none, the only one, or two that differ.
    pub intervals: Vec<(String, f64)>,
    pub is_feet: bool,
}

pub(super) fn u16_at(order: ByteOrder, bytes: &[u8], at: usize) -> u16 {
    order.unsigned(&bytes[at..at + 2]) as u16
}

pub(super) fn i16_at(order: ByteOrder, bytes: &[u8], at: usize) -> i16 {
    u16_at(order, bytes, at).cast_signed()
}

/// Byte order and format code, if one order gives a code that the standard knows.
pub(super) fn format_code(bytes: &[u8]) -> Option<(ByteOrder, u16)> {
    [ByteOrder::Big, ByteOrder::Little]
        .map(|order| (order, u16_at(order, bytes, 3224)))
        .into_iter()
        .find(|(_, code)| (1..=16).contains(code))
}

fn sample_of(code: u16) -> Result<Sample> {
    Ok(match code {
        1 => Sample::IbmF32,
        2 => Sample::I32,
        3 => Sample::I16,
        5 => Sample::F32,
        6 => Sample::F64,
        8 => Sample::I8,
        10 => Sample::U32,
        11 => Sample::U16,
        16 => Sample::U8,
        _ => {
            let what = format!("SEG-Y sample format {code}");
            let way_out = "write the traces as format 5 (IEEE float)";
            return Err(Error::unsupported(what, way_out));
        }
    })
}

impl Layout {
    /// The layout of a SEG-Y file.
    pub(super) fn segy(bytes: &[u8]) -> Result<Layout> {
        let damaged = |expected: String, found: String| {
            let place = "SEG-Y headers";
            Err(Error::damaged(place, expected, found))
        };
        let refused = |what: String, way_out: &str| Err(Error::unsupported(what, way_out));
        if bytes.len() < FILE_HEADER + HEADER {
            let least = format!("at least {} bytes", FILE_HEADER + HEADER);
            let found = format!("{} bytes, {}", bytes.len(), beginning(bytes));
            return damaged(least, found);
        }
        let Some((order, code)) = format_code(bytes) else {
            let found = u16_at(ByteOrder::Big, bytes, 3224);
            return damaged(
                "a sample format from 1 to 16 at byte 3225".into(),
                found.to_string(),
            );
        };
        let sample = sample_of(code)?;
        let revision = match order {
            // Revision 1 is a number of two bytes, revision 2 has one byte for major and one for minor.
            ByteOrder::Little if bytes[3500] == 0 => bytes[3501],
            _ => bytes[3500],
        };
        if revision > 2 {
            let what = format!("SEG-Y revision {revision}");
            return refused(what, "write the file as revision 1");
        }
        // Fields that revision 2 added to the binary header: 0 is unset.
        let extended = |at: usize, len: usize| match revision {
            2 => order.unsigned(&bytes[at..at + len]),
            _ => 0,
        };
        if extended(3506, 4) != 0 {
            let what = "additional trace headers of SEG-Y revision 2".into();
            return refused(what, "write the file without them");
        }
        let headers = match revision {
            0 => 0,
            _ => i16_at(order, bytes, 3504),
        };
        let start = match (extended(3520, 8), usize::try_from(headers)) {
            (0, Ok(headers)) => FILE_HEADER + 3200 * headers,
            (0, Err(_)) => {
                let what = "an unstated number of extended textual headers".into();
                return refused(what, "write their number into bytes 3505 to 3506");
            }
            (first, _) => usize::try_from(first).unwrap_or(usize::MAX),
        };
        let trailers = extended(3528, 4) as u32 as i32;
        let behind = usize::try_from(trailers).ok();
        let end = behind.and_then(|n| bytes.len().checked_sub(n.checked_mul(3200)?));
        let Some(end) = end else {
            let what = format!("{trailers} data trailers");
            return refused(what, "write the file without them");
        };
        if start < FILE_HEADER || end.checked_sub(start).is_none_or(|left| left < HEADER) {
            let expected = format!("the first trace within bytes {FILE_HEADER} to {end}");
            return damaged(expected, format!("byte {start}"));
        }
        let traces = &bytes[start..end];
        let of_file = match extended(3268, 4) {
            0 => usize::from(u16_at(order, bytes, 3220)),
            samples => samples as usize,
        };
        let is_fixed = revision > 0 && i16_at(order, bytes, 3502) == 1;
        let samples = equal_length(order, traces, sample.bytes(), of_file, is_fixed)?;
        let mut layout = Layout {
            order,
            sample,
            start,
            traces: traces.len() / (HEADER + samples * sample.bytes()),
            samples,
            revision: Some(revision),
            intervals: Vec::new(),
            is_feet: i16_at(order, bytes, 3254) == 2,
        };
        // Another interval than one that 16 bits can hold stands there alone.
        let extended = f64::from_bits(extended(3272, 8));
        layout.intervals = match extended > 0.0 && extended.is_finite() {
            true => vec![("binary header".to_owned(), extended)],
            false => layout.intervals(bytes, u16_at(order, bytes, 3216)),
        };
        Ok(layout)
    }

    /// The layout of a Seismic Unix file: in the byte order that agrees with the length of the file.
    pub(super) fn seismic_unix(bytes: &[u8]) -> Result<Layout> {
        if bytes.len() < HEADER {
            let expected = format!("a header of {HEADER} bytes");
            let found = format!("{} bytes", bytes.len());
            return Err(Error::damaged("trace 1", expected, found));
        }
        let of = |order| Ok((order, equal_length(order, bytes, 4, 0, false)?));
        let (order, samples) = of(ByteOrder::Little)
            .or_else(|little| of(ByteOrder::Big).map_err(|_: Error| little))?;
        let mut layout = Layout {
            order,
            sample: Sample::F32,
            start: 0,
            traces: bytes.len() / (HEADER + 4 * samples),
            samples,
            revision: None,
            intervals: Vec::new(),
            is_feet: false,
        };
        layout.intervals = layout.intervals(bytes, 0);
        Ok(layout)
    }

    /// The first sample interval in us that the binary header, or a trace, states, and the first other one.
    fn intervals(&self, bytes: &[u8], of_file: u16) -> Vec<(String, f64)> {
        let of_traces = (0..self.traces).map(|trace| {
            let interval = u16_at(self.order, self.header(bytes, trace), 116);
            (format!("trace {}", trace + 1), f64::from(interval))
        });
        let all = std::iter::once(("binary header".to_owned(), of_file.into())).chain(of_traces);
        let mut stated = all.filter(|(_, interval)| *interval > 0.0);
        let first = stated.next();
        let other = stated.find(|(_, other)| first.as_ref().is_some_and(|first| first.1 != *other));
        first.into_iter().chain(other).collect()
    }

    /// Bytes from one trace header to the next.
    pub(super) fn stride(&self) -> usize {
        HEADER + self.samples * self.sample.bytes()
    }

    pub(super) fn header<'a>(&self, bytes: &'a [u8], trace: usize) -> &'a [u8] {
        &bytes[self.start + trace * self.stride()..][..HEADER]
    }
}

/// The length of every trace: `of_file` unless only that of the first trace header fits the file.
fn equal_length(
    order: ByteOrder,
    traces: &[u8],
    size: usize,
    of_file: usize,
    is_fixed: bool,
) -> Result<usize> {
    let length_at = |at: usize| usize::from(u16_at(order, traces, at + 114));
    let first = length_at(0);
    let stride = |samples: usize| samples.checked_mul(size)?.checked_add(HEADER);
    let fits = |&samples: &usize| {
        samples > 0 && stride(samples).is_some_and(|stride| traces.len().is_multiple_of(stride))
    };
    let whole = [of_file, first].into_iter().find(fits);
    if let Some(samples) = whole {
        let step = HEADER + samples * size;
        // A length of 0 is an unset field, as is one of traces too long for its 16 bits.
        let differs = |at: &usize| {
            let own = length_at(*at);
            own != 0 && own != samples && samples <= usize::from(u16::MAX)
        };
        let other = (0..traces.len()).step_by(step).find(differs);
        return match other {
            Some(at) if !is_fixed => Err(unequal(at / step + 1, length_at(at), samples)),
            _ => Ok(samples),
        };
    }
    // Neither fits: traces differ in length, or the file was cut.
    let (mut at, mut trace) = (0, 1);
    while at + HEADER <= traces.len() && first > 0 {
        let own = length_at(at);
        if own != first {
            return Err(unequal(trace, own, first));
        }
        at += HEADER + own * size;
        trace += 1;
    }
    let expected = match first.max(of_file) {
        0 => "a number of samples above 0".to_owned(),
        samples => format!("whole traces of {samples} samples"),
    };
    let found = format!("{} bytes", traces.len());
    Err(Error::damaged("traces", expected, found))
}

fn unequal(trace: usize, found: usize, samples: usize) -> Error {
    let what = format!("trace {trace} of {found} samples among traces of {samples}");
    Error::unsupported(what, "cut or pad the traces to one length")
}
