//! File formats that are recognized, so that a message can name them, but not read.

use std::fmt;

use ForeignFormat::*;

/// A format that is recognized by its first bytes or its extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ForeignFormat {
    Hdf5,
    /// Before version 7.3.
    Matlab,
    /// Version 7.3, which is HDF5 with the axes in reverse order.
    Matlab73,
    NetCdf,
    Parquet,
    Excel,
    Gzip,
    Zstd,
    Wav,
}

/// How messages call each format, and its first bytes; none of what is known by its extension alone.
const FORMATS: [(ForeignFormat, &str, &[u8]); 9] = [
    (Matlab73, "a MATLAB file", b"MATLAB 7.3 MAT-file"),
    (Matlab, "a MATLAB file", b"MATLAB 5.0 MAT-file"),
    (Hdf5, "an HDF5 file", b"\x89HDF\r\n\x1a\n"),
    (Gzip, "a gzip file", b"\x1f\x8b"),
    (Zstd, "a zstd file", b"\x28\xb5\x2f\xfd"),
    (NetCdf, "a NetCDF file", b"CDF"),
    (Parquet, "a Parquet file", b"PAR1"),
    (Wav, "a WAV file", b"RIFF"),
    (Excel, "a spreadsheet", b""),
];

impl ForeignFormat {
    /// The format of a file with this extension (lower case) and these first bytes.
    pub(crate) fn detect(extension: &str, bytes: &[u8]) -> Option<Self> {
        // NetCDF 4 is HDF5 inside, a spreadsheet a zip archive.
        match extension {
            "nc" | "nc4" => return Some(NetCdf),
            "xlsx" | "xls" | "ods" => return Some(Excel),
            _ => {}
        }
        let begins = |start: &[u8]| !start.is_empty() && bytes.starts_with(start);
        FORMATS
            .iter()
            .find(|(.., start)| begins(start))
            .map(|it| it.0)
    }
}

impl fmt::Display for ForeignFormat {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let words = FORMATS.iter().find(|(format, ..)| format == self);
        f.write_str(words.map_or("", |(_, words, _)| words))
    }
}
