//! Spectra of all columns back to the columns.

use std::sync::Arc;

use num_complex::Complex;

use crate::columns::{check_input, check_output, check_scratch};
use crate::{Columns, ColumnsMut, FftError, Real, RealToComplexColumns};

/// The transform of spectra back to real columns: `v_n = sum_m X_m exp(2 pi i m n / N)` over all m of both
/// signs, unnormalised; [`ComplexToRealColumns::normalized`] divides by N.
///
/// The sum is a Hartley transform, which is its own inverse: with the real numbers
/// `h_m = Re X_m - Im X_m`, `m = 0 .. N`, and their transform H, `v_n = Re H_n - Im H_n`. So every
/// length is transformed back by the kernels of [`RealToComplexColumns`].
///
/// # Shapes
/// The input is `(N / 2 + 1, columns)`, the output `(N, columns)`. Imaginary parts of bins 0 and, for even N,
/// N / 2 are ignored. Input and output may have any strides; tiles of columns are copied.
///
/// # Errors
/// A column there and back returns to about twice [`RealToComplexColumns::expected_error`]. Its bits depend
/// neither on other columns nor on the number of threads.
///
/// Source: R. N. Bracewell, "Discrete Hartley transform", J. Opt. Soc. Am. 73, 1832 (1983).
pub struct ComplexToRealColumns<T: Real> {
    plan: Arc<RealToComplexColumns<T>>,
    /// Of all results.
    factor: T,
    #[cfg(feature = "rayon")]
    pool: crate::pool::Pool<Complex<T>>,
}

#[allow(clippy::len_without_is_empty)]
impl<T: Real> ComplexToRealColumns<T> {
    /// Plans transforms to columns of `len` samples for this processor.
    ///
    /// # Errors
    /// [`FftError::Zero`] for length 0.
    pub fn new(len: usize) -> Result<Self, FftError> {
        RealToComplexColumns::new(len).map(|plan| Self::of(Arc::new(plan)))
    }

    /// The inverse of a plan, whose tables it shares.
    pub fn of(plan: Arc<RealToComplexColumns<T>>) -> Self {
        ComplexToRealColumns {
            plan,
            factor: T::one(),
            #[cfg(feature = "rayon")]
            pool: crate::pool::Pool::default(),
        }
    }

    /// The same with all results times `1 / N`, so that it undoes the transform.
    pub fn normalized(self) -> Self {
        ComplexToRealColumns {
            factor: T::rounded(1.0 / self.plan.len() as f64),
            ..self
        }
    }

    /// Length N of the columns.
    pub fn len(&self) -> usize {
        self.plan.len()
    }

    /// Rows of the input, `N / 2 + 1`.
    pub fn bins(&self) -> usize {
        self.plan.bins()
    }

    /// Complex numbers of a tile's sums, and of their transforms.
    fn parts(len: usize, width: usize) -> [usize; 2] {
        [(width * len).div_ceil(2), width * (len / 2 + 1)]
    }

    /// Complex numbers of scratch, for any number of columns and any strides.
    pub fn scratch_len(&self) -> usize {
        let width = self.plan.width();
        let [sums, transforms] = Self::parts(self.len(), width);
        let layout = crate::columns::Layout::of_rows(width * size_of::<T>());
        sums + transforms + self.plan.scratch_len_in(width, layout)
    }

    /// The same of any plan of length `len` for this processor; known before there is a plan. 0 for length 0.
    pub fn scratch_len_of(len: usize) -> usize {
        if len == 0 {
            return 0;
        }
        let width = RealToComplexColumns::<T>::width_of(len);
        let [sums, transforms] = Self::parts(len, width);
        sums + transforms + RealToComplexColumns::<T>::scratch_len_of(len, width, width)
    }

    /// Scratch for any number of columns.
    pub fn make_scratch(&self) -> Vec<Complex<T>> {
        vec![Complex::default(); self.scratch_len()]
    }

