//! `S(k, f)` with intervals against NumPy and SciPy, noise whose spectrum is known, and waves.

use std::f64::consts::TAU;

use ndarray::{Array2, s};
use test_support::estimate::spacetime;
use test_support::fields::Congruential as Noise;
use test_support::{near, share};
use wavecascade::estimates::SpaceTimeEstimate;

use crate::peers::{DT, DX, compare, field, record};

fn found(words: &str, values: Array2<f64>) -> SpaceTimeEstimate {
    spacetime(words, [&field(values)]).unwrap()
}

#[test]
fn val_numpy_and_scipy_spectra() {
    compare("numpy and scipy S(k, f)");
}

/// Waves that are 1e6 times as strong as the noise leak through equal weights over the whole plane; SciPy's
/// sequences and a fixed-point iteration in NumPy give the adaptive average and its degrees of freedom.
#[test]
fn val_adaptive_weights_by_numpy() {
    compare("numpy adaptive S(k, f)");
    let words = "tapers=2.5:4 space-tapers=2:3 detrend=none";
    let of = |words: &str| spacetime(words, [&record("steep 45 9")]).unwrap();
    let (one, equal) = (of(words), of(&format!("{words} equal")));
    let [least, _, most] = one.degrees_range().unwrap();
    assert!(least < 5.0 && most > 20.0 && most <= 24.0, "{least} {most}");
    let lowest = |found: &SpaceTimeEstimate| found.spectrum.fold(f64::INFINITY, |m, v| m.min(*v));
    let leaked = lowest(&equal) / lowest(&one);
    assert!(leaked > 2.0, "{leaked}");
}

/// White noise lies in the intervals as often as they say; its density is `2 variance dt dx / (2 pi)`.
#[test]
fn val_intervals_of_white_noise_hold() {
    let mut noise = Noise(23);
    let adaptive = "tapers=3:5 space-tapers=2:3 detrend=none";
    let equal = "tapers=3:5 space-tapers=2:3 detrend=none equal";
    for (times, sites, words, expected) in [
        (4096, 24, "segment=64 overlap=32", 2.0 * 120.4),
        (256, 40, equal, 2.0 * 15.0),
        (256, 40, adaptive, 2.0 * 14.9),
    ] {
        let truth = 2.0 * DT * DX / TAU;
        let held = (0..2).flat_map(|_| {
            let found = found(words, noise.white(times, sites));
            let [_, degrees, _] = found.degrees_range().unwrap();
            near(degrees / expected, 1.0, 0.07);
            let [low, high] =
                [&found.low, &found.high].map(|ends| ends.slice(s![4..ends.nrows() - 4, ..]));
            let is_inside = |(low, high): (&f64, &f64)| *low < truth && truth < *high;
            low.iter().zip(high).map(is_inside).collect::<Vec<_>>()
        });
        near(share(held), 0.95, 0.015);
    }
}

/// A wave travels towards +x at positive k; its power is that of the samples.
#[test]
fn val_plane_waves_at_their_wavenumber_and_frequency() {
    let (bin, wave) = (11, 3);
    let frequency = f64::from(bin) / (64.0 * DT);
    for (sign, shares) in [(1.0, [1.0, 0.0, 0.0]), (-1.0, [0.0, 1.0, 0.0])] {
        let k = sign * TAU * f64::from(wave) / (20.0 * DX);
        let values = Array2::from_shape_fn((1000, 20), |(n, j)| {
            3.0 * (k * j as f64 * DX - TAU * frequency * n as f64 * DT).cos()
        });
        for words in [
            "segment=64 overlap=32",
            "segment=64 overlap=0 window=none space-window=none",
        ] {
            let found = found(words, values.clone());
            let (row, column) = found.largest();
            near(found.frequency[row], frequency, 1e-12);
            near(found.wavenumber[column], k, 1e-12);
            for (share, expected) in found.directions().into_iter().zip(shares) {
                near(share, expected, 1e-9);
            }
            near(found.power / 4.5, 1.0, 1e-12);
            near(found.mean_square / 4.5, 1.0, 1e-12);
        }
    }
}
