//! Both axes of an array.

use std::sync::Arc;

use num_complex::Complex;
use rustfft::{Fft, FftDirection};

use crate::columns::{check_input, check_output, check_scratch};
use crate::{
    Columns, ColumnsMut, ComplexToRealColumns, FftError, Real, RealToComplexColumns, rows,
};

/// The transform of both axes of real arrays of one shape:
/// `X_mq = sum_nj v_nj exp(-2 pi i (m n / N +- q j / J))`, `m = 0 ..= N / 2`, `q = 0 .. J`, unnormalised. The second sign
/// is that of the direction along rows.
///
/// Columns are transformed by [`RealToComplexColumns`], rows by `rustfft`.
///
/// # Shapes
/// The input is `(N, J)`, the output `(N / 2 + 1, J)`, in the order of transforms: from `q = J / 2` on, q stands for
/// `q - J`.
///
/// # Errors
/// About those of both transforms, squared and added. Bits do not depend on the number of threads.
pub struct RealToComplex2d<T: Real> {
    columns: Arc<RealToComplexColumns<T>>,
    rows: Arc<dyn Fft<T>>,
}

/// The transform of spectra back to real arrays of one shape:
/// `v_nj = sum_mq X_mq exp(2 pi i (m n / N +- q j / J))` over all m of both signs, unnormalised; the second sign is the
/// opposite of that on the way there.
///
/// # Shapes
/// The input is `(N / 2 + 1, J)`, the output `(N, J)`. The input is overwritten.
///
/// # Errors
/// About those of both transforms, squared and added. Bits do not depend on the number of threads.
pub struct ComplexToReal2d<T: Real> {
    columns: ComplexToRealColumns<T>,
    rows: Arc<dyn Fft<T>>,
    /// Of rows.
    factor: Option<T>,
}

/// Filters of arrays of one shape: the transform of both axes, times gains, transformed back and normalised, so that
/// gains of 1 return the array to rounding.
///
/// The array is periodic along both axes: what leaves at one end enters at the other.
///
/// # Shapes
/// Input and output are `(N, J)`; gains are given row by row of `(N / 2 + 1, J)` bins.
///
/// # Errors
/// About twice those of [`RealToComplex2d`]. Bits do not depend on the number of threads.
#[derive(Debug)]
pub struct Filter2d<T: Real> {
    there: RealToComplex2d<T>,
    back: ComplexToReal2d<T>,
}

impl<T: Real> RealToComplex2d<T> {
    /// Plans transforms of arrays of `shape`, rows and columns, with kernels `exp(-i ..)` along columns and, by
    /// `along_rows`, `exp(-i ..)` ([`FftDirection::Forward`]) or `exp(+i ..)` along rows.
    ///
    /// # Errors
    /// [`FftError::Zero`] without rows or columns.
    pub fn new(shape: (usize, usize), along_rows: FftDirection) -> Result<Self, FftError> {
        let columns = RealToComplexColumns::new(shape.0)?;
        let rows = plan_rows(shape.1, along_rows)?;
        Ok(Self::of(Arc::new(columns), rows))
    }

    pub(crate) fn of(columns: Arc<RealToComplexColumns<T>>, rows: Arc<dyn Fft<T>>) -> Self {
        RealToComplex2d { columns, rows }
    }

    /// Rows and columns of the input.
    pub fn shape(&self) -> (usize, usize) {
        (self.columns.len(), self.rows.len())
    }

    /// Rows of the output, `N / 2 + 1`.
    pub fn bins(&self) -> usize {
        self.columns.bins()
    }

    /// Complex numbers of scratch for arrays of any strides.
    pub fn scratch_len(&self) -> usize {
        let columns = self.columns.scratch_len(self.rows.len());
        columns.max(row_scratch_len(&*self.rows))
    }

    /// Scratch for arrays of any strides.
    pub fn make_scratch(&self) -> Vec<Complex<T>> {
        vec![Complex::default(); self.scratch_len()]
    }

