//! Memory, prefetch, files, threads, and the journal of long work.

pub(crate) mod buffer;
pub(crate) mod journal;
pub(crate) mod threads;

pub(crate) use wavecascade_system::{file_io, memory, prefetch, publish, signals};

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::{Error, Result};

/// The value, also where a thread that had it panicked.
pub(crate) fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether the bytes `needed` are `allowed`, by default half of the free memory.
///
/// # Errors
/// [`Error::Memory`], of `what`.
pub(crate) fn check_memory(what: &'static str, needed: u64, allowed: Option<u64>) -> Result<()> {
    let allowed = allowed.unwrap_or_else(memory::half_of_free_memory);
    Error::beyond_memory(what, needed, allowed)
}
