//! Software prefetches.
//!
//! Hardware prefetchers follow long streams, but not short ones far apart, nor several at once, nor
//! across a page boundary. These prefetches fill L2, which measured faster than L1: it has more
//! outstanding requests.

/// Bytes of a cache line.
pub const LINE: usize = 64;

/// Prefetches the cache line of `sample`.
#[inline(always)]
pub fn prefetch<S>(sample: &S) {
    prefetch_after(sample, 0);
}

/// Prefetches the cache line that is the given number of `S` after `sample`; it need not be valid
/// memory.
#[inline(always)]
pub fn prefetch_after<S>(sample: &S, further: usize) {
    let line = std::ptr::from_ref(sample).wrapping_add(further);
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T1, _mm_prefetch};
        // SAFETY: a prefetch only affects the caches, and any address is allowed.
        unsafe { _mm_prefetch::<_MM_HINT_T1>(line.cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = line;
}
