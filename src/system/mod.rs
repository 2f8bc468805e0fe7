//! Memory, prefetch, files, threads, scratch, and the journal of long work.

pub(crate) mod buffer;
pub(crate) mod file_io;
pub(crate) mod journal;
pub(crate) mod memory;
pub(crate) mod prefetch;
pub(crate) mod publish;
pub(crate) mod scratch_pool;
pub(crate) mod threads;
