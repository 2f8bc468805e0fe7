//! Stored samples, read in blocks as `f64`.
//!
//! The samples form contiguous rows of `row_len`, in memory or in a mapped file, at any byte
//! offset.
//!
//! A mapped file must not be truncated by another program while it is open: reading a missing page
//! ends the process.

use std::ops::Range;
use std::sync::Arc;

use ndarray::Array2;

use super::block::ReadBlock;
use super::file_bytes::FileBytes;

/// Type of one stored sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SampleType {
    F64,
    F32,
    F16,
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
    Bool,
}

impl SampleType {
    /// Bytes of one sample.
    pub(crate) fn bytes(self) -> usize {
        use SampleType::*;
        match self {
            I8 | U8 | Bool => 1,
            F16 | I16 | U16 => 2,
            F32 | I32 | U32 => 4,
            F64 | I64 | U64 => 8,
        }
    }

    /// Relative rounding error of a stored number.
    pub(crate) fn relative_rounding(self) -> f64 {
        match self {
            SampleType::F16 => 1.0 / 1024.0,
            SampleType::F32 => f64::from(f32::EPSILON),
            _ => f64::EPSILON,
        }
    }
}

/// Byte order of one stored sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ByteOrder {
    Little,
    Big,
}

impl ByteOrder {
    pub(crate) const NATIVE: ByteOrder = if cfg!(target_endian = "big") {
        ByteOrder::Big
    } else {
        ByteOrder::Little
    };
}

/// Owner of the samples' bytes.
#[derive(Debug, Clone)]
pub(crate) enum Bytes {
    File(Arc<FileBytes>),
    Inflated(Arc<Vec<u8>>),
    Values(Arc<Vec<f64>>),
}

impl Bytes {
    pub(crate) fn as_slice(&self) -> &[u8] {
        match self {
            Bytes::File(bytes) => bytes,
            Bytes::Inflated(bytes) => bytes,
            // SAFETY: the slice covers exactly the vector's initialized values. Every byte of an
            // `f64` is a valid `u8`, which needs no alignment.
            Bytes::Values(values) => unsafe {
                std::slice::from_raw_parts(values.as_ptr().cast(), size_of_val(values.as_slice()))
            },
        }
    }
}

/// Memory layout of the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Arrangement {
    pub(crate) sample: SampleType,
    pub(crate) order: ByteOrder,
    /// Byte offset of the first sample.
    pub(crate) start: usize,
    /// Samples per contiguous row.
    pub(crate) row_len: usize,
    /// Whether a row holds the sites of one time, or the times of one site.
    pub(crate) rows_are_times: bool,
}

#[derive(Debug, Clone)]
pub(crate) struct Storage {
    bytes: Bytes,
    arrangement: Arrangement,
}

impl Storage {
    pub(crate) fn new(bytes: Bytes, arrangement: Arrangement) -> Self {
        Storage { bytes, arrangement }
    }

    /// `values` in rows of `row_len`.
    pub(crate) fn from_values(values: Vec<f64>, row_len: usize, rows_are_times: bool) -> Self {
        Storage::new(
            Bytes::Values(Arc::new(values)),
            Arrangement {
                sample: SampleType::F64,
                order: ByteOrder::NATIVE,
                start: 0,
                row_len,
                rows_are_times,
            },
        )
    }

    /// From an array `(time, site)`; not copied if contiguous in either order.
    pub(crate) fn from_array(values: Array2<f64>) -> Self {
        let rows_are_times = !values.t().is_standard_layout() || values.is_standard_layout();
        let rows = if rows_are_times {
            values
        } else {
            values.reversed_axes()
        };
        let row_len = rows.ncols();
        let rows = if rows.is_standard_layout() {
            rows
        } else {
            rows.as_standard_layout().into_owned()
        };
        let len = rows.len();
        let (mut values, offset) = rows.into_raw_vec_and_offset();
        values.drain(..offset.unwrap_or(0));
        values.truncate(len);
        Storage::from_values(values, row_len, rows_are_times)
    }

    /// Whether a row holds the sites of one time.
    pub(crate) fn rows_are_times(&self) -> bool {
        self.arrangement.rows_are_times
    }

    /// Relative rounding error of a sample.
    pub(crate) fn relative_rounding(&self) -> f64 {
        self.arrangement.sample.relative_rounding()
    }

