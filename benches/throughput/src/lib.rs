//! Throughput of the column, two-dimensional and short-time transforms compared with reference
//! implementations, and a gate against regressions.
//!
//! # Equations
//! - GFLOP/s: `2.5 n log2 n` operations per real transform of n samples ([`CaseOf::operations`]),
//!   divided by the median time.
//! - The bound is the time to read the array and to write its spectra once, at the rate of a copy
//!   that exceeds the caches ([`copy_rate`]). The part of the bound is that time over the median
//!   time.
//! - Single-threaded times are CPU times ([`Clock`]), so that other load hardly matters.
//! - The ratio to another implementation is the median over rounds of the quotient of times within
//!   a round ([`Throughput::ratio`]). Rounds are interleaved: each implementation runs once per
//!   round. Changes of clock rate or load affect all of them, so quotients vary less than times.
//! - Instructions per sample are counted by valgrind, for `k` and for `k + m` transforms; the
//!   difference over `m` excludes startup and planning ([`CountedCase`]). They do not depend on
//!   load.
//!
//! # Baselines
//! A [`Baseline`] holds ratios by processor and instruction set, and instruction counts by
//! architecture. A case may lose at most [`LARGEST_LOSS`] of either.

mod baseline;
mod buffer;
mod case;
mod counted;
mod error;
mod kind;
mod machine;
mod planes;
mod rounds;
mod ways;

pub use baseline::{Baseline, Comparison, Instructions, Ratios};
pub use buffer::Buffer;
pub use case::{ArrayShape, CaseOf, fit_memory, name};
pub use counted::{Counted, CountedCase};
pub use error::{Error, Result};
pub use kind::{Precision, TransformKind};
pub use machine::{Machine, Versions};
pub use rounds::{Clock, Rounds, Throughput, copy_rate, median, table};
pub use ways::{Arrays, Description, Implementation, PlannedTransform};

/// The fraction of its throughput that a case may lose against the baseline.
pub const LARGEST_LOSS: f64 = 0.1;
