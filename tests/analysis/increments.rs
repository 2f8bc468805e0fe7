//! Structure functions against fluidsf (`data/increments.json`, made by `data/make_increments.py`) and closed
//! forms.

use ndarray::Array2;
use serde::Deserialize;
use test_support::changed;
use test_support::fields::{Congruential, noise, stepped};
use wavecascade::Field;
use wavecascade::estimates::{
    AxisIncrements, ExponentBasis, FieldAxis, Increments, IncrementsRequest, IntervalBasis,
    increments,
};
use wavecascade::observer::Silent;
use wavecascade::sheet::Describe;

const DT: f64 = 0.25;
const DX: f64 = 0.5;
const TAU: f64 = std::f64::consts::TAU;

fn field(values: Array2<f64>) -> Field {
    stepped(values, DT, DX)
}

fn found(field: &Field, request: &IncrementsRequest) -> Increments {
    increments(&[field], request, &Silent).unwrap()
}

fn along(found: &Increments, axis: FieldAxis) -> &AxisIncrements {
    found.axes.iter().find(|one| one.axis == axis).unwrap()
}

/// Moments of `|z|^p` of a normal variable.
const NORMAL: [f64; 6] = [
    0.797_884_560_802_865_4,
    1.0,
    1.595_769_121_605_730_8,
    3.0,
    6.383_076_486_422_923,
    15.0,
];

#[derive(Deserialize)]
struct Reference {
    separation: Vec<f64>,
    second: Vec<f64>,
    third: Vec<f64>,
}

#[test]
fn val_fluidsf_second_and_third_order() {
    let expected: Reference =
        serde_json::from_str(include_str!("../data/increments.json")).unwrap();
    let (mut random, mut sum) = (Congruential(1), 0.0);
    let values = Array2::from_shape_fn((1, 400), |_| {
        sum += random.uniform();
        sum
    });
    let steps = expected
        .separation
        .iter()
        .map(|r| (r / DX).round() as usize)
        .collect();
    let request = IncrementsRequest {
        separations: Some(steps),
        ..IncrementsRequest::default()
    };
    let found = found(&field(values), &request);
    let axis = along(&found, FieldAxis::Space);
    assert_eq!(axis.scales.len(), expected.separation.len());
    let mut worst = 0.0f64;
    for (i, m) in axis.scales.iter().enumerate() {
        assert_eq!(m.scale, expected.separation[i]);
        assert_eq!(m.pairs as usize, 400 - m.step);
        let third = (m.third - expected.third[i]).abs() / m.structure[2];
        worst = worst
            .max((m.structure[1] / expected.second[i] - 1.0).abs())
            .max(third);
    }
    assert!(worst < 3e-15, "{worst:e}");
}

/// `v = a sin(q x + w t)`: increments over r are `2 a sin(q r / 2)` times a cosine, whose moments are known
/// over whole periods.
#[test]
fn val_closed_form_of_a_sine() {
    let (a, n, sites) = (1.7f64, 64, 48);
    let q = TAU * 5.0 / n as f64;
    let values = Array2::from_shape_fn((n, sites), |(t, j)| {
        a * (q * t as f64 + 0.37 * j as f64).sin()
    });
    let request = IncrementsRequest {
        separations: Some(vec![1, 3, 10]),
        lags: None,
        ..IncrementsRequest::default()
    };
    let found = found(&field(values), &request);
    // Means of |cos|^p over the 64 phases: even orders are exact.
    for m in &along(&found, FieldAxis::Space).scales {
        let size = 2.0 * a * (0.185 * m.step as f64).sin().abs();
        for (p, mean) in [(2, 0.5), (4, 0.375), (6, 0.3125)] {
            let off = m.structure[p - 1] / (size.powi(p as i32) * mean) - 1.0;
            assert!(off.abs() < 5e-14, "{p}: {off:e}");
        }
        assert!((m.flatness - 1.5).abs() < 1e-13);
        assert!(m.third.abs() < 1e-13 * m.structure[2]);
        let mean = 2.0 / std::f64::consts::PI;
        assert!((m.structure[0] / (size * mean) - 1.0).abs() < 2e-3);
    }
}

