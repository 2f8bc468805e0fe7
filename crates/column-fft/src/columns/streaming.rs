//! Copies by streaming (non-temporal) stores.

use bytemuck::Pod;

use super::LINE;

/// Copies each piece by streaming stores, where the processor has them: the target is neither read nor kept in
/// the caches.
///
/// # Panics
/// If the lengths of a piece and its place differ.
pub(crate) fn copy_streaming<'a, T: Pod>(pieces: impl Iterator<Item = (&'a [T], &'a mut [T])>) {
    for (from, to) in pieces {
        copy_piece(bytemuck::cast_slice(from), bytemuck::cast_slice_mut(to));
    }
    super::simd::finish_streams();
}

fn copy_piece(from: &[u8], to: &mut [u8]) {
    assert_eq!(from.len(), to.len());
    // Lines that are shared with others are written as usual.
    let head = to.as_ptr().align_offset(LINE).min(to.len());
    let (head_from, from) = from.split_at(head);
    let (head_to, to) = to.split_at_mut(head);
    head_to.copy_from_slice(head_from);
    let (lines_from, tail_from) = from.as_chunks();
    let (lines_to, tail_to) = to.as_chunks_mut();
    for (from, to) in lines_from.iter().zip(lines_to) {
        // SAFETY: the head ends where a line starts.
        unsafe { copy_line(from, to) };
    }
    tail_to.copy_from_slice(tail_from);
}

/// One whole line.
///
/// # Safety
/// `to` must be aligned to a line.
#[inline(always)]
unsafe fn copy_line(from: &[u8; LINE], to: &mut [u8; LINE]) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{__m128i, _mm_loadu_si128, _mm_stream_si128};
        let from: *const __m128i = from.as_ptr().cast();
        let to: *mut __m128i = to.as_mut_ptr().cast();
        for quarter in 0..4 {
            // SAFETY: every x86-64 has these instructions; a line has four such parts, and that of `to`
            // starts at one.
            unsafe { _mm_stream_si128(to.add(quarter), _mm_loadu_si128(from.add(quarter))) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    to.copy_from_slice(from);
}
