//! The matrix between the two halves of a space-time transform: in memory, or in a scratch file.

use std::fs::File;
use std::path::PathBuf;

use ndarray::{Array2, ArrayView2, ArrayViewMut2, s};
use num_complex::Complex;

use crate::buffer::Buffer;
use crate::error::{Error, Result};
use crate::io::{read_at, write_at};
use crate::transform::Real;

/// `(frequency x segment, site)`: written by columns, read by rows.
#[derive(Debug)]
pub(super) enum Between<T: Real> {
    Memory {
        buffer: Buffer<Complex<T>>,
        shape: (usize, usize),
    },
    Scratch {
        file: File,
        shape: (usize, usize),
        place: PathBuf,
    },
}

impl<T: Real> Between<T> {
    pub fn in_memory(shape: (usize, usize)) -> Result<Self> {
        let buffer = Buffer::zeros(shape)?;
        Ok(Between::Memory { buffer, shape })
    }

    /// An unnamed file that is gone when it is closed, however the program ends.
    pub fn in_scratch(shape: (usize, usize)) -> Result<Self> {
        let place = std::env::temp_dir();
        let file = tempfile::tempfile().map_err(Error::write("make a scratch file in", &place))?;
        let bytes = (shape.0 * shape.1 * size_of::<Complex<T>>()) as u64;
        crate::io::allocate(&file, 0, bytes)
            .map_err(Error::write("reserve room for a scratch file in", &place))?;
        Ok(Between::Scratch { file, shape, place })
    }

    /// `fill` gets the columns `from .. from + width`, to be written whole.
    pub fn with_columns(
        &mut self,
        from: usize,
        width: usize,
        fill: impl FnOnce(ArrayViewMut2<Complex<T>>) -> Result<()>,
    ) -> Result<()> {
        match self {
            Between::Memory { buffer, shape } => {
                let mut all = buffer.view_mut(*shape)?;
                fill(all.slice_mut(s![.., from..from + width]))
            }
            Between::Scratch { file, shape, place } => {
                let mut block = Array2::default((shape.0, width));
                fill(block.view_mut())?;
                for (m, row) in block.outer_iter().enumerate() {
                    let Some(row) = row.to_slice() else { continue };
                    let at = (m * shape.1 + from) * size_of::<Complex<T>>();
                    write_at(file, bytemuck::cast_slice(row), at as u64)
                        .map_err(Error::write("write to a scratch file in", place))?;
                }
                Ok(())
            }
        }
    }

    /// `read` gets the rows `from .. from + count`.
    pub fn with_rows<R>(
        &self,
        from: usize,
        count: usize,
        read: impl FnOnce(ArrayView2<Complex<T>>) -> R,
    ) -> Result<R> {
        match self {
            Between::Memory { buffer, shape } => {
                let all = buffer.view(*shape)?;
                Ok(read(all.slice(s![from..from + count, ..])))
            }
            Between::Scratch { file, shape, place } => {
                let mut block = Array2::default((count, shape.1));
                if let Some(values) = block.as_slice_mut() {
                    let at = from * shape.1 * size_of::<Complex<T>>();
                    read_at(file, bytemuck::cast_slice_mut(values), at as u64)
                        .map_err(Error::read("read a scratch file in", place))?;
                }
                Ok(read(block.view()))
            }
        }
    }
}
