//! Structure functions against fluidsf and closed forms.

use std::f64::consts::{PI, TAU};

use ndarray::{Array2, s};
use test_support::estimate::increments;
use test_support::fields::{noise, red};
use test_support::{lies, near};
use wavecascade::Field;
use wavecascade::estimates::{AxisIncrements, FieldAxis, Increments, IntervalBasis};
use wavecascade::sheet::Describe;

use crate::peers::{compare, field};

fn found(words: &str, values: Array2<f64>) -> Increments {
    increments(words, [&field(values)]).unwrap()
}

fn along(found: &Increments, axis: FieldAxis) -> &AxisIncrements {
    found.axes.iter().find(|one| one.axis == axis).unwrap()
}

/// Moments of `|z|^p` of a normal variable, and within how much of them those of random walks are.
const NORMAL: [(f64, f64); 6] = [
    (0.797_884_560_802_865_4, 0.01),
    (1.0, 0.01),
    (1.595_769_121_605_730_8, 0.02),
    (3.0, 0.03),
    (6.383_076_486_422_923, 0.05),
    (15.0, 0.1),
];

#[test]
fn val_fluidsf_second_and_third_order() {
    compare("fluidsf");
}

/// `v = a sin(q x + w t)`: increments over r are `2 a sin(q r / 2)` times a cosine, whose moments are known
/// over whole periods.
#[test]
fn val_closed_form_of_a_sine() {
    let (a, n) = (1.7f64, 64);
    let q = TAU * 5.0 / n as f64;
    let values =
        Array2::from_shape_fn((n, 48), |(t, j)| a * (q * t as f64 + 0.37 * j as f64).sin());
    // Means of |cos|^p over the 64 phases: even orders are exact.
    for m in &along(&found("separations=1,3,10", values), FieldAxis::Space).scales {
        let size = 2.0 * a * (0.185 * m.step as f64).sin().abs();
        for (p, mean) in [(2, 0.5), (4, 0.375), (6, 0.3125)] {
            let expected = size.powi(p as i32) * mean;
            near(m.structure[p - 1] / expected, 1.0, 5e-14);
        }
        near(m.flatness, 1.5, 1e-13);
        near(m.third, 0.0, 1e-13 * m.structure[2]);
        near(m.structure[0] / (size * 2.0 / PI), 1.0, 2e-3);
    }
}

/// One jump of height h in a ramp (a sawtooth over one period): for separations below the period,
/// `S_p = (1 - r / L) (h r / L)^p + (r / L) (h - h r / L)^p`, which grows like r; the third moment is negative.
#[test]
fn val_closed_form_of_a_sawtooth() {
    let (period, h, sites) = (512usize, 3.0, 8 * 512);
    // Eight periods: pairs over the whole of seven of them, by a step that divides none.
    let values = Array2::from_shape_fn((4, sites), |(t, j)| {
        h * ((j + 37 * t) % period) as f64 / period as f64
    });
    let found = found("separations=1,2,4,8,16 band=0.4,2.1", values);
    let axis = along(&found, FieldAxis::Space);
    for m in &axis.scales {
        // Pairs of all eight periods but those that begin in the last r sites: count the jumps.
        let jumps = (0..4).flat_map(|t| (0..sites - m.step).map(move |j| (j + 37 * t) % period));
        let share = test_support::share(jumps.map(|at| at + m.step >= period));
        let ramp = h * m.step as f64 / period as f64;
        let parts = |p: i32| ((1.0 - share) * ramp.powi(p), share * (h - ramp).powi(p));
        for p in 1..=6 {
            let (ramps, jumps) = parts(p);
            near(m.structure[p as usize - 1] / (ramps + jumps), 1.0, 3e-13);
        }
        near(m.third / (parts(3).0 - parts(3).1), 1.0, 1e-12);
    }
    let fit = axis.exponents.unwrap();
    assert_eq!((fit.points, fit.basis), (3, IntervalBasis::Regression));
    // Like r, whatever the order: a shock.
    fit.exponents[2..].iter().for_each(|e| near(*e, 1.0, 0.03));
}

