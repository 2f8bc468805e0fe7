//! The passes, compiled once for each instruction set, and dispatch among them.
//!
//! A kernel is one function with the features of its instruction set switched on, into which all
//! of [`super::passes`] and [`super::simd`] is inlined. Kernels are called through pointers, which
//! are taken only after the features were detected: that makes the calls sound.

use std::any::{Any, TypeId};

use super::butterfly::{Butterfly, Dft};
use super::passes::{self, Last, Prefetch, Rows, Split, Stage, Twiddled};
use super::simd::{Lanes, Portable, Single};
use crate::Real;

/// Radices that kernels exist for, in the order of the tables.
pub const RADICES: [usize; 6] = [2, 3, 4, 5, 7, 8];

/// `rows, prefetch, to, count, twiddles` of [`passes::first`].
type First<T> = unsafe fn(&Rows<T>, &mut Prefetch<T>, *mut T, usize, *const T);
/// `from, to, blocks, count, twiddles, prefetch` of [`passes::middle`].
type Middle<T> = unsafe fn(*const T, *mut T, usize, usize, *const T, &mut Prefetch<T>);
/// Of [`passes::split`].
type Splitting<T> = unsafe fn(&Split<T>, Prefetch<T>);
/// Of passes whose places have names.
type End<A> = unsafe fn(&A);

/// `from, next, factors, factors_apart, valid, count, to` of [`passes::chirp`].
type ChirpKernel<T> = unsafe fn(*const T, usize, *const T, usize, usize, usize, *mut T);
/// `from, next, count, to` of [`passes::collect`].
type Collect<T> = unsafe fn(*const T, usize, usize, *mut T);

/// All passes for one kind of register.
#[derive(Debug)]
pub struct Kernels<T: 'static> {
    /// Columns of a tile.
    pub width: usize,
    pub stage: End<Stage<T>>,
    pub stage_windowed: End<Stage<T>>,
    /// Rows to scratch as they are, or times the window.
    pub gather: First<T>,
    pub gather_windowed: First<T>,
    pub first: [First<T>; RADICES.len()],
    pub first_windowed: [First<T>; RADICES.len()],
    pub middle: [Middle<T>; RADICES.len()],
    /// With prefetches of the rows of the next pair of series.
    pub middle_prefetching: [Middle<T>; RADICES.len()],
    pub split: [Splitting<T>; RADICES.len()],
    pub last: [End<Last<T>>; RADICES.len()],
    /// With prefetches of the rows of the result that come next.
    pub last_prefetching: [End<Last<T>>; RADICES.len()],
    /// With streaming stores, to aligned rows.
    pub last_streaming: [End<Last<T>>; RADICES.len()],
    pub chirp: ChirpKernel<T>,
    pub collect: Collect<T>,
    pub twiddle: [End<Twiddled<T>>; RADICES.len()],
    pub twiddle_conjugated: [End<Twiddled<T>>; RADICES.len()],
    /// Conjugated, to rows of a spectrum.
    pub twiddle_interleaved: [End<Twiddled<T>>; RADICES.len()],
    pub order: [End<Twiddled<T>>; RADICES.len()],
}

