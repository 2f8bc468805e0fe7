//! Spectra with intervals against nitime, multitaper and SciPy, and against noise whose spectrum is known.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use ndarray::{Array2, s};
use test_support::estimate::spectrum;
use test_support::fields::{Congruential as Noise, passing, red};
use test_support::{lies, near, share, worst};
use wavecascade::Field;
use wavecascade::analyze::Request;
use wavecascade::estimates::{LeftOutEach, SpectrumEstimate};
use wavecascade::sheet::Describe;

use crate::peers::{DT, compare, field, record};

fn found(words: &str, values: Array2<f64>) -> SpectrumEstimate {
    spectrum(words, [&field(values)]).unwrap()
}

#[test]
fn val_nitime_and_multitaper_weights_intervals_and_lines() {
    compare("nitime and multitaper");
    // The line, and nothing else.
    let found = spectrum("tapers=4:7", [&record("noises 400 3")]).unwrap();
    let test = found.line_test.unwrap();
    assert_eq!(test.lines.len(), 1);
    let line = &test.lines[0];
    assert_eq!((line.column, line.at), (2, 49.0 / 400.0 / DT));
    near(line.amplitude, 0.7, 2.5 * line.amplitude_error);
    lies(line.amplitude_error, 0.0..0.1);
}

#[test]
fn val_scipy_welch_and_periodogram() {
    compare("scipy spectra");
    // Two degrees of freedom of a periodogram; of Welch's method, twice the effective number of segments.
    let [one, several] = ["window=none whole", "segment=64 overlap=32"].map(|words| {
        let found = spectrum(words, [&record("noises 400 3")]).unwrap();
        let [least, _, most] = found.degrees_range().unwrap();
        near(least, most, 1e-9 * most);
        (most, found)
    });
    near(one.0, 2.0, 1e-12);
    let effective = several.1.independence.effective;
    near(several.0 / (2.0 * effective), 1.0, 1e-12);
    lies(effective, 9.0..11.0);
    // The mean is removed: nothing is estimated at 0. At the Nyquist frequency, half of it.
    assert!(several.1.degrees[[0, 0]].is_nan() && several.1.low[[0, 0]].is_nan());
    near(several.1.degrees[[32, 0]] / effective, 1.0, 1e-12);
}

/// Share of the cells in which the true density is inside of the interval, by the chi-square distribution and by the jackknife.
pub fn coverage(
    found: &SpectrumEstimate,
    bins: Range<usize>,
    truth: impl Fn(f64) -> f64,
) -> [f64; 2] {
    let cells = found.spectrum.indexed_iter();
    let cells = cells.filter(|((m, _), _)| bins.contains(m));
    let held = cells.map(|(cell, s)| {
        let truth = truth(found.bins[cell.0]);
        let is_inside = found.low[cell] < truth && truth < found.high[cell];
        [is_inside, (s / truth).ln().abs() < found.jackknife[cell]]
    });
    [0, 1].map(|i| share(held.clone().map(|held| held[i])))
}

/// Noise with a spectrum over three decades, an average of neighbours apart.
#[test]
fn val_intervals_of_noise_hold_as_often_as_they_say() {
    let values = red(Noise(9).white(2148, 40), 0.9);
    let field = field(values.slice(s![100.., ..]).to_owned());
    let truth = |f: f64| 2.0 * DT / (1.81 - 1.8 * (TAU * f * DT).cos());
    for (words, apart, expected) in [
        ("tapers=4:7", 8, [0.95, 0.955]),
        ("tapers=4:7 segment=512 overlap=256", 8, [0.95, 0.95]),
        ("segment=256 overlap=128", 3, [0.95, 0.95]),
        ("segment=256 overlap=208", 3, [0.95, 0.95]),
        ("window=none whole", 3, [0.95, 0.0]),
    ] {
        let found = spectrum(words, [&field]).unwrap();
        let shares = coverage(&found, apart..found.bins.len() - apart, truth);
        let off = shares.iter().zip(expected).map(|(a, b)| (a - b).abs());
        assert!(worst(off) < 0.02, "{words}: {shares:?}");
    }
}

