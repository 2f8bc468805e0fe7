//! miniSEED.

use crate::{Bytes, Container, Error, Format, Options, Result};

/// The format of a file with this extension (lower case) and these bytes, if it is one of this module.
pub(crate) fn detect(extension: &str, bytes: &[u8]) -> Option<Format> {
    let _ = (extension, bytes);
    None
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let _ = (bytes, options);
    Err(Error::unsupported(format.to_string(), "convert it"))
}
