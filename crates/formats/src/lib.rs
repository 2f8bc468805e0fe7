//! Files of laboratories and simulations, opened as named arrays.
//!
//! A [`Container`] lists the [`Variable`]s of a file with their dimensions, coordinates and attributes.
//! Samples that lie uncompressed in the file stay there: their [`Place`] says where, so that a mapped
//! file needs no copy. Others are decoded block by block by [`Container::read`].
//!
//! Nothing here decides which variable is a velocity field, or what a unit means.

#![warn(missing_debug_implementations, missing_docs)]

mod attributes;
mod container;
mod cursor;
mod error;
mod format;
#[cfg(feature = "hdf5")]
mod hdf5;
mod lammps;
mod mat;
mod miniseed;
mod netcdf3;
mod npy;
mod npz;
mod rows;
mod sample;
mod segy;
mod sets;
mod tdms;
mod time;
mod uff;
#[cfg(feature = "zarr")]
mod zarr;

pub use attributes::{Attributes, Value};
pub use container::{
    Block, Container, Coordinate, Dimension, Place, Remark, Strided, Variable, strides,
};
pub use error::{Error, Result};
pub use format::{Format, Options, open, open_directory};
pub use npz::has_members;
pub use sample::{ByteOrder, Sample, SampleType, half_to_f64, ibm_to_f64};

pub use time::numpy_times;

use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

/// All bytes of a file, the same on every call.
pub trait FileBytes: AsRef<[u8]> + Debug + Send + Sync {
    /// Says that a range is not needed soon: its pages may leave the memory.
    fn release(&self, _range: Range<usize>) {}
}

impl FileBytes for Vec<u8> {}

/// The bytes of a file, mapped or in memory.
pub type Bytes = Arc<dyn FileBytes>;

/// The bytes of a file as a value that refers to them.
#[derive(Clone)]
struct Shared(Bytes);

impl AsRef<[u8]> for Shared {
    fn as_ref(&self) -> &[u8] {
        (*self.0).as_ref()
    }
}
