//! What several tests of the workspace share.

pub mod fields;
pub mod figures;
pub mod hostile;
pub mod made;
pub mod measured;
pub mod netcdf;
pub mod place;
pub mod power;
pub mod preload;
pub mod pulse;
pub mod recipe;
pub mod running;
pub mod shared;

/// The same with a change.
pub fn changed<T>(mut it: T, change: impl FnOnce(&mut T)) -> T {
    change(&mut it);
    it
}

/// Asserts that a text has all of these words.
#[track_caller]
pub fn contains_all(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "no {word:?} in {text}");
    }
}
