//! Columns of real arrays: this crate, and `realfft` and `rustfft` of columns gathered eight by eight.
//!
//! `cargo bench -p column-fft`; throughput counts the bytes of the array and of its spectrum.

use std::hint::black_box;

use column_fft::rows::{plan_fft_complex, plan_fft_forward};
use column_fft::{ColumnFftPlanner, Columns, ColumnsMut, FftDirection, Real};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use num_complex::Complex;

/// Columns gathered together: a cache line of each row.
const TILE: usize = 8;

fn noise<T: Real>(numbers: usize) -> Vec<T> {
    let mut state = 1_u64;
    let next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        T::rounded((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
    };
    std::iter::repeat_with(next).take(numbers).collect()
}

fn arrays<T: Real>(criterion: &mut Criterion, name: &str) {
    let mut group = criterion.benchmark_group(format!("columns, {name}"));
    group.sample_size(10);
    for (rows, columns) in [(256, 37), (4096, 300), (16384, 300), (10007, 300)] {
        let bins = rows / 2 + 1;
        let values = noise::<T>(rows * columns);
        let mut spectra = vec![Complex::<T>::default(); bins * columns];
        let bytes = columns * (rows + 2 * bins) * size_of::<T>();
        group.throughput(Throughput::Bytes(bytes as u64));
        let shape = format!("{rows}x{columns}");

        let plan = ColumnFftPlanner::<T>::new().plan_fft_forward(rows).unwrap();
        let mut scratch = plan.make_scratch(columns);
        group.bench_function(BenchmarkId::new("column-fft", &shape), |bencher| {
            bencher.iter(|| {
                let input = Columns::new(black_box(&values), rows, columns, columns).unwrap();
                let output = ColumnsMut::new(&mut spectra, bins, columns, columns).unwrap();
                plan.process_with_scratch(input, output, &mut scratch)
                    .unwrap();
            });
        });

        let plan = plan_fft_forward::<T>(rows);
        let mut scratch = plan.make_scratch_vec();
        let mut records = vec![T::zero(); rows * TILE];
        let mut found = vec![Complex::default(); bins * TILE];
        group.bench_function(BenchmarkId::new("realfft", &shape), |bencher| {
            bencher.iter(|| {
                for first in (0..columns).step_by(TILE) {
                    let width = TILE.min(columns - first);
                    for (n, row) in black_box(&values).chunks_exact(columns).enumerate() {
                        for c in 0..width {
                            records[c * rows + n] = row[first + c];
                        }
                    }
                    let tile = records
                        .chunks_exact_mut(rows)
                        .zip(found.chunks_exact_mut(bins));
                    for (record, spectrum) in tile.take(width) {
                        plan.process_with_scratch(record, spectrum, &mut scratch)
                            .unwrap();
                    }
                    for (m, row) in spectra.chunks_exact_mut(columns).enumerate() {
                        for c in 0..width {
                            row[first + c] = found[c * bins + m];
                        }
                    }
                }
            });
        });

        let plan = plan_fft_complex::<T>(rows, FftDirection::Forward);
        let mut scratch = vec![Complex::default(); plan.get_inplace_scratch_len()];
        let mut records = vec![Complex::<T>::default(); rows * TILE];
        group.bench_function(BenchmarkId::new("rustfft", &shape), |bencher| {
            bencher.iter(|| {
                for first in (0..columns).step_by(TILE) {
                    let width = TILE.min(columns - first);
                    for (n, row) in black_box(&values).chunks_exact(columns).enumerate() {
                        for c in 0..width {
                            records[c * rows + n] = Complex::new(row[first + c], T::zero());
                        }
                    }
                    plan.process_with_scratch(&mut records[..rows * width], &mut scratch);
                    for (m, row) in spectra.chunks_exact_mut(columns).enumerate() {
                        for c in 0..width {
                            row[first + c] = records[c * rows + m];
                        }
                    }
                }
            });
        });
    }
    group.finish();
}

fn columns(criterion: &mut Criterion) {
    arrays::<f64>(criterion, "f64");
    arrays::<f32>(criterion, "f32");
}

criterion_group!(benches, columns);
criterion_main!(benches);
