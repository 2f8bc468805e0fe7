//! Vectors of eight numbers in the widest registers that the processor has.
//!
//! Every operation rounds each lane like a scalar, and products are fused with sums in [`Lanes::fused`] alone,
//! so all others give the same bits with all instruction sets.

use std::ops::{Add, Div, Mul, Sub};

use fearless_simd::{Fallback, Level, Simd, SimdBase, f64x8};
use num_complex::Complex;

/// Lanes of a block.
pub(crate) const WIDTH: usize = 8;

/// A block of numbers on a cache line of its own.
#[derive(Debug, Clone, Copy, Default, PartialEq, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C, align(64))]
pub(crate) struct LaneBlock(pub(crate) [f64; WIDTH]);

/// Numbers in whole blocks.
#[derive(Debug, Clone, Default)]
pub(crate) struct AlignedRow(pub(crate) Vec<LaneBlock>);

impl AlignedRow {
    /// At least this many zeros.
    pub(crate) fn zeros(length: usize) -> AlignedRow {
        AlignedRow(vec![LaneBlock::default(); length.div_ceil(WIDTH)])
    }
}

impl std::ops::Deref for AlignedRow {
    type Target = [f64];

    #[inline(always)]
    fn deref(&self) -> &[f64] {
        bytemuck::cast_slice(&self.0)
    }
}

impl std::ops::DerefMut for AlignedRow {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f64] {
        bytemuck::cast_slice_mut(&mut self.0)
    }
}

/// The first `length` numbers of `room` that start on a cache line, whatever they hold.
pub(crate) fn on_lines<T: Copy + Default>(room: &mut Vec<T>, length: usize) -> &mut [T] {
    let spare = align_of::<LaneBlock>() / size_of::<T>();
    if room.len() < length + spare {
        room.resize(length + spare, T::default());
    }
    let first = room
        .as_ptr()
        .align_offset(align_of::<LaneBlock>())
        .min(spare);
    &mut room[first..first + length]
}

/// One number, or several that undergo the same.
pub(crate) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    fn splat(value: f64) -> Self;

    fn sqrt(self) -> Self;

    /// `yes` where this is above 0, else `no`.
    fn choose(self, yes: Self, no: Self) -> Self;

    /// By a function of single numbers and the place of each, of which the first is `at`.
    fn at_each(self, at: usize, b: Self, c: Self, f: impl Fn(usize, f64, f64, f64) -> f64) -> Self;

    /// By a function of single numbers.
    #[inline(always)]
    fn map3(self, b: Self, c: Self, f: impl Fn(f64, f64, f64) -> f64) -> Self {
        self.at_each(0, b, c, |_, a, b, c| f(a, b, c))
    }

    /// Itself where above 0, else 0.
    #[inline(always)]
    fn positive(self) -> Self {
        self.choose(self, Self::splat(0.0))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.choose(self, Self::splat(0.0) - self)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        (self - other).choose(other, self)
    }
}

/// A block in registers.
pub(crate) trait Lanes: Number {
    fn read(from: &[f64; WIDTH]) -> Self;

    fn write(self, to: &mut [f64; WIDTH]);

    #[inline(always)]
    fn numbers(self) -> [f64; WIDTH] {
        let mut numbers = [0.0; WIDTH];
        self.write(&mut numbers);
        numbers
    }

    #[inline(always)]
    fn load(block: &LaneBlock) -> Self {
        Self::read(&block.0)
    }

    #[inline(always)]
    fn store(self, block: &mut LaneBlock) {
        self.write(&mut block.0);
    }

    /// Itself where less than `old`, else `old`; `old` also where this is NaN.
    fn least(self, old: Self) -> Self;

    /// Itself where larger than `old`, else `old`; `old` also where this is NaN.
    fn largest(self, old: Self) -> Self;

    /// Itself where equal to `other`, else `no`.
    fn where_equal(self, other: Self, no: Self) -> Self;

    /// Each lane from the one before it, the first from the last of `before`.
    fn take_left(self, before: Self) -> Self;

    /// Each lane from the one after it, the last from the first of `after`.
    fn take_right(self, after: Self) -> Self;

    /// A bit for each lane, the first lowest: whether it is above 0.
    fn positive_mask(self) -> u8;

    /// Real and imaginary parts of complex numbers.
    fn parts(from: &[Complex<f64>; WIDTH]) -> [Self; 2];

    /// `self * factor + term`, rounded once where the processor has an instruction for it: the only operation
    /// whose bits depend on the instruction set. For sums over transforms, whose bits do so, too.
    fn fused(self, factor: Self, term: Self) -> Self;

    /// The sum of all lanes.
    #[inline(always)]
    fn sum(self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.numbers();
        ((a + e) + (b + f)) + ((c + g) + (d + h))
    }
}

/// Work that is compiled once for each instruction set, with explicit lanes or with loops that the
/// compiler vectorizes.
pub(crate) trait SimdKernel {
    type Output;

    /// To be marked `#[inline(always)]`, with all that it calls on lanes.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Does the work with the widest registers there are.
#[inline]
pub(crate) fn widest<W: SimdKernel>(work: W) -> W::Output {
    let level = Level::new();
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(found) = level.as_avx512() {
            return with(found, work);
        }
        if let Some(found) = level.as_avx2() {
            return with(found, work);
        }
    }
    #[cfg(target_arch = "aarch64")]
    if let Some(found) = level.as_neon() {
        return with(found, work);
    }
    let _ = level;
    with(Fallback::new(), work)
}