/// Random walks: `S_p = m_p r^{p/2}` with normal moments, inside the intervals as often as stated, flatness 3.
#[test]
fn val_brownian_motion_scales_like_the_root() {
    let steps = noise(12 * 512, 64);
    let walk = |steps: ndarray::ArrayView2<f64>| red(steps.t().to_owned(), 1.0).reversed_axes();
    let shots = steps.exact_chunks((512, 64)).into_iter();
    let shots: Vec<Field> = shots.map(|one| field(walk(one))).collect();
    let found = increments("separations=1,2,4,8,16 band=0,100", &shots).unwrap();
    assert_eq!(found.basis, IntervalBasis::Shots);
    let axis = along(&found, FieldAxis::Space);
    let mut inside = 0;
    for m in &axis.scales {
        for (p, (moment, within)) in NORMAL.into_iter().enumerate() {
            let expected = moment * (m.step as f64).powf(0.5 * (p + 1) as f64);
            near(m.structure[p] / expected, 1.0, within);
            inside += usize::from((m.structure[p] - expected).abs() < m.half[p]);
        }
        near(m.flatness, 3.0, 1.5 * m.half[7].min(0.06));
    }
    // Orders of one scale go together.
    assert!(inside >= 21, "{inside} of 30");
    assert!(axis.third_signs(0.05).is_empty());
    let fit = axis.exponents.unwrap();
    assert_eq!(fit.basis, IntervalBasis::Shots);
    for (p, order) in (0..6).zip(1..) {
        let order = f64::from(order);
        near(fit.exponents[p], 0.5 * order, 2.0 * fit.half[p]);
        lies(fit.half[p], 0.0..0.02 * order);
        near(fit.relative[p], order / 3.0, 0.01);
    }
}

/// Normal noise: the histogram is the normal density, within what counts leave.
#[test]
fn val_histogram_of_normal_increments() {
    let found = found("histograms=2", noise(1024, 64));
    let histogram = &along(&found, FieldAxis::Space).histograms[0];
    near(histogram.density.iter().sum::<f64>() * 0.25, 1.0, 1e-12);
    assert_eq!(histogram.outside, [0, 0]);
    let pairs = 1024.0 * 63.0;
    for (edges, density) in histogram.edges.windows(2).zip(&histogram.density) {
        let middle: f64 = 0.5 * (edges[0] + edges[1]);
        // The mean of the density over a cell of 1/4.
        let normal = (-0.5 * middle * middle).exp() / TAU.sqrt();
        let expected = normal * (1.0 + (middle * middle - 1.0) / (24.0 * 16.0));
        let spread = (expected / (0.25 * pairs)).sqrt();
        near(*density, expected, 6.0 * spread + 1e-4);
    }
}

/// Missing samples are left out, with the number of pairs; the rest has the same bits as summed by hand.
#[test]
fn regress_gaps_are_left_out() {
    let mut values = noise(64, 16);
    values[[3, 5]] = f64::NAN;
    values[[10, 0]] = f64::INFINITY;
    let found = found("separations=2 lags=4", values.clone());
    let [space, time] =
        [FieldAxis::Space, FieldAxis::Time].map(|axis| along(&found, axis).scales[0]);
    assert_eq!((space.pairs, time.pairs), (64 * 14 - 3, 60 * 16 - 3));
    let steps = &values.slice(s![4.., ..]) - &values.slice(s![..-4, ..]);
    let known = steps.iter().filter(|d| d.is_finite());
    let sum: f64 = known.map(|d| d * d).sum();
    near(time.structure[1] / (sum / time.pairs as f64), 1.0, 1e-14);
}

/// Normal noise that follows itself (AR(1)) in time, with a factor for each sample and limits of its size.
fn coloured(
    seed: usize,
    follows: f64,
    limit: f64,
    factor: impl Fn(usize, usize) -> f64,
) -> Array2<f64> {
    let values = noise(4096 * (seed + 1), 16);
    let mut values = red(values.slice(s![4096 * seed.., ..]).to_owned(), follows);
    for ((t, j), v) in values.indexed_iter_mut() {
        *v = (*v * factor(t, j)).clamp(-limit, limit);
    }
    values
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
            let found = found("", still);
            let told = |axis: &&AxisIncrements| axis.is_intermittent().unwrap();
            wrong += found.axes.iter().filter(told).count();
            let smallest = along(&found, FieldAxis::Time).scales[0];
            let off = (smallest.local_flatness - 3.0).abs();
            held += usize::from(off < smallest.local_flatness_half());
        }
        let level = coloured(seed + 8, 0.95, f64::INFINITY, |_, _| 0.2);
        let bursts = coloured(seed, 0.5, f64::INFINITY, |t, j| level[[t, j]].exp());
        let found = found("", bursts);
        missed += usize::from(along(&found, FieldAxis::Time).is_intermittent() != Some(true));
    }
    assert!(wrong <= 3 && missed == 0, "{wrong} of 48, {missed} of 8");
    // Of loud and decaying fields.
    assert!((13..=16).contains(&held), "{held} of 16");
}

/// Records that are the same have no increments along x.
#[test]
fn val_the_same_records_do_not_move_along_x() {
    let same = noise(512, 1).broadcast((512, 12)).unwrap().to_owned();
    let found = found("", same);
    assert!(!along(&found, FieldAxis::Space).moves() && along(&found, FieldAxis::Time).moves());
    let (answer, said) = (found.describe().answer, "all increments along x are 0");
    assert!(answer.starts_with(said), "{answer}");
}
