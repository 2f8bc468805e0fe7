//! Spectra of overlapping segments of all columns.

use std::sync::Arc;

use num_complex::Complex;

use crate::columns::{LINE, Layout, check_output, check_scratch, copy_streaming};
use crate::{Columns, ColumnsMut, FftError, Real, RealToComplexColumns, SegmentsMut};

/// The short-time transform of all columns: `X_sm = sum_n w_n v_{s h + n} exp(-2 pi i m n / L)`,
/// `m = 0 ..= L / 2`, of segments of L samples with window w, a hop h apart, unnormalised.
///
/// # Shapes
/// The input is `(times, columns)`, the output `(segments, L / 2 + 1, columns)`. Rows of the output that are whole
/// cache lines are the fastest; large results in other rows are assembled in up to a megabyte of scratch a thread.
///
/// # Errors
/// Those of [`RealToComplexColumns::expected_error`] at L. Bits do not depend on the number of threads; those of a
/// segment are those of a windowed copy.
///
/// Source: J. B. Allen, "Short term spectral analysis, synthesis, and modification by discrete Fourier transform",
/// IEEE Trans. Acoust. Speech Signal Process. 25, 235 (1977).
pub struct ShortTimeColumns<T: Real> {
    window: Vec<T>,
    hop: usize,
    plan: Arc<RealToComplexColumns<T>>,
}

/// Columns that are windowed together: a few tiles, which L2 holds.
const TOGETHER: usize = 4;

/// Bytes of spectra of a segment that are assembled in the caches before they are copied by streaming stores.
const ASSEMBLED_BYTES: usize = 1 << 20;

/// Bytes of a row from which on pieces of rows are worth it: lines at their ends are shared.
const LEAST_PIECE: usize = 2048;

/// All columns if their spectra fit, else as many whole tiles as do, if that makes long pieces of rows.
fn columns_assembled<T: Real>(bins: usize, width: usize, columns: usize) -> Option<usize> {
    let fit = ASSEMBLED_BYTES / (size_of::<Complex<T>>() * bins);
    if fit >= columns {
        return (columns > 0).then_some(columns);
    }
    let together = fit / width * width;
    (together * size_of::<Complex<T>>() >= LEAST_PIECE).then_some(together)
}

/// Complex numbers of scratch.
#[derive(Debug, Clone, Copy)]
struct Parts {
    /// Columns that are windowed before they are transformed.
    windowed: usize,
    /// Spectra to be copied by streaming stores.
    assembled: usize,
    plan: usize,
}

impl Parts {
    fn len(self) -> usize {
        self.windowed + self.assembled + self.plan
    }
}

impl<T: Real> ShortTimeColumns<T> {
    /// Plans transforms of segments of `window.len()` samples, `hop` samples apart.
    ///
    /// # Errors
    /// [`FftError::Zero`] for a window without samples or hop 0.
    pub fn new(window: &[f64], hop: usize) -> Result<Self, FftError> {
        let plan = RealToComplexColumns::new(window.len())?;
        Self::of(Arc::new(plan), window, hop)
    }

    /// The same with a plan of the window's length, whose tables it shares.
    pub(crate) fn of(
        plan: Arc<RealToComplexColumns<T>>,
        window: &[f64],
        hop: usize,
    ) -> Result<Self, FftError> {
        match hop {
            0 => Err(FftError::Zero { what: "the hop" }),
            _ => Ok(ShortTimeColumns {
                window: window.iter().map(|&w| T::rounded(w)).collect(),
                hop,
                plan,
            }),
        }
    }

