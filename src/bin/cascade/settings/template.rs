//! A settings file with every key, to start from, and its JSON schema.

use std::fmt::Write;

use clap::Arg;
use clap::builder::PossibleValue;
use serde_json::{Map, Value, json};

use super::keys::{Kind, choices, is_flag, is_list, is_whole, key_of};

/// Columns of the comments.
const WIDTH: usize = 96;

/// All keys, commented out, each with its description and its default, an example, or what stands for
/// its value in the help.
pub fn template(kind: Kind) -> String {
    let mut text = String::from(match kind {
        Kind::Analysis => {
            "# Settings for `cascade analyze`. The file analysis.toml beside a field is used if it is\n\
             # there; another one is named with `--settings`. Options on the command line take\n\
             # precedence.\n"
        }
        Kind::Style => {
            "# How figures look: options of all commands that draw. The file style.toml beside what a\n\
             # command reads is used if it is there, and cascade/style.toml in the home configuration\n\
             # (~/.config). Options on the command line and analysis.toml take precedence.\n"
        }
    });
    let mut group = "";
    let keys = kind.keys();
    for key in &keys {
        let heading = key.get_help_heading().unwrap_or_default();
        if heading != group {
            group = heading;
            // Writing to a string cannot fail.
            let _ = write!(text, "\n\n# == {group}\n");
        }
        text.push('\n');
        for line in wrapped(&comment(key)) {
            let _ = writeln!(text, "# {line}");
        }
        let _ = writeln!(text, "#{} = {}", key_of(key), value(key));
    }
    text
}

fn comment(key: &Arg) -> String {
    let mut comment = description(key);
    let each = choices(key).into_iter().map(|choice| told(&choice));
    let each: Vec<String> = each.collect();
    if !each.is_empty() {
        let some = if is_list(key) { "Some of" } else { "One of" };
        let _ = write!(comment, " {some}: {}.", each.join("; "));
    }
    if defaults(key).is_empty() && each.is_empty() && !is_flag(key) {
        comment += match example(key) {
            Some(_) => " Example:",
            None => " Form:",
        };
    }
    comment
}

fn told(choice: &PossibleValue) -> String {
    match choice.get_help() {
        Some(about) => {
            let about = about.to_string();
            format!("{} ({})", choice.get_name(), about.trim_end_matches('.'))
        }
        None => choice.get_name().to_owned(),
    }
}

/// One paragraph.
fn description(key: &Arg) -> String {
    let help = key.get_long_help().or(key.get_help());
    let help = help.map(ToString::to_string).unwrap_or_default();
    let words: Vec<&str> = help.split_whitespace().collect();
    let mut text = words.join(" ");
    if !text.is_empty() && !text.ends_with('.') {
        text.push('.');
    }
    text
}

fn defaults(key: &Arg) -> Vec<String> {
    let defaults = key.get_default_values().iter();
    defaults
        .map(|value| value.to_string_lossy().into_owned())
        .collect()
}

/// The value that the help names after "such as".
fn example(key: &Arg) -> Option<String> {
    let help = description(key);
    let (_, after) = help.split_once("such as ")?;
    let word = after.split([' ', ',', ';', ']']).next()?;
    let word = word.trim_end_matches('.').trim_matches('`');
    (!word.is_empty()).then(|| word.to_owned())
}

/// What stands behind the key, in TOML.
fn value(key: &Arg) -> String {
    if is_flag(key) {
        return "false".into();
    }
    let mut values = defaults(key);
    if values.is_empty() {
        let placeholder = || {
            let name = key.get_value_names().and_then(|names| names.first());
            name.map_or_else(|| "VALUE".to_owned(), ToString::to_string)
        };
        let first = choices(key)
            .first()
            .map(|choice| choice.get_name().to_owned());
        values.push(first.or_else(|| example(key)).unwrap_or_else(placeholder));
    }
    let values: Vec<String> = values.iter().map(|value| literal(value)).collect();
    match is_list(key) {
        true => format!("[{}]", values.join(", ")),
        false => values.concat(),
    }
}

/// A number, or a text in quotes.
fn literal(value: &str) -> String {
    match value.parse::<f64>() {
        Ok(number) if number.is_finite() => value.to_owned(),
        _ => toml::Value::String(value.to_owned()).to_string(),
    }
}

fn wrapped(text: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.len() + 1 + word.len() <= WIDTH => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// The JSON schema of such files.
pub fn schema(kind: Kind) -> Value {
    let properties: Map<String, Value> = kind
        .keys()
        .iter()
        .map(|key| (key_of(key), property(key)))
        .collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": kind.file_name(),
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
    })
}

fn property(key: &Arg) -> Value {
    let names: Vec<String> = choices(key)
        .iter()
        .map(|choice| choice.get_name().to_owned())
        .collect();
    let one = match (is_flag(key), names.is_empty()) {
        (true, _) => json!({ "type": "boolean" }),
        (false, false) => json!({ "enum": names }),
        (false, true) if is_whole(key) => json!({ "type": "integer", "minimum": 0 }),
        (false, true) => json!({ "type": ["number", "string"] }),
    };
    let mut property = match is_list(key) {
        true => json!({ "anyOf": [{ "type": "array", "items": one, "minItems": 1 }, one] }),
        false => one,
    };
    property["description"] = description(key).into();
    if let Some(group) = key.get_help_heading() {
        property["x-group"] = group.into();
    }
    match &defaults(key)[..] {
        [] => {}
        _ if is_flag(key) => property["default"] = false.into(),
        [one] if !is_list(key) => property["default"] = typed(one),
        some => property["default"] = some.iter().map(|value| typed(value)).collect(),
    }
    property
}

fn typed(value: &str) -> Value {
    serde_json::from_str(value)
        .ok()
        .filter(Value::is_number)
        .unwrap_or_else(|| value.into())
}
