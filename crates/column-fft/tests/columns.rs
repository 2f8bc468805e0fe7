//! Transforms of columns against `realfft`, direct sums in integers, and themselves.

use std::f64::consts::TAU;
use std::sync::Arc;

mod common;
#[path = "../src/twiddle.rs"]
mod twiddle;

use column_fft::{
    Algorithm, ColumnFftPlanner, Columns, ColumnsMut, ComplexToComplexColumns, FftDirection,
    FftError, InstructionSet, Real, RealToComplexColumns, rows,
};
use common::{apart, by_threads, direct_sums, double, noise, plans, power, spectra};
use ndarray::{Array2, ArrayView2, ShapeBuilder, s};
use num_complex::Complex;

fn by_realfft<T: Real>(column: ndarray::ArrayView1<T>) -> Vec<Complex<f64>> {
    let plan = rows::plan_fft_forward::<f64>(column.len());
    let mut record: Vec<f64> = column.iter().map(|v| v.to_f64()).collect();
    let mut spectrum = plan.make_output_vec();
    plan.process(&mut record, &mut spectrum).unwrap();
    spectrum
}

fn realfft_agrees<T: Real>(length: usize, by_passes: f64, otherwise: f64) {
    let columns = 1 + length % 11;
    let values = noise::<T>((length, columns), length as u64);
    for c in [0, columns - 1] {
        let truth = by_realfft(values.column(c));
        for plan in plans::<T>(length) {
            let found = spectra(&plan, values.slice(s![.., c..]));
            let off = apart(found.column(0), truth.iter().copied());
            // Other lengths are the less precise with `realfft`, too.
            let bound = match plan.algorithm() {
                Algorithm::FourStep { .. } => by_passes,
                _ => otherwise,
            };
            assert!(off < bound, "{length} {plan:?}: {off:e}");
        }
    }
}

/// Every length to 2048, every instruction set: all bins of all columns.
#[test]
fn val_realfft_at_every_length() {
    for length in 1..=2048 {
        realfft_agrees::<f64>(length, 1.1e-15, 2e-15);
        realfft_agrees::<f32>(length, 4e-7, 4e-7);
    }
}

fn direct_sums_agree<T: Real>(length: usize) {
    let values = noise::<T>((length, 1), 2);
    let bins: Vec<usize> = (0..8).map(|i| (2 * i + 1) * (length / 2) / 16).collect();
    let truth = direct_sums(&values.column(0).mapv(T::to_f64).to_vec(), &bins);
    let size = (length as f64 / 12.0).sqrt();
    for plan in plans::<T>(length) {
        let found = spectra(&plan, values.view());
        let off = |(&m, z): (&usize, &Complex<f64>)| power(double(found[[m, 0]]) - z);
        let squares: f64 = bins.iter().zip(&truth).map(off).sum();
        let error = (squares / bins.len() as f64).sqrt() / size;
        let stated = plan.expected_error();
        // A few bins scatter by a third about the mean.
        let is_near = (0.25 * stated..1.6 * stated).contains(&error);
        assert!(is_near, "{length}: {error:e}, stated {stated:e}");
    }
}

/// Lengths of every kind against direct sums, to what the plan states.
#[test]
fn val_direct_sums_to_the_stated_error() {
    for length in [
        16, 27, 49, 60, 125, 128, 210, 343, 480, 729, 1000, 1009, 1024, 2187, 3125, 4096, 5040,
        6561, 9973, 10007, 10011, 16384, 16807, 30000, 65536, 100_000, 262_144, 510_510, 999_983,
        1_048_576,
    ] {
        direct_sums_agree::<f64>(length);
        direct_sums_agree::<f32>(length);
    }
}

fn bits(spectra: ArrayView2<Complex<f64>>) -> Vec<[u64; 2]> {
    let bits = |z: &Complex<f64>| [z.re.to_bits(), z.im.to_bits()];
    spectra.iter().map(bits).collect()
}

