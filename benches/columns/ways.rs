//! The ways to transform, and the arrays they work on.

use std::hint::black_box;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use bytemuck::Pod;
use cascade::transform::vertical::ColumnScratch;
use cascade::transform::{ColumnTransform, Real};
use memmap2::MmapMut;
use ndarray::parallel::prelude::*;
use ndarray::{ArrayView2, ArrayViewMut2, Axis, s};
use num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

/// Columns gathered before they are transformed one by one: a cache line of each row.
const TILE: usize = 8;

/// An array in huge pages.
pub struct Buffer(pub MmapMut);

impl Buffer {
    pub fn new(bytes: usize) -> Buffer {
        let pages = MmapMut::map_anon(bytes.max(1)).expect("memory for the arrays");
        #[cfg(target_os = "linux")]
        let _refused = pages.advise(memmap2::Advice::HugePage);
        Buffer(pages)
    }

    pub fn of<T: Pod>(&mut self) -> &mut [T] {
        bytemuck::cast_slice_mut(&mut self.0)
    }
}

/// The ways to transform, planned for one shape, and the arrays.
pub struct Case<T: Real> {
    shape: (usize, usize),
    values: Buffer,
    spectra: Buffer,
    ours: ColumnTransform<T>,
    scratch: ColumnScratch<T>,
    realfft: Arc<dyn RealToComplex<T>>,
    rustfft: Arc<dyn Fft<T>>,
}

pub const WAYS: [&str; 4] = [
    "cascade",
    "realfft, 8 columns",
    "realfft, 1 column",
    "rustfft, two-for-one",
];

impl<T: Real> Case<T> {
    pub fn new(shape: (usize, usize)) -> Self {
        let (rows, columns) = shape;
        let mut values = Buffer::new(rows * columns * size_of::<T>());
        let mut state = 1_u64;
        for value in values.of::<T>() {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            *value = T::rounded((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5);
        }
        let ours = ColumnTransform::new(rows);
        Case {
            shape,
            values,
            spectra: Buffer::new((rows / 2 + 1) * columns * 2 * size_of::<T>()),
            scratch: ours.scratch(columns),
            ours,
            realfft: RealFftPlanner::new().plan_fft_forward(rows),
            rustfft: FftPlanner::new().plan_fft_forward(rows),
        }
    }

    /// Milliseconds of one run of one of [`WAYS`] by the threads of the current pool.
    pub fn run(&mut self, way: usize) -> f64 {
        let (rows, columns) = self.shape;
        let values: &[T] = self.values.of();
        let values = ArrayView2::from_shape((rows, columns), values).expect("the array's shape");
        let spectra: &mut [Complex<T>] = self.spectra.of();
        let spectra = ArrayViewMut2::from_shape((rows / 2 + 1, columns), spectra);
        let mut spectra = spectra.expect("the spectrum's shape");
        let start = Instant::now();
        match way {
            0 if rayon::current_num_threads() == 1 => {
                let scratch = &mut self.scratch;
                self.ours.transform(values, spectra.view_mut(), scratch);
            }
            0 => self.ours.transform_in_parallel(values, spectra.view_mut()),
            _ => {
                let width = if way == 2 { 1 } else { TILE };
                values
                    .axis_chunks_iter(Axis(1), width)
                    .into_par_iter()
                    .zip(spectra.axis_chunks_iter_mut(Axis(1), width))
                    .for_each_init(Vec::new, |room, (values, spectra)| match way {
                        3 => two_for_one(&*self.rustfft, values, spectra, room),
                        _ => by_column(&*self.realfft, values, spectra, room),
                    });
            }
        }
        let seconds = start.elapsed().as_secs_f64();
        black_box(&mut self.spectra);
        1e3 * seconds
    }

    /// Transforms the values in `file` in each way, and writes of the spectra every `every`-th
    /// column, the last one first, to `file.0`, `file.1`, ...
    pub fn write_spectra(&mut self, file: &Path, every: isize) -> std::io::Result<()> {
        let (rows, columns) = self.shape;
        std::fs::File::open(file)?.read_exact(self.values.of())?;
        for way in 0..WAYS.len() {
            // Not numbers: what a way leaves out is seen.
            self.spectra.of::<u8>().fill(0xff);
            self.run(way);
            let spectra: &[Complex<T>] = self.spectra.of();
            let spectra = ArrayView2::from_shape((rows / 2 + 1, columns), spectra);
            let spectra = spectra.expect("the spectrum's shape");
            let kept = spectra.slice(s![.., ..;-every]);
            let kept: Vec<Complex<T>> = kept.iter().copied().collect();
            let to = file.with_extension(way.to_string());
            std::fs::write(to, bytemuck::cast_slice(&kept))?;
        }
        Ok(())
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
