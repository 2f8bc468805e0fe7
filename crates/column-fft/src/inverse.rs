//! Spectra of all columns back to the columns.

use std::sync::{Mutex, PoisonError};

use ndarray::parallel::prelude::*;
use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use num_complex::Complex;

use super::Real;
use crate::columns::{ColumnScratch, ColumnTransform};

/// `v_n = 1 / N sum_m X_m exp(2 pi i m n / N)` over all m of both signs, of spectra `(bin, column)`
/// as [`ColumnTransform`] makes them; undoes it to rounding. A column's bits do not depend on the
/// others.
///
/// Bins 0 and, for even N, N / 2 are taken for real.
///
/// The sum is a Hartley transform, which is its own inverse: with the real numbers
/// `h_m = Re X_m - Im X_m`, `m = 0 .. N`, and their transform H, `N v_n = Re H_n - Im H_n`. So every
/// length goes back by the kernels by which it came.
///
/// Source: R. N. Bracewell, "Discrete Hartley transform", J. Opt. Soc. Am. 73, 1832 (1983).
pub struct ColumnInverse<T: Real> {
    plan: ColumnTransform<T>,
    /// Working spaces of threads that are done, for those to come.
    spare: Mutex<Vec<Room<T>>>,
}

/// Working space of one thread: a tile of columns, of their sums and of these sums' transforms.
struct Room<T> {
    sums: Vec<T>,
    transforms: Vec<Complex<T>>,
    scratch: ColumnScratch<T>,
}

impl<T: Real> ColumnInverse<T> {
    /// Plans transforms to columns of `length` samples.
    ///
    /// # Panics
    /// If `length` is 0.
    pub fn new(length: usize) -> Self {
        ColumnInverse {
            plan: ColumnTransform::new(length),
            spare: Mutex::default(),
        }
    }

    /// Bytes of working space that a thread needs at most for columns of `length` samples, known before
    /// anything is planned.
    pub fn working_bytes(length: usize) -> u64 {
        let width = ColumnTransform::<T>::width_of(length);
        let row = width * size_of::<T>();
        let sums = length + 2 * (length / 2 + 1);
        (row * sums) as u64 + ColumnTransform::<T>::working_bytes(length, width, row)
    }

    /// Length N of the columns.
    pub fn length(&self) -> usize {
        self.plan.length()
    }

    /// The columns of `spectra`, `(N / 2 + 1, column)`, to `values`, `(N, column)`, by all threads of
    /// the current pool, with the same bits from any number of them.
    ///
    /// # Panics
    /// If the shapes are not those of the plan.
    pub fn transform_in_parallel(
        &self,
        spectra: ArrayView2<Complex<T>>,
        mut values: ArrayViewMut2<T>,
    ) {
        assert_eq!(spectra.dim(), (self.plan.bins(), values.ncols()));
        assert_eq!(values.nrows(), self.length());
        let width = self.plan.width();
        let columns = values.ncols();
        let tiles = columns.div_ceil(width);
        let stripe = tiles.div_ceil(4 * rayon::current_num_threads()).max(1) * width;
        spectra
            .axis_chunks_iter(Axis(1), stripe)
            .into_par_iter()
            .zip(values.axis_chunks_iter_mut(Axis(1), stripe))
            .for_each(|(spectra, mut values)| {
                let mut room = self.borrow();
                let tiles = spectra.axis_chunks_iter(Axis(1), width);
                for (spectra, values) in tiles.zip(values.axis_chunks_iter_mut(Axis(1), width)) {
                    self.tile(spectra, values, &mut room);
                }
                let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
                spare.push(room);
            });
    }

    /// A working space of one thread, one that is spare if there is one.
    fn borrow(&self) -> Room<T> {
        let spare = self
            .spare
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .pop();
        let (width, length) = (self.plan.width(), self.length());
        spare.unwrap_or_else(|| Room {
            sums: vec![T::zero(); width * length],
            transforms: vec![Complex::default(); width * self.plan.bins()],
            scratch: self.plan.scratch(width),
        })
    }

    /// At most a tile's width of columns; the places of others hold what they held before, which
    /// does not matter.
    fn tile(
        &self,
        spectra: ArrayView2<Complex<T>>,
        mut values: ArrayViewMut2<T>,
        room: &mut Room<T>,
    ) {
        let (length, width) = (self.length(), self.plan.width());
        for (m, bins) in spectra.outer_iter().enumerate() {
            let mirror = (length - m) % length;
            for (c, x) in bins.iter().enumerate() {
                // Not a product with 0, which would let infinities through.
                let im = if mirror == m { T::zero() } else { x.im };
                room.sums[m * width + c] = x.re - im;
                room.sums[mirror * width + c] = x.re + im;
            }
        }
        // The shapes are the buffers' own, so this cannot fail.
        let sums = ArrayView2::from_shape((length, width), &room.sums);
        let bins = (self.plan.bins(), width);
        let transforms = ArrayViewMut2::from_shape(bins, &mut room.transforms);
        if let (Ok(sums), Ok(transforms)) = (sums, transforms) {
            self.plan.transform(sums, transforms, &mut room.scratch);
        }
        let scale = T::rounded(1.0 / length as f64);
        for (n, row) in room.transforms.chunks_exact(width).enumerate() {
            for (v, x) in values.row_mut(n).iter_mut().zip(row) {
                *v = (x.re - x.im) * scale;
            }
            if n > 0 {
                for (v, x) in values.row_mut(length - n).iter_mut().zip(row) {
                    *v = (x.re + x.im) * scale;
                }
            }
        }
    }
}

impl<T: Real> std::fmt::Debug for ColumnInverse<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ColumnInverse")
            .field("length", &self.length())
            .finish_non_exhaustive()
    }
}
