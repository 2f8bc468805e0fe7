#![doc = include_str!("../README.md")]
#![warn(missing_debug_implementations)]

pub mod analyze;
pub mod error;
pub mod field;
#[cfg(feature = "figures")]
pub mod plot;
pub mod prepare;
pub mod reference;
pub mod report;
mod turns;

pub use error::{Error, Result};
pub use field::Field;
