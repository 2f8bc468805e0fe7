//! Views of arrays: rows and columns at strides of their own.

use std::fmt;
use std::marker::PhantomData;

use num_complex::Complex;

use crate::FftError;

/// An array to be read: rows are samples of time, columns are series. Element `(n, c)` is number
/// `n row_stride + c column_stride` of the slice.
pub struct Columns<'a, T> {
    start: *const T,
    shape: [usize; 2],
    strides: [isize; 2],
    of: PhantomData<&'a [T]>,
}

/// An array to be written, laid out as [`Columns`].
pub struct ColumnsMut<'a, T> {
    start: *mut T,
    shape: [usize; 2],
    strides: [isize; 2],
    of: PhantomData<&'a mut [T]>,
}

/// Spectra of segments to be written: element `(s, m, c)` is bin m of segment s of column c.
pub struct SegmentsMut<'a, T> {
    start: *mut T,
    shape: [usize; 3],
    strides: [isize; 3],
    of: PhantomData<&'a mut [T]>,
}

// SAFETY: a view is as much as the slice that it borrows.
unsafe impl<T: Sync> Send for Columns<'_, T> {}
// SAFETY: as above.
unsafe impl<T: Sync> Sync for Columns<'_, T> {}
// SAFETY: no two views of a kind to be written share an element.
unsafe impl<T: Send> Send for ColumnsMut<'_, T> {}
// SAFETY: a shared reference to the view only tells its shape.
unsafe impl<T: Sync> Sync for ColumnsMut<'_, T> {}
// SAFETY: as for `ColumnsMut`.
unsafe impl<T: Send> Send for SegmentsMut<'_, T> {}
// SAFETY: as for `ColumnsMut`.
unsafe impl<T: Sync> Sync for SegmentsMut<'_, T> {}

impl<T> Clone for Columns<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for Columns<'_, T> {}

/// Elements that an array spans; `None` beyond what can be counted.
fn span<const D: usize>(shape: [usize; D], strides: [usize; D]) -> Option<usize> {
    if shape.contains(&0) {
        return Some(0);
    }
    let axes = shape.iter().zip(strides);
    let last = axes
        .map(|(count, stride)| (count - 1).checked_mul(stride))
        .try_fold(0_usize, |sum, part| sum.checked_add(part?))?;
    last.checked_add(1)
}

/// Whether a slice of `found` elements holds an array.
fn check_span<const D: usize>(
    shape: [usize; D],
    strides: [usize; D],
    found: usize,
) -> Result<(), FftError> {
    let needed = span(shape, strides).unwrap_or(usize::MAX);
    match needed <= found {
        true => Ok(()),
        false => Err(FftError::Slice { needed, found }),
    }
}

/// Whether all elements have places of their own: each axis, in order of strides, steps over all that the
/// shorter ones span.
fn check_apart<const D: usize>(shape: [usize; D], strides: [usize; D]) -> Result<(), FftError> {
    if shape.contains(&0) {
        return Ok(());
    }
    let mut axes: Vec<(usize, usize)> = strides.into_iter().zip(shape).collect();
    axes.retain(|&(_, count)| count > 1);
    axes.sort_unstable();
    let mut covered = 0;
    for (stride, count) in axes {
        if stride <= covered {
            return Err(FftError::Overlap);
        }
        // No overflow: the array lies within a slice.
        covered += stride * (count - 1);
    }
    Ok(())
}

/// Strides of arrays within a slice are below `isize::MAX`, but for those of axes with one element, which
/// do not matter.
fn signed<const D: usize>(strides: [usize; D]) -> [isize; D] {
    strides.map(|stride| isize::try_from(stride).unwrap_or(0))
}

impl<'a, T> Columns<'a, T> {
    /// `rows` rows of `columns` neighbouring elements, `row_stride` elements from row to row. Rows may
    /// overlap.
    ///
    /// # Errors
    /// [`FftError::Slice`] where the slice ends before the last element.
    pub fn new(
        slice: &'a [T],
        rows: usize,
        columns: usize,
        row_stride: usize,
    ) -> Result<Self, FftError> {
        Self::with_strides(slice, [rows, columns], [row_stride, 1])
    }

