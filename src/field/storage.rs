//! Stored samples, read in blocks as `f64`.
//!
//! The samples lie at equal distances along both axes, in memory or in a mapped file, at any byte offset; those of
//! one time or of one site are contiguous as a rule.
//!
//! A mapped file must not be truncated by another program while it is open: reading a missing page
//! ends the process.

use std::ops::Range;
use std::sync::Arc;

use ndarray::Array2;
pub(crate) use wavecascade_formats::{ByteOrder, Sample as SampleType};
use wavecascade_formats::{half_to_f64, ibm_to_f64};

use super::block::{ReadBlock, StridedBlock};
use super::file_bytes::FileBytes;
use super::memory::SharedBytes;

/// Owner of the samples' bytes.
#[derive(Debug, Clone)]
pub(crate) enum Bytes {
    File(Arc<FileBytes>),
    /// Decoded samples of a file in a scratch file.
    Spilled(Arc<FileBytes>),
    /// In memory.
    Held(SharedBytes),
}

impl Bytes {
    fn as_slice(&self) -> &[u8] {
        match self {
            Bytes::File(bytes) | Bytes::Spilled(bytes) => bytes,
            Bytes::Held(bytes) => bytes.as_slice(),
        }
    }

    fn of_values(values: Vec<f64>) -> Bytes {
        Bytes::Held(SharedBytes::new(Values(values)))
    }
}

struct Values(Vec<f64>);

impl AsRef<[u8]> for Values {
    fn as_ref(&self) -> &[u8] {
        bytemuck::cast_slice(&self.0)
    }
}

/// A number for all samples, or one for each time or site: that at `time * strides[0] + site * strides[1]`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Factor {
    numbers: Vec<f64>,
    strides: [usize; 2],
}

impl Factor {
    /// One number for all.
    pub(crate) fn one(number: f64) -> Factor {
        Factor::new(vec![number], [0, 0])
    }

    /// One for each time (strides 1 and 0) or each site (0 and 1).
    pub(crate) fn new(numbers: Vec<f64>, strides: [usize; 2]) -> Factor {
        Factor { numbers, strides }
    }

    /// The number, if there is one for all.
    pub(crate) fn only(&self) -> Option<f64> {
        (self.strides == [0, 0]).then(|| self.numbers[0])
    }

    /// Those of the part that begins at this time and site.
    fn from(&self, time: usize, site: usize) -> &[f64] {
        &self.numbers[time * self.strides[0] + site * self.strides[1]..]
    }
}

/// How stored numbers stand for samples: `scale * number + offset`, or a gap.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Packing {
    pub(crate) scale: Factor,
    pub(crate) offset: Factor,
    /// Numbers that stand for gaps, which are read as NaN.
    pub(crate) gaps: Vec<f64>,
    /// The least and the largest number that is no gap.
    pub(crate) valid: Option<[f64; 2]>,
}

impl Packing {
    /// Scale and offset, if they are those of all samples.
    fn linear(&self) -> Option<[f64; 2]> {
        Some([self.scale.only()?, self.offset.only()?])
    }

    fn is_scaled(&self) -> bool {
        self.linear() != Some([1.0, 0.0])
    }

    fn is_plain(&self) -> bool {
        !self.is_scaled() && self.gaps.is_empty() && self.valid.is_none()
    }

