//! Work beside the interpreter: without its lock, with progress, and ended by Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use super::faults;
use crate::prelude::*;

/// Time between two looks at signals and progress.
const INTERVAL: Duration = Duration::from_millis(50);

/// Stack of the thread that works, as large as that of a program's first thread.
const STACK: usize = 8 << 20;

/// Where the work stands.
#[derive(Debug, Default)]
struct Watch {
    cancelled: AtomicBool,
    stage: Mutex<Stage>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Stage {
    name: &'static str,
    done: u64,
    units: u64,
}

impl Watch {
    fn stage(&self) -> std::sync::MutexGuard<'_, Stage> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Observer for Watch {
    fn stage(&self, name: &'static str, units: u64) {
        *Watch::stage(self) = Stage {
            name,
            done: 0,
            units,
        };
    }

    fn advance(&self, units: u64) {
        Watch::stage(self).done += units;
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Does `work` on samples that come from there in a thread of its own, without the lock of the interpreter. The calling
/// thread looks after signals, and calls `progress(stage, done, units)`; an exception there cancels the work.
pub fn run<T: Send, E: Into<Failure> + Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    from: faults::From,
    work: impl FnOnce(&dyn Observer) -> Result<T, E> + Send,
) -> PyResult<T> {
    let watch = Watch::default();
    let progress = progress.map(|progress| progress.clone().unbind());
    let mut told = Stage::default();
    let mut look = |failed: &mut Option<PyErr>| {
        let stage = *watch.stage();
        let is_new = stage != told;
        Python::attach(|py| {
            py.check_signals()?;
            if let (true, Some(progress)) = (is_new, &progress) {
                told = stage;
                progress.call1(py, (stage.name, stage.done, stage.units))?;
            }
            Ok(())
        })
        .unwrap_or_else(|error| {
            watch.cancelled.store(true, Ordering::Relaxed);
            failed.get_or_insert(error);
        });
    };
    let mut failed = None;
    let done = py.detach(|| {
        std::thread::scope(|scope| {
            let (finished, waiting) = channel::<()>();
            let watch = &watch;
            let thread =
                std::thread::Builder::new()
                    .stack_size(STACK)
                    .spawn_scoped(scope, move || {
                        // Dropped when the work ends, however it does.
                        let _finished = finished;
                        work(watch)
                    })?;
            while waiting.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                look(&mut failed);
            }
            look(&mut failed);
            thread.join().map_err(|panic| {
                let text = panic.downcast_ref::<String>().cloned();
                let text = text.or(panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
                PyRuntimeError::new_err(text.unwrap_or_default())
            })
        })
    });
    match failed {
        Some(error) => Err(error),
        None => done?.map_err(|error| faults::of(py, error, from)),
    }
}
