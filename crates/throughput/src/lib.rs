//! Throughput of the transforms of all columns, of both axes and of short-time segments, beside the usual
//! ways, and a gate against its loss.
//!
//! # Equations
//! - `2.5 n log2 n` operations for n real numbers that are transformed together, over the median time:
//!   GFLOP/s ([`CaseOf::operations`]).
//! - The bound is the array read and its spectra written once at the rate of a copy past the caches
//!   ([`copy_rate`]); the part of it is its time over the median time.
//! - Times of one thread are the processor's ([`Clock`]), so that a busy machine hardly counts.
//! - The ratio to another way is the median over rounds of the quotient of times within a round
//!   ([`Throughput::ratio`]): each way runs once a round, so that a change of the machine's clock or
//!   load meets all of them, and quotients move less than times.
//! - Instructions per sample are counted by valgrind, for `k` and for `k + m` transforms; the
//!   difference over `m` leaves start and planning out ([`CountedCase`]). They do not depend on load.
//!
//! # What is kept
//! A [`Baseline`] holds ratios by processor and instruction set, and counts by architecture. Of either
//! a case may lose no more than [`LARGEST_LOSS`].

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

/// The part of its throughput that a case may lose against the baseline.
pub const LARGEST_LOSS: f64 = 0.1;
