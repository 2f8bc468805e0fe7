//! Preparation, once, before all transforms: range, gaps, trends, tapers.
//!
//! A `Prepared` field holds trends, gaps and scale of the samples, not a copy of them: every block,
//! in either order, is read from the field and prepared on reading. A sample undergoes the same
//! operations in every block, so its bits do not depend on the blocks.

mod channels;
mod extremes;
mod prepared;
mod read_ahead;
mod scan;
pub mod slepian;
mod survey;
mod trend;
mod unit;
mod window;

pub use channels::{Examined, channel_findings};
pub(crate) use channels::{GAIN_STEPS, Sites, channels, some};
pub(crate) use prepared::{Prepared, Tiles};
pub(crate) use read_ahead::{ReadAhead, piece_bytes};
pub(crate) use scan::ChannelScan;
pub(crate) use survey::survey_bytes;
pub(crate) use trend::Trend;
pub use window::{Window, WindowError, WindowGains};

use crate::arrays::Precision;

/// The trend that is removed from a record or a snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Detrend {
    #[default]
    None,
    /// The mean.
    Mean,
    /// The least-squares line.
    Linear,
}

/// The treatment of samples that are not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gaps {
    /// The run fails; the error states their number and places.
    #[default]
    Refuse,
    /// Filled along time by the line between the neighbours; ends keep the nearest value, and a
    /// record without any finite sample becomes 0.
    Interpolate,
    /// Set to 0 after trends are removed; trends are fitted without them. In averages over segments they have the mean of
    /// their record, before trends are removed. They count as samples in the normalisation, so that a density is low by
    /// their share.
    Mask,
    /// Averages over segments leave out those with such samples; nothing is filled.
    LeaveOut,
}

/// The preparation of the samples before transforms.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Preparation<'a> {
    pub gaps: Gaps,
    /// Whether masked samples keep the mean of their record, where trends are removed from segments later.
    pub masks_by_mean: bool,
    /// Sites of the field that are left out: zeros, whatever their samples are.
    pub left_out: &'a [usize],
    pub precision: Precision,
    /// Samples of a record, from the first, that segments along time reach.
    pub reached: usize,
    /// Whether the others are transformed as well, along space or in short-time spectra.
    pub transforms_all: bool,
    /// Removes the mean over all samples first.
    pub detrend_field_mean: bool,
    pub detrend_space: Detrend,
    pub detrend_time: Detrend,
}
