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
    joined(std::env::args_os().collect(), |name| {
        std::path::Path::new(name).exists()
    })
}

/// The words with a unit that stands apart from the number of an option as one with it: `--dx 2 mm`. A word
/// that is the name of a file stays one.
fn joined(words: Vec<OsString>, is_file: impl Fn(&str) -> bool) -> Vec<OsString> {
    let mut all: Vec<OsString> = Vec::new();
    for word in words {
        let is_number = |text: &str| text.parse::<f64>().is_ok();
        let number = match &all[..] {
            [.., option, value] => match (option.to_str(), value.to_str()) {
                (_, Some(value)) if value.starts_with("--") => value
                    .split_once('=')
                    .is_some_and(|(_, number)| is_number(number)),
                (Some(option), Some(value)) => option.starts_with("--") && is_number(value),
                _ => false,
            },
            _ => false,
        };
        let unit = word
            .to_str()
            .filter(|unit| number && is_unit(unit) && !is_file(unit));
        match (unit, all.last_mut()) {
            (Some(unit), Some(last)) => {
                last.push(" ");
                last.push(unit);
            }
            _ => all.push(word),
        }
    }
    all
}

/// The words with a negative number as the value of the option before it: `--t0 -3ms` as `--t0=-3ms`.
pub fn with_values(words: Vec<OsString>) -> Vec<OsString> {
    let is_value = |word: &str| {
        let number = word.strip_prefix('-').unwrap_or_default();
        number.starts_with(|c: char| "0123456789.i".contains(c))
    };
    let is_option = |word: &str| word.len() > 2 && word.starts_with("--") && !word.contains('=');
    let mut all: Vec<OsString> = Vec::new();
    for word in words {
        let of_option = |last: &&mut OsString| last.to_str().is_some_and(is_option);
        match all.last_mut().filter(of_option) {
            Some(option) if word.to_str().is_some_and(is_value) => {
                option.push("=");
                option.push(word);
            }
            _ => all.push(word),
        }
    }
    all
}

fn is_unit(name: &str) -> bool {
    use wavecascade::measure as m;
    m::size::<m::Time>(name)
        .or(m::size::<m::Length>(name))
        .or(m::size::<m::Frequency>(name))
        .or(m::size::<m::Speed>(name))
        .or(m::size::<m::Mass>(name))
        .or(m::size::<m::Density>(name))
        .or(m::size::<m::Pressure>(name))
        .or(m::size::<m::Force>(name))
        .or(m::size::<m::Wavenumber>(name))
        .is_some()
}

/// The same as text.
pub fn as_text() -> Vec<String> {
    let words = typed().into_iter();
    words
        .map(|word| word.to_string_lossy().into_owned())
        .collect()
}

/// A word as a shell takes it.
pub fn quoted(word: &str) -> String {
    match word.contains(|c: char| c.is_whitespace() || "*?;&|()'\"".contains(c)) {
        true => format!("'{}'", word.replace('\'', "'\\''")),
        false => word.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_belongs_to_the_number_before_it() {
        for (typed, expected) in [
            ("cascade analyze a --dx 2 mm", "cascade|analyze|a|--dx|2 mm"),
            ("c analyze --dt=1e-5 s a", "c|analyze|--dt=1e-5 s|a"),
            (
                "c simulate --radius 9 mm --force",
                "c|simulate|--radius|9 mm|--force",
            ),
            ("c analyze --dx 2 a mm", "c|analyze|--dx|2|a|mm"),
            ("c analyze --dx 2mm m", "c|analyze|--dx|2mm|m"),
            ("c analyze --dx 2 cm", "c|analyze|--dx|2|cm"),
        ] {
            let words = typed.split(' ').map(OsString::from).collect();
            let found = joined(words, |name| name == "cm");
            let found: Vec<&str> = found.iter().filter_map(|word| word.to_str()).collect();
            assert_eq!(found.join("|"), expected);
        }
    }
}
