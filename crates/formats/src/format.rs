//! Which formats there are, and which one a file has.

use std::fmt;
use std::path::Path;

use crate::{ByteOrder, Bytes, Container, Error, Result, Sample, SampleType, Value};

/// A format that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// An array of NumPy.
    Npy,
    /// An archive of them.
    Npz,
    /// A table of text, whose reader is not in this crate.
    Table,
    /// HDF5, with what builds on it: MATLAB 7.3, NetCDF-4, DASDAE.
    Hdf5,
    /// NetCDF-3: classic, with offsets of 64 bits, or with lengths of 64 bits (CDF-5).
    NetCdf3,
    /// MATLAB, versions 5 to 7.
    Mat5,
    /// MATLAB, version 4.
    Mat4,
    /// SEG-Y, revisions 0 to 2.
    SegY,
    /// Seismic Unix: the traces of SEG-Y without the headers of the file.
    SeismicUnix,
    /// Universal file, data sets 58 and 58b.
    Uff,
    /// TDMS of National Instruments.
    Tdms,
    /// miniSEED, versions 2 and 3.
    MiniSeed,
    /// LAMMPS, a text dump of atoms.
    Lammps,
    /// Zarr, versions 2 and 3: a directory.
    Zarr,
}

/// How a file is opened.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Options {
    /// Bytes of memory that decoded samples may take; none: no limit.
    pub memory: Option<u64>,
}

/// The format of these bytes, if they have the signature of one that it knows.
type Detector = fn(&[u8]) -> Option<Format>;

/// What is read of files without a signature, by their extensions. A format that has one says what was found instead.
const EXTENSIONS: [(Format, &[&str]); 8] = [
    (Format::Hdf5, &["h5", "hdf5", "he5", "nc", "nc4"]),
    (Format::Tdms, &["tdms"]),
    (Format::MiniSeed, &["mseed", "miniseed", "msd", "mseed3"]),
    (Format::Uff, &["uff", "unv", "uf", "bunv"]),
    (Format::Lammps, &["lammpstrj", "dump"]),
    (Format::Mat5, &["mat"]),
    (Format::SegY, &["sgy", "segy"]),
    (Format::SeismicUnix, &["su"]),
];

impl Format {
    /// The format of a file with this name and these bytes; `None` for one that is not read.
    pub fn detect(name: &str, bytes: &[u8]) -> Option<Format> {
        let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension);
        let extension = extension.to_ascii_lowercase();
        let detectors: &[Detector] = &[
            #[cfg(feature = "hdf5")]
            crate::hdf5::detect,
            crate::npy::detect,
            crate::netcdf3::detect,
            crate::tdms::detect,
            crate::miniseed::detect,
            crate::uff::detect,
            crate::lammps::detect,
            crate::mat::detect,
        ];
        let signed = detectors.iter().find_map(|detect| detect(bytes));
        let is_named = |(_, names): &&(Format, &[&str])| names.contains(&extension.as_str());
        let named = || match EXTENSIONS.iter().find(is_named)?.0 {
            Format::Mat5 if crate::mat::is_version_4(bytes) => Some(Format::Mat4),
            // What is packed, or of another format, begins with other bytes.
            Format::Hdf5 | Format::Mat5 | Format::Lammps if !is_text_or_blank(bytes) => None,
            format => Some(format),
        };
        signed.or_else(named).or_else(|| crate::segy::detect(bytes))
    }

    /// The format of the store in this directory; `None` for one that is not read.
    pub fn detect_directory(path: &Path) -> Option<Format> {
        let names = ["zarr.json", ".zgroup", ".zarray"];
        let is_zarr = names.iter().any(|name| path.join(name).is_file());
        is_zarr.then_some(Format::Zarr)
    }
}