    /// Transforms all columns of `input` to `output`.
    ///
    /// # Errors
    /// [`FftError::Input`] and [`FftError::Output`] for shapes other than the plan's.
    pub fn process<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, Complex<T>>>,
        output: impl Into<ColumnsMut<'o, T>>,
    ) -> Result<(), FftError> {
        self.process_with_scratch(input, output, &mut self.make_scratch())
    }

    /// The same without allocation.
    ///
    /// # Errors
    /// As [`ComplexToRealColumns::process`]; [`FftError::Scratch`] for scratch shorter than
    /// [`ComplexToRealColumns::scratch_len`].
    pub fn process_with_scratch<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, Complex<T>>>,
        output: impl Into<ColumnsMut<'o, T>>,
        scratch: &mut [Complex<T>],
    ) -> Result<(), FftError> {
        let (input, output) = (input.into(), output.into());
        self.check(&input, &output)?;
        check_scratch(self.scratch_len(), scratch)?;
        self.stripe(input, output, scratch);
        Ok(())
    }

    /// The same by all threads of the current rayon pool, with the same bits. Scratch is kept in the plan and
    /// used again.
    ///
    /// # Errors
    /// As [`ComplexToRealColumns::process`].
    #[cfg(feature = "rayon")]
    pub fn process_in_parallel<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, Complex<T>>>,
        output: impl Into<ColumnsMut<'o, T>>,
    ) -> Result<(), FftError> {
        use rayon::prelude::*;

        let (input, output) = (input.into(), output.into());
        self.check(&input, &output)?;
        let width = self.plan.width();
        let tiles = input.columns().div_ceil(width);
        let stripe = tiles.div_ceil(4 * rayon::current_num_threads()).max(1) * width;
        let needed = self.scratch_len();
        let stripes: Vec<_> = input.parts(stripe).zip(output.parts(stripe)).collect();
        stripes.into_par_iter().for_each(|(spectra, values)| {
            self.stripe(spectra, values, &mut self.pool.take(needed));
        });
        Ok(())
    }

    fn check(&self, input: &Columns<Complex<T>>, output: &ColumnsMut<T>) -> Result<(), FftError> {
        check_input((self.bins(), input.columns()), input.dim())?;
        check_output((self.len(), input.columns()), output.dim())
    }

    /// Some columns, tile by tile.
    fn stripe(
        &self,
        spectra: Columns<Complex<T>>,
        values: ColumnsMut<T>,
        scratch: &mut [Complex<T>],
    ) {
        let width = self.plan.width();
        for (spectra, values) in spectra.parts(width).zip(values.parts(width)) {
            self.tile(spectra, values, scratch);
        }
    }

    /// At most a tile's width of columns; the places of others hold what they held before, which
    /// does not matter.
    fn tile(
        &self,
        spectra: Columns<Complex<T>>,
        mut values: ColumnsMut<T>,
        scratch: &mut [Complex<T>],
    ) {
        let (length, width) = (self.len(), self.plan.width());
        let [sums, transforms] = Self::parts(length, width);
        let (sums, rest) = scratch.split_at_mut(sums);
        let (transforms, scratch) = rest.split_at_mut(transforms);
        let sums: &mut [T] = bytemuck::cast_slice_mut(sums);
        for m in 0..self.bins() {
            let mirror = (length - m) % length;
            let mut put = |c: usize, x: Complex<T>| {
                // Not a product with 0, which would let infinities through.
                let im = if mirror == m { T::zero() } else { x.im };
                sums[m * width + c] = x.re - im;
                sums[mirror * width + c] = x.re + im;
            };
            match spectra.row_slice(m) {
                Some(row) => row.iter().enumerate().for_each(|(c, &x)| put(c, x)),
                None => (0..spectra.columns()).for_each(|c| put(c, spectra.at(m, c))),
            }
        }
        // The shapes are the plan's, so these cannot fail.
        if let Ok(sums) = Columns::new(sums, length, width, width)
            && let Ok(mut transforms) = ColumnsMut::new(transforms, self.bins(), width, width)
        {
            let stream = self.plan.streams(width);
            self.plan
                .stripe(sums, &[], &mut transforms, stream, scratch);
        }
        for (n, row) in transforms.chunks_exact(width).enumerate() {
            put_row(&mut values, n, row, |x| (x.re - x.im) * self.factor);
            if n > 0 {
                put_row(&mut values, length - n, row, |x| {
                    (x.re + x.im) * self.factor
                });
            }
        }
    }
}

/// Row n of the first columns of `row`.
#[inline(always)]
fn put_row<T: Real>(
    values: &mut ColumnsMut<T>,
    n: usize,
    row: &[Complex<T>],
    value: impl Fn(Complex<T>) -> T,
) {
    match values.row_slice_mut(n) {
        Some(to) => to.iter_mut().zip(row).for_each(|(to, &x)| *to = value(x)),
        None => {
            for (c, &x) in row.iter().enumerate().take(values.columns()) {
                values.set(n, c, value(x));
            }
        }
    }
}

impl<T: Real> std::fmt::Debug for ComplexToRealColumns<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ComplexToRealColumns")
            .field("len", &self.len())
            .field("factor", &self.factor)
            .finish_non_exhaustive()
    }
}
