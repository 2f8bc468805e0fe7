//! The fields of a scene as data, read from the schema that their declarations make.

use std::sync::OnceLock;

use schemars::generate::SchemaSettings;
use serde_json::{Map, Value};

use super::Scene;

/// A field of a scene, as a form, an option or a comment shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    pub name: String,
    /// The group of fields it belongs to.
    pub group: String,
    pub description: String,
    pub kind: Kind,
    /// What holds where nothing is typed, in JSON.
    pub default: Option<Value>,
    pub example: Option<Value>,
    /// The least number, of a list each; it is left out itself where `is_above`.
    pub least: f64,
    pub is_above: bool,
}

/// What can be typed into a field.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    Number,
    Whole,
    Flag,
    Text,
    /// A number, or a text of a number and one of these units, or one of these words.
    Measure {
        units: Vec<String>,
        words: Vec<String>,
    },
    Choice(Vec<Choice>),
    Numbers,
    Choices(Vec<Choice>),
    Tables,
}

/// One of several words.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    pub name: String,
    pub description: String,
}

/// The JSON schema of scene files.
pub fn schema() -> Value {
    let settings = SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
    let mut schema = settings
        .into_generator()
        .into_root_schema_for::<Scene>()
        .to_value();
    strip_null(&mut schema);
    schema
}

/// The fields of a scene in the order of their declaration.
pub fn properties() -> &'static [Property] {
    static PROPERTIES: OnceLock<Vec<Property>> = OnceLock::new();
    PROPERTIES.get_or_init(|| {
        let schema = schema();
        let mut group = String::new();
        let fields = schema["properties"].as_object();
        fields
            .into_iter()
            .flatten()
            .map(|(name, field)| {
                if let Some(opened) = field["x-group"].as_str() {
                    group = opened.to_owned();
                }
                let least = |key: &str| field[key].as_f64();
                let above = least("exclusiveMinimum");
                let least = above.or(least("minimum"));
                Property {
                    least: least.unwrap_or(f64::NEG_INFINITY),
                    is_above: above.is_some(),
                    name: name.clone(),
                    group: group.clone(),
                    description: description(field),
                    kind: kind(field),
                    default: field.get("default").cloned(),
                    example: field["examples"].get(0).cloned(),
                }
            })
            .collect()
    })
}

/// A key that is left out is absent, never null: TOML has no null.
fn strip_null(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            if object.get("default") == Some(&Value::Null) {
                object.shift_remove("default");
            }
            unwrap_single(object);
            if let Some(Value::Array(types)) = object.get_mut("type") {
                types.retain(|t| t != "null");
                if let [only] = &types[..] {
                    object["type"] = only.clone();
                }
            }
            if let Some(Value::Array(values)) = object.get_mut("enum") {
                values.retain(|v| !v.is_null());
            }
            object.values_mut().for_each(strip_null);
        }
        Value::Array(values) => values.iter_mut().for_each(strip_null),
        _ => {}
    }
}

/// `anyOf` of one schema and null is that schema, under the field's own description.
fn unwrap_single(object: &mut Map<String, Value>) {
    let Some(Value::Array(mut any)) = object.shift_remove("anyOf") else {
        return;
    };
    any.retain(|one| one["type"] != "null");
    match &mut any[..] {
        [Value::Object(only)] => {
            for (key, value) in std::mem::take(only) {
                object.entry(key).or_insert(value);
            }
        }
        _ => {
            object.insert("anyOf".into(), Value::Array(any));
        }
    }
}

/// One paragraph, whatever lines it was written in.
fn description(schema: &Value) -> String {
    let text = schema["description"].as_str().unwrap_or_default();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn kind(field: &Value) -> Kind {
    if let Some(choices) = choices(field) {
        return Kind::Choice(choices);
    }
    let words = |key: &str| -> Vec<String> {
        let words = field[key].as_array().into_iter().flatten();
        words
            .filter_map(|w| w.as_str().map(str::to_owned))
            .collect()
    };
    if field.get("x-units").is_some() {
        return Kind::Measure {
            units: words("x-units"),
            words: words("x-words"),
        };
    }
    match field["type"].as_str() {
        Some("integer") => Kind::Whole,
        Some("boolean") => Kind::Flag,
        Some("string") => Kind::Text,
        Some("array") => match (choices(&field["items"]), field["items"]["type"].as_str()) {
            (Some(choices), _) => Kind::Choices(choices),
            (None, Some("object")) => Kind::Tables,
            _ => Kind::Numbers,
        },
        _ => Kind::Number,
    }
}

fn choices(schema: &Value) -> Option<Vec<Choice>> {
    let named = |name: &Value, description: String| {
        Some(Choice {
            name: name.as_str()?.to_owned(),
            description,
        })
    };
    if let Some(all) = schema["oneOf"].as_array() {
        let each = all.iter().flat_map(|one| match one["enum"].as_array() {
            // Those without a description of their own share one entry.
            Some(names) => names
                .iter()
                .filter_map(|n| named(n, String::new()))
                .collect(),
            None => Vec::from_iter(named(&one["const"], description(one))),
        });
        return Some(each.collect());
    }
    let names = schema["enum"].as_array()?;
    Some(
        names
            .iter()
            .filter_map(|n| named(n, String::new()))
            .collect(),
    )
}
