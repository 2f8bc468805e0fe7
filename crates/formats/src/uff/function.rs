//! Data sets 58 and 58b: functions at nodes.

use std::hash::{DefaultHasher, Hash, Hasher};

use super::text::{Line, Lines};
use crate::rows::{Piece, Record};
use crate::sets::Traits;
use crate::{ByteOrder, Error, Result, Sample};

/// A function at a node.
#[derive(Debug)]
pub(super) struct Function {
    /// Its place among the functions of the file, from 1.
    pub number: usize,
    /// 1 for a response over time, 4 for a frequency response, ..
    pub function_type: i64,
    pub is_complex: bool,
    pub count: usize,
    /// Origin and step; none for uneven spacing.
    pub even: Option<[f64; 2]>,
    /// Abscissas of uneven spacing.
    pub abscissas: Vec<f64>,
    pub abscissa_type: i64,
    pub abscissa_unit: String,
    pub ordinate_type: i64,
    pub ordinate_unit: String,
    pub denominator_unit: String,
    pub name: String,
    pub label: String,
    /// Node and direction.
    pub response: [i64; 2],
    pub reference: [i64; 2],
    sample: Sample,
    /// Byte order of a binary data set.
    binary: Option<ByteOrder>,
}

impl Function {
    /// Numbers for each abscissa.
    fn per_point(&self) -> usize {
        1 + usize::from(self.even.is_none()) + usize::from(self.is_complex)
    }

    /// Whether its abscissa is, or may be, time.
    pub(super) fn is_record(&self) -> bool {
        self.function_type <= 1 && matches!(self.abscissa_type, 0 | 1 | 17)
    }

    /// What it has in common with others of one variable.
    pub(super) fn traits(&self) -> Traits {
        let named = |unit: &str| if unit.is_empty() { "none" } else { unit }.to_owned();
        // Zeros of both signs are the same.
        let abscissa = match self.even {
            Some([origin, step]) => format!("from {:?} by {:?}", origin + 0.0, step + 0.0),
            None => {
                let mut hasher = DefaultHasher::new();
                let bits = self.abscissas.iter().map(|x| (x + 0.0).to_bits());
                bits.for_each(|bits| bits.hash(&mut hasher));
                format!("uneven ({:016x})", hasher.finish())
            }
        };
        let kind = if self.is_complex { "complex" } else { "real" };
        Traits(vec![
            ("function type", self.function_type.to_string()),
            ("type of the abscissa", self.abscissa_type.to_string()),
            ("unit", named(&self.ordinate_unit)),
            ("unit of the denominator", named(&self.denominator_unit)),
            ("data of type", self.ordinate_type.to_string()),
            ("direction", self.response[1].to_string()),
            ("numbers", kind.into()),
            ("number of values", self.count.to_string()),
            ("unit of the abscissa", named(&self.abscissa_unit)),
            ("abscissa", abscissa),
        ])
    }

    /// Reads the header behind the line `id` that names the data set.
    pub(super) fn header(id: Line, lines: &mut Lines, number: usize) -> Result<Function> {
        let binary = match id.columns(6, 7) {
            b"b" | b"B" => Some(byte_order(id)?),
            _ => None,
        };
        let mut next = || lines.expect("the 11 header lines of data set 58");
        let name = next()?.label(0, 80);
        for _ in 1..5 {
            next()?;
        }
        let kind = next()?;
        let form = next()?;
        let (is_complex, sample) = match form.integer(0, 10)? {
            2 => (false, Sample::F32),
            4 => (false, Sample::F64),
            5 => (true, Sample::F32),
            6 => (true, Sample::F64),
            _ => return Err(form.damaged("ordinate type 2, 4, 5 or 6", form.columns(0, 10))),
        };
        let even = match form.integer(20, 30)? {
            0 => None,
            _ => Some([form.float(30, 43)?, form.float(43, 56)?]),
        };
        let [abscissa, ordinate, denominator, _] = [next()?, next()?, next()?, next()?];
        let count = usize::try_from(form.integer(10, 20)?).unwrap_or(0);
        if !(1..=lines.bytes.len()).contains(&count) {
            let expected = "a number of values within the file";
            return Err(form.damaged(expected, form.columns(10, 20)));
        }
        Ok(Function {
            number,
            function_type: kind.integer(0, 5)?,
            is_complex,
            count,
            even,
            abscissas: Vec::new(),
            abscissa_type: abscissa.integer(0, 10)?,
            abscissa_unit: abscissa.label(46, 67),
            ordinate_type: ordinate.integer(0, 10)?,
            ordinate_unit: ordinate.label(46, 67),
            denominator_unit: denominator.label(46, 67),
            name,
            label: ordinate.label(25, 46),
            response: [kind.integer(41, 51)?, kind.integer(51, 55)?],
            reference: [kind.integer(66, 76)?, kind.integer(76, 80)?],
            sample,
            binary,
        })
    }

