//! Metadata in JSON, and attributes of it.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Map, Value as Json};

use crate::{Attributes, Error, Result, Value};

/// Bytes of a file of metadata.
const LONGEST: u64 = 16 << 20;

/// The JSON object in the file `name` of a folder; `None` if there is no such file.
pub(super) fn read(folder: &Path, name: &str, path: &str) -> Result<Option<Map<String, Json>>> {
    let place = || format!("{name} of {path}");
    let failed =
        |error: std::io::Error| Error::damaged(place(), "a readable file", error.to_string());
    let file = match File::open(folder.join(name)) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        file => file.map_err(failed)?,
    };
    let mut bytes = Vec::new();
    file.take(LONGEST + 1)
        .read_to_end(&mut bytes)
        .map_err(failed)?;
    if bytes.len() as u64 > LONGEST {
        let expected = format!("at most {LONGEST} bytes of metadata");
        return Err(Error::damaged(place(), expected, "more"));
    }
    let parsed = serde_json::from_slice(&quoted(&bytes));
    let parsed = parsed.map_err(|error| Error::damaged(place(), "JSON", error.to_string()))?;
    match parsed {
        Json::Object(object) => Ok(Some(object)),
        _ => Err(Error::damaged(place(), "a JSON object", "another value")),
    }
}

/// JSON whose numbers `NaN`, `Infinity` and `-Infinity`, which Python writes, are texts.
fn quoted(json: &[u8]) -> Cow<'_, [u8]> {
    const WORDS: [&[u8]; 3] = [b"-Infinity", b"Infinity", b"NaN"];
    if !WORDS
        .iter()
        .any(|word| json.windows(word.len()).any(|found| found == *word))
    {
        return Cow::Borrowed(json);
    }
    let mut out = Vec::with_capacity(json.len() + 16);
    let (mut at, mut is_text) = (0, false);
    while at < json.len() {
        let word = WORDS.iter().find(|word| json[at..].starts_with(word));
        if let Some(word) = word.filter(|_| !is_text) {
            out.push(b'"');
            out.extend_from_slice(word);
            out.push(b'"');
            at += word.len();
            continue;
        }
        if is_text && json[at] == b'\\' && at + 1 < json.len() {
            out.push(json[at]);
            at += 1;
        } else if json[at] == b'"' {
            is_text = !is_text;
        }
        out.push(json[at]);
        at += 1;
    }
    Cow::Owned(out)
}

/// JSON values as attributes; what has no type of its own becomes JSON text.
pub(super) fn attributes(object: &Map<String, Json>) -> Attributes {
    let mut attributes = Attributes::default();
    for (name, json) in object {
        attributes.insert(name.as_str(), value(json));
    }
    attributes
}

fn value(json: &Json) -> Value {
    match json {
        Json::String(text) => Value::Text(text.clone()),
        Json::Number(_) | Json::Bool(_) => list(std::slice::from_ref(json), json),
        Json::Array(items) if !items.is_empty() => list(items, json),
        _ => Value::Text(json.to_string()),
    }
}

fn list(items: &[Json], whole: &Json) -> Value {
    let integers = items.iter().map(|item| match item {
        Json::Bool(is_true) => Some(i64::from(*is_true)),
        item => item.as_i64(),
    });
    if let Some(integers) = integers.collect() {
        return Value::Integers(integers);
    }
    if let Some(numbers) = items.iter().map(Json::as_f64).collect() {
        return Value::Numbers(numbers);
    }
    let texts = items.iter().map(|item| item.as_str().map(str::to_owned));
    match texts.collect() {
        Some(texts) => Value::Texts(texts),
        None => Value::Text(whole.to_string()),
    }
}

/// A fill value as xarray writes it into attributes: of floats the bits in base64.
pub(super) fn fill_of_xarray(json: &Json) -> Option<Value> {
    let Json::String(text) = json else {
        return Some(value(json));
    };
    let bits = BASE64_STANDARD.decode(text).ok()?;
    let bits: [u8; 8] = bits.try_into().ok()?;
    Some(Value::Numbers(vec![f64::from_le_bytes(bits)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_python_that_are_no_json() {
        let json = br#"{"a": NaN, "b": [-Infinity, Infinity], "c": "a \" NaN \\", "d": 1}"#;
        let parsed: Map<String, Json> = serde_json::from_slice(&quoted(json)).unwrap();
        assert_eq!(parsed["a"], "NaN");
        assert_eq!(parsed["b"], serde_json::json!(["-Infinity", "Infinity"]));
        assert_eq!(parsed["c"], "a \" NaN \\");
        assert_eq!(quoted(b"{\"a\": \"NaN").as_ref(), b"{\"a\": \"NaN");
    }
}