/// A column's bits do not depend on how many there are, where it lies, how rows are aligned, nor
/// on what its neighbours hold.
#[test]
fn columns_do_not_know_of_each_other() {
    for length in [48, 210, 251, 253, 1000, 1024] {
        let all = noise::<f64>((length, 48), 3);
        for plan in plans::<f64>(length) {
            let whole = spectra(&plan, all.view());
            for columns in 1..=40 {
                let from = columns % 9;
                let part = all.slice(s![.., from..from + columns]);
                let found = spectra(&plan, part);
                let expected = whole.slice(s![.., from..from + columns]);
                assert_eq!(bits(found.view()), bits(expected), "{plan:?} {columns}");
                // Results at an odd place of a wider array; the rest stays as it was.
                let mut wide = Array2::from_elem((plan.bins(), 59), Complex::new(7.0, 7.0));
                let place = wide.slice_mut(s![.., from..from + columns]);
                plan.process_with_scratch(part, place, &mut plan.make_scratch(columns))
                    .unwrap();
                let found = wide.slice(s![.., from..from + columns]);
                assert_eq!(bits(found), bits(expected), "{plan:?} {columns}");
                let untouched = |z: &&Complex<f64>| **z == Complex::new(7.0, 7.0);
                let rest = plan.bins() * (59 - columns);
                assert_eq!(wide.iter().filter(untouched).count(), rest);
            }
        }
    }
}

/// Scratch may be longer than needed and start anywhere; what is too short is refused.
#[test]
fn scratch_of_any_place_gives_the_same_bits() {
    for length in [1000, 251, 253, 7] {
        let values = noise::<f64>((length, 19), 10);
        for plan in plans::<f64>(length) {
            let expected = spectra(&plan, values.view());
            let mut scratch = vec![Complex::default(); plan.scratch_len(100) + 4];
            for start in 0..5 {
                let mut out = Array2::default((plan.bins(), 19));
                let scratch = &mut scratch[start..];
                plan.process_with_scratch(values.view(), out.view_mut(), scratch)
                    .unwrap();
                assert_eq!(bits(out.view()), bits(expected.view()));
            }
            let mut out = Array2::default((plan.bins(), 19));
            let needed = plan.scratch_len_for(&values.view().into(), &out.view_mut().into());
            let short = &mut scratch[..needed - 1];
            let found = plan
                .process_with_scratch(values.view(), out.view_mut(), short)
                .unwrap_err();
            let expected = FftError::Scratch {
                needed,
                found: needed - 1,
            };
            assert_eq!(found, expected);
        }
    }
}

#[test]
fn other_shapes_than_the_plans_are_refused() {
    let zero = RealToComplexColumns::<f64>::new(0).unwrap_err();
    assert_eq!(zero.to_string(), "the length is 0, expected at least 1");
    let plan = RealToComplexColumns::<f64>::new(12).unwrap();
    let run = |input, output| {
        let (input, mut output) = (Array2::zeros(input), Array2::default(output));
        let refused = plan.process(input.view(), output.view_mut()).unwrap_err();
        let in_parallel = plan
            .process_in_parallel(input.view(), output.view_mut())
            .unwrap_err();
        assert_eq!(refused, in_parallel);
        refused.to_string()
    };
    for (input, output, told) in [
        ((11, 3), (7, 3), "expected input of 12 x 3, found 11 x 3"),
        ((12, 3), (6, 3), "expected output of 7 x 3, found 6 x 3"),
        ((12, 3), (7, 4), "expected output of 7 x 3, found 7 x 4"),
    ] {
        assert_eq!(run(input, output), told);
    }
}

