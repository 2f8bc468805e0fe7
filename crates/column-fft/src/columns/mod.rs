//! Real transforms of all columns of an array at once, without a transpose.
//!
//! # Equation
//! `X_m = sum_n v_n exp(-2 pi i m n / N)`, `m = 0 ..= N / 2`, of every column `v` of an array of N
//! rows, unnormalised. Bins 0 and, for even N, N / 2 have imaginary part 0.
//!
//! # Algorithm
//! A register holds one row of as many neighbouring columns as it has lanes, a *tile*. All lanes
//! undergo the same, so a column's bits do not depend on its place or on its neighbours.
//!
//! `N = n1 n2` is split into two halves (the four-step algorithm), with `n = j1 n2 + j2` and
//! `m = k1 + n1 k2`:
//!
//! 1. for each `j2` the `n1` rows `j1 n2 + j2` are transformed, times `exp(-2 pi i k1 j2 / N)`;
//! 2. for each `k1` the `n2` numbers over `j2` are transformed, which gives the rows `m`.
//!
//! The series of step 1 are real, so those of `j2` and `j2 + 1` pass through one complex transform
//! as its real and imaginary part and are split again, which leaves `k1 = 0 ..= n1 / 2`. The bins
//! above `N / 2` that step 2 gives for these are the mirrors of the others. The intermediate matrix
//! has `(n1 / 2 + 1) n2` complex numbers a column and lies in the scratch. Rows are read once, bins
//! written once.
//!
//! Each half is a chain of passes of radix 2, 3, 4, 5, 7 or 8 (decimation in frequency, in place;
//! the digits of the last pass come in reversed order and are written where they belong) over
//! numbers that stay in L1. Twiddle factors come from tables that are right to half a unit in the
//! last place. Rows are prefetched one pair of series before their use, a few with each butterfly; rows
//! at a critical stride are first copied into the order of use. Results in rows of whole cache
//! lines that are larger than the caches are written by streaming stores; rows of other large
//! results are prefetched.
//!
//! Lengths with other prime factors go through a convolution of a length that has none, in the
//! same halves, Bluestein's; the shortest are transformed column by column.
//!
//! # Instruction sets
//! [`InstructionSet`] is chosen at run time. Fused multiply-adds round once where others round
//! twice, so results of [`InstructionSet::Portable`] differ in the last digits from the others',
//! which agree with each other.
//!
//! Source: D. H. Bailey, "FFTs in external or hierarchical memory", J. Supercomputing 4, 23
//! (1990); C. Van Loan, "Computational Frameworks for the Fast Fourier Transform", 1992.

mod algorithm;
mod bluestein;
mod butterfly;
mod cyclic;
mod fallback;
mod kernels;
mod mixed_radix;
mod passes;
mod plan;
mod scratch;
mod simd;
mod streaming;
mod tiles;

use num_complex::Complex;

use crate::{Columns, ColumnsMut, FftError, Real};
pub use algorithm::Algorithm;
use algorithm::Decomposition;
pub use kernels::InstructionSet;
use kernels::Kernels;
use plan::TilePlan;
pub(crate) use streaming::copy_streaming;
pub(crate) use tiles::{Layout, windows_in_passing};

/// Bytes of a cache line.
pub(crate) const LINE: usize = 64;

/// Bytes of a result from which on stores are streaming.
const STREAMING_BYTES: usize = 4 << 20;

/// Bytes from which on places are prefetched before they are written: of the intermediate matrix, and over
/// which rows of a result lie that is stored through the caches. Half of an L2, or all of a small one.
const PREFETCH_BYTES: usize = 512 << 10;

/// The transform of all columns of real arrays of one number of rows: `X_m = sum_n v_n exp(-2 pi i m n / N)`,
/// `m = 0 ..= N / 2`, unnormalised.
///
/// # Shapes
/// The input is `(N, columns)`, the output `(N / 2 + 1, columns)`, bins in ascending order. Bins 0 and, for even
/// N, N / 2 have imaginary part 0. Input and output may have any strides; where columns are neighbours in
/// memory, nothing is copied, but for rows a multiple of 4096 bytes apart. Rows of the output that are whole
/// cache lines are the fastest.
///
/// # Errors
/// The root mean square error of a column's bins is about [`RealToComplexColumns::expected_error`] of their root
/// mean square. A column's bits depend neither on its place, nor on other columns, nor on the number of threads.
///
/// Source: D. H. Bailey, "FFTs in external or hierarchical memory", J. Supercomputing 4, 23 (1990).
pub struct RealToComplexColumns<T: Real> {
    length: usize,
    set: InstructionSet,
    decomposition: Decomposition,
    plan: TilePlan<T>,
    /// As [`kernels_for`] gives them.
    kernels: Vec<&'static Kernels<T>>,
    #[cfg(feature = "rayon")]
    pool: crate::pool::Pool<Complex<T>>,
}

