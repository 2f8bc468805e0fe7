//! From a field to its cascade: request, plan, run, result.

mod along;
mod answer;
mod arrays;
pub(crate) mod axes;
mod blocks;
mod columns;
mod dispersion;
mod display;
mod filtered;
mod flux;
mod front;
mod gains;
mod intermediate;
pub(crate) mod labels;
mod noise;
mod plan;
mod quality;
mod reference;
mod request;
mod result;
mod rows;
mod run;
pub(crate) mod sheet;
mod short_time;
mod spacetime;
mod stages;
mod worker;

pub use crate::diagnostics::{Map, MapAxis, Reduction};
pub use crate::prepare::channel_findings;
pub use crate::sheet::Warning;
pub use crate::transform::Scaling;
pub use along::Headline;
pub use arrays::Spectra;
pub use axes::Axes;
pub(crate) use dispersion::formula_values;
pub use dispersion::{Constants, Dispersion, DispersionCurve, parse_constants};
pub use display::{Display, Extent, Show, ShowAxis};
pub use filtered::{Filtered, filtered};
pub use plan::{Blocks, Plan, PlanSummary, PlannedStage, plan};
pub use request::{Request, Results, ShortTime, TimeRange, Welch};
pub use result::*;
pub use run::{analyze, run};

/// Index of the sample nearest to `at`, within `count`.
fn nearest(axis: &crate::field::Axis, at: f64, count: usize) -> usize {
    let index = ((at - axis.origin) / axis.step).round().max(0.0);
    (index as usize).min(count.saturating_sub(1))
}
