//! Averages that leave out segments with missing samples, against SciPy on segments picked by hand
//! (`data/gaps.json`, made by `data/make_gaps.py`), and their intervals on noise.

use std::f64::consts::TAU;

use ndarray::{Array2, concatenate};
use serde::Deserialize;
use test_support::changed;
use test_support::fields::{Congruential, asking, averaging, noise, option, stepped};
use wavecascade::Field;
use wavecascade::estimates::{
    BicoherenceRequest, CoherenceRequest, ModesRequest, SpectrumAxis, SpectrumRequest, Tapers,
    bicoherence, coherence, modes, slope, spectrum,
};
use wavecascade::observer::Silent;
use wavecascade::prepare::Gaps;

const DT: f64 = 0.25;

fn generated(seed: u64, count: usize) -> Vec<f64> {
    let mut random = Congruential(seed);
    (0..count).map(|_| random.uniform()).collect()
}

fn field(values: Array2<f64>) -> Field {
    stepped(values, DT, 1.0)
}

fn request(segment: usize, overlap: usize) -> SpectrumRequest {
    SpectrumRequest {
        averaging: averaging(segment, overlap),
        gaps: Gaps::LeaveOut,
        ..SpectrumRequest::default()
    }
}

#[derive(Deserialize)]
struct Welch {
    segments: usize,
    effective: f64,
    spectrum: Option<Vec<f64>>,
    low: Option<Vec<f64>>,
    high: Option<Vec<f64>>,
    jackknife: Option<Vec<f64>>,
}

#[derive(Deserialize)]
struct WithSite1 {
    segments: usize,
    coherence: Vec<f64>,
    level: f64,
}

#[derive(Deserialize)]
struct Together {
    segments: usize,
    effective: f64,
}

#[derive(Deserialize)]
struct Reference {
    missing: [Vec<usize>; 4],
    welch: [Welch; 4],
    tapered: [Option<Vec<f64>>; 4],
    coherence: [Option<WithSite1>; 4],
    together: Together,
}

fn reference() -> Reference {
    serde_json::from_str(include_str!("../data/gaps.json")).unwrap()
}

/// The records of `make_gaps.py`.
fn with_gaps(reference: &Reference) -> Array2<f64> {
    let common = generated(7, 600);
    let records: Vec<Vec<f64>> = (1..5).map(|seed| generated(seed, 600)).collect();
    let mut values = Array2::from_shape_fn((600, 4), |(n, j)| records[j][n] + common[n]);
    for (j, missing) in reference.missing.iter().enumerate() {
        missing.iter().for_each(|n| values[[*n, j]] = f64::NAN);
    }
    values
}

/// The largest relative difference of a column away from 0 and from the Nyquist frequency; all are NaN where
/// nothing is expected.
fn differs(found: &Array2<f64>, site: usize, expected: Option<&Vec<f64>>) -> f64 {
    let column = found.column(site);
    let Some(expected) = expected else {
        return if column.iter().all(|v| v.is_nan()) {
            0.0
        } else {
            1.0
        };
    };
    let inside = 1..expected.len() - 1;
    let one = |m: usize| (column[m] / expected[m] - 1.0).abs();
    inside
        .map(one)
        .fold(0.0, |a: f64, b| if a > b { a } else { b })
}

#[test]
fn val_scipy_segments_picked_by_hand() {
    let reference = reference();
    let field = field(with_gaps(&reference));
    let found = spectrum(&[&field], &request(64, 32), &Silent).unwrap();
    let left = found.segments_left.as_ref().unwrap();
    assert_eq!((left.of, left.incomplete(), left.empty()), (17, 3, vec![3]));
    assert_eq!(found.has_interval, [true, true, true, false]);
    for (j, expected) in reference.welch.iter().enumerate() {
        assert_eq!(left.left[j], expected.segments);
        assert!((left.effective[j] - expected.effective).abs() < 1e-12);
        for (what, array, expected) in [
            ("spectrum", &found.spectrum, &expected.spectrum),
            ("low", &found.low, &expected.low),
            ("high", &found.high, &expected.high),
            ("jackknife", &found.jackknife, &expected.jackknife),
        ] {
            // Jackknives are differences of logarithms that nearly cancel.
            let error = differs(array, j, expected.as_ref());
            assert!(error < 1e-9, "{what} {j}: {error:e}");
        }
    }
    // Several tapers with equal weights.
    let mut several = request(64, 32);
    several.averaging.tapers = Tapers::Slepian { nw: 2.0, count: 3 };
    several.is_adaptive = false;
    let found = spectrum(&[&field], &several, &Silent).unwrap();
    for (j, expected) in reference.tapered.iter().enumerate() {
        let error = differs(&found.spectrum, j, expected.as_ref());
        assert!(error < 1e-11, "tapered {j}: {error:e}");
    }
    // Sites without gaps are what they are without the choice, to rounding; others are refused then.
    let whole = field_of(&field, 0);
    let usual = changed(request(64, 32), |it| it.gaps = Gaps::Refuse);
    let usual = spectrum(&[&whole], &usual, &Silent).unwrap();
    let chosen = spectrum(&[&whole], &request(64, 32), &Silent).unwrap();
    assert_eq!(usual.spectrum, chosen.spectrum);
    // Degrees of freedom are summed in another order.
    let degrees = usual.degrees.iter().zip(&chosen.degrees);
    degrees.for_each(|(a, b)| assert!((a / b - 1.0).abs() < 1e-13 || a.is_nan() && b.is_nan()));
}

