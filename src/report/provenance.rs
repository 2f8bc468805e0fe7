//! Where a result came from.

use serde::Serialize;

/// Where a result came from.
#[derive(Debug, Clone, Serialize)]
pub struct Provenance {
    pub program: &'static str,
    pub version: &'static str,
    /// The command as typed, word by word.
    pub command: Vec<String>,
    pub input: Option<String>,
    /// BLAKE3 of the input file, hexadecimal.
    pub input_blake3: Option<String>,
    /// How the input was read, where it does not state it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub read_as: Vec<String>,
}

impl Provenance {
    /// Of this program, for `command` on `input`, whose content has this hash.
    pub fn new(command: Vec<String>, input: Option<String>, input_blake3: Option<String>) -> Self {
        Provenance {
            program: "cascade",
            version: env!("CARGO_PKG_VERSION"),
            command,
            input,
            input_blake3,
            read_as: Vec::new(),
        }
    }
}
