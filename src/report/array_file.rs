//! Files of named arrays, in either format.

use super::{Archive, ArrayLabels, NetCdf};
use crate::arrays::Sink;
use crate::error::Result;

/// A file of named arrays; the large ones come in blocks, by [`Sink`].
pub trait ArrayFile: Sink {
    /// Adds an array, row-major. An archive keeps the name and the shape of its labels.
    ///
    /// # Errors
    /// [`crate::Error::Write`].
    fn add(&self, labels: &ArrayLabels, values: &[f64]) -> Result<()>;
}

impl ArrayFile for Archive {
    fn add(&self, labels: &ArrayLabels, values: &[f64]) -> Result<()> {
        self.append(labels.name, &labels.shape(), values)
    }
}

impl ArrayFile for NetCdf {
    fn add(&self, labels: &ArrayLabels, values: &[f64]) -> Result<()> {
        self.append(labels, values)
    }
}

/// The format of the arrays of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ArrayFormat {
    /// [`Archive`].
    #[default]
    Npz,
    /// [`NetCdf`].
    NetCdf,
}

impl ArrayFormat {
    /// Name of the file of these arrays: `spectra.npz` or `spectra.nc` of `spectra`.
    pub fn file_name(self, arrays: &str) -> String {
        match self {
            ArrayFormat::Npz => format!("{arrays}.npz"),
            ArrayFormat::NetCdf => format!("{arrays}.nc"),
        }
    }
}
