//! Ways in which a file can fail to be what its format promises.

use std::fmt;

pub use wavecascade_formats::Error as FormatError;

use super::ForeignFormat;

/// One fault, with the expected and the found value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InputFault {
    #[error("expected samples, found an empty file")]
    Empty,

    #[error("line {line}: expected {expected}, found {found}")]
    Curve {
        line: usize,
        expected: String,
        found: String,
    },

    #[error("expected a file, found {found}")]
    NotAFile { found: FileKind },

    #[error(
        "expected NumPy (.npy, .npz), text (.csv, .tsv, .txt), HDF5, NetCDF, MATLAB, SEG-Y, UFF, TDMS, miniSEED or LAMMPS dumps, found {found}"
    )]
    UnknownFormat { found: String },

    /// A known format that is not read.
    #[error(
        "expected NumPy (.npy, .npz), text (.csv, .tsv, .txt), HDF5, NetCDF, MATLAB, SEG-Y, UFF, TDMS, miniSEED or LAMMPS dumps, found {format}"
    )]
    ForeignFormat { format: ForeignFormat },

    #[error("expected a run file: the member {missing:?} is not there")]
    NoRun { missing: &'static str },

    #[error(
        "expected shape {}, found {}",
        DisplayShape(expected),
        DisplayShape(found)
    )]
    RunShape { expected: Vec<u64>, found: Vec<u64> },

    #[error("expected what the scene in the file says, found another {what} at index {index}")]
    RunScene { what: &'static str, index: usize },

    #[error("expected the values of `{what}` that were written, found others: its hash differs")]
    RunChanged { what: &'static str },

    #[error("expected the report of a run, found {reason}")]
    RunReport { reason: String },

    #[error("expected samples, found an array of shape {}", DisplayShape(shape))]
    NoSamples { shape: Vec<u64> },

    #[error(
        "expected an array that can be addressed, found shape {} of {sample_bytes}-byte samples",
        DisplayShape(shape)
    )]
    TooLarge {
        shape: Vec<u64>,
        sample_bytes: usize,
    },

    #[error("member {member:?}: {fault}")]
    Member {
        member: String,
        #[source]
        fault: Box<InputFault>,
    },

    /// An array of which a file of that length cannot hold all samples.
    #[error(
        "expected at most {most} bytes of samples in a file of this length, found an array of {claimed}"
    )]
    Overclaimed { claimed: u64, most: u64 },

    /// Two statements about the samples that differ.
    #[error("expected one {what}, found {first} and {second}")]
    Contradiction {
        what: &'static str,
        first: String,
        second: String,
    },

    #[error(
        "expected one {what}, or one for each of {} times or of {} sites, found {found} numbers in `{place}`",
        shape[0], shape[1]
    )]
    Factors {
        place: String,
        what: &'static str,
        found: usize,
        /// Times and sites.
        shape: [usize; 2],
    },

    #[error("expected {expected} {axis} coordinates, found {found}")]
    AxisLength {
        axis: &'static str,
        expected: u64,
        found: u64,
    },

    #[error(
        "expected uniform {axis} steps of {expected}, found {found} before {axis} index {index}"
    )]
    UnevenAxis {
        axis: &'static str,
        index: usize,
        expected: f64,
        found: f64,
    },

    #[error(
        "expected {axis} steps of at most {limit} medians of {expected} to resample, found {found} before \
         {axis} index {index}"
    )]
    LongStep {
        axis: &'static str,
        index: usize,
        limit: f64,
        expected: f64,
        found: f64,
    },

    #[error("expected traces that begin at one time, found delays from {least} to {most} ms")]
    Delays { least: f64, most: f64 },

    #[error(
        "expected a delay of a whole number of steps against the first trace, found {steps} of trace {trace}"
    )]
    Delay { trace: usize, steps: f64 },

    #[error(
        "expected two times that all traces have in common, found trace {early} at its end before trace {late} begins"
    )]
    NoCommonTime { early: usize, late: usize },

    #[error(
        "expected an axis in a unit that a step or an origin with a unit can be converted to \
         ({expected}), found {found:?}"
    )]
    UnitOfAxis { expected: String, found: String },

    #[error("line {line}: expected a time step of {expected}, found {found}")]
    UnevenTimes {
        line: u64,
        expected: f64,
        found: f64,
    },

    #[error("expected text in UTF-8, found {found}")]
    Encoding { found: &'static str },

    #[error("expected rows of numbers, found only a header")]
    NoRows,

    #[error(
        "expected a first column of samples or of {}, found one that {reason}",
        coordinates.words()
    )]
    FirstColumn {
        coordinates: CoordinateKind,
        reason: &'static str,
    },

    #[error("expected a column of samples beside the times, found none")]
    NoColumns,

    #[error("line {line}: expected {expected} cells, found {found}")]
    Ragged {
        line: u64,
        expected: usize,
        found: usize,
    },

    #[error("line {line}, column {column}: expected a number, found {found:?}")]
    Cell {
        line: u64,
        column: usize,
        found: String,
    },

    #[error(
        "line {line}: expected commas between numbers or within them, found both in {found:?}; write the \
         table with semicolons or tabs between its cells"
    )]
    DecimalCommas { line: u64, found: String },

    #[error("line {line}: expected a row of at most {limit} bytes, found a longer one")]
    RowLength { line: u64, limit: usize },

    #[error("expected the time column {asked}, found the columns {}", columns.join(", "))]
    NoSuchColumn { asked: String, columns: Vec<String> },

    /// A file of named arrays that is damaged, or has a part that is not read.
    #[error("{}", ContainerFault(fault))]
    Container { fault: Box<FormatError> },

    #[error("expected one array v(t, x), found {}", Listed(variables))]
    WhichVariable { variables: Vec<String> },

    #[error("expected the variable {name:?}, found {}", Listed(variables))]
    NoSuchVariable {
        name: String,
        variables: Vec<String>,
    },

    #[error("expected numbers in {variable}, found {found}")]
    NotNumbers {
        variable: String,
        found: String,
        /// How it becomes numbers that are read, where there is a way.
        way_out: Option<&'static str>,
    },

    #[error("expected times in {variable}, found only the sites {dimension:?} of one time")]
    NoTimes { variable: String, dimension: String },

    #[error("expected the dimension {name:?} of {variable}, found ({dimensions})")]
    NoSuchDimension {
        name: String,
        variable: String,
        dimensions: String,
    },

    #[error("expected times and sites, found {variable} ({dimensions}), also along {dimension}")]
    FurtherDimension {
        variable: String,
        dimensions: String,
        dimension: Box<DimensionName>,
    },

    #[error("{dimension}: expected {expected}, found {found}")]
    NoSuchLabel {
        dimension: String,
        expected: String,
        found: String,
    },

    #[error("expected one sidecar, found {first:?} and {second:?}")]
    TwoSidecars { first: String, second: String },

    #[error("{}{}{reason}", Line(line), Key(key))]
    Sidecar {
        line: Option<usize>,
        key: Option<String>,
        reason: String,
    },

    #[error("expected at most {limit} bytes of settings, found {found}")]
    SidecarLength { found: u64, limit: u64 },
}

