//! TDMS files.

use std::sync::Arc;

use wavecascade_formats::{Format, Options, open};

use super::common::open_bytes;

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
