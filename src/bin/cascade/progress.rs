//! Progress bar, and Ctrl-C.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use wavecascade::observer::Observer;
use wavecascade_system::signals;

use crate::failure::{Failure, INTERRUPTED, TIMED_OUT};

/// A stage shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_millis(300);

/// Letters of a name that are shown.
const LONGEST: usize = 24;

/// The command whose work an end by `--max-time` cancels; none before there is one.
static WATCHED: Mutex<Option<Arc<Shared>>> = Mutex::new(None);

/// Whether the time of `--max-time` is over.
static EXPIRED: AtomicBool = AtomicBool::new(false);

/// Ends the command after `most`, as an interrupt does, where a time is stated.
pub fn end_after(most: Option<Duration>) {
    let Some(most) = most else { return };
    let wait = move || {
        std::thread::sleep(most);
        EXPIRED.store(true, Ordering::Relaxed);
        let watched = lock(&WATCHED).clone();
        match watched {
            Some(shared) => shared.interrupt(),
            None => end_at_once(),
        }
    };
    // Without its thread the command takes as long as it takes.
    let _ = std::thread::Builder::new().spawn(wait);
}

/// The exit code of work that was stopped: as shells count signals, or as `timeout` ends.
pub fn stopped_code() -> u8 {
    if EXPIRED.load(Ordering::Relaxed) {
        return TIMED_OUT;
    }
    let signal = signals::stopped_by().and_then(|signal| u8::try_from(signal).ok());
    signal.map_or(INTERRUPTED, |signal| 128 + signal)
}

/// Of work that was stopped, the reason, where it is `--max-time`.
pub fn reason() -> Option<&'static str> {
    let expired = EXPIRED.load(Ordering::Relaxed);
    expired.then_some("the time of `--max-time` is over")
}

fn end_at_once() -> ! {
    std::process::exit(Failure::from(wavecascade::Error::Cancelled).report().into())
}

/// Shows each stage's progress on standard error where that is a terminal.
#[derive(Debug)]
pub struct Progress {
    shown: bool,
    /// What of several things the work is for; empty where there is one.
    part: Mutex<String>,
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    stage: Mutex<Stage>,
    phase: Mutex<Phase>,
    interrupted: AtomicBool,
}

#[derive(Debug)]
struct Stage {
    bar: ProgressBar,
    since: Instant,
}

/// What an interrupt finds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// Nothing has been written: the program can end at once.
    Reading,
    /// Ctrl-C cancels the work, which then removes its partial output.
    Writing,
    /// The work has been cancelled.
    Stopping,
}

impl Progress {
    /// Shown where standard error is a terminal. Listens for Ctrl-C and termination from now on; a second one ends the program at once.
    pub fn new(shown: bool) -> Self {
        let shared = Arc::new(Shared {
            stage: Mutex::new(Stage {
                bar: ProgressBar::hidden(),
                since: Instant::now(),
            }),
            phase: Mutex::new(Phase::Reading),
            interrupted: AtomicBool::new(false),
        });
        *lock(&WATCHED) = Some(Arc::clone(&shared));
        let heard = Arc::clone(&shared);
        signals::on_stop(move || heard.interrupt());
        Progress {
            shown: shown && std::io::stderr().is_terminal(),
            part: Mutex::default(),
            shared,
        }
    }

    /// From now on stages are those of the n-th of several things.
    pub fn of(&self, n: usize, all: usize, name: &str) {
        let name: String = name.chars().take(LONGEST).collect();
        *lock(&self.part) = format!("{n} of {all}, {name}: ");
    }

    /// Shows a stage whose progress is unknown.
    pub fn wait(&self, name: &'static str) {
        self.stage(name, 1);
        let stage = lock(&self.shared.stage);
        if self.shown
            && let Ok(style) = ProgressStyle::with_template("{spinner} {msg}, {elapsed}")
        {
            stage.bar.set_style(style);
            stage.bar.set_draw_target(ProgressDrawTarget::stderr());
            stage.bar.enable_steady_tick(PATIENCE / 3);
        }
    }

    /// From now on an interrupt has something to tidy up.
    pub fn begin_writing(&self) {
        *lock(&self.shared.phase) = Phase::Writing;
    }

    /// Ends with an error if the user has asked to stop.
    pub fn check(&self) -> wavecascade::Result<()> {
        if self.cancelled() {
            self.clear();
            return Err(wavecascade::Error::Cancelled);
        }
        Ok(())
    }

    /// Removes the bar.
    pub fn clear(&self) {
        lock(&self.shared.stage).bar.finish_and_clear();
    }
}

impl Shared {
    fn interrupt(&self) {
        let mut phase = lock(&self.phase);
        match *phase {
            Phase::Writing => {
                *phase = Phase::Stopping;
                self.interrupted.store(true, Ordering::Relaxed);
            }
            Phase::Reading => {
                lock(&self.stage).bar.finish_and_clear();
                end_at_once();
            }
            Phase::Stopping => std::process::exit(stopped_code().into()),
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Observer for Progress {
    fn stage(&self, name: &'static str, units: u64) {
        let style = ProgressStyle::with_template("{msg:<26} {bar:30} {percent:>3} %  {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::with_draw_target(Some(units), ProgressDrawTarget::hidden());
        bar.set_style(style);
        bar.set_message(format!("{}{name}", lock(&self.part)));
        let stage = Stage {
            bar,
            since: Instant::now(),
        };
        std::mem::replace(&mut *lock(&self.shared.stage), stage)
            .bar
            .finish_and_clear();
    }

    fn advance(&self, units: u64) {
        let stage = lock(&self.shared.stage);
        if self.shown && stage.bar.is_hidden() && stage.since.elapsed() > PATIENCE {
            stage.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        stage.bar.inc(units);
    }

    fn cancelled(&self) -> bool {
        self.shared.interrupted.load(Ordering::Relaxed)
    }
}
