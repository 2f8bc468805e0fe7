//! The known name that a mistyped one is nearest to, and what words are expected.

/// The name with the fewest letters to insert, remove or replace (Levenshtein), if these are at most a
/// fifth of the key and one more; capitals count as small letters.
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
    let key: String = key.to_lowercase().chars().take(100).collect();
    let distances = known
        .into_iter()
        .map(|name| (strsim::levenshtein(&key, &name.to_lowercase()), name));
    let (distance, nearest) = distances.min_by_key(|(distance, _)| *distance)?;
    (distance <= 1 + key.len() / 5).then_some(nearest)
}

/// Words as a sentence lists them: `` `a`, `b` or `c` ``.
pub(crate) fn listed<S: AsRef<str>>(words: &[S]) -> String {
    let quoted: Vec<String> = words
        .iter()
        .map(|word| format!("`{}`", word.as_ref()))
        .collect();
    match &quoted[..] {
        [first @ .., last] if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        _ => quoted.concat(),
    }
}

/// What is expected in place of a word that is none of those known: these, and the one that was probably meant.
pub(crate) fn one_of_words<S: AsRef<str>>(found: &str, known: &[S]) -> String {
    match nearest_key(found, known.iter().map(AsRef::as_ref)) {
        Some(near) => format!("{} (`{near}`?)", listed(known)),
        None => listed(known),
    }
}
