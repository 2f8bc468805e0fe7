//! Transforms of both axes, and of overlapping segments of all columns: ours, and
//! the usual ways with `realfft` and `rustfft`, in turn in one process.
//!
//! `cargo bench --bench planes` prints a table; `-- --test` runs everything once on small arrays.
//! `-- --serve` answers lines `spacetime|short-time ROWS COLUMNS f32|f64 THREADS` with the milliseconds of
//! one run of each way, for `peers/planes.py`, which runs other libraries in between.
//!
//! Short-time segments are of 256 samples, 32 apart, weighed by Hann's window. GFLOP/s count `2.5 n log2 n`
//! for the transform of n real numbers; the bound is the array read and the result written once at the
//! rate of a copy past the caches.

use std::hint::black_box;
use std::io::BufRead;
use std::sync::Arc;
use std::time::Instant;

use cascade::throughput::{Buffer, copy_rate, median};
use cascade::transform::{Real, ShortTimeTransform, SpaceTimeTransform};
use ndarray::{ArrayView2, ArrayViewMut2, ArrayViewMut3, Axis, s};
use num_complex::Complex;
use rayon::prelude::*;
use realfft::{RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

const SEGMENT: usize = 256;
const HOP: usize = 32;
/// Columns gathered before they are transformed one by one: a cache line of each row.
const TILE: usize = 8;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Work {
    SpaceTime,
    ShortTime,
}

/// The plans and arrays of one kind of work and shape.
struct Case<T: Real> {
    work: Work,
    shape: (usize, usize),
    values: Buffer,
    result: Buffer,
    spacetime: SpaceTimeTransform<T>,
    short_time: ShortTimeTransform<T>,
    window: Vec<T>,
    column: Arc<dyn RealToComplex<T>>,
    row: Arc<dyn Fft<T>>,
}

impl<T: Real> Case<T> {
    fn new(work: Work, (rows, columns): (usize, usize)) -> Self {
        let window: Vec<f64> = (0..SEGMENT)
            .map(|n| {
                (std::f64::consts::PI * n as f64 / SEGMENT as f64)
                    .sin()
                    .powi(2)
            })
            .collect();
        let short_time = ShortTimeTransform::new(&window, HOP);
        let numbers = match work {
            Work::SpaceTime => (rows / 2 + 1) * columns,
            Work::ShortTime => short_time.segments(rows) * short_time.bins() * columns,
        };
        let mut values = Buffer::new(rows * columns * size_of::<T>()).expect("memory");
        let mut state = 1_u64;
        for value in values.of::<T>() {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            *value = T::rounded((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5);
        }
        let length = if work == Work::ShortTime {
            SEGMENT
        } else {
            rows
        };
        Case {
            work,
            shape: (rows, columns),
            values,
            result: Buffer::new(numbers * size_of::<Complex<T>>()).expect("memory"),
            spacetime: SpaceTimeTransform::new((length, columns)),
            short_time,
            window: window.into_iter().map(T::rounded).collect(),
            column: RealFftPlanner::new().plan_fft_forward(length),
            row: FftPlanner::new().plan_fft_inverse(columns),
        }
    }

    /// Milliseconds of one run, ours or the usual way.
    fn run(&mut self, ours: bool) -> f64 {
        let (rows, columns) = self.shape;
        let values: &[T] = self.values.of();
        let values = ArrayView2::from_shape((rows, columns), values).expect("shape");
        let result: &mut [Complex<T>] = self.result.of();
        let start = Instant::now();
        match (self.work, ours) {
            (Work::SpaceTime, _) => {
                let shape = (rows / 2 + 1, columns);
                let mut spectrum = ArrayViewMut2::from_shape(shape, result).expect("shape");
                if ours {
                    self.spacetime.transform(values, spectrum);
                } else {
                    by_tiles(&*self.column, values, spectrum.view_mut());
                    by_rows(&*self.row, spectrum);
                }
            }
            (Work::ShortTime, _) => {
                let shape = (
                    self.short_time.segments(rows),
                    self.short_time.bins(),
                    columns,
                );
                let mut spectra = ArrayViewMut3::from_shape(shape, result).expect("shape");
                if ours {
                    self.short_time.transform_in_parallel(values, spectra);
                } else {
                    let (plan, window) = (&*self.column, &self.window);
                    spectra
                        .axis_iter_mut(Axis(0))
                        .into_par_iter()
                        .enumerate()
                        .for_each(|(s, spectra)| {
                            let start = s * HOP;
                            let mut segment =
                                values.slice(s![start..start + SEGMENT, ..]).to_owned();
                            for (mut row, &w) in segment.outer_iter_mut().zip(window) {
                                row.mapv_inplace(|v| v * w);
                            }
                            by_tiles(plan, segment.view(), spectra);
                        });
                }
            }
        }
        let seconds = start.elapsed().as_secs_f64();
        black_box(&mut self.result);
        1e3 * seconds
    }

    /// Read and written, once.
    fn bytes(&mut self) -> usize {
        size_of_val(self.values.of::<u8>()) + size_of_val(self.result.of::<u8>())
    }

    fn work(&self) -> f64 {
        let (rows, columns) = (self.shape.0 as f64, self.shape.1 as f64);
        match self.work {
            Work::SpaceTime => 2.5 * rows * columns * (rows * columns).log2(),
            Work::ShortTime => {
                let segments = self.short_time.segments(self.shape.0) as f64;
                2.5 * segments * columns * SEGMENT as f64 * (SEGMENT as f64).log2()
            }
        }
    }
}

fn by_rows<T: Real>(plan: &dyn Fft<T>, mut rows: ArrayViewMut2<Complex<T>>) {
    rows.axis_iter_mut(Axis(0)).into_par_iter().for_each_init(
        || vec![Complex::default(); plan.get_inplace_scratch_len()],
        |scratch, row| {
            plan.process_with_scratch(row.into_slice().expect("a row"), scratch);
        },
    );
}

/// Gathers columns, transforms each, scatters the bins.
fn by_tiles<T: Real>(
    plan: &dyn RealToComplex<T>,
    values: ArrayView2<T>,
    mut spectra: ArrayViewMut2<Complex<T>>,
) {
    let bins = plan.len() / 2 + 1;
    values
        .axis_chunks_iter(Axis(1), TILE)
        .into_par_iter()
        .zip(spectra.axis_chunks_iter_mut(Axis(1), TILE))
        .for_each_init(
            || {
                (
                    vec![T::zero(); TILE * plan.len()],
                    vec![Complex::default(); TILE * bins],
                    plan.make_scratch_vec(),
                )
            },
            |(records, found, scratch), (values, mut spectra)| {
                for (n, row) in values.outer_iter().enumerate() {
                    for (c, &v) in row.iter().enumerate() {
                        records[c * plan.len() + n] = v;
                    }
                }
                let pairs = records.chunks_exact_mut(plan.len());
                for (record, spectrum) in pairs.zip(found.chunks_exact_mut(bins)) {
                    plan.process_with_scratch(record, spectrum, scratch)
                        .expect("the plan's own lengths");
                }
                for (m, mut row) in spectra.outer_iter_mut().enumerate() {
                    for (c, bin) in row.iter_mut().enumerate() {
                        *bin = found[c * bins + m];
                    }
                }
            },
        );
}

fn with_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("worker threads").install(work)
}

fn line<T: Real>(name: &str, work: Work, shape: (usize, usize), threads: usize, rounds: usize) {
    let mut case = Case::<T>::new(work, shape);
    let (mut ours, mut usual) = (Vec::new(), Vec::new());
    with_threads(threads, || {
        for _ in 0..rounds {
            ours.push(case.run(true));
            usual.push(case.run(false));
        }
    });
    let ratios: Vec<f64> = ours.iter().zip(&usual).map(|(a, b)| b / a).collect();
    let ratio = median(ratios);
    let ours = median(ours);
    println!(
        "{:>10} {:>11} {name} {threads:>7} {ours:>9.2} {:>8.1} {:>9.3} {:>9.2} ({ratio:.2})",
        format!("{work:?}"),
        format!("{}x{}", shape.0, shape.1),
        case.work() / ours / 1e6,
        case.bytes() as f64 / copy_rate(threads).expect("memory") * 1e3 / ours,
        median(usual),
    );
}

/// Answers requests until the input ends; a request that says nothing known gets an empty line.
fn serve() {
    let mut single: Option<Case<f32>> = None;
    let mut double: Option<Case<f64>> = None;
    for request in std::io::stdin().lock().lines().map_while(Result::ok) {
        let words: Vec<&str> = request.split_whitespace().collect();
        let known = match words[..] {
            [work, rows, columns, precision, threads] => {
                let work = match work {
                    "spacetime" => Work::SpaceTime,
                    _ => Work::ShortTime,
                };
                let shape = rows.parse().ok().zip(columns.parse().ok());
                shape
                    .zip(threads.parse().ok())
                    .map(|(shape, threads)| (work, shape, precision == "f32", threads))
            }
            _ => None,
        };
        let Some((work, shape, is_single, threads)) = known else {
            println!();
            continue;
        };
        let times = if is_single {
            double = None;
            single = single.filter(|c| c.work == work && c.shape == shape);
            let case = single.get_or_insert_with(|| Case::new(work, shape));
            with_threads(threads, || [case.run(true), case.run(false)])
        } else {
            single = None;
            double = double.filter(|c| c.work == work && c.shape == shape);
            let case = double.get_or_insert_with(|| Case::new(work, shape));
            with_threads(threads, || [case.run(true), case.run(false)])
        };
        println!("{} {}", times[0], times[1]);
    }
}

fn main() {
    let has = |flag: &str| std::env::args().any(|a| a == flag);
    if has("--serve") {
        return serve();
    }
    let (cases, rounds) = if has("--test") {
        (
            [(Work::SpaceTime, (96, 20)), (Work::ShortTime, (320, 10))],
            1,
        )
    } else {
        (
            [
                (Work::SpaceTime, (8192, 8192)),
                (Work::ShortTime, (16384, 300)),
            ],
            5,
        )
    };
    println!(
        "      work       shape type threads        ms  GFLOP/s  of bound  realfft, rustfft (ratio)"
    );
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    for (work, shape) in cases {
        for threads in [1, 2] {
            if threads <= all {
                line::<f64>(" f64", work, shape, threads, rounds);
                line::<f32>(" f32", work, shape, threads, rounds);
            }
        }
    }
}