    /// Transforms `input` to `output`.
    ///
    /// # Errors
    /// [`FftError::Input`] and [`FftError::Output`] for shapes other than the plan's.
    pub fn process<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, T>>,
        output: impl Into<ColumnsMut<'o, Complex<T>>>,
    ) -> Result<(), FftError> {
        self.process_with_scratch(input, output, &mut self.make_scratch())
    }

    /// The same without allocation.
    ///
    /// # Errors
    /// As [`RealToComplex2d::process`]; [`FftError::Scratch`] for scratch shorter than
    /// [`RealToComplex2d::scratch_len`].
    pub fn process_with_scratch<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, T>>,
        output: impl Into<ColumnsMut<'o, Complex<T>>>,
        scratch: &mut [Complex<T>],
    ) -> Result<(), FftError> {
        self.process_and(input.into(), output.into(), scratch, |_, _| {})
    }

    /// The same; then `each` gets each row with its number, while it is in the cache.
    fn process_and(
        &self,
        input: Columns<T>,
        mut output: ColumnsMut<Complex<T>>,
        scratch: &mut [Complex<T>],
        each: impl Fn(usize, &mut [Complex<T>]),
    ) -> Result<(), FftError> {
        check_input(self.shape(), input.dim())?;
        check_scratch(self.scratch_len(), scratch)?;
        self.columns
            .process_with_scratch(input, output.reborrow(), scratch)?;
        each_row(&*self.rows, output, scratch, each);
        Ok(())
    }

    /// The same by all threads of the current rayon pool, with the same bits.
    ///
    /// # Errors
    /// As [`RealToComplex2d::process`].
    #[cfg(feature = "rayon")]
    pub fn process_in_parallel<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, T>>,
        output: impl Into<ColumnsMut<'o, Complex<T>>>,
    ) -> Result<(), FftError> {
        self.process_in_parallel_and(input.into(), output.into(), |_, _| {})
    }

    #[cfg(feature = "rayon")]
    fn process_in_parallel_and(
        &self,
        input: Columns<T>,
        mut output: ColumnsMut<Complex<T>>,
        each: impl Fn(usize, &mut [Complex<T>]) + Sync,
    ) -> Result<(), FftError> {
        check_input(self.shape(), input.dim())?;
        self.columns.process_in_parallel(input, output.reborrow())?;
        each_row_in_parallel(&*self.rows, output, each);
        Ok(())
    }
}

impl<T: Real> ComplexToReal2d<T> {
    /// Plans transforms back to arrays of `shape`, rows and columns, with kernels `exp(+i ..)` along columns and, by
    /// `along_rows`, `exp(-i ..)` ([`FftDirection::Forward`]) or `exp(+i ..)` along rows.
    ///
    /// # Errors
    /// [`FftError::Zero`] without rows or columns.
    pub fn new(shape: (usize, usize), along_rows: FftDirection) -> Result<Self, FftError> {
        let columns = ComplexToRealColumns::new(shape.0)?;
        Ok(Self::of(columns, plan_rows(shape.1, along_rows)?))
    }

    pub(crate) fn of(columns: ComplexToRealColumns<T>, rows: Arc<dyn Fft<T>>) -> Self {
        ComplexToReal2d {
            columns,
            rows,
            factor: None,
        }
    }

    /// The same with all results times `1 / (N J)`, so that it undoes the transform.
    pub fn normalized(self) -> Self {
        ComplexToReal2d {
            columns: self.columns.normalized(),
            factor: Some(T::rounded(1.0 / self.rows.len() as f64)),
            rows: self.rows,
        }
    }

    /// Rows and columns of the output.
    pub fn shape(&self) -> (usize, usize) {
        (self.columns.len(), self.rows.len())
    }

    /// Rows of the input, `N / 2 + 1`.
    pub fn bins(&self) -> usize {
        self.columns.bins()
    }

