//! What an analysis holds at most, by an allocator that keeps count, against what its plan says.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use ndarray::Array2;
use wavecascade::analyze::{Request, plan, run};
use wavecascade::arrays::Nowhere;
use wavecascade::observer::Silent;
use wavecascade::{Error, Field};

struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: all is left to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        MOST.fetch_max(held, Ordering::Relaxed);
        // SAFETY: the caller's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Long records, wide profiles, lengths that are primes: each with all the memory it wants, and in the
/// least that is accepted. One test, since others would be counted with it.
#[test]
fn no_more_is_held_than_the_plan_says() {
    for (n_times, n_sites) in [
        (20_011, 61),
        (61, 20_011),
        (24, 100_003),
        (65_536, 24),
        (500, 1000),
    ] {
        let value = |(n, j): (usize, usize)| ((n * 31 + j * 7) as f64).sin();
        let field = Field::from_array(Array2::from_shape_fn((n_times, n_sites), value));
        for threads in [1, 2, 5] {
            let request = |memory| Request {
                threads: Some(threads),
                memory: Some(memory),
                ..Request::default()
            };
            // First the axes must fit, then all else.
            let mut least = 1;
            while let Err(Error::Memory { needed, .. }) = plan(&field, &request(least)) {
                assert!(needed > least);
                least = needed;
            }
            for allowed in [4 << 30, least] {
                let planned = plan(&field, &request(allowed)).unwrap();
                let before = HELD.load(Ordering::Relaxed);
                MOST.store(before, Ordering::Relaxed);
                run(&field, &planned, &Nowhere, &Silent).unwrap();
                let allocated = MOST.load(Ordering::Relaxed) - before;
                // The field, which was there before, and what pages of their own are asked for.
                let between = match planned.scratch_file {
                    0 => 16 * (n_times / 2 + 1) * n_sites,
                    _ => 0,
                };
                let held = (allocated + between + 8 * n_times * n_sites) as u64;
                let case = format!("{n_times} x {n_sites}, {threads} threads, {allowed} allowed");
                let needed = planned.memory_needed;
                assert!(needed <= allowed, "{case}: {needed}");
                assert!(held <= needed, "{case}: {held} of {needed}");
                // More threads than processors may or may not hold their parts at once. One thread's
                // stages do not all hold theirs: 2.08 times as much is planned at most, with AVX-512,
                // whose tiles are the widest.
                assert!(
                    threads > 1 || 10 * needed <= 21 * held,
                    "{case}: {held} of {needed}"
                );
            }
        }
    }
}
