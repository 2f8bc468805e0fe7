//! Results to files: `summary.json`, `spectra.npz` or `spectra.nc`, `report.html`, in a directory that appears
//! whole or not at all; run files; localized waves.

mod archive;
mod array_file;
mod arrays;
mod budget_arrays;
mod directory;
mod field_file;
mod field_set;
mod headlines;
mod netcdf;
mod new_file;
#[cfg(feature = "figures")]
mod page;
mod partial;
mod provenance;
mod run_file;
mod samples;
mod scan_records;
mod sheet;
mod snippet;

pub use crate::sheet::{number, percent};
pub use archive::Archive;
pub use array_file::{ArrayFile, ArrayFormat, ArrayLabels, Attribute};
pub use arrays::label_analysis;
pub use budget_arrays::{DescribedBudget, write_measured_arrays};
pub use directory::{ResultDirectory, write_beside};
pub use field_file::{FIELD_SCHEMA, FieldFile};
pub use field_set::{
    FIELDS_SCHEMA, FieldOutcome, FieldRow, FieldSet, field_names, fields_tables, verdicts_in_words,
};
pub use headlines::{Headlines, MovedShares};
pub use netcdf::NetCdf;
#[cfg(feature = "figures")]
pub use page::{fields_html, sheet_html};
pub use partial::{PARTIAL_SCHEMA, read_partial, read_partial_about, write_partial};
pub use provenance::Provenance;
pub use run_file::{RUN_SCHEMA, RunFile, RunParts};
pub use scan_records::{records_json, records_table};
pub use snippet::{
    analysis_snippet, attenuation_snippet, budget_snippet, localized_snippet, sweep_snippet,
    transmission_snippet,
};
