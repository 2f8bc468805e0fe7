//! What several tests of the workspace share.

pub mod estimate;
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
pub mod scenes;
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

/// Asserts that numbers differ by less than this.
#[track_caller]
pub fn near(found: f64, expected: f64, within: f64) {
    let off = (found - expected).abs();
    assert!(off < within, "{found:e} for {expected:e}: off by {off:e}");
}

/// Asserts that a number is in this range.
#[track_caller]
pub fn lies(found: f64, within: std::ops::Range<f64>) {
    assert!(within.contains(&found), "{found:e} is not in {within:?}");
}

/// The largest number; NaN where one is.
pub fn worst(values: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |a: f64, b: f64| if b.is_nan() || b > a { b } else { a };
    values.into_iter().fold(0.0, larger)
}

/// How many of these hold, as a share.
pub fn share(holds: impl IntoIterator<Item = bool>) -> f64 {
    let (mut held, mut all) = (0.0, 0.0);
    for one in holds {
        all += 1.0;
        held += f64::from(u8::from(one));
    }
    held / all
}

/// Root mean square.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value * value;
        count += 1.0;
    }
    f64::sqrt(sum / count)
}

/// Asserts that of so many trials a number in this range holds.
#[track_caller]
pub fn hold(trials: u64, within: std::ops::RangeInclusive<usize>, holds: impl FnMut(&u64) -> bool) {
    let held = (0..trials).filter(holds).count();
    assert!(within.contains(&held), "{held} of {trials}");
}
