//! A file as named arrays.

use std::collections::HashMap;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use crate::rows::{Piece, Scaling};
use crate::{Attributes, ByteOrder, Bytes, Error, Format, Result, Sample, SampleType};

/// A file as named arrays.
pub struct Container {
    /// Its format.
    pub format: Format,
    /// Values that belong to the whole file.
    pub attributes: Attributes,
    /// Its arrays, in the order of the file.
    pub variables: Vec<Variable>,
    /// What the reader is not sure of, or has left out of a variable.
    pub remarks: Vec<Remark>,
    bytes: Bytes,
    /// One a variable.
    sources: Vec<Source>,
    pub(crate) most_bytes: u64,
}

/// A named array.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its name in the file, with the groups that hold it: `/group/velocity`, `data.vel`.
    pub path: String,
    /// From the slowest to the fastest index.
    pub dimensions: Vec<Dimension>,
    /// What it holds.
    pub sample_type: SampleType,
    /// Values that belong to it. Unit, fill value, scale and offset have the names of the CF conventions:
    /// `units`, `_FillValue`, `scale_factor`, `add_offset`.
    pub attributes: Attributes,
    /// Where its samples are.
    pub place: Place,
}

/// A doubt about what was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// The variable that it is about, by its place; none for all of the file.
    pub variable: Option<usize>,
    /// One clause.
    pub text: String,
}

impl Remark {
    /// `what` and the first few of `texts`; none if there are none.
    pub(crate) fn listing(what: &str, texts: impl IntoIterator<Item = String>) -> Option<String> {
        const NAMED: usize = 4;
        let mut texts: Vec<String> = texts.into_iter().take(NAMED + 1).collect();
        if let Some(last) = texts.get_mut(NAMED) {
            *last = "and more".into();
        }
        (!texts.is_empty()).then(|| format!("{what} {}", texts.join("; ")))
    }
}

/// One index of an array.
#[derive(Debug, Clone, PartialEq)]
pub struct Dimension {
    /// Its name, if the file has one.
    pub name: Option<String>,
    /// How many values it takes.
    pub len: u64,
    /// What the index stands for, if the file says so.
    pub coordinate: Option<Coordinate>,
}

/// What an index stands for.
#[derive(Debug, Clone, PartialEq)]
pub enum Coordinate {
    /// `origin + index * step`.
    Even {
        /// Its value at index 0.
        origin: f64,
        /// From one index to the next; NaN where the file does not state one alone.
        step: f64,
        /// Unit of both.
        unit: Option<String>,
    },
    /// The values of a variable of one dimension, by its place in [`Container::variables`].
    Listed(usize),
}

/// Where the samples of a variable are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// In bytes, all of them within those that [`Container::bytes`] gives.
    Strided(Strided),
    /// They have to be decoded.
    Encoded {
        /// How many indices of the first dimension are best decoded at once: those of a chunk.
        rows: u64,
    },
}

/// Samples at even distances along each index: `i, j, ..` is at `start + i * strides[0] + j * strides[1] + ..`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Strided {
    /// Byte of the first sample.
    pub start: u64,
    /// Bytes from one index to the next, one a dimension.
    pub strides: Vec<u64>,
    /// Byte order of each sample.
    pub order: ByteOrder,
    /// Whether the bytes are those of the file, and not unpacked first.
    pub is_in_file: bool,
}

impl Strided {
    /// In the file as it is.
    pub(crate) fn new(start: u64, strides: Vec<u64>, order: ByteOrder) -> Strided {
        Strided {
            start,
            strides,
            order,
            is_in_file: true,
        }
    }

    /// Copies a block of numbers of type `from` row by row, as numbers of type `to`.
    ///
    /// # Errors
    /// A number that is none of type `to`.
    pub(crate) fn copy(
        &self,
        bytes: &[u8],
        block: Block,
        [from, to]: [Sample; 2],
        out: &mut [u8],
    ) -> std::result::Result<(), f64> {
        let (last, outer, step) = match block.split_last() {
            Some((last, outer)) => (last.clone(), outer, self.strides[outer.len()]),
            None => (0..1, block, 0),
        };
        let count = last.end - last.start;
        let rows = out.chunks_exact_mut(count as usize * to.bytes());
        for (row, out) in rows.enumerate() {
            let mut row = row as u64;
            let mut start = self.start + last.start * step;
            for (range, stride) in outer.iter().zip(&self.strides).rev() {
                let len = range.end - range.start;
                start += (range.start + row % len) * stride;
                row /= len;
            }
            let run = Piece::of([start, step, count], self.order);
            run.copy(bytes, [from, to], &Scaling::default(), out, to.bytes())?;
        }
        Ok(())
    }
}

