//! A file as named arrays.

use std::fmt;
use std::ops::Range;

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
    decoder: Option<Box<dyn Decoder>>,
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
    pub(crate) fn listing(what: &str, texts: impl Iterator<Item = String>) -> Option<String> {
        const NAMED: usize = 4;
        let mut texts: Vec<String> = texts.take(NAMED + 1).collect();
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
        /// From one index to the next.
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
    /// In the bytes of the file: sample `i, j, ..` is at `start + i * strides[0] + j * strides[1] + ..`.
    ///
    /// All of them lie within the file.
    Strided {
        /// Byte of the first sample.
        start: u64,
        /// Bytes from one index to the next, one a dimension.
        strides: Vec<u64>,
        /// Byte order of each sample.
        order: ByteOrder,
    },
    /// They have to be decoded.
    Encoded {
        /// How many indices of the first dimension are best decoded at once: those of a chunk.
        rows: u64,
    },
}

/// A range of each index.
pub type Block<'a> = &'a [Range<u64>];

/// Decodes what does not lie in the file as it is.
pub trait Decoder: Send + Sync {
    /// Copies a block of the variable at this place in [`Container::variables`] to `out`, in native byte
    /// order, the last index fastest. `block` lies within the variable and `out` is as long as the block.
    ///
    /// # Errors
    /// If the bytes are damaged.
    fn read(&self, variable: usize, block: Block, out: &mut [u8]) -> Result<()>;

    /// Most bytes that what it decodes can stand for; `None` if that follows from the bytes of the file.
    fn most_bytes(&self) -> Option<u64> {
        None
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
    /// The lengths of its dimensions.
    pub fn shape(&self) -> Vec<u64> {
        self.dimensions.iter().map(|d| d.len).collect()
    }

    /// How many numbers it holds; `None` beyond a `u64`.
    pub fn count(&self) -> Option<u64> {
        let mut lengths = self.dimensions.iter().map(|d| d.len);
        lengths.try_fold(1u64, u64::checked_mul)
    }
}

impl Container {
    /// A file whose variables lie in `bytes` or are decoded by `decoder`.
    pub fn new(format: Format, bytes: Bytes, decoder: Option<Box<dyn Decoder>>) -> Container {
        Container {
            format,
            attributes: Attributes::default(),
            variables: Vec::new(),
            remarks: Vec::new(),
            bytes,
            decoder,
        }
    }

    /// The place of the variable of this name, with or without a leading `/`.
    pub fn find(&self, path: &str) -> Option<usize> {
        let bare = |path: &str| path.trim_start_matches('/').to_owned();
        let path = bare(path);
        self.variables.iter().position(|v| bare(&v.path) == path)
    }

    /// Most bytes that the file can stand for: deflate encodes at most 258 bytes in two bits.
    ///
    /// A header that claims more is damaged, or leaves nearly all of its samples unwritten.
    pub fn most_bytes(&self) -> u64 {
        const MAX_INFLATION: u64 = 1032;
        let length = (*self.bytes).as_ref().len() as u64;
        let stated = self
            .decoder
            .as_ref()
            .and_then(|decoder| decoder.most_bytes());
        stated.unwrap_or(length.saturating_mul(MAX_INFLATION))
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
        match &found.place {
            Place::Encoded { .. } => match &self.decoder {
                Some(decoder) => decoder.read(variable, block, out),
                None => unreachable!("what is encoded has a decoder"),
            },
            Place::Strided {
                start,
                strides,
                order,
            } => {
                let bytes = (*self.bytes).as_ref();
                copy_strided(bytes, *start, strides, sample, block, out);
                if *order != ByteOrder::NATIVE {
                    out.chunks_exact_mut(sample.bytes())
                        .for_each(<[u8]>::reverse);
                }
                Ok(())
            }
        }
    }

    /// All numbers of a variable, the last index fastest, as they are stored: without scale, offset and
    /// fill value.
    ///
    /// # Errors
    /// As [`Container::read`].
    pub fn numbers(&self, variable: usize) -> Result<Vec<f64>> {
        let (sample, bytes) = self.all(variable)?;
        let numbers = bytes.chunks_exact(sample.bytes());
        Ok(numbers
            .map(|one| sample.to_f64(ByteOrder::NATIVE, one))
            .collect())
    }

    /// As [`Container::numbers`], without rounding; `None` for floats and for what exceeds an `i64`.
    ///
    /// # Errors
    /// As [`Container::read`].
    pub fn integers(&self, variable: usize) -> Result<Option<Vec<i64>>> {
        let (sample, bytes) = self.all(variable)?;
        let numbers = bytes.chunks_exact(sample.bytes());
        Ok(numbers
            .map(|one| sample.to_i64(ByteOrder::NATIVE, one))
            .collect())
    }

