//! Diagnostics of spectra: distribution of energy, directions, defects of the data.

mod bins;
mod interleaved;
mod map;
mod map_builder;
mod moments;

pub use crate::sheet::{Map, MapAxis, Reduction};
pub(crate) use bins::Bins;
pub(crate) use map::{Keep, MAP_LIMIT};
pub(crate) use map_builder::MapBuilder;
pub(crate) use moments::{SpectrumMoments, edge_of, interleaved_moments, quantile_of};
