//! What can be stated about a file.

use super::sidecar::Sidecar;
use super::{Layout, Quantity};
use crate::error::{Error, Result};
use crate::measure::{Dimension, Frequency, Length, Measure, Time};

/// How a file is read. What is stated here overrides the sidecar, which overrides the file.
///
/// A step or an origin with a unit of its own (`10 us`) is converted to the unit of its axis. If
/// that unit is not stated, it is seconds or metres. A step without a unit is in the unit of its
/// axis: `Measure::new(0.1)`, or `0.1.into()`.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenOptions {
    pub layout: Option<Layout>,
    /// Time step, above 0.
    pub dt: Option<Measure<Time>>,
    /// Samples per unit of time, above 0, in place of the time step.
    pub rate: Option<Measure<Frequency>>,
    /// Distance of neighbouring sites, above 0.
    pub dx: Option<Measure<Length>>,
    /// Time of the first sample.
    pub t0: Option<Measure<Time>>,
    /// Place of the first site.
    pub x0: Option<Measure<Length>>,
    pub time_unit: Option<String>,
    pub space_unit: Option<String>,
    /// Unit of the samples.
    pub unit: Option<String>,
    pub quantity: Option<Quantity>,
    /// The array of an archive, with or without its `.npy`.
    pub member: Option<String>,
    pub header: Header,
    pub time_column: TimeColumn,
    /// Bytes that may be held in memory for what is not mapped (deflated members, tables, copies).
    pub memory: Option<u64>,
    /// How the bytes of the file are read.
    pub read: ReadMode,
    /// Whether [`Field::content_hash`](super::Field::content_hash) is computed, which reads the
    /// whole file once.
    pub hash: bool,
}

impl Default for OpenOptions {
    fn default() -> Self {
        OpenOptions {
            layout: None,
            dt: None,
            rate: None,
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
            read: ReadMode::default(),
            hash: true,
        }
    }
}

/// How the bytes of a file are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ReadMode {
    /// Mapped, and read from the file whenever they are needed.
    #[default]
    Map,
    /// Read once, into memory, for files that other programs may change.
    Copy,
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
            // A rate is a step by another name, so either of them overrides both.
            dt: self.step().or(sidecar.step()),
            rate: None,
            dx: self.dx.or(sidecar.dx),
            t0: self.t0.or(sidecar.t0),
            x0: self.x0.or(sidecar.x0),
            time_unit: self.time_unit.clone().or(sidecar.time_unit),
            space_unit: self.space_unit.clone().or(sidecar.space_unit),
            quantity: self.quantity.or(sidecar.quantity),
            unit: self.unit.clone().or(sidecar.unit),
            dispersion: sidecar.dispersion,
        }
    }

    /// Checks that `needed` bytes are within the memory limit.
    pub(super) fn allow(&self, what: &'static str, needed: u64) -> Result<()> {
        match self.memory {
            Some(allowed) if needed > allowed => Err(Error::Memory {
                what,
                needed,
                allowed,
            }),
            _ => Ok(()),
        }
    }

    fn step(&self) -> Option<Measure<Time>> {
        self.dt.or(self.rate.map(Measure::period))
    }

    pub(super) fn check(&self) -> Result<()> {
        above_zero("dt", self.dt)?;
        above_zero("rate", self.rate)?;
        above_zero("dx", self.dx)?;
        finite("t0", self.t0)?;
        finite("x0", self.x0)?;
        match (self.dt, self.rate) {
            (Some(_), Some(_)) => Err(refuse("rate", "either the rate or the step dt", "both")),
            _ => Ok(()),
        }
    }
}

fn refuse(option: &'static str, expected: &str, found: &str) -> Error {
    Error::Request {
        option,
        expected: expected.into(),
        found: found.into(),
    }
}

fn above_zero<D: Dimension>(option: &'static str, stated: Option<Measure<D>>) -> Result<()> {
    match stated {
        Some(step) if !(step.value.is_finite() && step.value > 0.0) => Err(refuse(
            option,
            "a finite number above 0",
            &step.value.to_string(),
        )),
        _ => Ok(()),
    }
}

fn finite<D: Dimension>(option: &'static str, stated: Option<Measure<D>>) -> Result<()> {
    match stated {
        Some(origin) if !origin.value.is_finite() => {
            Err(refuse(option, "a finite number", &origin.value.to_string()))
        }
        _ => Ok(()),
    }
}
