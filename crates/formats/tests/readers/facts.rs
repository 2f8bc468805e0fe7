//! What files of peers state, as they are and with other bytes: a variable a row of `facts.txt`.

use std::sync::Arc;

use wavecascade_formats::{Container, Coordinate, Error, Format, Options, open};

use super::common;

/// Bytes of a text with `\n`, `\r`, and `\xHH` for a byte; a blank as `~`.
fn unescaped(text: &str) -> Vec<u8> {
    let text = text
        .replace('~', " ")
        .replace("\\n", "\n")
        .replace("\\r", "\r");
    let mut parts = text.split("\\x");
    let mut bytes = parts.next().unwrap().as_bytes().to_vec();
    for part in parts {
        bytes.push(u8::from_str_radix(&part[..2], 16).unwrap());
        bytes.extend(part[2..].bytes());
    }
    bytes
}

/// The name and the bytes of a file, with its edits.
fn file(words: &str) -> (&str, Vec<u8>) {
    let mut words = words.split(' ');
    let first = words.next().unwrap();
    let (name, mut bytes) = match first.split_once('/') {
        Some((folder, name)) => (name, common::file(folder, name)),
        None => (first, unescaped(words.next().unwrap())),
    };
    for edit in words {
        let (kind, rest) = edit.split_at(1);
        match kind {
            "@" => {
                let (at, hex) = rest.split_once('=').unwrap();
                let at: usize = at.parse().unwrap();
                for i in 0..hex.len() / 2 {
                    bytes[at + i] = u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap();
                }
            }
            "+" => {
                let (folder, name) = rest.split_once('/').unwrap();
                bytes.extend(common::file(folder, name));
            }
            "_" => bytes.resize(rest.parse().unwrap(), b' '),
            "-" => bytes.truncate(bytes.len() - 1),
            // The n-th, or all.
            which => {
                let [from, to] = rest
                    .split_once("=>")
                    .map(|(a, b)| [a, b].map(unescaped))
                    .unwrap();
                let places = (0..bytes.len()).filter(|at| bytes[*at..].starts_with(&from));
                let mut places: Vec<usize> = places.collect();
                assert!(!places.is_empty(), "{edit}");
                if let Ok(n) = which.parse::<usize>() {
                    places = vec![places[n - 1]];
                }
                for at in places.into_iter().rev() {
                    bytes.splice(at..at + from.len(), to.iter().copied());
                }
            }
        }
    }
    (name, bytes)
}

fn opened(words: &str) -> Result<Container, Error> {
    if let Some((folder, name)) = words.split_once('/')
        && common::directory(folder).join(name).is_dir()
    {
        return Ok(common::opened(folder, name));
    }
    let (name, bytes) = file(words);
    let format = Format::detect(name, &bytes).unwrap_or_else(|| panic!("{name} is detected"));
    open(format, Arc::new(bytes), &Options::default())
}

/// Whether an error has these words, or is of this kind.
fn is_of(error: &Error, words: &str) -> bool {
    error.to_string().contains(words) || format!("{error:?}").starts_with(words)
}

