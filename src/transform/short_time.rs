//! Spectra of overlapping segments of all columns.

use ndarray::parallel::prelude::*;
use ndarray::{ArrayView2, ArrayViewMut2, ArrayViewMut3, Axis, s};
use num_complex::Complex;

use super::{ColumnTransform, Real};

/// `X_sm = sum_n w_n v_{s h + n} exp(-2 pi i m n / L)`, `m = 0 ..= L / 2`, of segments of L samples, a
/// hop h apart, of every column `v` of an array `(time, column)`: `(segment, bin, column)`,
/// unnormalised.
pub struct ShortTimeTransform<T: Real> {
    window: Vec<T>,
    hop: usize,
    plan: ColumnTransform<T>,
}

/// Columns that are weighed together: a few tiles, which the second cache holds.
const TOGETHER: usize = 4;

impl<T: Real> ShortTimeTransform<T> {
    /// Plans transforms of segments weighed by `window`, `hop` samples apart.
    ///
    /// # Panics
    /// If the window is empty or the hop 0.
    pub fn new(window: &[f64], hop: usize) -> Self {
        assert!(hop > 0);
        ShortTimeTransform {
            window: window.iter().map(|&w| T::rounded(w)).collect(),
            hop,
            plan: ColumnTransform::new(window.len()),
        }
    }

    /// Whole segments in records of `times` samples.
    pub fn segments(&self, times: usize) -> usize {
        match times.checked_sub(self.window.len()) {
            Some(rest) => rest / self.hop + 1,
            None => 0,
        }
    }

    /// Bins of a segment, `L / 2 + 1`.
    pub fn bins(&self) -> usize {
        self.plan.bins()
    }

    /// The spectra of `values`, `(time, column)`, to `spectra`, `(segment, bin, column)`, by all threads
    /// of the current pool, with the same bits from any number of them.
    ///
    /// # Panics
    /// If the shapes are not those of the plan.
    pub fn transform_in_parallel(
        &self,
        values: ArrayView2<T>,
        mut spectra: ArrayViewMut3<Complex<T>>,
    ) {
        let (times, columns) = values.dim();
        let length = self.window.len();
        assert_eq!(
            spectra.dim(),
            (self.segments(times), self.bins(), columns),
            "shape of the spectra"
        );
        let stream = self.plan.streams(columns * self.segments(times));
        let passing = self.plan.weighs();
        let together = TOGETHER * self.plan.width();
        let room = if passing { 0 } else { length * together };
        spectra
            .axis_iter_mut(Axis(0))
            .into_par_iter()
            .enumerate()
            .for_each_init(
                || (vec![T::zero(); room], self.plan.scratch(columns)),
                |(weighed, scratch), (s, mut spectra)| {
                    let start = s * self.hop;
                    let segment = values.slice(s![start..start + length, ..]);
                    if passing {
                        self.plan
                            .stripe(segment, &self.window, &mut spectra, stream, scratch);
                        return;
                    }
                    for from in (0..columns).step_by(together) {
                        let to = columns.min(from + together);
                        let weighed = &mut weighed[..length * (to - from)];
                        self.weigh(segment.slice(s![.., from..to]), weighed);
                        let weighed = ArrayView2::from_shape((length, to - from), &*weighed);
                        let mut stripe: ArrayViewMut2<_> = spectra.slice_mut(s![.., from..to]);
                        // The shape is the buffer's own, so this cannot fail.
                        if let Ok(weighed) = weighed {
                            self.plan.stripe(weighed, &[], &mut stripe, stream, scratch);
                        }
                    }
                },
            );
    }

    fn weigh(&self, segment: ArrayView2<T>, weighed: &mut [T]) {
        let rows = weighed.chunks_exact_mut(segment.ncols());
        for ((row, to), &weight) in segment.outer_iter().zip(rows).zip(&self.window) {
            match row.to_slice() {
                Some(row) => to.iter_mut().zip(row).for_each(|(to, &v)| *to = v * weight),
                None => to
                    .iter_mut()
                    .zip(&row)
                    .for_each(|(to, &v)| *to = v * weight),
            }
        }
    }
}

impl<T: Real> std::fmt::Debug for ShortTimeTransform<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ShortTimeTransform")
            .field("length", &self.window.len())
            .field("hop", &self.hop)
            .finish_non_exhaustive()
    }
}
