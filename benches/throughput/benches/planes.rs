//! Transforms of both axes, and of overlapping segments of all columns: ours, and
//! the usual ways with `realfft` and `rustfft`, in turn in one process.
//!
//! `cargo bench -p throughput --bench planes` prints a table; `-- --test` runs everything once on small arrays.
//! `-- --serve` answers lines `spacetime|short-time ROWS COLUMNS f32|f64 THREADS` with the milliseconds of
//! one run of ours and one with `realfft`, for `peers/planes.py`, which runs other libraries in between.
//!
//! What is measured and how is [`throughput`]'s, whose program is the short form.

use std::io::BufRead;

use throughput::{
    ArrayShape, CaseOf, Clock, Implementation, PlannedTransform, Precision, Rounds, TransformKind,
    table,
};

const WAYS: [Implementation; 2] = [Implementation::Cascade, Implementation::Realfft];

/// Answers requests until the input ends; a request that says nothing known gets an empty line.
fn serve() {
    // One case at a time is held: the largest take gigabytes.
    let mut held: Option<(CaseOf, Box<dyn PlannedTransform>, rayon::ThreadPool)> = None;
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        let Some(case) = case(&line).filter(|case| case.check().is_ok()) else {
            println!();
            continue;
        };
        held = held.filter(|(known, ..)| *known == case);
        let (_, arrays, pool) = held.get_or_insert_with(|| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(case.threads)
                .build();
            let arrays = case.prepare().expect("memory for the arrays");
            (case, arrays, pool.expect("worker threads"))
        });
        let times = pool.install(|| {
            let mut time = |way| Clock::Wall.milliseconds(|| arrays.run(way, case.threads > 1));
            WAYS.map(|way| time(way).to_string())
        });
        println!("{}", times.join(" "));
    }
}

fn case(line: &str) -> Option<CaseOf> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [kind, rows, columns, precision, threads] = words[..] else {
        return None;
    };
    Some(CaseOf {
        kind: match kind {
            "spacetime" => TransformKind::Plane,
            "short-time" => TransformKind::ShortTime,
            _ => return None,
        },
        shape: format!("{rows}x{columns}").parse().ok()?,
        precision: match precision {
            "f32" => Precision::F32,
            _ => Precision::F64,
        },
        threads: threads.parse().ok().filter(|&threads| threads > 0)?,
    })
}

fn main() {
    let has = |flag: &str| std::env::args().any(|a| a == flag);
    if has("--serve") {
        return serve();
    }
    let (cases, rounds) = match has("--test") {
        true => (
            [
                (TransformKind::Plane, 96, 20),
                (TransformKind::ShortTime, 320, 10),
            ],
            1,
        ),
        false => (
            [
                (TransformKind::Plane, 8192, 8192),
                (TransformKind::ShortTime, 16384, 300),
            ],
            5,
        ),
    };
    let ways = vec![
        Implementation::Cascade,
        Implementation::Realfft,
        Implementation::Rustfft,
    ];
    let rounds = Rounds { rounds, ways };
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    for (kind, rows, columns) in cases {
        let mut found = Vec::new();
        for threads in (1..=2).filter(|&threads| threads <= all) {
            for precision in [Precision::F64, Precision::F32] {
                let shape = ArrayShape::new(rows, columns);
                let case = CaseOf {
                    kind,
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
