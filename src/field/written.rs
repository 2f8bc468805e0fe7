//! Hashes of arrays as they were written, by which a reader finds those that were changed.

use std::collections::BTreeMap;

use crate::error::Fault;

/// BLAKE3 hash of the values of an array, in hexadecimal.
pub(crate) fn array_hash(values: &[f64]) -> String {
    blake3::hash(bytemuck::cast_slice(values))
        .to_hex()
        .to_string()
}

/// Refuses an array of other values than those that were written.
///
/// `hashes` is what the file says of its arrays by their names, in JSON; of a file that says nothing, nothing is known.
pub(crate) fn check_written(
    hashes: Option<&str>,
    what: &'static str,
    values: &[f64],
) -> Result<(), Fault> {
    let hashes = serde_json::from_str::<BTreeMap<String, String>>(hashes.unwrap_or("{}"));
    let hashes = hashes.map_err(Fault::report)?;
    match hashes.get(what) {
        Some(hash) if *hash != array_hash(values) => {
            let expected = format!("the values of `{what}` that were written");
            let advice = "make it anew with `cascade simulate`; other velocities are a field, to be saved as an `.npy` of its own";
            let found = "others: its hash differs";
            Err(Fault::expected(expected, found, advice))
        }
        _ => Ok(()),
    }
}
