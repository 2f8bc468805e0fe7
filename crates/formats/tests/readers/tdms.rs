//! TDMS files.

use std::sync::Arc;

use wavecascade_formats::{Format, Options, open};

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