/// What exists where a file was expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    Directory,
    Pipe,
    Socket,
    Device,
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FileKind::Directory => "a directory",
            FileKind::Pipe => "a pipe",
            FileKind::Socket => "a socket",
            FileKind::Device => "a device",
        })
    }
}

/// A dimension with its values, where they are known.
#[derive(Debug, Clone, PartialEq)]
pub struct DimensionName {
    pub name: String,
    pub len: u64,
    /// First and last value, and their unit.
    pub range: Option<(f64, f64, Option<String>)>,
}

impl fmt::Display for DimensionName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.name)?;
        match &self.range {
            Some((first, last, unit)) => {
                let unit = unit.as_deref().unwrap_or_default();
                let text = format!("{} values from {first} to {last} {unit}", self.len);
                write!(f, " ({})", text.trim_end())
            }
            None => write!(f, " ({} values)", self.len),
        }
    }
}

/// What is wrong, without what to do about it.
struct ContainerFault<'a>(&'a FormatError);

impl fmt::Display for ContainerFault<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            FormatError::Unsupported { what, .. } => {
                write!(
                    f,
                    "expected a part of the format that is read, found {what}"
                )
            }
            fault => write!(f, "{fault}"),
        }
    }
}

/// Some of many names.
struct Listed<'a>(&'a [String]);

impl fmt::Display for Listed<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const MOST: usize = 12;
        if self.0.is_empty() {
            return f.write_str("none");
        }
        let named = &self.0[..self.0.len().min(MOST)];
        f.write_str(&named.join(", "))?;
        match self.0.len() - named.len() {
            0 => Ok(()),
            more => write!(f, " and {more} more"),
        }
    }
}

struct DisplayShape<'a>(&'a [u64]);

impl fmt::Display for DisplayShape<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lengths: Vec<String> = self.0.iter().map(u64::to_string).collect();
        write!(f, "({})", lengths.join(", "))
    }
}

/// What a column of coordinates may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CoordinateKind {
    Times,
    Positions,
}

impl CoordinateKind {
    pub(crate) fn words(self) -> &'static str {
        match self {
            CoordinateKind::Times => "times",
            CoordinateKind::Positions => "positions",
        }
    }
}

struct Line<'a>(&'a Option<usize>);

impl fmt::Display for Line<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |line| write!(f, "line {line}: "))
    }
}

struct Key<'a>(&'a Option<String>);

impl fmt::Display for Key<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.as_ref().map_or(Ok(()), |key| write!(f, "{key}: "))
    }
}