    fn number(&self, variable: usize) -> Result<Sample> {
        let found = &self.variables[variable];
        match &found.sample_type {
            SampleType::Number(sample) => Ok(*sample),
            SampleType::Other(other) => Err(Error::damaged(
                format!("variable {}", found.path),
                "numbers",
                other.clone(),
            )),
        }
    }

    fn all(&self, variable: usize) -> Result<(Sample, Vec<u8>)> {
        let sample = self.number(variable)?;
        let found = &self.variables[variable];
        let block: Vec<Range<u64>> = found.dimensions.iter().map(|d| 0..d.len).collect();
        let bytes = found
            .count()
            .and_then(|n| n.checked_mul(sample.bytes() as u64));
        if bytes.is_none_or(|bytes| bytes > self.most_bytes()) {
            return Err(Error::damaged(
                format!("variable {}", found.path),
                format!(
                    "at most {} bytes of samples in this file",
                    self.most_bytes()
                ),
                bytes.map_or("more".into(), |bytes| bytes.to_string()),
            ));
        }
        let mut out = Vec::new();
        let reserved = bytes
            .and_then(|bytes| usize::try_from(bytes).ok())
            .and_then(|bytes| out.try_reserve_exact(bytes).ok().map(|()| bytes));
        let Some(bytes) = reserved else {
            return Err(Error::Memory {
                what: format!("variable {}", found.path),
                needed: bytes.unwrap_or(u64::MAX),
                allowed: 0,
            });
        };
        out.resize(bytes, 0);
        self.read(variable, &block, &mut out)?;
        Ok((sample, out))
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

/// Copies a block sample by sample, or row by row where the last index is contiguous.
fn copy_strided(
    bytes: &[u8],
    start: u64,
    strides: &[u64],
    sample: Sample,
    block: Block,
    out: &mut [u8],
) {
    let size = sample.bytes();
    let (Some((last, outer)), Some((&stride, outer_strides))) =
        (block.split_last(), strides.split_last())
    else {
        out.copy_from_slice(&bytes[start as usize..][..size]);
        return;
    };
    let row = (last.end - last.start) as usize;
    let mut index: Vec<u64> = outer.iter().map(|range| range.start).collect();
    for row_out in out.chunks_exact_mut(row * size) {
        let offset: u64 = index
            .iter()
            .zip(outer_strides)
            .map(|(i, stride)| i * stride)
            .sum();
        let from = (start + offset + last.start * stride) as usize;
        if stride == size as u64 {
            row_out.copy_from_slice(&bytes[from..][..row * size]);
        } else {
            for (i, one) in row_out.chunks_exact_mut(size).enumerate() {
                one.copy_from_slice(&bytes[from + i * stride as usize..][..size]);
            }
        }
        for (i, range) in index.iter_mut().zip(outer).rev() {
            *i += 1;
            if *i < range.end {
                break;
            }
            *i = range.start;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// Two rows of three big-endian integers, each row behind a header of four bytes.
    fn traces() -> Container {
        let mut bytes = Vec::new();
        for row in 0..2i16 {
            bytes.extend([9; 4]);
            bytes.extend((0..3).flat_map(|i| (10 * row + i).to_be_bytes()));
        }
        let mut container = Container::new(Format::SegY, Arc::new(bytes), None);
        container.variables.push(Variable {
            path: "/traces".into(),
            dimensions: vec![Dimension::new(2), Dimension::new(3)],
            sample_type: SampleType::Number(Sample::I16),
            attributes: Attributes::default(),
            place: Place::Strided {
                start: 4,
                strides: vec![10, 2],
                order: ByteOrder::Big,
            },
        });
        container
    }

    #[test]
    fn val_definition_strided_samples() {
        let container = traces();
        assert_eq!(container.find("traces"), Some(0));
        let all = container.numbers(0).unwrap();
        assert_eq!(all, [0.0, 1.0, 2.0, 10.0, 11.0, 12.0]);
        let integers = container.integers(0).unwrap();
        assert_eq!(integers, Some(vec![0, 1, 2, 10, 11, 12]));
        let mut out = [0; 4];
        container.read(0, &[0..2, 1..2], &mut out).unwrap();
        assert_eq!(out, [1i16.to_ne_bytes(), 11i16.to_ne_bytes()].concat()[..]);
    }
}
