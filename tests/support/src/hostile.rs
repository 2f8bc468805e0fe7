//! Damaged files, and what they are refused with.

use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use wavecascade::error::InputFault;
use wavecascade::field::OpenOptions;
use wavecascade::{Error, Field};
use zip::write::{SimpleFileOptions, ZipWriter};
use zip::{CompressionMethod, DateTime};

pub struct Folder(tempfile::TempDir);

impl Default for Folder {
    fn default() -> Self {
        Folder::new()
    }
}

impl Folder {
    pub fn new() -> Self {
        Folder(tempfile::tempdir().unwrap())
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

pub fn refusal(name: &str, bytes: impl AsRef<[u8]>, options: &OpenOptions) -> Error {
    let folder = Folder::new();
    let path = folder.write(name, bytes);
    Field::open(&path, options).expect_err("the file is refused")
}

pub fn fault(name: &str, bytes: impl AsRef<[u8]>) -> InputFault {
    fault_with(name, bytes, &OpenOptions::default())
}

pub fn fault_with(name: &str, bytes: impl AsRef<[u8]>, options: &OpenOptions) -> InputFault {
    match refusal(name, bytes, options) {
        Error::Input { fault, .. } => fault,
        other => panic!("{other}"),
    }
}

pub fn npy_with_header(text: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend(data);
    bytes
}

pub fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
    npy_with_header(&text, data)
}

pub fn npy_f64(shape: &str, values: impl IntoIterator<Item = f64>) -> Vec<u8> {
    let data: Vec<u8> = values.into_iter().flat_map(f64::to_le_bytes).collect();
    npy("<f8", shape, &data)
}

pub fn npz(method: CompressionMethod, members: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default()
        .compression_method(method)
        .last_modified_time(DateTime::default());
    for (name, bytes) in members {
        archive.start_file(*name, options).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

pub const BOTH: [CompressionMethod; 2] = [CompressionMethod::Stored, CompressionMethod::Deflated];

/// A text with its escapes: `\n`, `\r`, `\t`, and `\xHH` for a byte.
pub fn unescaped(text: &str) -> Vec<u8> {
    let mut parts = text.split('\\');
    let mut bytes = parts.next().unwrap().as_bytes().to_vec();
    for part in parts {
        let (byte, rest) = match part.as_bytes()[0] {
            b'n' => (b'\n', &part[1..]),
            b'r' => (b'\r', &part[1..]),
            b't' => (b'\t', &part[1..]),
            _ => (u8::from_str_radix(&part[1..3], 16).unwrap(), &part[3..]),
        };
        bytes.push(byte);
        bytes.extend(rest.as_bytes());
    }
    bytes
}
