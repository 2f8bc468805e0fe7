//! Results to files.

#[cfg(feature = "figures")]
mod html;

#[cfg(feature = "figures")]
pub use html::html;
