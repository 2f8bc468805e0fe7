//! Averages that leave out segments with missing samples, against SciPy on segments picked by hand, and their intervals on noise.

use std::f64::consts::TAU;

use ndarray::{Array2, ArrayView2, Axis, concatenate, s};
use test_support::estimate::{coherence, flat, modes, seen, slope, spectrum};
use test_support::fields::{Congruential, asking, noise, option, red};
use test_support::{lies, near, share, worst};
use wavecascade::Field;
use wavecascade::prepare::Gaps;

use crate::identities::{assert_undefined, section};
use crate::peers::{DT, compare, field, record};
use crate::spectrum::coverage;

const WELCH: &str = "segment=64 overlap=32 gaps=leave-out";

fn samples(field: &Field) -> Array2<f64> {
    test_support::made::values(field)
}

#[test]
fn val_scipy_segments_picked_by_hand() {
    compare("scipy spectra of gaps");
    let gaps = record("gaps 600 4");
    let found = spectrum(WELCH, [&gaps]).unwrap();
    let left = found.segments_left.as_ref().unwrap();
    assert_eq!((left.of, left.incomplete(), left.empty()), (17, 3, vec![3]));
    assert_eq!(found.has_interval, [true, true, true, false]);
    // Sites without gaps are what they are without the choice, to rounding; others are refused then.
    let whole = field(samples(&gaps).select(Axis(1), &[0]));
    let [usual, chosen] = ["refuse", "leave-out"].map(|gaps| {
        let words = format!("segment=64 overlap=32 gaps={gaps}");
        spectrum(&words, [&whole]).unwrap()
    });
    assert_eq!(usual.spectrum, chosen.spectrum);
    // Degrees of freedom are summed in another order.
    let degrees = usual.degrees.iter().zip(&chosen.degrees).skip(1);
    lies(worst(degrees.map(|(a, b)| (a / b - 1.0).abs())), 0.0..1e-13);
}

#[test]
fn val_scipy_coherence_of_segments_that_both_sites_have() {
    compare("scipy coherence of gaps");
    let gaps = record("gaps 600 4");
    let found = coherence(&format!("{WELCH} reference=1"), [&gaps]).unwrap();
    // Of the segments that it shares, a site has the spectrum of itself.
    let alone = spectrum(WELCH, [&gaps]).unwrap().spectrum;
    let off = &found.spectrum.column(1) / &alone.column(1) - 1.0;
    lies(worst(off.iter().map(|off| off.abs())), 0.0..1e-12);
}

/// The segments of which nothing is missing, one after another.
fn kept(values: ArrayView2<f64>, segment: usize) -> Field {
    let parts = values.exact_chunks((segment, values.ncols())).into_iter();
    let whole = parts.filter(|part| part.iter().all(|v| v.is_finite()));
    field(concatenate(Axis(0), &whole.collect::<Vec<_>>()).unwrap())
}

/// Without overlap, what is left is as good as a record of the segments that are left.
#[test]
fn val_estimates_of_several_sites_leave_out_what_any_of_them_misses() {
    // Welch's sum over pairs of segments that are left.
    compare("gaps of any site");
    let given = record("gaps 600 3");
    let values = samples(&given);
    let two = values.select(Axis(1), &[0, 2]);
    for (words, expected, kept, array) in [
        ("modes", "modes", kept(values.view(), 32), "eigenvalues"),
        (
            "bicoherence output=2",
            "bicoherence output=1",
            kept(two.view(), 32),
            "bicoherence",
        ),
    ] {
        let segments = "segment=32 overlap=0";
        let found = seen(&format!("{words} {segments} gaps=leave-out"), [&given]).unwrap();
        let expected = seen(&format!("{expected} {segments}"), [&kept]).unwrap();
        for array in [array, "/independence/segments"] {
            assert_eq!(found.array(array), expected.array(array));
        }
    }
}

#[test]
fn nothing_left_is_an_error_and_so_is_what_cannot_leave_out() {
    let all = record("gaps 600 4");
    let last = field(samples(&all).select(Axis(1), &[3]));
    let whole = asking(|it| it.gaps = Gaps::LeaveOut);
    for error in [
        spectrum(WELCH, [&last]).err(),
        modes(WELCH, [&all]).err(),
        slope("axis=time gaps=leave-out", [&all]).err(),
        wavecascade::analyze(&all, &whole).err(),
    ] {
        assert_eq!(option(error.unwrap()), "gaps");
    }
    // Snapshots that miss a sample go from the mean over the times.
    let mut snapshots = noise(64, 32);
    let rest: Vec<usize> = (0..64).filter(|n| *n != 3).collect();
    let rest = field(snapshots.select(Axis(0), &rest));
    snapshots[[3, 5]] = f64::NAN;
    let along = |field: &Field| {
        let words = "along=space segment=32 overlap=0 whole gaps=leave-out";
        spectrum(words, [field]).unwrap()
    };
    let (found, expected) = (along(&field(snapshots)), along(&rest));
    assert!(found.spectrum.column(3).iter().all(|v| v.is_nan()));
    let [found, expected] = [found, expected].map(|it| it.mean.unwrap().spectrum);
    assert_eq!(found, expected);
}