    /// Length L of a segment.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.window.len()
    }

    /// Samples from one segment to the next.
    pub fn hop(&self) -> usize {
        self.hop
    }

    /// Whole segments in columns of `times` samples.
    pub fn segments(&self, times: usize) -> usize {
        match times.checked_sub(self.window.len()) {
            Some(rest) => rest / self.hop + 1,
            None => 0,
        }
    }

    /// Rows of a segment's spectra, `L / 2 + 1`.
    pub fn bins(&self) -> usize {
        self.plan.bins()
    }

    /// Complex numbers of scratch for `columns` columns of arrays of any strides.
    pub fn scratch_len(&self, columns: usize) -> usize {
        let assembled = columns_assembled::<T>(self.bins(), self.plan.width(), columns);
        self.windowed_len(columns)
            + assembled.unwrap_or(0) * self.bins()
            + self.plan.scratch_len(columns)
    }

    /// Complex numbers of scratch that a plan of segments of `len` samples for this processor needs, for `columns`
    /// neighbouring columns in rows `row_stride` numbers apart and spectra without gaps; known before there is
    /// a plan. 0 for length 0.
    pub fn scratch_len_of(len: usize, columns: usize, row_stride: usize) -> usize {
        if len == 0 {
            return 0;
        }
        let width = RealToComplexColumns::<T>::width_of(len);
        let bins = len / 2 + 1;
        let is_whole = (columns * size_of::<Complex<T>>()).is_multiple_of(LINE);
        let assembled = match is_whole {
            true => None,
            false => columns_assembled::<T>(bins, width, columns),
        };
        let windowed = match crate::columns::windows_in_passing(len) {
            true => 0,
            false => (len * columns.min(TOGETHER * width)).div_ceil(2),
        };
        let plan = RealToComplexColumns::<T>::scratch_len_of(len, columns, row_stride);
        windowed + assembled.unwrap_or(0) * bins + plan
    }

    /// Scratch for `columns` columns of arrays of any strides.
    pub fn make_scratch(&self, columns: usize) -> Vec<Complex<T>> {
        vec![Complex::default(); self.scratch_len(columns)]
    }

    fn windowed_len(&self, columns: usize) -> usize {
        match self.plan.windows_in_passing() {
            true => 0,
            false => (self.len() * columns.min(TOGETHER * self.plan.width())).div_ceil(2),
        }
    }

    /// Scratch for these arrays.
    fn parts(&self, input: &Columns<T>, output: &SegmentsMut<Complex<T>>, stream: bool) -> Parts {
        let columns = input.columns();
        let is_whole = output.strides()[..2]
            .iter()
            .all(|stride| (stride.unsigned_abs() * size_of::<Complex<T>>()).is_multiple_of(LINE));
        let assembled = match stream && !(is_whole && output.as_ptr().addr().is_multiple_of(LINE)) {
            true => columns_assembled::<T>(self.bins(), self.plan.width(), columns),
            false => None,
        };
        let [_, row, column] = output.strides();
        let layout = match column == 1 && row >= 0 {
            true => Layout::of_input(input),
            false => Layout::Strided,
        };
        Parts {
            windowed: self.windowed_len(columns),
            assembled: assembled.unwrap_or(0) * self.bins(),
            plan: self.plan.scratch_len_in(columns, layout),
        }
    }

    /// Transforms all segments of all columns of `input` to `output`.
    ///
    /// # Errors
    /// [`FftError::Output`] for shapes other than the plan's, with segments times bins as rows.
    pub fn process<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, T>>,
        output: impl Into<SegmentsMut<'o, Complex<T>>>,
    ) -> Result<(), FftError> {
        let input = input.into();
        let mut scratch = self.make_scratch(input.columns());
        self.process_with_scratch(input, output, &mut scratch)
    }

    /// The same without allocation.
    ///
    /// # Errors
    /// As [`ShortTimeColumns::process`]; [`FftError::Scratch`] for scratch that is too short for these arrays, which
    /// [`ShortTimeColumns::scratch_len`] never is.
    pub fn process_with_scratch<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, T>>,
        output: impl Into<SegmentsMut<'o, Complex<T>>>,
        scratch: &mut [Complex<T>],
    ) -> Result<(), FftError> {
        let (input, output) = (input.into(), output.into());
        let stream = self.check(&input, &output)?;
        let parts = self.parts(&input, &output, stream);
        check_scratch(parts.len(), scratch)?;
        for (s, spectra) in output.each().enumerate() {
            self.one(input, (s, spectra), stream, (parts, &mut *scratch));
        }
        Ok(())
    }

    /// The same by all threads of the current rayon pool, with the same bits.
    ///
    /// # Errors
    /// As [`ShortTimeColumns::process`].
    #[cfg(feature = "rayon")]
    pub fn process_in_parallel<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, T>>,
        output: impl Into<SegmentsMut<'o, Complex<T>>>,
    ) -> Result<(), FftError> {
        use rayon::prelude::*;

        let (input, output) = (input.into(), output.into());
        let stream = self.check(&input, &output)?;
        let parts = self.parts(&input, &output, stream);
        let segments: Vec<_> = output.each().enumerate().collect();
        segments.into_par_iter().for_each_init(
            || vec![Complex::default(); parts.len()],
            |scratch, segment| self.one(input, segment, stream, (parts, scratch)),
        );
        Ok(())
    }

    /// Whether stores are streaming.
    fn check(
        &self,
        input: &Columns<T>,
        output: &SegmentsMut<Complex<T>>,
    ) -> Result<bool, FftError> {
        let (times, columns) = input.dim();
        let segments = self.segments(times);
        check_output(
            (segments * self.bins(), columns),
            (output.segments() * output.bins(), output.columns()),
        )?;
        check_output((self.bins(), columns), (output.bins(), columns))?;
        Ok(self.plan.streams(columns * segments))
    }

    /// Segment s.
    fn one(
        &self,
        input: Columns<T>,
        (s, mut spectra): (usize, ColumnsMut<Complex<T>>),
        stream: bool,
        (parts, scratch): (Parts, &mut [Complex<T>]),
    ) {
        let segment = input.row_range(s * self.hop, self.len());
        let (windowed, rest) = scratch.split_at_mut(parts.windowed);
        let (assembled, scratch) = rest.split_at_mut(parts.assembled);
        match self.columns_assembled(&spectra) {
            Some(together) if stream => {
                self.assembled(segment, spectra, together, [windowed, assembled, scratch]);
            }
            _ => self.segment(segment, &mut spectra, stream, (windowed, scratch)),
        }
    }

    /// How many columns are assembled together. `None` where rows of spectra are whole cache lines,
    /// which the transform itself stores streaming, or are no rows.
    fn columns_assembled(&self, spectra: &ColumnsMut<Complex<T>>) -> Option<usize> {
        let [row, column] = spectra.strides();
        let row = row.unsigned_abs() * size_of::<Complex<T>>();
        let is_whole = row.is_multiple_of(LINE) && spectra.as_ptr().addr().is_multiple_of(LINE);
        match column {
            1 if !is_whole => {
                columns_assembled::<T>(self.bins(), self.plan.width(), spectra.columns())
            }
            _ => None,
        }
    }

    /// One segment, `together` columns after the other, assembled in the caches first.
    fn assembled(
        &self,
        segment: Columns<T>,
        spectra: ColumnsMut<Complex<T>>,
        together: usize,
        [windowed, assembled, scratch]: [&mut [Complex<T>]; 3],
    ) {
        for (segment, mut spectra) in segment.parts(together).zip(spectra.parts(together)) {
            let columns = segment.columns();
            let assembled = &mut assembled[..self.bins() * columns];
            // The shape is the buffer's own, so this cannot fail.
            if let Ok(mut assembled) = ColumnsMut::new(assembled, self.bins(), columns, columns) {
                self.segment(
                    segment,
                    &mut assembled,
                    false,
                    (&mut *windowed, &mut *scratch),
                );
            }
            match spectra.as_slice_mut() {
                Some(spectra) => copy_streaming(std::iter::once((&*assembled, spectra))),
                None => {
                    let rows = spectra.single_rows().map(ColumnsMut::into_row);
                    copy_streaming(assembled.chunks_exact(columns).zip(rows));
                }
            }
        }
    }

    /// One segment, windowed as it is read, or before.
    fn segment(
        &self,
        segment: Columns<T>,
        spectra: &mut ColumnsMut<Complex<T>>,
        stream: bool,
        (windowed, scratch): (&mut [Complex<T>], &mut [Complex<T>]),
    ) {
        if self.plan.windows_in_passing() {
            self.plan
                .stripe(segment, &self.window, spectra, stream, scratch);
            return;
        }
        let windowed: &mut [T] = bytemuck::cast_slice_mut(windowed);
        let together = TOGETHER * self.plan.width();
        let stripes = spectra.reborrow().parts(together);
        for (segment, mut spectra) in segment.parts(together).zip(stripes) {
            let columns = segment.columns();
            let windowed = &mut windowed[..self.len() * columns];
            self.apply_window(segment, windowed);
            // The shape is the buffer's own, so this cannot fail.
            if let Ok(windowed) = Columns::new(windowed, self.len(), columns, columns) {
                self.plan
                    .stripe(windowed, &[], &mut spectra, stream, scratch);
            }
        }
    }

    fn apply_window(&self, segment: Columns<T>, windowed: &mut [T]) {
        let rows = windowed.chunks_exact_mut(segment.columns());
        for (n, (to, &factor)) in rows.zip(&self.window).enumerate() {
            match segment.row_slice(n) {
                Some(row) => to.iter_mut().zip(row).for_each(|(to, &v)| *to = v * factor),
                None => {
                    for (c, to) in to.iter_mut().enumerate() {
                        *to = segment.at(n, c) * factor;
                    }
                }
            }
        }
    }
}

impl<T: Real> std::fmt::Debug for ShortTimeColumns<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ShortTimeColumns")
            .field("len", &self.len())
            .field("hop", &self.hop)
            .finish_non_exhaustive()
    }
}
