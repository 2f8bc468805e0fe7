//! Two-dimensional and short-time transforms: ours and the reference implementations.

use std::f64::consts::PI;
use std::hint::black_box;
use std::sync::Arc;

use ndarray::parallel::prelude::*;
use ndarray::{ArrayView2, ArrayViewMut2, ArrayViewMut3, Axis, s};
use num_complex::Complex;

use crate::Result;
use crate::kind::{HOP, SEGMENT};
use crate::ways::{Description, PlannedTransform, ReferencePlans, noise};
use crate::{ArrayShape, Buffer, Implementation};
use column_fft::{
    Fft, FftDirection, Real, RealToComplex2d, RealToComplexColumns, ShortTimeColumns, rows,
};

/// A noise array and its two-dimensional spectrum. Reference implementations transform the columns,
/// then the rows by `rustfft`.
pub struct Plane<T: Real> {
    shape: ArrayShape,
    values: Buffer,
    spectrum: Buffer,
    ours: RealToComplex2d<T>,
    columns: ReferencePlans<T>,
    rows: Arc<dyn Fft<T>>,
    room: Vec<Complex<T>>,
}

impl<T: Real> Plane<T> {
    /// # Errors
    /// [`crate::Error::Memory`] where there is no memory.
    pub fn new(shape: ArrayShape) -> Result<Self> {
        let ArrayShape { rows, columns } = shape;
        Ok(Plane {
            shape,
            values: noise::<T>(shape)?,
            spectrum: Buffer::new(shape.bins() * columns * size_of::<Complex<T>>())?,
            ours: RealToComplex2d::new((rows, columns), FftDirection::Inverse)
                .expect("rows and columns"),
            columns: ReferencePlans::new(rows),
            rows: rows::plan_fft_complex(columns, FftDirection::Inverse),
            room: Vec::new(),
        })
    }
}

impl<T: Real> PlannedTransform for Plane<T> {
    fn run(&mut self, way: Implementation, in_parallel: bool) {
        let ArrayShape { rows, columns } = self.shape;
        let values = ArrayView2::from_shape((rows, columns), self.values.of::<T>());
        let values = values.expect("the array's shape");
        let spectrum = self.spectrum.of::<Complex<T>>();
        let spectrum = ArrayViewMut2::from_shape((self.shape.bins(), columns), spectrum);
        let mut spectrum = spectrum.expect("the spectrum's shape");
        if way == Implementation::Cascade {
            let transformed = self.ours.process_in_parallel(values, spectrum);
            transformed.expect("shapes of the plan");
        } else {
            let by_column = spectrum.view_mut();
            self.columns
                .transform(way, values, by_column, in_parallel, &mut self.room);
            let scratch = self.rows.get_inplace_scratch_len();
            spectrum
                .axis_iter_mut(Axis(0))
                .into_par_iter()
                .for_each_init(
                    || vec![Complex::default(); scratch],
                    |scratch, row| {
                        let row = row.into_slice().expect("a row of the spectrum");
                        self.rows.process_with_scratch(row, scratch);
                    },
                );
        }
        black_box(&mut self.spectrum);
    }

    fn about(&self) -> Description {
        let plan = RealToComplexColumns::<T>::new(self.shape.rows);
        let along_time = plan.expect("at least one row").algorithm();
        Description {
            method: format!("{along_time:?}, then rows by rustfft"),
            expected_error: None,
        }
    }
}

/// A noise array and the spectra of its segments. Reference implementations window a copy of each
/// segment and transform its columns.
pub struct ShortTime<T: Real> {
    shape: ArrayShape,
    values: Buffer,
    spectra: Buffer,
    ours: ShortTimeColumns<T>,
    window: Vec<T>,
    columns: ReferencePlans<T>,
}

impl<T: Real> ShortTime<T> {
    /// Arrays must hold at least one segment.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] where there is no memory.
    pub fn new(shape: ArrayShape) -> Result<Self> {
        let hann = |n: usize| (PI * n as f64 / SEGMENT as f64).sin().powi(2);
        let window: Vec<f64> = (0..SEGMENT).map(hann).collect();
        let ours = ShortTimeColumns::new(&window, HOP).expect("a window and a hop");
        let bins = ours.segments(shape.rows) * ours.bins() * shape.columns;
        Ok(ShortTime {
            shape,
            values: noise::<T>(shape)?,
            spectra: Buffer::new(bins * size_of::<Complex<T>>())?,
            ours,
            window: window.into_iter().map(T::rounded).collect(),
            columns: ReferencePlans::new(SEGMENT),
        })
    }
}

