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
    /// All numbers are below this.
    below: f64,
    /// Keys that decide the same, and keys of which one has to be there.
    pub(super) excludes: Vec<String>,
    pub(super) beside: Vec<String>,
    /// Keys that have to have one of these words.
    pub(super) only_where: Vec<(String, Vec<String>)>,
    /// How many values a list has.
    pub(super) length: Option<Length>,
}

/// How many values a list has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Length {
    /// As there are sites, not contacts.
    pub(super) is_of_sites: bool,
    /// A cell, which repeats along the chain.
    pub(super) repeats: bool,
}

impl Property {
    pub(super) fn allows(&self, number: f64) -> bool {
        let is_enough = match self.is_above {
            true => number > self.least,
            false => number >= self.least,
        };
        is_enough && number < self.below && number.is_finite()
    }

    /// The numbers that it allows, in words.
    pub(super) fn bounds(&self) -> String {
        let least = match (self.least.is_finite(), self.is_above) {
            (false, _) => String::new(),
            (true, true) => format!(" above {}", self.least),
            (true, false) => format!(" of {} or more", self.least),
        };
        match self.below.is_finite() {
            true => format!("a finite number{least}, below {}", self.below),
            false => format!("a finite number{least}"),
        }
    }
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

/// The field of this name.
pub(super) fn property(name: &str) -> Option<&'static Property> {
    properties().iter().find(|property| property.name == name)
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
                let above = field["exclusiveMinimum"].as_f64();
                let least = above.or(field["minimum"].as_f64());
                let conditions = field["x-where"].as_object().into_iter().flatten();
                Property {
                    name: name.clone(),
                    group: group.clone(),
                    description: description(field),
                    kind: kind(field),
                    default: field.get("default").cloned(),
                    example: field["examples"].get(0).cloned(),
                    least: least.unwrap_or(f64::NEG_INFINITY),
                    is_above: above.is_some(),
                    below: field["exclusiveMaximum"].as_f64().unwrap_or(f64::INFINITY),
                    excludes: words(&field["x-excludes"]),
                    beside: words(&field["x-beside"]),
                    only_where: conditions
                        .map(|(key, of)| (key.clone(), words(of)))
                        .collect(),
                    length: field["x-length"].as_str().map(|length| Length {
                        is_of_sites: length.ends_with("sites"),
                        repeats: length.starts_with("cell"),
                    }),
                }
            })
            .collect()
    })
}

/// The texts of a list.
fn words(list: &Value) -> Vec<String> {
    let words = list.as_array().into_iter().flatten();
    words
        .filter_map(|word| Some(word.as_str()?.to_owned()))
        .collect()
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
    if field.get("x-units").is_some() {
        return Kind::Measure {
            units: words(&field["x-units"]),
            words: words(&field["x-words"]),
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
    let choice = |name: &Value, description: String| {
        let name = name.as_str()?.to_owned();
        Some(Choice { name, description })
    };
    // Those without a description of their own share an entry.
    let alike = |schema: &Value| -> Vec<Choice> {
        let names = schema["enum"].as_array().into_iter().flatten();
        names
            .filter_map(|name| choice(name, String::new()))
            .collect()
    };
    let all = match schema["oneOf"].as_array() {
        Some(each) => each
            .iter()
            .flat_map(|one| match one.get("const") {
                Some(name) => Vec::from_iter(choice(name, description(one))),
                None => alike(one),
            })
            .collect(),
        None => alike(schema),
    };
    (!all.is_empty()).then_some(all)
}
