//! From a field to its cascade: request, plan, run, result.

mod along;
mod between;
mod columns;
mod filtered;
mod flux;
mod front;
pub(crate) mod labels;
mod maps;
mod observer;
mod plan;
mod reference;
mod request;
mod result;
mod rows;
mod run;
mod short_time;
mod sink;
mod spacetime;
mod stages;
mod warning;
mod worker;

pub use along::Headline;
pub use filtered::{Filtered, filtered};
pub use observer::{Observer, Silent};
#[cfg(feature = "cli")]
pub(crate) use plan::half_of_free_memory;
pub use plan::{Blocks, Plan, PlanSummary, PlannedStage, plan};
pub use request::{Precision, Request, Results, Scaling, ShortTime, TimeRange, Welch};
pub use result::*;
pub use run::{analyze, run};
pub(crate) use sink::Collect;
pub use sink::{Arrays, LargeArray, Nowhere, Sink, Spectra};
pub use warning::Warning;

/// Cells of a map, `(rows, columns)`: as many as a page shows.
const MAP_LIMIT: (usize, usize) = (400, 300);

/// Whether the bin `q` of `axis` lies in `band`, both ends included: a typed edge that misses its
/// bin by rounding means that bin.
fn in_band(q: f64, band: (f64, f64), axis: &[f64]) -> bool {
    let slack = 1e-9 * axis.get(1).copied().unwrap_or_default();
    (band.0 - slack..=band.1 + slack).contains(&q)
}

/// Index of the sample nearest to `at`, within `count`.
fn nearest(axis: &crate::field::Axis, at: f64, count: usize) -> usize {
    let index = ((at - axis.origin) / axis.step).round().max(0.0);
    (index as usize).min(count.saturating_sub(1))
}
