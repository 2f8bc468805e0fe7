//! The pages of results, one for each command.

mod analysis;
mod budget;
mod fields;
mod sheet;

pub use analysis::analysis_html;
pub use budget::budget_html;
pub use fields::fields_html;
pub use sheet::sheet_html;
