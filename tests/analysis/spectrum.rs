//! Spectra with intervals against nitime, multitaper and SciPy (`data/spectrum.json`, made by
//! `data/make_spectrum.py`), and against noise whose spectrum is known.

use ndarray::Array2;
use serde::Deserialize;
use test_support::fields::Congruential as Noise;
use wavecascade::Field;
use wavecascade::estimates::{
    Averaging, LeftOutEach, SpectrumAxis, SpectrumEstimate, SpectrumRequest, Tapers, spectrum,
};
use wavecascade::observer::Silent;
use wavecascade::prepare::{Detrend, Window};
use wavecascade::sheet::Describe;

const DT: f64 = 0.25;

fn field(values: Array2<f64>) -> Field {
    let mut field = Field::from_array(values);
    field.time.step = DT;
    field
}

fn tapers(segment: Option<usize>, overlap: Option<usize>) -> SpectrumRequest {
    SpectrumRequest {
        averaging: Averaging {
            segment,
            overlap,
            tapers: Tapers::Slepian { nw: 4.0, count: 7 },
            ..Averaging::default()
        },
        ..SpectrumRequest::default()
    }
}

fn welch(length: usize, overlap: usize) -> SpectrumRequest {
    SpectrumRequest {
        averaging: Averaging {
            segment: Some(length),
            overlap: Some(overlap),
            ..Averaging::default()
        },
        ..SpectrumRequest::default()
    }
}

fn periodogram() -> SpectrumRequest {
    SpectrumRequest {
        averaging: Averaging {
            tapers: Tapers::Window(Window::None),
            ..Averaging::default()
        },
        is_whole: true,
        ..SpectrumRequest::default()
    }
}

fn found(field: &Field, request: &SpectrumRequest) -> SpectrumEstimate {
    spectrum(&[field], request, &Silent).unwrap()
}

/// The records of `make_spectrum.py`.
fn records() -> Array2<f64> {
    let noise = |seed: u64, count: usize| -> Vec<f64> {
        let mut noise = Noise(seed);
        (0..count).map(|_| noise.uniform()).collect()
    };
    let (white, driven, beside) = (noise(1, 400), noise(2, 600), noise(3, 400));
    let mut steep = vec![0.0; 600];
    for n in 0..600 {
        let before = |back: usize| if n >= back { steep[n - back] } else { 0.0 };
        steep[n] = driven[n] + 2.7607 * before(1) - 3.8106 * before(2) + 2.6535 * before(3)
            - 0.9238 * before(4);
    }
    Array2::from_shape_fn((400, 3), |(n, j)| match j {
        0 => white[n],
        1 => steep[200 + n],
        _ => {
            let angle = std::f64::consts::TAU * 0.1225 * n as f64 + 0.3;
            beside[n] + 0.7 * angle.cos()
        }
    })
}

#[derive(Deserialize)]
struct Multitaper {
    spectrum: Vec<f64>,
    nitime: Vec<Option<f64>>,
    degrees: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    jackknife: Vec<f64>,
    nitime_jackknife: Vec<f64>,
    f: Vec<f64>,
}

#[derive(Deserialize)]
struct Reference {
    multitaper: [Multitaper; 3],
    welch: [Vec<f64>; 3],
    periodogram: [Vec<f64>; 3],
}

fn reference() -> Reference {
    serde_json::from_str(include_str!("../data/spectrum.json")).unwrap()
}

/// The largest relative difference away from 0 and from the Nyquist frequency.
fn difference(found: &Array2<f64>, site: usize, expected: &[f64]) -> f64 {
    let inside = 1..expected.len() - 1;
    let one = |m: usize| (found[[m, site]] / expected[m] - 1.0).abs();
    inside.map(one).fold(0.0, f64::max)
}

