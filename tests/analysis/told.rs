//! What is said holds, and is said where a field shows it: speeds that arrivals hide, reasons that are so, directions that an array
//! resolves.

use std::f64::consts::TAU;

use ndarray::Array2;
use test_support::fields::{Congruential, noise};
use wavecascade::analyze::Warning;
use wavecascade::moved::{Reason, Verdict};

use crate::moved_kinds::{analysis_of, answer_of, burst};

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

/// A burst that passes a site in a third of a sample, in noise that scatters arrivals by many: group delays tell its speed, and with
/// it which way a harmonic grows, and that its energy does.
#[test]
fn val_theory_group_delays_tell_a_speed_where_arrivals_scatter() {
    let (mut told, sites) = (0, 40);
    for seed in 0..20 {
        let slow = 0.3 + 0.02 * f64::from(seed % 10);
        let toward = if seed % 2 == 0 { 1.0 } else { -1.0 };
        let level = noise(2048, 2 * sites);
        let found = answer_of((2048, sites), 0.0, |n, j| {
            let far = if toward > 0.0 {
                j
            } else {
                sites as f64 - 1.0 - j
            };
            let s = n - 700.0 - slow * far;
            let second = 0.55 * far / (sites as f64 - 1.0);
            let shift = (17 * seed as usize + n as usize) % 2048;
            burst(s, 0.02, 400.0)
                + second * burst(s, 0.04, 400.0)
                + 0.03 * level[[shift, j as usize]]
        });
        let moved = &found.frequency;
        assert!(
            moved.verdict == Verdict::Untold
                || (moved.verdict == Verdict::Up && moved.transfer == Some(true)),
            "{seed}: {moved:?}"
        );
        if let Some(speed) = found.speed {
            told += 1;
            let off = speed.value - toward / slow;
            assert!(off.abs() < 2.0 * speed.error, "{seed}: {speed:?} {off}");
            assert!(speed.error < 0.3 / slow, "{seed}: {speed:?}");
        }
    }
    assert!(told >= 17, "{told}");
}

/// Dead sites, and a gain of 6 for half of the record, spread energy over all wavenumbers: nothing folds, and most of the energy still
/// goes one way. A wave of two sites folds.
#[test]
fn val_theory_gains_do_not_fold() {
    for seed in 1..9 {
        let sites = 24;
        let wave = steady(seed, (2048, sites), 0.05, 1.1);
        let mut dead = wave.clone();
        for site in [6, 13] {
            dead.column_mut(site).fill(0.0);
        }
        let mut changed = wave.clone();
        changed
            .column_mut(3)
            .iter_mut()
            .skip(1024)
            .for_each(|v| *v *= 6.0);
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

/// A burst whose wavelength is three times the array, or a tenth of it: of the first no shares by direction are given.
#[test]
fn val_theory_long_waves_have_no_shares_by_direction() {
    for (slow, is_long) in [(0.15, true), (5.0, false)] {
        let values = noise(2048, 32);
        let values = Array2::from_shape_fn((2048, 32), |(n, j)| {
            burst(n as f64 - 500.0 - slow * j as f64, 0.0625, 300.0) + 1e-3 * values[[n, j]]
        });
        let analysis = analysis_of(values);
        let speed = analysis.answer.as_ref().unwrap().speed.unwrap();
        assert!((speed.value * slow - 1.0).abs() < 0.02, "{speed:?}");
        let is_withheld = matches!(analysis.undirected, Some(Reason::Aperture { folds: false }));
        assert_eq!(is_withheld, is_long, "{:?}", analysis.undirected);
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
            let said = told.find(|warning| warning.code == "gain-steps");
            let said = said.map(|told| {
                let of = |name: &str| -> Vec<f64> {
                    serde_json::from_value(told.numbers[name].clone()).unwrap()
                };
                let sites = of("sites").into_iter().map(|site| site as usize);
                (sites.collect::<Vec<_>>(), of("ratios"), of("ratio_errors"))
            });
            match said {
                None if step == 1.0 => {}
                Some((sites, ratios, errors)) if step > 1.0 && sites.len() == 1 => {
                    all += 1;
                    right += usize::from(sites[0] == at);
                    within += usize::from((ratios[0] - step).abs() < errors[0]);
                    assert!(sites[0].abs_diff(at) <= 2, "{seed}: {sites:?}");
                }
                None => {}
                said => panic!("{seed} {step}: {said:?}"),
            }
        }
    }
    let are_most = |part: usize| 10 * part >= 8 * all;
    assert!(all >= 20, "{all} {right} {within}");
    assert!(are_most(right), "{all} {right} {within}");
    assert!(are_most(within), "{all} {right} {within}");
}

/// A wave eight times as long as an array of 6 sites is no hum, though most of it is common to them; of 4 sites neither is told.
#[test]
fn val_theory_a_long_wave_is_no_hum() {
    for (delay, sites, is_hum) in [(8.3, 6, false), (0.0, 6, true), (0.0, 4, false)] {
        let level = noise(4096, sites);
        let values = Array2::from_shape_fn((4096, sites), |(n, j)| {
            (TAU * 0.0025 * (n as f64 - delay * j as f64)).cos() + 0.02 * level[[n, j]]
        });
        let analysis = analysis_of(values);
        let is_line = |of: &Warning| of.code == "common-mode" && of.numbers["line"].is_number();
        let warnings = &analysis.warnings;
        assert_eq!(
            warnings.iter().any(is_line),
            is_hum,
            "{delay}: {warnings:?}"
        );
    }
}

/// Hum at a harmonic, common to all sites, under a burst that keeps its content while it fades: what the hum does to a group of sites
/// is one noise, not the mean of many. Of many phases few are said to move.
#[test]
fn val_theory_hum_under_a_burst_moves_nothing() {
    let level = noise(1277, 41);
    let moves = |phase: f64| {
        let found = answer_of((1277, 41), 0.0, |n, j| {
            let fades = (-2.2 * j / 40.0).exp();
            let hum = 0.03 * (TAU * 0.0918 * n + phase).cos();
            let wave = fades * burst(n - 470.0 - j / 2.98, 0.0306, 160.0);
            wave + hum + 1e-4 * level[[n as usize, j as usize]]
        });
        found.frequency.moves()
    };
    let many = (0..24).filter(|i| moves(0.26 * f64::from(*i))).count();
    assert!(many <= 3, "{many}");
}

/// A chirp whose wavelength grows past the array leaves the wavenumbers that it resolves: its energy is not lost.
#[test]
fn val_theory_what_becomes_longer_than_the_array_is_not_lost() {
    let found = answer_of((1000, 30), 0.0, |n, j| {
        let s = n - j / 1.65;
        (TAU * (0.164 * s - 0.5 * 0.114 / 1000.0 * s * s)).cos()
    });
    let moved = &found.wavenumber;
    assert_ne!(moved.transfer, Some(false), "{moved:?}");
}