fn field_of(all: &Field, site: usize) -> Field {
    let mut record = vec![0.0; all.n_times()];
    all.read_site_major(0..all.n_times(), site..site + 1, &mut record);
    field(Array2::from_shape_vec((record.len(), 1), record).unwrap())
}

#[test]
fn val_scipy_coherence_of_segments_that_both_sites_have() {
    let reference = reference();
    let field = field(with_gaps(&reference));
    let request = CoherenceRequest {
        reference: 1,
        averaging: averaging(64, 32),
        gaps: Gaps::LeaveOut,
        ..CoherenceRequest::default()
    };
    let found = coherence(&[&field], &request, &Silent).unwrap();
    let left = found.segments_left.as_ref().unwrap();
    for (j, expected) in reference.coherence.iter().enumerate() {
        let Some(expected) = expected else {
            assert!(left.left[j] == 0 && found.coherence.column(j).iter().all(|v| v.is_nan()));
            assert_eq!(found.level_at(j), None);
            continue;
        };
        assert_eq!(left.left[j], expected.segments);
        assert!((found.level_at(j).unwrap() / expected.level - 1.0).abs() < 1e-12);
        let error = differs(&found.coherence, j, Some(&expected.coherence));
        assert!(error < 1e-9, "{j}: {error:e}");
    }
    // Of the segments that it shares, a site has the spectrum of itself.
    let alone = spectrum(&[&field], &super::gaps::request(64, 32), &Silent).unwrap();
    let cells = found
        .spectrum
        .column(1)
        .into_iter()
        .zip(alone.spectrum.column(1));
    cells.for_each(|(a, b)| assert!((a / b - 1.0).abs() < 1e-12));
}

/// Without overlap, what is left is as good as a record of the segments that are left.
#[test]
fn val_estimates_of_several_sites_leave_out_what_any_of_them_misses() {
    let reference = reference();
    let values = with_gaps(&reference);
    let three = values.slice(ndarray::s![.., ..3]).to_owned();
    let kept = |segment: usize| {
        let parts = three.exact_chunks((segment, 3)).into_iter();
        let parts: Vec<_> = parts
            .filter(|part| part.iter().all(|v| v.is_finite()))
            .collect();
        field(concatenate(ndarray::Axis(0), &parts).unwrap())
    };
    let given = field(three.clone());
    let modes_request = |gaps| ModesRequest {
        averaging: averaging(32, 0),
        gaps,
        ..ModesRequest::default()
    };
    let found = modes(&[&given], &modes_request(Gaps::LeaveOut), &Silent).unwrap();
    let expected = modes(&[&kept(32)], &modes_request(Gaps::Refuse), &Silent).unwrap();
    assert_eq!(found.independence.segments, 9);
    assert_eq!(found.eigenvalues, expected.eigenvalues);

    let of_three = |gaps| BicoherenceRequest {
        site: 0,
        output: Some(2),
        averaging: averaging(32, 0),
        gaps,
        ..BicoherenceRequest::default()
    };
    let found = bicoherence(&[&given], &of_three(Gaps::LeaveOut), &Silent).unwrap();
    let two = three.select(ndarray::Axis(1), &[0, 2]);
    let parts = two.exact_chunks((32, 2)).into_iter();
    let parts: Vec<_> = parts
        .filter(|part| part.iter().all(|v| v.is_finite()))
        .collect();
    let whole = field(concatenate(ndarray::Axis(0), &parts).unwrap());
    let of_two = changed(of_three(Gaps::Refuse), |it| it.output = Some(1));
    let expected = bicoherence(&[&whole], &of_two, &Silent).unwrap();
    assert_eq!(found.map.bicoherence, expected.map.bicoherence);
    assert_eq!(found.independence.segments, parts.len());

    // Welch's sum over pairs of segments that are left.
    let overlapping = ModesRequest {
        averaging: averaging(64, 32),
        ..modes_request(Gaps::LeaveOut)
    };
    let found = modes(&[&given], &overlapping, &Silent).unwrap();
    assert_eq!(found.independence.segments, reference.together.segments);
    assert!((found.independence.effective - reference.together.effective).abs() < 1e-12);
}