#[test]
fn val_nitime_and_multitaper_weights_intervals_and_lines() {
    let field = field(records());
    let found = found(&field, &tapers(None, None));
    for (j, expected) in reference().multitaper.iter().enumerate() {
        let largest = expected.spectrum.iter().copied().fold(0.0, f64::max);
        for (m, theirs) in expected.nitime.iter().enumerate() {
            let Some(theirs) = theirs else { continue };
            let error = (found.spectrum[[m, j]] / theirs - 1.0).abs();
            assert!(error < 2e-10, "nitime {j} {m}: {error:e}");
        }
        assert!(found.spectrum[[0, j]] < largest);
        let test = &found.line_test.as_ref().unwrap().statistic;
        for (what, array, expected, bound) in [
            ("spectrum", &found.spectrum, &expected.spectrum, 2e-10),
            ("degrees", &found.degrees, &expected.degrees, 1e-10),
            ("low", &found.low, &expected.low, 3e-10),
            ("high", &found.high, &expected.high, 3e-10),
            ("jackknife", &found.jackknife, &expected.jackknife, 1e-9),
            ("F", test, &expected.f, 1e-11),
        ] {
            let error = difference(array, j, expected);
            assert!(error < bound, "{j} {what}: {error:e}");
        }
        // Theirs estimates the variance of the samples anew without each taper.
        let ratios = 1..expected.jackknife.len() - 1;
        let mut ratios: Vec<f64> = ratios
            .map(|m| (found.jackknife[[m, j]] / expected.nitime_jackknife[m] - 1.0).abs())
            .filter(|ratio| !ratio.is_nan())
            .collect();
        ratios.sort_by(f64::total_cmp);
        let (median, most) = (ratios[ratios.len() / 2], ratios[ratios.len() - 1]);
        assert!(median < 0.005 && most < 0.1, "{j}: {median} {most}");
    }
    // The line, and nothing else.
    let test = found.line_test.as_ref().unwrap();
    assert_eq!(test.lines.len(), 1);
    let line = &test.lines[0];
    assert_eq!((line.column, line.at), (2, 49.0 / 400.0 / DT));
    let deviation = (line.amplitude - 0.7) / line.amplitude_error;
    assert!(
        deviation.abs() < 2.5 && line.amplitude_error < 0.1,
        "{line:?}"
    );
}

#[test]
fn val_scipy_welch_and_periodogram() {
    let (field, reference) = (field(records()), reference());
    for (request, expected) in [
        (welch(64, 32), &reference.welch),
        (periodogram(), &reference.periodogram),
    ] {
        let found = found(&field, &request);
        for (j, expected) in expected.iter().enumerate() {
            let largest = expected.iter().copied().fold(0.0, f64::max);
            for (m, s) in expected.iter().enumerate() {
                let error = (found.spectrum[[m, j]] - s).abs() / largest;
                assert!(error < 1e-13, "{j} {m}: {error:e}");
            }
        }
    }
    // Two degrees of freedom of a periodogram; of Welch's method, twice the effective number of segments.
    let one = found_degrees(&found(&field, &periodogram()));
    assert!((one - 2.0).abs() < 1e-12, "{one}");
    let several = found(&field, &welch(64, 32));
    let effective = several.independence.effective;
    assert!((found_degrees(&several) / (2.0 * effective) - 1.0).abs() < 1e-12);
    assert!((9.0..11.0).contains(&effective), "{effective}");
    // The mean is removed: nothing is estimated at 0. At the Nyquist frequency, half of it.
    assert!(several.degrees[[0, 0]].is_nan() && several.low[[0, 0]].is_nan());
    assert!((several.degrees[[32, 0]] / effective - 1.0).abs() < 1e-12);
}

fn found_degrees(found: &SpectrumEstimate) -> f64 {
    let [least, _, most] = found.degrees_range().unwrap();
    assert!(most - least < 1e-9 * most);
    most
}

/// Share of the cells away from both ends in which the true density is inside of the interval, by the
/// chi-square distribution and by the jackknife.
fn coverage(found: &SpectrumEstimate, truth: impl Fn(f64) -> f64, from: usize) -> [f64; 2] {
    let (rows, columns) = found.spectrum.dim();
    let (mut inside, mut by_jackknife, mut all) = (0, 0, 0);
    for m in from..rows - from {
        for j in 0..columns {
            let cell = [m, j];
            let truth = truth(found.bins[m]);
            inside += usize::from(found.low[cell] < truth && truth < found.high[cell]);
            let deviation = (found.spectrum[cell] / truth).ln().abs();
            by_jackknife += usize::from(deviation < found.jackknife[cell]);
            all += 1;
        }
    }
    [inside, by_jackknife].map(|count| f64::from(count as u32) / f64::from(all as u32))
}

