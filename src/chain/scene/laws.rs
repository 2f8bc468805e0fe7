//! The laws of the contacts.

use super::check::Check;
use crate::chain::{Law, Laws};
use crate::error::{Error, Result, listed};

/// Keys that give the numbers of a law, and the laws that have each by their names alone.
const NUMBERS: [(&str, &[&str]); 4] = [
    ("exponent", &["power"]),
    ("alpha", &["spring"]),
    ("beta", &["spring"]),
    ("steepness", &["toda", "morse"]),
];

/// The law of all contacts, or those of a cell.
pub(super) fn laws(check: Check) -> Result<Laws> {
    let scene = check.scene;
    let (key, texts) = match (&scene.laws, &scene.law) {
        (Some(cell), _) => ("laws", cell.clone()),
        (None, Some(law)) => ("law", vec![law.clone()]),
        (None, None) => ("law", vec!["hertz".into()]),
    };
    let numbers = [scene.exponent, scene.alpha, scene.beta, scene.steepness];
    let typed = NUMBERS.into_iter().zip(numbers);
    let typed = typed.filter_map(|((name, words), value)| Some((name, value?, words)));
    let typed: Vec<(&str, f64, &[&str])> = typed.collect();
    for (name, _, words) in &typed {
        let used = |text: &String| words.contains(&bare(text)) || takes(text, name);
        if !texts.iter().any(used) {
            let laws = listed(words);
            let expected = format!("it only beside the law {laws} or a formula that uses it");
            return Err(check.fault(name, expected, "it alone"));
        }
    }
    let each = texts.iter().enumerate().map(|(i, text)| {
        let key = match key {
            "laws" => format!("laws[{i}]"),
            _ => key.to_owned(),
        };
        let text = whole(check, text.trim(), &typed)?;
        parsed(check, &key, &text)
    });
    let cell = each.collect::<Result<_>>()?;
    Laws::cell(cell).map_err(|error| check.named(error, key))
}

pub(super) fn parsed(check: Check, key: &str, text: &str) -> Result<Law> {
    Law::parse(text).map_err(|error| match error {
        Error::Request {
            option: "law",
            expected,
            found,
        } => check.fault(key, expected, found),
        other => check.named(other, key),
    })
}

/// A law without what says on which sides it acts.
fn bare(text: &str) -> &str {
    let text = text.trim();
    let sides = ["one-sided ", "two-sided "];
    let bare = sides.into_iter().find_map(|side| text.strip_prefix(side));
    bare.unwrap_or(text).trim()
}

/// Whether a formula takes the value of a name from outside: it has the word, and does not set it itself.
fn takes(text: &str, name: &str) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let has_word = text.split(|c| !is_word(c)).any(|word| word == name);
    let sets = |part: &str| {
        let rest = part.trim().strip_prefix(name);
        rest.is_some_and(|rest| rest.trim_start().starts_with('='))
    };
    let mut parts = text.split([';', ',']).chain(text.split_whitespace());
    has_word && !parts.any(sets)
}

/// A law with the numbers that keys give: a name alone is completed, and a formula gets its constants.
fn whole(check: Check, text: &str, typed: &[(&str, f64, &[&str])]) -> Result<String> {
    let number = |name: &str| typed.iter().find(|key| key.0 == name).map(|key| key.1);
    let word = bare(text);
    let need = |name: &str| check.need(name, number(name), &format!("the {name} of the law"));
    Ok(match word {
        "power" => format!("{text} {}", need("exponent")?),
        "toda" | "morse" => format!("{text} {}", need("steepness")?),
        "spring" => {
            let of = |name| number(name).unwrap_or(0.0);
            format!("{text} alpha={} beta={}", of("alpha"), of("beta"))
        }
        _ => {
            let used = typed.iter().filter(|key| takes(word, key.0));
            let used = used.map(|(name, value, _)| format!("{name}={value}"));
            let used: Vec<String> = used.collect();
            match (used.is_empty(), text.contains(';')) {
                (true, _) => text.to_owned(),
                (false, true) => format!("{text}, {}", used.join(", ")),
                (false, false) => format!("{text}; {}", used.join(", ")),
            }
        }
    })
}

/// The laws with those of single contacts.
pub(super) fn with_defects(check: Check, laws: Laws, contacts: usize) -> Result<Laws> {
    let own = check.scene.defect.iter().flatten().enumerate();
    let own = own.filter_map(|(i, defect)| Some((i, defect.contact, defect.law.as_ref()?)));
    let own: Vec<_> = own.collect();
    if own.is_empty() {
        return Ok(laws);
    }
    let mut all: Vec<Law> = (0..contacts).map(|j| laws.of(j).clone()).collect();
    // The contact with a wall before site 0 follows the cell.
    all.push(laws.before_first().clone());
    for (i, contact, text) in own {
        let key = format!("defect[{i}].law");
        let Some(law) = contact.and_then(|contact| all.get_mut(contact)) else {
            return Err(check.fault(&key, "it only beside a `contact`", "it alone"));
        };
        *law = parsed(check, &key, text)?;
    }
    Laws::cell(all)
}
