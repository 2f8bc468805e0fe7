//! Spectra of all columns back to the columns.

use std::sync::Arc;

use ndarray::parallel::prelude::*;
use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner};

use super::Real;

/// Columns that are gathered together: a cache line of each row.
const TOGETHER: usize = 8;

/// `v_n = 1 / N sum_m X_m exp(2 pi i m n / N)` over all m of both signs, of spectra `(bin, column)`
/// as [`ColumnTransform`](super::ColumnTransform) makes them; undoes it to rounding. Column by
/// column, so that a column's bits do not depend on the others.
///
/// Bins 0 and, for even N, N / 2 are taken for real.
pub struct ColumnInverse<T: Real> {
    plan: Arc<dyn ComplexToReal<T>>,
}

/// Working space of one thread.
struct Room<T> {
    spectra: Vec<Complex<T>>,
    columns: Vec<T>,
    work: Vec<Complex<T>>,
}

impl<T: Real> ColumnInverse<T> {
    /// Plans transforms to columns of `length` samples.
    ///
    /// # Panics
    /// If `length` is 0.
    pub fn new(length: usize) -> Self {
        assert!(length > 0);
        ColumnInverse {
            plan: RealFftPlanner::<T>::new().plan_fft_inverse(length),
        }
    }

    /// Length N of the columns.
    pub fn length(&self) -> usize {
        self.plan.len()
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
        let length = self.length();
        assert_eq!(spectra.dim(), (length / 2 + 1, values.ncols()));
        assert_eq!(values.nrows(), length);
        spectra
            .axis_chunks_iter(Axis(1), TOGETHER)
            .into_par_iter()
            .zip(values.axis_chunks_iter_mut(Axis(1), TOGETHER))
            .for_each_init(
                || self.room(),
                |room, (spectra, values)| self.tile(spectra, values, room),
            );
    }

    fn room(&self) -> Room<T> {
        let length = self.length();
        Room {
            spectra: vec![Complex::default(); TOGETHER * (length / 2 + 1)],
            columns: vec![T::zero(); TOGETHER * length],
            work: self.plan.make_scratch_vec(),
        }
    }

    fn tile(
        &self,
        spectra: ArrayView2<Complex<T>>,
        mut values: ArrayViewMut2<T>,
        room: &mut Room<T>,
    ) {
        let length = self.length();
        let bins = length / 2 + 1;
        let scale = T::rounded(1.0 / length as f64);
        for (m, row) in spectra.outer_iter().enumerate() {
            for (c, &bin) in row.iter().enumerate() {
                room.spectra[c * bins + m] = bin.scale(scale);
            }
        }
        let columns = room.columns.chunks_exact_mut(length);
        for (spectrum, column) in room.spectra.chunks_exact_mut(bins).zip(columns) {
            spectrum[0].im = T::zero();
            if length.is_multiple_of(2) {
                spectrum[bins - 1].im = T::zero();
            }
            // The lengths are the plan's own and these bins are real, so this cannot fail.
            let _ = self
                .plan
                .process_with_scratch(spectrum, column, &mut room.work);
        }
        for (n, mut row) in values.outer_iter_mut().enumerate() {
            for (c, value) in row.iter_mut().enumerate() {
                *value = room.columns[c * length + n];
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
