//! What moved: what cannot be told, and what must not be said for want of energy, of length or of a quiet background.

use std::f64::consts::TAU;

use ndarray::Array2;
use wavecascade::moved::{Reason, Verdict};

use crate::moved_kinds::{analysis_of, answer_of, answers_of_scene, burst, ricker};
use test_support::fields::noise;

/// A wave below the cut-off decays, a faint one above it passes: the share above grows to all there is, and no energy is gained there.
#[test]
fn val_construction_a_wave_that_decays_leaves_what_passes() {
    let noise = noise(4096, 64);
    for faint in [0.004, 0.008, 0.01] {
        let scan = |(n, j): (usize, usize)| {
            let (t, x) = (n as f64, j as f64);
            let slow = (-0.32 * x).exp() * burst(t - 600.0, 0.006, 1000.0);
            slow + faint * burst(t - 620.0 - 6.0 * x, 0.012, 700.0) + 2e-3 * noise[[n, j]]
        };
        let analysis = analysis_of(Array2::from_shape_fn((4096, 64), scan));
        let moved = &analysis.answer.as_ref().unwrap().frequency;
        let words = analysis.words().answer;
        assert_ne!(moved.transfer, Some(true), "{faint}: {moved:?}");
        assert!(moved.up.share <= 1.0, "{faint}: {moved:?}");
        assert!(!words.starts_with("energy moves"), "{faint}: {words}");
    }
}

/// Near an end that is all but fixed what comes and what comes back cancel, low frequencies most: the sites there are left out.
#[test]
fn val_construction_a_fixed_end_moves_nothing() {
    for part in [-0.85f64, -0.9, -0.95] {
        let found = answer_of((4096, 64), 2e-3, |n, j| {
            let passed = |i: i32| match i % 2 {
                0 => f64::from(i) * 63.0 + j,
                _ => f64::from(i + 1) * 63.0 - j,
            };
            let pulse = |i: i32| part.powi(i) * ricker(n - 500.0 - 4.17 * passed(i), 30.0);
            (0..30).map(pulse).sum()
        });
        let moved = &found.frequency;
        assert!(!moved.moves(), "{part}: {moved:?}");
    }
}

/// What is said of the front in a short chain is what is said of it in a long one, or nothing: its launch is no move.
#[test]
fn val_identity_short_chains_say_what_long_ones_do() {
    for ratio in [1.0, 2.398, 4.9272, 8.04, 14.622, 100.0] {
        let of = |sites: usize| {
            let text = format!(
                "sites = {sites}\nstiffness_ratio = {ratio}\nend_time = {}\nsamples = 1024\ntolerance = 1e-7",
                sites + 6
            );
            let [_, known] = answers_of_scene(&text);
            known.frequency
        };
        let long = of(100).verdict;
        let shows = ratio != 2.398;
        assert_eq!(long == Verdict::Unchanged, shows, "{ratio}: {long:?}");
        for sites in [8, 10, 12, 16, 20, 24, 26, 30, 36, 40, 60, 80] {
            let short = of(sites);
            let is_same = short.verdict == Verdict::Untold || short.verdict == long;
            assert!(is_same, "{ratio}, {sites}: {short:?} {long:?}");
        }
    }
}

/// Hum at all sites hides a burst whose harmonic grows: a warning names it.
#[test]
fn val_construction_hum_is_named() {
    let noise = noise(4096, 56);
    let scan = |(n, j): (usize, usize)| {
        let (s, second) = (
            n as f64 - 900.0 - 2.6 * j as f64,
            0.2f64.sqrt() * j as f64 / 55.0,
        );
        let wave = burst(s, 0.032, 300.0) + second * burst(s, 0.064, 300.0);
        wave + (TAU * 1e-3 * n as f64).cos() + 5e-3 * noise[[n, j]]
    };
    let analysis = analysis_of(Array2::from_shape_fn((4096, 56), scan));
    let sheet = analysis.words();
    let mut warnings = sheet.warnings.iter();
    let hum = warnings.find(|warning| warning.code == "common-mode");
    let hum = hum.expect("hum");
    assert!(hum.advice.contains("--detrend-space mean"), "{hum:?}");
    assert!(hum.numbers["line"].is_number(), "{hum:?}");
    let verdict = &sheet.numbers["moved"]["frequency"]["verdict"];
    assert!(verdict == "unchanged" || verdict == "untold", "{verdict}");
}

