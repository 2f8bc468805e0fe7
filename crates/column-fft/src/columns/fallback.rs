//! The shortest lengths: column by column, by `realfft`.

use std::sync::Arc;

use num_complex::Complex;
use realfft::RealToComplex;

use crate::{Columns, ColumnsMut, Real, rows};

/// Columns that are gathered together: a cache line of each row.
pub const WIDTH: usize = 8;

/// A planned transform of one length.
pub struct Fallback<T> {
    plan: Arc<dyn RealToComplex<T>>,
}

impl<T: Real> Fallback<T> {
    pub fn new(length: usize) -> Self {
        Fallback {
            plan: rows::plan_fft_forward(length),
        }
    }

    /// Records in complex numbers, and spectra.
    fn parts(&self) -> [usize; 2] {
        let length = self.plan.len();
        [(length * WIDTH).div_ceil(2), (length / 2 + 1) * WIDTH]
    }

    /// Complex numbers of scratch: records, spectra, and what `realfft` needs.
    pub fn scratch_len(&self) -> usize {
        let [records, spectra] = self.parts();
        records + spectra + self.plan.get_scratch_len()
    }

    /// # Panics
    /// If the shapes are not those of the plan or the scratch is too short.
    pub fn transform(
        &self,
        values: Columns<T>,
        spectra: &mut ColumnsMut<Complex<T>>,
        scratch: &mut [Complex<T>],
    ) {
        let length = self.plan.len();
        let bins = length / 2 + 1;
        let columns = values.columns();
        let [records, found] = self.parts();
        let (records, rest) = scratch.split_at_mut(records);
        let (found, work) = rest.split_at_mut(found);
        let records: &mut [T] = bytemuck::cast_slice_mut(records);
        for from in (0..columns).step_by(WIDTH) {
            let width = WIDTH.min(columns - from);
            for n in 0..length {
                for c in 0..width {
                    records[c * length + n] = values.at(n, from + c);
                }
            }
            let tile = records.chunks_exact_mut(length);
            for (record, spectrum) in tile.zip(found.chunks_exact_mut(bins)).take(width) {
                // The lengths are the plan's own, so this cannot fail.
                let _ = self.plan.process_with_scratch(record, spectrum, work);
            }
            for m in 0..bins {
                for c in 0..width {
                    spectra.set(m, from + c, found[c * bins + m]);
                }
            }
        }
    }
}
