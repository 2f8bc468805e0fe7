//! Stored samples, read in blocks as `f64`.
//!
//! The samples form rows of contiguous samples at equal distances, in memory or in a mapped file, at
//! any byte offset.
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
    /// Of a file, unpacked or decoded.
    Unpacked(wavecascade_formats::Bytes),
    Values(Arc<Vec<f64>>),
    /// Of an owner outside of the library.
    Shared(SharedBytes),
}

impl Bytes {
    pub(crate) fn as_slice(&self) -> &[u8] {
        match self {
            Bytes::File(bytes) | Bytes::Spilled(bytes) => bytes,
            Bytes::Unpacked(bytes) => (**bytes).as_ref(),
            Bytes::Shared(bytes) => bytes.as_slice(),
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
    /// Samples from the start of one row to that of the next, at least as many as a row has.
    pub(crate) row_len: usize,
    /// Whether a row holds the sites of one time, or the times of one site.
    pub(crate) rows_are_times: bool,
}

impl Arrangement {
    /// Rows of samples `(time, site)` of this shape, whose bytes from time to time and from site to site are `strides`;
    /// `None` where they lie in no rows.
    pub(crate) fn of_strides(
        (sample, order): (SampleType, ByteOrder),
        start: usize,
        shape: [usize; 2],
        strides: [isize; 2],
    ) -> Option<Arrangement> {
        let size = sample.bytes() as isize;
        [true, false].into_iter().find_map(|rows_are_times| {
            let (rows, width) = by_rows(rows_are_times, shape[0], shape[1]);
            let (slow, fast) = by_rows(rows_are_times, strides[0], strides[1]);
            let is_contiguous = fast == size || width == 1;
            let is_apart = slow % size == 0 && slow >= size.saturating_mul(width as isize);
            (is_contiguous && (is_apart || rows == 1)).then_some(Arrangement {
                sample,
                order,
                start,
                row_len: if rows == 1 {
                    width
                } else {
                    (slow / size) as usize
                },
                rows_are_times,
            })
        })
    }
}

/// A number for all samples, or one for each time or site.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Factor {
    One(f64),
    Times(Vec<f64>),
    Sites(Vec<f64>),
}

impl Factor {
    fn at(&self, time: usize, site: usize) -> f64 {
        match self {
            Factor::One(number) => *number,
            Factor::Times(numbers) => numbers[time],
            Factor::Sites(numbers) => numbers[site],
        }
    }

    /// That of the part that begins at this time and site.
    fn from(&self, time: usize, site: usize) -> Factor {
        match self {
            Factor::One(number) => Factor::One(*number),
            Factor::Times(numbers) => Factor::Times(numbers[time..].to_vec()),
            Factor::Sites(numbers) => Factor::Sites(numbers[site..].to_vec()),
        }
    }

