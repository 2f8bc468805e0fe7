//! Several real records at once, one after the other in memory.

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
    /// Records it has room for.
    records: usize,
    tapered: Vec<f64>,
    input: Vec<T>,
    spectra: Vec<Complex<T>>,
    energies: Vec<f64>,
    means: Vec<f64>,
    columns: Option<ColumnScratch<T>>,
}

impl<T: Real> Default for RecordScratch<T> {
    fn default() -> Self {
        RecordScratch {
            records: 0,
            tapered: Vec::new(),
            input: Vec::new(),
            spectra: Vec::new(),
            energies: Vec::new(),
            means: Vec::new(),
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
        let width = records.len();
        let (length, bins) = (self.padded(), self.bins());
        let samples = self.taper.samples;
        scratch.input.resize(width * length, T::zero());
        // Padding may hold samples of other records from before.
        scratch.input[width * samples..].fill(T::zero());
        scratch.spectra.resize(width * bins, Complex::default());
        scratch.energies.clear();
        scratch.means.clear();
        let records: Vec<&[f64]> = records.collect();
        for record in &records {
            assert_eq!(record.len(), samples);
            let (mean, energy) = self.taper.look(record, &mut scratch.tapered);
            scratch.means.push(mean);
            scratch.energies.push(energy);
        }
        self.taper
            .weigh_across(&records, &scratch.means, &mut scratch.input);
        if scratch.records < width || scratch.columns.is_none() {
            scratch.columns = Some(self.plan.scratch(width));
            scratch.records = width;
        }
        // The shapes are the buffers' own, so this cannot fail.
        let input = ArrayView2::from_shape((length, width), &scratch.input);
        let output = ArrayViewMut2::from_shape((bins, width), &mut scratch.spectra);
        if let (Ok(input), Ok(output), Some(columns)) = (input, output, &mut scratch.columns) {
            self.plan.transform(input, output, columns);
        }
        for (c, &mean) in scratch.means.iter().enumerate() {
            let spectrum = scratch.spectra.iter_mut().skip(c).step_by(width);
            self.taper.add_mean(mean, spectrum);
        }
        (&scratch.spectra, &scratch.energies)
    }
}

impl<T: Real> std::fmt::Debug for RecordTransform<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RecordTransform")
            .field("samples", &self.taper.samples)
            .field("padded", &self.padded())
            .finish_non_exhaustive()
    }
}
