//! Worker threads of a run of their own.

use crate::error::{Error, Result};

/// Does `work` on so many threads; `None`, or where the current pool has as many: on those of the
/// current pool.
pub(crate) fn in_pool<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    let is_worker = rayon::current_thread_index().is_some();
    let fits = |&threads: &usize| is_worker && threads == rayon::current_num_threads();
    let Some(threads) = threads.filter(|threads| !fits(threads)) else {
        return work();
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Error::Threads {
        threads,
        reason: error.to_string(),
    })?;
    pool.install(work)
}
