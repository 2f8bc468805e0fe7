//! What was taken of each file of a scan, as a table.

use crate::field::ScanRecord;

/// The records as CSV: `file,position,n_times,delay,left,correlation`, one row a file in the order of the
/// sites; delays in samples, an empty cell where there is no reference.
pub fn records_csv(records: &[ScanRecord]) -> String {
    let mut table = String::from("file,position,n_times,delay,left,correlation\n");
    for record in records {
        let correlation = record.correlation.map(|value| value.to_string());
        table += &format!(
            "{},{},{},{},{},{}\n",
            quoted(&record.path.to_string_lossy()),
            record.position,
            record.n_times,
            record.delay,
            record.left,
            correlation.unwrap_or_default()
        );
    }
    table
}

/// A text as a field of CSV.
pub(super) fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}
