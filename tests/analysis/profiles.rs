//! What moved where the first and the last sites alone would say another thing.

use std::f64::consts::{PI, TAU};

use ndarray::{Array2, s};
use wavecascade::moved::{Fate, Movement, Verdict};

use crate::moved_kinds::analysis_of;
use test_support::fields::noise;

const SEEDS: usize = 3;
const SITES: usize = 52;

/// A burst of this width at the frequency f.
fn wave(s: f64, f: f64, width: f64) -> f64 {
    (-0.5 * (s / width).powi(2)).exp() * (TAU * f * s).cos()
}

/// Of `of(n, j)`, in noise of this level whose samples follow one another by `colour`.
fn moved(
    times: usize,
    seed: usize,
    [level, colour]: [f64; 2],
    of: impl Fn(f64, f64) -> f64,
) -> Movement {
    let columns = seed * SITES..(seed + 1) * SITES;
    let mut values = noise(times, SEEDS * SITES).slice_move(s![.., columns]);
    for n in 1..times {
        for j in 0..SITES {
            values[[n, j]] += colour * values[[n - 1, j]];
        }
    }
    let level = level * (1.0 - colour * colour).sqrt();
    let value = |(n, j): (usize, usize)| of(n as f64, j as f64) + level * values[[n, j]];
    let values = Array2::from_shape_fn((times, SITES), value);
    analysis_of(values).answer.unwrap().frequency
}

/// A burst that arrives late by 1 / 0.42 samples a site, and its second harmonic.
fn pair(n: f64, j: f64, [first, second]: [f64; 2]) -> f64 {
    let s = n - 300.0 - j / 0.42;
    first * wave(s, 0.058, 28.0) + second * wave(s, 0.116, 28.0)
}

/// A harmonic out of step takes `sin^2 0.7` of the energy by the middle, and gives it back.
#[test]
fn val_construction_a_beat_is_up_and_back() {
    for seed in 0..SEEDS {
        let moved = moved(1200, seed, [0.005, 0.0], |n, j| {
            let part = 0.7 * (PI * j / SITES as f64).sin();
            pair(n, j, [part.cos(), part.sin()])
        });
        assert_eq!(moved.verdict, Verdict::Up, "{seed}: {moved:?}");
        assert!((moved.up.share - 0.407).abs() < 0.02, "{seed}: {moved:?}");
        assert!(
            moved.to.unwrap().rows[0].abs_diff(24) <= 4,
            "{seed}: {moved:?}"
        );
        assert_eq!(moved.fate, Some(Fate::Back), "{seed}: {moved:?}");
        assert_eq!(moved.transfer, Some(true), "{seed}: {moved:?}");
    }
}

/// A harmonic rises over 16 sites to `sin^2 0.85` of the energy, and is absorbed from there on.
#[test]
fn val_construction_what_rises_and_is_absorbed_is_lost() {
    for seed in 0..SEEDS {
        let moved = moved(1200, seed, [0.005, 0.0], |n, j| {
            let part = 0.85 * (j / 16.0).min(1.0);
            let kept = (-(j - 16.0).max(0.0) / 5.0).exp();
            pair(n, j, [part.cos(), part.sin() * kept])
        });
        assert_eq!(moved.verdict, Verdict::Up, "{seed}: {moved:?}");
        assert_eq!(moved.fate, Some(Fate::Lost), "{seed}: {moved:?}");
        assert_eq!(moved.transfer, Some(true), "{seed}: {moved:?}");
    }
}

/// Of a fundamental that is lost beside a constant harmonic the share above grows; gains of 20 % from site to site are no energy gained.
#[test]
fn val_construction_gains_are_no_transfer() {
    let gains = noise(1, SEEDS * SITES);
    for seed in 0..SEEDS {
        let moved = moved(1200, seed, [0.005, 0.0], |n, j| {
            let gain = 1.0 + 0.2 * gains[[0, seed * SITES + j as usize]];
            gain * pair(n, j, [(-1.2 * j / SITES as f64).exp(), 0.4])
        });
        assert_ne!(moved.transfer, Some(true), "{seed}: {moved:?}");
    }
}

/// What noise of slow frequencies is above late along the array, where a wave has decayed, is no move.
#[test]
fn val_construction_an_even_decay_moves_nothing() {
    for seed in 0..SEEDS {
        let moved = moved(1200, seed, [0.04, 0.8], |n, j| {
            pair(n, j, [(-1.4 * j / SITES as f64).exp(), 0.0])
        });
        assert!(!moved.moves(), "{seed}: {moved:?}");
    }
}

/// Two waves of different speeds, of which the slow one is wholly recorded behind the fast one: neither a transfer nor a loss.
#[test]
fn val_construction_a_slow_wave_falls_behind_a_fast_one() {
    for seed in 0..SEEDS {
        let moved = moved(3600, seed, [0.004, 0.0], |n, j| {
            let late = n - 200.0;
            wave(late - 5.0 * j, 0.095, 9.0) + 1.2 * wave(late - 10.0 * j, 0.04, 13.0)
        });
        assert!(moved.lags || !moved.moves(), "{seed}: {moved:?}");
        assert_eq!(moved.transfer, None, "{seed}: {moved:?}");
    }
}
