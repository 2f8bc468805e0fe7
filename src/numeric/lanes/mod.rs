//! Vectors of eight numbers in the widest registers that the processor has.
//!
//! Every operation rounds each lane like a scalar, and products are fused with sums in [`Lanes::fused`] alone,
//! so all others give the same bits with all instruction sets.

#[cfg(target_arch = "x86_64")]
mod x86;

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

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
    let first = room.as_ptr().align_offset(align_of::<LaneBlock>());
    &mut room[first.min(spare)..][..length]
}

/// One number, or several that undergo the same.
pub(crate) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// How many.
    const COUNT: usize = WIDTH;

    /// The first numbers of these.
    fn read(from: &[f64; WIDTH]) -> Self;

    fn write(self, to: &mut [f64; WIDTH]);

    fn splat(value: f64) -> Self;

    fn sqrt(self) -> Self;

    /// `yes` where this is above 0, else `no`.
    fn choose(self, yes: Self, no: Self) -> Self;

    /// By a function of single numbers and their places.
    #[inline(always)]
    fn at_each(self, b: Self, c: Self, f: impl Fn(usize, f64, f64, f64) -> f64) -> Self {
        let mut parts = [[0.0; WIDTH]; 3];
        for (lanes, part) in [self, b, c].into_iter().zip(&mut parts) {
            lanes.write(part);
        }
        let [mut found, b, c] = parts;
        for l in 0..Self::COUNT {
            found[l] = f(l, found[l], b[l], c[l]);
        }
        Self::read(&found)
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

    /// The lesser of both; itself where the other is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        (self - other).choose(other, self)
    }

    /// The larger of both; itself where the other is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        (other - self).choose(other, self)
    }
}

/// A block in registers.
pub(crate) trait Lanes: Number {
    #[inline(always)]
    fn load(block: &LaneBlock) -> Self {
        Self::read(&block.0)
    }

    #[inline(always)]
    fn store(self, block: &mut LaneBlock) {
        self.write(&mut block.0);
    }

    /// Each lane from the one before it, the first from the last of `before`.
    fn take_left(self, before: Self) -> Self;

    /// Each lane from the one after it, the last from the first of `after`.
    fn take_right(self, after: Self) -> Self;

    /// A bit for each lane, the first lowest: whether it is above 0.
    fn positive_mask(self) -> u8;

    /// `self * factor + term`, rounded once where the processor has an instruction for it: the only operation
    /// whose bits depend on the instruction set. For sums over transforms, whose bits do so, too.
    fn fused(self, factor: Self, term: Self) -> Self;

    /// The sum of all lanes.
    #[inline(always)]
    fn sum(self) -> f64 {
        let mut lanes = [0.0; WIDTH];
        self.write(&mut lanes);
        let [a, b, c, d, e, f, g, h] = lanes;
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
    #[cfg(target_arch = "x86_64")]
    {
        if std::arch::is_x86_feature_detected!("avx512f") {
            // SAFETY: the feature that this needs was found just above.
            return unsafe { x86::with_avx512(work) };
        }
        if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
        {
            // SAFETY: the features that this needs were found just above.
            return unsafe { x86::with_avx2(work) };
        }
    }
    work.run::<LaneBlock>()
}

impl Number for f64 {
    const COUNT: usize = 1;

    #[inline(always)]
    fn read(from: &[f64; WIDTH]) -> f64 {
        from[0]
    }

    #[inline(always)]
    fn write(self, to: &mut [f64; WIDTH]) {
        to[0] = self;
    }

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
}

macro_rules! by_lane {
    ($($operator:ident $method:ident)*) => {$(
        impl $operator for LaneBlock {
            type Output = LaneBlock;

            #[inline(always)]
            fn $method(self, other: LaneBlock) -> LaneBlock {
                LaneBlock(from_fn(|l| self.0[l].$method(other.0[l])))
            }
        }
    )*};
}
by_lane!(Add add Sub sub Mul mul Div div);

/// Lanes for any processor.
impl Number for LaneBlock {
    #[inline(always)]
    fn read(from: &[f64; WIDTH]) -> LaneBlock {
        LaneBlock(*from)
    }

    #[inline(always)]
    fn write(self, to: &mut [f64; WIDTH]) {
        *to = self.0;
    }

    #[inline(always)]
    fn splat(value: f64) -> LaneBlock {
        LaneBlock([value; WIDTH])
    }

    #[inline(always)]
    fn sqrt(self) -> LaneBlock {
        LaneBlock(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    fn choose(self, yes: LaneBlock, no: LaneBlock) -> LaneBlock {
        LaneBlock(from_fn(|l| self.0[l].choose(yes.0[l], no.0[l])))
    }
}

impl Lanes for LaneBlock {
    #[inline(always)]
    fn take_left(self, before: LaneBlock) -> LaneBlock {
        let lane = |l: usize| l.checked_sub(1).map_or(before.0[WIDTH - 1], |l| self.0[l]);
        LaneBlock(from_fn(lane))
    }

    #[inline(always)]
    fn take_right(self, after: LaneBlock) -> LaneBlock {
        LaneBlock(from_fn(|l| *self.0.get(l + 1).unwrap_or(&after.0[0])))
    }

    #[inline(always)]
    fn positive_mask(self) -> u8 {
        let bit = |l: usize| u8::from(self.0[l] > 0.0) << l;
        (0..WIDTH).fold(0, |mask, l| mask | bit(l))
    }

    #[inline(always)]
    fn fused(self, factor: LaneBlock, term: LaneBlock) -> LaneBlock {
        self * factor + term
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
            let [a, b] = blocks.each_ref().map(L::load);
            let nan = L::splat(f64::NAN);
            let elementwise = [a + b, a - b, a * b, a / b, a.abs().sqrt(), a.positive()];
            let chosen = [a.choose(b, a), a.min(b), a.max(b), a.max(nan), a.min(nan)];
            let moved = [a.take_left(b), a.take_right(b)];
            let each = [a.at_each(b, a, |l, a, b, c| a.mul_add(b, c + l as f64))];
            let mut bits = vec![u64::from(a.positive_mask()), u64::from(b.positive_mask())];
            for lanes in [&elementwise[..], &chosen, &moved, &each].concat() {
                let mut block = LaneBlock::default();
                lanes.store(&mut block);
                bits.extend(block.0.map(f64::to_bits));
            }
            bits
        }
    }

    #[test]
    fn val_portable_lanes_equal_registers_bit_by_bit() {
        let portable = Sample.run::<LaneBlock>();
        assert_eq!(widest(Sample), portable);
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
        {
            // SAFETY: the features were found just above.
            assert_eq!(unsafe { x86::with_avx2(Sample) }, portable);
        }
    }
}