/// One jump of height h in a ramp (a sawtooth over one period): for separations below the period,
/// `S_p = (1 - r / L) (h r / L)^p + (r / L) (h - h r / L)^p`, which grows like r; the third moment is negative.
#[test]
fn val_closed_form_of_a_sawtooth() {
    let (period, h) = (512usize, 3.0);
    // Eight periods: pairs over the whole of seven of them, by a step that divides none.
    let values = Array2::from_shape_fn((4, 8 * period), |(t, j)| {
        h * ((j + 37 * t) % period) as f64 / period as f64
    });
    let request = IncrementsRequest {
        separations: Some(vec![1, 2, 4, 8, 16]),
        band: Some((0.4, 2.1)),
        ..IncrementsRequest::default()
    };
    let found = found(&field(values), &request);
    let axis = along(&found, FieldAxis::Space);
    for m in &axis.scales {
        // Pairs of all eight periods but those that begin in the last r sites: count the jumps.
        let (mut jumps, mut pairs) = (0, 0);
        for t in 0..4 {
            for j in 0..8 * period - m.step {
                let at = (j + 37 * t) % period;
                jumps += usize::from(at + m.step >= period);
                pairs += 1;
            }
        }
        let share = jumps as f64 / pairs as f64;
        let (ramp, jump) = (
            h * m.step as f64 / period as f64,
            h - h * m.step as f64 / period as f64,
        );
        for p in 1..=6 {
            let expected = (1.0 - share) * ramp.powi(p) + share * jump.powi(p);
            let off = m.structure[p as usize - 1] / expected - 1.0;
            assert!(off.abs() < 3e-13, "{p}: {off:e}");
        }
        let expected = (1.0 - share) * ramp.powi(3) - share * jump.powi(3);
        assert!((m.third / expected - 1.0).abs() < 1e-12);
    }
    let fit = axis.exponents.unwrap();
    assert_eq!((fit.points, fit.basis), (3, ExponentBasis::Regression));
    // Like r, whatever the order: a shock.
    for p in 2..6 {
        assert!((fit.exponents[p] - 1.0).abs() < 0.03, "{fit:?}");
    }
}

/// Random walks: `S_p = m_p r^{p/2}` with normal moments, inside the intervals as often as stated, flatness 3.
#[test]
fn val_brownian_motion_scales_like_the_root() {
    let shots: Vec<Field> = (0..12)
        .map(|s| {
            let steps = noise(12 * 512, 64);
            let mut values = Array2::zeros((512, 64));
            for t in 0..512 {
                let mut sum = 0.0;
                for j in 0..64 {
                    sum += steps[[s * 512 + t, j]];
                    values[[t, j]] = sum;
                }
            }
            field(values)
        })
        .collect();
    let all: Vec<&Field> = shots.iter().collect();
    let request = IncrementsRequest {
        separations: Some(vec![1, 2, 4, 8, 16]),
        band: Some((0.0, 100.0)),
        ..IncrementsRequest::default()
    };
    let found = increments(&all, &request, &Silent).unwrap();
    assert_eq!(found.basis, IntervalBasis::Shots);
    let axis = along(&found, FieldAxis::Space);
    let (mut inside, mut count) = (0, 0);
    for m in &axis.scales {
        for p in 0..6 {
            let expected = NORMAL[p] * (m.step as f64).powf(0.5 * (p + 1) as f64);
            let off = m.structure[p] / expected - 1.0;
            assert!(
                off.abs() < [0.01, 0.01, 0.02, 0.03, 0.05, 0.1][p],
                "{p} {} {off}",
                m.step
            );
            count += 1;
            inside += usize::from((m.structure[p] - expected).abs() < m.half[p]);
        }
        assert!(
            (m.flatness - 3.0).abs() < 1.5 * m.half[7].min(0.06),
            "{m:?}"
        );
    }
    assert!(axis.third_signs(0.05).is_empty());
    let fit = axis.exponents.unwrap();
    // Orders of one scale go together.
    assert!(10 * inside >= 7 * count, "{inside} of {count}");
    assert_eq!(fit.basis, ExponentBasis::Shots);
    for p in 0..6 {
        let expected = 0.5 * (p + 1) as f64;
        assert!(
            (fit.exponents[p] - expected).abs() < 2.0 * fit.half[p],
            "{fit:?}"
        );
        assert!(fit.half[p] < 0.02 * (p + 1) as f64);
        assert!((fit.relative[p] - (p + 1) as f64 / 3.0).abs() < 0.01);
    }
}

/// Normal noise: the histogram is the normal density, within what counts leave.
#[test]
fn val_histogram_of_normal_increments() {
    let values = noise(1024, 64);
    let request = changed(IncrementsRequest::default(), |it| it.histograms = 2);
    let found = found(&field(values), &request);
    let histogram = &along(&found, FieldAxis::Space).histograms[0];
    let sum: f64 = histogram.density.iter().map(|d| d * 0.25).sum();
    assert!((sum - 1.0).abs() < 1e-12 && histogram.outside == [0, 0]);
    let pairs = 1024.0 * 63.0;
    for (edges, density) in histogram.edges.windows(2).zip(&histogram.density) {
        let middle: f64 = 0.5 * (edges[0] + edges[1]);
        // The mean of the density over a cell of 1/4.
        let normal = (-0.5 * middle * middle).exp() / TAU.sqrt();
        let expected = normal * (1.0 + (middle * middle - 1.0) / (24.0 * 16.0));
        let spread = (expected / (0.25 * pairs)).sqrt();
        assert!(
            (density - expected).abs() < 6.0 * spread + 1e-4,
            "{middle}: {density}"
        );
    }
}

