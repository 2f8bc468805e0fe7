//! Transforms of all columns of a (time, site) array: ours, and the usual ways with `realfft` and
//! `rustfft`, in turn in one process.
//!
//! `cargo bench --bench columns` prints a table, `-- 4096x300` of that shape alone; `-- --test` runs everything once on small arrays.
//! `-- --serve` answers lines `ROWS COLUMNS f32|f64 THREADS` with the milliseconds of one run of
//! each way, for `peers/columns.py`, which runs other libraries in between.
//!
//! Arrays lie in huge pages where the system has them. The bound is the array read and the
//! spectrum written once at the rate of a copy past the caches; GFLOP/s count `2.5 n log2 n` for a
//! column.

use std::collections::HashMap;
use std::hint::black_box;
use std::io::BufRead;
use std::sync::Arc;
use std::time::Instant;

use bytemuck::Pod;
use cascade::transform::vertical::ColumnScratch;
use cascade::transform::{ColumnTransform, Real};
use memmap2::MmapMut;
use ndarray::parallel::prelude::*;
use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

/// Columns gathered before they are transformed one by one: a cache line of each row.
const TILE: usize = 8;

/// An array in huge pages.
struct Buffer(MmapMut);

impl Buffer {
    fn new(bytes: usize) -> Buffer {
        let pages = MmapMut::map_anon(bytes.max(1)).expect("memory for the arrays");
        #[cfg(target_os = "linux")]
        let _refused = pages.advise(memmap2::Advice::HugePage);
        Buffer(pages)
    }

    fn of<T: Pod>(&mut self) -> &mut [T] {
        bytemuck::cast_slice_mut(&mut self.0)
    }
}

/// The ways to transform, planned for one shape, and the arrays.
struct Case<T: Real> {
    shape: (usize, usize),
    values: Buffer,
    spectra: Buffer,
    ours: ColumnTransform<T>,
    scratch: ColumnScratch<T>,
    realfft: Arc<dyn RealToComplex<T>>,
    rustfft: Arc<dyn Fft<T>>,
}

const WAYS: [&str; 4] = [
    "cascade",
    "realfft, 8 columns",
    "realfft, 1 column",
    "rustfft, two-for-one",
];

impl<T: Real> Case<T> {
    fn new(shape: (usize, usize)) -> Self {
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
    fn run(&mut self, way: usize) -> f64 {
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

/// Cases of both precisions, made when they are first asked for.
#[derive(Default)]
struct Cases {
    f64: HashMap<(usize, usize), Case<f64>>,
    f32: HashMap<(usize, usize), Case<f32>>,
    pools: HashMap<usize, rayon::ThreadPool>,
}

impl Cases {
    fn run(&mut self, shape: (usize, usize), single: bool, threads: usize, way: usize) -> f64 {
        let pool = self.pools.entry(threads).or_insert_with(|| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("worker threads")
        });
        if single {
            let case = self.f32.entry(shape).or_insert_with(|| Case::new(shape));
            pool.install(|| case.run(way))
        } else {
            let case = self.f64.entry(shape).or_insert_with(|| Case::new(shape));
            pool.install(|| case.run(way))
        }
    }

    /// One case at a time is held: the largest take gigabytes.
    fn forget(&mut self, kept: (usize, usize)) {
        self.f64.retain(|shape, _| *shape == kept);
        self.f32.retain(|shape, _| *shape == kept);
    }
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Bytes a second read and written by `threads` copies, past the caches for large buffers.
fn copy_rate(threads: usize) -> f64 {
    let bytes = 128 << 20;
    let (mut from, mut to) = (Buffer::new(bytes), Buffer::new(bytes));
    from.of::<u8>().fill(1);
    to.of::<u8>().fill(2);
    let part = bytes.div_ceil(threads);
    let mut copy = || {
        let start = Instant::now();
        std::thread::scope(|scope| {
            for (from, to) in from.0.chunks(part).zip(to.0.chunks_mut(part)) {
                scope.spawn(move || to.copy_from_slice(black_box(from)));
            }
        });
        start.elapsed().as_secs_f64()
    };
    let best = (0..9).map(|_| copy()).fold(f64::INFINITY, f64::min);
    2.0 * bytes as f64 / best
}

fn table(shapes: &[(usize, usize)], rounds: usize) {
    let mut cases = Cases::default();
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    println!(
        "      shape  type  threads       ms  GFLOP/s  of bound  ms of {:?}",
        &WAYS[1..]
    );
    for &shape in shapes {
        let (rows, columns) = shape;
        cases.forget(shape);
        for (single, threads) in [(false, 1), (true, 1), (false, 2), (true, 2)] {
            if threads > all {
                continue;
            }
            let mut times = vec![Vec::new(); WAYS.len()];
            for _ in 0..rounds {
                for (way, times) in times.iter_mut().enumerate() {
                    times.push(cases.run(shape, single, threads, way));
                }
            }
            let times: Vec<f64> = times.iter_mut().map(|t| median(t)).collect();
            let numbers = columns * (rows + 2 * (rows / 2 + 1));
            let bytes = numbers * if single { 4 } else { 8 };
            let work = 2.5 * (columns * rows) as f64 * (rows as f64).log2();
            let others: Vec<String> = times[1..]
                .iter()
                .map(|t| format!("{t:8.2} ({:4.2})", t / times[0]))
                .collect();
            println!(
                "{:>11}  {}  {threads:>7} {:>8.2} {:>8.1} {:>9.3}  {}",
                format!("{rows}x{columns}"),
                if single { " f32" } else { " f64" },
                times[0],
                work / times[0] / 1e6,
                bytes as f64 / copy_rate(threads) * 1e3 / times[0],
                others.join("  ")
            );
        }
    }
}

/// Answers requests until the input ends; a request that says nothing known gets an empty line.
fn serve() {
    let mut cases = Cases::default();
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let request = match words[..] {
            [rows, columns, precision, threads] => rows
                .parse()
                .ok()
                .zip(columns.parse().ok())
                .zip(threads.parse().ok())
                .map(|(shape, threads)| (shape, precision == "f32", threads)),
            _ => None,
        };
        let times = request.map_or(Vec::new(), |(shape, single, threads)| {
            cases.forget(shape);
            let run = |way| cases.run(shape, single, threads, way).to_string();
            (0..WAYS.len()).map(run).collect()
        });
        println!("{}", times.join(" "));
    }
}

fn main() {
    let has = |flag: &str| std::env::args().any(|a| a == flag);
    if has("--serve") {
        serve();
    } else if has("--test") {
        table(&[(256, 12), (257, 9), (360, 17)], 1);
    } else {
        let asked = std::env::args().filter_map(|a| {
            let (rows, columns) = a.split_once('x')?;
            rows.parse().ok().zip(columns.parse().ok())
        });
        let mut shapes: Vec<(usize, usize)> = asked.collect();
        if shapes.is_empty() {
            shapes = vec![
                (4096, 300),
                (16384, 300),
                (65536, 1000),
                (65536, 1024),
                (10007, 300),
                (9973, 301),
            ];
        }
        table(&shapes, 9);
    }
}
