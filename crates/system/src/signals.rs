//! Signals that would end the program without a word.

use std::path::Path;
use std::ptr::null_mut;
use std::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use std::sync::atomic::{AtomicI32, AtomicPtr, AtomicUsize};

#[cfg(unix)]
pub use bus_error::prepare;

/// The last signal that asked to stop.
static STOPPED_BY: AtomicI32 = AtomicI32::new(0);

/// Calls `stop` at each interrupt, termination and hangup, on a thread of its own. Only the first call has an effect.
/// Where the system refuses, these still end the program, only less tidily.
pub fn on_stop(stop: impl Fn() + Send + 'static) {
    static CALLED: std::sync::Once = std::sync::Once::new();
    CALLED.call_once(|| {
        #[cfg(unix)]
        {
            use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
            let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGHUP])
            else {
                return;
            };
            let listen = move || {
                for signal in signals.forever() {
                    STOPPED_BY.store(signal, Relaxed);
                    stop();
                }
            };
            let _ = std::thread::Builder::new().spawn(listen);
        }
        #[cfg(not(unix))]
        let _ = ctrlc::set_handler(stop);
    });
}

/// The number of the signal that came, if one did and signals have numbers here.
pub fn stopped_by() -> Option<i32> {
    Some(STOPPED_BY.load(Relaxed)).filter(|&signal| signal != 0)
}

/// Files that are mapped at a time and named in the message; of more it is silent.
const SLOTS: usize = 64;

static WATCHED: [Slot; SLOTS] = [const {
    Slot {
        path: AtomicPtr::new(null_mut()),
        length: AtomicUsize::new(0),
        start: AtomicUsize::new(0),
        end: AtomicUsize::new(0),
    }
}; SLOTS];

/// The path of a file, null while the slot is free, and its range of memory. The end is 0 while there is none, and is
/// written last, so that the handler sees a whole slot or none.
#[derive(Debug)]
struct Slot {
    path: AtomicPtr<u8>,
    length: AtomicUsize,
    start: AtomicUsize,
    end: AtomicUsize,
}

/// A mapped file, named in the message of [`prepare`] as long as this lives. It must live longer
/// than the map.
#[derive(Debug)]
pub struct Watched {
    slot: Option<&'static Slot>,
    /// The handler reads it through a pointer.
    _path: Box<[u8]>,
}

impl Watched {
    /// Of the file at `path`, mapped at `bytes`.
    pub fn new(bytes: &[u8], path: &Path) -> Watched {
        let path: Box<[u8]> = path.as_os_str().as_encoded_bytes().into();
        let (free, taken) = (null_mut(), path.as_ptr().cast_mut());
        let take = |slot: &&Slot| {
            slot.path
                .compare_exchange(free, taken, Acquire, Relaxed)
                .is_ok()
        };
        let slot = WATCHED.iter().find(take);
        if let Some(slot) = slot {
            let start = bytes.as_ptr().addr();
            slot.length.store(path.len(), Relaxed);
            slot.start.store(start, Relaxed);
            slot.end.store(start + bytes.len(), Release);
        }
        Watched { slot, _path: path }
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        if let Some(slot) = self.slot {
            slot.end.store(0, Release);
            slot.path.store(null_mut(), Release);
        }
    }
}

/// Of no effect here: there are no such signals.
#[cfg(not(unix))]
pub fn prepare(_text: &'static str) {}

#[cfg(unix)]
mod bus_error {
    use std::ffi::{c_int, c_void};
    use std::sync::OnceLock;
    use std::sync::atomic::AtomicBool;
    use std::sync::atomic::Ordering::{AcqRel, Acquire, Relaxed};

    use super::{Slot, WATCHED};

    /// What follows the path in the message.
    static TEXT: OnceLock<&'static str> = OnceLock::new();

    /// The action that ends the process, for faults in other memory.
    static BEFORE: OnceLock<libc::sigaction> = OnceLock::new();

    /// Whether a thread writes the message: several may read what is gone.
    static SAID: AtomicBool = AtomicBool::new(false);

    /// Has the process end with exit code 1 and `error: <path> <text>` on standard error where a
    /// mapped file is shortened by another program or cannot be read from its disk, and has a write
    /// beyond the allowed size of a file (`ulimit -f`) fail with an error. Both signals would end it
    /// without a word. The working files stay; their lock goes with the process.
    pub fn prepare(text: &'static str) {
        // SAFETY: an ignored signal runs no code.
        unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
        if TEXT.set(text).is_err() {
            return;
        }
        // SAFETY: zeros are a valid `sigaction`; the pointers are those of live locals.
        unsafe {
            let (mut before, mut action): (libc::sigaction, libc::sigaction) = std::mem::zeroed();
            let handler: extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void) = on_bus_error;
            action.sa_sigaction = handler as libc::sighandler_t;
            action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            if libc::sigaction(libc::SIGBUS, &action, &mut before) == 0 {
                let _ = BEFORE.set(before);
            }
        }
    }

    /// Calls nothing but what a handler may call.
    extern "C" fn on_bus_error(_: c_int, info: *mut libc::siginfo_t, _: *mut c_void) {
        // SAFETY: the system passes a valid pointer, and this signal has an address.
        let address = unsafe { (*info).si_addr() }.addr();
        let is_in =
            |slot: &&Slot| address < slot.end.load(Acquire) && address >= slot.start.load(Relaxed);
        if let Some(slot) = WATCHED.iter().find(is_in) {
            if SAID.swap(true, AcqRel) {
                // The thread that writes ends this one, too.
                loop {
                    // SAFETY: a handler may call it.
                    unsafe { libc::pause() };
                }
            }
            let path = slot.path.load(Relaxed);
            let length = slot.length.load(Relaxed);
            let text = TEXT.get().copied().unwrap_or_default();
            // SAFETY: the memory of the file is being read, so its `Watched` lives, and with it the
            // path. `write` and `_exit` are safe in a handler; nothing can be done where even a write fails.
            unsafe {
                let path = std::slice::from_raw_parts(path, length);
                let parts: [&[u8]; 4] = [b"error: ", path, b" ", text.as_bytes()];
                for part in parts {
                    libc::write(2, part.as_ptr().cast(), part.len());
                }
                libc::_exit(1);
            }
        }
        // SAFETY: as in `prepare`; the access is repeated and meets the former action.
        unsafe {
            match BEFORE.get() {
                Some(before) => libc::sigaction(libc::SIGBUS, before, std::ptr::null_mut()),
                None => libc::_exit(1),
            };
        }
    }
}
