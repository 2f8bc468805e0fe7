//! Signals that would end the program without a word.

#[cfg(unix)]
pub use unix::{Watched, prepare, remember_stop, stopped_by};

#[cfg(not(unix))]
pub use other::{Watched, prepare, remember_stop, stopped_by};

#[cfg(unix)]
mod unix {
    use std::ffi::{c_int, c_void};
    use std::os::unix::ffi::OsStrExt;
    use std::path::Path;
    use std::sync::OnceLock;
    use std::sync::atomic::{AtomicBool, AtomicI32, AtomicPtr, AtomicUsize, Ordering};

    /// Files that are mapped at a time and named in the message; of more it is silent.
    const SLOTS: usize = 64;

    static WATCHED: [Slot; SLOTS] = [const { Slot::empty() }; SLOTS];

    /// What follows the path in the message.
    static TEXT: OnceLock<&'static str> = OnceLock::new();

    /// The action that ends the process, for faults in other memory.
    static BEFORE: OnceLock<libc::sigaction> = OnceLock::new();

    /// Whether a thread writes the message: several may read what is gone.
    static SAID: AtomicBool = AtomicBool::new(false);

    /// A range of memory and the path of its file. The end is 0 while there is none, and is written
    /// last, so that the handler sees a whole slot or none.
    struct Slot {
        is_taken: AtomicBool,
        start: AtomicUsize,
        end: AtomicUsize,
        path: AtomicPtr<u8>,
        length: AtomicUsize,
    }

    impl Slot {
        const fn empty() -> Slot {
            Slot {
                is_taken: AtomicBool::new(false),
                start: AtomicUsize::new(0),
                end: AtomicUsize::new(0),
                path: AtomicPtr::new(std::ptr::null_mut()),
                length: AtomicUsize::new(0),
            }
        }
    }

    /// A mapped file, named in the message of [`prepare`] as long as this lives. It must live longer
    /// than the map.
    #[derive(Debug)]
    pub struct Watched {
        slot: Option<usize>,
        /// The handler reads it through a pointer.
        _path: Box<[u8]>,
    }

    impl Watched {
        /// Of the file at `path`, mapped at `bytes`.
        pub fn new(bytes: &[u8], path: &Path) -> Watched {
            let path: Box<[u8]> = path.as_os_str().as_bytes().into();
            let take = |slot: &&Slot| !slot.is_taken.swap(true, Ordering::Acquire);
            let found = WATCHED.iter().position(|slot| take(&slot));
            if let Some(n) = found {
                let (slot, start) = (&WATCHED[n], bytes.as_ptr().addr());
                slot.start.store(start, Ordering::Relaxed);
                slot.path.store(path.as_ptr().cast_mut(), Ordering::Relaxed);
                slot.length.store(path.len(), Ordering::Relaxed);
                slot.end.store(start + bytes.len(), Ordering::Release);
            }
            Watched {
                slot: found,
                _path: path,
            }
        }
    }

    impl Drop for Watched {
        fn drop(&mut self) {
            if let Some(slot) = self.slot.map(|n| &WATCHED[n]) {
                slot.end.store(0, Ordering::Release);
                slot.is_taken.store(false, Ordering::Release);
            }
        }
    }

    /// Signals that stop a process, beside the interrupt.
    const STOPS: [c_int; 2] = [libc::SIGTERM, libc::SIGHUP];

    /// The last of them that came.
    static STOPPED_BY: AtomicI32 = AtomicI32::new(0);

    /// The handlers that they had.
    static HANDLERS: [AtomicUsize; 2] = [const { AtomicUsize::new(0) }; 2];

    /// Has the handlers that `set` sets for a termination and a hangup be preceded by a note of the signal. One that comes
    /// meanwhile waits.
    pub fn remember_stop(set: impl FnOnce()) {
        // SAFETY: zeros are a valid set; the pointers are those of live locals.
        let before = unsafe {
            let (mut stops, mut before): (libc::sigset_t, libc::sigset_t) = std::mem::zeroed();
            libc::sigemptyset(&mut stops);
            for signal in STOPS {
                libc::sigaddset(&mut stops, signal);
            }
            libc::pthread_sigmask(libc::SIG_BLOCK, &stops, &mut before);
            before
        };
        set();
        note_stops();
        // SAFETY: the pointer is that of a live local.
        unsafe { libc::pthread_sigmask(libc::SIG_SETMASK, &before, std::ptr::null_mut()) };
    }