    fn transposed(&self) -> Factor {
        match self.clone() {
            Factor::Times(numbers) => Factor::Sites(numbers),
            Factor::Sites(numbers) => Factor::Times(numbers),
            one => one,
        }
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
    fn is_scaled(&self) -> bool {
        (&self.scale, &self.offset) != (&Factor::One(1.0), &Factor::One(0.0))
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
            if let (Factor::One(scale), Factor::One(offset), true) =
                (&self.scale, &self.offset, self.is_scaled())
            {
                for number in part {
                    *number = scale * *number + offset;
                }
            }
        }
        if let (Factor::One(_), Factor::One(_)) = (&self.scale, &self.offset) {
            return;
        }
        let (rows, columns) = by_rows(!site_major, times, sites);
        for (row, numbers) in rows.zip(numbers.chunks_mut(columns.len())) {
            for (column, number) in columns.clone().zip(numbers) {
                let (time, site) = by_rows(!site_major, row, column);
                *number = self.scale.at(time, site) * *number + self.offset.at(time, site);
            }
        }
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Storage {
    bytes: Bytes,
    arrangement: Arrangement,
    /// Bytes from time to time and from site to site, of samples that lie in no rows.
    strides: Option<[isize; 2]>,
    packing: Option<Arc<Packing>>,
}

impl Storage {
    pub(crate) fn new(bytes: Bytes, arrangement: Arrangement) -> Self {
        Storage {
            bytes,
            arrangement,
            strides: None,
            packing: None,
        }
    }

    /// Samples whose bytes from time to time and from site to site are `strides`, all within `bytes`: in rows, if they lie
    /// so. Else the length of rows is not that of the bytes.
    pub(crate) fn of_strides(
        bytes: Bytes,
        numbers: (SampleType, ByteOrder),
        start: usize,
        shape: [usize; 2],
        strides: [isize; 2],
    ) -> Self {
        if let Some(rows) = Arrangement::of_strides(numbers, start, shape, strides) {
            return Storage::new(bytes, rows);
        }
        let [time, site] = strides.map(isize::unsigned_abs);
        let rows_are_times = time >= site;
        let arrangement = Arrangement {
            sample: numbers.0,
            order: numbers.1,
            start,
            row_len: by_rows(rows_are_times, shape[0], shape[1]).1,
            rows_are_times,
        };
        Storage {
            strides: Some(strides),
            ..Storage::new(bytes, arrangement)
        }
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
        let at = self.arrangement;
        let (row, column) = by_rows(at.rows_are_times, time, site);
        self.arrangement.start = match self.strides {
            Some(strides) => offset(at.start, strides, time, site),
            None => at.start + (row * at.row_len + column) * at.sample.bytes(),
        };
        self.with_factors(|factor| factor.from(time, site))
    }

    /// `values` in rows of `row_len`.
    pub(crate) fn from_values(values: Vec<f64>, row_len: usize, rows_are_times: bool) -> Self {
        Storage::of_numbers(Bytes::Values(Arc::new(values)), row_len, rows_are_times)
    }

    /// Numbers in double precision in rows of `row_len`.
    pub(crate) fn of_numbers(bytes: Bytes, row_len: usize, rows_are_times: bool) -> Self {
        let arrangement = Arrangement {
            sample: SampleType::F64,
            order: ByteOrder::NATIVE,
            start: 0,
            row_len,
            rows_are_times,
        };
        Storage::new(bytes, arrangement)
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
        let rows = match rows.is_standard_layout() {
            true => rows,
            false => rows.as_standard_layout().into_owned(),
        };
        let len = rows.len();
        let (mut values, offset) = rows.into_raw_vec_and_offset();
        values.drain(..offset.unwrap_or(0));
        values.truncate(len);
        Storage::from_values(values, row_len, rows_are_times)
    }

    /// The same samples with times for sites.
    pub(crate) fn transposed(&self) -> Storage {
        let mut storage = self.clone();
        storage.arrangement.rows_are_times ^= true;
        storage.strides = storage.strides.map(|[time, site]| [site, time]);
        storage.with_factors(Factor::transposed)
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

    /// Whether a row holds the sites of one time.
    pub(crate) fn rows_are_times(&self) -> bool {
        self.arrangement.rows_are_times
    }

    /// Relative rounding error of a sample.
    pub(crate) fn relative_rounding(&self) -> f64 {
        self.arrangement.sample.relative_rounding()
    }

    /// Whether every sample is a number in single precision.
    pub(crate) fn is_single(&self) -> bool {
        use SampleType::{Bool, F16, F32, I8, I16, U8, U16};
        let is_short = matches!(
            self.arrangement.sample,
            F32 | F16 | I8 | I16 | U8 | U16 | Bool
        );
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
        let at = self.arrangement;
        let is_native = at.sample == SampleType::F64 && at.order == ByteOrder::NATIVE;
        let is_in_rows = self.strides.is_none() && at.row_len == row_len;
        if !is_native || self.packing.is_some() || !is_in_rows {
            return None;
        }
        let bytes = &self.bytes.as_slice()[at.start..];
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
        let Arrangement { sample, order, .. } = self.arrangement;
        let Arrangement { start, row_len, .. } = self.arrangement;
        let rows_are_times = self.rows_are_times();
        let (rows, columns) = by_rows(rows_are_times, times.clone(), sites.clone());
        if rows.is_empty() || columns.is_empty() {
            return;
        }
        let transposed = rows_are_times == site_major;
        let strided = self.strides.map(|strides| {
            let (row, column) = by_rows(rows_are_times, strides[0], strides[1]);
            StridedBlock {
                bytes: self.bytes.as_slice(),
                start,
                strides: [row, column],
                rows: rows.clone(),
                columns: columns.clone(),
                transposed,
            }
        });
        // Strides may lead below the first sample.
        let from = if strided.is_some() { 0 } else { start };
        let block = ReadBlock {
            bytes: &self.bytes.as_slice()[from..],
            row_len,
            rows,
            columns,
            transposed,
        };
        macro_rules! decode {
            ($type:ty, $value:expr) => {
                match (&strided, order) {
                    (None, ByteOrder::Little) => {
                        block.read(|b| $value(<$type>::from_le_bytes(b)), out)
                    }
                    (None, ByteOrder::Big) => {
                        block.read(|b| $value(<$type>::from_be_bytes(b)), out)
                    }
                    (Some(strided), order) => strided.read(
                        |b| match order {
                            ByteOrder::Little => $value(<$type>::from_le_bytes(b)),
                            ByteOrder::Big => $value(<$type>::from_be_bytes(b)),
                        },
                        out,
                    ),
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
        let Arrangement { start, row_len, .. } = self.arrangement;
        let (rows, columns) = by_rows(self.rows_are_times(), times, sites);
        let size = self.arrangement.sample.bytes();
        if let Some(bytes) = self.mapped() {
            for row in rows {
                let at = |column: usize| start + (row * row_len + column) * size;
                bytes.fetch(at(columns.start)..at(columns.end));
            }
        }
    }

    /// As [`Storage::release_pages`], for the whole rows of a block and the pages mapped around
    /// them.
    pub(crate) fn release_block(&self, times: Range<usize>, sites: Range<usize>) {
        let Arrangement { start, row_len, .. } = self.arrangement;
        let (rows, _) = by_rows(self.rows_are_times(), times, sites);
        let row = row_len * self.arrangement.sample.bytes();
        if let Some(bytes) = self.mapped() {
            let from = start + rows.start * row;
            let end = start + rows.end * row + MAPPED_AROUND;
            bytes.release(from.saturating_sub(MAPPED_AROUND)..bytes.len().min(end));
        }
    }
}

/// The byte of a sample.
fn offset(start: usize, strides: [isize; 2], time: usize, site: usize) -> usize {
    start
        .wrapping_add_signed(strides[0] * time as isize)
        .wrapping_add_signed(strides[1] * site as isize)
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
