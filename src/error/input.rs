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

    #[error("expected shape {}, found {}", shape_of(expected), shape_of(found))]
    RunShape { expected: Vec<u64>, found: Vec<u64> },

    #[error("expected what the scene in the file says, found another {what} at index {index}")]
    RunScene { what: &'static str, index: usize },

    #[error("expected the values of `{what}` that were written, found others: its hash differs")]
    RunChanged { what: &'static str },

    #[error("expected the report of a run, found {reason}")]
    RunReport { reason: String },

    #[error("expected samples, found an array of shape {}", shape_of(shape))]
    NoSamples { shape: Vec<u64> },

    #[error(
        "expected an array that can be addressed, found shape {} of {sample_bytes}-byte samples",
        shape_of(shape)
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
    #[error("{}", of_container(fault))]
    Container { fault: Box<FormatError> },

    #[error("expected one array v(t, x), found {}", some_of(variables))]
    WhichVariable { variables: Vec<String> },

    #[error("expected the variable {name:?}, found {}", some_of(variables))]
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

    #[error("{}{}{reason}", before("line ", line), before("", key))]
    Sidecar {
        line: Option<usize>,
        key: Option<String>,
        reason: String,
    },

    #[error("expected at most {limit} bytes of settings, found {found}")]
    SidecarLength { found: u64, limit: u64 },
}

/// What exists where a file was expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FileKind {
    #[error("a directory")]
    Directory,
    #[error("a pipe")]
    Pipe,
    #[error("a socket")]
    Socket,
    #[error("a device")]
    Device,
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
        let range = self.range.as_ref().map(|(first, last, unit)| {
            let unit = unit.as_deref().unwrap_or_default();
            format!(" from {first} to {last} {unit}")
        });
        let range = range.unwrap_or_default();
        write!(f, "{} ({} values{})", self.name, self.len, range.trim_end())
    }
}

/// What is wrong, without what to do about it.
fn of_container(fault: &FormatError) -> String {
    match fault {
        FormatError::Unsupported { what, .. } => {
            format!("expected a part of the format that is read, found {what}")
        }
        fault => fault.to_string(),
    }
}

/// Some of many names.
fn some_of(names: &[String]) -> String {
    const MOST: usize = 12;
    match names.len() {
        0 => "none".into(),
        1..=MOST => names.join(", "),
        all => format!("{} and {} more", names[..MOST].join(", "), all - MOST),
    }
}

fn shape_of(lengths: &[u64]) -> String {
    let lengths: Vec<String> = lengths.iter().map(u64::to_string).collect();
    format!("({})", lengths.join(", "))
}

/// A place, where it is known, before what is said of it.
fn before(word: &str, place: &Option<impl fmt::Display>) -> String {
    let named = place.as_ref().map(|place| format!("{word}{place}: "));
    named.unwrap_or_default()
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