impl Place {
    /// In the file as it is.
    pub(crate) fn in_file(start: u64, strides: Vec<u64>, order: ByteOrder) -> Place {
        Place::Strided(Strided::new(start, strides, order))
    }
}

/// Bytes from one index to the next of samples without gaps between them, the last index fastest, or the first.
pub fn strides(shape: &[u64], sample: Sample, is_first_fastest: bool) -> Vec<u64> {
    let mut next = sample.bytes() as u64;
    let mut strides = vec![0; shape.len()];
    let mut place = |d: usize| {
        strides[d] = next;
        next = next.saturating_mul(shape[d]);
    };
    match is_first_fastest {
        true => (0..shape.len()).for_each(&mut place),
        false => (0..shape.len()).rev().for_each(&mut place),
    }
    strides
}

/// A range of each index.
pub type Block<'a> = &'a [Range<u64>];

/// Decodes what does not lie in the file as it is.
pub(crate) trait Decoder: Send + Sync {
    /// Copies a block to `out`, in native byte order, the last index fastest. `block` lies within the variable
    /// and `out` is as long as the block.
    ///
    /// # Errors
    /// If the bytes are damaged.
    fn read(&self, block: Block, out: &mut [u8]) -> Result<()>;
}

type Unpack = Box<dyn Fn() -> Result<Bytes> + Send + Sync>;

/// What gives the samples of a variable.
enum Source {
    /// The bytes of the file, if it holds any.
    File,
    /// Bytes in which they lie at the strides of its place: those of the file, once they are checked, or unpacked ones.
    Bytes(Unpack),
    /// A decoder, block by block.
    Decoder(Box<dyn Decoder>),
    /// Nothing, since they are damaged.
    Damaged(Error),
}

impl Coordinate {
    /// Even ones, in a unit that may be empty.
    pub(crate) fn even(origin: f64, step: f64, unit: &str) -> Coordinate {
        let unit = Some(unit.to_owned()).filter(|unit| !unit.is_empty());
        Coordinate::Even { origin, step, unit }
    }
}

impl Dimension {
    /// One without name and coordinate.
    pub fn new(len: u64) -> Dimension {
        Dimension {
            name: None,
            len,
            coordinate: None,
        }
    }

    /// The same with a name.
    pub fn named(self, name: impl Into<String>) -> Dimension {
        Dimension {
            name: Some(name.into()),
            ..self
        }
    }

    /// The same with a coordinate.
    pub fn at(self, coordinate: Coordinate) -> Dimension {
        Dimension {
            coordinate: Some(coordinate),
            ..self
        }
    }
}

impl Variable {
    /// One of numbers that are best decoded row by row.
    pub(crate) fn new(path: impl Into<String>, dimensions: Vec<Dimension>, of: Sample) -> Variable {
        Variable {
            path: path.into(),
            dimensions,
            sample_type: SampleType::Number(of),
            attributes: Attributes::default(),
            place: Place::Encoded { rows: 1 },
        }
    }

    /// One that holds no numbers.
    pub(crate) fn other(
        path: impl Into<String>,
        dimensions: Vec<Dimension>,
        what: impl Into<String>,
    ) -> Variable {
        Variable {
            sample_type: SampleType::Other(what.into()),
            ..Variable::new(path, dimensions, Sample::F64)
        }
    }

    /// The lengths of its dimensions.
    pub fn shape(&self) -> Vec<u64> {
        self.dimensions.iter().map(|d| d.len).collect()
    }

    /// What is wrong with it if its type cannot hold a number.
    pub(crate) fn misfit(path: &str, sample: Sample, number: f64) -> Error {
        let expected = format!("numbers that fit in {}", sample.name());
        Error::damaged(format!("variable {path}"), expected, number)
    }

    /// What is wrong with it.
    pub(crate) fn damaged(&self, expected: impl fmt::Display, found: impl fmt::Display) -> Error {
        Error::damaged(format!("variable {}", self.path), expected, found)
    }

    /// How many numbers it holds; `None` beyond a `u64`.
    pub fn count(&self) -> Option<u64> {
        let mut lengths = self.dimensions.iter().map(|d| d.len);
        lengths.try_fold(1u64, u64::checked_mul)
    }
}

/// Deflate encodes at most 258 bytes in two bits.
pub(crate) const MAX_INFLATION: u64 = 1032;

impl Container {
    /// A file without variables so far.
    pub(crate) fn new(format: Format, bytes: &Bytes) -> Container {
        let length = (**bytes).as_ref().len() as u64;
        Container {
            format,
            attributes: Attributes::default(),
            variables: Vec::new(),
            remarks: Vec::new(),
            bytes: Bytes::clone(bytes),
            sources: Vec::new(),
            most_bytes: length.saturating_mul(MAX_INFLATION),
        }
    }

