//! MATLAB files of versions 4 to 7.

mod columns;
mod listing;
mod v4;
mod v5;

use columns::Columns;
use listing::Listing;

use crate::{Bytes, Container, Format, Options, Result};

/// The format of a file with this extension (lower case) and these bytes, if it is one of this module.
pub(crate) fn detect(extension: &str, bytes: &[u8]) -> Option<Format> {
    if v5::is_header(bytes) {
        Some(Format::Mat5)
    } else if extension == "mat" && v4::is_header(bytes) {
        Some(Format::Mat4)
    } else {
        None
    }
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let mut listing = Listing::new(options.memory);
    let inflated = match format {
        Format::Mat4 => {
            v4::list((*bytes).as_ref(), &mut listing)?;
            Vec::new()
        }
        _ => v5::list((*bytes).as_ref(), &mut listing)?,
    };
    let decoder = Columns {
        file: bytes.clone(),
        inflated,
        stored: listing.stored,
    };
    let mut container = Container::new(format, bytes, Some(Box::new(decoder)));
    container.attributes = listing.attributes;
    container.variables = listing.variables;
    Ok(container)
}
