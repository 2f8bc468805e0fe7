//! From a field to its cascade: request, plan, run, result.

mod along;
mod arrays;
mod columns;
mod filtered;
mod flux;
mod front;
mod intermediate;
pub(crate) mod labels;
mod maps;
mod plan;
mod quality;
mod reference;
mod request;
mod result;
mod rows;
mod run;
mod short_time;
mod spacetime;
mod stages;
mod warning;
mod worker;

pub use crate::diagnostics::{Map, MapAxis, Reduction};
pub use crate::transform::Scaling;
pub use along::Headline;
pub use arrays::Spectra;
pub use filtered::{Filtered, filtered};
pub use plan::{Blocks, Plan, PlanSummary, PlannedStage, plan};
pub use request::{Request, Results, ShortTime, TimeRange, Welch};
pub use result::*;
pub use run::{analyze, run};
pub use warning::Warning;

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
