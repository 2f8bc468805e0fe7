//! How long localized waves take.
//!
//! `cargo bench --bench localized` prints, in CSV, the median and the shortest wall-clock time of:
//! orders 1 to 8 and 1 to 19 on one thread, each with the largest estimated error of a ratio;
//! the leaks of 400 struck chains of 200 cells, and the direct minima of orders 1 to 8, on all
//! threads; an order-2 wave launched over 1000 cells, twice, on one. With `--test` each is run once,
//! small.

use std::time::Instant;

use wavecascade::localized::{Comparison, Family, LeakScan};
use wavecascade::observer::Silent;

fn main() {
    let small = std::env::args().any(|argument| argument == "--test");
    let repeats = if small { 1 } else { 5 };
    println!("work,threads,median_s,shortest_s,largest_error");
    for last in if small { vec![2] } else { vec![8, 19] } {
        one_thread(|| {
            report(&format!("orders 1 to {last}"), 1, repeats, || {
                let search = Family::default().search(last).expect("estimates");
                (1..=last)
                    .map(|order| search.wave(order).expect("a wave").convergence.error())
                    .fold(0.0, f64::max)
            });
        });
    }
    let (ratios, cells) = if small { (4, 60) } else { (400, 200) };
    let scan = LeakScan {
        family: Family::default(),
        cells,
        local_error: 1e-11,
    };
    // Evenly in the root of the stiffening, up to order 19.
    let ratios: Vec<f64> = (0..ratios)
        .map(|j| (1.0 + 11.0 * f64::from(j) / f64::from(ratios)).powi(3))
        .collect();
    let threads = rayon::current_num_threads();
    let work = format!("leaks of {} chains of {cells} cells", ratios.len());
    report(&work, threads, repeats.min(3), || {
        let leaks = scan.run(&ratios, &Silent).expect("leaks");
        leaks.iter().filter(|leak| leak.per_cell.is_nan()).count() as f64
    });
    let comparison = Comparison {
        family: Family::default(),
        orders: 1..=if small { 1 } else { 8 },
        cells: Some(cells),
        cylinders: None,
    };
    report(
        "orders 1 to 8 with direct minima",
        threads,
        repeats.min(3),
        || {
            let rows = comparison.run(&Silent).expect("rows");
            let errors = rows.iter().filter_map(|row| Some(row.direct?.error));
            errors.fold(0.0, f64::max)
        },
    );
    let wave = Family::default()
        .search(2)
        .and_then(|s| s.wave(2))
        .expect("a wave");
    let cells = if small { 10 } else { 1000 };
    one_thread(|| {
        report(
            &format!("order 2 launched over {cells} cells"),
            1,
            repeats,
            || {
                let journey = wave.journey(cells, &Silent).expect("a journey");
                journey.arrived.shape_change
            },
        );
    });
}

fn one_thread(work: impl FnOnce() + Send) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("a thread").install(work);
}

/// Prints the time of some work, and the error that it returns.
fn report(name: &str, threads: usize, repeats: usize, work: impl Fn() -> f64) {
    let mut error = 0.0;
    let mut seconds: Vec<f64> = (0..repeats)
        .map(|_| {
            let started = Instant::now();
            error = work();
            started.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    println!(
        "{name},{threads},{:.3},{:.3},{error:.1e}",
        seconds[seconds.len() / 2],
        seconds[0]
    );
}
