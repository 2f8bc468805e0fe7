//! What was taken of each file of a scan, as a table.

use serde_json::{Value, json};

use crate::field::ScanRecord;
use crate::sheet::Table;

/// The records as JSON, an object for each file in the order of the sites: `file`, `position`, `n_times`, `delay` in
/// samples, `left`, and `correlation`, which is `null` where there is no reference.
pub fn records_json(records: &[ScanRecord]) -> Value {
    let record = |record: &ScanRecord| {
        json!({
            "file": record.path.display().to_string(),
            "position": record.position,
            "n_times": record.n_times,
            "delay": record.delay,
            "left": record.left,
            "correlation": record.correlation,
        })
    };
    records.iter().map(record).collect()
}

/// The same as a table, for CSV.
pub fn records_table(records: &[ScanRecord]) -> Table {
    let row = |record: &ScanRecord| {
        vec![
            record.path.display().to_string(),
            record.position.to_string(),
            record.n_times.to_string(),
            record.delay.to_string(),
            record.left.to_string(),
            record
                .correlation
                .map_or(String::new(), |value| value.to_string()),
        ]
    };
    let head = [
        "file",
        "position",
        "n_times",
        "delay",
        "left",
        "correlation",
    ];
    Table::of("", &head, records.iter().map(row))
}
