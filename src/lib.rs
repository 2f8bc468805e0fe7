#![doc = include_str!("../README.md")]
#![warn(missing_debug_implementations)]

pub mod analyze;
pub mod attenuation;
pub mod budget;
mod buffer;
mod caches;
pub mod chain;
mod diagnostics;
pub mod error;
pub mod field;
mod io;
mod ledger;
pub mod localized;
mod logarithm;
pub mod measure;
#[cfg(feature = "figures")]
pub mod plot;
pub mod prepare;
pub mod reference;
pub mod report;
mod spare;
mod sum;
pub mod sweep;
mod threads;
#[cfg(feature = "cli")]
pub mod throughput;
pub mod transform;
mod turns;

pub use analyze::analyze;
pub use error::{Error, Result};
pub use field::Field;
