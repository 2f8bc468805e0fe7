//! miniSEED files against ObsPy and pymseed (`make_miniseed.py`).

use std::collections::HashMap;
use std::sync::Arc;

use serde_json::Value as Json;
use wavecascade_formats::{
    Container, Coordinate, Error, Format, Options, SampleType, Value, Variable, open,
};

use super::common::{self, open_bytes};

fn file(name: &str) -> Vec<u8> {
    common::file("miniseed", name)
}

fn peer() -> HashMap<String, Vec<Json>> {
    serde_json::from_slice(&file("expected.json")).unwrap()
}

fn opened(name: &str) -> Container {
    open_bytes(name, &file(name))
}

fn refused(bytes: Vec<u8>) -> Error {
    open(Format::MiniSeed, Arc::new(bytes), &Options::default()).unwrap_err()
}

/// The variable that holds a trace, and its row there.
fn place(container: &Container, name: &str) -> (usize, Option<u64>) {
    let names = |variable: &Variable| match variable.attributes.get("traces") {
        Some(Value::Texts(names)) => names.clone(),
        _ => vec![variable.path.trim_start_matches('/').to_owned()],
    };
    let found = container
        .variables
        .iter()
        .enumerate()
        .find_map(|(place, variable)| {
            let row = names(variable).iter().position(|found| found == name)?;
            Some((place, (variable.dimensions.len() > 1).then_some(row as u64)))
        });
    found.unwrap_or_else(|| panic!("{name} is listed"))
}

fn read(container: &Container, at: usize, row: Option<u64>, range: std::ops::Range<u64>) -> String {
    let rows = row.map(|row| row..row + 1);
    let block: Vec<_> = rows.into_iter().chain([range]).collect();
    common::hex(&common::bytes(container, at, &block))
}

#[test]
fn val_obspy_every_trace() {
    let mut traces = 0;
    for (name, expected) in peer() {
        if matches!(name.as_str(), "gap.mseed" | "overlap.mseed") {
            continue;
        }
        let container = opened(&name);
        for one in &expected {
            let text = |key: &str| one[key].as_str().unwrap();
            let (at, row) = place(&container, text("id"));
            let variable = &container.variables[at];
            let what = format!("{name} {}", text("id"));
            traces += 1;
            if text("type") == "text" {
                assert_eq!(variable.sample_type, SampleType::Other("text".into()));
                continue;
            }
            let sample = variable.sample_type.number().unwrap();
            let kind = format!("{}{}", &sample.name()[..1], sample.bytes());
            assert_eq!(kind, text("type"), "{what}");
            let time = variable.dimensions.last().unwrap();
            let hex = text("hex");
            let digits = 2 * sample.bytes();
            assert_eq!(time.len as usize, hex.len() / digits, "{what}");
            for (from, to) in [(0, time.len), (1, time.len - 1), (7, 8), (30, 35), (5, 5)] {
                let found = read(&container, at, row, from..to);
                let expected = &hex[from as usize * digits..to as usize * digits];
                assert_eq!(found, expected, "{what} {from} to {to}");
            }
            let attributes = &variable.attributes;
            assert_eq!(
                attributes.number("sampling_rate"),
                one["rate"].as_f64(),
                "{what}"
            );
            let Some(Coordinate::Even { origin, step, unit }) = &time.coordinate else {
                panic!("{what}");
            };
            let found = (Some(*origin), Some(*step), unit.as_deref());
            assert_eq!(
                found,
                (Some(0.0), one["delta"].as_f64(), Some("s")),
                "{what}"
            );
        }
    }
    assert_eq!(traces, 33);
}

#[test]
fn val_obspy_starts() {
    for (name, path, start) in [
        ("exact.mseed", "XX.STA.00.HHZ", "1969-12-31T23:59:58.000037"),
        (
            "corrected.mseed",
            "XX.STA.00.HHZ",
            "2024-02-29T23:59:57.6234",
        ),
        (
            "corrected_before.mseed",
            "XX.STA.00.HHZ",
            "2024-02-29T23:59:59.1234",
        ),
        ("v3.mseed3", "XX.STA.00.LHZ", "2024-02-29T23:59:59.12345679"),
        (
            "v3.mseed3",
            "XX.STA.00.BHZ",
            "2024-02-29T23:59:59.123456789",
        ),
    ] {
        let expected = peer().remove(name).unwrap();
        let one = expected.iter().find(|one| one["id"] == path).unwrap();
        let nanoseconds = one["start"].as_i64().unwrap();
        let digits = format!("{:09}", nanoseconds.rem_euclid(1_000_000_000));
        let digits = digits.trim_end_matches('0');
        assert!(start.ends_with(digits), "{start} {digits}");
        let container = opened(name);
        let variable = &container.variables[container.find(path).unwrap()];
        assert_eq!(variable.attributes.text("start_time"), Some(start));
    }
}

#[test]
fn regress_refused() {
    let is_unsupported = |error: &Error| matches!(error, Error::Unsupported { .. });
    let mut volume = b"000001V 010009402.3121970,001".to_vec();
    volume.resize(512, b' ');
    assert_eq!(Format::detect("a", &volume), Some(Format::MiniSeed));
    let error = refused(volume);
    assert!(is_unsupported(&error), "{error}");
    // An encoding that is not read is listed.
    let mut bytes = file("int32_big.mseed");
    for at in (0..bytes.len()).step_by(256) {
        bytes[at + 52] = 30;
    }
    let container = open_bytes("a", &bytes);
    let other = SampleType::Other("samples in encoding 30".into());
    assert_eq!(container.variables[0].sample_type, other);
}

#[test]
fn regress_damage_is_found_where_samples_are_decoded() {
    // A difference of Steim, and a float of a record with a checksum.
    let is_float = |header: &[u8]| header.starts_with(b"MS\x03") && header[15] == 5;
    let v3 = file("v3.mseed3");
    let float = v3.windows(16).position(is_float).unwrap() + 150;
    for (name, at) in [
        ("steim1_big.mseed", 100),
        ("steim2_big.mseed", 100),
        ("v3.mseed3", float),
    ] {
        let mut bytes = file(name);
        bytes[at] ^= 1;
        let container = open_bytes(name, &bytes);
        let failed = |i: usize| {
            let is_number = container.variables[i].sample_type.number().is_some();
            is_number && matches!(container.numbers(i), Err(Error::Damaged { .. }))
        };
        let failures = (0..container.variables.len())
            .filter(|i| failed(*i))
            .count();
        assert_eq!(failures, 1, "{name}");
    }
}
