//! What is said holds, and is said where a field shows it: speeds that arrivals hide, reasons that are so, directions that an array
//! resolves.

use std::f64::consts::TAU;

use ndarray::Array2;
use test_support::fields::Congruential;
use wavecascade::moved::Reason;

use crate::moved_kinds::analysis_of;

/// Waves of many frequencies about `middle` that pass a site by `delay` samples, of one variance.
fn steady(seed: u64, (times, sites): (usize, usize), middle: f64, delay: f64) -> Array2<f64> {
    let mut random = Congruential(seed);
    let waves: Vec<[f64; 3]> = (0..60)
        .map(|i| {
            let f = middle * (0.75 + 0.5 * (i as f64 + 0.5 + 0.5 * random.uniform()) / 60.0);
            [TAU * f, random.gaussian(), random.gaussian()]
        })
        .collect();
    Array2::from_shape_fn((times, sites), |(n, j)| {
        let at = n as f64 - delay * j as f64;
        let of = |[w, a, b]: &[f64; 3]| a * (w * at).cos() + b * (w * at).sin();
        waves.iter().map(of).sum::<f64>() / 60f64.sqrt()
    })
}

/// Dead sites, and a gain of 6 for half of the record, spread energy over all wavenumbers: nothing folds, and most of the energy still
/// goes one way. A wave of two sites folds.
#[test]
fn val_theory_gains_do_not_fold() {
    for seed in 1..9 {
        let sites = 24;
        let wave = steady(seed, (2048, sites), 0.05, 1.1);
        let times = |factor: fn(usize, usize) -> f64| {
            let factors = Array2::from_shape_fn((2048, sites), |(n, j)| factor(n, j));
            &wave * factors
        };
        let dead = times(|_, j| f64::from(u8::from(j != 6 && j != 13)));
        let changed = times(|n, j| if n >= 1024 && j == 3 { 6.0 } else { 1.0 });
        for (name, values, least) in [
            ("whole", wave, 0.9),
            ("dead", dead, 0.8),
            ("gain", changed, 0.6),
        ] {
            let analysis = analysis_of(values);
            assert_eq!(analysis.undirected, None, "{seed} {name}");
            let direction = analysis.direction_of_waves().unwrap();
            assert!(
                direction.toward_plus_x > least,
                "{seed} {name}: {direction:?}"
            );
            let moved = &analysis.answer.as_ref().unwrap().wavenumber;
            let folds = Some(Reason::Aperture { folds: true });
            assert_ne!(moved.reason, folds, "{seed} {name}: {moved:?}");
        }
        let folds = analysis_of(steady(seed, (2048, sites), 0.05, 9.5));
        assert!(
            matches!(folds.undirected, Some(Reason::Aperture { folds: true })),
            "{seed}: {:?}",
            folds.undirected
        );
    }
}

/// Gains of single sites, 0.7 to 1.4, are no step along x; one of 5 beside them is, at its site and within its error.
#[test]
fn val_theory_gains_of_sites_are_no_step() {
    let (sites, at) = (60, 31);
    let (mut all, mut right, mut within) = (0, 0, 0);
    for seed in 1..31 {
        let mut random = Congruential(900 + seed);
        let gains: Vec<f64> = (0..sites).map(|_| 1.05 + 0.35 * random.uniform()).collect();
        for step in [1.0, 5.0] {
            let mut values = steady(seed, (1024, sites), 0.05, 2.3);
            for (j, gain) in gains.iter().enumerate() {
                let gain = gain * if j < at { 1.0 } else { step };
                values.column_mut(j).mapv_inplace(|v| gain * v);
            }
            let analysis = analysis_of(values);
            let mut told = analysis.warnings.iter();
            let Some(said) = told.find(|warning| warning.code == "gain-steps") else {
                continue;
            };
            let [sites, ratios, errors] = ["sites", "ratios", "ratio_errors"].map(|name| {
                let all: Vec<f64> = serde_json::from_value(said.numbers[name].clone()).unwrap();
                all
            });
            assert!(step > 1.0 && sites.len() == 1, "{seed}: {said:?}");
            let off = (sites[0] - at as f64).abs();
            assert!(off <= 2.0, "{seed}: {sites:?}");
            all += 1;
            right += usize::from(off == 0.0);
            within += usize::from((ratios[0] - step).abs() < errors[0]);
        }
    }
    let are_most = |part: usize| 10 * part >= 8 * all;
    assert!(all >= 20, "{all} {right} {within}");
    assert!(are_most(right), "{all} {right} {within}");
    assert!(are_most(within), "{all} {right} {within}");
}