/// Of noise with gaps at random, several of up to a fortieth of the record a site, 95 % of the intervals hold the
/// true density.
#[test]
fn val_intervals_hold_as_often_as_they_say() {
    let (n_times, n_sites) = (4096, 64);
    let mut values = noise(n_times, n_sites);
    let mut random = Congruential(11);
    for (j, mut record) in values.columns_mut().into_iter().enumerate() {
        // From one gap to eight.
        for _ in 0..=j % 8 {
            let [from, length] = [0; 2].map(|_| 0.5 * (random.uniform() + 1.0));
            let from = (from * n_times as f64) as usize;
            let end = (from + 1 + (length * 100.0) as usize).min(n_times);
            record.slice_mut(s![from..end]).fill(f64::NAN);
        }
    }
    let words = "segment=128 overlap=64 gaps=leave-out";
    let found = spectrum(words, [&field(values)]).unwrap();
    let left = found.segments_left.as_ref().unwrap();
    assert!(left.least_and_median()[0] < 45 && left.of == 63);
    // One-sided, of variance 1.
    let [held, by_jackknife] = coverage(&found, 2..64, |_| 2.0 * DT);
    near(held, 0.95, 0.008);
    near(by_jackknife, 0.95, 0.012);
}

/// Where more than a twentieth of the samples were filled, nothing is stated of chance: white noise without a quarter of its
/// samples has a spectrum of three quarters, which no interval holds. A site without a sample has none.
#[test]
fn val_construction_filled_records_have_no_intervals() {
    let mut values = noise(2048, 4);
    values.slice_mut(s![600..640, 1]).fill(f64::NAN);
    let few = field(values.clone());
    values.slice_mut(s![600..1112, 1]).fill(f64::NAN);
    values.column_mut(2).fill(f64::NAN);
    let many = field(values);
    for gaps in ["interpolate", "mask"] {
        let of = |words: &str, field| seen(&format!("{words} gaps={gaps}"), [field]).unwrap();
        let spectra = of("spectrum segment=128 overlap=64", &few);
        assert_eq!(flat(&spectra.numbers["without_interval"]), [0.0]);
        for row in section("filled") {
            let found = of(row[0], &many);
            assert_undefined(&found, row[1]);
            for name in row[2].split(' ') {
                let is_stated = found.array(name).iter().skip(2).any(|v| v.is_finite());
                assert!(is_stated, "{row:?} {name} {gaps}");
            }
        }
    }
}

/// Red noise of known spectrum with scattered gaps: intervals hold where they are stated, which they are not below what is filled. An
/// offset is none of it: unrelated records about 5 with gaps at the same times have nothing in common.
#[test]
fn val_theory_intervals_of_filled_spectra_hold_or_are_withheld() {
    let white = noise(6 * 4 * 9000, 1);
    for (gaps, length, stated_of) in [
        ("mask", 512, 0.1..0.5),
        ("mask", 128, 0.02..0.5),
        ("interpolate", 512, 0.4..1.0),
        ("interpolate", 128, 0.2..1.0),
    ] {
        let (mut held, mut stated) = (Vec::new(), Vec::new());
        for seed in 0..6 {
            let white =
                Array2::from_shape_fn((8692, 4), |(n, j)| white[[9000 * (4 * seed + j) + n, 0]]);
            let mut values = 5.0 + &red(white, 0.95).slice(s![500.., ..]);
            let mut random = Congruential(seed as u64);
            values.mapv_inplace(|v| match random.uniform().abs() < 0.044 {
                true => f64::NAN,
                false => v,
            });
            let words = format!("segment={length} overlap={} gaps={gaps}", length / 2);
            let found = spectrum(&words, [&field(values)]).unwrap();
            for m in 2..length / 2 - 4 {
                let exact = 2.0 * DT / (1.9025 - 1.9 * (TAU * found.bins[m] * DT).cos());
                for (low, high) in found.low.row(m).iter().zip(found.high.row(m)) {
                    stated.push(low.is_finite());
                    let is_held = *low < exact && exact < *high;
                    held.extend(low.is_finite().then_some(is_held));
                }
            }
        }
        lies(share(held), 0.92..0.99);
        lies(share(stated), stated_of);
    }
    let mut values = 5.0 + &noise(8192, 6);
    for start in [500, 1700, 2900, 4100, 5300, 6500] {
        values.slice_mut(s![start..start + 40, ..]).fill(f64::NAN);
    }
    let found = coherence("segment=256 overlap=128 gaps=mask", [&field(values)]).unwrap();
    assert_eq!(found.coherent_sites().count(), 0);
}