/// Plain slices at strides: the bits of arrays.
#[test]
fn slices_have_the_bits_of_arrays() {
    for length in [48, 7, 251] {
        let values = noise::<f64>((length, 20), 12);
        let slice = values.as_slice().unwrap();
        let plan = RealToComplexColumns::<f64>::new(length).unwrap();
        let expected = spectra(&plan, values.slice(s![.., 3..14]));
        let input = Columns::new(&slice[3..], length, 11, 20).unwrap();
        let mut found = vec![Complex::default(); plan.bins() * 13];
        let output = ColumnsMut::new(&mut found, plan.bins(), 11, 13).unwrap();
        plan.process(input, output).unwrap();
        // Contiguous columns.
        let mut by_column = vec![Complex::default(); plan.bins() * 11];
        let transposed = values.t().as_standard_layout().into_owned();
        let input = &transposed.as_slice().unwrap()[3 * length..];
        let input = Columns::with_strides(input, [length, 11], [1, length]).unwrap();
        let strides = [1, plan.bins()];
        let output = ColumnsMut::with_strides(&mut by_column, [plan.bins(), 11], strides).unwrap();
        plan.process(input, output).unwrap();
        for ((m, c), x) in expected.indexed_iter() {
            assert_eq!(found[m * 13 + c], *x);
            assert_eq!(by_column[c * plan.bins() + m], *x);
        }
    }
}

#[test]
fn plans_are_shared() {
    let mut planner = ColumnFftPlanner::<f32>::new();
    let plan = planner.plan_fft_forward(60).unwrap();
    assert!(Arc::ptr_eq(&plan, &planner.plan_fft_forward(60).unwrap()));
    let back = planner.plan_fft_inverse(60).unwrap();
    assert!(Arc::ptr_eq(&back, &planner.plan_fft_inverse(60).unwrap()));
    assert!(planner.plan_fft_forward(0).is_err() && planner.plan_fft_2d_forward((3, 0)).is_err());
    assert!(planner.plan_short_time(&[1.0; 8], 0).is_err());
    let set = InstructionSet::Portable;
    let mut portable = ColumnFftPlanner::<f64>::with_instruction_set(set).unwrap();
    assert_eq!(portable.plan_fft_forward(9).unwrap().instruction_set(), set);
    // Unnormalised: N times the columns.
    let values = noise::<f32>((60, 5), 13);
    let mut bins = Array2::default((plan.bins(), 5));
    plan.process(values.view(), bins.view_mut()).unwrap();
    let mut twice = Array2::default((60, 5));
    back.process(bins.view(), twice.view_mut()).unwrap();
    let apart = twice.iter().zip(&values).map(|(a, b)| (a - 60.0 * b).abs());
    assert!(apart.fold(0.0, f32::max) < 60.0 * 4e-7);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for length in [480, 251, 253] {
        let columns = 37;
        let rows = noise::<f64>((length, columns), 4);
        let plan = RealToComplexColumns::<f64>::new(length).unwrap();
        let expected = spectra(&plan, rows.view());
        for threads in [1, 2, 4] {
            let mut out = Array2::default((plan.bins(), columns));
            let run = || plan.process_in_parallel(rows.view(), out.view_mut());
            by_threads(threads, run).unwrap();
            assert_eq!(bits(out.view()), bits(expected.view()));
        }
        let none = Array2::<f64>::zeros((length, 0));
        assert_eq!(spectra(&plan, none.view()).len(), 0);
    }
}

/// Large results in rows that are no whole cache lines, which are asked for; by last passes of each radix.
fn rows_asked_for<T: Real>() {
    let of_radix = [
        (16384, 8),
        (16464, 3),
        (16807, 7),
        (17150, 2),
        (17500, 4),
        (18750, 5),
    ];
    for (length, radix) in of_radix {
        let values = noise::<T>((length, 17), 9);
        for plan in plans::<T>(length) {
            let algorithm = plan.algorithm();
            assert!(
                matches!(algorithm, Algorithm::FourStep { second, .. } if second.last() == Some(&radix)),
                "{plan:?}"
            );
            let found = spectra(&plan, values.view());
            for c in [0, 7, 16] {
                let alone = spectra(&plan, values.slice(s![.., c..c + 1]));
                assert!(found.column(c) == alone.column(0), "{plan:?} {c}");
            }
        }
    }
}

#[test]
fn rows_asked_for_have_the_bits_of_lone_columns() {
    rows_asked_for::<f64>();
    rows_asked_for::<f32>();
}

