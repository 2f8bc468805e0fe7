//! Files of named arrays, in either format.

use super::{Archive, ArrayLabels, Attribute, LabelledArrays};
use crate::arrays::Sink;
use crate::error::Result;

/// A file of named arrays; the large ones come in blocks, by [`Sink`].
pub trait ArrayFile: Sink + LabelledArrays {}

impl<T: Sink + LabelledArrays> ArrayFile for T {}

/// Keeps the names and the shapes.
impl LabelledArrays for Archive {
    fn append(&self, labels: &ArrayLabels, values: &[f64]) -> Result<()> {
        Archive::append(self, labels.name, &labels.shape(), values)
    }

    fn describe(&self, _: &str, _: Vec<(&str, Attribute)>) {}

    fn attribute(&self, _: &str, _: Attribute) {}
}

/// The format of the arrays of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ArrayFormat {
    /// [`Archive`].
    #[default]
    Npz,
    /// [`super::NetCdf`].
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
