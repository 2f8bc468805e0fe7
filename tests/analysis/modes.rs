//! Spectral proper orthogonal decompositions against NumPy's singular values and PySPOD, and against fields whose modes are known.

use std::f64::consts::TAU;

use ndarray::{Array2, Axis};
use num_complex::Complex;
use test_support::estimate::{flat, modes};
use test_support::fields::{noise, red};
use test_support::{hold, lies, near, share, worst};
use wavecascade::estimates::Modes;
use wavecascade::transform::fold;

use crate::peers::{DT, DX, compare, data, field, record};

fn found(words: &str, values: Array2<f64>) -> Modes {
    modes(words, [&field(values)]).unwrap()
}

/// Of more sites than realisations, and of fewer.
#[test]
fn val_numpy_svd_of_the_realisations() {
    compare("numpy eigenvalues");
    for (made, sites) in [("wide", 22), ("narrow", 11)] {
        let words = "segment=32 overlap=16 frequencies=0.375,0.5,1.125";
        let found = modes(words, [&record(&format!("waves 272 {sites}"))]).unwrap();
        let ours = found.chosen.iter().flat_map(|shapes| shapes.modes.rows());
        let [re, im] = ["real", "imag"].map(|part| flat(&data("modes.json")[made][part]));
        let theirs = re.chunks(sites).zip(im.chunks(sites));
        let off = ours.zip(theirs).map(|(mode, (re, im))| {
            let theirs = re.iter().zip(im).map(|(re, im)| Complex::new(*re, *im));
            // 1 for the same mode, whatever the phases.
            let pairs = mode.iter().zip(theirs);
            let product: Complex<f64> = pairs.map(|(a, b)| a.conj() * b * DX).sum();
            (product.norm() - 1.0).abs()
        });
        assert_eq!(off.clone().count(), 9);
        lies(worst(off), 0.0..1e-12);
    }
}

/// The eigenvalues of a frequency sum up to the power spectral density of all sites, which is that of
/// the samples: with no taper, to their variance.
#[test]
fn val_parseval_of_all_eigenvalues() {
    let values = noise(960, 21);
    let parts = values.axis_chunks_iter(Axis(0), 64);
    let variance: f64 = parts.map(|part| part.var_axis(Axis(0), 0.0).sum()).sum();
    let found = found("segment=64 overlap=0 window=none", values);
    for (row, total) in found.eigenvalues.outer_iter().zip(&found.total) {
        assert!(row[0] == 0.0 || (row.sum() / total - 1.0).abs() < 3e-15);
    }
    let sum = found.eigenvalues.sum() / (64.0 * DT);
    near(sum / (variance * DX / 15.0), 1.0, 2e-14);
    assert_eq!(fold(0, 64), 1.0);
}

/// Independent sources with known shapes: their eigenvalues lie within the intervals as often as stated.
#[test]
fn val_known_sources_lie_within_the_intervals() {
    let (n, sites) = (8192, 30);
    let source = noise(n, 2);
    // Orthogonal shapes: one half wave and one whole wave over the sites.
    let shape = |k: usize, j: usize| (TAU * k as f64 * (j as f64 + 0.5) / (2 * sites) as f64).sin();
    let values = Array2::from_shape_fn((n, sites), |(t, j)| {
        3.0 * source[[t, 0]] * shape(1, j) + source[[t, 1]] * shape(2, j)
    });
    let found = found("segment=128 overlap=64", values);
    // White noise of variance 1 has the density 2 dt; each shape has the square sum sites / 2.
    let strength = 2.0 * DT * DX * sites as f64 / 2.0;
    let held = (2..63).flat_map(|bin| {
        let [low, high] = found.interval(bin).unwrap();
        lies(found.eigenvalues[[bin, 2]], 0.0..1e-12 * strength);
        let value = found.eigenvalues.row(bin);
        [(0, 9.0), (1, 1.0)].map(|(mode, times)| {
            (value[mode] * low..value[mode] * high).contains(&(times * strength))
        })
    });
    lies(share(held), 0.9..0.99);
}

/// White and red records, one of them loud, of more sites than realisations and of fewer.
#[test]
fn val_unrelated_records_have_no_coherent_motion() {
    let mut said = 0;
    for (sites, length) in [(2, 64), (8, 64), (24, 128), (60, 256)] {
        let white = noise(2048, 20 * sites);
        let fields = white.axis_chunks_iter(Axis(1), sites);
        for (one, memory) in fields.flat_map(|one| [(one, 0.0), (one, 0.9)]) {
            let mut values = one.to_owned();
            values.column_mut(1).mapv_inplace(|v| 5.0 * v);
            let found = found(&format!("segment={length}"), red(values, memory));
            let mut bins = 1..found.frequency.len() - 1;
            said += usize::from(bins.any(|bin| found.above_noise(bin) > Some(0)));
        }
    }
    assert!(said <= 1, "{said} of 160");
}

/// A wave that decays, identical records, two motions, and a wave past a loud site that has nothing to do with it.
#[test]
fn val_motions_are_counted_and_not_realisations() {
    let source = noise(4200, 3);
    let wave = |t: usize, j: usize| source[[t + 100 - 6 * j, 0]];
    for (case, expected) in [1, 1, 2, 1].into_iter().enumerate() {
        let values = Array2::from_shape_fn((4096, 12), |(t, j)| match (case, j) {
            (0, _) => wave(t, j) * (-0.3 * j as f64).exp(),
            (1, _) => source[[t, 0]],
            (2, _) => source[[t, 0]] + source[[t, 1]] * [1.0, -1.0][j % 2],
            (_, 3) => 20.0 * source[[t, 2]],
            _ => wave(t, j),
        });
        let found = found("segment=256", values);
        let mut counted = (3..100).map(|bin| found.above_noise(bin));
        assert!(counted.all(|count| count == Some(expected)), "{case}");
        let coherent = &found.chosen[0].is_coherent;
        let first = usize::from(case == 3);
        assert_eq!(coherent.iter().position(|is| *is), Some(first), "{case}");
        assert!(case != 1 || (found.coherencies[[5, 0]] - 12.0).abs() < 1e-12);
    }
}

/// Tones anywhere between bins, in noise as loud as they are. Standing ones are no waves.
#[test]
fn val_velocities_lie_within_their_intervals() {
    let noise = noise(2048, 1200);
    hold(100, 92..=98, |k| {
        let k = *k as usize;
        let velocity = [3.0, -4.0][k % 2];
        let omega = TAU * (0.5 + 3e-4 * k as f64);
        let first = |back: f64| {
            let values = Array2::from_shape_fn((2048, 12), |(n, j)| {
                let (x, t) = (DX * j as f64 / velocity, DT * n as f64);
                let both = (omega * (x - t)).cos() + back * (omega * (x + t)).cos();
                2.0f64.sqrt() * both + noise[[n, 12 * k + j]]
            });
            found("segment=128", values).chosen[0].waves[0].unwrap()
        };
        let (wave, standing) = (first(0.0), first(1.0));
        assert!(wave.is_wave && !standing.is_wave, "{wave:?} {standing:?}");
        lies(standing.share, 0.5..0.8);
        let half = wave.velocity_half.unwrap();
        lies(half, 0.0..0.05 * velocity.abs());
        (wave.velocity - velocity).abs() < half
    });
}
