//! SEG-Y and Seismic Unix against segyio (`make_segy.py`).

use serde_json::Value as Json;
use std::sync::Arc;
use wavecascade_formats::{Container, Coordinate, Format, Options, Result, Sample, Value, open};

use super::common::{self, values};

fn file(name: &str) -> Vec<u8> {
    common::file("segy", name)
}

fn expected() -> serde_json::Map<String, Json> {
    serde_json::from_slice(&file("expected.json")).unwrap()
}

fn open_bytes(name: &str, bytes: Vec<u8>) -> Result<Container> {
    let format = Format::detect(name, &bytes).unwrap();
    open(format, Arc::new(bytes), &Options::default())
}

fn opened(name: &str) -> Container {
    open_bytes(name, file(name)).unwrap()
}

fn numbers(json: &Json) -> Vec<f64> {
    match json {
        Json::Array(values) => values.iter().flat_map(numbers).collect(),
        one => vec![one.as_f64().unwrap()],
    }
}

#[test]
fn val_segyio_samples_and_headers() {
    for (name, expected) in expected() {
        let container = opened(&name);
        let samples = values(&container, "/traces");
        // segyio rounds IBM floats to f32, here they are exact.
        let is_ibm = container.variables[0].sample_type.number() == Some(Sample::IbmF32);
        let samples: Vec<f64> = match is_ibm {
            true => samples.iter().map(|&v| f64::from(v as f32)).collect(),
            false => samples,
        };
        assert_eq!(samples, numbers(&expected["traces"]), "{name}");
        let scalar = numbers(&expected["scalar"])[0];
        let scale = if scalar < 0.0 { -scalar } else { 1.0 };
        for (field, scale) in [
            ("group_x", scale),
            ("group_y", scale),
            ("offset", 1.0),
            ("delay", 1.0),
        ] {
            let peer = numbers(&expected[field]);
            match container.find(field) {
                Some(found) => {
                    let peer: Vec<f64> = peer.iter().map(|v| v / scale).collect();
                    assert_eq!(container.numbers(found).unwrap(), peer, "{name} {field}");
                }
                None => assert!(peer.iter().all(|&v| v == 0.0), "{name} {field}"),
            }
        }
        if let Some(text) = expected.get("text") {
            let text = text.as_str().unwrap().as_bytes();
            let lines = text
                .chunks(80)
                .map(|line| std::str::from_utf8(line).unwrap().trim_end());
            let text = lines.collect::<Vec<_>>().join("\n");
            assert_eq!(
                container.attributes.text("text"),
                Some(text.trim()),
                "{name}"
            );
        }
    }
}

#[test]
fn regress_revision_2() {
    let mut bytes = file("f32.sgy");
    bytes[3500..3502].copy_from_slice(&[2, 0]);
    bytes[3220..3222].fill(0);
    bytes[3268..3272].copy_from_slice(&12u32.to_be_bytes());
    bytes[3272..3280].copy_from_slice(&62.5f64.to_be_bytes());
    bytes[3528..3532].copy_from_slice(&1i32.to_be_bytes());
    bytes.extend([b' '; 3200]);
    let container = open_bytes("a.sgy", bytes).unwrap();
    assert_eq!(
        values(&container, "/traces"),
        values(&opened("f32.sgy"), "/traces")
    );
    let revision = container.attributes.get("revision");
    assert_eq!(revision, Some(&Value::Integers(vec![2])));
    let Some(Coordinate::Even { step, .. }) = container.variables[0].dimensions[1].coordinate
    else {
        panic!("no interval");
    };
    assert_eq!(step, 62.5e-6);
}