#[allow(clippy::len_without_is_empty)]
impl<T: Real> RealToComplexColumns<T> {
    /// Plans transforms of columns of `len` samples for this processor.
    ///
    /// # Errors
    /// [`FftError::Zero`] for length 0.
    pub fn new(len: usize) -> Result<Self, FftError> {
        Self::with_instruction_set(len, InstructionSet::best())
    }

    /// The same with chosen instructions.
    ///
    /// # Errors
    /// As [`RealToComplexColumns::new`]; [`FftError::InstructionSet`] where the processor lacks them.
    pub fn with_instruction_set(len: usize, set: InstructionSet) -> Result<Self, FftError> {
        if len == 0 {
            return Err(FftError::Zero { what: "the length" });
        }
        if !set.is_available() {
            return Err(FftError::InstructionSet(set));
        }
        let decomposition = Decomposition::of(len);
        Ok(RealToComplexColumns {
            length: len,
            set,
            plan: TilePlan::new(set, len, decomposition.clone()),
            kernels: kernels_for(set, &decomposition),
            decomposition,
            #[cfg(feature = "rayon")]
            pool: crate::pool::Pool::default(),
        })
    }

    /// Length N of the columns.
    pub fn len(&self) -> usize {
        self.length
    }

    /// Rows of the output, `N / 2 + 1`.
    pub fn bins(&self) -> usize {
        self.length / 2 + 1
    }

    /// Columns that are transformed together, a tile.
    pub fn width(&self) -> usize {
        width_for(&self.kernels, usize::MAX)
    }

    /// The instructions in use.
    pub fn instruction_set(&self) -> InstructionSet {
        self.set
    }

    /// The algorithm in use.
    pub fn algorithm(&self) -> Algorithm {
        self.decomposition.algorithm()
    }

    /// Root mean square error of white noise's bins, relative to the root mean square of all: measured
    /// `0.35 eps sqrt(log2 N)` for N of small prime factors, `0.6 eps sqrt(log2 N)` for others.
    pub fn expected_error(&self) -> f64 {
        let levels = (self.length as f64).log2().max(1.0).sqrt();
        self.decomposition.rounding() * T::EPSILON * levels
    }

    /// Complex numbers of scratch for `columns` columns, or fewer, of arrays of any strides.
    pub fn scratch_len(&self, columns: usize) -> usize {
        let layouts = [Layout::Rows, Layout::CriticalRows, Layout::Strided];
        let lengths = layouts.map(|layout| self.scratch_len_in(columns, layout));
        lengths.into_iter().fold(0, usize::max)
    }

    /// Complex numbers of scratch for these arrays, or for fewer columns of them.
    pub fn scratch_len_for(&self, input: &Columns<T>, output: &ColumnsMut<Complex<T>>) -> usize {
        self.scratch_len_in(input.columns(), Layout::of(input, output))
    }

    /// Complex numbers of scratch that a plan of length `len` for this processor needs for `columns`
    /// neighbouring columns in rows `row_stride` numbers apart; known before there is a plan. 0 for length 0.
    pub fn scratch_len_of(len: usize, columns: usize, row_stride: usize) -> usize {
        match len {
            0 => 0,
            _ => {
                let layout = Layout::of_rows(row_stride.saturating_mul(size_of::<T>()));
                tiles::scratch_len::<T>(len, columns, layout)
            }
        }
    }

    /// The [`RealToComplexColumns::width`] of a plan of length `len` for this processor; known before there is
    /// a plan.
    pub(crate) fn width_of(len: usize) -> usize {
        let kernels = kernels_for::<T>(InstructionSet::best(), &Decomposition::of(len));
        width_for(&kernels, usize::MAX)
    }

    /// Scratch for `columns` columns of arrays of any strides.
    pub fn make_scratch(&self, columns: usize) -> Vec<Complex<T>> {
        vec![Complex::default(); self.scratch_len(columns)]
    }

