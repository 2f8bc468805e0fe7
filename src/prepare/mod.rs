//! Preparation, once, before all transforms: range, gaps, trends, tapers.

mod lobes;
pub mod slepian;
mod window;

pub use lobes::Lobes;
pub use window::{Window, WindowError, WindowGains};

/// What is removed from a record or a profile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Detrend {
    #[default]
    None,
    /// The mean.
    Mean,
    /// The least-squares line.
    Linear,
}

/// What is done with samples that are not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gaps {
    /// The run stops and says how many there are and where.
    #[default]
    Refuse,
    /// Filled along time by the line between the neighbours; ends keep the nearest value.
    Interpolate,
    /// Set to 0 after trends are removed; trends are fitted without them.
    Mask,
}
