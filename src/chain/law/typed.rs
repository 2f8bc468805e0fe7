//! Laws as scenes name them.

use super::Law;
use crate::chain::lattice::refuse;
use crate::error::{Result, nearest_key, one_of_words};
use crate::formula::is_free;

/// Words that begin a law, with what follows them.
const WORDS: [(&str, &str); 7] = [
    ("hertz", "hertz"),
    ("power", "power 2.5"),
    ("spring", "spring alpha=0.25 beta=0"),
    ("toda", "toda 1"),
    ("morse", "morse 1"),
    ("polynomial", "polynomial 1 -0.3 0.05"),
    ("table", "table -0.1 -2, 0 0, 0.1 1"),
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
        let Some((_, example)) = WORDS.iter().find(|(known, _)| *known == word) else {
            return Law::expression(text).map_err(|error| match is_meant(word, rest) {
                true => {
                    let words = one_of_words(word, &WORDS.map(|(known, _)| known));
                    let expected = format!("{words}, or a formula of the overlap `d`");
                    refuse("law", &expected, format!("`{word}`"))
                }
                false => error,
            });
        };
        let fault = || {
            refuse(
                "law",
                &format!("`{word}` as in `{example}`"),
                format!("`{text}`"),
            )
        };
        let numbers = |rest: &str| -> Result<Vec<f64>> {
            let numbers = rest.split_whitespace().map(|number| {
                // `NAME=` may stand before a number.
                let value = number.rsplit('=').next().unwrap_or(number).parse::<f64>();
                value.ok().filter(|value| value.is_finite())
            });
            numbers.collect::<Option<_>>().ok_or_else(fault)
        };
        let one = || match numbers(rest)?[..] {
            [value] => Ok(value),
            _ => Err(fault()),
        };
        match word {
            "hertz" if rest.is_empty() => Ok(Law::Hertz),
            "power" => power(one()?),
            "spring" => spring(rest).ok_or_else(fault),
            "toda" => steepness(one()?).map(Law::toda),
            "morse" => steepness(one()?).map(Law::morse),
            "polynomial" => match numbers(rest)? {
                terms if terms.is_empty() => Err(fault()),
                terms => Ok(Law::polynomial(terms)),
            },
            "table" => {
                let row = |row: &str| match numbers(row)?[..] {
                    [overlap, force] => Ok((overlap, force)),
                    _ => Err(fault()),
                };
                let rows: Result<Vec<(f64, f64)>> = rest.split(',').map(row).collect();
                let (overlap, force) = rows?.into_iter().unzip();
                Law::table(overlap, force)
            }
            _ => Err(fault()),
        }
    }
}

/// Whether a word that begins no law stands for one: where it is nearly the word of one, or what follows does not go on with a
/// formula.
fn is_meant(word: &str, rest: &str) -> bool {
    let is_near = nearest_key(word, WORDS.map(|(known, _)| known)).is_some();
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
        let value = value
            .parse::<f64>()
            .ok()
            .filter(|value| value.is_finite())?;
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
    if !(exponent >= 1.0 && exponent.is_finite()) {
        return Err(refuse(
            "exponent",
            "a finite exponent of 1 or more",
            exponent,
        ));
    }
    Ok(Law::Power { exponent })
}

/// The steepness of an exponential law.
///
/// # Errors
/// [`crate::Error::Request`] for one that is not above 0.
pub(crate) fn steepness(steepness: f64) -> Result<f64> {
    if !(steepness > 0.0 && steepness.is_finite()) {
        return Err(refuse("steepness", "a finite number above 0", steepness));
    }
    Ok(steepness)
}