/// Missing samples are left out, with the number of pairs; the rest has the same bits as summed by hand.
#[test]
fn regress_gaps_are_left_out() {
    let mut values = noise(64, 16);
    values[[3, 5]] = f64::NAN;
    values[[10, 0]] = f64::INFINITY;
    let request = IncrementsRequest {
        separations: Some(vec![2]),
        lags: Some(vec![4]),
        ..IncrementsRequest::default()
    };
    let found = found(&field(values.clone()), &request);
    let space = along(&found, FieldAxis::Space).scales[0];
    let time = along(&found, FieldAxis::Time).scales[0];
    assert_eq!(space.pairs, 64 * 14 - 3);
    assert_eq!(time.pairs, 60 * 16 - 3);
    let mut sum = 0.0;
    for t in 0..60 {
        for j in 0..16 {
            let d: f64 = values[[t + 4, j]] - values[[t, j]];
            sum += if d.is_finite() { d * d } else { 0.0 };
        }
    }
    assert!((time.structure[1] / (sum / time.pairs as f64) - 1.0).abs() < 1e-14);
}

/// A pulse, one that noise hides over the smallest lag, and one that is in the array all the time.
#[test]
fn regress_one_transient_has_no_interval() {
    for (times, sites, from, apart, width, level) in [
        (2048, 6, 300.0, 5.0, 6.0, 0.0),
        (2048, 6, 300.0, 5.0, 20.0, 0.03),
        (512, 48, 20.0, 10.0, 12.0, 0.0),
    ] {
        let mut values = noise(times, sites) * level;
        for ((n, j), v) in values.indexed_iter_mut() {
            let t = (n as f64 - from - apart * j as f64) / width;
            *v += (-t * t).exp();
        }
        let one = found(&field(values), &IncrementsRequest::default());
        assert_eq!(one.basis, IntervalBasis::None, "{}", one.steadiness);
        for axis in &one.axes {
            let mut halves = axis.scales.iter().flat_map(|m| m.half);
            assert!(halves.all(f64::is_nan));
            assert!(axis.third_signs(0.05).is_empty() && axis.is_intermittent().is_none());
        }
    }
}

/// Normal noise that follows itself (AR(1)) in time, with a factor for each sample and limits of its size.
fn coloured(seed: usize, follows: f64, limit: f64, factor: impl Fn(usize, usize) -> f64) -> Field {
    let mut values = noise(4096 * (seed + 1), 16);
    values = values.slice(ndarray::s![4096 * seed.., ..]).to_owned();
    for mut record in values.columns_mut() {
        let mut last = 0.0;
        record.mapv_inplace(|v| {
            last = follows * last + v;
            last
        });
    }
    values
        .indexed_iter_mut()
        .for_each(|((t, j), v)| *v = (*v * factor(t, j)).clamp(-limit, limit));
    field(values)
}

/// Levels that differ from site to site or in time, and limits, make no field intermittent, though they give it a flatness of up to
/// 20 and one that grows towards small scales; a level that changes at random within the record does.
#[test]
fn val_levels_are_no_intermittency() {
    let (mut wrong, mut held, mut missed) = (0, 0, 0);
    for seed in 0..8 {
        let loud = |_, j| if j == 4 { 5.0 } else { 1.0 };
        let decays = |t: usize, j: usize| (-0.15 * j as f64 - t as f64 / 4096.0).exp();
        for still in [
            coloured(seed, 0.0, f64::INFINITY, loud),
            coloured(seed, 0.9, f64::INFINITY, decays),
            coloured(seed, 0.9, 3.0, |_, _| 1.0),
        ] {
            let found = found(&still, &IncrementsRequest::default());
            let told = |axis: &AxisIncrements| axis.is_intermittent().unwrap();
            wrong += found.axes.iter().filter(|axis| told(axis)).count();
            let smallest = along(&found, FieldAxis::Time).scales[0];
            let off = (smallest.local_flatness - 3.0).abs();
            held += usize::from(off < smallest.local_flatness_half());
        }
        let level = coloured(seed + 8, 0.95, f64::INFINITY, |_, _| 0.2);
        let mut samples = vec![0.0; 4096 * 16];
        level.read_time_major(0..4096, 0..16, &mut samples);
        let bursts = coloured(seed, 0.5, f64::INFINITY, |t, j| samples[16 * t + j].exp());
        let found = found(&bursts, &IncrementsRequest::default());
        missed += usize::from(along(&found, FieldAxis::Time).is_intermittent() != Some(true));
    }
    assert!(wrong <= 3 && missed == 0, "{wrong} of 48, {missed} of 8");
    // Of loud and decaying fields.
    assert!((13..=16).contains(&held), "{held} of 16");
}

/// Records that are the same have no increments along x.
#[test]
fn val_the_same_records_do_not_move_along_x() {
    let one = noise(512, 1);
    let same = Array2::from_shape_fn((512, 12), |(t, _)| one[[t, 0]]);
    let found = found(&field(same), &IncrementsRequest::default());
    assert!(!along(&found, FieldAxis::Space).moves() && along(&found, FieldAxis::Time).moves());
    let answer = found.describe().answer;
    assert!(
        answer.starts_with("all increments along x are 0"),
        "{answer}"
    );
}
