//! How a caller's scratch is divided.

use num_complex::Complex;

use super::LINE;
use crate::Real;

/// Numbers of T, in whole cache lines.
fn in_lines<T>(numbers: usize) -> usize {
    (numbers * size_of::<T>()).next_multiple_of(LINE) / size_of::<T>()
}

/// Complex numbers of a scratch that holds `parts` numbers, each part aligned to a cache line, at any alignment of
/// the scratch.
pub fn complex_len<T>(parts: [usize; 2]) -> usize {
    let numbers: usize = parts.into_iter().map(in_lines::<T>).sum();
    let align = LINE / size_of::<T>();
    (numbers + align) / 2
}

/// The parts of a scratch of [`complex_len`], the second as long as it gets.
///
/// # Panics
/// If the first part does not fit.
pub fn divide<T: Real>(scratch: &mut [Complex<T>], first: usize) -> (&mut [T], &mut [T]) {
    let numbers: &mut [T] = bytemuck::cast_slice_mut(scratch);
    let skipped = numbers.as_ptr().align_offset(LINE).min(numbers.len());
    numbers[skipped..].split_at_mut(in_lines::<T>(first))
}
