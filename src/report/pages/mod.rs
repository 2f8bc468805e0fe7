//! The pages of results, one for each command.

mod analysis;
mod budget;
mod budget_pictures;
mod fields;
mod sheet;

pub use analysis::analysis_html;
pub use budget::{budget_html, comparison_html, comparison_rows};
pub use fields::fields_html;
pub use sheet::sheet_html;
