//! The compared implementations, and the arrays they work on.

use std::hint::black_box;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use ndarray::parallel::prelude::*;
use ndarray::{ArrayView2, ArrayViewMut2, Axis, s};
use num_complex::Complex;

use crate::Result;
use crate::{ArrayShape, Buffer};
use column_fft::{
    Fft, FftDirection, InstructionSet, Real, RealToComplex, RealToComplexColumns, rows,
};

/// Columns gathered before they are transformed one by one: a cache line of each row.
pub(crate) const TILE: usize = 8;

/// An implementation of the transform of all columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Implementation {
    /// [`RealToComplexColumns`].
    Cascade,
    /// `realfft` on columns gathered in tiles of eight.
    Realfft,
    /// `realfft` on columns gathered one at a time.
    RealfftSingle,
    /// `rustfft` on columns gathered in tiles of eight, two columns per complex transform.
    Rustfft,
}

impl Implementation {
    pub const ALL: [Implementation; 4] = [
        Implementation::Cascade,
        Implementation::Realfft,
        Implementation::RealfftSingle,
        Implementation::Rustfft,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Implementation::Cascade => "cascade",
            Implementation::Realfft => "realfft, 8 columns",
            Implementation::RealfftSingle => "realfft, 1 column",
            Implementation::Rustfft => "rustfft, two-for-one",
        }
    }
}

/// Arrays with the plans of all implementations.
pub trait PlannedTransform: Send {
    /// Runs an implementation once: on the calling thread, or `in_parallel` on the current pool.
    fn run(&mut self, way: Implementation, in_parallel: bool);

    /// Describes our algorithm.
    fn about(&self) -> Description;
}

/// Description of our algorithm.
#[derive(Debug, Clone)]
pub struct Description {
    pub method: String,
    /// The expected relative error, if stated.
    pub expected_error: Option<f64>,
}

/// The usual ways to transform columns of one length.
pub(crate) struct ReferencePlans<T: Real> {
    realfft: Arc<dyn RealToComplex<T>>,
    rustfft: Arc<dyn Fft<T>>,
}

impl<T: Real> ReferencePlans<T> {
    pub fn new(length: usize) -> Self {
        ReferencePlans {
            realfft: rows::plan_fft_forward(length),
            rustfft: rows::plan_fft_complex(length, FftDirection::Forward),
        }
    }

    /// Transforms on the calling thread with the scratch `room`, or on the current pool.
    pub fn transform(
        &self,
        way: Implementation,
        values: ArrayView2<T>,
        mut spectra: ArrayViewMut2<Complex<T>>,
        in_parallel: bool,
        room: &mut Vec<Complex<T>>,
    ) {
        let width = if way == Implementation::RealfftSingle {
            1
        } else {
            TILE
        };
        let tile = |room: &mut Vec<Complex<T>>,
                    values: ArrayView2<T>,
                    spectra: ArrayViewMut2<_>| match way {
            Implementation::Rustfft => two_for_one(&*self.rustfft, values, spectra, room),
            _ => by_column(&*self.realfft, values, spectra, room),
        };
        let tiles = values.axis_chunks_iter(Axis(1), width);
        let results = spectra.axis_chunks_iter_mut(Axis(1), width);
        if in_parallel {
            let tiles = tiles.into_par_iter().zip(results);
            tiles.for_each_init(Vec::new, |room, (values, spectra)| {
                tile(room, values, spectra)
            });
        } else {
            let tiles = tiles.zip(results);
            tiles.for_each(|(values, spectra)| tile(room, values, spectra));
        }
    }
}

