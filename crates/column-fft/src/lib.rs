//! Real Fourier transforms along the strided axis of an array.

#![warn(missing_debug_implementations)]

pub mod columns;
mod inverse;
mod plane;
mod pool;
mod real;
mod short_time;
mod twiddle;

pub use columns::ColumnTransform;
pub use inverse::ColumnInverse;
pub use plane::{SpaceTimeInverse, SpaceTimeTransform};
pub use real::Real;
pub use short_time::ShortTimeTransform;
