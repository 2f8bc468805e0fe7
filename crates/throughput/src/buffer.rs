//! Memory for the arrays that are measured.

use bytemuck::Pod;
use memmap2::MmapMut;

use crate::error::{Error, Result};
use crate::system::buffer::huge_pages;

/// An array in huge pages, where the system has them.
#[derive(Debug)]
pub struct Buffer(MmapMut);

impl Buffer {
    /// So many zeros.
    ///
    /// # Errors
    /// [`Error::Read`] where the system gives no memory.
    pub fn new(bytes: usize) -> Result<Buffer> {
        let pages = huge_pages(bytes.max(1));
        let pages = pages.map_err(Error::read("reserve memory for", "the arrays".as_ref()))?;
        Ok(Buffer(pages))
    }

    /// The array as numbers of a type.
    pub fn of<T: Pod>(&mut self) -> &mut [T] {
        bytemuck::cast_slice_mut(&mut self.0)
    }
}
