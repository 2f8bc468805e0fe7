//! Memory for large arrays.

use std::marker::PhantomData;

use bytemuck::{Pod, cast_slice, cast_slice_mut};
use memmap2::MmapMut;
use ndarray::{ArrayView2, ArrayViewMut2};
use wavecascade_system::memory::huge_pages;

use crate::error::{Error, Result};

/// Zeroed memory for arrays, in huge pages where the system has them.
///
/// Fresh memory costs a fault a page, and filling a column looks up a page a row. Pages of 2 MiB
/// instead of 4 KiB make both rare.
#[derive(Debug)]
pub(crate) struct Buffer<T> {
    pages: MmapMut,
    of: PhantomData<T>,
}

impl<T: Pod> Buffer<T> {
    /// Zeroed memory for an array of `shape`.
    ///
    /// # Errors
    /// [`Error::Refused`] if there is not enough.
    pub fn zeros(shape: (usize, usize)) -> Result<Self> {
        let bytes = shape.0 * shape.1 * size_of::<T>();
        Ok(Buffer {
            pages: huge_pages(bytes).map_err(|_| no_room::<T>(shape))?,
            of: PhantomData,
        })
    }

    /// All numbers, row by row.
    pub fn numbers_mut(&mut self) -> &mut [T] {
        cast_slice_mut(&mut self.pages)
    }

    /// The start of the memory as an array.
    ///
    /// # Errors
    /// [`Error::Refused`] if `shape` is larger than the allocated one.
    pub fn view(&self, shape: (usize, usize)) -> Result<ArrayView2<'_, T>> {
        ArrayView2::from_shape(shape, cast_slice(&self.pages)).map_err(|_| no_room::<T>(shape))
    }

    /// The same to be written to.
    ///
    /// # Errors
    /// As [`Buffer::view`].
    pub fn view_mut(&mut self, shape: (usize, usize)) -> Result<ArrayViewMut2<'_, T>> {
        let values = cast_slice_mut(&mut self.pages);
        ArrayViewMut2::from_shape(shape, values).map_err(|_| no_room::<T>(shape))
    }
}

fn no_room<T>(shape: (usize, usize)) -> Error {
    Error::Refused {
        what: "an array",
        needed: (shape.0 * shape.1 * size_of::<T>()) as u64,
    }
}
