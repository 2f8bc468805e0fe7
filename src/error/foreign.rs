//! File formats that are recognized, so that a message can name them, but not read.

use std::fmt;

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

impl ForeignFormat {
    /// The format of a file with this extension (lower case) and these first bytes.
    pub(crate) fn detect(extension: &str, bytes: &[u8]) -> Option<Self> {
        use ForeignFormat::*;
        let magic: [(&[u8], ForeignFormat); 8] = [
            (b"MATLAB 7.3 MAT-file", Matlab73),
            (b"MATLAB 5.0 MAT-file", Matlab),
            (b"\x89HDF\r\n\x1a\n", Hdf5),
            (b"\x1f\x8b", Gzip),
            (b"\x28\xb5\x2f\xfd", Zstd),
            (b"CDF", NetCdf),
            (b"PAR1", Parquet),
            (b"RIFF", Wav),
        ];
        let by_bytes = magic
            .into_iter()
            .find(|(start, _)| bytes.starts_with(start))
            .map(|(_, format)| format);
        let by_extension = match extension {
            "nc" | "nc4" => Some(NetCdf),
            "xlsx" | "xls" | "ods" => Some(Excel),
            _ => None,
        };
        // NetCDF 4 is HDF5 inside, a spreadsheet a zip archive.
        by_extension.or(by_bytes)
    }
}

impl fmt::Display for ForeignFormat {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            ForeignFormat::Hdf5 => "an HDF5 file",
            ForeignFormat::Matlab | ForeignFormat::Matlab73 => "a MATLAB file",
            ForeignFormat::NetCdf => "a NetCDF file",
            ForeignFormat::Parquet => "a Parquet file",
            ForeignFormat::Excel => "a spreadsheet",
            ForeignFormat::Gzip => "a gzip file",
            ForeignFormat::Zstd => "a zstd file",
            ForeignFormat::Wav => "a WAV file",
        })
    }
}
