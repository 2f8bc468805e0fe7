//! Data sets 58 and 58b: functions at nodes.

use std::hash::{Hash, Hasher};

use super::text::{Lines, columns, float, integer, is_delimiter, label};
use crate::{ByteOrder, Error, Result, Sample};

/// What the functions of one variable have in common.
#[derive(Debug, Clone)]
pub(super) struct Kind {
    pub function: i64,
    pub is_complex: bool,
    pub count: usize,
    /// Origin and step; none for uneven spacing.
    pub even: Option<[f64; 2]>,
    pub abscissa_type: i64,
    pub abscissa_unit: String,
    pub ordinate_type: i64,
    pub ordinate_unit: String,
    pub denominator_unit: String,
}

/// The header of a function.
#[derive(Debug, Clone)]
pub(super) struct Function {
    pub kind: Kind,
    pub sample: Sample,
    /// Byte order of a binary data set.
    pub binary: Option<ByteOrder>,
    /// Whether ASCII columns are those of single precision.
    pub is_single: bool,
    pub name: String,
    pub label: String,
    pub response: [i64; 2],
    pub reference: [i64; 2],
}

/// The bits of a number, by which zeros of both signs are the same and NaN is equal to itself.
pub(super) fn bits(number: f64) -> u64 {
    (number + 0.0).to_bits()
}

impl PartialEq for Kind {
    fn eq(&self, other: &Kind) -> bool {
        self.fields() == other.fields()
    }
}

impl Hash for Kind {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.fields().hash(state);
    }
}

impl Kind {
    fn fields(&self) -> impl Hash + PartialEq + '_ {
        (
            self.function,
            self.is_complex,
            self.count,
            self.even.map(|even| even.map(bits)),
            self.abscissa_type,
            &self.abscissa_unit,
            self.ordinate_type,
            &self.ordinate_unit,
            &self.denominator_unit,
        )
    }

    /// Numbers for each abscissa.
    pub(super) fn per_point(&self) -> usize {
        1 + usize::from(self.even.is_none()) + usize::from(self.is_complex)
    }

    /// How functions of this kind differ from those of another one, which measure the same over the same
    /// quantity; none if they do not.
    pub(super) fn differs(&self, other: &Kind) -> Option<String> {
        let kinds = |kind: &Kind| (kind.function, kind.abscissa_type);
        if kinds(self) != kinds(other) {
            return None;
        }
        let named = |unit: &str| match unit {
            "" => "none".to_owned(),
            unit => unit.to_owned(),
        };
        Some(match () {
            _ if self.ordinate_unit != other.ordinate_unit => {
                let [own, others] = [self, other].map(|kind| named(&kind.ordinate_unit));
                format!("unit {own}, not {others}")
            }
            _ if self.denominator_unit != other.denominator_unit => {
                let [own, others] = [self, other].map(|kind| named(&kind.denominator_unit));
                format!("unit of the denominator {own}, not {others}")
            }
            _ if self.ordinate_type != other.ordinate_type => {
                format!(
                    "data of type {}, not {}",
                    self.ordinate_type, other.ordinate_type
                )
            }
            _ if self.is_complex != other.is_complex => "real or complex, unlike the others".into(),
            _ if self.count != other.count => {
                format!("{} values, not {}", self.count, other.count)
            }
            _ => "another abscissa".into(),
        })
    }
}

