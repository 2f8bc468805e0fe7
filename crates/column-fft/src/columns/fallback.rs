//! The shortest lengths: column by column.

use std::sync::Arc;

use ndarray::{ArrayView2, ArrayViewMut2};
use num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};

use crate::Real;

/// Columns that are gathered together: a cache line of each row.
pub const WIDTH: usize = 8;

pub struct Fallback<T> {
    plan: Arc<dyn RealToComplex<T>>,
}

/// Records, spectra and working space.
#[derive(Debug, Clone, Default)]
pub struct Room<T> {
    records: Vec<T>,
    spectra: Vec<Complex<T>>,
    work: Vec<Complex<T>>,
}

impl<T> Room<T> {
    pub fn bytes(&self) -> u64 {
        let numbers = size_of_val(&self.records[..]);
        (numbers + size_of_val(&self.spectra[..]) + size_of_val(&self.work[..])) as u64
    }
}

impl<T: Real> Fallback<T> {
    pub fn new(length: usize) -> Self {
        Fallback {
            plan: RealFftPlanner::<T>::new().plan_fft_forward(length),
        }
    }

    pub fn room(&self) -> Room<T> {
        let length = self.plan.len();
        Room {
            records: vec![T::zero(); length * WIDTH],
            spectra: vec![Complex::default(); (length / 2 + 1) * WIDTH],
            work: self.plan.make_scratch_vec(),
        }
    }

    pub fn transform(
        &self,
        values: ArrayView2<T>,
        mut spectra: ArrayViewMut2<Complex<T>>,
        room: &mut Room<T>,
    ) {
        let length = self.plan.len();
        let bins = length / 2 + 1;
        let columns = values.ncols();
        for from in (0..columns).step_by(WIDTH) {
            let width = WIDTH.min(columns - from);
            for (n, row) in values.outer_iter().enumerate() {
                for c in 0..width {
                    room.records[c * length + n] = row[from + c];
                }
            }
            let records = room.records.chunks_exact_mut(length);
            let tile = records.zip(room.spectra.chunks_exact_mut(bins));
            for (record, spectrum) in tile.take(width) {
                // The lengths are the plan's own, so this cannot fail.
                let _ = self
                    .plan
                    .process_with_scratch(record, spectrum, &mut room.work);
            }
            for (m, mut row) in spectra.outer_iter_mut().enumerate() {
                for c in 0..width {
                    row[from + c] = room.spectra[c * bins + m];
                }
            }
        }
    }
}
