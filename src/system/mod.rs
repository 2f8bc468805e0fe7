//! Memory, prefetch, files, threads, scratch, and the journal of long work.

pub(crate) mod buffer;
pub(crate) mod journal;
pub(crate) mod threads;

pub(crate) use wavecascade_system::{file_io, memory, prefetch, publish, scratch_pool, signals};