macro_rules! kernels {
    ($module:ident, $lanes:ty, $scalar:ty $(, $feature:literal)?) => {
        pub mod $module {
            use super::*;

            $(#[target_feature(enable = $feature)])?
            unsafe fn stage<const WINDOWED: bool>(at: &Stage<$scalar>) {
                // SAFETY: the caller's.
                unsafe { passes::stage::<$lanes, WINDOWED>(at) }
            }

            $(#[target_feature(enable = $feature)])?
            unsafe fn first<const R: usize, const WINDOWED: bool>(
                rows: &Rows<$scalar>,
                prefetch: &mut Prefetch<$scalar>,
                to: *mut $scalar,
                count: usize,
                twiddles: *const $scalar,
            ) where
                Dft: Butterfly<R>,
            {
                // SAFETY: the caller's.
                unsafe { passes::first::<$lanes, R, WINDOWED>(rows, prefetch, to, count, twiddles) }
            }

            $(#[target_feature(enable = $feature)])?
            unsafe fn middle<const R: usize, const PREFETCH: bool>(
                from: *const $scalar,
                to: *mut $scalar,
                blocks: usize,
                count: usize,
                twiddles: *const $scalar,
                prefetch: &mut Prefetch<$scalar>,
            ) where
                Dft: Butterfly<R>,
            {
                // SAFETY: the caller's.
                unsafe { passes::middle::<$lanes, R, PREFETCH>(from, to, blocks, count, twiddles, prefetch) }
            }

            $(#[target_feature(enable = $feature)])?
            unsafe fn split<const R: usize>(at: &Split<$scalar>, prefetch: Prefetch<$scalar>)
            where
                Dft: Butterfly<R>,
            {
                // SAFETY: the caller's.
                unsafe { passes::split::<$lanes, R>(at, prefetch) }
            }

            $(#[target_feature(enable = $feature)])?
            unsafe fn last<const R: usize, const STREAM: bool, const PREFETCH: bool>(at: &Last<$scalar>)
            where
                Dft: Butterfly<R>,
            {
                // SAFETY: the caller's.
                unsafe { passes::last::<$lanes, R, STREAM, PREFETCH>(at) }
            }

            $(#[target_feature(enable = $feature)])?
            unsafe fn chirp(
                from: *const $scalar,
                next: usize,
                factors: *const $scalar,
                factors_apart: usize,
                valid: usize,
                count: usize,
                to: *mut $scalar,
            ) {
                // SAFETY: the caller's.
                unsafe {
                    passes::chirp::<$lanes>(from, next, factors, factors_apart, valid, count, to)
                }
            }

            $(#[target_feature(enable = $feature)])?
            unsafe fn collect(
                from: *const $scalar,
                next: usize,
                count: usize,
                to: *mut $scalar,
            ) {
                // SAFETY: the caller's.
                unsafe { passes::collect::<$lanes>(from, next, count, to) }
            }

            $(#[target_feature(enable = $feature)])?
            unsafe fn twiddle<const R: usize, const CONJUGATE: bool, const INTERLEAVE: bool>(
                at: &Twiddled<$scalar>,
            ) where
                Dft: Butterfly<R>,
            {
                // SAFETY: the caller's.
                unsafe { passes::twiddle::<$lanes, R, CONJUGATE, INTERLEAVE>(at) }
            }

            $(#[target_feature(enable = $feature)])?
            unsafe fn order<const R: usize>(at: &Twiddled<$scalar>)
            where
                Dft: Butterfly<R>,
            {
                // SAFETY: the caller's.
                unsafe { passes::order::<$lanes, R>(at) }
            }

            pub(in crate::columns) static KERNELS: Kernels<$scalar> = Kernels {
                width: <$lanes as Lanes>::WIDTH,
                stage: stage::<false>,
                stage_windowed: stage::<true>,
                gather: first::<1, false>,
                gather_windowed: first::<1, true>,
                first: [
                    first::<2, false>, first::<3, false>, first::<4, false>,
                    first::<5, false>, first::<7, false>, first::<8, false>,
                ],
                first_windowed: [
                    first::<2, true>, first::<3, true>, first::<4, true>,
                    first::<5, true>, first::<7, true>, first::<8, true>,
                ],
                middle: [
                    middle::<2, false>, middle::<3, false>, middle::<4, false>,
                    middle::<5, false>, middle::<7, false>, middle::<8, false>,
                ],
                middle_prefetching: [
                    middle::<2, true>, middle::<3, true>, middle::<4, true>,
                    middle::<5, true>, middle::<7, true>, middle::<8, true>,
                ],
                split: [split::<2>, split::<3>, split::<4>, split::<5>, split::<7>, split::<8>],
                last: [
                    last::<2, false, false>, last::<3, false, false>, last::<4, false, false>,
                    last::<5, false, false>, last::<7, false, false>, last::<8, false, false>,
                ],
                last_prefetching: [
                    last::<2, false, true>, last::<3, false, true>, last::<4, false, true>,
                    last::<5, false, true>, last::<7, false, true>, last::<8, false, true>,
                ],
                last_streaming: [
                    last::<2, true, false>, last::<3, true, false>, last::<4, true, false>,
                    last::<5, true, false>, last::<7, true, false>, last::<8, true, false>,
                ],
                chirp,
                collect,
                twiddle: [
                    twiddle::<2, false, false>, twiddle::<3, false, false>, twiddle::<4, false, false>,
                    twiddle::<5, false, false>, twiddle::<7, false, false>, twiddle::<8, false, false>,
                ],
                twiddle_conjugated: [
                    twiddle::<2, true, false>, twiddle::<3, true, false>, twiddle::<4, true, false>,
                    twiddle::<5, true, false>, twiddle::<7, true, false>, twiddle::<8, true, false>,
                ],
                twiddle_interleaved: [
                    twiddle::<2, true, true>, twiddle::<3, true, true>, twiddle::<4, true, true>,
                    twiddle::<5, true, true>, twiddle::<7, true, true>, twiddle::<8, true, true>,
                ],
                order: [order::<2>, order::<3>, order::<4>, order::<5>, order::<7>, order::<8>],
            };
        }
    };
}

kernels!(portable_f64, Portable<f64, 4>, f64);
kernels!(portable_f32, Portable<f32, 8>, f32);
kernels!(portable_single_f64, Single<f64, false>, f64);
kernels!(portable_single_f32, Single<f32, false>, f32);
#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::super::simd::{X256f32, X256f64, X512f32, X512f64};
    use super::*;

    kernels!(avx2_f64, X256f64, f64, "avx2,fma");
    kernels!(avx2_f32, X256f32, f32, "avx2,fma");
    kernels!(avx512_f64, X512f64, f64, "avx512f,avx2,fma");
    kernels!(avx512_f32, X512f32, f32, "avx512f,avx2,fma");
    // The narrower registers again, of which there are twice as many with AVX-512.
    kernels!(avx512vl_f64, X256f64, f64, "avx512f,avx512vl,avx2,fma");
    kernels!(avx512vl_f32, X256f32, f32, "avx512f,avx512vl,avx2,fma");
    kernels!(single_f64, Single<f64, true>, f64, "avx2,fma");
    kernels!(single_f32, Single<f32, true>, f32, "avx2,fma");
}
#[cfg(target_arch = "aarch64")]
mod neon {
    use super::super::simd::{Neon32, Neon64};
    use super::*;

    kernels!(neon_f64, Neon64, f64, "neon");
    kernels!(neon_f32, Neon32, f32, "neon");
    kernels!(single_f64, Single<f64, true>, f64, "neon");
    kernels!(single_f32, Single<f32, true>, f32, "neon");
}

/// Instructions that kernels are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InstructionSet {
    /// Whatever the build targets.
    Portable,
    /// Four `f64` or eight `f32`, with fused multiply-add.
    Avx2,
    /// Eight `f64` or sixteen `f32`, with fused multiply-add.
    Avx512,
    /// Two `f64` or four `f32`, with fused multiply-add.
    Neon,
}

impl InstructionSet {
    /// Those that this processor has, the fastest first.
    pub fn available() -> Vec<InstructionSet> {
        let mut found = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            let fma = std::arch::is_x86_feature_detected!("avx2")
                && std::arch::is_x86_feature_detected!("fma");
            let wide = std::arch::is_x86_feature_detected!("avx512f")
                && std::arch::is_x86_feature_detected!("avx512vl");
            if fma && wide {
                found.push(InstructionSet::Avx512);
            }
            if fma {
                found.push(InstructionSet::Avx2);
            }
        }
        #[cfg(target_arch = "aarch64")]
        if std::arch::is_aarch64_feature_detected!("neon") {
            found.push(InstructionSet::Neon);
        }
        found.push(InstructionSet::Portable);
        found
    }

    /// The fastest there is.
    pub fn best() -> InstructionSet {
        Self::available()[0]
    }

    /// Whether this processor has it.
    pub fn is_available(self) -> bool {
        Self::available().contains(&self)
    }
}

/// The kernels of an instruction set, the widest first; none where the processor lacks it.
pub fn kernels<T: Real>(set: InstructionSet) -> Vec<&'static Kernels<T>> {
    if !set.is_available() {
        return Vec::new();
    }
    let of_type: Box<dyn Any> = match TypeId::of::<T>() == TypeId::of::<f64>() {
        true => Box::new(kernels_f64(set)),
        false => Box::new(kernels_f32(set)),
    };
    // The trait is sealed: T is f64 or f32.
    *of_type.downcast().expect("kernels of f64 or f32")
}

macro_rules! dispatch {
    ($name:ident, $scalar:ty, $portable:ident, $portable_single:ident, $avx2:ident, $avx512:ident,
     $avx512vl:ident, $single:ident, $neon:ident) => {
        fn $name(set: InstructionSet) -> Vec<&'static Kernels<$scalar>> {
            match set {
                InstructionSet::Portable => vec![&$portable::KERNELS, &$portable_single::KERNELS],
                #[cfg(target_arch = "x86_64")]
                InstructionSet::Avx512 => vec![
                    &x86::$avx512::KERNELS,
                    &x86::$avx512vl::KERNELS,
                    &x86::$single::KERNELS,
                ],
                #[cfg(target_arch = "x86_64")]
                InstructionSet::Avx2 => vec![&x86::$avx2::KERNELS, &x86::$single::KERNELS],
                #[cfg(target_arch = "aarch64")]
                InstructionSet::Neon => vec![&neon::$neon::KERNELS, &neon::$single::KERNELS],
                #[allow(unreachable_patterns)]
                _ => Vec::new(),
            }
        }
    };
}
dispatch!(
    kernels_f64,
    f64,
    portable_f64,
    portable_single_f64,
    avx2_f64,
    avx512_f64,
    avx512vl_f64,
    single_f64,
    neon_f64
);
dispatch!(
    kernels_f32,
    f32,
    portable_f32,
    portable_single_f32,
    avx2_f32,
    avx512_f32,
    avx512vl_f32,
    single_f32,
    neon_f32
);
