//! What files of peers state, as they are and with other bytes: a variable a row of `facts.txt`.

use std::sync::Arc;

use wavecascade_formats::{Container, Coordinate, Error, Format, Options, open};

use super::common;

/// A file of a folder, with edits: `@OFFSET=HEX`, and `cut` of its last byte.
fn opened(words: &str) -> Result<Container, Error> {
    let mut words = words.split(' ');
    let (folder, name) = words.next().unwrap().split_once('/').unwrap();
    let mut bytes = common::file(folder, name);
    for edit in words {
        match edit[1..].split_once('=') {
            Some((at, hex)) => {
                let at: usize = at.parse().unwrap();
                for i in 0..hex.len() / 2 {
                    bytes[at + i] = u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap();
                }
            }
            None => bytes.truncate(bytes.len() - 1),
        }
    }
    let format = Format::detect(name, &bytes).unwrap();
    open(format, Arc::new(bytes), &Options::default())
}

/// Whether a fact of a variable, or of the file, holds: `KEY VALUE`.
fn holds(container: &Container, path: &str, fact: &str) -> bool {
    let at = match path {
        "#0" => Some(0),
        path => container.find(path),
    };
    let (key, value) = fact.split_once(' ').unwrap();
    let numbers = || value.split(' ').map(|v| v.parse::<f64>().unwrap());
    let mut remarks = container.remarks.iter();
    match key {
        "absent" => return at.is_none(),
        "count" => return container.variables.len().to_string() == value,
        "remarks" => return remarks.len().to_string() == value,
        "remark" => return remarks.any(|remark| remark.text.contains(value)),
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
                expected.is_ok_and(|expected| (found - expected).abs() <= 1e-7 * expected.abs())
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
        "shape" => variable.shape().iter().map(|len| *len as f64).eq(numbers()),
        "values" => container.numbers(at).unwrap().into_iter().eq(numbers()),
        "broken" => container
            .numbers(at)
            .unwrap_err()
            .to_string()
            .contains(value),
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
    for row in rows.filter(|row| !row.is_empty() && !row.starts_with('#')) {
        if !cfg!(feature = "hdf5") && row.starts_with("hdf5") {
            continue;
        }
        let parts: Vec<&str> = row.split(" | ").collect();
        let container = opened(parts[0]);
        let is_right = |fact: &&str| match (&container, fact.split_once(' ').unwrap()) {
            (Err(error), ("refused", words)) => error.to_string().contains(words),
            (Err(error), ("kind", name)) => format!("{error:?}").starts_with(name),
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
