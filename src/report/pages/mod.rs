//! The pages of results, one for each command.

mod analysis;
mod budget;
mod budget_pictures;
mod fields;
mod localized;
mod sheet;

pub use analysis::analysis_html;
pub use budget::{budget_html, comparison_html, comparison_rows};
pub use fields::fields_html;
pub use localized::{journey_html, localized_html, wave_html};
pub use sheet::sheet_html;
