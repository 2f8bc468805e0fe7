//! Transforms of both axes, of overlapping segments, and back: against sums as they are written in
//! the definitions, and against `realfft`.

mod common;

use std::f64::consts::TAU;

use column_fft::{
    ComplexToReal2d, ComplexToRealColumns, FftDirection, Filter2d, Real, RealToComplex2d,
    RealToComplexColumns, ShortTimeColumns, rows,
};
use common::{apart, by_threads, direct_sums, double, noise, segments, short_time, spectra};
use ndarray::{Array2, Array3, ArrayView2, Axis, s};
use num_complex::Complex;

/// `sum v exp(i (k x - 2 pi f t))`, the double sum, angles reduced in whole numbers.
fn double_sum(values: &Array2<f64>, m: usize, q: usize) -> Complex<f64> {
    let (times, sites) = values.dim();
    let terms = values.indexed_iter().map(|((n, j), &v)| {
        let turns = (q * j % sites) as f64 / sites as f64 - (m * n % times) as f64 / times as f64;
        Complex::cis(TAU * turns) * v
    });
    terms.sum()
}

#[test]
fn val_double_sums_over_time_and_space() {
    let shapes = [
        (1, 1),
        (2, 3),
        (16, 12),
        (15, 20),
        (13, 11),
        (24, 1),
        (1, 9),
    ];
    for shape in shapes {
        let values = noise::<f64>(shape, 5);
        let plan = RealToComplex2d::new(shape, FftDirection::Inverse).unwrap();
        let spectrum = plane(&plan, values.view());
        let truth = spectrum
            .indexed_iter()
            .map(|((m, q), _)| double_sum(&values, m, q));
        let off = apart(&spectrum, truth);
        assert!(off < 1e-15, "{shape:?}: {off:e}");
    }
}

fn plane<T: Real>(plan: &RealToComplex2d<T>, values: ArrayView2<T>) -> Array2<Complex<T>> {
    let mut spectrum = Array2::default((plan.bins(), values.ncols()));
    plan.process_in_parallel(values, spectrum.view_mut())
        .unwrap();
    spectrum
}

fn returns<T: Real>(tolerance: f64) {
    for shape in [(1, 1), (2, 2), (64, 48), (63, 50), (101, 37), (600, 7)] {
        let values = noise::<T>(shape, 11);
        let plan = RealToComplex2d::new(shape, FftDirection::Inverse).unwrap();
        let mut spectrum = plane(&plan, values.view());
        let mut back = Array2::default(shape);
        let inverse = ComplexToReal2d::new(shape, FftDirection::Forward)
            .unwrap()
            .normalized();
        inverse
            .process(spectrum.view_mut(), back.view_mut())
            .unwrap();
        let truth = values.iter().map(|v| Complex::from(v.to_f64()));
        let off = apart(&back.mapv(|v| Complex::new(v, T::zero())), truth);
        assert!(off < tolerance, "{shape:?}: {off:e}");
        // By one thread: the same bits.
        plan.process(values.view(), spectrum.view_mut()).unwrap();
        assert_eq!(plane(&plan, values.view()), spectrum);
        let mut again = Array2::default(shape);
        inverse
            .process_in_parallel(spectrum.view_mut(), again.view_mut())
            .unwrap();
        assert_eq!(again, back);
        let filter = Filter2d::new(shape, FftDirection::Inverse).unwrap();
        filter
            .process(values.view(), again.view_mut(), |_, _| {})
            .unwrap();
        assert_eq!(again, back);
        filter
            .process_in_parallel(values.view(), again.view_mut(), |m, row| {
                if m > 0 {
                    row.fill(Complex::default());
                }
            })
            .unwrap();
        let mean =
            |c: usize| back.column(c).iter().map(|v| v.to_f64()).sum::<f64>() / shape.0 as f64;
        for (c, column) in again.axis_iter(Axis(1)).enumerate() {
            let apart = column.iter().map(|v| (v.to_f64() - mean(c)).abs());
            assert!(apart.fold(0.0, f64::max) < tolerance);
        }
    }
}

#[test]
fn fields_return_to_rounding() {
    returns::<f64>(1.5e-15);
    returns::<f32>(8e-7);
}

/// Rows that are not contiguous, and columns of columns, go another way to the same bits.
#[test]
fn any_layout_and_any_number_of_threads_give_the_same_bits() {
    let shape = (48, 21);
    let values = noise::<f64>(shape, 3);
    let plan = RealToComplex2d::new(shape, FftDirection::Inverse).unwrap();
    let run = |threads: usize, stride: usize| {
        let mut room = Array2::<Complex<f64>>::default((plan.bins(), stride * shape.1));
        let spectrum = room.slice_mut(s![.., ..;stride]);
        by_threads(threads, || {
            plan.process_in_parallel(values.view(), spectrum)
        })
        .unwrap();
        room.slice(s![.., ..;stride]).to_owned()
    };
    let first = run(1, 1);
    for (threads, stride) in [(2, 1), (4, 1), (1, 2), (3, 3)] {
        assert_eq!(
            run(threads, stride),
            first,
            "{threads} threads, every {stride}"
        );
    }
}