#[inline(always)]
fn with<S: Simd, W: SimdKernel>(found: S, work: W) -> W::Output {
    found.vectorize(
        #[inline(always)]
        || work.run::<f64x8<S>>(),
    )
}

/// Says that the processor has the instructions of S.
#[inline(always)]
fn found<S: Simd>() -> S {
    const { assert!(size_of::<S>() == 0) };
    // SAFETY: of a type without size all is zero; lanes of S arise in [`widest`] alone, which has found the instructions.
    unsafe { std::mem::zeroed() }
}

impl Number for f64 {
    #[inline(always)]
    fn splat(value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn choose(self, yes: f64, no: f64) -> f64 {
        if self > 0.0 { yes } else { no }
    }

    #[inline(always)]
    fn at_each(self, at: usize, b: f64, c: f64, f: impl Fn(usize, f64, f64, f64) -> f64) -> f64 {
        f(at, self, b, c)
    }
}

/// Lanes for any processor.
pub(crate) type Portable = f64x8<Fallback>;

impl<S: Simd> Number for f64x8<S> {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        found::<S>().splat_f64x8(value)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.simd.sqrt_f64x8(self)
    }

    #[inline(always)]
    fn choose(self, yes: Self, no: Self) -> Self {
        let above = self.simd.simd_gt_f64x8(self, Number::splat(0.0));
        self.simd.select_f64x8(above, yes, no)
    }

    #[inline(always)]
    fn at_each(self, at: usize, b: Self, c: Self, f: impl Fn(usize, f64, f64, f64) -> f64) -> Self {
        let [x, y, z] = [self, b, c].map(<[f64; WIDTH]>::from);
        Self::load_array(
            self.simd,
            std::array::from_fn(|l| f(at + l, x[l], y[l], z[l])),
        )
    }
}

impl<S: Simd> Lanes for f64x8<S> {
    #[inline(always)]
    fn read(from: &[f64; WIDTH]) -> Self {
        Self::load_array_ref(found(), from)
    }

    #[inline(always)]
    fn write(self, to: &mut [f64; WIDTH]) {
        self.store_array(to);
    }

    #[inline(always)]
    fn least(self, old: Self) -> Self {
        let below = self.simd.simd_lt_f64x8(self, old);
        self.simd.select_f64x8(below, self, old)
    }

    #[inline(always)]
    fn largest(self, old: Self) -> Self {
        let above = self.simd.simd_gt_f64x8(self, old);
        self.simd.select_f64x8(above, self, old)
    }

    #[inline(always)]
    fn where_equal(self, other: Self, no: Self) -> Self {
        let equal = self.simd.simd_eq_f64x8(self, other);
        self.simd.select_f64x8(equal, self, no)
    }

    #[inline(always)]
    fn take_left(self, before: Self) -> Self {
        self.simd.slide_f64x8::<{ WIDTH - 1 }>(before, self)
    }

    #[inline(always)]
    fn take_right(self, after: Self) -> Self {
        self.simd.slide_f64x8::<1>(self, after)
    }

    #[inline(always)]
    fn positive_mask(self) -> u8 {
        let above = self.simd.simd_gt_f64x8(self, Number::splat(0.0));
        self.simd.to_bitmask_mask64x8(above) as u8
    }

    #[inline(always)]
    fn parts(from: &[Complex<f64>; WIDTH]) -> [Self; 2] {
        let numbers: &[[f64; WIDTH]; 2] = bytemuck::cast_ref(from);
        let [low, high] = numbers.each_ref().map(Self::read);
        low.simd.deinterleave_f64x8(low, high).into()
    }

    #[inline(always)]
    fn fused(self, factor: Self, term: Self) -> Self {
        self.simd.mul_add_f64x8(self, factor, term)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bits of every operation on some awkward numbers.
    struct Sample;

    impl SimdKernel for Sample {
        type Output = Vec<u64>;

        #[inline(always)]
        fn run<L: Lanes>(self) -> Vec<u64> {
            let blocks = [
                LaneBlock([1.5, -2.0, 0.0, -0.0, 1e300, 3e-310, 7.25, -1e-3]),
                LaneBlock([0.3, 4.0, -1.0, 2.0, 1e-300, 9.0, -7.25, 1e5]),
            ];
            let [a, b] = [L::load(&blocks[0]), L::read(&blocks[1].0)];
            let nan = L::splat(f64::NAN);
            let [re, im] = L::parts(&std::array::from_fn(|l| {
                Complex::new(blocks[0].0[l], blocks[1].0[l])
            }));
            let results = [
                re,
                im,
                (a + b) / (a - b) * b,
                a.abs().sqrt(),
                a.positive(),
                a.choose(b, a),
                a.min(b),
                a.take_left(b),
                a.take_right(b),
                a.least(b),
                b.least(a * b),
                a.largest(b),
                (nan - a).largest(b),
                (nan - a).least(b),
                a.where_equal(b, a * b),
                a.where_equal(a.abs(), b),
                a.map3(b, a, |a, b, c| a.mul_add(b, c)),
            ];
            let mut bits = vec![u64::from(a.positive_mask()), u64::from(b.positive_mask())];
            bits.extend(
                results
                    .iter()
                    .flat_map(|lanes| lanes.numbers().map(f64::to_bits)),
            );
            bits
        }
    }

    #[test]
    fn val_portable_lanes_equal_registers_bit_by_bit() {
        let portable = Sample.run::<Portable>();
        assert_eq!(widest(Sample), portable);
        #[cfg(target_arch = "x86_64")]
        if let Some(found) = Level::new().as_avx2() {
            assert_eq!(with(found, Sample), portable);
        }
    }
}