/// Noise with a spectrum over three decades, an average of neighbours apart.
#[test]
fn val_intervals_of_noise_hold_as_often_as_they_say() {
    let mut noise = Noise(9);
    let (times, sites) = (2048, 40);
    let mut values = Array2::zeros((times, sites));
    for j in 0..sites {
        let mut state = 0.0;
        for n in 0..times + 100 {
            state = 0.9 * state + noise.gaussian();
            if n >= 100 {
                values[[n - 100, j]] = state;
            }
        }
    }
    let truth = |f: f64| {
        let angle = std::f64::consts::TAU * f * DT;
        let gain = 1.0 - 1.8 * angle.cos() + 0.81;
        2.0 * DT * 4.0 / gain
    };
    let field = field(values);
    for (name, request, from, expected) in [
        ("multitaper", tapers(None, None), 8, [0.95, 0.955]),
        (
            "multitaper of segments",
            tapers(Some(512), Some(256)),
            8,
            [0.95, 0.95],
        ),
        ("Welch", welch(256, 128), 3, [0.95, 0.95]),
        ("Welch, much overlap", welch(256, 208), 3, [0.95, 0.95]),
        ("periodogram", periodogram(), 3, [0.95, 0.0]),
    ] {
        let found = found(&field, &request);
        let shares = coverage(&found, truth, from);
        for (share, expected) in shares.into_iter().zip(expected) {
            assert!((share - expected).abs() < 0.02, "{name}: {shares:?}");
        }
    }
}

/// A mean takes `|W(f)|^2 / (N sum w^2)` of white noise: two thirds of bin 0 under a Hann window, a sixth of bin 1.
#[test]
fn val_closed_form_what_detrending_takes() {
    let mut noise = Noise(3);
    let field = field(Array2::from_shape_fn((4096, 40), |_| noise.gaussian()));
    let found = found(&field, &welch(256, 128));
    for (bin, lost) in [(0, 2.0 / 3.0), (1, 1.0 / 6.0), (2, 0.0)] {
        assert!((found.detrended[bin] - lost).abs() < 2e-3, "{bin}");
        assert_eq!(found.low[[bin, 0]].is_nan(), bin < 2);
    }
    let kept = found.spectrum.row(1).mean().unwrap() / found.spectrum.mean().unwrap();
    assert!((kept - 5.0 / 6.0).abs() < 0.05, "{kept}");
}

/// A resonance with poles at radius r has a half-power width of `(1 - r) / (pi dt)`.
#[test]
fn val_theory_a_hump_is_one_peak() {
    let (mut noise, r, f) = (Noise(8), 0.97, 0.12);
    let [a, b] = [2.0 * r * (std::f64::consts::TAU * f).cos(), -r * r];
    let mut values = Array2::zeros((8192, 4));
    for mut record in values.columns_mut() {
        let mut last = [0.0; 2];
        for v in &mut record {
            *v = a * last[0] + b * last[1] + noise.gaussian();
            last = [*v, last[0]];
        }
    }
    let found = found(&field(values), &welch(1024, 512));
    let peaks = found.peaks().unwrap();
    assert_eq!(peaks.len(), 4);
    let answer = found.describe().answer;
    assert!(answer.contains(" (4 of 4 sites)"), "{answer}");
    for peak in peaks {
        assert!(
            (peak.at - f / DT).abs() < 0.02 && peak.ratio > 8.0,
            "{peak:?}"
        );
        let width = (1.0 - r) / (std::f64::consts::PI * DT);
        assert!(
            (peak.width / width - 1.0).abs() < 0.4,
            "{}",
            peak.width / width
        );
    }
}

/// Lines anywhere in a bin are found, with the amplitude that they have.
#[test]
fn val_lines_between_bins() {
    let mut noise = Noise(15);
    let offsets: Vec<f64> = (0..9).map(|j| -0.5 + 0.125 * f64::from(j)).collect();
    let values = Array2::from_shape_fn((1024, 9), |(n, j)| {
        let angle = std::f64::consts::TAU * (200.0 + offsets[j]) / 1024.0 * n as f64 + j as f64;
        noise.gaussian() + 2.0 * angle.cos()
    });
    let found = found(&field(values), &tapers(None, None));
    let lines = &found.line_test.as_ref().unwrap().lines;
    // The tenth is one of those that are found by chance, once in twenty fields.
    assert!(lines.len() <= 10, "{lines:?}");
    let mut sites: Vec<usize> = lines.iter().take(9).map(|line| line.column).collect();
    sites.sort_unstable();
    assert_eq!(sites, (0..9).collect::<Vec<_>>());
    for line in &lines[..9] {
        let bin = found.bins[1];
        let off = line.at / bin - 200.0 - offsets[line.column];
        let deviation = (line.amplitude - 2.0) / line.amplitude_error;
        assert!(off.abs() < 0.3 && deviation.abs() < 4.0, "{line:?}");
    }
}