    fn add(&mut self, variable: Variable, source: Source) {
        self.variables.push(variable);
        self.sources.push(source);
    }

    /// Adds a variable that lies in the file, or holds no numbers.
    pub(crate) fn push(&mut self, variable: Variable) {
        self.add(variable, Source::File);
    }

    /// Adds a variable that is decoded, or lies in the file if its place says so.
    pub(crate) fn push_decoded(&mut self, variable: Variable, decoder: impl Decoder + 'static) {
        self.add(variable, Source::Decoder(Box::new(decoder)));
    }

    /// Adds a variable that lies in the bytes that `unpack` gives, or a text in UTF-8 that is all of them.
    pub(crate) fn push_in(
        &mut self,
        variable: Variable,
        unpack: impl Fn() -> Result<Bytes> + Send + Sync + 'static,
    ) {
        self.add(variable, Source::Bytes(Box::new(unpack)));
    }

    /// Adds what cannot be read, and why.
    pub(crate) fn push_damaged(&mut self, path: String, fault: Error) {
        let variable = Variable::other(path, Vec::new(), "unreadable");
        self.add(variable, Source::Damaged(fault));
    }

    /// Adds numbers along one dimension, of 8 bytes each in native byte order.
    pub(crate) fn push_list(
        &mut self,
        variable: Variable,
        values: impl IntoIterator<Item = [u8; 8]>,
    ) {
        let bytes: Bytes = Arc::new(values.into_iter().flatten().collect::<Vec<u8>>());
        let mut variable = variable;
        let strided = Strided::new(0, vec![8], ByteOrder::NATIVE);
        variable.place = Place::Strided(Strided {
            is_in_file: false,
            ..strided
        });
        self.push_in(variable, move || Ok(Arc::clone(&bytes)));
    }

    /// The same of floats with a unit.
    pub(crate) fn push_floats(
        &mut self,
        path: impl Into<String>,
        dimension: &Dimension,
        unit: &str,
        values: impl IntoIterator<Item = f64>,
    ) {
        let mut variable = Variable::new(path, vec![dimension.clone()], Sample::F64);
        variable.attributes.insert_text("units", unit);
        self.push_list(variable, values.into_iter().map(f64::to_ne_bytes));
    }

    /// Says `text` of the variable that is added next.
    pub(crate) fn remark_on_next(&mut self, text: Option<String>) {
        let variable = Some(self.variables.len());
        self.remarks
            .extend(text.map(|text| Remark { variable, text }));
    }

    /// The place of the variable of this name, with or without a leading `/`.
    pub fn find(&self, path: &str) -> Option<usize> {
        let bare = |path: &str| path.trim_start_matches('/').to_owned();
        let path = bare(path);
        self.variables.iter().position(|v| bare(&v.path) == path)
    }

    /// Most bytes that the file can stand for.
    ///
    /// A header that claims more is damaged, or leaves nearly all of its samples unwritten.
    pub fn most_bytes(&self) -> u64 {
        self.most_bytes
    }

    /// Why a variable that is listed cannot be read.
    pub fn damage(&self, variable: usize) -> Option<&Error> {
        match &self.sources[variable] {
            Source::Damaged(fault) => Some(fault),
            _ => None,
        }
    }

    /// The text that a variable is; `None` of others.
    ///
    /// # Errors
    /// If its bytes are damaged.
    pub fn text(&self, variable: usize) -> Result<Option<String>> {
        let is_number = self.variables[variable].sample_type.number().is_some();
        match &self.sources[variable] {
            Source::Bytes(unpack) if !is_number => {
                let text = String::from_utf8_lossy((*unpack()?).as_ref()).into_owned();
                Ok(Some(text))
            }
            _ => Ok(None),
        }
    }

    /// The bytes in which the samples of a variable lie at the strides of its place; `None` of those that are decoded
    /// block by block.
    ///
    /// # Errors
    /// If the bytes are damaged, or unpacking them needs more memory than is allowed.
    pub fn bytes(&self, variable: usize) -> Result<Option<Bytes>> {
        match (&self.variables[variable].place, &self.sources[variable]) {
            (_, Source::Damaged(fault)) => Err(fault.clone()),
            (Place::Encoded { .. }, _) => Ok(None),
            (_, Source::Bytes(unpack)) => unpack().map(Some),
            _ => Ok(Some(Bytes::clone(&self.bytes))),
        }
    }