    /// `shape` is `[rows, columns]`, `strides` are those from row to row and from column to column, in
    /// elements.
    ///
    /// # Errors
    /// As [`Columns::new`].
    pub fn with_strides(
        slice: &'a [T],
        shape: [usize; 2],
        strides: [usize; 2],
    ) -> Result<Self, FftError> {
        check_span(shape, strides, slice.len())?;
        Ok(Columns {
            start: slice.as_ptr(),
            shape,
            strides: signed(strides),
            of: PhantomData,
        })
    }

    /// Rows, the samples of a column.
    pub fn rows(&self) -> usize {
        self.shape[0]
    }

    /// Columns.
    pub fn columns(&self) -> usize {
        self.shape[1]
    }

    /// `(rows, columns)`.
    pub(crate) fn dim(&self) -> (usize, usize) {
        (self.shape[0], self.shape[1])
    }

    pub(crate) fn strides(&self) -> [isize; 2] {
        self.strides
    }

    pub(crate) fn as_ptr(&self) -> *const T {
        self.start
    }

    /// `count` columns from number `first` on.
    pub(crate) fn part(&self, first: usize, count: usize) -> Self {
        assert!(first + count <= self.shape[1]);
        Columns {
            start: self.start.wrapping_offset(first as isize * self.strides[1]),
            shape: [self.shape[0], count],
            ..*self
        }
    }

    /// `count` rows from number `first` on.
    pub(crate) fn row_range(&self, first: usize, count: usize) -> Self {
        assert!(first + count <= self.shape[0]);
        Columns {
            start: self.start.wrapping_offset(first as isize * self.strides[0]),
            shape: [count, self.shape[1]],
            ..*self
        }
    }

    /// Parts of `width` columns, the last one of fewer.
    pub(crate) fn parts(self, width: usize) -> impl Iterator<Item = Self> {
        let columns = self.shape[1];
        (0..columns)
            .step_by(width)
            .map(move |first| self.part(first, width.min(columns - first)))
    }

    /// Row n where its elements are neighbours.
    #[inline]
    pub(crate) fn row_slice(&self, n: usize) -> Option<&'a [T]> {
        assert!(n < self.shape[0]);
        if self.strides[1] != 1 && self.shape[1] > 1 {
            return None;
        }
        let start = self.start.wrapping_offset(n as isize * self.strides[0]);
        // SAFETY: the row is within the slice that is borrowed.
        Some(unsafe { std::slice::from_raw_parts(start, self.shape[1]) })
    }
}

impl<T: Copy> Columns<'_, T> {
    #[inline]
    pub(crate) fn at(&self, n: usize, c: usize) -> T {
        assert!(n < self.shape[0] && c < self.shape[1]);
        let offset = n as isize * self.strides[0] + c as isize * self.strides[1];
        // SAFETY: the element is within the slice that is borrowed.
        unsafe { *self.start.wrapping_offset(offset) }
    }
}

impl<'a, T> Columns<'a, Complex<T>> {
    /// Real and imaginary parts as columns side by side; `None` where columns are not neighbours.
    pub(crate) fn as_reals(&self) -> Option<Columns<'a, T>> {
        let [rows, columns] = self.shape;
        let [row, column] = self.strides;
        if (column != 1 && columns > 1) || row < 0 {
            return None;
        }
        // A complex number is two numbers, the real part first.
        Some(Columns {
            start: self.start.cast(),
            shape: [rows, 2 * columns],
            strides: [2 * row, 1],
            of: PhantomData,
        })
    }
}

impl<'a, T> ColumnsMut<'a, T> {
    /// `rows` rows of `columns` neighbouring elements, `row_stride` elements from row to row.
    ///
    /// # Errors
    /// [`FftError::Slice`] where the slice ends before the last element, [`FftError::Overlap`] where
    /// rows do.
    pub fn new(
        slice: &'a mut [T],
        rows: usize,
        columns: usize,
        row_stride: usize,
    ) -> Result<Self, FftError> {
        Self::with_strides(slice, [rows, columns], [row_stride, 1])
    }

    /// `shape` is `[rows, columns]`, `strides` are those from row to row and from column to column, in
    /// elements.
    ///
    /// # Errors
    /// As [`ColumnsMut::new`].
    pub fn with_strides(
        slice: &'a mut [T],
        shape: [usize; 2],
        strides: [usize; 2],
    ) -> Result<Self, FftError> {
        check_span(shape, strides, slice.len())?;
        check_apart(shape, strides)?;
        Ok(ColumnsMut {
            start: slice.as_mut_ptr(),
            shape,
            strides: signed(strides),
            of: PhantomData,
        })
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.shape[0]
    }

