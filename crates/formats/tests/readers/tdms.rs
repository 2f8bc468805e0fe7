//! TDMS files against npTDMS (`make_tdms.py`).

use std::collections::HashMap;
use std::sync::Arc;

use serde_json::Value as Json;
use wavecascade_formats::{
    ByteOrder, Container, Coordinate, Error, Format, Options, Sample, SampleType, Value, Variable,
    open,
};

use super::common::{self, open_bytes};

fn file(name: &str) -> Vec<u8> {
    common::file("tdms", name)
}

fn peer() -> HashMap<String, Vec<Json>> {
    serde_json::from_slice(&file("expected.json")).unwrap()
}

fn opened(name: &str) -> Container {
    open_bytes(name, &file(name))
}

fn texts(variable: &Variable, name: &str) -> Vec<String> {
    match variable.attributes.get(name) {
        Some(Value::Texts(texts)) => texts.clone(),
        _ => Vec::new(),
    }
}

/// The place of the variable that holds a channel, and its row there.
fn place(container: &Container, group: &str, channel: &str) -> (usize, Option<u64>) {
    if let Some(place) = container.find(&format!("{group}/{channel}")) {
        return (place, None);
    }
    for (place, variable) in container.variables.iter().enumerate() {
        let path = variable.path.trim_start_matches('/');
        let is_of_group = path == group || path.starts_with(&format!("{group}/"));
        let row = texts(variable, "channels")
            .iter()
            .position(|name| name == channel);
        if let Some(row) = row.filter(|_| is_of_group) {
            return (place, Some(row as u64));
        }
    }
    panic!("{group}/{channel} is listed");
}

/// The samples of a channel in a range of times, the lowest byte first.
fn samples(container: &Container, group: &str, channel: &str, part: [u64; 2]) -> (Sample, Vec<u8>) {
    let (place, row) = place(container, group, channel);
    let variable = &container.variables[place];
    let sample = variable.sample_type.number().unwrap();
    let range = |d: &wavecascade_formats::Dimension| match d.name.as_deref() {
        Some("channel") => row.unwrap()..row.unwrap() + 1,
        _ => part[0].min(d.len)..d.len.saturating_sub(part[1]).max(part[0].min(d.len)),
    };
    let block: Vec<_> = variable.dimensions.iter().map(range).collect();
    (sample, common::bytes(container, place, &block))
}

fn bytes_of(hex: &str) -> Vec<u8> {
    let digits = hex.as_bytes().chunks(2);
    digits
        .map(|two| u8::from_str_radix(std::str::from_utf8(two).unwrap(), 16).unwrap())
        .collect()
}

/// The samples as npTDMS scales them.
fn scaled(variable: &Variable, sample: Sample, bytes: &[u8]) -> Vec<u8> {
    let number = |name| variable.attributes.number(name);
    let (Some(scale), Some(offset)) = (number("scale_factor"), number("add_offset")) else {
        return bytes.to_vec();
    };
    let samples = bytes.chunks_exact(sample.bytes());
    samples
        .flat_map(|one| (scale * sample.to_f64(ByteOrder::Little, one) + offset).to_le_bytes())
        .collect()
}

fn is_scaled(variable: &Variable) -> bool {
    variable.attributes.get("scale_factor").is_some()
}

/// Doubles as numbers of the type that was stored: `i2`, `f4`.
fn narrowed(doubles: &[u8], kind: &str) -> Vec<u8> {
    let doubles = doubles.chunks_exact(8);
    let doubles = doubles.map(|one| Sample::F64.to_f64(ByteOrder::Little, one));
    let narrow = |double: f64| match kind {
        "f4" => (double as f32).to_le_bytes().to_vec(),
        _ => {
            assert_eq!(double.fract(), 0.0);
            let size = kind[1..].parse().unwrap();
            (double as i64).to_le_bytes()[..size].to_vec()
        }
    };
    doubles.flat_map(narrow).collect()
}