/// A mean takes `|W(f)|^2 / (N sum w^2)` of white noise: two thirds of bin 0 under a Hann window, a sixth of bin 1.
#[test]
fn val_closed_form_what_detrending_takes() {
    let found = found("segment=256 overlap=128", Noise(3).white(4096, 40));
    for (bin, lost) in [(0, 2.0 / 3.0), (1, 1.0 / 6.0), (2, 0.0)] {
        near(found.detrended[bin], lost, 2e-3);
        assert_eq!(found.low[[bin, 0]].is_nan(), bin < 2);
    }
    let kept = found.spectrum.row(1).mean().unwrap() / found.spectrum.mean().unwrap();
    near(kept, 5.0 / 6.0, 0.05);
}

/// A resonance with poles at radius r has a half-power width of `(1 - r) / (pi dt)`.
#[test]
fn val_theory_a_hump_is_one_peak() {
    let (mut noise, r, f) = (Noise(8), 0.97, 0.12);
    let [a, b] = [2.0 * r * (TAU * f).cos(), -r * r];
    let mut values = Array2::zeros((8192, 4));
    for mut record in values.columns_mut() {
        let mut last = [0.0; 2];
        for v in &mut record {
            *v = a * last[0] + b * last[1] + noise.normal();
            last = [*v, last[0]];
        }
    }
    let found = found("segment=1024 overlap=512", values);
    let peaks = found.peaks().unwrap();
    assert_eq!(peaks.len(), 4);
    let answer = found.describe().answer;
    assert!(answer.contains(" (4 of 4 sites)"), "{answer}");
    for peak in peaks {
        near(peak.at, f / DT, 0.02);
        assert!(peak.ratio > 8.0, "{peak:?}");
        near(peak.width / ((1.0 - r) / (PI * DT)), 1.0, 0.4);
    }
}

/// Lines anywhere in a bin are found, with the amplitude that they have.
#[test]
fn val_lines_between_bins() {
    let mut noise = Noise(15);
    let bin_of = |j: usize| 199.5 + 0.125 * j as f64;
    let values = Array2::from_shape_fn((1024, 9), |(n, j)| {
        let angle = TAU * bin_of(j) / 1024.0 * n as f64 + j as f64;
        noise.normal() + angle.cos()
    });
    let found = found("tapers=4:7", values);
    let lines = &found.line_test.as_ref().unwrap().lines;
    // The tenth is one of those that are found by chance, once in twenty fields.
    assert!(lines.len() <= 10, "{lines:?}");
    let mut sites: Vec<usize> = lines.iter().take(9).map(|line| line.column).collect();
    sites.sort_unstable();
    assert_eq!(sites, (0..9).collect::<Vec<_>>());
    for line in &lines[..9] {
        near(line.at / found.bins[1], bin_of(line.column), 0.3);
        near(line.amplitude, 1.0, 4.0 * line.amplitude_error);
    }
}

/// F exceeds its levels as often as they say, of tapers and of tapers in segments.
#[test]
fn val_lines_are_found_by_chance_as_often_as_stated() {
    let field = field(Noise(21).white(2048, 40));
    for words in ["tapers=4:7", "tapers=4:7 segment=512 overlap=256"] {
        let test = spectrum(words, [&field]).unwrap().line_test.unwrap();
        let cells = test.statistic.iter().filter(|f| f.is_finite());
        near(share(cells.map(|f| *f > test.level)), 0.05, 0.012);
        assert!(test.lines.is_empty(), "{:?}", test.lines);
    }
}