/// Reads a header behind the line `id` that names the data set.
pub(super) fn header(id: &[u8], lines: &mut Lines) -> Result<Function> {
    let binary = match columns(id, 6, 7) {
        b"b" | b"B" => Some(byte_order(id, lines.at)?),
        _ => None,
    };
    let what = "the 11 header lines of data set 58";
    let name = label(lines.expect(what)?, 0, 80);
    for _ in 1..5 {
        lines.expect(what)?;
    }
    let at = lines.at;
    let line = lines.expect(what)?;
    let function = integer(line, 0, 5, at)?;
    let response = [integer(line, 41, 51, at)?, integer(line, 51, 55, at)?];
    let reference = [integer(line, 66, 76, at)?, integer(line, 76, 80, at)?];
    let at = lines.at;
    let line = lines.expect(what)?;
    let (is_complex, sample) = match integer(line, 0, 10, at)? {
        2 => (false, Sample::F32),
        4 => (false, Sample::F64),
        5 => (true, Sample::F32),
        6 => (true, Sample::F64),
        other => {
            let place = format!("the line at byte {at}");
            return Err(Error::damaged(
                place,
                "ordinate type 2, 4, 5 or 6",
                other.to_string(),
            ));
        }
    };
    let count = integer(line, 10, 20, at)?;
    let count = usize::try_from(count)
        .ok()
        .filter(|&count| count > 0 && count <= lines.bytes.len());
    let Some(count) = count else {
        let found = String::from_utf8_lossy(columns(line, 10, 20)).into_owned();
        return Err(Error::damaged(
            format!("the line at byte {at}"),
            "a number of values within the file",
            found,
        ));
    };
    let even = match integer(line, 20, 30, at)? {
        0 => None,
        _ => Some([float(line, 30, 43, at)?, float(line, 43, 56, at)?]),
    };
    let mut axis = || -> Result<(i64, String, String)> {
        let at = lines.at;
        let line = lines.expect(what)?;
        Ok((
            integer(line, 0, 10, at)?,
            label(line, 25, 46),
            label(line, 46, 67),
        ))
    };
    let (abscissa_type, _, abscissa_unit) = axis()?;
    let (ordinate_type, ordinate_label, ordinate_unit) = axis()?;
    let (_, _, denominator_unit) = axis()?;
    axis()?;
    let kind = Kind {
        function,
        is_complex,
        count,
        even,
        abscissa_type,
        abscissa_unit,
        ordinate_type,
        ordinate_unit,
        denominator_unit,
    };
    Ok(Function {
        kind,
        sample: match binary {
            Some(_) => sample,
            None => Sample::F64,
        },
        binary,
        is_single: sample == Sample::F32,
        name,
        label: ordinate_label,
        response,
        reference,
    })
}

fn byte_order(id: &[u8], at: usize) -> Result<ByteOrder> {
    if integer(id, 13, 19, at)? != 2 {
        let what = "data set 58b in floating-point numbers of DEC or IBM";
        return Err(Error::unsupported(what, "write it with IEEE numbers"));
    }
    match integer(id, 7, 13, at)? {
        1 => Ok(ByteOrder::Little),
        2 => Ok(ByteOrder::Big),
        other => {
            let place = format!("the line before byte {at}");
            Err(Error::damaged(
                place,
                "byte order 1 or 2",
                other.to_string(),
            ))
        }
    }
}

/// Goes behind the binary numbers of a function; the byte of the first.
pub(super) fn skip_binary(function: &Function, lines: &mut Lines) -> Result<usize> {
    let (start, kind) = (lines.at, &function.kind);
    let length = kind
        .count
        .checked_mul(kind.per_point() * function.sample.bytes());
    let end = length.and_then(|length| start.checked_add(length));
    let Some(end) = end.filter(|&end| end <= lines.bytes.len()) else {
        let expected = format!("{} binary values", kind.count);
        return Err(Error::damaged(
            format!("byte {start}"),
            expected,
            "the end of the file",
        ));
    };
    lines.at = end;
    // A line end may stand between the numbers and the delimiter.
    let mut line = lines.expect("the end of data set 58b")?;
    if line.is_empty() {
        line = lines.expect("the end of data set 58b")?;
    }
    if !is_delimiter(line) {
        return Err(Error::damaged(
            format!("byte {end}"),
            "the end of data set 58b",
            "more data",
        ));
    }
    Ok(start)
}

/// The numbers of a function in ASCII, as far as the delimiter.
pub(super) fn ascii(function: &Function, lines: &mut Lines) -> Result<Vec<f64>> {
    let kind = &function.kind;
    let widths: &[usize] = match (function.is_single, kind.even.is_some(), kind.is_complex) {
        (true, ..) => &[13; 6],
        (false, true, _) => &[20; 4],
        (false, false, false) => &[13, 20, 13, 20],
        (false, false, true) => &[13, 20, 20],
    };
    let start = lines.at;
    let wrong = |found: usize| {
        let expected = format!("{} values", kind.count);
        Error::damaged(
            format!("byte {start}"),
            expected,
            (found / kind.per_point()).to_string(),
        )
    };
    let expected = kind.count * kind.per_point();
    let mut values = Vec::new();
    loop {
        let at = lines.at;
        let line = lines.expect("the end of data set 58")?;
        if is_delimiter(line) {
            break;
        }
        let mut from = 0;
        for width in widths {
            if columns(line, from, from + width).is_empty() {
                break;
            }
            if values.len() == expected {
                // Some writers fill up the last line.
                match from {
                    0 => return Err(wrong(expected + kind.per_point())),
                    _ => break,
                }
            }
            values.push(float(line, from, from + width, at)?);
            from += width;
        }
    }
    if values.len() == expected {
        Ok(values)
    } else {
        Err(wrong(values.len()))
    }
}