    /// The bytes of the file, if the samples are read from them.
    pub(crate) fn file(&self) -> Option<&FileBytes> {
        match &self.bytes {
            Bytes::File(bytes) => Some(bytes),
            Bytes::Inflated(_) | Bytes::Values(_) => None,
        }
    }

    /// Bytes of samples that are no pages of a file.
    pub(crate) fn loaded_bytes(&self) -> u64 {
        match &self.bytes {
            Bytes::File(bytes) if !bytes.is_copy() => 0,
            held => held.as_slice().len() as u64,
        }
    }

    /// All rows in order without conversion, if they are aligned `f64` in native byte order.
    pub(crate) fn numbers(&self) -> Option<&[f64]> {
        let Arrangement {
            sample,
            order,
            start,
            ..
        } = self.arrangement;
        if sample != SampleType::F64 || order != ByteOrder::NATIVE {
            return None;
        }
        let bytes = &self.bytes.as_slice()[start..];
        bytemuck::try_cast_slice(&bytes[..bytes.len() / 8 * 8]).ok()
    }

    /// Copies a block to `out` in time-major or site-major order; `out` is as long as the block.
    ///
    /// # Panics
    /// If the block leaves the storage.
    pub(crate) fn read(
        &self,
        times: Range<usize>,
        sites: Range<usize>,
        site_major: bool,
        out: &mut [f64],
    ) {
        let Arrangement {
            sample,
            order,
            start,
            row_len,
            rows_are_times,
        } = self.arrangement;
        let (rows, columns) = if rows_are_times {
            (times, sites)
        } else {
            (sites, times)
        };
        if rows.is_empty() || columns.is_empty() {
            return;
        }
        let block = ReadBlock {
            bytes: &self.bytes.as_slice()[start..],
            row_len,
            rows,
            columns,
            transposed: rows_are_times == site_major,
        };
        macro_rules! decode {
            ($type:ty, $value:expr) => {
                match order {
                    ByteOrder::Little => block.read(|b| $value(<$type>::from_le_bytes(b)), out),
                    ByteOrder::Big => block.read(|b| $value(<$type>::from_be_bytes(b)), out),
                }
            };
        }
        match sample {
            SampleType::F64 => decode!(f64, f64::from),
            SampleType::F32 => decode!(f32, f64::from),
            SampleType::F16 => decode!(u16, half_to_f64),
            SampleType::I8 => decode!(i8, f64::from),
            SampleType::I16 => decode!(i16, f64::from),
            SampleType::I32 => decode!(i32, f64::from),
            SampleType::I64 => decode!(i64, |value| value as f64),
            SampleType::U8 => decode!(u8, f64::from),
            SampleType::U16 => decode!(u16, f64::from),
            SampleType::U32 => decode!(u32, f64::from),
            SampleType::U64 => decode!(u64, |value| value as f64),
            SampleType::Bool => decode!(u8, |value| f64::from(value != 0)),
        }
    }

    /// Lets the operating system drop the pages of a mapped file from memory.
    pub(crate) fn release_pages(&self) {
        if let Bytes::File(bytes) = &self.bytes {
            bytes.release(0..bytes.len());
        }
    }

    /// As [`Storage::release_pages`], for the whole rows of a block and the pages mapped around
    /// them.
    pub(crate) fn release_block(&self, times: Range<usize>, sites: Range<usize>) {
        let Arrangement {
            sample,
            start,
            row_len,
            rows_are_times,
            ..
        } = self.arrangement;
        let rows = if rows_are_times { times } else { sites };
        let row = row_len * sample.bytes();
        if let Bytes::File(bytes) = &self.bytes {
            let from = start + rows.start * row;
            let end = start + rows.end * row + MAPPED_AROUND;
            bytes.release(from.saturating_sub(MAPPED_AROUND)..bytes.len().min(end));
        }
    }
}

/// Bytes around a faulting page that the kernel maps with it if cached (fault-around).
const MAPPED_AROUND: usize = 64 << 10;

/// IEEE 754 binary16: 1 sign bit, 5 of exponent, 10 of fraction.
fn half_to_f64(bits: u16) -> f64 {
    let fraction = f64::from(bits & 0x3ff);
    let magnitude = match (bits >> 10) & 0x1f {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        exponent => (1024.0 + fraction) * 2f64.powi(i32::from(exponent) - 25),
    };
    if bits & 0x8000 == 0 {
        magnitude
    } else {
        -magnitude
    }
}
