//! SEG-Y and Seismic Unix against segyio (`make_segy.py`).

use serde_json::Value as Json;
use std::sync::Arc;
use wavecascade_formats::{
    ByteOrder, Container, Coordinate, Error, Format, Options, Place, Result, Sample, Strided,
    Value, open,
};

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

/// Path of the coordinate of the traces.
fn coordinate(container: &Container) -> Option<&str> {
    match container.variables[0].dimensions[0].coordinate {
        Some(Coordinate::Listed(at)) => Some(&container.variables[at].path),
        _ => None,
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
fn regress_coordinates() {
    let ibm = opened("ibm.sgy");
    assert_eq!(coordinate(&ibm), Some("/group_x"));
    let time = Coordinate::Even {
        origin: 0.04,
        step: 0.002001,
        unit: Some("s".into()),
    };
    assert_eq!(
        ibm.variables[0].dimensions[1].coordinate,
        Some(time.clone())
    );
    assert_eq!(
        ibm.variables[0].place,
        Place::Strided(Strided {
            start: 3840,
            strides: vec![288, 4],
            order: ByteOrder::Big,
            is_in_file: true,
        })
    );
    let slant = opened("i32.sgy");
    assert_eq!(coordinate(&slant), Some("/distance"));
    assert_eq!(
        values(&slant, "/distance"),
        [0.0, 500.0, 1000.0, 1500.0, 2000.0]
    );
    let arcs = opened("i16.sgy");
    assert_eq!(coordinate(&arcs), Some("/offset"));
    let unit = |path: &str| {
        arcs.variables[arcs.find(path).unwrap()]
            .attributes
            .text("units")
    };
    assert_eq!(
        [unit("source_x"), unit("offset")],
        [Some("arcsec"), Some("ft")]
    );
    let delays = opened("f32.sgy");
    assert_eq!(coordinate(&delays), None);
    assert!(delays.variables[0].attributes.text("delays").is_some());
    for name in ["big.su", "little.su"] {
        assert_eq!(
            opened(name).variables[0].dimensions[1].coordinate,
            Some(time.clone())
        );
    }
}

#[test]
fn regress_falling_receivers_are_no_coordinate() {
    let mut bytes = file("ibm.sgy");
    for trace in 0..5usize {
        let at = 3600 + trace * 288 + 80;
        bytes[at..at + 4].copy_from_slice(&(-(trace as i32)).to_be_bytes());
    }
    assert_eq!(coordinate(&open_bytes("a.sgy", bytes).unwrap()), None);
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

/// What stands in some of five trace headers, and in the binary header, against what is said of it.
#[test]
fn val_definition_headers_that_contradict_each_other() {
    let trace = |i: usize, field: usize| 3600 + i * 288 + field;
    let all = |field: usize, value: u16| (0..5).map(move |i| (trace(i, field), value)).collect();
    let intervals = |of_file: u16, first: u16| {
        let places = [(3216, of_file), (trace(0, 116), first)];
        Vec::from(places)
    };
    for (written, intervals, remark) in [
        // Unset fields contradict nothing.
        (intervals(0, 2001), [None; 2], None),
        (intervals(2001, 0), [None; 2], None),
        (
            intervals(4000, 2001),
            [Some(("binary header", 4000)), Some(("trace 1", 2001))],
            None,
        ),
        (
            vec![(3216, 0), (trace(2, 116), 500)],
            [Some(("trace 1", 2001)), Some(("trace 3", 500))],
            None,
        ),
        (
            vec![(trace(3, 28), 2)],
            [None; 2],
            Some("traces that hold no record of a sensor: 4 (dead)"),
        ),
        (
            vec![(trace(0, 28), 7)],
            [None; 2],
            Some("1 (identification code 7)"),
        ),
        (all(28, 1), [None; 2], None),
        (all(28, 14), [None; 2], None),
    ] {
        let mut bytes = file("ibm.sgy");
        for (at, value) in written {
            bytes[at..at + 2].copy_from_slice(&u16::to_be_bytes(value));
        }
        let container = open_bytes("a.sgy", bytes).unwrap();
        let attributes = &container.variables[0].attributes;
        for (place, interval) in intervals.into_iter().flatten() {
            let stated = attributes.text(&format!("sample_interval ({place})"));
            assert_eq!(stated, Some(&*format!("{interval} us")));
        }
        assert_eq!(attributes.0.len(), intervals.iter().flatten().count());
        let said: Vec<&str> = container.remarks.iter().map(|r| &*r.text).collect();
        assert_eq!(said.is_empty(), remark.is_none(), "{said:?}");
        assert!(
            said.concat().contains(remark.unwrap_or_default()),
            "{said:?}"
        );
    }
}

#[test]
fn regress_refused() {
    let mut unequal = file("ibm.sgy");
    unequal[3600 + 2 * 288 + 114..][..2].copy_from_slice(&11u16.to_be_bytes());
    let error = open_bytes("a.sgy", unequal).unwrap_err();
    assert!(
        error.to_string().contains("trace 3 of 11 samples"),
        "{error}"
    );
    for code in [4u8, 7, 9, 12, 15] {
        let mut bytes = file("ibm.sgy");
        bytes[3225] = code;
        let error = open_bytes("a.sgy", bytes).unwrap_err();
        assert!(matches!(error, Error::Unsupported { .. }), "{error}");
    }
    let mut cut = file("ibm.sgy");
    cut.pop();
    let error = open_bytes("a.sgy", cut).unwrap_err();
    assert!(matches!(error, Error::Damaged { .. }), "{error}");
}
