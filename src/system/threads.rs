//! Worker threads of one run.

use crate::error::{Error, Result};

/// Runs `work` on a pool of `threads` threads. With `None`, or if the current pool has that number
/// of threads, it runs on the current pool.
///
/// # Errors
/// Those of `work`; [`Error::Threads`] where the threads cannot be started.
pub(crate) fn in_pool<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    let is_worker = rayon::current_thread_index().is_some();
    let fits = |threads: usize| is_worker && threads == rayon::current_num_threads();
    let Some(threads) = threads.filter(|threads| !fits(*threads)) else {
        return work();
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Error::Threads {
        threads,
        reason: error.to_string(),
    })?;
    pool.install(work)
}
