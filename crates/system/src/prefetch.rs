//! Hints to the caches of the processor.
//!
//! Processors foresee long runs, but neither short ones far apart, nor several at once, nor what lies
//! in another page. What is asked for goes to the second cache, which was quicker than the first: it
//! has room for more requests on their way.

/// Bytes of a cache line.
pub const LINE: usize = 64;

/// Asks for the cache line of `sample`, which will be wanted soon.
#[inline(always)]
pub fn prefetch<S>(sample: &S) {
    prefetch_after(sample, 0);
}

/// Asks for the cache line so many `S` after `sample`, which may be no memory at all.
#[inline(always)]
pub fn prefetch_after<S>(sample: &S, further: usize) {
    let line = std::ptr::from_ref(sample).wrapping_add(further);
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T1, _mm_prefetch};
        // SAFETY: prefetching has no effect but on the caches, wherever it points to.
        unsafe { _mm_prefetch::<_MM_HINT_T1>(line.cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = line;
}