/// An array of noise.
pub(crate) fn noise<T: Real>(shape: ArrayShape) -> Result<Buffer> {
    let mut values = Buffer::new(shape.samples() * size_of::<T>())?;
    let mut state = 1_u64;
    for value in values.of::<T>() {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        *value = T::rounded((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5);
    }
    Ok(values)
}

/// A noise array and its columns' spectra, with the plans of all implementations.
pub struct Arrays<T: Real> {
    shape: ArrayShape,
    values: Buffer,
    spectra: Buffer,
    ours: RealToComplexColumns<T>,
    scratch: Vec<Complex<T>>,
    usual: ReferencePlans<T>,
    /// Scratch of the reference implementations on one thread.
    room: Vec<Complex<T>>,
}

impl<T: Real> Arrays<T> {
    /// Plans for the fastest instruction set of this processor.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] where there is no memory.
    pub fn new(shape: ArrayShape) -> Result<Self> {
        let ours = RealToComplexColumns::new(shape.rows).expect("at least one row");
        Self::planned(shape, ours)
    }

    /// Plans for a given instruction set; `None` if the processor lacks it.
    ///
    /// # Errors
    /// As [`Arrays::new`].
    pub fn with(shape: ArrayShape, set: InstructionSet) -> Result<Option<Self>> {
        let ours = RealToComplexColumns::with_instruction_set(shape.rows, set).ok();
        ours.map(|ours| Self::planned(shape, ours)).transpose()
    }

    fn planned(shape: ArrayShape, ours: RealToComplexColumns<T>) -> Result<Self> {
        let ArrayShape { rows, columns } = shape;
        Ok(Arrays {
            shape,
            values: noise::<T>(shape)?,
            spectra: Buffer::new(shape.bins() * columns * size_of::<Complex<T>>())?,
            scratch: vec![
                Complex::default();
                RealToComplexColumns::<T>::scratch_len_of(rows, columns, columns)
            ],
            ours,
            usual: ReferencePlans::new(rows),
            room: Vec::new(),
        })
    }

    /// Transforms the values in `file` with each implementation. Writes every `every`-th column of
    /// the spectra, starting from the last one, to `file.0`, `file.1`, ... in the order of
    /// [`Implementation::ALL`].
    ///
    /// # Errors
    /// Errors of reading and writing.
    pub fn write_spectra(&mut self, file: &Path, every: isize) -> std::io::Result<()> {
        let shape = (self.shape.bins(), self.shape.columns);
        std::fs::File::open(file)?.read_exact(self.values.of())?;
        for (index, way) in Implementation::ALL.into_iter().enumerate() {
            // NaN, so that outputs that are not written are detected.
            self.spectra.of::<u8>().fill(0xff);
            self.run(way, false);
            let spectra: &[Complex<T>] = self.spectra.of();
            let spectra = ArrayView2::from_shape(shape, spectra).expect("the spectrum's shape");
            let kept = spectra.slice(s![.., ..;-every]);
            let kept: Vec<Complex<T>> = kept.iter().copied().collect();
            let to = file.with_extension(index.to_string());
            std::fs::write(to, bytemuck::cast_slice(&kept))?;
        }
        Ok(())
    }
}

impl<T: Real> PlannedTransform for Arrays<T> {
    fn run(&mut self, way: Implementation, in_parallel: bool) {
        let ArrayShape { rows, columns } = self.shape;
        let values = ArrayView2::from_shape((rows, columns), self.values.of::<T>());
        let values = values.expect("the array's shape");
        let spectra = self.spectra.of::<Complex<T>>();
        let spectra = ArrayViewMut2::from_shape((self.shape.bins(), columns), spectra);
        let spectra = spectra.expect("the spectrum's shape");
        match (way, in_parallel) {
            (Implementation::Cascade, false) => {
                let transformed =
                    self.ours
                        .process_with_scratch(values, spectra, &mut self.scratch);
                transformed.expect("shapes of the plan");
            }
            (Implementation::Cascade, true) => {
                let transformed = self.ours.process_in_parallel(values, spectra);
                transformed.expect("shapes of the plan");
            }
            _ => self
                .usual
                .transform(way, values, spectra, in_parallel, &mut self.room),
        }
        black_box(&mut self.spectra);
    }

    fn about(&self) -> Description {
        Description {
            method: format!("{:?}", self.ours.algorithm()),
            expected_error: Some(self.ours.expected_error()),
        }
    }
}

impl<T: Real> std::fmt::Debug for Arrays<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Arrays")
            .field("shape", &self.shape)
            .field("transform", &self.ours)
            .finish_non_exhaustive()
    }
}

/// Gathers columns, transforms each, scatters the bins.
fn by_column<T: Real>(
    plan: &dyn RealToComplex<T>,
    values: ArrayView2<T>,
    mut spectra: ArrayViewMut2<Complex<T>>,
    room: &mut Vec<Complex<T>>,
) {
    let (rows, columns) = values.dim();
    let bins = rows / 2 + 1;
    let scratch = plan.get_scratch_len();
    room.resize(
        columns * (rows.div_ceil(2) + bins) + scratch,
        Complex::default(),
    );
    let (records, rest) = room.split_at_mut(columns * rows.div_ceil(2));
    let (found, scratch) = rest.split_at_mut(columns * bins);
    let records: &mut [T] = bytemuck::cast_slice_mut(records);
    for (n, row) in values.outer_iter().enumerate() {
        for (c, &v) in row.iter().enumerate() {
            records[c * rows + n] = v;
        }
    }
    let scratch = &mut scratch[..plan.get_scratch_len()];
    for (record, spectrum) in records
        .chunks_exact_mut(rows)
        .zip(found.chunks_exact_mut(bins))
    {
        plan.process_with_scratch(record, spectrum, scratch)
            .expect("the plan's own lengths");
    }
    for (m, mut row) in spectra.outer_iter_mut().enumerate() {
        for (c, bin) in row.iter_mut().enumerate() {
            *bin = found[c * bins + m];
        }
    }
}

/// The same for pairs of columns as the real and imaginary parts of one complex transform.
fn two_for_one<T: Real>(
    plan: &dyn Fft<T>,
    values: ArrayView2<T>,
    mut spectra: ArrayViewMut2<Complex<T>>,
    room: &mut Vec<Complex<T>>,
) {
    let (rows, columns) = values.dim();
    let pairs = columns.div_ceil(2);
    let scratch = plan.get_inplace_scratch_len();
    room.resize(pairs * rows + scratch, Complex::default());
    let (records, scratch) = room.split_at_mut(pairs * rows);
    for (n, row) in values.outer_iter().enumerate() {
        for p in 0..pairs {
            let im = row.get(2 * p + 1).copied().unwrap_or_default();
            records[p * rows + n] = Complex::new(row[2 * p], im);
        }
    }
    for record in records.chunks_exact_mut(rows) {
        plan.process_with_scratch(record, &mut scratch[..plan.get_inplace_scratch_len()]);
    }
    let half = T::rounded(0.5);
    for (m, mut row) in spectra.outer_iter_mut().enumerate() {
        for p in 0..pairs {
            let (z, mirror) = (records[p * rows + m], records[p * rows + (rows - m) % rows]);
            row[2 * p] = (z + mirror.conj()).scale(half);
            if let Some(bin) = row.get_mut(2 * p + 1) {
                let d = (z - mirror.conj()).scale(half);
                *bin = Complex::new(d.im, -d.re);
            }
        }
    }
}
