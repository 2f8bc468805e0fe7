//! Runs that end early: soon, and with the reason.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use ndarray::{Array2, ArrayView2};
use test_support::fields::asking;
use wavecascade::analyze::{Request, Results, plan, run};
use wavecascade::arrays::{LargeArray, Nowhere, Sink};
use wavecascade::observer::{Observer, Silent};
use wavecascade::{Error, Field, Result};

/// How long a put that is no failure takes after the failure, which is being noted meanwhile.
const PAUSE: Duration = Duration::from_millis(20);

/// Fails where one array is put; the others wait for that, and are counted.
struct Full {
    fails: LargeArray,
    failed: AtomicBool,
    others: AtomicUsize,
}

impl Sink for Full {
    fn reserve(&self, _: LargeArray, _: (usize, usize)) -> Result<()> {
        Ok(())
    }

    fn put(&self, array: LargeArray, _: usize, _: usize, _: ArrayView2<f64>) -> Result<()> {
        if array == self.fails {
            self.failed.store(true, Ordering::SeqCst);
            return Err(Error::Write {
                path: PathBuf::from("full"),
                action: "write to",
                source: std::io::ErrorKind::StorageFull.into(),
            });
        }
        self.others.fetch_add(1, Ordering::SeqCst);
        let started = Instant::now();
        while !self.failed.load(Ordering::SeqCst) && started.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(PAUSE);
        Ok(())
    }
}

fn field(shape: (usize, usize)) -> Field {
    let value = |(n, j): (usize, usize)| (0.01 * (n * (j + 1)) as f64).sin();
    Field::from_array(Array2::from_shape_fn(shape, value))
}

/// Records and profiles go side by side: where one cannot be written, the other stops long before
/// its last block, and the disk is to blame. With space-time, records are put by blocks of
/// frequencies.
#[test]
fn a_disk_that_is_full_stops_what_goes_beside() {
    let field = field((30_000, 64));
    for fails in [LargeArray::TEMPORAL_SPECTRUM, LargeArray::SPATIAL_SPECTRUM] {
        let spacetime = fails == LargeArray::SPATIAL_SPECTRUM;
        let request = Request {
            results: Results {
                temporal: true,
                spatial: true,
                spacetime,
                ..Results::NONE
            },
            threads: Some(2),
            memory: Some(1 << 30),
            ..Request::default()
        };
        let plan = plan(&field, &request).unwrap();
        let blocks = plan.blocks();
        let beside = match spacetime {
            true => (field.n_times() / 2 + 1).div_ceil(blocks.frequencies),
            false => field.n_times().div_ceil(blocks.times),
        };
        assert!(beside >= 8, "{beside}");
        let sink = Full {
            fails,
            failed: AtomicBool::new(false),
            others: AtomicUsize::new(0),
        };
        let error = run(&field, &plan, &sink, &Silent).unwrap_err();
        let is_full = matches!(&error, Error::Write { path, .. } if path.ends_with("full"));
        assert!(is_full, "{error}");
        let others = sink.others.into_inner();
        assert!(others <= beside / 2, "{others} of {beside}");
    }
}

/// Has patience for so many questions.
struct Patience(AtomicUsize);

impl Observer for Patience {
    fn cancelled(&self) -> bool {
        let spend = |left: usize| left.checked_sub(1);
        let order = Ordering::SeqCst;
        self.0.fetch_update(order, order, spend).is_err()
    }
}

/// Wherever it is told to, whether records and profiles go side by side or one after the other.
#[test]
fn a_run_that_is_told_to_stop_says_so() {
    let field = field((6_000, 200));
    for (memory, streams) in [(1 << 30, false), (30 << 20, true)] {
        let request = asking(|it| (it.threads, it.memory) = (Some(2), Some(memory)));
        let plan = plan(&field, &request).unwrap();
        assert_eq!(plan.streams(), streams);
        let run_for = |questions: usize| {
            let patience = Patience(AtomicUsize::new(questions));
            let ended = run(&field, &plan, &Nowhere, &patience);
            (ended.map(|_| ()), questions - patience.0.into_inner())
        };
        let (ended, questions) = run_for(usize::MAX);
        ended.unwrap();
        // In every pass: the look at the samples alone has some twenty.
        assert!(questions >= 200, "{questions}");
        for asked in (0..questions).step_by(questions / 10) {
            let (ended, _) = run_for(asked);
            let is_told = matches!(ended, Err(Error::Cancelled));
            assert!(is_told, "{asked} of {questions}: {ended:?}");
        }
    }
}
