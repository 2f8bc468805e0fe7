//! Laws as scenes name them.

use super::Law;
use crate::error::{Error, Result, nearest_key, one_of_words};
use crate::formula::is_free;

/// A law from what follows its word; `None` where that is not of the form of the example.
type Typed = fn(&str) -> Result<Option<Law>>;

/// Words that begin a law, an example, and the law.
const WORDS: [(&str, &str, Typed); 7] = [
    ("hertz", "hertz", |rest| {
        Ok(rest.is_empty().then_some(Law::Hertz))
    }),
    ("power", "power 2.5", |rest| {
        one(rest).map(power).transpose()
    }),
    ("spring", "spring alpha=0.25 beta=0", |rest| {
        Ok(spring(rest))
    }),
    ("toda", "toda 1", |rest| {
        let of = |b| steepness(b).map(Law::toda);
        one(rest).map(of).transpose()
    }),
    ("morse", "morse 1", |rest| {
        let of = |b| steepness(b).map(Law::morse);
        one(rest).map(of).transpose()
    }),
    ("polynomial", "polynomial 1 -0.3 0.05", |rest| {
        let terms = numbers(rest).filter(|terms| !terms.is_empty());
        Ok(terms.map(Law::polynomial))
    }),
    ("table", "table -0.1 -2, 0 0, 0.1 1", |rest| {
        table(rest)
            .map(|(overlap, force)| Law::table(overlap, force))
            .transpose()
    }),
];

impl Law {
    /// A law from its text: a word with its numbers, or a formula of the overlap `d`, such as `d + 0.3*d^3`, with
    /// `one-sided` or `two-sided` before it where that is not what the law is by itself.
    ///
    /// # Errors
    /// [`crate::Error::Request`] naming what is wrong in the text.
    pub fn parse(text: &str) -> Result<Law> {
        let text = text.trim();
        if let Some(law) = text.strip_prefix("one-sided ") {
            return Law::parse(law)?.one_sided();
        }
        if let Some(law) = text.strip_prefix("two-sided ") {
            return match Law::parse(law)? {
                Law::Hertz => Ok(Law::two_sided_power(1.5)),
                Law::Power { exponent } => Ok(Law::two_sided_power(exponent)),
                other => Ok(other),
            };
        }
        let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let Some((_, example, law)) = WORDS.iter().find(|(known, ..)| *known == word) else {
            return Law::expression(text).map_err(|error| match is_meant(word, rest) {
                true => {
                    let words = one_of_words(word, &WORDS.map(|(known, ..)| known));
                    let expected = format!("{words}, or a formula of the overlap `d`");
                    Error::request("law", &expected, format!("`{word}`"))
                }
                false => error,
            });
        };
        let expected = || format!("`{word}` as in `{example}`");
        law(rest)?.ok_or_else(|| Error::request("law", expected(), format!("`{text}`")))
    }
}

/// Numbers, each of which may have `NAME=` before it.
fn numbers(rest: &str) -> Option<Vec<f64>> {
    let number = |typed: &str| finite(typed.rsplit('=').next().unwrap_or(typed));
    rest.split_whitespace().map(number).collect()
}

fn finite(typed: &str) -> Option<f64> {
    typed.parse().ok().filter(|value: &f64| value.is_finite())
}

fn one(rest: &str) -> Option<f64> {
    match numbers(rest)?[..] {
        [value] => Some(value),
        _ => None,
    }
}

/// Overlaps and forces.
fn table(rest: &str) -> Option<(Vec<f64>, Vec<f64>)> {
    let row = |row: &str| match numbers(row)?[..] {
        [overlap, force] => Some((overlap, force)),
        _ => None,
    };
    rest.split(',').map(row).collect()
}

/// Whether a word that begins no law stands for one: where it is nearly the word of one, or what follows does not go on with a
/// formula.
fn is_meant(word: &str, rest: &str) -> bool {
    let is_near = nearest_key(word, WORDS.map(|(known, ..)| known)).is_some();
    let goes_on = rest
        .trim_start()
        .starts_with(['+', '-', '*', '/', '^', '(', ';']);
    is_free(word) && (is_near || !goes_on)
}

/// `alpha=A beta=B`, either of which may be absent.
fn spring(rest: &str) -> Option<Law> {
    let (mut alpha, mut beta) = (0.0, 0.0);
    for typed in rest.split_whitespace() {
        let (name, value) = typed.split_once('=')?;
        let value = finite(value)?;
        match name {
            "alpha" => alpha = value,
            "beta" => beta = value,
            _ => return None,
        }
    }
    Some(Law::Spring { alpha, beta })
}

/// The law of a power of the overlap.
///
/// # Errors
/// [`crate::Error::Request`] for an exponent below 1.
pub(crate) fn power(exponent: f64) -> Result<Law> {
    let expected = "a finite exponent of 1 or more";
    let is_one = exponent >= 1.0 && exponent.is_finite();
    Error::require(is_one, "exponent", expected, exponent)?;
    Ok(Law::Power { exponent })
}

/// The steepness of an exponential law.
///
/// # Errors
/// [`crate::Error::Request`] for one that is not above 0.
pub(crate) fn steepness(steepness: f64) -> Result<f64> {
    let is_one = steepness > 0.0 && steepness.is_finite();
    Error::require(is_one, "steepness", "a finite number above 0", steepness)?;
    Ok(steepness)
}