impl<T: Real> PlannedTransform for ShortTime<T> {
    fn run(&mut self, way: Implementation, _in_parallel: bool) {
        let ArrayShape { rows, columns } = self.shape;
        let values = ArrayView2::from_shape((rows, columns), self.values.of::<T>());
        let values = values.expect("the array's shape");
        let shape = (self.ours.segments(rows), self.ours.bins(), columns);
        let spectra = ArrayViewMut3::from_shape(shape, self.spectra.of::<Complex<T>>());
        let mut spectra = spectra.expect("the spectra's shape");
        if way == Implementation::Cascade {
            let transformed = self.ours.process_in_parallel(values, spectra);
            transformed.expect("shapes of the plan");
        } else {
            let segments = spectra.axis_iter_mut(Axis(0)).into_par_iter().enumerate();
            segments.for_each_init(
                || (vec![T::zero(); SEGMENT * columns], Vec::new()),
                |(weighed, room), (segment, spectra)| {
                    let start = segment * HOP;
                    let rows = values.slice(s![start..start + SEGMENT, ..]);
                    let copies = weighed.chunks_exact_mut(columns);
                    for ((row, copy), &w) in rows.outer_iter().zip(copies).zip(&self.window) {
                        copy.iter_mut().zip(row).for_each(|(to, &v)| *to = v * w);
                    }
                    let weighed = ArrayView2::from_shape((SEGMENT, columns), &*weighed);
                    let weighed = weighed.expect("the copy's shape");
                    self.columns.transform(way, weighed, spectra, false, room);
                },
            );
        }
        black_box(&mut self.spectra);
    }

    fn about(&self) -> Description {
        let plan = RealToComplexColumns::<T>::new(SEGMENT);
        let segment = plan.expect("at least one row").algorithm();
        Description {
            method: format!("segments of {SEGMENT}, {HOP} apart: {segment:?}"),
            expected_error: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All implementations agree with ours, single-threaded and in parallel, to `within` of the
    /// largest value.
    fn agree<T: Real, P: PlannedTransform>(
        mut planned: P,
        result: fn(&mut P) -> &mut Buffer,
        within: f64,
    ) {
        let mut run = |way, in_parallel| -> Vec<Complex<f64>> {
            result(&mut planned).of::<u8>().fill(0xff);
            planned.run(way, in_parallel);
            let found = result(&mut planned).of::<Complex<T>>().iter();
            found
                .map(|x| Complex::new(x.re.to_f64(), x.im.to_f64()))
                .collect()
        };
        let ours = run(Implementation::Cascade, false);
        let largest = |of: &mut dyn Iterator<Item = f64>| of.fold(0.0, f64::max);
        let scale = largest(&mut ours.iter().map(|x| x.norm()));
        for way in Implementation::ALL {
            for in_parallel in [false, true] {
                let found = run(way, in_parallel);
                assert!(found.iter().all(|x| x.is_finite()), "{way:?}");
                let off = largest(&mut found.iter().zip(&ours).map(|(x, y)| (x - y).norm()));
                let name = std::any::type_name::<T>();
                assert!(off < within * scale, "{way:?} {name}: {:e}", off / scale);
            }
        }
    }

    #[test]
    fn val_usual_ways_over_both_axes_give_the_same_numbers() {
        let shape = ArrayShape::new(96, 21);
        let (single, double) = (Plane::new(shape), Plane::new(shape));
        agree::<f32, Plane<f32>>(single.unwrap(), |p| &mut p.spectrum, 5e-7);
        agree::<f64, Plane<f64>>(double.unwrap(), |p| &mut p.spectrum, 1e-15);
    }

    #[test]
    fn val_usual_ways_of_segments_give_the_same_numbers() {
        let shape = ArrayShape::new(330, 11);
        let (single, double) = (ShortTime::new(shape), ShortTime::new(shape));
        agree::<f32, ShortTime<f32>>(single.unwrap(), |s| &mut s.spectra, 5e-7);
        agree::<f64, ShortTime<f64>>(double.unwrap(), |s| &mut s.spectra, 1e-15);
    }
}
