//! Transforms of all columns of a (time, site) array: ours, and the usual ways with `realfft` and
//! `rustfft`, in turn in one process.
//!
//! `cargo bench --bench columns` prints a table, `-- 4096x300` of that shape alone; `-- --test` runs everything once on small arrays.
//! `-- --serve` answers lines `ROWS COLUMNS f32|f64 THREADS` with the milliseconds of one run of
//! each way, for `peers/columns.py`, which runs other libraries in between; for its errors,
//! `-- --spectra ROWS COLUMNS f32|f64 FILE EVERY` writes what each way makes of the values in a file.
//!
//! Arrays lie in huge pages where the system has them. The bound is the array read and the
//! spectrum written once at the rate of a copy past the caches; GFLOP/s count `2.5 n log2 n` for a
//! column.

mod ways;

use std::collections::HashMap;
use std::hint::black_box;
use std::io::BufRead;
use std::path::Path;
use std::time::Instant;

use ways::{Buffer, Case, WAYS};

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

/// Writes spectra of `ROWS COLUMNS f32|f64 FILE EVERY`, with one thread.
fn spectra(words: &[String]) {
    let [rows, columns, precision, file, every] = words else {
        panic!("--spectra takes ROWS COLUMNS f32|f64 FILE EVERY, found {words:?}");
    };
    let shape = (
        rows.parse().expect("a number of rows"),
        columns.parse().expect("a number of columns"),
    );
    let every = every.parse().expect("a step of columns");
    let file = Path::new(file);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let written = pool
        .expect("a thread")
        .install(|| match precision.as_str() {
            "f32" => Case::<f32>::new(shape).write_spectra(file, every),
            _ => Case::<f64>::new(shape).write_spectra(file, every),
        });
    written.expect("the files of values and spectra");
}

fn main() {
    let words: Vec<String> = std::env::args().collect();
    if let Some(at) = words.iter().position(|word| word == "--spectra") {
        let rest = &words[at + 1..];
        return spectra(rest.strip_suffix(&["--bench".into()]).unwrap_or(rest));
    }
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
