//! A scene file with every key, to start from.

use std::fmt::Write;

use serde_json::Value;

use super::properties::{Kind, Property, properties};

/// Columns of the comments.
const WIDTH: usize = 96;

/// A scene of the non-dimensional dimer. Every other key is commented out, with its description and
/// its default or an example.
pub fn template() -> String {
    let mut text = String::from(
        "# A scene for `cascade simulate`. Keys that are commented out stand with their default, or,\n\
         # marked so, with an example. A scene with a material is in SI, and its quantities may be\n\
         # texts with a unit, such as \"9 mm\"; one without has no units.\n",
    );
    let mut group = "";
    for property in properties() {
        if property.group != group {
            group = &property.group;
            // Writing to a string cannot fail.
            let _ = write!(text, "\n\n# == {group}\n");
        }
        text.push('\n');
        for line in wrapped(&comment(property)) {
            let _ = writeln!(text, "# {line}");
        }
        let value = property.default.as_ref().or(property.example.as_ref());
        let value = value.map(toml).unwrap_or_default();
        // The keys of the dimer, so that the template runs unchanged.
        let typed = ["sites", "stiffness_ratio"].contains(&property.name.as_str());
        let mark = if typed { "" } else { "#" };
        let _ = writeln!(text, "{mark}{} = {value}", property.name);
    }
    text
}

fn comment(property: &Property) -> String {
    let mut comment = property.description.clone();
    match &property.kind {
        Kind::Choice(choices) | Kind::Choices(choices) => {
            let each =
                choices
                    .iter()
                    .map(|choice| match choice.description.trim_end_matches('.') {
                        "" => choice.name.clone(),
                        about => format!("{} ({about})", choice.name),
                    });
            comment += &format!(" One of: {}.", each.collect::<Vec<_>>().join("; "));
        }
        Kind::Measure { units, .. } if units.len() > 1 => {
            comment += &format!(" Units: {}.", units.join(", "));
        }
        _ => {}
    }
    if property.default.is_none() {
        comment += " Example:";
    }
    comment
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

/// A JSON value as TOML.
fn toml(value: &Value) -> String {
    match value {
        Value::Array(values) => {
            let values: Vec<String> = values.iter().map(toml).collect();
            format!("[{}]", values.join(", "))
        }
        Value::Object(table) => {
            let pairs = table.iter().map(|(key, v)| format!("{key} = {}", toml(v)));
            format!("{{ {} }}", pairs.collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}