    /// Columns.
    pub fn columns(&self) -> usize {
        self.shape[1]
    }

    /// The same array for a shorter time.
    pub fn reborrow(&mut self) -> ColumnsMut<'_, T> {
        ColumnsMut {
            start: self.start,
            shape: self.shape,
            strides: self.strides,
            of: PhantomData,
        }
    }

    /// The same array to be read.
    pub fn as_columns(&self) -> Columns<'_, T> {
        Columns {
            start: self.start,
            shape: self.shape,
            strides: self.strides,
            of: PhantomData,
        }
    }

    /// `(rows, columns)`.
    pub(crate) fn dim(&self) -> (usize, usize) {
        (self.shape[0], self.shape[1])
    }

    pub(crate) fn strides(&self) -> [isize; 2] {
        self.strides
    }

    pub(crate) fn as_mut_ptr(&mut self) -> *mut T {
        self.start
    }

    pub(crate) fn as_ptr(&self) -> *const T {
        self.start
    }

    /// Parts of `width` columns, the last one of fewer.
    pub(crate) fn parts(self, width: usize) -> impl Iterator<Item = ColumnsMut<'a, T>> {
        let [rows, columns] = self.shape;
        // Parts share no column, so that no element is in two.
        (0..columns).step_by(width).map(move |first| ColumnsMut {
            start: self.start.wrapping_offset(first as isize * self.strides[1]),
            shape: [rows, width.min(columns - first)],
            strides: self.strides,
            of: PhantomData,
        })
    }

    /// Each row by itself.
    pub(crate) fn single_rows(self) -> impl Iterator<Item = ColumnsMut<'a, T>> {
        let [rows, columns] = self.shape;
        (0..rows).map(move |n| ColumnsMut {
            start: self.start.wrapping_offset(n as isize * self.strides[0]),
            shape: [1, columns],
            strides: self.strides,
            of: PhantomData,
        })
    }

    /// Row n where its elements are neighbours.
    #[inline]
    pub(crate) fn row_slice_mut(&mut self, n: usize) -> Option<&mut [T]> {
        assert!(n < self.shape[0]);
        if self.strides[1] != 1 && self.shape[1] > 1 {
            return None;
        }
        let start = self.start.wrapping_offset(n as isize * self.strides[0]);
        // SAFETY: the row is within the slice that is borrowed, and no other view has it.
        Some(unsafe { std::slice::from_raw_parts_mut(start, self.shape[1]) })
    }

    /// The only row of an array, of neighbouring elements.
    ///
    /// # Panics
    /// If there are more, or its elements are not neighbours.
    pub(crate) fn into_row(self) -> &'a mut [T] {
        let [rows, columns] = self.shape;
        assert!(rows == 1 && (self.strides[1] == 1 || columns <= 1));
        // SAFETY: the row is within the slice that is borrowed, and no other view has it.
        unsafe { std::slice::from_raw_parts_mut(self.start, columns) }
    }

    /// The whole array where its elements are neighbours, row by row.
    pub(crate) fn as_slice_mut(&mut self) -> Option<&mut [T]> {
        let [rows, columns] = self.shape;
        let in_rows = columns <= 1 || self.strides[1] == 1;
        let in_a_piece = rows <= 1 || self.strides[0] == columns as isize;
        if !(in_rows && in_a_piece) {
            return None;
        }
        // SAFETY: as for `row_slice_mut`, of neighbouring rows.
        Some(unsafe { std::slice::from_raw_parts_mut(self.start, rows * columns) })
    }

    #[inline]
    pub(crate) fn set(&mut self, n: usize, c: usize, value: T)
    where
        T: Copy,
    {
        assert!(n < self.shape[0] && c < self.shape[1]);
        let offset = n as isize * self.strides[0] + c as isize * self.strides[1];
        // SAFETY: the element is within the slice that is borrowed, and no other view has it.
        unsafe { *self.start.wrapping_offset(offset) = value }
    }
}