/// F exceeds its levels as often as they say, of tapers and of tapers in segments.
#[test]
fn val_lines_are_found_by_chance_as_often_as_stated() {
    let mut noise = Noise(21);
    let values = Array2::from_shape_fn((2048, 40), |_| noise.gaussian());
    let field = field(values);
    for request in [tapers(None, None), tapers(Some(512), Some(512 / 2))] {
        let found = found(&field, &request);
        let test = found.line_test.as_ref().unwrap();
        let cells: Vec<f64> = test
            .statistic
            .iter()
            .copied()
            .filter(|f| f.is_finite())
            .collect();
        let above = cells.iter().filter(|f| **f > test.level).count() as f64 / cells.len() as f64;
        assert!((above - 0.05).abs() < 0.012, "{above}");
        assert!(test.lines.is_empty(), "{:?}", test.lines);
    }
}

#[test]
fn regress_a_transient_has_intervals_by_its_records_alone() {
    let mut noise = Noise(4);
    let mut shot = || {
        let gain = noise.gaussian();
        field(Array2::from_shape_fn((2048, 3), |(n, j)| {
            let t = (n as f64 - 300.0 - 5.0 * j as f64) / 6.0;
            gain * (-t * t).exp()
        }))
    };
    let shots: Vec<Field> = (0..6).map(|_| shot()).collect();
    // Adaptive weights would differ between shots.
    let request = SpectrumRequest {
        is_adaptive: false,
        ..tapers(None, None)
    };
    let one = found(&shots[0], &request);
    assert_eq!(one.without_interval(), 3);
    assert!(one.degrees_range().is_none());
    assert!(
        one.low
            .iter()
            .chain(&one.high)
            .chain(&one.jackknife)
            .all(|v| v.is_nan())
    );
    assert!(one.line_test.unwrap().lines.is_empty());
    let all: Vec<&Field> = shots.iter().collect();
    let several = spectrum(&all, &request, &Silent).unwrap();
    assert_eq!(several.left_out, LeftOutEach::Record);
    assert_eq!(several.degrees_range().unwrap(), [12.0; 3]);
    // Shots of one shape whose energies differ: a jackknife of these, at any frequency.
    let energies: Vec<f64> = all
        .iter()
        .map(|shot| found(shot, &request).spectrum[[40, 1]])
        .collect();
    let sum: f64 = energies.iter().sum();
    let without: Vec<f64> = energies.iter().map(|e| ((sum - e) / 5.0).ln()).collect();
    let mean = without.iter().sum::<f64>() / 6.0;
    let variance = without.iter().map(|l| (l - mean).powi(2)).sum::<f64>() * 5.0 / 6.0;
    // Student's t of 5 degrees of freedom.
    let expected = 2.570_581_835_636_314 * variance.sqrt();
    let error = several.jackknife[[40, 1]] / expected - 1.0;
    assert!(error.abs() < 1e-10, "{error:e}");
    assert!((several.spectrum[[40, 1]] / (sum / 6.0) - 1.0).abs() < 1e-12);
}

/// Several records of a steady field are as one with as many segments.
#[test]
fn val_records_count_as_segments() {
    let mut noise = Noise(33);
    let values = Array2::from_shape_fn((1024, 9), |_| noise.gaussian());
    let request = tapers(Some(256), Some(0));
    let one = found(&field(values.clone()), &request);
    let parts: Vec<Field> = (0..4)
        .map(|i| {
            field(
                values
                    .slice(ndarray::s![256 * i..256 * (i + 1), ..])
                    .to_owned(),
            )
        })
        .collect();
    let shots: Vec<&Field> = parts.iter().collect();
    let several = spectrum(&shots, &request, &Silent).unwrap();
    let [f, g] = [&one, &several].map(|found| &found.line_test.as_ref().unwrap().statistic);
    for (a, b) in [
        (&one.spectrum, &several.spectrum),
        (&one.degrees, &several.degrees),
        (&one.low, &several.low),
        (&one.jackknife, &several.jackknife),
        (f, g),
    ] {
        for (a, b) in a.iter().zip(b).filter(|(a, _)| a.is_finite()) {
            assert!((a / b - 1.0).abs() < 1e-10, "{a} {b}");
        }
    }
}