    /// Transforms all columns of `input` to `output`.
    ///
    /// # Errors
    /// [`FftError::Input`] and [`FftError::Output`] for shapes other than the plan's.
    pub fn process<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, T>>,
        output: impl Into<ColumnsMut<'o, Complex<T>>>,
    ) -> Result<(), FftError> {
        let (input, output) = (input.into(), output.into());
        let mut scratch = vec![Complex::default(); self.scratch_len_for(&input, &output)];
        self.process_with_scratch(input, output, &mut scratch)
    }

    /// The same without allocation.
    ///
    /// # Errors
    /// As [`RealToComplexColumns::process`]; [`FftError::Scratch`] for scratch shorter than
    /// [`RealToComplexColumns::scratch_len_for`] says, which [`RealToComplexColumns::scratch_len`] never is.
    #[inline]
    pub fn process_with_scratch<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, T>>,
        output: impl Into<ColumnsMut<'o, Complex<T>>>,
        scratch: &mut [Complex<T>],
    ) -> Result<(), FftError> {
        self.process_all(input.into(), output.into(), scratch)
    }

    fn process_all(
        &self,
        input: Columns<T>,
        mut output: ColumnsMut<Complex<T>>,
        scratch: &mut [Complex<T>],
    ) -> Result<(), FftError> {
        self.check(&input, &output)?;
        check_scratch(self.scratch_len_for(&input, &output), scratch)?;
        let stream = self.streams(input.columns());
        self.stripe(input, &[], &mut output, stream, scratch);
        Ok(())
    }

    /// The same by all threads of the current rayon pool, with the same bits. Scratch is kept in the plan and
    /// used again.
    ///
    /// # Errors
    /// As [`RealToComplexColumns::process`].
    #[cfg(feature = "rayon")]
    pub fn process_in_parallel<'i, 'o>(
        &self,
        input: impl Into<Columns<'i, T>>,
        output: impl Into<ColumnsMut<'o, Complex<T>>>,
    ) -> Result<(), FftError> {
        use rayon::prelude::*;

        let (input, output) = (input.into(), output.into());
        self.check(&input, &output)?;
        let columns = input.columns();
        let stream = self.streams(columns);
        let tiles = columns.div_ceil(self.width());
        let stripe = tiles.div_ceil(4 * rayon::current_num_threads()).max(1) * self.width();
        let layout = Layout::of(&input, &output);
        let needed = self.scratch_len_in(stripe.min(columns), layout);
        let stripes: Vec<_> = input.parts(stripe).zip(output.parts(stripe)).collect();
        stripes.into_par_iter().for_each_init(
            || self.pool.take(needed),
            |scratch, (values, mut spectra)| {
                self.stripe(values, &[], &mut spectra, stream, scratch);
            },
        );
        Ok(())
    }

    fn check(&self, input: &Columns<T>, output: &ColumnsMut<Complex<T>>) -> Result<(), FftError> {
        check_input((self.length, input.columns()), input.dim())?;
        check_output((self.bins(), input.columns()), output.dim())
    }

    /// Whether stores to a result of `columns` columns are streaming.
    pub(crate) fn streams(&self, columns: usize) -> bool {
        self.bins() * columns * size_of::<Complex<T>>() >= STREAMING_BYTES
    }

    /// Whether [`RealToComplexColumns::stripe`] takes a window.
    pub(crate) fn windows_in_passing(&self) -> bool {
        matches!(self.plan, TilePlan::MixedRadix(_))
    }

    /// Transforms some columns of an array, rows times `window` if there is one.
    ///
    /// # Panics
    /// If shapes are not the plan's, or the scratch is too short.
    pub(crate) fn stripe(
        &self,
        values: Columns<T>,
        window: &[T],
        spectra: &mut ColumnsMut<Complex<T>>,
        stream: bool,
        scratch: &mut [Complex<T>],
    ) {
        assert_eq!(values.rows(), self.length);
        assert_eq!(spectra.dim(), (self.bins(), values.columns()));
        assert!(window.is_empty() || window.len() == self.length && self.windows_in_passing());
        match &self.plan {
            TilePlan::Fallback(fallback) => fallback.transform(values, spectra, scratch),
            _ => self.tiles(values, window, spectra, stream, scratch),
        }
    }
}

pub(crate) fn check_input(expected: (usize, usize), found: (usize, usize)) -> Result<(), FftError> {
    match expected == found {
        true => Ok(()),
        false => Err(FftError::Input { expected, found }),
    }
}

pub(crate) fn check_output(
    expected: (usize, usize),
    found: (usize, usize),
) -> Result<(), FftError> {
    match expected == found {
        true => Ok(()),
        false => Err(FftError::Output { expected, found }),
    }
}

pub(crate) fn check_scratch<T>(needed: usize, scratch: &[T]) -> Result<(), FftError> {
    let found = scratch.len();
    match needed <= found {
        true => Ok(()),
        false => Err(FftError::Scratch { needed, found }),
    }
}

/// Those of an instruction set, wide ones first; none where columns are transformed one by one.
fn kernels_for<T: Real>(
    set: InstructionSet,
    decomposition: &Decomposition,
) -> Vec<&'static Kernels<T>> {
    match decomposition {
        Decomposition::Fallback => Vec::new(),
        _ => kernels::kernels(set),
    }
}

/// Columns of the widest tile of at most `columns` columns.
fn width_for<T>(kernels: &[&'static Kernels<T>], columns: usize) -> usize {
    match kernels {
        [] => fallback::WIDTH,
        _ => widest(kernels, columns).width,
    }
}

/// The widest kernel of at most `columns` columns; the last is of one.
fn widest<T>(kernels: &[&'static Kernels<T>], columns: usize) -> &'static Kernels<T> {
    let fits = kernels.iter().find(|k| k.width <= columns);
    fits.unwrap_or(&kernels[kernels.len() - 1])
}

impl<T: Real> std::fmt::Debug for RealToComplexColumns<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RealToComplexColumns")
            .field("len", &self.length)
            .field("instruction_set", &self.set)
            .field("algorithm", &self.algorithm())
            .finish_non_exhaustive()
    }
}