/// A dead channel beside the loudest stays exactly zero, and NaN and infinity stay in theirs.
#[test]
fn nothing_leaks_from_a_column() {
    for length in [360, 251, 253, 1024] {
        let mut values = noise::<f64>((length, 16), 6);
        for c in (0..16).step_by(2) {
            values.column_mut(c).fill(0.0);
        }
        values.column_mut(3).mapv_inplace(|v| v * 1e300);
        values[[5, 7]] = f64::NAN;
        values[[length - 1, 9]] = f64::INFINITY;
        for plan in plans::<f64>(length) {
            let found = spectra(&plan, values.view());
            for c in 0..16 {
                let column = found.column(c);
                let zero = column.iter().all(|z| z.norm() == 0.0);
                assert_eq!(zero, c % 2 == 0);
                let finite = column.iter().all(|z| z.re.is_finite() && z.im.is_finite());
                assert_eq!(finite, c != 7 && c != 9, "{plan:?} {c}");
            }
        }
    }
}

#[test]
fn real_bins_are_real() {
    for length in [16, 30, 48, 96, 100, 250, 1024, 22, 26] {
        let values = noise::<f64>((length, 9), 7);
        for plan in plans::<f64>(length) {
            let found = spectra(&plan, values.view());
            assert!(found.row(0).iter().all(|z| z.im == 0.0));
            let last = found.row(length / 2);
            assert!(last.iter().all(|z| z.im == 0.0), "{plan:?}");
        }
    }
}

/// `X(a u + b v) = a X(u) + b X(v)`; a shift turns phases; Parseval's identity.
#[test]
fn val_linearity_shift_and_parseval() {
    for length in [96, 315, 1024, 6000] {
        let [u, v] = [8, 9].map(|seed| noise::<f64>((length, 5), seed));
        for plan in plans::<f64>(length) {
            let of_sum = spectra(&plan, (&u * 3.0 + &v * 0.25).view());
            let sum = spectra(&plan, u.view()).mapv(|z| z * 3.0)
                + spectra(&plan, v.view()).mapv(|z| z * 0.25);
            let shift = 7;
            let mut shifted = u.clone();
            for n in 0..length {
                shifted.row_mut(n).assign(&u.row((n + shift) % length));
            }
            let shifted = spectra(&plan, shifted.view());
            let mut turned = spectra(&plan, u.view());
            for (m, mut row) in turned.outer_iter_mut().enumerate() {
                let turns = (m * shift % length) as f64 / length as f64;
                row.mapv_inplace(|z| z * Complex::from_polar(1.0, TAU * turns));
            }
            for c in 0..5 {
                assert!(apart(of_sum.column(c), sum.column(c).to_vec()) < 6e-16);
                assert!(apart(shifted.column(c), turned.column(c).to_vec()) < 8e-16);
                let fold = |m: usize| if m == 0 || 2 * m == length { 1.0 } else { 2.0 };
                let found = spectra(&plan, u.view());
                let powers = found.column(c).mapv(power);
                let energy = powers.iter().enumerate();
                let energy: f64 = energy.map(|(m, &p)| fold(m) * p).sum();
                let of_record: f64 = u.column(c).iter().map(|v| v * v).sum();
                let residual = energy / length as f64 / of_record - 1.0;
                assert!(residual.abs() < 5e-15, "{residual:e}");
            }
        }
    }
}

/// Scaled by a power of two nothing but exponents changes, up to where sums overflow or get
/// subnormal.
#[test]
fn huge_and_tiny_columns_keep_their_digits() {
    let values = |length| noise::<f64>((length, 6), 9);
    let plans = [480, 251, 253].into_iter().flat_map(plans::<f64>);
    for plan in plans {
        let values = values(plan.len());
        let plain = spectra(&plan, values.view());
        for exponent in [1012, -900] {
            let unit = 2f64.powi(exponent);
            let scaled = spectra(&plan, values.mapv(|v| v * unit).view());
            assert_eq!(scaled, plain.mapv(|z| z * unit));
        }
        // Subnormal samples: right to the last place there is.
        let tiny = values.mapv(|v| v * 1e-150 * 1e-160);
        let found = spectra(&plan, tiny.view());
        let raised = spectra(&plan, tiny.mapv(|v| v * 2f64.powi(600)).view());
        for (a, b) in found.iter().zip(&raised) {
            let apart = (*a * 2f64.powi(600) - b).norm() / 2f64.powi(600);
            // Convolutions round more numbers in between.
            let places = match plan.algorithm() {
                Algorithm::FourStep { .. } => 40.0,
                _ => 70.0,
            };
            assert!(apart < places * 5e-324, "{plan:?} {apart:e}");
        }
    }
}