    /// Complex numbers of scratch for arrays of any strides.
    pub fn scratch_len(&self) -> usize {
        let columns = self.columns.scratch_len();
        columns.max(row_scratch_len(&*self.rows))
    }

    /// Scratch for arrays of any strides.
    pub fn make_scratch(&self) -> Vec<Complex<T>> {
        vec![Complex::default(); self.scratch_len()]
    }

    /// Transforms `input` to `output`.
    ///
    /// # Errors
    /// [`FftError::Input`] and [`FftError::Output`] for shapes other than the plan's.
    pub fn process<'i, 'o>(
        &self,
        input: impl Into<ColumnsMut<'i, Complex<T>>>,
        output: impl Into<ColumnsMut<'o, T>>,
    ) -> Result<(), FftError> {
        self.process_with_scratch(input, output, &mut self.make_scratch())
    }

    /// The same without allocation.
    ///
    /// # Errors
    /// As [`ComplexToReal2d::process`]; [`FftError::Scratch`] for scratch shorter than
    /// [`ComplexToReal2d::scratch_len`].
    pub fn process_with_scratch<'i, 'o>(
        &self,
        input: impl Into<ColumnsMut<'i, Complex<T>>>,
        output: impl Into<ColumnsMut<'o, T>>,
        scratch: &mut [Complex<T>],
    ) -> Result<(), FftError> {
        let (mut input, output) = (input.into(), output.into());
        self.check(&input, &output)?;
        check_scratch(self.scratch_len(), scratch)?;
        let scale = self.scale();
        each_row(&*self.rows, input.reborrow(), scratch, |_, row| scale(row));
        self.columns
            .process_with_scratch(input.as_columns(), output, scratch)
    }

    /// The same by all threads of the current rayon pool, with the same bits.
    ///
    /// # Errors
    /// As [`ComplexToReal2d::process`].
    #[cfg(feature = "rayon")]
    pub fn process_in_parallel<'i, 'o>(
        &self,
        input: impl Into<ColumnsMut<'i, Complex<T>>>,
        output: impl Into<ColumnsMut<'o, T>>,
    ) -> Result<(), FftError> {
        let (mut input, output) = (input.into(), output.into());
        self.check(&input, &output)?;
        let scale = self.scale();
        each_row_in_parallel(&*self.rows, input.reborrow(), |_, row| scale(row));
        self.columns.process_in_parallel(input.as_columns(), output)
    }

    /// Nothing was written before this is found.
    fn check(
        &self,
        input: &ColumnsMut<Complex<T>>,
        output: &ColumnsMut<T>,
    ) -> Result<(), FftError> {
        check_input((self.bins(), self.rows.len()), input.dim())?;
        check_output(self.shape(), output.dim())
    }

    fn scale(&self) -> impl Fn(&mut [Complex<T>]) + use<T> {
        let factor = self.factor;
        move |row| {
            if let Some(factor) = factor {
                row.iter_mut().for_each(|x| *x = x.scale(factor));
            }
        }
    }
}

impl<T: Real> Filter2d<T> {
    /// Plans filters of arrays of `shape`, rows and columns. Gains belong to kernels `exp(-i ..)` along columns and,
    /// by `along_rows`, `exp(-i ..)` ([`FftDirection::Forward`]) or `exp(+i ..)` along rows.
    ///
    /// # Errors
    /// [`FftError::Zero`] without rows or columns.
    pub fn new(shape: (usize, usize), along_rows: FftDirection) -> Result<Self, FftError> {
        let there = RealToComplex2d::new(shape, along_rows)?;
        let columns = ComplexToRealColumns::of(Arc::clone(&there.columns));
        let rows = plan_rows(shape.1, along_rows.opposite_direction())?;
        Ok(Filter2d {
            there,
            back: ComplexToReal2d::of(columns, rows).normalized(),
        })
    }

    /// Rows and columns of the arrays.
    pub fn shape(&self) -> (usize, usize) {
        self.there.shape()
    }

