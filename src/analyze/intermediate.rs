//! The matrix between the two halves of a transform in space and time: in memory, or in a scratch file.

use std::marker::PhantomData;
use std::ops::Range;

use ndarray::{ArrayView2, s};
use num_complex::Complex;
use rayon::prelude::*;

use super::plan::Plan;
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
    Spilled {
        file: SpillFile<T>,
        /// Rows read at once.
        together: usize,
        /// The rows that are held, stripe by stripe.
        held: Range<usize>,
        values: Vec<Complex<T>>,
    },
}

impl<T: Real> Intermediate<T> {
    /// As planned.
    pub fn new(plan: &Plan) -> Result<Self> {
        let shape = (plan.between_rows(), plan.axes.n_sites);
        if plan.scratch_file == 0 {
            let buffer = Buffer::zeros(shape)?;
            return Ok(Intermediate::Memory { buffer, shape });
        }
        Ok(Intermediate::Spilled {
            file: SpillFile::new(shape, plan.tiles.sites)?,
            together: plan.blocks.scratch * plan.segments.count(),
            held: 0..0,
            values: Vec::new(),
        })
    }

    /// Makes `rows`, which come in order, ready to be viewed; reads some of the following ones with them.
    pub fn hold(&mut self, rows: Range<usize>) -> Result<()> {
        let Intermediate::Spilled {
            file,
            together,
            held,
            values,
        } = self
        else {
            return Ok(());
        };
        if held.start <= rows.start && rows.end <= held.end {
            return Ok(());
        }
        let (start, stripe) = (rows.start, file.stripe);
        *held = start..file.shape.0.min(start + rows.len().max(*together));
        values.resize(held.len() * file.shape.1, Complex::default());
        let pieces = values.par_chunks_mut(held.len() * stripe).enumerate();
        pieces.try_for_each(|(i, piece)| file.read((start, i * stripe), piece))
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
            Intermediate::Spilled {
                file, held, values, ..
            } => {
                let (count, sites) = (rows.len(), file.shape.1);
                room.resize(count * sites, Complex::default());
                let stripes = values.chunks(held.len() * file.stripe);
                for (stripe, piece) in stripes.enumerate() {
                    let width = piece.len() / held.len();
                    let from = piece[(rows.start - held.start) * width..].chunks_exact(width);
                    for (row, from) in room.chunks_exact_mut(sites).zip(from) {
                        row[stripe * file.stripe..][..width].copy_from_slice(from);
                    }
                }
                ArrayView2::from_shape((count, sites), &room[..]).expect("as long as its shape")
            }
        }
    }
}

/// A scratch file of stripes of a few columns one after the other, each stripe row by row.
///
/// A stripe is written in one piece, by one thread. Neighbouring rows are one piece in every stripe.
/// In a file of whole rows, writing a stripe would take one piece per row.
#[derive(Debug)]
pub(super) struct SpillFile<T: Real> {
    file: ScratchFile,
    shape: (usize, usize),
    /// Columns a stripe; the last may be narrower.
    stripe: usize,
    of: PhantomData<T>,
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
    /// A file for a matrix of `shape` in stripes of `stripe` columns.
    pub fn new(shape: (usize, usize), stripe: usize) -> Result<Self> {
        let bytes = scratch_bytes(shape, stripe, size_of::<Complex<T>>() as u64);
        Ok(SpillFile {
            file: ScratchFile::new(bytes)?,
            shape,
            stripe,
            of: PhantomData,
        })
    }

    /// Byte of the first number of `row` in the stripe that starts with `column`.
    fn place(&self, (row, column): (usize, usize)) -> u64 {
        let item = size_of::<Complex<T>>() as u64;
        let width = self.stripe.min(self.shape.1 - column);
        let stripe = (column / self.stripe) as u64;
        stripe * stripe_bytes(self.shape.0, self.stripe, item) + (row * width) as u64 * item
    }

    /// Writes neighbouring rows of the stripe that starts with a column; `first` is their first row, and that column.
    pub fn write(&self, first: (usize, usize), values: &[Complex<T>]) -> Result<()> {
        let bytes = bytemuck::cast_slice(values);
        self.file.write(self.place(first), bytes)
    }

    /// Reads what [`Self::write`] wrote.
    pub fn read(&self, first: (usize, usize), values: &mut [Complex<T>]) -> Result<()> {
        let bytes = bytemuck::cast_slice_mut(values);
        self.file.read(self.place(first), bytes)
    }
}