impl<'a, T> SegmentsMut<'a, T> {
    /// Segments of `bins` rows of `columns` neighbouring elements, `row_stride` elements from row to row,
    /// one segment after the other.
    ///
    /// # Errors
    /// As [`ColumnsMut::new`].
    pub fn new(
        slice: &'a mut [T],
        segments: usize,
        bins: usize,
        columns: usize,
        row_stride: usize,
    ) -> Result<Self, FftError> {
        let Some(segment_stride) = bins.checked_mul(row_stride) else {
            return Err(FftError::Slice {
                needed: usize::MAX,
                found: slice.len(),
            });
        };
        let strides = [segment_stride, row_stride, 1];
        Self::with_strides(slice, [segments, bins, columns], strides)
    }

    /// `shape` is `[segments, bins, columns]`; `strides` in elements.
    ///
    /// # Errors
    /// As [`ColumnsMut::new`].
    pub fn with_strides(
        slice: &'a mut [T],
        shape: [usize; 3],
        strides: [usize; 3],
    ) -> Result<Self, FftError> {
        check_span(shape, strides, slice.len())?;
        check_apart(shape, strides)?;
        Ok(SegmentsMut {
            start: slice.as_mut_ptr(),
            shape,
            strides: signed(strides),
            of: PhantomData,
        })
    }

    /// Segments.
    pub fn segments(&self) -> usize {
        self.shape[0]
    }

    /// Rows of a segment.
    pub fn bins(&self) -> usize {
        self.shape[1]
    }

    /// Columns.
    pub fn columns(&self) -> usize {
        self.shape[2]
    }

    pub(crate) fn strides(&self) -> [isize; 3] {
        self.strides
    }

    pub(crate) fn as_ptr(&self) -> *const T {
        self.start
    }

    /// Each segment by itself.
    pub(crate) fn each(self) -> impl Iterator<Item = ColumnsMut<'a, T>> {
        let [segments, bins, columns] = self.shape;
        (0..segments).map(move |s| ColumnsMut {
            start: self.start.wrapping_offset(s as isize * self.strides[0]),
            shape: [bins, columns],
            strides: [self.strides[1], self.strides[2]],
            of: PhantomData,
        })
    }
}

#[cfg(feature = "ndarray")]
mod of_arrays {
    use ndarray::{ArrayView2, ArrayViewMut2, ArrayViewMut3};

    use super::*;

    /// Of any layout.
    impl<'a, T> From<ArrayView2<'a, T>> for Columns<'a, T> {
        fn from(view: ArrayView2<'a, T>) -> Self {
            let (rows, columns) = view.dim();
            let &[row, column] = view.strides() else {
                unreachable!("two axes")
            };
            Columns {
                start: view.as_ptr(),
                shape: [rows, columns],
                strides: [row, column],
                of: PhantomData,
            }
        }
    }

    /// Of any layout.
    impl<'a, T> From<ArrayViewMut2<'a, T>> for ColumnsMut<'a, T> {
        fn from(mut view: ArrayViewMut2<'a, T>) -> Self {
            let (rows, columns) = view.dim();
            let start = view.as_mut_ptr();
            let &[row, column] = view.strides() else {
                unreachable!("two axes")
            };
            ColumnsMut {
                start,
                shape: [rows, columns],
                strides: [row, column],
                of: PhantomData,
            }
        }
    }

    /// Of any layout.
    impl<'a, T> From<ArrayViewMut3<'a, T>> for SegmentsMut<'a, T> {
        fn from(mut view: ArrayViewMut3<'a, T>) -> Self {
            let (segments, bins, columns) = view.dim();
            let start = view.as_mut_ptr();
            let &[segment, row, column] = view.strides() else {
                unreachable!("three axes")
            };
            SegmentsMut {
                start,
                shape: [segments, bins, columns],
                strides: [segment, row, column],
                of: PhantomData,
            }
        }
    }
}

impl<T> fmt::Debug for Columns<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Columns")
            .field("shape", &self.shape)
            .field("strides", &self.strides)
            .finish_non_exhaustive()
    }
}

impl<T> fmt::Debug for ColumnsMut<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ColumnsMut")
            .field("shape", &self.shape)
            .field("strides", &self.strides)
            .finish_non_exhaustive()
    }
}

impl<T> fmt::Debug for SegmentsMut<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SegmentsMut")
            .field("shape", &self.shape)
            .field("strides", &self.strides)
            .finish_non_exhaustive()
    }
}
