//! The ways to transform, and the arrays they work on.

use std::hint::black_box;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use ndarray::parallel::prelude::*;
use ndarray::{ArrayView2, ArrayViewMut2, Axis, s};
use num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

use super::{Buffer, Shape};
use crate::error::Result;
use crate::transform::vertical::{ColumnScratch, InstructionSet};
use crate::transform::{ColumnTransform, Real};

/// Columns gathered before they are transformed one by one: a cache line of each row.
const TILE: usize = 8;

/// A way to transform all columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// [`ColumnTransform`].
    Cascade,
    /// `realfft` of columns gathered eight by eight.
    Realfft,
    /// `realfft` of columns gathered one by one.
    RealfftSingle,
    /// `rustfft` of columns gathered eight by eight, two as one complex transform.
    Rustfft,
}

impl Way {
    pub const ALL: [Way; 4] = [Way::Cascade, Way::Realfft, Way::RealfftSingle, Way::Rustfft];

    pub fn name(self) -> &'static str {
        match self {
            Way::Cascade => "cascade",
            Way::Realfft => "realfft, 8 columns",
            Way::RealfftSingle => "realfft, 1 column",
            Way::Rustfft => "rustfft, two-for-one",
        }
    }
}

/// An array of noise and room for its spectrum, with the ways planned for them.
pub struct Arrays<T: Real> {
    shape: Shape,
    values: Buffer,
    spectra: Buffer,
    ours: ColumnTransform<T>,
    scratch: ColumnScratch<T>,
    realfft: Arc<dyn RealToComplex<T>>,
    rustfft: Arc<dyn Fft<T>>,
    /// Of the ways that gather columns, run by one thread.
    room: Vec<Complex<T>>,
}

impl<T: Real> Arrays<T> {
    /// For the fastest instructions of this processor.
    ///
    /// # Errors
    /// [`crate::Error::Read`] where there is no memory.
    pub fn new(shape: Shape) -> Result<Self> {
        Self::planned(shape, ColumnTransform::new(shape.rows))
    }

    /// For chosen instructions; `None` where the processor lacks them.
    ///
    /// # Errors
    /// As [`Arrays::new`].
    pub fn with(shape: Shape, set: InstructionSet) -> Result<Option<Self>> {
        let ours = ColumnTransform::with(shape.rows, set);
        ours.map(|ours| Self::planned(shape, ours)).transpose()
    }

    fn planned(shape: Shape, ours: ColumnTransform<T>) -> Result<Self> {
        let Shape { rows, columns } = shape;
        let mut values = Buffer::new(rows * columns * size_of::<T>())?;
        let mut state = 1_u64;
        for value in values.of::<T>() {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            *value = T::rounded((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5);
        }
        Ok(Arrays {
            shape,
            values,
            spectra: Buffer::new(shape.bins() * columns * 2 * size_of::<T>())?,
            scratch: ours.scratch(columns),
            ours,
            realfft: RealFftPlanner::new().plan_fft_forward(rows),
            rustfft: FftPlanner::new().plan_fft_forward(rows),
            room: Vec::new(),
        })
    }

    /// The transform that is measured.
    pub fn transform(&self) -> &ColumnTransform<T> {
        &self.ours
    }

    /// Runs a way once: by the calling thread, or `in_parallel` by all threads of the current pool.
    pub fn run(&mut self, way: Way, in_parallel: bool) {
        let Shape { rows, columns } = self.shape;
        let values: &[T] = self.values.of();
        let values = ArrayView2::from_shape((rows, columns), values).expect("the array's shape");
        let spectra: &mut [Complex<T>] = self.spectra.of();
        let spectra = ArrayViewMut2::from_shape((self.shape.bins(), columns), spectra);
        let mut spectra = spectra.expect("the spectrum's shape");
        let width = if way == Way::RealfftSingle { 1 } else { TILE };
        let (realfft, rustfft) = (&*self.realfft, &*self.rustfft);
        let tile = |room: &mut Vec<Complex<T>>,
                    values: ArrayView2<T>,
                    spectra: ArrayViewMut2<_>| match way {
            Way::Rustfft => two_for_one(rustfft, values, spectra, room),
            _ => by_column(realfft, values, spectra, room),
        };
        match (way, in_parallel) {
            (Way::Cascade, false) => {
                self.ours
                    .transform(values, spectra.view_mut(), &mut self.scratch)
            }
            (Way::Cascade, true) => self.ours.transform_in_parallel(values, spectra.view_mut()),
            (_, false) => values
                .axis_chunks_iter(Axis(1), width)
                .zip(spectra.axis_chunks_iter_mut(Axis(1), width))
                .for_each(|(values, spectra)| tile(&mut self.room, values, spectra)),
            (_, true) => values
                .axis_chunks_iter(Axis(1), width)
                .into_par_iter()
                .zip(spectra.axis_chunks_iter_mut(Axis(1), width))
                .for_each_init(Vec::new, |room, (values, spectra)| {
                    tile(room, values, spectra)
                }),
        }
        black_box(&mut self.spectra);
    }

    /// Transforms the values in `file` in each way, and writes of the spectra every `every`-th
    /// column, the last one first, to `file.0`, `file.1`, ... in the order of [`Way::ALL`].
    ///
    /// # Errors
    /// Of reading and writing.
    pub fn write_spectra(&mut self, file: &Path, every: isize) -> std::io::Result<()> {
        let shape = (self.shape.bins(), self.shape.columns);
        std::fs::File::open(file)?.read_exact(self.values.of())?;
        for (index, way) in Way::ALL.into_iter().enumerate() {
            // Not numbers: what a way leaves out is seen.
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

/// The same for pairs of columns as real and imaginary part of one complex transform.
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
