#![doc = include_str!("../README.md")]
#![warn(missing_debug_implementations)]

pub mod analyze;
pub mod arrays;
pub mod attenuation;
pub mod budget;
pub mod chain;
pub mod design;
mod diagnostics;
pub mod error;
pub mod estimates;
pub mod field;
pub mod fit;
mod formula;
pub mod localized;
pub mod measure;
pub mod moved;
mod numeric;
pub mod observer;
#[cfg(feature = "figures")]
pub mod plot;
pub mod prepare;
pub mod reference;
pub mod report;
pub mod ridges;
pub mod sheet;
pub mod sweep;
mod system;
pub mod transform;
mod unit;

pub use analyze::analyze;
pub use error::{Error, Result};
pub use field::Field;
pub use fit::plan;

/// The examples of the guide, compiled and run as tests.
#[cfg(doctest)]
mod guide {
    #[doc = include_str!("../docs/guide/scans.md")]
    struct Scans;
    #[doc = include_str!("../docs/guide/chains.md")]
    struct Chains;
    #[doc = include_str!("../docs/guide/budgets.md")]
    struct Budgets;
    #[doc = include_str!("../docs/guide/localized-waves.md")]
    struct LocalizedWaves;
    #[doc = include_str!("../docs/guide/attenuation.md")]
    struct Attenuation;
}
