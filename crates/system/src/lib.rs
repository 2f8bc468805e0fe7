//! Files at given positions and files that appear whole, memory, prefetch, threads and signals: what the crates of this
//! workspace need of the system.

#![warn(missing_debug_implementations, missing_docs)]

pub mod file_io;
mod limits;
pub mod memory;
pub mod prefetch;
pub mod publish;
pub mod signals;
pub mod threads;
