//! What every average shares: segments, tapers and shots, read in the memory allowed; their effective
//! number, and the intervals that follow from it.

mod adaptive;
mod averaging;
mod effective;
mod ensemble;
mod grid;
mod interval;
mod kept;
mod part;
mod records;
mod sheet;
mod shots;
mod sums;

/// Probability by which a level of significance is exceeded by chance, or an interval does not hold, unless another is
/// stated.
pub const SIGNIFICANCE: f64 = 0.05;

pub(crate) use adaptive::{Average, Weights, WithoutOne};
pub use averaging::{Averaging, Tapers};
pub(crate) use averaging::{Realisations, SegmentScratch, check_count};
pub use ensemble::Independence;
pub(crate) use ensemble::{
    LEAST_STEADINESS, level_of_chance, steadiness, steadiness_of_field, steadiness_of_sites,
};
pub use grid::Grid;
pub(crate) use interval::{FactorTable, phase_spread};
pub use interval::{SpectrumInterval, interval_factors};
pub(crate) use kept::KeptOfSites;
pub use kept::SegmentsLeft;
pub use part::Part;
pub(crate) use part::Portion;
pub(crate) use records::{Records, interleave};
pub(crate) use sheet::{least_median_most, without_mean};
pub(crate) use shots::{
    FILLED, Shot, Shots, TOGETHER, a_site, check_significance, first_of, refuse_left_out,
};
pub(crate) use sums::{Sums, SumsShape};