/// Sites that do not move have a spectrum of 0 and no interval; others are not disturbed.
#[test]
fn regress_still_sites() {
    let mut noise = Noise(8);
    let values = Array2::from_shape_fn((512, 4), |(_, j)| match j {
        1 => 0.0,
        2 => 3.0,
        _ => noise.gaussian(),
    });
    let with = found(&field(values.clone()), &tapers(None, None));
    for j in [1, 2] {
        assert!(with.spectrum.column(j).iter().all(|s| *s < 1e-28), "{j}");
    }
    assert!(with.degrees.column(1).iter().all(|d| d.is_nan()));
    assert!(with.low.column(3).iter().skip(5).all(|s| *s > 0.0));
}

/// Along space, the estimate of the field with exchanged axes; its mean over the times has intervals that hold.
#[test]
fn val_mean_of_correlated_snapshots() {
    // Modes of a ring of sites, each a process of its own with a memory of about ten times.
    let (times, sites) = (4096, 32);
    let mut noise = Noise(77);
    let mut inside = [0, 0];
    for _ in 0..6 {
        let mut state = vec![0.0; sites];
        let mut values = Array2::zeros((times, sites));
        for n in 0..times {
            for j in 0..sites {
                state[j] = 0.9 * state[j] + noise.gaussian();
                values[[n, j]] = state[j];
            }
        }
        let mut field = field(values);
        field.space.step = 0.5;
        let request = SpectrumRequest {
            along: SpectrumAxis::Space,
            averaging: Averaging {
                detrend: Detrend::None,
                ..periodogram().averaging
            },
            ..periodogram()
        };
        let found = found(&field, &request);
        assert_eq!(found.spectrum.dim(), (17, times));
        assert_eq!((found.time.step, found.space.step), (DT, 0.5));
        let dk = found.bins[1];
        assert!((dk - std::f64::consts::TAU / 16.0).abs() < 1e-15);
        // Parseval: the integral over k is the mean square of each snapshot.
        for n in [0, 1000] {
            let row = field_row(&field, n);
            let square = row.iter().map(|v| v * v).sum::<f64>() / sites as f64;
            let sum = found.spectrum.column(n).sum() * dk;
            assert!((sum / square - 1.0).abs() < 1e-13, "{sum} {square}");
        }
        let mean = found.mean.unwrap();
        let truth = 2.0 * 0.5 * 4.0 / 0.19 / std::f64::consts::TAU;
        for m in 1..16 {
            inside[0] += i32::from(mean.low[m] < truth && truth < mean.high[m]);
            inside[1] += 1;
            // Of 4096: the powers' correlation is 0.81^l, so (1 + 0.81) / (1 - 0.81) count as one: 430.
            let effective = mean.effective_snapshots[m];
            assert!((100.0..2000.0).contains(&effective), "{effective}");
        }
    }
    let share = f64::from(inside[0]) / f64::from(inside[1]);
    assert!((share - 0.95).abs() < 0.06, "{share}");
}

fn field_row(field: &Field, time: usize) -> Vec<f64> {
    let mut row = vec![0.0; field.n_sites()];
    field.read_time_major(time..time + 1, 0..field.n_sites(), &mut row);
    row
}

/// What `analyze` states of its own spectra.
#[test]
fn val_intervals_of_analyze() {
    use wavecascade::analyze::Request;
    let steady = field(records());
    let (analysis, _) = wavecascade::analyze(&steady, &Request::default()).unwrap();
    let interval = analysis.interval.unwrap();
    assert!((interval.degrees_of_freedom.unwrap() - 2.0).abs() < 1e-13);
    // Of an exponential distribution.
    let [low, high] = interval.factors.unwrap();
    assert!((low * -0.025_f64.ln() - 1.0).abs() < 1e-13);
    assert!((high * -(-0.025_f64).ln_1p() - 1.0).abs() < 1e-13);
    let pulse = field(Array2::from_shape_fn((1024, 6), |(n, j)| {
        let t = (n as f64 - 200.0 - 5.0 * j as f64) / 6.0;
        (-t * t).exp()
    }));
    let (analysis, _) = wavecascade::analyze(&pulse, &Request::default()).unwrap();
    let interval = analysis.interval.unwrap();
    assert!(interval.factors.is_none() && interval.degrees_of_freedom.is_none());
    assert!(interval.steadiness < 0.2, "{}", interval.steadiness);
}
