//! What an analysis, or an average, holds at most, by an allocator that keeps count, against what it says that it needs.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::RefCell;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use ndarray::Array2;
use ndarray_npy::write_npy;
use test_support::changed;
use test_support::fields::TEMPORAL;
use test_support::made::values;
use wavecascade::analyze::{Request, filtered, plan, run};
use wavecascade::arrays::{LargeArray, Nowhere};
use wavecascade::estimates::{
    Averaging, CoherenceRequest, DividedRequest, Part, Partial, SpectrumRequest, Tapers, coherence,
    combine, join, partial, spectrum,
};
use wavecascade::field::OpenOptions;
use wavecascade::observer::Silent;
use wavecascade::transform::Passband;
use wavecascade::{Error, Field};

struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);
/// Bytes of the largest piece of memory asked for.
static LARGEST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: all is left to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        MOST.fetch_max(held, Ordering::Relaxed);
        LARGEST.fetch_max(layout.size(), Ordering::Relaxed);
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

/// One test at a time, since others would be counted with it.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Bytes that `work` takes at most beside what is held before.
fn taken<T>(work: impl FnOnce() -> T) -> (u64, T) {
    let before = HELD.load(Ordering::Relaxed);
    MOST.store(before, Ordering::Relaxed);
    let made = work();
    ((MOST.load(Ordering::Relaxed) - before) as u64, made)
}

/// The bytes that a refusal says are needed.
fn needed<T>(refused: Result<T, Error>) -> u64 {
    match refused.map(|_| ()) {
        Err(Error::Memory { needed, .. }) => needed,
        other => panic!("a refusal: {other:?}"),
    }
}

/// Long records, wide profiles, lengths that are primes: each with all the memory it wants, and in the
/// least that is accepted.
#[test]
fn no_more_is_held_than_the_plan_says() {
    let _alone = alone();
    for (n_times, n_sites) in [
        (20_011, 61),
        (61, 20_011),
        (24, 100_003),
        (65_536, 24),
        (500, 1000),
    ] {
        let field = field((n_times, n_sites));
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
                let (allocated, ran) = taken(|| run(&field, &planned, &Nowhere, &Silent));
                ran.unwrap();
                // The field, which was there before, and what pages of their own are asked for.
                let between = match planned.scratch_file {
                    0 => 16 * (n_times / 2 + 1) * n_sites,
                    _ => 0,
                };
                let held = allocated + (between + 8 * n_times * n_sites) as u64;
                let case = format!("{n_times} x {n_sites}, {threads} threads, {allowed} allowed");
                let needed = planned.memory_needed;
                assert!(needed <= allowed, "{case}: {needed}");
                assert!(held <= needed, "{case}: {held} of {needed}");
                // More threads than processors may or may not hold their parts at once. One thread's
                // stages do not all hold theirs: 2.08 times as much is planned at most, with AVX-512,
                // whose tiles are the widest.
                let is_tight = threads > 1 || 10 * needed <= 21 * held;
                assert!(is_tight, "{case}: {held} of {needed}");
            }
        }
    }
}

fn field((n_times, n_sites): (usize, usize)) -> Field {
    let value = |(n, j): (usize, usize)| ((n * n % 8191 * 31 + j * 7) as f64).sin();
    Field::from_array(Array2::from_shape_fn((n_times, n_sites), value))
}

fn averaging(segment: usize, tapers: Tapers) -> Averaging {
    Averaging {
        segment: Some(segment),
        tapers,
        ..Averaging::default()
    }
}

const SLEPIAN: Tapers = Tapers::Slepian { nw: 3.0, count: 5 };