/// A wave towards +x in noise of three quarters of the energy and more: noise goes both ways, and counts for neither.
#[test]
fn val_construction_noise_has_no_direction() {
    let noise = noise(4096, 56);
    for level in [0.05, 0.1, 0.2] {
        let scan = |(n, j): (usize, usize)| {
            burst(n as f64 - 900.0 - 2.6 * j as f64, 0.032, 300.0) + level * noise[[n, j]]
        };
        let analysis = analysis_of(Array2::from_shape_fn((4096, 56), scan));
        let all = analysis.direction.unwrap();
        let waves = analysis.direction_of_waves().unwrap();
        assert!(all.toward_minus_x > 0.04, "{level}: {all:?}");
        assert!(waves.toward_plus_x > 0.95, "{level}: {waves:?}");
        assert!(waves.toward_minus_x < 0.03, "{level}: {waves:?}");
    }
}

/// Bursts of five times the noise come and go, but no sample of theirs is eight times as large: noise is why, not a late start of
/// the record.
#[test]
fn val_construction_noise_hides_when_it_arrives() {
    let found = answer_of((4096, 40), 0.2, |n, j| {
        let s = n - 900.0 - 9.0 * j;
        let is_inside = (0.0..300.0).contains(&s);
        if is_inside { (0.6 * s).sin() } else { 0.0 }
    });
    let moved = found.frequency;
    let hides = matches!(moved.reason, Some(Reason::Noise { .. }));
    assert!(hides, "{moved:?}");
}

/// A pulse that disperses, `w = c k (1 - 0.054 k^2)`, whose high frequencies come after the record's end at most sites: they lag, and are not lost.
#[test]
fn val_construction_what_comes_after_the_record_is_not_lost() {
    for (c, beta, carrier, width) in [
        (0.234, 0.054, 0.8, 0.6),
        (0.237, 0.034, 0.8, 0.53),
        (0.156, 0.021, 0.8, 0.59),
    ] {
        let sites = 300;
        let waves: Vec<(f64, f64, f64)> = (1..560)
            .map(|i| {
                let k = 0.005 * f64::from(i);
                let a = (-0.5 * ((k - carrier) / width).powi(2)).exp();
                (a, k, c * k * (1.0 - beta * k * k))
            })
            .collect();
        let all: f64 = waves.iter().map(|(a, ..)| a).sum();
        let found = answer_of((1024, sites), 1e-4, |n, j| {
            let wave = |(a, k, w): &(f64, f64, f64)| a * (k * (j - 35.0) - w * n).cos();
            waves.iter().map(wave).sum::<f64>() / all
        });
        let moved = &found.frequency;
        assert_eq!(moved.transfer, None, "{c}: {moved:?}");
        assert!(moved.lags || !moved.moves(), "{c}: {moved:?}");
    }
}

/// Pulses of constant shape that are as long as a tenth of the record, and inside when it ends: windows cut them alike.
#[test]
fn val_construction_a_pulse_that_windows_cut_is_unchanged() {
    for (speed, half, is_ricker) in [(0.032, 4.9, false), (0.032, 4.6, false), (0.033, 4.3, true)] {
        let found = answer_of((2000, 120), 1e-3, |n, j| {
            let s = j - 30.0 - speed * n;
            match is_ricker {
                true => ricker(s, half),
                false => (-0.5 * (s / half).powi(2)).exp(),
            }
        });
        let moved = &found.frequency;
        assert_eq!(
            moved.verdict,
            Verdict::Unchanged,
            "{speed} {half}: {moved:?}"
        );
        assert!(moved.bound < 0.1, "{speed} {half}: {moved:?}");
    }
}

/// Waves of random phases around 0.04 and 0.12 cycles a sample, of which those above fade along x: steady records differ by chance, and none is gained.
#[test]
fn val_construction_steady_absorption_gains_nothing() {
    let chance = noise(40, 24);
    let mut told = 0;
    for seed in 0..6 {
        let waves = |f: f64, column: usize| -> Vec<(f64, f64)> {
            let of = |i: usize| (chance[[i, column]], 20.0 * chance[[i, column + 1]]);
            (0..40)
                .map(of)
                .map(|(off, phase)| (f * (1.0 + 0.1 * off), phase))
                .collect()
        };
        let (low, high) = (waves(0.04, 4 * seed), waves(0.12, 4 * seed + 2));
        let sum = |waves: &[(f64, f64)], s: f64| -> f64 {
            waves
                .iter()
                .map(|(f, phase)| (TAU * f * s + phase).cos())
                .sum()
        };
        let found = answer_of((2048, 60), 0.0, |n, j| {
            let s = n - 0.8 * j;
            sum(&low, s) + 0.8 * (-2.0 * j / 59.0).exp() * sum(&high, s)
        });
        let moved = &found.frequency;
        assert_ne!(moved.transfer, Some(true), "{seed}: {moved:?}");
        told += usize::from(moved.verdict == Verdict::Down);
    }
    assert!(told >= 2, "{told}");
}
