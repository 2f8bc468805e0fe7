//! The header of a NetCDF classic file: dimensions, attributes, and where the samples of each variable are.
//!
//! Layout: NetCDF User's Guide, "File Format Specifications" (CDF-2, CDF-5). All numbers are big-endian.

use crate::arrays::Precision;
use crate::report::Attribute;

/// What the header says.
#[derive(Debug, Default)]
pub(super) struct Header {
    pub dimensions: Vec<(String, u64)>,
    pub attributes: Vec<(String, Attribute)>,
    pub variables: Vec<Variable>,
}

#[derive(Debug)]
pub(super) struct Variable {
    pub name: String,
    /// Places in [`Header::dimensions`].
    pub dimensions: Vec<usize>,
    pub attributes: Vec<(String, Attribute)>,
    pub precision: Precision,
    /// Byte of the first sample.
    pub begin: u64,
    /// Bytes of all samples, without padding.
    pub size: u64,
}

const DIMENSIONS: u32 = 10;
const VARIABLES: u32 = 11;
const ATTRIBUTES: u32 = 12;

/// Version of the format, by its numbers in the header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Version {
    /// Lengths of 32 bits, offsets of 64.
    Cdf2,
    /// Lengths and offsets of 64 bits.
    Cdf5,
}

impl Header {
    /// The bytes of the header, in the older version if its lengths suffice: more programs read it.
    pub fn encode(&self) -> Vec<u8> {
        let mut out = Writer {
            version: self.version(),
            bytes: match self.version() {
                Version::Cdf2 => b"CDF\x02".to_vec(),
                Version::Cdf5 => b"CDF\x05".to_vec(),
            },
        };
        // No records.
        out.length(0);
        out.list(DIMENSIONS, self.dimensions.len());
        for (name, len) in &self.dimensions {
            out.text(name);
            out.length(*len);
        }
        out.attributes(&self.attributes);
        out.list(VARIABLES, self.variables.len());
        for variable in &self.variables {
            out.text(&variable.name);
            out.length(variable.dimensions.len() as u64);
            for &dimension in &variable.dimensions {
                out.length(dimension as u64);
            }
            out.attributes(&variable.attributes);
            out.word(match variable.precision {
                Precision::F32 => 5,
                Precision::F64 => 6,
            });
            out.length(variable.size.next_multiple_of(4));
            out.bytes.extend(variable.begin.to_be_bytes());
        }
        out.bytes
    }

    fn version(&self) -> Version {
        /// The netCDF library keeps the last values of a signed word for itself.
        const MOST_32: u64 = i32::MAX as u64 - 3;
        const MOST_SIZE_32: u64 = u32::MAX as u64 - 3;
        let is_short = self.dimensions.iter().all(|(_, len)| *len <= MOST_32)
            && self.variables.iter().all(|v| v.size <= MOST_SIZE_32);
        match is_short {
            true => Version::Cdf2,
            false => Version::Cdf5,
        }
    }
}

struct Writer {
    version: Version,
    bytes: Vec<u8>,
}

impl Writer {
    fn word(&mut self, word: u32) {
        self.bytes.extend(word.to_be_bytes());
    }

    fn length(&mut self, length: u64) {
        match self.version {
            Version::Cdf2 => self.word(length as u32),
            Version::Cdf5 => self.bytes.extend(length.to_be_bytes()),
        }
    }

    /// The start of a list; an empty one has no tag.
    fn list(&mut self, tag: u32, entries: usize) {
        self.word(if entries == 0 { 0 } else { tag });
        self.length(entries as u64);
    }

    fn padded(&mut self, bytes: &[u8]) {
        self.bytes.extend(bytes);
        let length = self.bytes.len().next_multiple_of(4);
        self.bytes.resize(length, 0);
    }

    /// A name or a text, after its length.
    fn text(&mut self, text: &str) {
        self.length(text.len() as u64);
        self.padded(text.as_bytes());
    }

    fn attributes(&mut self, attributes: &[(String, Attribute)]) {
        self.list(ATTRIBUTES, attributes.len());
        for (name, value) in attributes {
            self.text(name);
            let (kind, number) = match value {
                Attribute::Text(text) => {
                    self.word(2);
                    self.text(text);
                    continue;
                }
                Attribute::Integer(value) => (4, value.to_be_bytes().to_vec()),
                Attribute::Single(value) => (5, value.to_be_bytes().to_vec()),
                Attribute::Number(value) => (6, value.to_be_bytes().to_vec()),
            };
            self.word(kind);
            self.length(1);
            self.bytes.extend(number);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand, from the specification.
    #[test]
    fn val_definition_of_a_small_header() {
        let header = Header {
            dimensions: vec![("x".into(), 3)],
            attributes: vec![("a".into(), Attribute::Text("\u{b5}m".into()))],
            variables: vec![Variable {
                name: "wide".into(),
                dimensions: vec![0],
                attributes: vec![("n".into(), Attribute::Integer(-2))],
                precision: Precision::F32,
                begin: 0x1_0000_0002,
                size: 12,
            }],
        };
        let mut expected = b"CDF\x02\0\0\0\0".to_vec();
        expected.extend(b"\0\0\0\x0a\0\0\0\x01\0\0\0\x01x\0\0\0\0\0\0\x03");
        expected.extend(b"\0\0\0\x0c\0\0\0\x01\0\0\0\x01a\0\0\0\0\0\0\x02\0\0\0\x03\xc2\xb5m\0");
        expected.extend(b"\0\0\0\x0b\0\0\0\x01\0\0\0\x04wide\0\0\0\x01\0\0\0\0");
        expected
            .extend(b"\0\0\0\x0c\0\0\0\x01\0\0\0\x01n\0\0\0\0\0\0\x04\0\0\0\x01\xff\xff\xff\xfe");
        expected.extend(b"\0\0\0\x05\0\0\0\x0c\0\0\0\x01\0\0\0\x02");
        assert_eq!(header.encode(), expected);
    }

    #[test]
    fn long_arrays_have_long_lengths() {
        let header = |len: u64, size: u64| Header {
            dimensions: vec![("x".into(), len)],
            variables: vec![Variable {
                name: "v".into(),
                dimensions: vec![0],
                attributes: Vec::new(),
                precision: Precision::F32,
                begin: 0,
                size,
            }],
            ..Header::default()
        };
        for (len, size, version) in [
            (1 << 30, 0xffff_fffc, 2),
            (1 << 30, 0x1_0000_0000, 5),
            (0x7fff_fffc, 8, 2),
            (0x8000_0000, 8, 5),
        ] {
            assert_eq!(header(len, size).encode()[3], version, "{len} {size}");
        }
    }
}
