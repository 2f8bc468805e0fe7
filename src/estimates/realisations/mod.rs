//! What every average shares: segments, tapers and shots, read in the memory allowed; their effective
//! number, and the intervals that follow from it.

mod averaging;
mod ensemble;
mod interval;
mod shots;

pub use averaging::{Averaging, Tapers};
pub(crate) use averaging::{Realisations, SegmentScratch};
pub use ensemble::Independence;
pub(crate) use ensemble::steadiness;
pub(crate) use interval::FactorTable;
pub use interval::{SpectrumInterval, interval_factors};
pub(crate) use shots::{Shot, Shots, TOGETHER, first_of};