    /// Puts samples in place of the numbers of a block that stand for them. Each pass is free of branches, over a part
    /// that stays in L1.
    fn unpack(
        &self,
        numbers: &mut [f64],
        times: Range<usize>,
        sites: Range<usize>,
        site_major: bool,
    ) {
        const PART: usize = 1024;
        let single = self.linear();
        for part in numbers.chunks_mut(PART) {
            for &gap in &self.gaps {
                for number in &mut *part {
                    *number = if *number == gap { f64::NAN } else { *number };
                }
            }
            if let Some([least, most]) = self.valid {
                for number in &mut *part {
                    let is_valid = *number >= least && *number <= most;
                    *number = if is_valid { *number } else { f64::NAN };
                }
            }
            if let (Some([scale, offset]), true) = (single, self.is_scaled()) {
                for number in part {
                    *number = scale * *number + offset;
                }
            }
        }
        if single.is_some() {
            return;
        }
        let (rows, columns) = by_rows(!site_major, times, sites);
        for (row, numbers) in rows.zip(numbers.chunks_mut(columns.len())) {
            for (column, number) in columns.clone().zip(numbers) {
                let (time, site) = by_rows(!site_major, row, column);
                let [scale, offset] = [&self.scale, &self.offset].map(|of| of.from(time, site)[0]);
                *number = scale * *number + offset;
            }
        }
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Storage {
    bytes: Bytes,
    sample: SampleType,
    order: ByteOrder,
    /// Byte of the first sample.
    start: usize,
    /// Bytes from time to time and from site to site.
    strides: [isize; 2],
    packing: Option<Arc<Packing>>,
}

impl Storage {
    /// Samples `(time, site)` whose bytes from time to time and from site to site are `strides`, all within `bytes`.
    pub(crate) fn new(
        bytes: Bytes,
        (sample, order): (SampleType, ByteOrder),
        start: usize,
        [n_times, n_sites]: [usize; 2],
        [mut time, mut site]: [isize; 2],
    ) -> Self {
        // Nothing steps along an axis of one index.
        if n_sites == 1 {
            site = sample.bytes() as isize;
        }
        if n_times == 1 {
            time = site.saturating_mul(n_sites as isize);
        }
        Storage {
            bytes,
            sample,
            order,
            start,
            strides: [time, site],
            packing: None,
        }
    }

    /// Samples of this machine's byte order in rows of `row_len` samples, of times or of sites.
    pub(crate) fn in_rows(
        bytes: Bytes,
        sample: SampleType,
        row_len: usize,
        rows_are_times: bool,
    ) -> Self {
        let size = sample.bytes();
        let (time, site) = by_rows(rows_are_times, (row_len * size) as isize, size as isize);
        Storage {
            bytes,
            sample,
            order: ByteOrder::NATIVE,
            start: 0,
            strides: [time, site],
            packing: None,
        }
    }

    /// `values` in rows of `row_len`.
    pub(crate) fn from_values(values: Vec<f64>, row_len: usize, rows_are_times: bool) -> Self {
        let bytes = Bytes::of_values(values);
        Storage::in_rows(bytes, SampleType::F64, row_len, rows_are_times)
    }

    /// From an array `(time, site)`, which is not copied.
    pub(crate) fn from_array(values: Array2<f64>) -> Self {
        let size = size_of::<f64>();
        let shape = <[usize; 2]>::from(values.dim());
        let strides = [0, 1].map(|axis| values.strides()[axis] * size as isize);
        let (values, offset) = values.into_raw_vec_and_offset();
        let numbers = (SampleType::F64, ByteOrder::NATIVE);
        let start = offset.unwrap_or(0) * size;
        Storage::new(Bytes::of_values(values), numbers, start, shape, strides)
    }

    /// The same with numbers that stand for others.
    pub(crate) fn packed(self, packing: Packing) -> Self {
        Storage {
            packing: (!packing.is_plain()).then(|| Arc::new(packing)),
            ..self
        }
    }

    /// The part of the storage that begins at this time and site.
    pub(crate) fn from(mut self, time: usize, site: usize) -> Self {
        self.start = self.byte(time, site);
        let part = |of: &Factor| Factor::new(of.from(time, site).to_vec(), of.strides);
        self.with_factors(part)
    }

    /// The same samples with times for sites.
    pub(crate) fn transposed(&self) -> Storage {
        let mut storage = self.clone();
        storage.strides.reverse();
        storage.with_factors(|of| Factor::new(of.numbers.clone(), [of.strides[1], of.strides[0]]))
    }

    fn with_factors(self, of: impl Fn(&Factor) -> Factor) -> Storage {
        let packing = self.packing.map(|packing| {
            Arc::new(Packing {
                scale: of(&packing.scale),
                offset: of(&packing.offset),
                ..(*packing).clone()
            })
        });
        Storage { packing, ..self }
    }

    /// Whether the samples of one time are closer than those of one site.
    pub(crate) fn rows_are_times(&self) -> bool {
        let [time, site] = self.strides.map(isize::unsigned_abs);
        time >= site
    }

    /// Bytes from row to row and from column to column.
    fn by_rows(&self) -> [isize; 2] {
        let [time, site] = self.strides;
        by_rows(self.rows_are_times(), time, site).into()
    }

    /// Samples from the start of one row to that of the next, where those of a row are contiguous.
    fn row_len(&self) -> Option<usize> {
        let ([row, column], size) = (self.by_rows(), self.sample.bytes() as isize);
        let is_in_rows = column == size && row % size == 0;
        usize::try_from(row / size).ok().filter(|_| is_in_rows)
    }

    /// The byte of a sample.
    fn byte(&self, time: usize, site: usize) -> usize {
        let from_first = self.strides[0] * time as isize + self.strides[1] * site as isize;
        self.start.wrapping_add_signed(from_first)
    }

    /// Relative rounding error of a sample.
    pub(crate) fn relative_rounding(&self) -> f64 {
        self.sample.relative_rounding()
    }

    /// Whether every sample is a number in single precision.
    pub(crate) fn is_single(&self) -> bool {
        use SampleType::{Bool, F16, F32, I8, I16, U8, U16};
        let is_short = matches!(self.sample, F32 | F16 | I8 | I16 | U8 | U16 | Bool);
        let packing = self.packing.as_ref();
        is_short && !packing.is_some_and(|packing| packing.is_scaled())
    }

    /// The bytes of the file, if the samples are read from them.
    pub(crate) fn file(&self) -> Option<&FileBytes> {
        match &self.bytes {
            Bytes::File(bytes) => Some(bytes),
            _ => None,
        }
    }

    /// Those that are pages of a file, of that of the field or of a scratch file.
    pub(crate) fn mapped(&self) -> Option<&FileBytes> {
        match &self.bytes {
            Bytes::File(bytes) | Bytes::Spilled(bytes) => Some(bytes),
            _ => None,
        }
    }

    /// Bytes of samples that are no pages of a file.
    pub(crate) fn loaded_bytes(&self) -> u64 {
        match &self.bytes {
            Bytes::File(bytes) if !bytes.is_copy() => 0,
            Bytes::Spilled(_) => 0,
            held => held.as_slice().len() as u64,
        }
    }

    /// All rows in order without conversion, if they are aligned `f64` in native byte order, each of
    /// `row_len` samples with nothing between them.
    pub(crate) fn numbers(&self, row_len: usize) -> Option<&[f64]> {
        let is_native = self.sample == SampleType::F64 && self.order == ByteOrder::NATIVE;
        if !is_native || self.packing.is_some() || self.row_len() != Some(row_len) {
            return None;
        }
        let bytes = &self.bytes.as_slice()[self.start..];
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
        let rows_are_times = self.rows_are_times();
        let (rows, columns) = by_rows(rows_are_times, times.clone(), sites.clone());
        if rows.is_empty() || columns.is_empty() {
            return;
        }
        let transposed = rows_are_times == site_major;
        let bytes = self.bytes.as_slice();
        let block = self.row_len().map(|row_len| ReadBlock {
            bytes: &bytes[self.start..],
            row_len,
            rows: rows.clone(),
            columns: columns.clone(),
            transposed,
        });
        let strided = StridedBlock {
            bytes,
            start: self.start,
            strides: self.by_rows(),
            rows,
            columns,
            transposed,
        };
        macro_rules! decode {
            ($type:ty, $value:expr) => {
                match (&block, self.order) {
                    (Some(block), ByteOrder::Little) => {
                        block.read(|b| $value(<$type>::from_le_bytes(b)), out)
                    }
                    (Some(block), ByteOrder::Big) => {
                        block.read(|b| $value(<$type>::from_be_bytes(b)), out)
                    }
                    (None, order) => strided.read(
                        |b| match order {
                            ByteOrder::Little => $value(<$type>::from_le_bytes(b)),
                            ByteOrder::Big => $value(<$type>::from_be_bytes(b)),
                        },
                        out,
                    ),
                }
            };
        }
        match self.sample {
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
            SampleType::IbmF32 => decode!(u32, ibm_to_f64),
        }
        if let Some(packing) = &self.packing {
            packing.unpack(out, times, sites, site_major);
        }
    }

    /// Lets the operating system drop the pages of a mapped file from memory.
    pub(crate) fn release_pages(&self) {
        if let Some(bytes) = self.mapped() {
            bytes.release(0..bytes.len());
        }
    }

    /// Has the system read the samples of a block, row by row. A fault on a page would read as much again
    /// around it, of which short pieces of rows use little.
    pub(crate) fn fetch_block(&self, times: Range<usize>, sites: Range<usize>) {
        let rows_are_times = self.rows_are_times();
        let (rows, columns) = by_rows(rows_are_times, times, sites);
        let Some(bytes) = self.mapped() else { return };
        for row in rows {
            let at = |column| {
                let (time, site) = by_rows(rows_are_times, row, column);
                self.byte(time, site)
            };
            bytes.fetch(at(columns.start)..at(columns.end));
        }
    }

    /// As [`Storage::release_pages`], for the whole rows of a block and the pages mapped around
    /// them.
    pub(crate) fn release_block(&self, times: Range<usize>, sites: Range<usize>) {
        let (rows, _) = by_rows(self.rows_are_times(), times, sites);
        let row = self.by_rows()[0].unsigned_abs();
        if let Some(bytes) = self.mapped() {
            let from = self.start + rows.start * row;
            let end = self.start + rows.end * row + MAPPED_AROUND;
            bytes.release(from.saturating_sub(MAPPED_AROUND)..bytes.len().min(end));
        }
    }
}

/// What counts rows and what counts columns, of what counts times and what counts sites.
pub(super) fn by_rows<T>(rows_are_times: bool, times: T, sites: T) -> (T, T) {
    match rows_are_times {
        true => (times, sites),
        false => (sites, times),
    }
}

/// Bytes around a faulting page that the kernel maps with it if cached (fault-around).
const MAPPED_AROUND: usize = 64 << 10;
