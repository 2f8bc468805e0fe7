//! Results to files: `summary.json`, `spectra.npz`, `report.html`, in a directory that appears
//! whole or not at all; run files; localized waves.

mod archive;
mod arrays;
mod attenuation;
mod budget;
mod budget_arrays;
#[cfg(feature = "figures")]
mod budget_page;
mod directory;
mod field_file;
#[cfg(feature = "figures")]
mod html;
mod localized;
mod new_file;
mod run_file;
mod sentences;
mod summary;

pub use archive::Archive;
pub use arrays::write_small_arrays;
pub use attenuation::{
    ATTENUATION_SCHEMA, TRANSMISSION_SCHEMA, attenuation_csv, transmission_csv, versioned_json,
    write_beside,
};
pub use budget::{BUDGET_SCHEMA, BudgetSummary, ClosureSummary};
pub use budget_arrays::{write_budget_arrays, write_measured_arrays};
#[cfg(feature = "figures")]
pub use budget_page::{budget_html, comparison_html, comparison_rows};
pub use directory::{Contents, ResultDirectory};
pub use field_file::{FIELD_SCHEMA, FieldFile};
#[cfg(feature = "figures")]
pub use html::html;
pub use localized::{LOCALIZED_SCHEMA, LocalizedSummary, table_csv, write_journey, write_profile};
pub use run_file::{RUN_SCHEMA, RunFile};
pub use sentences::{Answer, Sentence, Unresolved, answers, number, percent, sentences};
pub use summary::{Advice, Doubt, Provenance, SCHEMA, Summary};
