//! What can be stated about a file.

use super::sidecar::Sidecar;
use super::{Layout, Quantity};
use crate::error::{Error, Result};

/// How a file is read. What is stated here overrides the sidecar, which overrides the file.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenOptions {
    pub layout: Option<Layout>,
    /// Time step, above 0.
    pub dt: Option<f64>,
    /// Distance of neighbouring sites, above 0.
    pub dx: Option<f64>,
    /// Time of the first sample.
    pub t0: Option<f64>,
    /// Place of the first site.
    pub x0: Option<f64>,
    pub time_unit: Option<String>,
    pub space_unit: Option<String>,
    /// Unit of the samples.
    pub unit: Option<String>,
    pub quantity: Option<Quantity>,
    /// The array of an archive, with or without its `.npy`.
    pub member: Option<String>,
    pub header: Header,
    pub time_column: TimeColumn,
    /// Bytes that may be held in memory for what cannot be mapped (deflated members, tables).
    pub memory: Option<u64>,
    /// Whether [`Field::content_hash`](super::Field::content_hash) is computed, which reads the whole file once.
    pub hash: bool,
}

impl Default for OpenOptions {
    fn default() -> Self {
        OpenOptions {
            layout: None,
            dt: None,
            dx: None,
            t0: None,
            x0: None,
            time_unit: None,
            space_unit: None,
            unit: None,
            quantity: None,
            member: None,
            header: Header::default(),
            time_column: TimeColumn::default(),
            memory: None,
            hash: true,
        }
    }
}

/// Whether the first line of a table names its columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Header {
    /// It does if its first cell is a word, or if none of its cells is a number.
    #[default]
    Detect,
    Present,
    Absent,
}

/// Which column of a table holds the times.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum TimeColumn {
    /// The first one that a header names `t` or `time`, with or without a unit (`time_s`).
    #[default]
    Detect,
    None,
    /// Counted from 0.
    Index(usize),
    /// Its header cell.
    Name(String),
}

impl OpenOptions {
    pub(super) fn over(&self, sidecar: Sidecar) -> Sidecar {
        Sidecar {
            layout: self.layout.or(sidecar.layout),
            dt: self.dt.or(sidecar.dt),
            dx: self.dx.or(sidecar.dx),
            t0: self.t0.or(sidecar.t0),
            x0: self.x0.or(sidecar.x0),
            time_unit: self.time_unit.clone().or(sidecar.time_unit),
            space_unit: self.space_unit.clone().or(sidecar.space_unit),
            quantity: self.quantity.or(sidecar.quantity),
            unit: self.unit.clone().or(sidecar.unit),
        }
    }

    pub(super) fn check(&self) -> Result<()> {
        let refuse = |option, expected: &str, found: f64| Error::Request {
            option,
            expected: expected.into(),
            found: found.to_string(),
        };
        for (option, value) in [("dt", self.dt), ("dx", self.dx)] {
            if let Some(step) = value.filter(|step| !(step.is_finite() && *step > 0.0)) {
                return Err(refuse(option, "a finite number above 0", step));
            }
        }
        for (option, value) in [("t0", self.t0), ("x0", self.x0)] {
            if let Some(origin) = value.filter(|origin| !origin.is_finite()) {
                return Err(refuse(option, "a finite number", origin));
            }
        }
        Ok(())
    }
}