/// Combining parts, and joining them: plain and by adaptive weights.
#[test]
fn parts_hold_no_more_than_is_counted() {
    let _alone = alone();
    let of_spectrum = |segment, tapers| -> DividedRequest {
        let default = SpectrumRequest::default();
        changed(default, |it| {
            (it.averaging, it.has_jackknife) = (averaging(segment, tapers), false);
        })
        .into()
    };
    let coherence = |segment, tapers| -> DividedRequest {
        let averaging = averaging(segment, tapers);
        changed(CoherenceRequest::default(), |it| it.averaging = averaging).into()
    };
    let hann = || Averaging::default().tapers;
    let off = RefCell::new(Vec::new());
    for (records, shape, parts, request) in [
        (1, (6000, 50), 4, of_spectrum(500, hann())),
        (3, (3000, 50), 4, of_spectrum(500, SLEPIAN)),
        (1, (6000, 50), 4, coherence(500, hann())),
        (3, (8000, 9), 2, coherence(4000, SLEPIAN)),
    ] {
        let fields = vec![field(shape); records];
        let fields: Vec<&Field> = fields.iter().collect();
        let parts: Vec<Partial> = (1..=parts)
            .map(|number| Part::new(number, parts).unwrap())
            .map(|part| partial(&fields, &request, part, &Silent).unwrap())
            .collect();
        let held: u64 = parts.iter().map(|part| part.bytes() as u64).sum();
        let case = format!("{records} {shape:?} {request:?}");
        let check = |what: &str, (most, counted): (u64, u64), slack: u64| {
            if most > counted || 10 * counted > slack * most {
                off.borrow_mut()
                    .push(format!("{what}: {most} of {counted}, {case}"));
            }
        };

        let counted = needed(combine(&parts, Some(1), None));
        let (most, combined) = taken(|| combine(&parts, Some(counted), None));
        combined.unwrap();
        check("combine", (held + most, counted), 20);

        let last = &parts[parts.len() / 2..];
        let held = last.iter().map(|part| part.bytes() as u64).sum::<u64>();
        let counted = needed(join(last, Some(1)));
        let (most, joined) = taken(|| join(last, Some(counted)));
        joined.unwrap();
        check("join", (held + most, counted), 20);
    }
    assert_eq!(off.into_inner(), Vec::<String>::new());
}

/// Segments so long that the search of delays takes the most.
#[test]
fn coherence_holds_no_more_than_is_counted() {
    let _alone = alone();
    for (shape, segment, tapers) in [
        ((40_000, 3), 40_000, SLEPIAN),
        ((70_000, 17), 33_000, Averaging::default().tapers),
        ((40_000, 9), 2_000, SLEPIAN),
    ] {
        let field = field(shape);
        for threads in [1, 2, 5] {
            let of = |memory| {
                let request = CoherenceRequest {
                    averaging: averaging(segment, tapers.clone()),
                    threads: Some(threads),
                    memory: Some(memory),
                    ..CoherenceRequest::default()
                };
                coherence(&[&field], &request, &Silent)
            };
            let counted = needed(of(1));
            for allowed in [counted, 4 << 30] {
                let (most, found) = taken(|| of(allowed));
                found.unwrap();
                let case = format!("{shape:?} {segment} {threads} threads, {allowed} allowed");
                assert!(most <= counted, "{case}: {most} of {counted}");
                let is_tight = threads > 1 || 10 * counted <= 20 * most;
                assert!(is_tight, "{case}: {most} of {counted}");
            }
        }
    }
}

/// Many sites, whose results take most: with a jackknife, without, and with lines.
#[test]
fn a_spectrum_holds_no_more_than_is_counted() {
    let _alone = alone();
    let hann = Averaging::default().tapers;
    for (shape, segment, tapers, has_jackknife) in [
        ((6000, 700), 1024, hann.clone(), false),
        ((6000, 700), 1024, hann, true),
        ((3000, 300), 1000, SLEPIAN, true),
    ] {
        let field = field(shape);
        for threads in [1, 3] {
            let of = |memory| {
                let request = SpectrumRequest {
                    averaging: averaging(segment, tapers.clone()),
                    has_jackknife,
                    threads: Some(threads),
                    memory: Some(memory),
                    ..SpectrumRequest::default()
                };
                spectrum(&[&field], &request, &Silent)
            };
            let counted = needed(of(1));
            let (most, found) = taken(|| of(counted));
            found.unwrap();
            let case = format!("{shape:?} {segment} {has_jackknife} {threads} threads");
            assert!(most <= counted, "{case}: {most} of {counted}");
            assert!(10 * counted <= 16 * most, "{case}: {most} of {counted}");
        }
    }
}

