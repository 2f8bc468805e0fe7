//! Memory for the arrays of a benchmark.

use bytemuck::Pod;
use memmap2::MmapMut;

use crate::{Error, Result};
use wavecascade_system::memory::huge_pages;

/// An array in huge pages, if the system has them.
#[derive(Debug)]
pub struct Buffer(MmapMut);

impl Buffer {
    /// An array of `bytes` zero bytes.
    ///
    /// # Errors
    /// [`Error::Memory`] where the system gives no memory.
    pub fn new(bytes: usize) -> Result<Buffer> {
        let pages = huge_pages(bytes.max(1));
        Ok(Buffer(pages.map_err(Error::Memory)?))
    }

    /// The array as a slice of numbers of type `T`.
    pub fn of<T: Pod>(&mut self) -> &mut [T] {
        bytemuck::cast_slice_mut(&mut self.0)
    }
}
