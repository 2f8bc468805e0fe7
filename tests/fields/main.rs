//! Fields from files: formats, conclusions, hostile input.

use wavecascade::Field;
use wavecascade::field::Note;

mod cases;
mod formats;
mod hostile;
mod hostile_npz;
mod inputs;
mod labelled;
mod meanings;
mod random;
mod read;
mod resample;
mod scans;
mod written;

/// What is said under this code of how a field was read.
fn note<'a>(field: &'a Field, code: &str) -> Option<&'a Note> {
    field.notes.iter().find(|note| note.code == code)
}

/// All that is said of it.
fn texts(field: &Field) -> Vec<&str> {
    field.notes.iter().map(|note| &note.text[..]).collect()
}
