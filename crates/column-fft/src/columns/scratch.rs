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

#[cfg(test)]
mod tests {
    use super::*;

    fn parts_of<T: Real>() {
        for parts in [[0, 0], [1, 1], [64, 3], [17, 1000]] {
            let length = complex_len::<T>(parts);
            let mut scratch = vec![Complex::<T>::default(); length + 5];
            for start in 0..5 {
                let (first, second) = divide(&mut scratch[start..start + length], parts[0]);
                assert!(first.len() >= parts[0] && second.len() >= parts[1]);
                assert!(first.as_ptr().addr().is_multiple_of(LINE));
                assert!(second.as_ptr().addr().is_multiple_of(LINE));
            }
        }
    }

    #[test]
    fn parts_start_with_a_cache_line_wherever_the_scratch_starts() {
        parts_of::<f64>();
        parts_of::<f32>();
    }
}