    /// Complex numbers of the spectrum.
    fn spectrum_len(&self) -> usize {
        self.there.bins() * self.shape().1
    }

    /// Complex numbers of scratch for arrays of any strides; the spectrum is among them.
    pub fn scratch_len(&self) -> usize {
        let work = self.there.scratch_len().max(self.back.scratch_len());
        self.spectrum_len() + work
    }

    /// Scratch for arrays of any strides.
    pub fn make_scratch(&self) -> Vec<Complex<T>> {
        vec![Complex::default(); self.scratch_len()]
    }

    /// Filters `input` to `output`: `gain` gets each row of the spectrum with its number, and multiplies its bins.
    ///
    /// # Errors
    /// [`FftError::Input`] and [`FftError::Output`] for shapes other than the plan's.
    pub fn process<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, T>>,
        output: impl Into<ColumnsMut<'o, T>>,
        gain: impl Fn(usize, &mut [Complex<T>]),
    ) -> Result<(), FftError> {
        self.process_with_scratch(input, output, gain, &mut self.make_scratch())
    }

    /// The same without allocation.
    ///
    /// # Errors
    /// As [`Filter2d::process`]; [`FftError::Scratch`] for scratch shorter than [`Filter2d::scratch_len`].
    pub fn process_with_scratch<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, T>>,
        output: impl Into<ColumnsMut<'o, T>>,
        gain: impl Fn(usize, &mut [Complex<T>]),
        scratch: &mut [Complex<T>],
    ) -> Result<(), FftError> {
        let (input, output) = (input.into(), output.into());
        check_output(self.shape(), output.dim())?;
        check_scratch(self.scratch_len(), scratch)?;
        let (spectrum, scratch) = scratch.split_at_mut(self.spectrum_len());
        let columns = self.shape().1;
        let mut spectrum = ColumnsMut::new(spectrum, self.there.bins(), columns, columns)?;
        self.there
            .process_and(input, spectrum.reborrow(), scratch, gain)?;
        self.back.process_with_scratch(spectrum, output, scratch)
    }

    /// The same by all threads of the current rayon pool, with the same bits.
    ///
    /// # Errors
    /// As [`Filter2d::process`].
    #[cfg(feature = "rayon")]
    pub fn process_in_parallel<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, T>>,
        output: impl Into<ColumnsMut<'o, T>>,
        gain: impl Fn(usize, &mut [Complex<T>]) + Sync,
    ) -> Result<(), FftError> {
        let (input, output) = (input.into(), output.into());
        check_output(self.shape(), output.dim())?;
        let columns = self.shape().1;
        let mut spectrum = vec![Complex::default(); self.spectrum_len()];
        let mut spectrum = ColumnsMut::new(&mut spectrum, self.there.bins(), columns, columns)?;
        self.there
            .process_in_parallel_and(input, spectrum.reborrow(), gain)?;
        self.back.process_in_parallel(spectrum, output)
    }

    /// The first of three steps by which arrays are filtered that do not fit into memory: transforms some columns of
    /// the array to those of its spectrum. By all threads of the current rayon pool; all three steps give the bits of
    /// [`Filter2d::process`], whatever the blocks.
    ///
    /// # Errors
    /// [`FftError::Input`] and [`FftError::Output`] for columns of other lengths than the plan's.
    #[cfg(feature = "rayon")]
    pub fn columns_to_spectrum<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, T>>,
        spectrum: impl Into<ColumnsMut<'o, Complex<T>>>,
    ) -> Result<(), FftError> {
        self.there.columns.process_in_parallel(input, spectrum)
    }

    /// The second step: transforms whole rows of the spectrum, from row `first` on, has `gain` multiply them, and
    /// transforms them back.
    ///
    /// # Errors
    /// [`FftError::Input`] for rows of another length than the plan's.
    #[cfg(feature = "rayon")]
    pub fn filter_rows<'i>(
        &self,
        first: usize,
        spectrum: impl Into<ColumnsMut<'i, Complex<T>>>,
        gain: impl Fn(usize, &mut [Complex<T>]) + Sync,
    ) -> Result<(), FftError> {
        let mut spectrum = spectrum.into();
        let rows = spectrum.dim().0;
        check_input((rows, self.shape().1), spectrum.dim())?;
        each_row_in_parallel(&*self.there.rows, spectrum.reborrow(), |m, row| {
            gain(first + m, row);
        });
        let scale = self.back.scale();
        each_row_in_parallel(&*self.back.rows, spectrum, |_, row| scale(row));
        Ok(())
    }

    /// The third step: transforms some columns of the spectrum back.
    ///
    /// # Errors
    /// [`FftError::Input`] and [`FftError::Output`] for columns of other lengths than the plan's.
    #[cfg(feature = "rayon")]
    pub fn columns_of_spectrum<'i, 'o>(
        &self,
        spectrum: impl Into<Columns<'i, Complex<T>>>,
        output: impl Into<ColumnsMut<'o, T>>,
    ) -> Result<(), FftError> {
        self.back.columns.process_in_parallel(spectrum, output)
    }
}