    /// Bytes of memory that its numbers take.
    pub(super) fn memory(&self) -> u64 {
        match self.binary.is_none() && !self.is_complex {
            true => 8 * (self.count * self.per_point()) as u64,
            false => 0,
        }
    }

    /// Reads its numbers, as far as the delimiter. Complex ones are passed over.
    pub(super) fn numbers(&mut self, lines: &mut Lines) -> Result<Record> {
        match self.binary {
            Some(order) => self.binary(order, lines),
            None if self.is_complex => {
                while !lines.expect("the end of data set 58")?.is_delimiter() {}
                Ok(Record::default())
            }
            None => {
                let mut values = self.ascii(lines)?;
                if self.even.is_none() {
                    self.abscissas = values.iter().step_by(2).copied().collect();
                    values = values.into_iter().skip(1).step_by(2).collect();
                }
                Ok(Record::held(&values))
            }
        }
    }

    fn binary(&mut self, order: ByteOrder, lines: &mut Lines) -> Result<Record> {
        let (start, size) = (lines.at, self.sample.bytes());
        let step = self.per_point() * size;
        let length = self.count.checked_mul(step);
        let end = length.and_then(|length| start.checked_add(length));
        let end = end.filter(|&end| end <= lines.bytes.len());
        let end = end.ok_or_else(|| {
            let expected = format!("{} binary values", self.count);
            Error::damaged(format!("byte {start}"), expected, "the end of the file")
        })?;
        lines.at = end;
        // A line end may stand between the numbers and the delimiter.
        let expected = "the end of data set 58b";
        let mut line = lines.expect(expected)?;
        if line.text.is_empty() {
            line = lines.expect(expected)?;
        }
        if !line.is_delimiter() {
            return Err(line.damaged(expected, line.text));
        }
        if self.even.is_none() && !self.is_complex {
            let points = lines.bytes[start..end].chunks_exact(step);
            let abscissa = |point: &[u8]| self.sample.to_f64(order, &point[..size]);
            self.abscissas = points.map(abscissa).collect();
        }
        let mut record = Record {
            sample: Some(self.sample),
            ..Record::default()
        };
        // Behind the abscissa, if each point has one.
        let first = start + step - size;
        let place = [first, step, self.count].map(|n| n as u64);
        record.pieces.push(Piece::of(place, order));
        Ok(record)
    }

    fn ascii(&self, lines: &mut Lines) -> Result<Vec<f64>> {
        let is_single = self.sample == Sample::F32;
        let widths: &[usize] = match (is_single, self.even.is_some()) {
            (true, _) => &[13; 6],
            (false, true) => &[20; 4],
            (false, false) => &[13, 20, 13, 20],
        };
        let start = lines.at;
        let wrong = |found: usize| {
            let expected = format!("{} values", self.count);
            let place = format!("byte {start}");
            Error::damaged(place, expected, found / self.per_point())
        };
        let expected = self.count * self.per_point();
        let mut values = Vec::new();
        loop {
            let line = lines.expect("the end of data set 58")?;
            if line.is_delimiter() {
                break;
            }
            let mut from = 0;
            for width in widths {
                if line.columns(from, from + width).is_empty() {
                    break;
                }
                if values.len() == expected {
                    // Some writers fill up the last line.
                    match from {
                        0 => return Err(wrong(expected + self.per_point())),
                        _ => break,
                    }
                }
                values.push(line.float(from, from + width)?);
                from += width;
            }
        }
        match values.len() == expected {
            true => Ok(values),
            false => Err(wrong(values.len())),
        }
    }
}

fn byte_order(id: Line) -> Result<ByteOrder> {
    if id.integer(13, 19)? != 2 {
        let what = "data set 58b in floating-point numbers of DEC or IBM";
        return Err(Error::unsupported(what, "write it with IEEE numbers"));
    }
    match id.integer(7, 13)? {
        1 => Ok(ByteOrder::Little),
        2 => Ok(ByteOrder::Big),
        _ => Err(id.damaged("byte order 1 or 2", id.columns(7, 13))),
    }
}
