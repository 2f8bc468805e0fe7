//! Transforms of columns in buffers without a number to spare.
//!
//! `./test` runs this file once more with an address sanitizer, which stops it at the first number
//! that a kernel reads or writes beside its buffers. Results that are written past the caches the
//! sanitizer does not see; those lie between margins that are looked at here.

mod common;

use column_fft::{Columns, ColumnsMut, FftError, Real, RealToComplexColumns, SegmentsMut};
use common::{noise, plans, short_time, spectra};
use ndarray::{Array2, ArrayViewMut2, ArrayViewMut3, Axis, ShapeBuilder, s};
use num_complex::Complex;

/// One of each kind: whole and mixed powers, odd, by convolution (primes and others), and the shortest.
const LENGTHS: [usize; 13] = [7, 11, 15, 16, 64, 48, 105, 210, 222, 251, 253, 256, 343];
const WIDEST: usize = 40;

fn every_tail<T: Real>() {
    for length in LENGTHS {
        let all = noise::<T>((length, WIDEST), 1);
        for plan in plans::<T>(length) {
            let whole = spectra(&plan, all.view());
            for columns in 1..=WIDEST {
                // The first and the last columns: copies, with nothing beside them.
                for from in [0, WIDEST - columns] {
                    let part = s![.., from..from + columns];
                    let exact =
                        Array2::from_shape_fn((length, columns), |(n, c)| all[[n, from + c]]);
                    let found = spectra(&plan, exact.view());
                    assert_eq!(found, whole.slice(part), "{plan:?} {columns}");
                }
            }
        }
    }
}

#[test]
fn every_tail_of_columns_keeps_to_its_buffers() {
    every_tail::<f64>();
    every_tail::<f32>();
}

/// Rows 4096 bytes apart, which are copied first: the last columns, with nothing behind them.
fn far_apart<T: Real>() {
    let wide = 4096 / size_of::<T>();
    for length in LENGTHS {
        let all = noise::<T>((length, wide), 2);
        for plan in plans::<T>(length) {
            // Tails of tiles, and of the 64 (`f64`) or 128 columns that are copied together.
            for columns in (1..=20).chain(61..=68).chain(125..=130) {
                let part = all.slice(s![.., wide - columns..]);
                let close = spectra(&plan, part.to_owned().view());
                assert_eq!(spectra(&plan, part), close, "{plan:?} {columns}");
            }
            // Scratch for any layout.
            let mut found = Array2::default((plan.bins(), wide));
            let scratch = &mut plan.make_scratch(wide);
            plan.process_with_scratch(all.view(), found.view_mut(), scratch)
                .unwrap();
            assert_eq!(found, spectra(&plan, all.view()));
        }
    }
}

#[test]
fn rows_far_apart_keep_to_their_buffers() {
    far_apart::<f64>();
    far_apart::<f32>();
}

/// Columns that are not neighbours, and stripes of several threads.
#[test]
fn any_layout_keeps_to_its_buffers() {
    for length in LENGTHS {
        for columns in [1, 3, 8, 17, 40] {
            let rows = noise::<f64>((length, columns), 3);
            let mut by_column = Array2::zeros((length, columns).f());
            by_column.assign(&rows);
            for plan in plans::<f64>(length) {
                let whole = spectra(&plan, rows.view());
                let mut found = Array2::default((plan.bins(), columns).f());
                let scratch = &mut plan.make_scratch(columns);
                plan.process_with_scratch(by_column.view(), found.view_mut(), scratch)
                    .unwrap();
                assert_eq!(found, whole);
                let mut found = Array2::default((plan.bins(), columns));
                plan.process_in_parallel(rows.view(), found.view_mut())
                    .unwrap();
                assert_eq!(found, whole);
            }
        }
    }
}

/// Room for so many results with margins, the number that fills it, and where a cache line begins behind the first margin.
fn marked<T: Real>(results: usize) -> (Complex<T>, usize, Vec<Complex<T>>) {
    const MARGIN: usize = 64;
    let marked = Complex::new(T::rounded(7.0), T::rounded(-7.0));
    let room = vec![marked; results + 3 * MARGIN];
    let is_line = |at: &usize| room[*at..].as_ptr().addr() % 64 == 0;
    (marked, (MARGIN..).find(is_line).unwrap(), room)
}

/// Large results, which are written past the caches where rows are whole cache lines.
fn streamed<T: Real>(length: usize, columns: usize) {
    let rows = noise::<T>((length, columns), 4);
    for plan in plans::<T>(length) {
        let results = plan.bins() * columns;
        let (marked, at, mut room) = marked(results);
        let (before, rest) = room.split_at_mut(at);
        let (spectra, after) = rest.split_at_mut(results);
        let mut spectra = ArrayViewMut2::from_shape((plan.bins(), columns), spectra).unwrap();
        plan.process_with_scratch(
            rows.view(),
            spectra.view_mut(),
            &mut plan.make_scratch(columns),
        )
        .unwrap();
        assert!(
            before.iter().chain(&*after).all(|z| *z == marked),
            "{plan:?}"
        );
        for from in [0, columns / 2, columns - 3] {
            let part = s![.., from..from + 3];
            let alone = common::spectra(&plan, rows.slice(part));
            assert_eq!(spectra.slice(part), alone);
        }
    }
}

#[test]
fn results_past_the_caches_keep_to_their_place() {
    // By passes, and by a convolution, which writes rows in no order.
    for length in [512, 521] {
        for columns in [1024, 1028] {
            streamed::<f64>(length, columns);
        }
        for columns in [2048, 2056] {
            streamed::<f32>(length, columns);
        }
    }
}