    /// Copies a block of a variable to `out`, in native byte order, the last index fastest.
    ///
    /// # Errors
    /// If the variable holds no numbers, or what has to be decoded is damaged.
    ///
    /// # Panics
    /// If the block leaves the variable, or `out` is not as long as the block.
    pub fn read(&self, variable: usize, block: Block, out: &mut [u8]) -> Result<()> {
        let found = &self.variables[variable];
        let sample = self.number(variable)?;
        assert_eq!(block.len(), found.dimensions.len());
        let is_within =
            |(range, d): (&Range<u64>, &Dimension)| range.start <= range.end && range.end <= d.len;
        assert!(block.iter().zip(&found.dimensions).all(is_within));
        let count: u64 = block.iter().map(|range| range.end - range.start).product();
        assert_eq!(out.len() as u64, count * sample.bytes() as u64);
        if out.is_empty() {
            return Ok(());
        }
        match (&found.place, &self.sources[variable], self.bytes(variable)?) {
            (Place::Strided(strided), _, Some(bytes)) => strided
                .copy((*bytes).as_ref(), block, [sample; 2], out)
                .map_err(|number| Variable::misfit(&found.path, sample, number)),
            (_, Source::Decoder(decoder), _) => decoder.read(block, out),
            _ => unreachable!("what is encoded has a decoder"),
        }
    }

    /// All numbers of a variable, the last index fastest, as they are stored: without scale, offset and
    /// fill value.
    ///
    /// # Errors
    /// As [`Container::read`].
    pub fn numbers(&self, variable: usize) -> Result<Vec<f64>> {
        let (sample, bytes) = self.all(variable)?;
        let each = bytes.chunks_exact(sample.bytes());
        let each = each.map(|one| sample.to_f64(ByteOrder::NATIVE, one));
        Ok(each.collect())
    }

    /// As [`Container::numbers`], without rounding; `None` for floats and for what exceeds an `i64`.
    ///
    /// # Errors
    /// As [`Container::read`].
    pub fn integers(&self, variable: usize) -> Result<Option<Vec<i64>>> {
        let (sample, bytes) = self.all(variable)?;
        let each = bytes.chunks_exact(sample.bytes());
        let each = each.map(|one| sample.to_i64(ByteOrder::NATIVE, one));
        Ok(each.collect())
    }

    fn number(&self, variable: usize) -> Result<Sample> {
        let found = &self.variables[variable];
        match (&found.sample_type, self.damage(variable)) {
            (SampleType::Number(sample), _) => Ok(*sample),
            (_, Some(fault)) => Err(fault.clone()),
            (SampleType::Other(other), None) => Err(found.damaged("numbers", other)),
        }
    }

    fn all(&self, variable: usize) -> Result<(Sample, Vec<u8>)> {
        let sample = self.number(variable)?;
        let found = &self.variables[variable];
        let block: Vec<Range<u64>> = found.dimensions.iter().map(|d| 0..d.len).collect();
        let (count, most) = (found.count().unwrap_or(u64::MAX), self.most_bytes);
        let bytes = count.saturating_mul(sample.bytes() as u64);
        if bytes > most {
            let expected = format!("at most {most} bytes of samples in this file");
            return Err(found.damaged(expected, bytes));
        }
        let mut out = Vec::new();
        let len = usize::try_from(bytes).unwrap_or(usize::MAX);
        out.try_reserve_exact(len).map_err(|_| Error::Memory {
            what: format!("variable {}", found.path),
            needed: bytes,
            allowed: 0,
        })?;
        out.resize(len, 0);
        self.read(variable, &block, &mut out)?;
        Ok((sample, out))
    }
}

/// Gives dimensions the coordinates of their name, in the group of the array or in one around it.
pub(crate) fn assign_coordinates(variables: &mut [Variable]) {
    let coordinate = |(i, v): (usize, &Variable)| {
        let [d] = &v.dimensions[..] else { return None };
        let is_one = d.name.is_some() && d.name.as_deref() == v.path.rsplit('/').next();
        let is_one = is_one && v.sample_type.number().is_some();
        is_one.then(|| (v.path.clone(), (i, d.len)))
    };
    let by_path = variables.iter().enumerate().filter_map(coordinate);
    let by_path: HashMap<String, (usize, u64)> = by_path.collect();
    for variable in variables {
        let path = &variable.path;
        for d in &mut variable.dimensions {
            let Some(name) = &d.name else { continue };
            let groups = path.rmatch_indices('/').map(|(at, _)| at + 1).chain([0]);
            let named = groups.map(|end| format!("{}{name}", &path[..end]));
            let mut found = named.filter_map(|path| by_path.get(&path));
            let found = found.find(|(_, len)| *len == d.len);
            d.coordinate = found.map(|(i, _)| Coordinate::Listed(*i));
        }
    }
}

impl fmt::Debug for Container {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Container")
            .field("format", &self.format)
            .field("variables", &self.variables)
            .finish_non_exhaustive()
    }
}