fn inverse_agrees<T: Real>(tolerance: f64) {
    let lengths = (1..200).chain([243, 256, 1000, 1009, 2048, 4096, 10007, 16384]);
    for length in lengths {
        // Tiles that are full and not.
        let columns = 1 + length % 19;
        let [re, im] = [17, 18].map(|seed| noise::<T>((length / 2 + 1, columns), seed));
        let spectra = Array2::from_shape_fn(re.dim(), |at| Complex::new(re[at], im[at]));
        let mut found = Array2::default((length, columns));
        let plan = ComplexToRealColumns::new(length).unwrap().normalized();
        plan.process_in_parallel(spectra.view(), found.view_mut())
            .unwrap();
        let theirs = rows::plan_fft_inverse::<f64>(length);
        for (c, column) in found.axis_iter(Axis(1)).enumerate() {
            let mut spectrum = spectra.column(c).mapv(double).to_vec();
            spectrum[0].im = 0.0;
            if length % 2 == 0 {
                spectrum[length / 2].im = 0.0;
            }
            let mut truth = vec![0.0; length];
            theirs.process(&mut spectrum, &mut truth).unwrap();
            let truth = truth.iter().map(|v| Complex::from(v / length as f64));
            let off = apart(&column.mapv(|v| Complex::new(v, T::zero())), truth);
            assert!(off < tolerance, "{length}, column {c}: {off:e}");
        }
    }
}

/// Bins whose imaginary part has no meaning are given one, which must not matter.
#[test]
fn val_realfft_inverses() {
    inverse_agrees::<f64>(2e-15);
    inverse_agrees::<f32>(8e-7);
}

#[test]
fn inverses_of_any_number_of_threads_have_the_same_bits() {
    let (length, columns) = (360, 53);
    let values = noise::<f64>((length, columns), 23);
    let spectra = spectra(&RealToComplexColumns::new(length).unwrap(), values.view());
    let inverse = ComplexToRealColumns::new(length).unwrap().normalized();
    let run = |threads: usize| {
        let mut back = Array2::default((length, columns));
        let run = || inverse.process_in_parallel(spectra.view(), back.view_mut());
        by_threads(threads, run).unwrap();
        back
    };
    let first = run(1);
    assert_eq!(run(2), first);
    assert_eq!(run(5), first);
    // A column alone has the bits it has among others.
    let mut alone = Array2::default((length, 1));
    let one = spectra.slice(s![.., 40..41]);
    inverse.process_in_parallel(one, alone.view_mut()).unwrap();
    assert_eq!(alone.column(0), first.column(40));
}

fn short_time_agrees<T: Real>(tolerance: f64) {
    for (times, columns, length, hop) in [
        (300, 13, 64, 10),
        (256, 40, 256, 32),
        (700, 5, 101, 101),
        (97, 3, 30, 47),
        (20, 2, 1, 3),
    ] {
        let values = noise::<T>((times, columns), 29);
        let window: Vec<f64> = (0..length)
            .map(|n| 0.1 + (n as f64 * 0.9).sin().powi(2))
            .collect();
        let plan = ShortTimeColumns::<T>::new(&window, hop).unwrap();
        assert_eq!(plan.segments(times), (times - length) / hop + 1);
        let spectra = segments(&plan, values.view());
        let bins: Vec<usize> = (0..plan.bins()).collect();
        for (s, segment) in spectra.outer_iter().enumerate() {
            for c in 0..columns {
                let weighed: Vec<f64> = (0..length)
                    .map(|n| values[(s * hop + n, c)].to_f64() * window[n])
                    .collect();
                let truth = direct_sums(&weighed, &bins);
                let off = apart(segment.column(c), truth);
                assert!(off < tolerance, "{length} / {hop}, {s}, {c}: {off:e}");
            }
        }
    }
}

#[test]
fn val_direct_sums_of_weighed_segments() {
    short_time_agrees::<f64>(6e-16);
    short_time_agrees::<f32>(3e-7);
}

/// Segments weighed as they are read have the bits of those weighed before: in one half of two passes
/// and in more, with an odd second half, of a prime length, of rows that alias.
fn weighed_bits<T: Real>() {
    for (length, columns) in [(64, 13), (105, 40), (30, 512), (256, 1024), (101, 9)] {
        let values = noise::<T>((length + 7, columns), 37);
        let found = segments(&short_time(length, 7), values.view());
        assert_eq!(found.len_of(Axis(0)), 2);
        let plan = RealToComplexColumns::<T>::new(length).unwrap();
        for (s, segment) in found.outer_iter().enumerate() {
            let weighed = Array2::from_shape_fn((length, columns), |(n, c)| {
                values[(7 * s + n, c)] * T::rounded(((n + 1) as f64).sqrt())
            });
            let expected = spectra(&plan, weighed.view());
            assert_eq!(segment, expected, "{length} x {columns}");
        }
    }
}

#[test]
fn weights_in_passing_give_the_bits_of_weighed_columns() {
    weighed_bits::<f64>();
    weighed_bits::<f32>();
}

/// Rows far apart, columns that are not neighbours in either array, segments weighed in passing and in
/// copies (a prime length): the same bits.
#[test]
fn segments_of_any_layout_have_the_same_bits() {
    for length in [64, 30, 105, 101] {
        let values = noise::<f64>((150, 512), 31);
        let plan = short_time::<f64>(length, 25);
        let whole = segments(&plan, values.view());
        assert_eq!(segments(&plan, values.t().to_owned().t()), whole);
        let (count, bins, columns) = whole.dim();
        let mut found = Array3::default((count, columns, bins));
        let turned = found.view_mut().permuted_axes([0, 2, 1]);
        plan.process_in_parallel(values.view(), turned).unwrap();
        assert_eq!(found.permuted_axes([0, 2, 1]), whole);
        let few = values.slice(s![.., 3..10]).to_owned();
        let found = segments(&plan, few.view());
        assert_eq!(found, whole.slice(s![.., .., 3..10]));
    }
}

#[test]
fn records_shorter_than_the_window_have_no_segments() {
    let plan = short_time::<f64>(8, 2);
    assert_eq!([7, 8, 10].map(|times| plan.segments(times)), [0, 1, 2]);
    let none = segments(&plan, noise((7, 3), 1).view());
    assert_eq!(none.dim(), (0, 5, 3));
}
