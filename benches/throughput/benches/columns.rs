//! Transforms of all columns of a (time, site) array: ours, and the usual ways with `realfft` and
//! `rustfft`, in turn in one process.
//!
//! `cargo bench -p throughput --bench columns` prints a table, `-- 4096x300` of that shape alone; `-- --test` runs everything once on small arrays.
//! `-- --serve` answers lines `ROWS COLUMNS f32|f64 THREADS` with the milliseconds of one run of
//! each way, for `peers/columns.py`, which runs other libraries in between; for its errors,
//! `-- --spectra ROWS COLUMNS f32|f64 FILE EVERY` writes what each way makes of the values in a file.
//!
//! What is measured and how is [`throughput`]'s, whose program is the short form.

use std::collections::HashMap;
use std::io::BufRead;
use std::path::Path;

use throughput::{
    ArrayShape, Arrays, CaseOf, Clock, Implementation, PlannedTransform, Precision, Rounds,
    TransformKind, table,
};

/// Arrays of both precisions, made when they are first asked for.
#[derive(Default)]
struct Cases {
    f64: HashMap<ArrayShape, Arrays<f64>>,
    f32: HashMap<ArrayShape, Arrays<f32>>,
    pools: HashMap<usize, rayon::ThreadPool>,
}

impl Cases {
    fn run(&mut self, case: CaseOf, way: Implementation) -> f64 {
        let CaseOf {
            shape,
            precision,
            threads,
            ..
        } = case;
        let pool = self.pools.entry(threads).or_insert_with(|| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("worker threads")
        });
        let memory = "memory for the arrays";
        match precision {
            Precision::F32 => {
                let arrays = self.f32.entry(shape);
                let arrays = arrays.or_insert_with(|| Arrays::new(shape).expect(memory));
                pool.install(|| Clock::Wall.milliseconds(|| arrays.run(way, threads > 1)))
            }
            Precision::F64 => {
                let arrays = self.f64.entry(shape);
                let arrays = arrays.or_insert_with(|| Arrays::new(shape).expect(memory));
                pool.install(|| Clock::Wall.milliseconds(|| arrays.run(way, threads > 1)))
            }
        }
    }

    /// One shape at a time is held: the largest take gigabytes.
    fn forget(&mut self, kept: ArrayShape) {
        self.f64.retain(|shape, _| *shape == kept);
        self.f32.retain(|shape, _| *shape == kept);
    }
}

fn precision(word: &str) -> Precision {
    match word {
        "f32" => Precision::F32,
        _ => Precision::F64,
    }
}

/// Prints the table of these shapes with one thread and with two, as far as there are so many cores.
fn tables(shapes: &[ArrayShape], rounds: usize) {
    let ways = Implementation::ALL.to_vec();
    let rounds = Rounds { rounds, ways };
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    for &shape in shapes {
        let mut found = Vec::new();
        for threads in (1..=2).filter(|&threads| threads <= all) {
            for precision in [Precision::F64, Precision::F32] {
                let case = CaseOf {
                    kind: TransformKind::Columns,
                    shape,
                    precision,
                    threads,
                };
                found.push(rounds.measure(case).expect("memory and threads"));
            }
        }
        println!("{}", table(&found));
    }
}

/// Answers requests until the input ends; a request that says nothing known gets an empty line.
fn serve() {
    let mut cases = Cases::default();
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let case = match words[..] {
            [rows, columns, kind, threads] => {
                let shape: Result<ArrayShape, String> = format!("{rows}x{columns}").parse();
                let threads = threads.parse().ok().filter(|&threads| threads > 0);
                shape.ok().zip(threads).map(|(shape, threads)| CaseOf {
                    kind: TransformKind::Columns,
                    shape,
                    precision: precision(kind),
                    threads,
                })
            }
            _ => None,
        };
        let times = case.map_or(Vec::new(), |case| {
            cases.forget(case.shape);
            let times = Implementation::ALL.map(|way| cases.run(case, way).to_string());
            times.to_vec()
        });
        println!("{}", times.join(" "));
    }
}

/// Writes spectra of `ROWS COLUMNS f32|f64 FILE EVERY`, with one thread.
fn spectra(words: &[String]) {
    let [rows, columns, kind, file, every] = words else {
        panic!("--spectra takes ROWS COLUMNS f32|f64 FILE EVERY, found {words:?}");
    };
    let shape: ArrayShape = format!("{rows}x{columns}").parse().expect("a shape");
    let every = every.parse().expect("a step of columns");
    let file = Path::new(file);
    let memory = "memory for the arrays";
    let written = match precision(kind) {
        Precision::F32 => {
            let mut arrays = Arrays::<f32>::new(shape).expect(memory);
            arrays.write_spectra(file, every)
        }
        Precision::F64 => {
            let mut arrays = Arrays::<f64>::new(shape).expect(memory);
            arrays.write_spectra(file, every)
        }
    };
    written.expect("the files of values and spectra");
}

fn main() {
    let words: Vec<String> = std::env::args().collect();
    if let Some(at) = words.iter().position(|word| word == "--spectra") {
        let rest = &words[at + 1..];
        return spectra(rest.strip_suffix(&["--bench".into()]).unwrap_or(rest));
    }
    let has = |flag: &str| words.iter().any(|word| word == flag);
    let shapes = |all: &[(usize, usize)]| -> Vec<ArrayShape> {
        let shape = |&(rows, columns): &(usize, usize)| ArrayShape::new(rows, columns);
        all.iter().map(shape).collect()
    };
    if has("--serve") {
        serve();
    } else if has("--test") {
        tables(&shapes(&[(256, 12), (257, 9), (360, 17)]), 1);
    } else {
        let asked: Vec<ArrayShape> = words.iter().filter_map(|word| word.parse().ok()).collect();
        let long = [
            (4096, 300),
            (16384, 300),
            (65536, 1000),
            (65536, 1024),
            (10007, 300),
            (9973, 301),
        ];
        let shapes = if asked.is_empty() {
            shapes(&long)
        } else {
            asked
        };
        tables(&shapes, 9);
    }
}
