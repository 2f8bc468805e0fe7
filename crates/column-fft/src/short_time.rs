//! Spectra of overlapping segments of all columns.

use ndarray::parallel::prelude::*;
use ndarray::{ArrayView2, ArrayViewMut2, ArrayViewMut3, Axis, s};
use num_complex::Complex;

use super::Real;
use crate::columns::LINE;
use crate::columns::{ColumnScratch, ColumnTransform, copy_streaming};

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

/// Bytes of spectra of a segment that are assembled in the caches before they are written past them.
const ASSEMBLED_BYTES: usize = 1 << 20;

/// Bytes of a row from which on pieces of rows are worth it: lines at their ends are shared.
const LEAST_PIECE: usize = 2048;

/// All columns if there is room for their spectra, else as many whole tiles as there is, if that makes
/// long pieces of rows.
fn columns_assembled<T: Real>(bins: usize, width: usize, columns: usize) -> Option<usize> {
    let fit = ASSEMBLED_BYTES / (size_of::<Complex<T>>() * bins);
    if fit >= columns {
        return (columns > 0).then_some(columns);
    }
    let together = fit / width * width;
    (together * size_of::<Complex<T>>() >= LEAST_PIECE).then_some(together)
}

/// Working space of one thread.
struct Room<T> {
    /// Columns that are weighed before they are transformed.
    weighed: Vec<T>,
    /// Spectra on their way past the caches.
    assembled: Vec<Complex<T>>,
    scratch: ColumnScratch<T>,
}

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
    /// Fastest where rows of `spectra` are whole cache lines; where large ones are not, they pass through
    /// up to a megabyte of working space a thread.
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
        let room = || Room {
            weighed: Vec::new(),
            assembled: Vec::new(),
            scratch: self.plan.scratch(columns),
        };
        spectra
            .axis_iter_mut(Axis(0))
            .into_par_iter()
            .enumerate()
            .for_each_init(room, |room, (s, mut spectra)| {
                let start = s * self.hop;
                let segment = values.slice(s![start..start + length, ..]);
                match self.assembled_columns(&spectra) {
                    Some(together) if stream => self.assembled(segment, spectra, together, room),
                    _ => self.segment(segment, &mut spectra, stream, room),
                }
            });
    }

    /// Bytes of working space that a thread needs at most beside those of columns, for segments of
    /// `length` samples of so many columns, whose spectra start with a cache line.
    pub fn assembled_bytes(length: usize, columns: usize) -> u64 {
        let (row, bins) = (columns * size_of::<Complex<T>>(), length / 2 + 1);
        let together = match row.is_multiple_of(LINE) {
            true => None,
            false => columns_assembled::<T>(bins, ColumnTransform::<T>::width_of(length), columns),
        };
        (together.unwrap_or(0) * bins * size_of::<Complex<T>>()) as u64
    }

    /// How many columns are assembled together. `None` where rows of spectra are whole cache lines,
    /// which the transform itself writes past the caches, or are no rows.
    fn assembled_columns(&self, spectra: &ArrayViewMut2<Complex<T>>) -> Option<usize> {
        let [row, column] = *spectra.strides() else {
            return None;
        };
        let row = row.unsigned_abs() * size_of::<Complex<T>>();
        let is_whole = row.is_multiple_of(LINE) && spectra.as_ptr().addr().is_multiple_of(LINE);
        match column {
            1 if !is_whole => {
                columns_assembled::<T>(self.bins(), self.plan.width(), spectra.ncols())
            }
            _ => None,
        }
    }

    /// One segment, so many columns after the other, assembled in the caches first.
    fn assembled(
        &self,
        segment: ArrayView2<T>,
        mut spectra: ArrayViewMut2<Complex<T>>,
        together: usize,
        room: &mut Room<T>,
    ) {
        let mut assembled = std::mem::take(&mut room.assembled);
        assembled.resize(self.bins() * together, Complex::default());
        let stripes = spectra.axis_chunks_iter_mut(Axis(1), together);
        for (segment, mut spectra) in segment.axis_chunks_iter(Axis(1), together).zip(stripes) {
            let assembled = &mut assembled[..self.bins() * segment.ncols()];
            // The shape is the buffer's own, so this cannot fail.
            if let Ok(mut assembled) = ArrayViewMut2::from_shape(spectra.dim(), &mut *assembled) {
                self.segment(segment, &mut assembled, false, room);
            }
            match spectra.as_slice_mut() {
                Some(spectra) => copy_streaming(std::iter::once((&*assembled, spectra))),
                None => {
                    let rows = spectra.outer_iter_mut();
                    let rows = rows.map(|row| row.into_slice().expect("neighbouring columns"));
                    copy_streaming(assembled.chunks_exact(segment.ncols()).zip(rows));
                }
            }
        }
        room.assembled = assembled;
    }

    /// One segment, weighed as it is read, or before.
    fn segment(
        &self,
        segment: ArrayView2<T>,
        spectra: &mut ArrayViewMut2<Complex<T>>,
        stream: bool,
        room: &mut Room<T>,
    ) {
        let Room {
            weighed, scratch, ..
        } = room;
        if self.plan.windows_in_passing() {
            self.plan
                .stripe(segment, &self.window, spectra, stream, scratch);
            return;
        }
        let together = TOGETHER * self.plan.width();
        let stripes = spectra.axis_chunks_iter_mut(Axis(1), together);
        for (segment, mut spectra) in segment.axis_chunks_iter(Axis(1), together).zip(stripes) {
            weighed.resize(segment.len(), T::zero());
            self.weigh(segment, weighed);
            // The shape is the buffer's own, so this cannot fail.
            if let Ok(weighed) = ArrayView2::from_shape(segment.dim(), &*weighed) {
                self.plan
                    .stripe(weighed, &[], &mut spectra, stream, scratch);
            }
        }
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