/// Large spectra of segments, assembled in the caches where rows are no whole lines: all columns at once or
/// several in turn, from the start of a line and from its middle, in rows `apart` numbers, and upside down.
fn assembled_segments<T: Real>(length: usize, columns: usize, apart: usize) {
    const STREAMED_BYTES: usize = 4 << 20;
    let hop = 3;
    let plan = short_time::<T>(length, hop);
    let segments = STREAMED_BYTES.div_ceil(plan.bins() * columns * size_of::<Complex<T>>());
    let rows = noise::<T>((length + hop * (segments - 1), columns), 5);
    let shape = (segments, plan.bins(), apart);
    let results = segments * plan.bins() * apart;
    let (marked, line, mut room) = marked::<T>(results);
    for (at, turned) in [(line, false), (line + 1, false), (line, true)] {
        room.fill(marked);
        let (before, rest) = room.split_at_mut(at);
        let (spectra, after) = rest.split_at_mut(results);
        let mut spectra = ArrayViewMut3::from_shape(shape, spectra).unwrap();
        if turned {
            spectra.invert_axis(Axis(1));
        }
        let (mut found, beside) = spectra.split_at(Axis(2), columns);
        plan.process_in_parallel(rows.view(), found.view_mut())
            .unwrap();
        let outside = before.iter().chain(&*after).chain(&beside);
        assert!(outside.copied().all(|z| z == marked), "{length} {columns}");
        let width = columns.min(3);
        for from in [0, columns / 2, columns - width] {
            let part = s![.., from..from + width];
            let alone = common::segments(&plan, rows.slice(part));
            assert_eq!(found.slice(s![.., .., from..from + width]), alone);
        }
    }
}

#[test]
fn segments_past_the_caches_keep_to_their_place() {
    // Weighed in passing and before; a megabyte holds 1985 (`f64`) of the former's columns.
    for length in [64, 101] {
        for (columns, apart) in [(301, 301), (304, 304), (2003, 2003), (301, 310)] {
            assembled_segments::<f64>(length, columns, apart);
            assembled_segments::<f32>(length, 2 * columns + 1, 2 * apart + 1);
        }
    }
    // One column, in rows of its own and in wider ones.
    for apart in [1, 3] {
        assembled_segments::<f64>(20000, 1, apart);
    }
}

#[test]
fn regress_arrays_beyond_the_slice_and_rows_that_overlap_are_refused() {
    let mut slice = [0.0; 23];
    assert!(Columns::new(&slice, 3, 7, 8).is_ok());
    let (needed, found) = (24, 23);
    let beyond = Columns::new(&slice, 3, 8, 8).unwrap_err();
    assert_eq!(beyond, FftError::Slice { needed, found });
    assert!(Columns::new(&slice, 5, 8, 3).is_ok());
    let endless = Columns::new(&slice, usize::MAX, 2, usize::MAX);
    assert!(matches!(endless, Err(FftError::Slice { .. })));
    assert!(ColumnsMut::new(&mut slice, 3, 7, 8).is_ok());
    assert!(ColumnsMut::new(&mut slice, 0, 99, 0).is_ok());
    assert!(ColumnsMut::with_strides(&mut slice, [3, 7], [1, 3]).is_ok());
    for strides in [[7, 1], [1, 2]] {
        let overlapping = ColumnsMut::with_strides(&mut slice, [3, 8], strides);
        assert_eq!(overlapping.unwrap_err(), FftError::Overlap);
    }
    assert!(SegmentsMut::new(&mut slice, 2, 3, 3, 4).is_ok());
    assert!(SegmentsMut::new(&mut slice, 2, usize::MAX, 3, 4).is_err());
    let overlapping = SegmentsMut::with_strides(&mut slice, [2, 2, 2], [2, 2, 1]);
    assert_eq!(overlapping.unwrap_err(), FftError::Overlap);
}

/// A plan needs what is known before it, and no less does. By hand: 4096 = 64 x 64, so a tile of w columns takes
/// 2 w (64 + 33 (64 + 2)) numbers, and a cache line for the alignment. Copies of rows 4096 bytes apart are of 8
/// lines a row; of 2 ^ 17 rows only of 2.
#[test]
fn val_scratch_by_hand() {
    let known = RealToComplexColumns::<f64>::scratch_len_of;
    for length in [4096, 1000, 251, 253, 7] {
        let plan = RealToComplexColumns::<f64>::new(length).unwrap();
        for (columns, stride) in [(512, 512), (30, 512), (512, 513), (3, 512)] {
            let samples = vec![0.5; length * stride];
            let mut bins = vec![Complex::default(); plan.bins() * columns];
            let values = Columns::new(&samples, length, columns, stride).unwrap();
            let known = known(length, columns, stride);
            let mut scratch = vec![Complex::default(); known];
            let mut run = |scratch: &mut [Complex<f64>]| {
                let spectra = ColumnsMut::new(&mut bins, plan.bins(), columns, columns).unwrap();
                assert_eq!(plan.scratch_len_for(&values, &spectra), known);
                plan.process_with_scratch(values, spectra, scratch)
            };
            assert_eq!(run(&mut scratch), Ok(()));
            let short = run(&mut scratch[1..]);
            assert!(matches!(short, Err(FftError::Scratch { .. })), "{length}");
            assert!(plan.scratch_len(columns) >= known);
        }
    }
    let bytes = |length| [512, 513].map(|stride| 16 * known(length, 512, stride));
    let width = RealToComplexColumns::<f64>::new(4096).unwrap().width();
    let scratch = 2 * width * (64 + 33 * 66) * 8 + 64;
    assert_eq!(bytes(4096), [scratch + (2 << 20), scratch]);
    let [copied, not] = bytes(1 << 17);
    assert_eq!(copied - not, 128 << 17);
}
