//! The known name that a mistyped one is nearest to.

/// The name with the fewest letters to insert, remove or replace (Levenshtein), if these are at most a
/// fifth of the key and one more.
///
/// # Examples
/// ```
/// use wavecascade::error::nearest_key;
///
/// let known = ["segment", "overlap"];
/// assert_eq!(nearest_key("segmnt", known), Some("segment"));
/// assert_eq!(nearest_key("colour", known), None);
/// ```
pub fn nearest_key<'a>(key: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // No name is that long; a hostile key is not compared.
    let key: String = key.chars().take(100).collect();
    let distances = known
        .into_iter()
        .map(|name| (strsim::levenshtein(&key, name), name));
    let (distance, nearest) = distances.min_by_key(|(distance, _)| *distance)?;
    (distance <= 1 + key.len() / 5).then_some(nearest)
}
