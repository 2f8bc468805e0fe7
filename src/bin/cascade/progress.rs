//! A bar for what is being done, and Ctrl-C.

use std::sync::Arc;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, Ordering};

use cascade::analyze::Observer;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Shows each stage's progress on standard error where that is a terminal.
#[derive(Debug)]
pub struct Progress {
    bar: Mutex<ProgressBar>,
    shown: bool,
    interrupted: Arc<AtomicBool>,
}

impl Progress {
    /// Listens for Ctrl-C and termination from now on; a second one ends the program at once.
    pub fn new(shown: bool) -> Self {
        let interrupted = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&interrupted);
        // Without a handler an interrupt still ends the program, only less tidily.
        let _ = ctrlc::set_handler(move || {
            if flag.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        });
        Progress {
            bar: Mutex::new(ProgressBar::hidden()),
            shown,
            interrupted,
        }
    }

    /// Ends with an error if the user has asked to stop.
    pub fn check(&self) -> cascade::Result<()> {
        if self.cancelled() {
            self.clear();
            return Err(cascade::Error::Cancelled);
        }
        Ok(())
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        self.lock().finish_and_clear();
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, ProgressBar> {
        self.bar.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Observer for Progress {
    fn stage(&self, name: &'static str, units: u64) {
        let target = if self.shown {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let style = ProgressStyle::with_template("{msg:<26} {bar:30} {percent:>3} %  {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::with_draw_target(Some(units), target);
        bar.set_style(style);
        bar.set_message(name);
        std::mem::replace(&mut *self.lock(), bar).finish_and_clear();
    }

    fn advance(&self, units: u64) {
        self.lock().inc(units);
    }

    fn cancelled(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }
}
