//! MATLAB files of versions 4 to 7.

mod listing;
mod v4;
mod v5;

use listing::Listing;
pub(crate) use v4::is_header as is_version_4;

use crate::{Bytes, Container, Format, Options, Result};

/// The format of these bytes, if it is one of this module that has a signature.
pub(crate) fn detect(bytes: &[u8]) -> Option<Format> {
    v5::is_header(bytes).then_some(Format::Mat5)
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let mut listing = Listing::new(format, &bytes, options);
    let bytes = (*bytes).as_ref();
    match format {
        Format::Mat4 => v4::list(bytes, &mut listing)?,
        _ => v5::list(bytes, &mut listing)?,
    }
    Ok(listing.container)
}

/// A name as far as a 0.
fn until_zero(name: &[u8]) -> String {
    let name = name.split(|c| *c == 0).next();
    String::from_utf8_lossy(name.unwrap_or_default()).into_owned()
}
