//! Memory that the system refuses: the program ends with a sentence and exit code 1, where the
//! standard library would abort it. Large memory is asked for in huge pages.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;

use wavecascade_system::memory::{ask_for_huge_pages, may_fail};

#[global_allocator]
static ALLOCATOR: EndsOnRefusal = EndsOnRefusal;

/// The system's allocator; a refusal ends the program, unless the caller takes it as an error.
struct EndsOnRefusal;

// SAFETY: every call is passed to the system's allocator unchanged, and what it returns is returned.
unsafe impl GlobalAlloc for EndsOnRefusal {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's, as for the functions below.
        granted(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        granted(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        granted(unsafe { System.realloc(pointer, layout, size) }, size)
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

fn granted(pointer: *mut u8, size: usize) -> *mut u8 {
    if pointer.is_null() && !may_fail() {
        refused(size);
    }
    // SAFETY: the allocator's, of this size.
    unsafe { ask_for_huge_pages(pointer, size) };
    pointer
}

/// Says so without allocating anything.
#[cold]
fn refused(size: usize) -> ! {
    let mut text = [0u8; 320];
    let mut left = &mut text[..];
    let _ = write!(
        left,
        "error: expected {size} bytes more of memory, found that the system refuses them\n\
         help: lower `--memory`, choose fewer sites, times or samples, use `--threads 1`, or raise the \
         limit (`ulimit -v`, that of the container)\n"
    );
    let unused = left.len();
    let written = text.len() - unused;
    let _ = std::io::stderr().write_all(&text[..written]);
    std::process::exit(1)
}
