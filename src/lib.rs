#![doc = include_str!("../README.md")]
#![warn(missing_debug_implementations)]

pub mod analyze;
pub mod chain;
pub mod error;
pub mod field;
#[cfg(feature = "figures")]
pub mod plot;
pub mod prepare;
pub mod report;

pub use error::{Error, Result};
pub use field::Field;
