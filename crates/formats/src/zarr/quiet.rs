//! Panics of `zarrs` that are caught print nothing.

use std::panic::{PanicHookInfo, set_hook, take_hook};
use std::sync::Once;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Calls of `zarrs` at the moment, on all threads.
static CALLS: AtomicUsize = AtomicUsize::new(0);

/// While it lives, a panic in the source of `zarrs` is not printed. Chunks are decoded on any thread, so that the
/// place of the panic decides and not the thread; all other panics are told as before.
pub(super) struct Silence(());

impl Silence {
    pub(super) fn new() -> Silence {
        static PREPARED: Once = Once::new();
        PREPARED.call_once(|| {
            let told = take_hook();
            set_hook(Box::new(move |panic| {
                if CALLS.load(Ordering::SeqCst) == 0 || !is_of_zarrs(panic) {
                    told(panic);
                }
            }));
        });
        CALLS.fetch_add(1, Ordering::SeqCst);
        Silence(())
    }
}

impl Drop for Silence {
    fn drop(&mut self) {
        CALLS.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Whether the source that panicked belongs to `zarrs` or one of the crates that it is made of.
fn is_of_zarrs(panic: &PanicHookInfo) -> bool {
    panic.location().is_some_and(|at| {
        let mut folders = at.file().split(['/', '\\']);
        folders.any(|folder| folder.starts_with("zarrs-") || folder.starts_with("zarrs_"))
    })
}
