//! Complex columns.

use std::sync::Arc;

use num_complex::Complex;
use rustfft::FftDirection;

use crate::columns::{Layout, check_input, check_output, check_scratch};
use crate::{Columns, ColumnsMut, FftError, Real, RealToComplexColumns};

/// The transform of all columns of complex arrays of one number of rows: `X_m = sum_n z_n exp(-+2 pi i m n / N)`,
/// `m = 0 .. N`, unnormalised; the sign is `-` for [`FftDirection::Forward`].
///
/// Real and imaginary parts are columns of their own of [`RealToComplexColumns`], so nothing leaks from one to the other:
/// with their transforms A and B, `X_m = A_m + i B_m` and `X_-m = conj(A_m) + i conj(B_m)`.
///
/// # Shapes
/// Input and output are `(N, columns)`, in the order of transforms: from `m = N / 2` on, m stands for `m - N`. Both may
/// have any strides.
///
/// # Errors
/// Those of [`RealToComplexColumns::expected_error`]. A column's bits depend neither on other columns nor on the number of
/// threads.
pub struct ComplexToComplexColumns<T: Real> {
    plan: Arc<RealToComplexColumns<T>>,
    direction: FftDirection,
}

/// Tiles that are transformed together: spectra that L2 holds.
const TOGETHER: usize = 2;

#[allow(clippy::len_without_is_empty)]
impl<T: Real> ComplexToComplexColumns<T> {
    /// Plans transforms of columns of `len` samples for this processor.
    ///
    /// # Errors
    /// [`FftError::Zero`] for length 0.
    pub fn new(len: usize, direction: FftDirection) -> Result<Self, FftError> {
        RealToComplexColumns::new(len).map(|plan| Self::of(Arc::new(plan), direction))
    }

    /// The complex transform by a real plan, whose tables it shares.
    pub fn of(plan: Arc<RealToComplexColumns<T>>, direction: FftDirection) -> Self {
        ComplexToComplexColumns { plan, direction }
    }

    /// Length N of the columns.
    pub fn len(&self) -> usize {
        self.plan.len()
    }

    /// The sign of the kernel.
    pub fn direction(&self) -> FftDirection {
        self.direction
    }

    /// Complex columns that are transformed together.
    fn together(&self) -> usize {
        (TOGETHER * self.plan.width()).div_ceil(2)
    }

    /// Complex numbers of copies of columns that are not neighbours, and of the spectra of both parts.
    fn parts(&self) -> [usize; 2] {
        let columns = self.together();
        [columns * self.len(), 2 * columns * self.plan.bins()]
    }

    /// Complex numbers of scratch, for any number of columns and any strides.
    pub fn scratch_len(&self) -> usize {
        let [copies, spectra] = self.parts();
        let columns = 2 * self.together();
        let layouts = [Layout::Rows, Layout::CriticalRows];
        let plan = layouts.map(|layout| self.plan.scratch_len_in(columns, layout));
        copies + spectra + plan[0].max(plan[1])
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
        output: impl Into<ColumnsMut<'o, Complex<T>>>,
    ) -> Result<(), FftError> {
        self.process_with_scratch(input, output, &mut self.make_scratch())
    }

