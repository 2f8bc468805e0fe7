//! What can be stated about a file.

use std::fmt;

use super::coordinates::Evenness;
use super::resample::Resample;
use super::sidecar::Sidecar;
use super::{Layout, Quantity};
use crate::error::{Error, Result};
use crate::measure::{Dimension, Frequency, Length, Measure, Time, size};

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
    /// The array of a file that holds several: its path, or its name alone; of an archive with or
    /// without its `.npy`.
    pub variable: Option<String>,
    /// Dimension of the variable that stands for times: its name, or its number from 0.
    pub time_dim: Option<String>,
    /// That which stands for sites.
    pub space_dim: Option<String>,
    /// Where further dimensions are taken.
    pub at: Vec<At>,
    /// Parts of the axes that are taken.
    pub select: Vec<Selection>,
    /// Largest deviation of listed coordinates from even ones, as a share of a step, that is taken for
    /// jitter.
    pub jitter: f64,
    /// How samples at coordinates that deviate more come to even ones; without a method they are refused.
    pub resample: Resample,
    /// What becomes of traces of one file that begin at different times.
    pub delays: Delays,
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
            variable: None,
            time_dim: None,
            space_dim: None,
            at: Vec::new(),
            select: Vec::new(),
            jitter: JITTER,
            resample: Resample::default(),
            delays: Delays::default(),
            header: Header::default(),
            time_column: TimeColumn::default(),
            memory: None,
            read: ReadMode::default(),
            hash: true,
        }
    }
}

/// Share of a step by which coordinates may deviate from even ones: at Nyquist, 3 % of a radian.
const JITTER: f64 = 0.01;

/// A place on an axis.
#[derive(Debug, Clone, PartialEq)]
pub enum Label {
    /// Counted from 0.
    Index(u64),
    /// A coordinate, in this unit or else in that of the axis.
    Value {
        /// The number.
        value: f64,
        /// The unit, if one is stated.
        unit: Option<String>,
    },
}

/// The index of a further dimension: the one whose coordinate is nearest to the label.
#[derive(Debug, Clone, PartialEq)]
pub struct At {
    /// Its name, or its number from 0.
    pub dimension: String,
    /// What is taken.
    pub label: Label,
}

/// A part of an axis, both ends included; one left out is that of the axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Selection {
    /// `time`, `space`, or the name of the dimension.
    pub dimension: String,
    /// The first coordinate.
    pub from: Option<Label>,
    /// The last one.
    pub to: Option<Label>,
}

impl Label {
    /// From `0.3`, `3 mm`, or `#5` for an index.
    pub fn parse(text: &str) -> Option<Label> {
        let text = text.trim();
        if let Some(index) = text.strip_prefix('#') {
            return Some(Label::Index(index.trim().parse().ok()?));
        }
        // The number is the longest part that reads as one: `1e-3m`, `5 eV`.
        let ends = text.char_indices().map(|(at, c)| at + c.len_utf8()).rev();
        let value = |end: usize| {
            let value: f64 = text[..end].trim_end().parse().ok()?;
            value.is_finite().then_some((value, end))
        };
        let (value, end) = ends.filter_map(value).next()?;
        let unit = text[end..].trim();
        Some(Label::Value {
            value,
            unit: Some(unit.to_owned()).filter(|unit| !unit.is_empty()),
        })
    }

    /// By what the number is multiplied to be in `unit`; `None` if its own unit cannot be converted.
    pub(super) fn factor(&self, unit: Option<&str>) -> Option<f64> {
        let own = match self {
            Label::Value {
                unit: Some(own), ..
            } => own,
            _ => return Some(1.0),
        };
        let unit = unit?;
        let ratio = |from: Option<f64>, to: Option<f64>| Some(from? / to?);
        ratio(size::<Time>(own), size::<Time>(unit))
            .or_else(|| ratio(size::<Length>(own), size::<Length>(unit)))
            .or((own == unit).then_some(1.0))
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Label::Index(index) => write!(f, "#{index}"),
            Label::Value { value, unit } => {
                write!(f, "{value}{}", unit.as_deref().unwrap_or_default())
            }
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

/// What becomes of traces of one file that begin at different times (delay recording times of SEG-Y).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Delays {
    /// They are refused.
    #[default]
    Refuse,
    /// The times that all have in common are taken. A delay against the first trace within
    /// [`OpenOptions::jitter`] of a whole number of steps is exact; another one needs
    /// [`OpenOptions::resample`] along time.
    Align,
    /// All are read as if they began at one time.
    Ignore,
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

    /// What makes the coordinates of an axis even.
    pub(super) fn evenness(&self, axis: &'static str) -> Evenness {
        Evenness {
            jitter: self.jitter,
            method: match axis {
                "time" => self.resample.time,
                _ => self.resample.space,
            },
        }
    }

    /// Checks that `needed` bytes are within the memory limit.
    pub(super) fn allow(&self, what: &'static str, needed: u64) -> Result<()> {
        let allowed = self.memory.unwrap_or(u64::MAX);
        Error::beyond_memory(what, needed, allowed)
    }

    fn step(&self) -> Option<Measure<Time>> {
        self.dt.or(self.rate.map(Measure::period))
    }

    pub(super) fn check(&self) -> Result<()> {
        check("dt", self.dt, true)?;
        check("rate", self.rate, true)?;
        check("dx", self.dx, true)?;
        check("t0", self.t0, false)?;
        check("x0", self.x0, false)?;
        let is_share = (0.0..=0.5).contains(&self.jitter);
        let expected = "a share of a step from 0 to 0.5";
        Error::require(is_share, "jitter", expected, self.jitter)?;
        let is_one = self.dt.is_none() || self.rate.is_none();
        Error::require(is_one, "rate", "either the rate or the step dt", "both")
    }
}

/// That a stated number is finite, and a step above 0.
fn check<D: Dimension>(
    option: &'static str,
    stated: Option<Measure<D>>,
    is_step: bool,
) -> Result<()> {
    let above = if is_step { " above 0" } else { "" };
    let value = stated.map_or(1.0, |stated| stated.value);
    let is_fit = value.is_finite() && (value > 0.0 || !is_step);
    Error::require(is_fit, option, format!("a finite number{above}"), value)
}
