//! Worker threads of one run.

use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};

/// Runs `work` on a pool of `threads` threads. With `None`, or if the current pool has that number
/// of threads, it runs on the current pool.
///
/// # Errors
/// If the threads cannot be started.
pub fn in_pool<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> T + Send,
) -> Result<T, ThreadPoolBuildError> {
    let is_worker = rayon::current_thread_index().is_some();
    let fits = |&threads: &usize| is_worker && threads == rayon::current_num_threads();
    match threads.filter(|threads| !fits(threads)) {
        None => Ok(work()),
        Some(threads) => {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
            Ok(pool.install(work))
        }
    }
}
