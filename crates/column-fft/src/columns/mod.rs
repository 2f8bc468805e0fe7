//! Real transforms of all columns of a (time, site) array at once, without transposing it.
//!
//! # Equation
//! `X_m = sum_n v_n exp(-2 pi i m n / N)`, `m = 0 ..= N / 2`, of every column `v` of an array of N
//! rows, unnormalised. Bins 0 and, for even N, N / 2 have imaginary part 0.
//!
//! # How
//! A register holds one row of as many neighbouring columns as it has lanes, a *tile*. All lanes
//! undergo the same, so a column's bits do not depend on its place or on its neighbours.
//!
//! `N = n1 n2` is split in two halves (the four-step, or Bailey's, algorithm), with
//! `n = j1 n2 + j2` and `m = k1 + n1 k2`:
//!
//! 1. for each `j2` the `n1` rows `j1 n2 + j2` are transformed, times `exp(-2 pi i k1 j2 / N)`;
//! 2. for each `k1` the `n2` numbers over `j2` are transformed, which gives the rows `m`.
//!
//! The series of step 1 are real, so those of `j2` and `j2 + 1` pass through one complex transform
//! as its real and imaginary part and are split again, which leaves `k1 = 0 ..= n1 / 2`. The bins
//! above `N / 2` that step 2 gives for these are the mirrors of the others. Between the halves
//! lies a matrix of `(n1 / 2 + 1) n2` complex numbers a column, the scratch. Nothing else is
//! stored twice: rows are read once, bins written once.
//!
//! Each half is a chain of passes of radix 2, 3, 4, 5, 7 or 8 (decimation in frequency, in place;
//! the digits of the last pass come in reversed order and are written where they belong) over
//! numbers that stay in the first cache. Twiddle factors come from tables that are right to half
//! a unit in the last place. Rows are asked for one pair of series prefetch of their use, a few with each
//! butterfly, or, where they share places in the caches, copied first into the order of use. Results
//! that fill whole cache lines and are larger than the caches are written past them; rows of other large
//! results are asked for before their turn.
//!
//! Lengths with other prime factors go through a convolution of a length that has none, in the
//! same halves: primes by Rader's algorithm, others by Bluestein's; the shortest are transformed
//! column by column.
//!
//! # Instruction sets
//! [`InstructionSet`] is chosen at run time. Fused multiply-adds round once where others round
//! twice, so results of [`InstructionSet::Portable`] differ in the last digits from the others',
//! which agree with each other.
//!
//! # Errors
//! The root mean square error of a column is about [`ColumnTransform::expected_error`] of the root
//! mean square of its bins.
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
mod rader;
mod simd;
mod streaming;
mod tiles;

use ndarray::parallel::prelude::*;
use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use num_complex::Complex;

use crate::Real;
use crate::pool::{Pool, PoolGuard};
pub use algorithm::Algorithm;
use algorithm::Decomposition;
use kernels::Kernels;
pub use kernels::{InstructionSet, Kernelled, KernelsOf};
use plan::TilePlan;
pub(crate) use streaming::copy_streaming;

/// Bytes of a cache line.
pub(crate) const LINE: usize = 64;

/// Bytes of a result from which on it is written past the caches.
const STREAMING_BYTES: usize = 4 << 20;

/// Bytes from which on places are asked for before they are written: of the matrix between the halves, and
/// over which rows of a result lie that are not written past the caches. Half of a second cache, or
/// all of a small one.
const PREFETCH_BYTES: usize = 512 << 10;

/// The transform of all columns of arrays of one number of rows; see the [module](self).
pub struct ColumnTransform<T: Real> {
    length: usize,
    set: InstructionSet,
    decomposition: Decomposition,
    way: TilePlan<T>,
    /// As [`kernels_for`] gives them.
    kernels: Vec<&'static Kernels<T>>,
    /// Working spaces of threads that are done, for those to come.
    pool: Pool<ColumnScratch<T>>,
}

/// Working space of one thread, made by [`ColumnTransform::scratch`].
#[derive(Debug, Clone)]
pub struct ColumnScratch<T> {
    /// Columns of the widest tile there is room for.
    width: usize,
    lines: Vec<Line>,
    /// Copies of rows: of columns that are not neighbours, with their bins, and of rows that alias; grows
    /// when it is needed.
    copies: Vec<Line>,
    by_column: fallback::Room<T>,
}

/// A cache line.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Line([u8; 64]);

// SAFETY: bytes without padding; all zeros are zeros.
unsafe impl bytemuck::Zeroable for Line {}
// SAFETY: any bits are bytes.
unsafe impl bytemuck::Pod for Line {}

impl<T: Real> ColumnTransform<T> {
    /// Plans transforms of columns of `length` samples, at least 1, for this processor.
    ///
    /// # Panics
    /// If `length` is 0.
    pub fn new(length: usize) -> Self {
        let set = InstructionSet::best();
        Self::planned(length, set)
    }

    /// The same for a chosen instruction set; `None` where the processor lacks it.
    ///
    /// # Panics
    /// If `length` is 0.
    pub fn with(length: usize, set: InstructionSet) -> Option<Self> {
        set.is_available().then(|| Self::planned(length, set))
    }

    fn planned(length: usize, set: InstructionSet) -> Self {
        assert!(length > 0);
        let decomposition = Decomposition::of(length);
        ColumnTransform {
            length,
            set,
            way: TilePlan::new(set, length, decomposition.clone()),
            kernels: kernels_for(set, &decomposition),
            decomposition,
            pool: Pool::default(),
        }
    }

    /// Length N of the columns.
    pub fn length(&self) -> usize {
        self.length
    }

    /// Rows of the result, `N / 2 + 1`.
    pub fn bins(&self) -> usize {
        self.length / 2 + 1
    }