#[test]
fn plans_say_how() {
    let plan = RealToComplexColumns::<f64>::new(16384).unwrap();
    let Algorithm::FourStep { first, second } = plan.algorithm() else {
        panic!("{plan:?}");
    };
    assert_eq!(first.iter().chain(&second).product::<usize>(), 16384);
    let plan = RealToComplexColumns::<f64>::new(10007).unwrap();
    assert!(matches!(
        plan.algorithm(),
        Algorithm::Bluestein { points: 15010.. }
    ));
    assert_eq!(
        RealToComplexColumns::<f64>::new(7).unwrap().algorithm(),
        Algorithm::ByColumn
    );
    assert_eq!(plan.instruction_set(), InstructionSet::best());
}

fn complex_agrees<T: Real>(tolerance: f64) {
    for length in [1, 2, 3, 7, 16, 48, 101, 105, 251, 253, 256, 1000] {
        for columns in [1, 3, 8, 21, 300] {
            let [re, im] = [14, 15].map(|seed| noise::<T>((length, columns), seed));
            let values =
                Array2::from_shape_fn((length, columns), |at| Complex::new(re[at], im[at]));
            for direction in [FftDirection::Forward, FftDirection::Inverse] {
                let plan = ComplexToComplexColumns::<T>::new(length, direction).unwrap();
                let mut found = Array2::default((length, columns));
                plan.process(values.view(), found.view_mut()).unwrap();
                let theirs = rows::plan_fft_complex::<f64>(length, direction);
                for c in [0, columns / 2, columns - 1] {
                    let mut truth: Vec<_> = values.column(c).iter().map(|z| double(*z)).collect();
                    theirs.process(&mut truth);
                    let off = apart(found.column(c), truth);
                    assert!(off < tolerance, "{length} x {columns}: {off:e}");
                }
                // Any layout and any number of threads: the same bits.
                let mut by_column = Array2::default((length, columns).f());
                by_column.assign(&values);
                let mut other = Array2::default((length, columns).f());
                plan.process(by_column.view(), other.view_mut()).unwrap();
                assert_eq!(other, found);
                let mut other = Array2::default((length, columns));
                plan.process_in_parallel(values.view(), other.view_mut())
                    .unwrap();
                assert_eq!(other, found);
                let short = &mut plan.make_scratch()[1..];
                assert!(
                    plan.process_with_scratch(values.view(), other.view_mut(), short)
                        .is_err()
                );
            }
        }
    }
}

#[test]
fn val_rustfft_of_complex_columns() {
    complex_agrees::<f64>(2e-15);
    complex_agrees::<f32>(5e-7);
}

/// Angles that are the same on paper have the same bits, and the sine of a twelfth of a cycle is one half; in every
/// octant the standard library's are right to about a unit of an angle that is itself rounded.
#[test]
fn val_identities_of_twiddle_factors() {
    let of = twiddle::cos_sin_exact;
    for q in 1..200 {
        assert_eq!(of(0, q), (1.0, 0.0));
        assert_eq!(of(q, 4 * q), (0.0, 1.0));
        assert_eq!(of(q, 12 * q).1, 0.5);
        for p in 0..=q {
            let (cos, sin) = of(p, q);
            assert_eq!(of(q - p, q), (cos, -sin));
        }
    }
    for p in 0..4096 {
        let angle = TAU * (p as f64 / 4096.0);
        let (cos, sin) = of(p, 4096);
        assert!((cos - angle.cos()).abs() < 7e-16);
        assert!((sin - angle.sin()).abs() < 7e-16);
    }
}
