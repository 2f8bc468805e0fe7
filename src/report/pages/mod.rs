//! The pages of results, of a result and of several fields.

mod fields;
mod sheet;

pub use fields::fields_html;
pub use sheet::sheet_html;