/// Whether a fact of a variable, or of the file, holds: `KEY VALUE`.
fn holds(container: &Container, path: &str, fact: &str) -> bool {
    let at = match path {
        "#0" => Some(0),
        path => container.find(path),
    };
    let (key, value) = fact.split_once(' ').unwrap();
    let parsed = |text: &str| -> Vec<f64> { text.split(' ').map(|v| v.parse().unwrap()).collect() };
    // Gaps are NaN on both sides.
    let are = |found: &[f64], wanted: &[f64]| format!("{found:?}") == format!("{wanted:?}");
    let mut remarks = container.remarks.iter();
    match key {
        "absent" => return at.is_none(),
        "count" => return container.variables.len().to_string() == value,
        "remarks" => return remarks.len().to_string() == value,
        "remark" => {
            let is_about = |of| path == "." || of == at;
            return remarks.any(|it| is_about(it.variable) && it.text.contains(value));
        }
        _ => {}
    }
    let attributes = at.map_or(&container.attributes, |at| {
        &container.variables[at].attributes
    });
    let (first, rest) = value.split_once(' ').unwrap_or((value, ""));
    let name = first.replace('~', " ");
    match key {
        "attr" => {
            let near = |found: f64| {
                let expected = rest.parse::<f64>();
                let is_near = |wanted: f64| {
                    (found - wanted).abs() <= 1e-7 * wanted.abs()
                        || found.is_nan() && wanted.is_nan()
                };
                expected.is_ok_and(is_near)
            };
            return attributes.text(&name) == Some(rest)
                || attributes.number(&name).is_some_and(near);
        }
        "list" => return format!("{:?}", attributes.get(&name)).contains(rest),
        "has" => return attributes.get(&name).is_some(),
        "no" => return attributes.get(&name).is_none(),
        "attributes" => return attributes.0.len().to_string() == value,
        _ => {}
    }
    let Some(at) = at else { return false };
    let variable = &container.variables[at];
    let dimension = || &variable.dimensions[first.parse::<usize>().unwrap()];
    match key {
        "shape" => format!("{:?}", variable.shape()) == format!("[{}]", value.replace(' ', ", ")),
        "values" => are(&container.numbers(at).unwrap(), &parsed(value)),
        "near" => {
            let (found, wanted) = (container.numbers(at).unwrap(), parsed(value));
            let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-14 * b.abs();
            found.len() == wanted.len() && found.iter().zip(&wanted).all(is_near)
        }
        "integers" => {
            let wanted = format!("Some([{}])", value.replace(' ', ", "));
            format!("{:?}", container.integers(at).unwrap()) == wanted
        }
        "same" => {
            let files = value.split(' ').map(|words| opened(words).unwrap());
            let numbers = files.flat_map(|file| common::values(&file, path));
            are(
                &container.numbers(at).unwrap(),
                &numbers.collect::<Vec<_>>(),
            )
        }
        "block" => {
            let bound = |text: &str| text.parse::<u64>().unwrap();
            let ranges = first.split(',').map(|range| range.split_once(':').unwrap());
            let ranges: Vec<_> = ranges.map(|(from, to)| bound(from)..bound(to)).collect();
            are(&common::block(container, at, &ranges), &parsed(rest))
        }
        "broken" => container
            .numbers(at)
            .is_err_and(|error| is_of(&error, value)),
        "name" => dimension().name.as_deref().unwrap_or("-") == rest,
        "coord" => match &dimension().coordinate {
            Some(Coordinate::Listed(i)) => {
                container.variables[*i].path.trim_start_matches('/') == rest
            }
            Some(even) => format!("{even:?}").contains(rest),
            None => rest == "none",
        },
        "place" => format!("{:?}", variable.place).contains(value),
        "type" => match variable.sample_type.number() {
            Some(sample) => sample.name() == value,
            None => format!("{:?}", variable.sample_type).contains(value),
        },
        "way" => variable
            .sample_type
            .way_out()
            .unwrap_or("-")
            .contains(value),
        _ => panic!("{fact}"),
    }
}

#[test]
fn val_definition_what_files_state() {
    let mut wrong = Vec::new();
    let rows = include_str!("facts.txt").lines();
    let mut before = "";
    for row in rows.filter(|row| !row.is_empty() && !row.starts_with('#')) {
        let is_read = |folder: &str, is_built| is_built || !row.starts_with(folder);
        if !is_read("hdf5/", cfg!(feature = "hdf5")) || !is_read("zarr/", cfg!(feature = "zarr")) {
            continue;
        }
        let parts: Vec<&str> = row.split(" | ").collect();
        let words = match parts[0].strip_prefix('"') {
            Some(edits) => format!("{before}{edits}"),
            None => {
                before = parts[0];
                before.to_owned()
            }
        };
        let container = opened(&words);
        let is_right = |fact: &&str| match (&container, fact.split_once(' ').unwrap()) {
            (Err(error), ("refused", words)) => is_of(error, words),
            (Ok(container), _) => holds(container, parts[1], fact),
            _ => false,
        };
        if let Some(missed) = parts[2].split(" ; ").find(|fact| !is_right(fact)) {
            let found = container.map(|it| it.find(parts[1]).map(|at| it.variables[at].clone()));
            wrong.push(format!("{row}\nnot {missed:?}: {found:?}"));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} wrong:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}