#[test]
fn nothing_left_is_an_error_and_so_is_what_cannot_leave_out() {
    let reference = reference();
    let all = field(with_gaps(&reference));
    let last = field_of(&all, 3);
    let error = spectrum(&[&last], &request(64, 32), &Silent).unwrap_err();
    assert_eq!(option(error), "gaps");
    let all_sites = ModesRequest {
        averaging: averaging(64, 32),
        gaps: Gaps::LeaveOut,
        ..ModesRequest::default()
    };
    assert_eq!(
        option(modes(&[&all], &all_sites, &Silent).unwrap_err()),
        "gaps"
    );
    let steep = wavecascade::estimates::SlopeRequest {
        gaps: Gaps::LeaveOut,
        axis: wavecascade::estimates::FieldAxis::Time,
        ..Default::default()
    };
    assert_eq!(option(slope(&[&all], &steep, &Silent).unwrap_err()), "gaps");
    let whole = asking(|it| it.gaps = Gaps::LeaveOut);
    assert_eq!(
        option(wavecascade::analyze(&all, &whole).unwrap_err()),
        "gaps"
    );
    // Snapshots that miss a sample go from the mean over the times.
    let mut snapshots = noise(64, 32);
    let full = snapshots.clone();
    snapshots[[3, 5]] = f64::NAN;
    let along = SpectrumRequest {
        along: SpectrumAxis::Space,
        is_whole: true,
        ..request(32, 0)
    };
    let found = spectrum(&[&field(snapshots)], &along, &Silent).unwrap();
    assert!(found.spectrum.column(3).iter().all(|v| v.is_nan()));
    let rest: Vec<usize> = (0..64).filter(|n| *n != 3).collect();
    let rest = field(full.select(ndarray::Axis(0), &rest));
    let expected = spectrum(&[&rest], &along, &Silent).unwrap();
    let (found, expected) = (found.mean.unwrap(), expected.mean.unwrap());
    assert_eq!(found.spectrum, expected.spectrum);
}

/// Of noise with gaps at random, several of up to a fortieth of the record a site, 95 % of the intervals hold the
/// true density.
#[test]
fn val_intervals_hold_as_often_as_they_say() {
    let (n_times, n_sites) = (4096, 64);
    let mut values = noise(n_times, n_sites);
    let at = generated(11, 2 * 8 * n_sites);
    for j in 0..n_sites {
        // From one gap to eight.
        for i in 0..=j % 8 {
            let [from, length] = [0, 1].map(|k| 0.5 * (at[2 * (8 * j + i) + k] + 1.0));
            let from = (from * n_times as f64) as usize;
            let end = (from + 1 + (length * 100.0) as usize).min(n_times);
            values.slice_mut(ndarray::s![from..end, j]).fill(f64::NAN);
        }
    }
    let found = spectrum(&[&field(values)], &request(128, 64), &Silent).unwrap();
    let left = found.segments_left.as_ref().unwrap();
    assert!(left.least_and_median()[0] < 45 && left.of == 63);
    // One-sided, of variance 1.
    let truth = 2.0 * DT;
    let mut held = [0, 0];
    let mut cells = 0;
    for (cell, s) in found.spectrum.slice(ndarray::s![2..64, ..]).indexed_iter() {
        let cell = [cell.0 + 2, cell.1];
        cells += 1;
        held[0] += usize::from((found.low[cell]..found.high[cell]).contains(&truth));
        held[1] += usize::from((truth / s).ln().abs() < found.jackknife[cell]);
    }
    let shares = held.map(|held| held as f64 / f64::from(cells));
    assert!((shares[0] - 0.95).abs() < 0.008, "{shares:?}");
    assert!((shares[1] - 0.95).abs() < 0.012, "{shares:?}");
}

