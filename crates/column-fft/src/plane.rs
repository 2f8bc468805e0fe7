//! Both axes of a field.

use std::sync::Arc;

use ndarray::parallel::prelude::*;
use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use super::{ColumnInverse, ColumnTransform, Real};

/// `V(k, f) = sum_{n,j} v(t_n, x_j) exp(i (k x_j - 2 pi f t_n))` of fields `(time, site)`, for
/// `f >= 0` and, in the order of transforms, k of both signs: `(frequency, wavenumber)`, planned once.
///
/// By all threads of the current pool, with the same bits from any number of them.
pub struct SpaceTimeTransform<T: Real> {
    along_time: ColumnTransform<T>,
    along_space: Arc<dyn Fft<T>>,
}

/// [`SpaceTimeTransform`] undone, to rounding.
pub struct SpaceTimeInverse<T: Real> {
    back_in_time: ColumnInverse<T>,
    back_in_space: Arc<dyn Fft<T>>,
}

impl<T: Real> SpaceTimeTransform<T> {
    /// Plans transforms of fields of `(times, sites)`.
    ///
    /// # Panics
    /// If there are no times or no sites.
    pub fn new((times, sites): (usize, usize)) -> Self {
        assert!(times > 0 && sites > 0);
        SpaceTimeTransform {
            along_time: ColumnTransform::new(times),
            along_space: FftPlanner::new().plan_fft_inverse(sites),
        }
    }

    /// `(times, sites)`.
    pub fn shape(&self) -> (usize, usize) {
        (self.along_time.length(), self.along_space.len())
    }

    /// Rows of the result, `times / 2 + 1`.
    pub fn bins(&self) -> usize {
        self.along_time.bins()
    }

    /// The spectrum of `values`, `(time, site)`, to `spectrum`, `(times / 2 + 1, sites)`.
    ///
    /// # Panics
    /// If the shapes are not those of the plan.
    pub fn transform(&self, values: ArrayView2<T>, spectrum: ArrayViewMut2<Complex<T>>) {
        self.transform_and(values, spectrum, |_, _| {});
    }

    /// The same; then `look` gets each row with its number, while it is in the cache.
    pub fn transform_and(
        &self,
        values: ArrayView2<T>,
        mut spectrum: ArrayViewMut2<Complex<T>>,
        look: impl Fn(usize, &mut [Complex<T>]) + Sync,
    ) {
        assert_eq!(values.ncols(), self.along_space.len());
        self.along_time
            .transform_in_parallel(values, spectrum.view_mut());
        each_row(&*self.along_space, spectrum, look);
    }
}

impl<T: Real> SpaceTimeInverse<T> {
    /// Plans transforms to fields of `(times, sites)`.
    ///
    /// # Panics
    /// If there are no times or no sites.
    pub fn new((times, sites): (usize, usize)) -> Self {
        assert!(times > 0 && sites > 0);
        SpaceTimeInverse {
            back_in_time: ColumnInverse::new(times),
            back_in_space: FftPlanner::new().plan_fft_forward(sites),
        }
    }

    /// The field of `spectrum`, `(times / 2 + 1, sites)`, to `values`, `(times, sites)`; the spectrum
    /// is used up.
    ///
    /// # Panics
    /// If the shapes are not those of the plan.
    pub fn transform(&self, mut spectrum: ArrayViewMut2<Complex<T>>, values: ArrayViewMut2<T>) {
        let scale = T::rounded(1.0 / self.back_in_space.len() as f64);
        each_row(&*self.back_in_space, spectrum.view_mut(), |_, row| {
            row.iter_mut().for_each(|x| *x = x.scale(scale));
        });
        self.back_in_time
            .transform_in_parallel(spectrum.view(), values);
    }
}

/// Transforms every row, and passes it on with its number.
fn each_row<T: Real>(
    plan: &dyn Fft<T>,
    mut rows: ArrayViewMut2<Complex<T>>,
    look: impl Fn(usize, &mut [Complex<T>]) + Sync,
) {
    let transform = |m: usize, row: &mut [Complex<T>], work: &mut Vec<Complex<T>>| {
        plan.process_with_scratch(row, work);
        look(m, row);
    };
    rows.axis_iter_mut(Axis(0))
        .into_par_iter()
        .enumerate()
        .for_each_init(
            || vec![Complex::default(); plan.get_inplace_scratch_len()],
            |work, (m, mut row)| match row.as_slice_mut() {
                Some(row) => transform(m, row, work),
                None => {
                    let mut copy = row.to_vec();
                    transform(m, &mut copy, work);
                    row.iter_mut().zip(copy).for_each(|(to, x)| *to = x);
                }
            },
        );
}

impl<T: Real> std::fmt::Debug for SpaceTimeTransform<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SpaceTimeTransform")
            .field("shape", &self.shape())
            .finish_non_exhaustive()
    }
}

impl<T: Real> std::fmt::Debug for SpaceTimeInverse<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SpaceTimeInverse")
            .field("times", &self.back_in_time.length())
            .field("sites", &self.back_in_space.len())
            .finish_non_exhaustive()
    }
}