/// Whether the first byte is one of a text, or zero.
fn is_text_or_blank(bytes: &[u8]) -> bool {
    let is_text = |byte: &u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    bytes
        .first()
        .is_some_and(|byte| *byte == 0 || is_text(byte))
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Format::Npy => "an array (.npy)",
            Format::Npz => "an archive (.npz)",
            Format::Table => "a table of text",
            Format::Hdf5 => "an HDF5 file",
            Format::NetCdf3 => "a NetCDF-3 file",
            Format::Mat5 => "a MATLAB file",
            Format::Mat4 => "a MATLAB 4 file",
            Format::SegY => "a SEG-Y file",
            Format::SeismicUnix => "a Seismic Unix file",
            Format::Uff => "a universal file (UFF)",
            Format::Tdms => "a TDMS file",
            Format::MiniSeed => "a miniSEED file",
            Format::Lammps => "a LAMMPS dump",
            Format::Zarr => "a Zarr store",
        })
    }
}

/// Opens the bytes of a file of this format.
///
/// # Errors
/// [`crate::Error`]: the bytes are damaged, or have a part of the format that is not read.
pub fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let open = match format {
        #[cfg(feature = "hdf5")]
        Format::Hdf5 => crate::hdf5::open,
        #[cfg(not(feature = "hdf5"))]
        Format::Hdf5 => {
            let way_out = "build with the feature hdf5";
            return Err(Error::unsupported(format.to_string(), way_out));
        }
        Format::NetCdf3 => crate::netcdf3::open,
        Format::Mat5 | Format::Mat4 => crate::mat::open,
        Format::SegY | Format::SeismicUnix => crate::segy::open,
        Format::Uff => crate::uff::open,
        Format::Tdms => crate::tdms::open,
        Format::MiniSeed => crate::miniseed::open,
        Format::Lammps => crate::lammps::open,
        Format::Npy => crate::npy::open,
        Format::Npz => crate::npz::open,
        Format::Table => {
            return Err(Error::unsupported(format.to_string(), "save it as HDF5"));
        }
        Format::Zarr => {
            return Err(Error::unsupported(
                "one file of a Zarr store",
                "name its directory",
            ));
        }
    };
    open(format, bytes, options).map(with_unsigned)
}

/// The same, with integers as unsigned or signed as their attribute `_Unsigned` says, a convention of NetCDF.
fn with_unsigned(mut container: Container) -> Container {
    for variable in &mut container.variables {
        let stated = variable.attributes.text("_Unsigned");
        let kind = match stated.map(str::to_ascii_lowercase).as_deref() {
            Some("true") => 'u',
            Some("false") => 'i',
            _ => continue,
        };
        let SampleType::Number(sample) = &mut variable.sample_type else {
            continue;
        };
        let is_integer = sample.name().starts_with(['i', 'u']);
        let meant = Sample::of_kind(kind, sample.bytes()).filter(|_| is_integer);
        let Some(meant) = meant else { continue };
        *sample = meant;
        // Fill values are of the stored type.
        for (name, value) in &mut variable.attributes.0 {
            if let ("_FillValue" | "missing_value", Value::Integers(values)) = (&name[..], value) {
                for value in values {
                    let bytes = value.to_le_bytes();
                    let stored = &bytes[..meant.bytes()];
                    *value = meant.to_i64(ByteOrder::Little, stored).unwrap_or(*value);
                }
            }
        }
    }
    container
}

/// Opens a directory of this format.
///
/// # Errors
/// [`crate::Error`]: the files are damaged, or the format is not read, or is one of files.
pub fn open_directory(format: Format, path: &Path, options: &Options) -> Result<Container> {
    match format {
        #[cfg(feature = "zarr")]
        Format::Zarr => crate::zarr::open(format, path, options).map(with_unsigned),
        #[cfg(not(feature = "zarr"))]
        Format::Zarr => {
            let _ = (path, options);
            let way_out = "open it in Python with `xarray.open_zarr(path)`, whose arrays `wavecascade` takes as they \
                           are, or build the program with the feature zarr";
            Err(Error::unsupported(format.to_string(), way_out))
        }
        _ => {
            let what = format!("{format} that is a directory");
            Err(Error::unsupported(what, "name the file"))
        }
    }
}