/// Shots of one shape whose energies differ: a jackknife of these, at any frequency.
#[test]
fn regress_a_transient_has_intervals_by_its_records_alone() {
    let mut noise = Noise(4);
    let pulse = passing((2048, 3), 300.0, 5.0, 6.0);
    let shots: Vec<Field> = (0..6).map(|_| field(&pulse * noise.normal())).collect();
    // Adaptive weights would differ between shots.
    let words = "tapers=4:7 equal";
    let one = spectrum(words, [&shots[0]]).unwrap();
    assert_eq!(one.without_interval(), 3);
    assert!(one.degrees_range().is_none() && one.line_test.unwrap().lines.is_empty());
    let several = spectrum(words, &shots).unwrap();
    assert_eq!(several.left_out, LeftOutEach::Record);
    assert_eq!(several.degrees_range().unwrap(), [12.0; 3]);
    let energy = |shot| spectrum(words, [shot]).unwrap().spectrum[[40, 1]];
    let energies: Vec<f64> = shots.iter().map(energy).collect();
    let sum: f64 = energies.iter().sum();
    let without: Vec<f64> = energies.iter().map(|e| ((sum - e) / 5.0).ln()).collect();
    let mean = without.iter().sum::<f64>() / 6.0;
    let variance = without.iter().map(|l| (l - mean).powi(2)).sum::<f64>() * 5.0 / 6.0;
    // Student's t of 5 degrees of freedom.
    let expected = 2.570_581_835_636_314 * variance.sqrt();
    near(several.jackknife[[40, 1]] / expected, 1.0, 1e-10);
    near(several.spectrum[[40, 1]] / (sum / 6.0), 1.0, 1e-12);
}

/// Along space, the estimate of the field with exchanged axes; its mean over the times has intervals that hold.
#[test]
fn val_mean_of_correlated_snapshots() {
    // Modes of a ring of sites, each a process of its own with a memory of about ten times.
    let (times, sites) = (4096, 32);
    let mut noise = Noise(77);
    let mut held = Vec::new();
    for _ in 0..6 {
        let values = red(noise.white(times, sites), 0.9);
        let words = "along=space window=none detrend=none whole";
        let found = found(words, values.clone());
        assert_eq!(found.spectrum.dim(), (17, times));
        assert_eq!((found.time.step, found.space.step), (DT, 0.5));
        let dk = found.bins[1];
        near(dk, TAU / 16.0, 1e-15);
        // Parseval: the integral over k is the mean square of each snapshot.
        for n in [0, 1000] {
            let square = values.row(n).dot(&values.row(n)) / sites as f64;
            near(found.spectrum.column(n).sum() * dk / square, 1.0, 1e-13);
        }
        let mean = found.mean.unwrap();
        let truth = 2.0 * 0.5 / 0.19 / TAU;
        for m in 1..16 {
            held.push((mean.low[m]..mean.high[m]).contains(&truth));
            // Of 4096: the powers' correlation is 0.81^l, so (1 + 0.81) / (1 - 0.81) count as one: 430.
            lies(mean.effective_snapshots[m], 100.0..2000.0);
        }
    }
    near(share(held), 0.95, 0.06);
}

/// What `analyze` states of its own spectra.
#[test]
fn val_intervals_of_analyze() {
    let of = |field: &Field| {
        let (analysis, _) = wavecascade::analyze(field, &Request::default()).unwrap();
        analysis.interval.unwrap()
    };
    let interval = of(&record("noises 400 3"));
    near(interval.degrees_of_freedom.unwrap(), 2.0, 1e-13);
    // Of an exponential distribution.
    let [low, high] = interval.factors.unwrap();
    near(low * -0.025_f64.ln(), 1.0, 1e-13);
    near(high * -(-0.025_f64).ln_1p(), 1.0, 1e-13);
    let interval = of(&field(passing((1024, 6), 200.0, 5.0, 6.0)));
    assert!(interval.factors.is_none() && interval.degrees_of_freedom.is_none());
    lies(interval.steadiness, 0.0..0.2);
}