/// A filter takes no more than it is allowed, and below three times the field works in blocks, with the same result.
#[test]
fn a_filter_takes_what_it_is_allowed() {
    let _alone = alone();
    for (shape, pad) in [
        ((20_011, 120), false),
        ((8192, 256), true),
        ((300, 4001), false),
    ] {
        let field = field(shape);
        let band = Passband {
            frequency: Some((0.1, 0.2)),
            ..Passband::default()
        };
        let whole = filtered(&field, &band, pad, Some(1 << 32), &Silent).unwrap();
        let least = needed(filtered(&field, &band, pad, Some(1 << 20), &Silent));
        let size = 8 * (shape.0 * shape.1) as u64;
        // In blocks, and at once.
        for allowed in [least, least + size / 4, 12 * size] {
            let (most, found) = taken(|| filtered(&field, &band, pad, Some(allowed), &Silent));
            let found = found.unwrap();
            let fits = most <= allowed + allowed / 50;
            assert!(fits, "{most} of {allowed} for {shape:?}");
            let is_at_once = allowed > 3 * size;
            assert!(most < 2 * size || pad || is_at_once, "{most} for {shape:?}");
            assert_eq!(values(&whole.field), values(&found.field));
            assert_eq!(whole.energy_after, found.energy_after);
        }
    }
}

/// Of samples that are decoded, only the sites asked for: no piece is as large as one profile.
#[test]
fn only_sites_that_are_asked_for_are_decoded() {
    let _alone = alone();
    let (n_times, n_sites) = (9, 1 << 18);
    let value = |n: usize, j: usize| (n * 1009 + j * 31) as f32 % 7.0 - 3.0;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wide.npy");
    let mut samples = Array2::from_shape_fn((n_times, n_sites), |(n, j)| value(n, j));
    // Beside what is asked for nobody looks; there, a gap is found in its place.
    samples[[4, 99]] = f32::NAN;
    samples[[6, 1000]] = f32::INFINITY;
    write_npy(&path, &samples).unwrap();
    let field = Field::open(&path, &OpenOptions::default()).unwrap();
    let request = |sites: std::ops::Range<usize>| Request {
        results: TEMPORAL,
        sites: Some(sites),
        threads: Some(2),
        memory: Some(1 << 30),
        ..Request::default()
    };
    LARGEST.store(0, Ordering::Relaxed);
    let narrow = plan(&field, &request(100..110)).unwrap();
    let found = run(&field, &narrow, &Nowhere, &Silent).unwrap();
    let largest = LARGEST.load(Ordering::Relaxed);
    assert!(largest < 4 * n_sites, "{largest}");
    let highest = (0..n_times).flat_map(|n| (100..110).map(move |j| value(n, j)));
    let highest = highest.fold(f32::MIN, f32::max);
    let seen = &found.maps[&LargeArray::SAMPLES].values;
    let seen = seen.iter().copied().fold(f32::MIN, f32::max);
    assert_eq!(seen, highest);

    let wide = plan(&field, &request(990..1010)).unwrap();
    let error = run(&field, &wide, &Nowhere, &Silent).unwrap_err();
    let Error::NonFinite {
        count,
        first,
        sites,
        ..
    } = error
    else {
        panic!("{error}");
    };
    assert_eq!((count, first, sites), (1, (6, 1000), 1));
    // What the threads take for two times of all sites is part of every plan.
    let request = request(0..n_sites);
    let needed = |field| plan(field, &request).unwrap().memory_needed;
    let stored = Field::from_array(samples.mapv(f64::from));
    assert_eq!(needed(&field), needed(&stored));
}