#[test]
fn val_nptdms_every_channel() {
    let mut channels = 0;
    for (name, expected) in peer() {
        let container = opened(&name);
        for one in &expected {
            let text = |key: &str| one[key].as_str().unwrap();
            let (group, channel) = (text("group"), text("channel"));
            let what = format!("{name} {group} {channel}");
            let (at, _) = place(&container, group, channel);
            let variable = &container.variables[at];
            channels += 1;
            if let Some(texts) = one.get("text") {
                assert_eq!(variable.sample_type, SampleType::Other("text".into()));
                let texts: Vec<String> = serde_json::from_value(texts.clone()).unwrap();
                let found = container.attributes.get(&variable.path);
                assert_eq!(found, Some(&Value::Texts(texts)), "{what}");
                continue;
            }
            if let Some(times) = one.get("nanoseconds") {
                let times: Vec<i64> = serde_json::from_value(times.clone()).unwrap();
                assert_eq!(container.integers(at).unwrap(), Some(times), "{what}");
                let units = variable.attributes.text("units");
                assert_eq!(units, Some("nanoseconds since 1970-01-01"));
                continue;
            }
            let Some(hex) = one.get("hex") else {
                assert_eq!(variable.sample_type.number(), None, "{what}");
                continue;
            };
            // Scalings that are not read.
            if group == "table" && name == "scaled.tdms" {
                let kind = SampleType::Other("samples with a scaling of type Table".into());
                assert_eq!(variable.sample_type, kind);
                continue;
            }
            let expected = bytes_of(hex.as_str().unwrap());
            let size = text("type")[1..].parse::<usize>().unwrap();
            for part in [[0, 0], [1, 0], [0, 1], [2, 1], [3, 4]] {
                let (sample, found) = samples(&container, group, channel, part);
                let found = scaled(variable, sample, &found);
                // Of channels of several types, those of this one.
                let found = match sample.bytes() > size && !is_scaled(variable) {
                    true => narrowed(&found, text("type")),
                    false => found,
                };
                let count = expected.len() / size;
                let from = (part[0] as usize).min(count);
                let to = count.saturating_sub(part[1] as usize).max(from);
                assert_eq!(found, expected[from * size..to * size], "{what} {part:?}");
            }
            if let Some(even) = one.get("even") {
                let even: [f64; 2] = serde_json::from_value(even.clone()).unwrap();
                let time = variable.dimensions.iter().find(|d| {
                    d.coordinate
                        == Some(Coordinate::Even {
                            origin: even[0],
                            step: even[1],
                            unit: Some("s".into()),
                        })
                });
                assert!(time.is_some(), "{what}");
            }
        }
    }
    assert_eq!(channels, 84);
}

#[test]
fn regress_refused() {
    let refused =
        |bytes: Vec<u8>| open(Format::Tdms, Arc::new(bytes), &Options::default()).unwrap_err();
    let mut index = file("field.tdms");
    index[3] = b'h';
    assert_eq!(
        Format::detect("field.tdms_index", &index),
        Some(Format::Tdms)
    );
    let error = refused(index);
    assert!(matches!(error, Error::Unsupported { .. }), "{error}");
    // The type of the first channel of `cut.tdms`.
    let bytes = file("cut.tdms");
    let at = bytes
        .windows(4)
        .position(|four| four == [20, 0, 0, 0])
        .unwrap()
        + 4;
    for (code, is_known) in [(11, true), (0x1b, true), (0x4f, true), (0x50, false)] {
        let mut bytes = bytes.clone();
        bytes[at] = code;
        let error = refused(bytes);
        let is_unsupported = matches!(error, Error::Unsupported { .. });
        assert_eq!(is_unsupported, is_known, "{code}: {error}");
    }
    let mut as_before = bytes.clone();
    as_before[at - 4..at].fill(0);
    let error = refused(as_before);
    assert!(
        error.to_string().contains("samples in an earlier segment"),
        "{error}"
    );
    let mut bytes = bytes.clone();
    bytes[0] = b'X';
    let error = refused(bytes);
    assert!(
        error.to_string().starts_with("byte 0: expected TDSm"),
        "{error}"
    );
}

#[test]
fn regress_times_beyond_an_i64_are_told() {
    let mut bytes = file("field.tdms");
    let at = bytes.windows(4).position(|four| four == b"Time").unwrap();
    let stamps = bytes.windows(8).rposition(|seconds| {
        // 2026-01-01.
        i64::from_le_bytes(seconds.try_into().unwrap()) == 2_082_844_800 + 1_767_225_600
    });
    let stamps = stamps.filter(|found| *found > at).unwrap();
    bytes[stamps + 7] = 0x7f;
    let container = open_bytes("field.tdms", &bytes);
    let error = container.integers(container.find("log/Time").unwrap());
    assert!(error.unwrap_err().to_string().contains("1677"));
}

