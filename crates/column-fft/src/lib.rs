#![doc = include_str!("../README.md")]
#![warn(missing_debug_implementations, missing_docs)]
#![deny(unsafe_op_in_unsafe_fn)]

mod columns;
mod complex;
mod error;
mod inverse;
mod plane;
mod planner;
#[cfg(feature = "rayon")]
mod pool;
mod real;
pub mod rows;
mod short_time;
mod twiddle;
mod view;

pub use columns::{Algorithm, InstructionSet, RealToComplexColumns};
pub use complex::ComplexToComplexColumns;
pub use error::FftError;
pub use inverse::ComplexToRealColumns;
pub use plane::{ComplexToReal2d, Filter2d, RealToComplex2d};
pub use planner::ColumnFftPlanner;
pub use real::Real;
pub use short_time::ShortTimeColumns;
pub use view::{Columns, ColumnsMut, SegmentsMut};

pub use num_complex::Complex;
pub use realfft::{ComplexToReal, RealToComplex};
pub use rustfft::{Fft, FftDirection};
