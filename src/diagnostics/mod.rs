//! Diagnostics of spectra: distribution of energy, directions, defects of the data.

mod bins;
mod interleaved;
mod map;
mod moments;

pub(crate) use bins::Bins;
pub(crate) use map::{MAP_LIMIT, MapBuilder};
pub use map::{Map, MapAxis, Reduction};
pub(crate) use moments::{SpectrumMoments, edge_of, interleaved_moments, quantile_of};
