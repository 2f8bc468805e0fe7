//! The words that the program was called with.

use std::ffi::OsString;

/// Those of a caller that has others than its process.
#[cfg(feature = "python")]
pub static GIVEN: std::sync::OnceLock<Vec<OsString>> = std::sync::OnceLock::new();

/// The words, the name of the program first.
pub fn typed() -> Vec<OsString> {
    #[cfg(feature = "python")]
    if let Some(words) = GIVEN.get() {
        return words.clone();
    }
    std::env::args_os().collect()
}

/// The same as text.
pub fn as_text() -> Vec<String> {
    let words = typed().into_iter();
    words
        .map(|word| word.to_string_lossy().into_owned())
        .collect()
}