    /// Columns that are transformed together.
    pub fn width(&self) -> usize {
        width_for(&self.kernels, usize::MAX)
    }

    /// The same of any plan of a length for this processor.
    pub(crate) fn width_of(length: usize) -> usize {
        let kernels = kernels_for::<T>(InstructionSet::best(), &Decomposition::of(length));
        width_for(&kernels, usize::MAX)
    }

    pub fn instruction_set(&self) -> InstructionSet {
        self.set
    }

    pub fn algorithm(&self) -> Algorithm {
        self.decomposition.algorithm()
    }

    /// Root mean square error of white noise's bins, relative to the root mean square of all.
    pub fn expected_error(&self) -> f64 {
        let levels = (self.length as f64).log2().max(1.0).sqrt();
        self.decomposition.rounding() * T::EPSILON * levels
    }

    /// A working space of one thread, one that is pool if there is one: new memory costs as much as
    /// a tile of short columns.
    fn borrow(&self, columns: usize) -> PoolGuard<'_, ColumnScratch<T>> {
        let width = width_for(&self.kernels, columns);
        let fits = |scratch: &ColumnScratch<T>| scratch.width == width;
        self.pool.take(fits, || self.scratch(columns))
    }

    /// Working space of one thread for arrays of `columns` columns, or of more.
    pub fn scratch(&self, columns: usize) -> ColumnScratch<T> {
        let width = width_for(&self.kernels, columns);
        ColumnScratch {
            width,
            lines: lines::<T>(self.decomposition.scratch_len(width)),
            copies: Vec::new(),
            by_column: match &self.way {
                TilePlan::Fallback(fallback) => fallback.room(),
                _ => fallback::Room::default(),
            },
        }
    }

    /// The spectra of all columns of `values`, `(time, column)`, to `spectra`, `(bin, column)`.
    ///
    /// Fastest where rows of `spectra` are whole cache lines. Allocates nothing where the columns
    /// of both are neighbours in memory, but once 128 bytes a row, or up to 8 MiB, where rows are a
    /// multiple of 4096 bytes apart.
    ///
    /// # Panics
    /// If the shapes are not those of the plan, or `scratch` was made by another.
    pub fn transform(
        &self,
        values: ArrayView2<T>,
        mut spectra: ArrayViewMut2<Complex<T>>,
        scratch: &mut ColumnScratch<T>,
    ) {
        let stream = self.streams(values.ncols());
        self.stripe(values, &[], &mut spectra, stream, scratch);
    }

    /// Whether a result of so many columns is written past the caches.
    pub(crate) fn streams(&self, columns: usize) -> bool {
        self.bins() * columns * size_of::<Complex<T>>() >= STREAMING_BYTES
    }

    /// Whether rows can be windowed in passing, by [`ColumnTransform::stripe`].
    pub(crate) fn windows_in_passing(&self) -> bool {
        matches!(self.way, TilePlan::MixedRadix(_))
    }

    /// Transforms a stripe of an array, rows times `window` if there are any.
    pub(crate) fn stripe(
        &self,
        values: ArrayView2<T>,
        window: &[T],
        spectra: &mut ArrayViewMut2<Complex<T>>,
        stream: bool,
        scratch: &mut ColumnScratch<T>,
    ) {
        assert_eq!(values.nrows(), self.length);
        assert_eq!(spectra.dim(), (self.bins(), values.ncols()));
        assert!(window.is_empty() || window.len() == self.length && self.windows_in_passing());
        match &self.way {
            TilePlan::Fallback(fallback) => {
                fallback.transform(values, spectra.view_mut(), &mut scratch.by_column)
            }
            _ => self.tiles(values, window, spectra, stream, scratch),
        }
    }

    /// The same by all threads of the current pool, with the same bits; each takes a working space
    /// that an earlier call left, if there is one.
    ///
    /// # Panics
    /// If the shapes are not those of the plan.
    pub fn transform_in_parallel(
        &self,
        values: ArrayView2<T>,
        mut spectra: ArrayViewMut2<Complex<T>>,
    ) {
        let columns = values.ncols();
        let stream = self.streams(columns);
        let tiles = columns.div_ceil(self.width());
        let stripe = tiles.div_ceil(4 * rayon::current_num_threads()).max(1) * self.width();
        values
            .axis_chunks_iter(Axis(1), stripe)
            .into_par_iter()
            .zip(spectra.axis_chunks_iter_mut(Axis(1), stripe))
            .for_each_init(
                || self.borrow(stripe.min(columns)),
                |scratch, (values, mut spectra)| {
                    self.stripe(values, &[], &mut spectra, stream, scratch);
                },
            );
    }
}

/// Those of an instruction set, wide ones first; none where columns are transformed one by one.
fn kernels_for<T: Real>(
    set: InstructionSet,
    decomposition: &Decomposition,
) -> Vec<&'static Kernels<T>> {
    match decomposition {
        Decomposition::Fallback => Vec::new(),
        _ => T::kernels(set).iter().map(|kernels| kernels.0).collect(),
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

/// Room for so many numbers.
fn lines<T>(numbers: usize) -> Vec<Line> {
    vec![bytemuck::Zeroable::zeroed(); lines_of::<T>(numbers)]
}

/// Lines that so many numbers take.
fn lines_of<T>(numbers: usize) -> usize {
    (numbers * size_of::<T>()).div_ceil(size_of::<Line>())
}

impl<T: Real> std::fmt::Debug for ColumnTransform<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ColumnTransform")
            .field("length", &self.length)
            .field("instruction_set", &self.set)
            .field("algorithm", &self.algorithm())
            .finish_non_exhaustive()
    }
}