/// Where more than a twentieth of the samples were filled, nothing is stated of chance: white noise without a quarter of its
/// samples has a spectrum of three quarters, which no interval holds. A site without a sample has none.
#[test]
fn val_construction_filled_records_have_no_intervals() {
    let values = |share: f64| {
        let noise = noise(2048, 4);
        Array2::from_shape_fn((2048, 4), |(n, j)| match j {
            1 if (600..600 + (2048.0 * share) as usize).contains(&n) => f64::NAN,
            2 if share > 0.05 => f64::NAN,
            _ => noise[[n, j]],
        })
    };
    for gaps in [Gaps::Interpolate, Gaps::Mask] {
        let of = |share: f64| {
            let request = changed(request(128, 64), |it| it.gaps = gaps);
            spectrum(&[&field(values(share))], &request, &Silent).unwrap()
        };
        let (few, many) = (of(0.02), of(0.25));
        assert!(few.has_interval.iter().all(|has| *has), "{gaps:?}");
        assert_eq!(many.has_interval, [true, false, false, true], "{gaps:?}");
        assert!(many.low.column(1).iter().all(|v| v.is_nan()));
        assert!(many.spectrum.column(2).iter().all(|v| v.is_nan()));
        let request = CoherenceRequest {
            averaging: averaging(128, 64),
            gaps,
            ..CoherenceRequest::default()
        };
        let found = coherence(&[&field(values(0.25))], &request, &Silent).unwrap();
        assert!(found.level().is_some(), "{gaps:?}");
        assert!(found.coherence.column(1).iter().all(|v| v.is_nan()));
        assert!(found.coherence.column(3).iter().all(|v| v.is_finite()));
        let request = changed(request, |it| it.reference = 1);
        let found = coherence(&[&field(values(0.25))], &request, &Silent).unwrap();
        assert!(found.level().is_none(), "{gaps:?}");
        let request = BicoherenceRequest {
            site: 1,
            averaging: averaging(128, 64),
            gaps,
            ..BicoherenceRequest::default()
        };
        let found = bicoherence(&[&field(values(0.25))], &request, &Silent).unwrap();
        assert!(found.map_level().is_none(), "{gaps:?}");
        let request = ModesRequest {
            averaging: averaging(128, 64),
            gaps,
            ..ModesRequest::default()
        };
        let found = modes(&[&field(values(0.25))], &request, &Silent).unwrap();
        assert!(found.independence.is_transient(), "{gaps:?}");
    }
}

/// Red noise of known spectrum with scattered gaps: intervals hold where they are stated, which they are not below what is filled. An
/// offset is none of it: unrelated records about 5 with gaps at the same times have nothing in common.
#[test]
fn val_theory_intervals_of_filled_spectra_hold_or_are_withheld() {
    for (gaps, length, least) in [
        (Gaps::Mask, 512, 0.1),
        (Gaps::Mask, 128, 0.02),
        (Gaps::Interpolate, 512, 0.4),
        (Gaps::Interpolate, 128, 0.2),
    ] {
        let (mut within, mut stated, mut all) = (0.0, 0.0, 0.0);
        for seed in 0..6 {
            let white = noise(4 * 9000 * (seed + 1), 1);
            let holes = generated(seed as u64, 8192 * 4);
            let mut red = Array2::zeros((8192, 4));
            for j in 0..4 {
                let mut last = 0.0;
                for n in 0..8692 {
                    last = 0.95 * last + white[[(4 * seed + j) * 9000 + n, 0]];
                    if n >= 500 {
                        let is_missing = holes[4 * (n - 500) + j].abs() < 0.044;
                        red[[n - 500, j]] = if is_missing { f64::NAN } else { 5.0 + last };
                    }
                }
            }
            let request = changed(request(length, length / 2), |it| it.gaps = gaps);
            let found = spectrum(&[&field(red)], &request, &Silent).unwrap();
            for (m, f) in found.bins.iter().enumerate().skip(2).take(length / 2 - 6) {
                let [re, im] = [(TAU * f * DT).cos(), (TAU * f * DT).sin()];
                let gain = (1.0 - 0.95 * re).powi(2) + (0.95 * im).powi(2);
                let exact = 2.0 * DT / gain;
                for j in 0..4 {
                    let [low, high] = [found.low[[m, j]], found.high[[m, j]]];
                    all += 1.0;
                    stated += f64::from(u8::from(low.is_finite()));
                    within += f64::from(u8::from(low < exact && exact < high));
                }
            }
        }
        let (coverage, stated) = (within / stated, stated / all);
        assert!(
            (0.92..0.99).contains(&coverage),
            "{gaps:?} {length}: {coverage}"
        );
        assert!(stated > least, "{gaps:?} {length}: {stated}");
        assert!(stated < 0.5 || gaps != Gaps::Mask, "{stated}");
    }
    let mut values = 5.0 + &noise(8192, 6);
    for start in [500, 1700, 2900, 4100, 5300, 6500] {
        values
            .slice_mut(ndarray::s![start..start + 40, ..])
            .fill(f64::NAN);
    }
    let request = CoherenceRequest {
        gaps: Gaps::Mask,
        averaging: averaging(256, 128),
        ..CoherenceRequest::default()
    };
    let found = coherence(&[&field(values)], &request, &Silent).unwrap();
    assert_eq!(found.coherent_sites().count(), 0);
}
