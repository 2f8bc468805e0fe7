//! What is held to look at the samples, by an allocator that keeps count.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use ndarray::Array2;
use ndarray_npy::write_npy;
use wavecascade::analyze::{Request, Results, plan, run};
use wavecascade::arrays::Nowhere;
use wavecascade::field::OpenOptions;
use wavecascade::observer::Silent;
use wavecascade::{Error, Field};

struct Counting;

/// Bytes of the largest piece of memory asked for.
static LARGEST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: all is left to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LARGEST.fetch_max(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: the caller's.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Of samples that are decoded, only the sites asked for: no piece is as large as one profile.
#[test]
fn only_sites_that_are_asked_for_are_decoded() {
    let (n_times, n_sites) = (9, 1 << 18);
    let value = |n: usize, j: usize| (n * 1009 + j * 31) as f32 % 7.0 - 3.0;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wide.npy");
    let mut values = Array2::from_shape_fn((n_times, n_sites), |(n, j)| value(n, j));
    // Beside what is asked for nobody looks; there, a gap is found in its place.
    values[[4, 99]] = f32::NAN;
    values[[6, 1000]] = f32::INFINITY;
    write_npy(&path, &values).unwrap();
    let field = Field::open(&path, &OpenOptions::default()).unwrap();
    let request = |sites: std::ops::Range<usize>| Request {
        results: Results {
            temporal: true,
            ..Results::NONE
        },
        sites: Some(sites),
        threads: Some(2),
        memory: Some(1 << 30),
        ..Request::default()
    };
    LARGEST.store(0, Ordering::Relaxed);
    let narrow = request(100..110);
    let narrow = plan(&field, &narrow).unwrap();
    let found = run(&field, &narrow, &Nowhere, &Silent).unwrap();
    let largest = LARGEST.load(Ordering::Relaxed);
    assert!(largest < 4 * n_sites, "{largest}");
    let highest = (0..n_times).flat_map(|n| (100..110).map(move |j| value(n, j)));
    let highest = highest.fold(f32::MIN, f32::max);
    let seen = found.field_map.unwrap().values;
    let seen = seen.iter().copied().fold(f32::MIN, f32::max);
    assert_eq!(seen, highest);

    let wide = plan(&field, &request(990..1010)).unwrap();
    let error = run(&field, &wide, &Nowhere, &Silent).unwrap_err();
    assert!(
        matches!(
            error,
            Error::NonFinite {
                count: 1,
                first: (6, 1000),
                sites: 1,
                ..
            }
        ),
        "{error}"
    );
    // What the threads take for two times of all sites is part of every plan.
    let request = request(0..n_sites);
    let needed = |field| plan(field, &request).unwrap().memory_needed;
    let stored = Field::from_array(values.mapv(f64::from));
    assert_eq!(needed(&field), needed(&stored));
}