    /// The same without allocation.
    ///
    /// # Errors
    /// As [`ComplexToComplexColumns::process`]; [`FftError::Scratch`] for scratch shorter than
    /// [`ComplexToComplexColumns::scratch_len`].
    pub fn process_with_scratch<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, Complex<T>>>,
        output: impl Into<ColumnsMut<'o, Complex<T>>>,
        scratch: &mut [Complex<T>],
    ) -> Result<(), FftError> {
        let (input, output) = (input.into(), output.into());
        self.check(&input, &output)?;
        check_scratch(self.scratch_len(), scratch)?;
        self.stripe(input, output, scratch);
        Ok(())
    }

    /// The same by all threads of the current rayon pool, with the same bits.
    ///
    /// # Errors
    /// As [`ComplexToComplexColumns::process`].
    #[cfg(feature = "rayon")]
    pub fn process_in_parallel<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, Complex<T>>>,
        output: impl Into<ColumnsMut<'o, Complex<T>>>,
    ) -> Result<(), FftError> {
        use rayon::prelude::*;

        let (input, output) = (input.into(), output.into());
        self.check(&input, &output)?;
        let width = self.together();
        let stripe = input.columns().div_ceil(4 * rayon::current_num_threads());
        let stripe = stripe.next_multiple_of(width).max(width);
        let stripes: Vec<_> = input.parts(stripe).zip(output.parts(stripe)).collect();
        stripes.into_par_iter().for_each_init(
            || self.make_scratch(),
            |scratch, (input, output)| self.stripe(input, output, scratch),
        );
        Ok(())
    }

    fn check(
        &self,
        input: &Columns<Complex<T>>,
        output: &ColumnsMut<Complex<T>>,
    ) -> Result<(), FftError> {
        let expected = (self.len(), input.columns());
        check_input(expected, input.dim())?;
        check_output(expected, output.dim())
    }

    /// Some columns, a few tiles after the other.
    fn stripe(
        &self,
        input: Columns<Complex<T>>,
        output: ColumnsMut<Complex<T>>,
        scratch: &mut [Complex<T>],
    ) {
        let [copies, spectra] = self.parts();
        let (copies, rest) = scratch.split_at_mut(copies);
        let (spectra, scratch) = rest.split_at_mut(spectra);
        let together = self.together();
        for (input, mut output) in input.parts(together).zip(output.parts(together)) {
            let columns = input.columns();
            let reals = match input.as_reals() {
                Some(reals) => reals,
                None => {
                    for (n, row) in copies
                        .chunks_exact_mut(columns)
                        .take(self.len())
                        .enumerate()
                    {
                        for (c, to) in row.iter_mut().enumerate() {
                            *to = input.at(n, c);
                        }
                    }
                    let reals: &[T] = bytemuck::cast_slice(copies);
                    // The shape is the buffer's own, so this cannot fail.
                    let Ok(reals) = Columns::new(reals, self.len(), 2 * columns, 2 * columns)
                    else {
                        return;
                    };
                    reals
                }
            };
            let spectra = &mut spectra[..2 * columns * self.plan.bins()];
            if let Ok(mut parts) =
                ColumnsMut::new(spectra, self.plan.bins(), 2 * columns, 2 * columns)
            {
                self.plan.stripe(reals, &[], &mut parts, false, scratch);
            }
            for (m, row) in spectra.chunks_exact(2 * columns).enumerate() {
                self.put(m, row, &mut output);
            }
        }
    }

    /// Rows m and N - m of the result, from bin m of both parts of each column.
    fn put(&self, m: usize, parts: &[Complex<T>], output: &mut ColumnsMut<Complex<T>>) {
        let mirror = (self.len() - m) % self.len();
        let (row, mirrored_row) = match self.direction {
            FftDirection::Forward => (m, mirror),
            FftDirection::Inverse => (mirror, m),
        };
        let (pairs, _) = parts.as_chunks::<2>();
        let bin = |[a, b]: &[Complex<T>; 2]| Complex::new(a.re - b.im, a.im + b.re);
        put_row(output, row, pairs, bin);
        if mirror != m {
            let bin = |[a, b]: &[Complex<T>; 2]| Complex::new(a.re + b.im, b.re - a.im);
            put_row(output, mirrored_row, pairs, bin);
        }
    }
}

#[inline(always)]
fn put_row<T: Real>(
    output: &mut ColumnsMut<Complex<T>>,
    row: usize,
    pairs: &[[Complex<T>; 2]],
    bin: impl Fn(&[Complex<T>; 2]) -> Complex<T>,
) {
    match output.row_slice_mut(row) {
        Some(to) => to
            .iter_mut()
            .zip(pairs)
            .for_each(|(to, pair)| *to = bin(pair)),
        None => {
            for (c, pair) in pairs.iter().enumerate() {
                output.set(row, c, bin(pair));
            }
        }
    }
}

impl<T: Real> std::fmt::Debug for ComplexToComplexColumns<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ComplexToComplexColumns")
            .field("len", &self.len())
            .field("direction", &self.direction)
            .finish_non_exhaustive()
    }
}