fn plan_rows<T: Real>(columns: usize, along: FftDirection) -> Result<Arc<dyn Fft<T>>, FftError> {
    match columns {
        0 => Err(FftError::Zero {
            what: "the number of columns",
        }),
        _ => Ok(rows::plan_fft_complex(columns, along)),
    }
}

/// Of a copy of a row, and of its transform.
fn row_scratch_len<T: Real>(plan: &dyn Fft<T>) -> usize {
    plan.len() + plan.get_inplace_scratch_len()
}

/// Transforms every row, and passes it on with its number.
fn each_row<T: Real>(
    plan: &dyn Fft<T>,
    rows: ColumnsMut<Complex<T>>,
    scratch: &mut [Complex<T>],
    each: impl Fn(usize, &mut [Complex<T>]),
) {
    for (m, row) in rows.single_rows().enumerate() {
        one_row(plan, (m, row), scratch, &each);
    }
}

#[cfg(feature = "rayon")]
fn each_row_in_parallel<T: Real>(
    plan: &dyn Fft<T>,
    rows: ColumnsMut<Complex<T>>,
    each: impl Fn(usize, &mut [Complex<T>]) + Sync,
) {
    use rayon::prelude::*;

    let rows: Vec<_> = rows.single_rows().enumerate().collect();
    rows.into_par_iter().for_each_init(
        || vec![Complex::default(); row_scratch_len(plan)],
        |scratch, row| one_row(plan, row, scratch, &each),
    );
}

fn one_row<T: Real>(
    plan: &dyn Fft<T>,
    (m, mut row): (usize, ColumnsMut<Complex<T>>),
    scratch: &mut [Complex<T>],
    each: &impl Fn(usize, &mut [Complex<T>]),
) {
    let (copy, scratch) = scratch.split_at_mut(plan.len());
    let scratch = &mut scratch[..plan.get_inplace_scratch_len()];
    if let Some(row) = row.row_slice_mut(0) {
        plan.process_with_scratch(row, scratch);
        each(m, row);
        return;
    }
    for (c, x) in copy.iter_mut().enumerate() {
        *x = row.as_columns().at(0, c);
    }
    plan.process_with_scratch(copy, scratch);
    each(m, copy);
    for (c, &x) in copy.iter().enumerate() {
        row.set(0, c, x);
    }
}

impl<T: Real> std::fmt::Debug for RealToComplex2d<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RealToComplex2d")
            .field("shape", &self.shape())
            .field("along_rows", &self.rows.fft_direction())
            .finish_non_exhaustive()
    }
}

impl<T: Real> std::fmt::Debug for ComplexToReal2d<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ComplexToReal2d")
            .field("shape", &self.shape())
            .field("along_rows", &self.rows.fft_direction())
            .finish_non_exhaustive()
    }
}