    fn note_stops() {
        for (signal, former) in STOPS.into_iter().zip(&HANDLERS) {
            // SAFETY: zeros are a valid `sigaction`; the pointers are those of live locals.
            unsafe {
                let mut action: libc::sigaction = std::mem::zeroed();
                let is_known = libc::sigaction(signal, std::ptr::null(), &mut action) == 0;
                let handler: extern "C" fn(c_int) = on_stop;
                let ours = handler as libc::sighandler_t;
                let is_plain = action.sa_flags & libc::SA_SIGINFO == 0;
                let is_none = [libc::SIG_DFL, libc::SIG_IGN, ours].contains(&action.sa_sigaction);
                if is_known && is_plain && !is_none {
                    former.store(action.sa_sigaction, Ordering::Release);
                    action.sa_sigaction = ours;
                    libc::sigaction(signal, &action, std::ptr::null_mut());
                }
            }
        }
    }

    /// The termination or hangup that came, if one did.
    pub fn stopped_by() -> Option<c_int> {
        Some(STOPPED_BY.load(Ordering::Relaxed)).filter(|&signal| signal != 0)
    }

    /// Calls nothing but the former handler.
    extern "C" fn on_stop(signal: c_int) {
        STOPPED_BY.store(signal, Ordering::Relaxed);
        let former = STOPS.iter().position(|&stop| stop == signal);
        let former = former.map_or(0, |n| HANDLERS[n].load(Ordering::Acquire));
        if former != 0 {
            // SAFETY: it was set as a handler of this type before this one was.
            let former: extern "C" fn(c_int) = unsafe { std::mem::transmute(former) };
            former(signal);
        }
    }

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
            let mut before: libc::sigaction = std::mem::zeroed();
            if libc::sigaction(libc::SIGBUS, std::ptr::null(), &mut before) != 0 {
                return;
            }
            let _ = BEFORE.set(before);
            let mut action: libc::sigaction = std::mem::zeroed();
            let handler: extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void) = on_bus_error;
            action.sa_sigaction = handler as libc::sighandler_t;
            action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            libc::sigaction(libc::SIGBUS, &action, std::ptr::null_mut());
        }
    }

    /// Calls nothing but what a handler may call.
    extern "C" fn on_bus_error(_: c_int, info: *mut libc::siginfo_t, _: *mut c_void) {
        // SAFETY: the system passes a valid pointer, and this signal has an address.
        let address = unsafe { (*info).si_addr() }.addr();
        let is_in = |slot: &&Slot| {
            address < slot.end.load(Ordering::Acquire)
                && address >= slot.start.load(Ordering::Relaxed)
        };
        if let Some(slot) = WATCHED.iter().find(is_in) {
            if SAID.swap(true, Ordering::AcqRel) {
                // The thread that writes ends this one, too.
                loop {
                    // SAFETY: a handler may call it.
                    unsafe { libc::pause() };
                }
            }
            let path = slot.path.load(Ordering::Relaxed);
            let length = slot.length.load(Ordering::Relaxed);
            let text = TEXT.get().copied().unwrap_or_default();
            // SAFETY: the memory of the file is being read, so its `Watched` lives, and with it the
            // path. `write` and `_exit` are safe in a handler.
            unsafe {
                say(b"error: ");
                say(std::slice::from_raw_parts(path, length));
                say(b" ");
                say(text.as_bytes());
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

    /// # Safety
    /// None beyond that of `write`, which a handler may call.
    unsafe fn say(text: &[u8]) {
        // Nothing can be done where even this cannot be written.
        let _ = unsafe { libc::write(2, text.as_ptr().cast(), text.len()) };
    }
}

#[cfg(not(unix))]
mod other {
    use std::path::Path;

    /// A mapped file; of no effect here.
    #[derive(Debug)]
    pub struct Watched;

    impl Watched {
        /// Of the file at `path`, mapped at `bytes`.
        pub fn new(_bytes: &[u8], _path: &Path) -> Watched {
            Watched
        }
    }

    /// Of no effect here: there are no such signals.
    pub fn prepare(_text: &'static str) {}

    /// Likewise.
    pub fn remember_stop(set: impl FnOnce()) {
        set();
    }

    /// None here.
    pub fn stopped_by() -> Option<i32> {
        None
    }
}