/// A long list of channels and many segments with less than one sample of each.
#[test]
fn regress_work_is_bounded() {
    const MANY: u32 = 5_000;
    let segment = |contents: u32, description: &[u8], samples: &[u8]| {
        let lengths = [description.len() + samples.len(), description.len()];
        let lengths = lengths.map(|length| (length as u64).to_le_bytes());
        let lead = [contents, 4713].map(u32::to_le_bytes);
        [
            b"TDSm",
            &lead.concat()[..],
            &lengths.concat(),
            description,
            samples,
        ]
        .concat()
    };
    let mut description = MANY.to_le_bytes().to_vec();
    for channel in 0..MANY {
        let path = format!("/'g'/'{channel:05}'");
        description.extend((path.len() as u32).to_le_bytes());
        description.extend(path.bytes());
        // One sample of type i8, no properties.
        description.extend([20u32, 1, 1, 1, 0, 0].map(u32::to_le_bytes).concat());
    }
    let mut bytes = segment(0b1110, &description, &[]);
    for _ in 0..MANY {
        bytes.extend(segment(0b1000, &[], &[1]));
    }
    let error = open(Format::Tdms, Arc::new(bytes), &Options::default()).unwrap_err();
    assert!(
        error.to_string().contains("5000 channels again and again"),
        "{error}"
    );
}

/// A channel: its name, the code of its type, its samples and its unit.
type Written<'a> = (&'a str, u32, Vec<u8>, &'a str);

/// A file with the channels of a group `g`.
fn written(channels: &[Written]) -> Vec<u8> {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let mut description = (channels.len() as u32).to_le_bytes().to_vec();
    for (name, kind, samples, unit) in channels {
        description.extend(text(&format!("/'g'/'{name}'")));
        let size = if *kind == 10 { 8 } else { 4 };
        description.extend([20, *kind, 1].map(u32::to_le_bytes).concat());
        description.extend((samples.len() as u64 / size).to_le_bytes());
        let properties = [("unit_string", *unit), ("wf_xunit_string", "s")];
        description.extend(3u32.to_le_bytes());
        for (name, value) in properties {
            description.extend([text(name), 0x20u32.to_le_bytes().to_vec(), text(value)].concat());
        }
        description.extend([text("wf_increment"), 10u32.to_le_bytes().to_vec()].concat());
        description.extend(1e-3f64.to_le_bytes());
    }
    let samples: Vec<u8> = channels
        .iter()
        .flat_map(|(_, _, samples, _)| samples.clone())
        .collect();
    let lengths = [description.len() + samples.len(), description.len()];
    let lengths = lengths.map(|length| (length as u64).to_le_bytes()).concat();
    let lead = [0b1110u32, 4713].map(u32::to_le_bytes).concat();
    [&b"TDSm"[..], &lead, &lengths, &description, &samples].concat()
}

#[test]
fn val_definition_channels_of_several_types_are_one_variable() {
    let doubles = [0.5f64, -1.25, 3.0].map(f64::to_le_bytes).concat();
    let singles = [0.25f32, -2.5, 4.0].map(f32::to_le_bytes).concat();
    let integers = [7i32, -8, 9].map(i32::to_le_bytes).concat();
    let channels = [
        ("a", 10, doubles.clone(), "m/s"),
        ("b", 9, singles, "m/s"),
        ("c", 3, integers, "m/s"),
        ("d", 10, doubles.clone(), "mm/s"),
        ("e", 10, doubles[..16].to_vec(), "m/s"),
        ("f", 10, doubles, "m/s"),
    ];
    let container = open_bytes("a.tdms", &written(&channels));
    let at = container.find("g").unwrap();
    assert_eq!(container.variables[at].shape(), [4, 3]);
    let rows = container.numbers(at).unwrap();
    assert_eq!(
        rows[..9],
        [0.5, -1.25, 3.0, 0.25, -2.5, 4.0, 7.0, -8.0, 9.0]
    );
    let remarks = &container.remarks;
    assert_eq!(remarks.len(), 1, "{remarks:?}");
    assert_eq!(remarks[0].variable, Some(at));
    for part in [
        "\"d\" (unit mm/s, not m/s)",
        "\"e\" (number of samples 2, not 3)",
        "unscaled integers beside floats: \"c\" (i32)",
    ] {
        assert!(remarks[0].text.contains(part), "{}", remarks[0].text);
    }
}
