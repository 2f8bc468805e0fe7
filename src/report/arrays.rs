//! What a file of arrays says of an analysis.

use crate::analyze::Analysis;
use crate::analyze::labels::Power;
use crate::arrays::LargeArray;
use crate::sheet::Sheet;
use crate::unit;

/// Parts of the numbers of an analysis that are attributes of the file, and what their names begin with there.
const ATTRIBUTES: [(&str, &str); 4] = [
    ("provenance", ""),
    ("field", ""),
    ("conventions", ""),
    ("parseval", "parseval_"),
];

/// Adds what the large arrays of an analysis are, which went to the [`Sink`], and that conventions, residuals and
/// provenance are attributes of their file.
///
/// [`Sink`]: crate::arrays::Sink
pub fn label_analysis(analysis: &Analysis, sheet: &mut Sheet) {
    sheet.attributes = &ATTRIBUTES;
    let power = Power::of(analysis);
    for array in LargeArray::OF_ANALYSES {
        let label = power.of_array(array);
        let (about, unit) = unit::split(&label);
        sheet.variable(array.name(), &[], unit, Vec::new());
        if let Some(added) = sheet.variables.last_mut() {
            added.about = about.into();
        }
    }
}
