//! Worker threads of one run, with the library's error.

use crate::error::{Error, Result};

/// As [`wavecascade_system::threads::in_pool`].
///
/// # Errors
/// Those of `work`; [`Error::Failed`] where the threads cannot be started.
pub(crate) fn in_pool<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    wavecascade_system::threads::in_pool(threads, work).map_err(|error| {
        let threads = threads.unwrap_or_else(rayon::current_num_threads);
        Error::failed(format!("cannot start {threads} worker threads: {error}"))
    })?
}
