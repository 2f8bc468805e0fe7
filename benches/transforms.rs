//! Throughput of the three transforms against the bound of reading the field and writing the
//! result once at this machine's copy bandwidth.
//!
//! `cargo bench --bench transforms` measures; `cargo bench --bench transforms -- --test` runs
//! everything once on small fields. The bound counts the bytes a stage must move (field read,
//! spectrum written, both `f64`), not those it moves; a copy of n bytes reads n and writes n. The
//! copy is the standard library's (`memcpy`, which uses non-temporal stores where the system's
//! does for buffers of this size), over 256 MiB, one thread and as many as the transforms use.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, Throughput};
use ndarray::ArrayView2;
use wavecascade::Field;
use wavecascade::analyze::{Request, Results, plan, run};
use wavecascade::arrays::{LargeArray, Sink};
use wavecascade::observer::Silent;
use wavecascade::reference::{Grid, WhiteNoise};

const COPIED: usize = 256 << 20;

/// Drops the arrays, so that neither disk nor page cache is measured.
struct Nowhere;

impl Sink for Nowhere {
    fn reserve(&self, _: LargeArray, _: (usize, usize)) -> wavecascade::Result<()> {
        Ok(())
    }

    fn put(
        &self,
        _: LargeArray,
        _: usize,
        _: usize,
        block: ArrayView2<f64>,
    ) -> wavecascade::Result<()> {
        black_box(block);
        Ok(())
    }
}

/// A result asked for alone, and the stages whose times add up to its transform.
struct Transform {
    name: &'static str,
    results: Results,
    stages: &'static [&'static str],
}

const TRANSFORMS: [Transform; 3] = [
    Transform {
        name: "along time",
        results: Results {
            temporal: true,
            ..Results::NONE
        },
        stages: &["along time"],
    },
    Transform {
        name: "along space",
        results: Results {
            spatial: true,
            ..Results::NONE
        },
        stages: &["along space"],
    },
    Transform {
        name: "space-time",
        results: Results {
            spacetime: true,
            ..Results::NONE
        },
        stages: &["along time", "space-time"],
    },
];

fn noise(n_times: usize, n_sites: usize) -> Field {
    let grid = Grid {
        n_times,
        n_sites,
        dt: 1.0,
        dx: 1.0,
    };
    let deviation = 1.0;
    let seed = 1;
    WhiteNoise {
        grid,
        deviation,
        seed,
    }
    .field()
}

/// Bytes read and written a second by `threads` copies of parts of one buffer; the best of 9.
fn copy_bandwidth(threads: usize, bytes: usize) -> f64 {
    let from = vec![1_u8; bytes];
    let mut to = vec![2_u8; bytes];
    let part = bytes.div_ceil(threads);
    let mut copy = || {
        let start = Instant::now();
        std::thread::scope(|scope| {
            for (from, to) in from.chunks(part).zip(to.chunks_mut(part)) {
                scope.spawn(move || to.copy_from_slice(black_box(from)));
            }
        });
        black_box(&to);
        start.elapsed().as_secs_f64()
    };
    let best = (0..9).map(|_| copy()).fold(f64::INFINITY, f64::min);
    2.0 * bytes as f64 / best
}

/// The time that a run spends in `stages`.
fn stage_time(field: &Field, request: &Request, stages: &[&str]) -> wavecascade::Result<Duration> {
    let analysis = run(field, &plan(field, request)?, &Nowhere, &Silent)?;
    let of_stages = analysis
        .timings
        .iter()
        .filter(|t| stages.contains(&t.stage));
    Ok(Duration::from_secs_f64(of_stages.map(|t| t.seconds).sum()))
}

/// Bytes of the field and of the arrays asked for.
fn bytes_once(field: &Field, request: &Request) -> wavecascade::Result<u64> {
    let samples = field.n_times() * field.n_sites();
    let results = plan(field, request)?.arrays;
    let results: usize = results
        .iter()
        .map(|(_, (rows, columns))| rows * columns)
        .sum();
    Ok(8 * (samples + results) as u64)
}

fn shapes(criterion: &mut Criterion, quick: bool, threads: &[usize]) -> wavecascade::Result<()> {
    let shapes = if quick {
        [(256, 12), (257, 16), (101, 13)]
    } else {
        [(16384, 300), (65536, 1024), (10007, 301)]
    };
    let copies: Vec<f64> = threads
        .iter()
        .map(|&threads| copy_bandwidth(threads, if quick { 1 << 20 } else { COPIED }))
        .collect();
    let mut table = Vec::new();
    for (n_times, n_sites) in shapes {
        let field = noise(n_times, n_sites);
        let shape = format!("{n_times}x{n_sites}");
        for (&threads, &copy) in threads.iter().zip(&copies) {
            let mut group = criterion.benchmark_group(format!("{shape}, {threads} threads"));
            group
                .sample_size(10)
                .warm_up_time(Duration::from_millis(100));
            for transform in &TRANSFORMS {
                let request = Request {
                    results: transform.results,
                    threads: Some(threads),
                    ..Request::default()
                };
                let bytes = bytes_once(&field, &request)?;
                let mut seconds = Vec::new();
                group.throughput(Throughput::Bytes(bytes));
                group.bench_function(BenchmarkId::from_parameter(transform.name), |bencher| {
                    bencher.iter_custom(|runs| {
                        let mut total = Duration::ZERO;
                        for _ in 0..runs {
                            let time = stage_time(&field, &request, transform.stages);
                            let time = time.unwrap_or(Duration::MAX);
                            seconds.push(time.as_secs_f64());
                            total = total.saturating_add(time);
                        }
                        total
                    });
                });
                let rate = bytes as f64 / median(&mut seconds);
                table.push(format!(
                    "{shape:>11}  {threads:>7}  {:<11}  {:6.2}  {:6.1}  {:6.3}",
                    transform.name,
                    rate / 1e9,
                    copy / 1e9,
                    rate / copy
                ));
            }
            let request = Request {
                threads: Some(threads),
                ..Request::default()
            };
            group.throughput(Throughput::Bytes(bytes_once(&field, &request)?));
            group.bench_function("all results, dropped", |bencher| {
                bencher.iter(|| {
                    plan(&field, &request).and_then(|plan| run(&field, &plan, &Nowhere, &Silent))
                });
            });
            group.finish();
        }
    }
    println!("      shape  threads  transform      GB/s    copy  of the bound");
    for line in table {
        println!("{line}");
    }
    Ok(())
}

fn median(seconds: &mut [f64]) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds.get(seconds.len() / 2).copied().unwrap_or(f64::NAN)
}

fn main() -> wavecascade::Result<()> {
    let quick = std::env::args().any(|a| a == "--test");
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = if all > 1 { vec![1, all] } else { vec![1] };
    let mut criterion = Criterion::default().configure_from_args();
    shapes(&mut criterion, quick, &threads)?;
    criterion.final_summary();
    Ok(())
}
