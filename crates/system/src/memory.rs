//! Available memory, memory in huge pages, and sizes as text.

use std::cell::Cell;
use std::collections::TryReserveError;
use std::io::Result;

use memmap2::MmapMut;

use crate::limits::free;

/// Bytes of memory available now, within the limits of a container and of the process (`ulimit`);
/// `u64::MAX` where the system does not report it.
pub fn available_memory() -> u64 {
    free("/".as_ref()).unwrap_or(u64::MAX)
}

/// Half of [`available_memory`]; 2 GiB where the system does not report it.
pub fn half_of_free_memory() -> u64 {
    free("/".as_ref()).map_or(2 << 30, |free| free / 2)
}

/// Zeroed memory in huge pages, where the system has them.
///
/// # Errors
/// The system's, where it gives no memory.
pub fn huge_pages(bytes: usize) -> Result<MmapMut> {
    let pages = MmapMut::map_anon(bytes)?;
    // Small pages do as well where the system refuses.
    #[cfg(target_os = "linux")]
    let _refused = pages.advise(memmap2::Advice::HugePage);
    Ok(pages)
}

/// Bytes from which fresh memory is asked for in huge pages, which are made 512 times as seldom: that of a small page takes as long
/// as writing it.
const LARGE: usize = 4 << 20;

/// Asks for huge pages within fresh memory, where it is large and the system has them.
///
/// # Safety
/// Null, or memory of so many bytes.
pub unsafe fn ask_for_huge_pages(memory: *mut u8, bytes: usize) {
    #[cfg(target_os = "linux")]
    if bytes >= LARGE && !memory.is_null() {
        const HUGE: usize = 2 << 20;
        let skipped = memory.align_offset(HUGE).min(bytes);
        let whole = (bytes - skipped) / HUGE * HUGE;
        // SAFETY: the range lies within the caller's memory; advice changes nothing that is stored there. Small pages do as
        // well where the system refuses.
        let _refused =
            unsafe { libc::madvise(memory.add(skipped).cast(), whole, libc::MADV_HUGEPAGE) };
    }
    #[cfg(not(target_os = "linux"))]
    let _ = (memory, bytes, LARGE);
}

thread_local! {
    static MAY_FAIL: Cell<bool> = const { Cell::new(false) };
}

/// `count` values, each `value`.
///
/// # Errors
/// What the allocator refused.
pub fn try_filled<T: Clone>(
    count: usize,
    value: T,
) -> std::result::Result<Vec<T>, TryReserveError> {
    let mut values = try_with_capacity(count)?;
    values.resize(count, value);
    Ok(values)
}

/// An empty vector with space for `count` values.
///
/// # Errors
/// What the allocator refused.
pub fn try_with_capacity<T>(count: usize) -> std::result::Result<Vec<T>, TryReserveError> {
    let mut values = Vec::new();
    MAY_FAIL.set(true);
    let reserved = values.try_reserve_exact(count);
    MAY_FAIL.set(false);
    reserved.map(|()| values)
}

/// Whether the caller of the allocator, on this thread, takes a refusal as an error of its own. A
/// program's allocator that ends the program on a refusal asks this first.
pub fn may_fail() -> bool {
    MAY_FAIL.get()
}

/// Has memory of 4 MiB and more go back to the system as soon as it is freed; the allocator of glibc keeps up to 64 MiB otherwise.
pub fn return_large_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: sets a parameter of the allocator.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, 4 << 20);
    }
}

/// Bytes in a binary unit, rounded up, so that the printed limit suffices.
pub fn size(bytes: u64) -> String {
    const UNITS: [&str; 5] = ["bytes", "KiB", "MiB", "GiB", "TiB"];
    let power = (bytes.max(1).ilog2() / 10).min(4);
    let value = bytes as f64 / 1024f64.powi(power as i32);
    match UNITS.get(power as usize) {
        Some(unit) if power > 0 => format!("{:.2} {unit}", (value * 100.0).ceil() / 100.0),
        _ => format!("{bytes} bytes"),
    }
}
