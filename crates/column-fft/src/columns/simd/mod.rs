//! Registers of numbers, one column in each lane.
//!
//! Everything here is `#[inline(always)]`, so that it becomes part of the kernel that it is called
//! from, which has the processor's features switched on; see [`super::kernels`].

#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;
mod single;
#[cfg(target_arch = "x86_64")]
mod x86;

#[cfg(target_arch = "aarch64")]
pub(super) use neon::{Neon32, Neon64};
pub(super) use portable::Portable;
pub(super) use single::Single;
#[cfg(target_arch = "x86_64")]
pub(super) use x86::{X256f32, X256f64, X512f32, X512f64};

/// A register of numbers, the same operation on each.
///
/// # Safety
/// Every function needs a processor that has the type's instructions. Pointers must be valid for
/// [`Lanes::WIDTH`] numbers ([`Lanes::store_interleaved`]: twice as many) and need no alignment unless
/// said.
pub(super) trait Lanes: Copy {
    type Scalar: Copy;
    const WIDTH: usize;

    unsafe fn load(from: *const Self::Scalar) -> Self;
    unsafe fn store(self, to: *mut Self::Scalar);
    /// One number in every lane.
    unsafe fn splat(from: *const Self::Scalar) -> Self;
    unsafe fn of(value: f64) -> Self;
    unsafe fn add(self, other: Self) -> Self;
    unsafe fn sub(self, other: Self) -> Self;
    unsafe fn mul(self, other: Self) -> Self;
    /// `self * factor + term`.
    unsafe fn mul_add(self, factor: Self, term: Self) -> Self;
    /// `self * factor - term`.
    unsafe fn mul_sub(self, factor: Self, term: Self) -> Self;
    /// `term - self * factor`.
    unsafe fn neg_mul_add(self, factor: Self, term: Self) -> Self;
    /// `re, im, re, im, ..`; where `STREAM`, by streaming stores, and `to` is aligned to 64 bytes.
    unsafe fn store_interleaved<const STREAM: bool>(re: Self, im: Self, to: *mut Self::Scalar);
    /// Prefetches the cache line at `at`, which need not be valid.
    unsafe fn prefetch(at: *const Self::Scalar);
}

/// Orders streaming stores before what follows, as other threads see it.
#[inline]
pub(super) fn finish_streams() {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: every x86-64 has this instruction.
    unsafe {
        std::arch::x86_64::_mm_sfence();
    }
}
