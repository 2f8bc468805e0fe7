//! From a field to its cascade: request, plan, run, result.

mod observer;
mod request;
mod result;
mod warning;

pub use observer::{Observer, Silent};
pub use request::{Precision, Request, Results, Scaling, ShortTime, TimeRange, Welch};
pub use result::*;
pub use warning::Warning;
