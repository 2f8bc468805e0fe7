//! The matrix between the two halves of a space-time transform: in memory, or in a scratch file.

use std::ops::Range;

use ndarray::{ArrayView2, s};
use num_complex::Complex;
use rayon::prelude::*;

use crate::error::Result;
use crate::field::ScratchFile;
use crate::system::buffer::Buffer;
use crate::transform::Real;

/// `(frequency x segment, site)`: written by columns, read by rows.
#[derive(Debug)]
pub(super) enum Intermediate<T: Real> {
    Memory {
        buffer: Buffer<Complex<T>>,
        shape: (usize, usize),
    },
    SpillFile(SpillFile<T>),
}

impl<T: Real> Intermediate<T> {
    pub fn in_memory(shape: (usize, usize)) -> Result<Self> {
        let buffer = Buffer::zeros(shape)?;
        Ok(Intermediate::Memory { buffer, shape })
    }

    /// Makes `rows`, which come in order, ready to be viewed.
    pub fn hold(&mut self, rows: Range<usize>) -> Result<()> {
        match self {
            Intermediate::Memory { .. } => Ok(()),
            Intermediate::SpillFile(scratch) => scratch.hold(rows),
        }
    }

    /// Rows that are held; copied to `room` if they are not contiguous.
    pub fn view<'r>(
        &'r self,
        rows: Range<usize>,
        room: &'r mut Vec<Complex<T>>,
    ) -> ArrayView2<'r, Complex<T>> {
        match self {
            Intermediate::Memory { buffer, shape } => {
                let all = buffer.view(*shape).expect("of this shape");
                all.slice_move(s![rows, ..])
            }
            Intermediate::SpillFile(scratch) => {
                let shape = (rows.len(), scratch.shape.1);
                room.resize(shape.0 * shape.1, Complex::default());
                scratch.gather(rows, room);
                ArrayView2::from_shape(shape, &room[..]).expect("as long as its shape says")
            }
        }
    }
}

/// A scratch file of stripes of a few columns one after the other, each stripe row by row.
///
/// A thread computes one stripe at a time and writes it in one piece. Neighbouring rows are one
/// piece in every stripe. In a file of whole rows, writing a stripe would take one piece per row.
#[derive(Debug)]
pub(super) struct SpillFile<T: Real> {
    file: ScratchFile,
    shape: (usize, usize),
    /// Columns a stripe; the last may be narrower.
    stripe: usize,
    /// Rows read at once.
    together: usize,
    /// The rows that are held, stripe by stripe.
    held: Range<usize>,
    values: Vec<Complex<T>>,
}

/// Stripes of many pages start with a page, since one that two threads write to is written twice.
const PAGE: u64 = 4096;

/// Distance of neighbouring stripes in bytes; `item` is the size of an element.
fn stripe_bytes(rows: usize, columns: usize, item: u64) -> u64 {
    let bytes = rows as u64 * columns as u64 * item;
    match bytes < 16 * PAGE {
        true => bytes,
        false => bytes.next_multiple_of(PAGE),
    }
}

/// Bytes of a spill file for a matrix of `shape` with elements of `item` bytes, in stripes of
/// `stripe` columns.
pub(super) fn scratch_bytes(shape: (usize, usize), stripe: usize, item: u64) -> u64 {
    shape.1.div_ceil(stripe) as u64 * stripe_bytes(shape.0, stripe, item)
}

impl<T: Real> SpillFile<T> {
    /// A file for a matrix of `shape`, written `stripe` columns and read `together` rows at a time.
    pub fn new(shape: (usize, usize), stripe: usize, together: usize) -> Result<Self> {
        let bytes = scratch_bytes(shape, stripe, size_of::<Complex<T>>() as u64);
        Ok(SpillFile {
            file: ScratchFile::new(bytes)?,
            shape,
            stripe,
            together,
            held: 0..0,
            values: Vec::new(),
        })
    }

    /// Byte at which a stripe starts.
    fn start_of(&self, stripe: usize) -> u64 {
        let item = size_of::<Complex<T>>() as u64;
        stripe as u64 * stripe_bytes(self.shape.0, self.stripe, item)
    }

    /// Writes the stripe that starts with column `first`, which is contiguous.
    pub fn put(&self, first: usize, columns: ArrayView2<Complex<T>>) -> Result<()> {
        let at = self.start_of(first / self.stripe);
        let columns = columns.to_slice().expect("a stripe of its own");
        self.file.write(at, bytemuck::cast_slice(columns))
    }

    /// Reads `rows` and some of the following ones, unless they are held.
    fn hold(&mut self, rows: Range<usize>) -> Result<()> {
        if self.held.start <= rows.start && rows.end <= self.held.end {
            return Ok(());
        }
        let end = self.shape.0.min(rows.start + self.together.max(rows.len()));
        let held = rows.start..end;
        let mut values = std::mem::take(&mut self.values);
        self.held = 0..0;
        values.resize(held.len() * self.shape.1, Complex::default());
        values
            .par_chunks_mut(held.len() * self.stripe)
            .enumerate()
            .try_for_each(|(stripe, piece)| {
                let row = (size_of_val(piece) / held.len()) as u64;
                let at = self.start_of(stripe) + held.start as u64 * row;
                self.file.read(at, bytemuck::cast_slice_mut(piece))
            })?;
        self.values = values;
        self.held = held;
        Ok(())
    }

    /// Copies rows that are held.
    fn gather(&self, rows: Range<usize>, out: &mut [Complex<T>]) {
        let stripes = self.values.chunks(self.held.len() * self.stripe);
        for (stripe, piece) in stripes.enumerate() {
            let width = piece.len() / self.held.len();
            let first = (rows.start - self.held.start) * width;
            let from = piece[first..].chunks_exact(width);
            for (row, from) in out.chunks_exact_mut(self.shape.1).zip(from) {
                row[stripe * self.stripe..][..width].copy_from_slice(from);
            }
        }
    }
}
