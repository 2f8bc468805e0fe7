//! Results to files: `summary.json`, `spectra.npz`, `report.html`, in a directory that appears
//! whole or not at all.

mod archive;
mod arrays;
mod directory;
mod summary;

pub use archive::Archive;
pub use arrays::write_small_arrays;
pub use directory::ResultDirectory;
pub use summary::{Provenance, SCHEMA, Summary};
