//! Decodes arrays stored by columns.

use std::ops::Range;

use crate::container::{Block, Decoder};
use crate::{ByteOrder, Bytes, Error, Result, Sample};

/// Where the bytes of an array are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    /// In the file.
    File,
    /// In an inflated variable.
    Inflated(usize),
}

/// An array that is decoded. All of it lies within its source.
pub(super) struct Stored {
    pub(super) path: String,
    pub(super) source: Source,
    pub(super) start: usize,
    pub(super) strides: Vec<u64>,
    pub(super) order: ByteOrder,
    /// Type of the stored numbers.
    pub(super) disk: Sample,
    /// Type that MATLAB gives them.
    pub(super) class: Sample,
}

/// Decodes arrays stored by columns.
pub(super) struct Columns {
    pub(super) file: Bytes,
    pub(super) inflated: Vec<Vec<u8>>,
    /// One a variable.
    pub(super) stored: Vec<Option<Stored>>,
}

impl Decoder for Columns {
    fn read(&self, variable: usize, block: Block, out: &mut [u8]) -> Result<()> {
        let Some(stored) = &self.stored[variable] else {
            unreachable!("what is encoded was stored");
        };
        let bytes = match stored.source {
            Source::File => (*self.file).as_ref(),
            Source::Inflated(i) => &self.inflated[i],
        };
        let (Some((last, outer)), Some((stride, outer_strides))) =
            (block.split_last(), stored.strides.split_last())
        else {
            unreachable!("arrays of MATLAB have two dimensions or more");
        };
        let row = (last.end - last.start) as usize;
        let mut index: Vec<u64> = outer.iter().map(|range| range.start).collect();
        for row_out in out.chunks_exact_mut(row * stored.class.bytes()) {
            let offset: u64 = index.iter().zip(outer_strides).map(|(i, s)| i * s).sum();
            let from = stored.start + (offset + last.start * stride) as usize;
            stored.read_row(bytes, from, *stride as usize, row_out)?;
            advance(&mut index, outer);
        }
        Ok(())
    }
}

impl Stored {
    fn read_row(&self, bytes: &[u8], from: usize, stride: usize, out: &mut [u8]) -> Result<()> {
        let size = self.disk.bytes();
        for (i, out) in out.chunks_exact_mut(self.class.bytes()).enumerate() {
            let one = &bytes[from + i * stride..][..size];
            if self.disk == self.class {
                out.copy_from_slice(one);
                if self.order != ByteOrder::NATIVE {
                    out.reverse();
                }
            } else {
                self.convert(one, out)?;
            }
        }
        Ok(())
    }

    fn convert(&self, one: &[u8], out: &mut [u8]) -> Result<()> {
        let float = || self.disk.to_f64(self.order, one);
        macro_rules! integer {
            ($type:ty) => {{
                let integer = self.disk.to_i64(self.order, one);
                let fitting = integer.and_then(|n| <$type>::try_from(n).ok());
                match fitting {
                    Some(n) => out.copy_from_slice(&n.to_ne_bytes()),
                    None => return Err(self.misfit(float())),
                }
            }};
        }
        match self.class {
            Sample::F64 => out.copy_from_slice(&float().to_ne_bytes()),
            Sample::F32 => out.copy_from_slice(&(float() as f32).to_ne_bytes()),
            Sample::Bool => out.fill(u8::from(float() != 0.0)),
            Sample::I8 => integer!(i8),
            Sample::I16 => integer!(i16),
            Sample::I32 => integer!(i32),
            Sample::I64 => integer!(i64),
            Sample::U8 => integer!(u8),
            Sample::U16 => integer!(u16),
            Sample::U32 => integer!(u32),
            Sample::U64 => integer!(u64),
            Sample::F16 | Sample::IbmF32 => unreachable!("no class of MATLAB"),
        }
        Ok(())
    }

    fn misfit(&self, found: f64) -> Error {
        let place = format!("variable {}", self.path);
        let expected = format!("numbers that fit in {}", self.class.name());
        Error::damaged(place, expected, found.to_string())
    }
}

/// The next index, the last fastest.
fn advance(index: &mut [u64], block: &[Range<u64>]) {
    for (i, range) in index.iter_mut().zip(block).rev() {
        *i += 1;
        if *i < range.end {
            return;
        }
        *i = range.start;
    }
}
