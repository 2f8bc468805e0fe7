//! What every average shares: segments, tapers and shots, read in the memory allowed; their effective
//! number, and the intervals that follow from it.

mod averaging;
mod ensemble;
mod grid;
mod interval;
mod part;
mod shots;
mod tree;

pub use averaging::{Averaging, Tapers};
pub(crate) use averaging::{Realisations, SegmentScratch};
pub use ensemble::Independence;
pub(crate) use ensemble::{LEAST_STEADINESS, steadiness};
pub use grid::Grid;
pub(crate) use interval::FactorTable;
pub use interval::{SpectrumInterval, interval_factors};
pub use part::Part;
pub(crate) use part::Portion;
pub(crate) use shots::{Shot, Shots, TOGETHER, first_of};
pub(crate) use tree::{RecordTree, SegmentTree, Sums, TreeNode, held_at_once};
