//! Several real records at once, one after the other in memory.

use std::any::TypeId;

use ndarray::{ArrayView2, ArrayViewMut2};
use num_complex::Complex;

use super::Real;
use super::real::Taper;
use super::vertical::{ColumnScratch, ColumnTransform};

/// [`RealTransform`](super::RealTransform) of several records, which pass through the transform
/// side by side. A record's bits do not depend on the others.
pub struct RecordTransform<T: Real> {
    plan: ColumnTransform<T>,
    taper: Taper,
}

/// Working space of one thread; grows once.
#[derive(Debug, Clone)]
pub struct RecordScratch<T> {
    /// Records that came one after the other, side by side.
    turned: Vec<f64>,
    spectra: Vec<Complex<T>>,
    energies: Vec<f64>,
    means: Vec<f64>,
    tapered: Vec<f64>,
    input: Vec<T>,
    /// And the records it has room for.
    columns: Option<(ColumnScratch<T>, usize)>,
}

impl<T> Default for RecordScratch<T> {
    fn default() -> Self {
        RecordScratch {
            turned: Vec::new(),
            spectra: Vec::new(),
            energies: Vec::new(),
            means: Vec::new(),
            tapered: Vec::new(),
            input: Vec::new(),
            columns: None,
        }
    }
}

impl<T: Real> RecordTransform<T> {
    /// Plans transforms of `window.len()` samples padded to `padded`; all weights 1 mean no taper.
    ///
    /// # Panics
    /// If there are no samples or `padded` is shorter than the window.
    pub fn new(window: &[f64], padded: usize) -> Self {
        assert!(!window.is_empty() && padded >= window.len());
        RecordTransform {
            plan: ColumnTransform::new(padded),
            taper: Taper::new(window, padded),
        }
    }

    /// Length N of the transform.
    pub fn padded(&self) -> usize {
        self.plan.length()
    }

    /// Bins of the result, `N / 2 + 1`.
    pub fn bins(&self) -> usize {
        self.plan.bins()
    }

    /// The spectra of `records`, bin by bin in the order of records, in `scratch`, and of each the energy
    /// `sum (w v)^2` of what went in.
    ///
    /// # Panics
    /// If a record is not as long as the window.
    pub fn transform<'a, 's>(
        &self,
        records: impl ExactSizeIterator<Item = &'a [f64]>,
        scratch: &'s mut RecordScratch<T>,
    ) -> (&'s [Complex<T>], &'s [f64]) {
        let (width, bins) = (records.len(), self.bins());
        let mut spectra = std::mem::take(&mut scratch.spectra);
        spectra.resize(width * bins, Complex::default());
        // The shape is the buffer's own, so this cannot fail.
        if let Ok(output) = ArrayViewMut2::from_shape((bins, width), &mut spectra) {
            self.transform_into(records, output, scratch);
        }
        scratch.spectra = spectra;
        (&scratch.spectra, &scratch.energies)
    }

    /// The same with the spectra, `(bin, record)`, in `spectra`; the energies.
    ///
    /// # Panics
    /// If a record is not as long as the window, or the shape is not that of the spectra.
    pub fn transform_into<'a, 's>(
        &self,
        records: impl ExactSizeIterator<Item = &'a [f64]>,
        spectra: ArrayViewMut2<Complex<T>>,
        scratch: &'s mut RecordScratch<T>,
    ) -> &'s [f64] {
        let records: Vec<&[f64]> = records.collect();
        let mut turned = std::mem::take(&mut scratch.turned);
        turned.resize(records.len() * self.taper.samples, 0.0);
        for record in &records {
            assert_eq!(record.len(), self.taper.samples);
        }
        for (n, row) in turned.chunks_exact_mut(records.len().max(1)).enumerate() {
            row.iter_mut()
                .zip(&records)
                .for_each(|(v, record)| *v = record[n]);
        }
        self.transform_columns(&turned, spectra, scratch);
        scratch.turned = turned;
        &scratch.energies
    }

    /// The same of records that lie side by side, time by time.
    ///
    /// # Panics
    /// If the shapes are not those of the plan.
    pub fn transform_columns<'s>(
        &self,
        values: &[f64],
        mut spectra: ArrayViewMut2<Complex<T>>,
        scratch: &'s mut RecordScratch<T>,
    ) -> &'s [f64] {
        let (length, width) = (self.padded(), spectra.ncols());
        assert_eq!(values.len(), width * self.taper.samples);
        let RecordScratch {
            energies,
            means,
            tapered,
            input,
            columns,
            ..
        } = scratch;
        self.taper
            .look_across(values, width, tapered, (means, energies));
        let room = columns.take().filter(|(_, room)| *room >= width);
        let (room, _) = columns.insert(room.unwrap_or_else(|| (self.plan.scratch(width), width)));
        let is_plain = self.taper.is_plain()
            && length == self.taper.samples
            && means.iter().all(|&mean| mean == 0.0);
        let input = match as_numbers(values).filter(|_| is_plain) {
            Some(numbers) => numbers,
            None => {
                input.clear();
                self.taper.weigh_across(values, means, input);
                input.resize(width * length, T::zero());
                &input[..]
            }
        };
        // The shape is the buffer's own, so this cannot fail.
        if let Ok(input) = ArrayView2::from_shape((length, width), input) {
            self.plan.transform(input, spectra.view_mut(), room);
        }
        for (&mean, mut spectrum) in means.iter().zip(spectra.columns_mut()) {
            self.taper.add_mean(mean, spectrum.iter_mut());
        }
        energies
    }
}

/// The same numbers, where they are of this type.
fn as_numbers<T: Real>(values: &[f64]) -> Option<&[T]> {
    let is_same = TypeId::of::<T>() == TypeId::of::<f64>();
    is_same.then(|| bytemuck::cast_slice(values))
}

impl<T: Real> std::fmt::Debug for RecordTransform<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RecordTransform")
            .field("samples", &self.taper.samples)
            .field("padded", &self.padded())
            .finish_non_exhaustive()
    }
}
