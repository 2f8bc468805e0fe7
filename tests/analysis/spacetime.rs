//! `S(k, f)` with intervals against NumPy and SciPy (`data/spacetime.json`, made by
//! `data/make_spacetime.py`), noise whose spectrum is known, and waves.

use std::f64::consts::TAU;

use ndarray::Array2;
use test_support::changed;
use test_support::fields::{Congruential as Noise, averaging, stepped};
use wavecascade::Field;
use wavecascade::estimates::{Averaging, SpaceTimeEstimate, SpaceTimeRequest, Tapers, spacetime};
use wavecascade::observer::Silent;
use wavecascade::prepare::{Detrend, Window};

const DT: f64 = 0.25;
const DX: f64 = 0.5;

fn field(values: Array2<f64>) -> Field {
    stepped(values, DT, DX)
}

fn welch(segment: usize, overlap: usize) -> SpaceTimeRequest {
    SpaceTimeRequest {
        averaging: averaging(segment, overlap),
        ..SpaceTimeRequest::default()
    }
}

fn tapers(time: (f64, usize), space: (f64, usize)) -> SpaceTimeRequest {
    let slepian = |(nw, count)| Tapers::Slepian { nw, count };
    SpaceTimeRequest {
        averaging: Averaging {
            tapers: slepian(time),
            detrend: Detrend::None,
            ..Averaging::default()
        },
        space: slepian(space),
        is_adaptive: false,
        ..SpaceTimeRequest::default()
    }
}

fn adaptive(time: (f64, usize), space: (f64, usize)) -> SpaceTimeRequest {
    changed(tapers(time, space), |it| it.is_adaptive = true)
}

fn found(field: &Field, request: &SpaceTimeRequest) -> SpaceTimeEstimate {
    spacetime(&[field], request, &Silent).unwrap()
}

#[derive(serde::Deserialize)]
struct Reference {
    welch: Vec<f64>,
    tapers: Vec<f64>,
    steep: [Vec<f64>; 2],
}

#[test]
fn val_numpy_and_scipy_spectra() {
    let text = include_str!("../data/spacetime.json");
    let reference: Reference = serde_json::from_str(text).unwrap();
    for (times, sites, request, expected) in [
        (52, 10, welch(16, 8), reference.welch),
        (45, 9, tapers((2.0, 3), (2.0, 2)), reference.tapers),
    ] {
        let mut noise = Noise(5);
        let values = Array2::from_shape_fn((times, sites), |_| noise.uniform());
        let found = found(&field(values), &request);
        let largest = expected.iter().copied().fold(0.0, f64::max);
        assert_eq!(found.spectrum.len(), expected.len());
        let errors = found.spectrum.iter().zip(&expected);
        let worst = errors.map(|(a, b)| (a - b).abs() / largest);
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 2e-13, "{times}: {worst:e}");
        assert!(found.parseval.abs() < 1e-13, "{:e}", found.parseval);
    }
}

/// Waves that are 1e6 times as strong as the noise leak through equal weights over the whole plane; SciPy's
/// sequences and a fixed-point iteration in NumPy give the adaptive average and its degrees of freedom.
#[test]
fn val_adaptive_weights_by_numpy() {
    let text = include_str!("../data/spacetime.json");
    let reference: Reference = serde_json::from_str(text).unwrap();
    let mut noise = Noise(5);
    let values = Array2::from_shape_fn((45, 9), |(n, j)| {
        1e3 * (0.9 * n as f64 - 1.1 * j as f64).cos() + noise.uniform()
    });
    let request = adaptive((2.5, 4), (2.0, 3));
    let [one, equal] = [true, false].map(|is_adaptive| {
        let request = changed(request.clone(), |it| it.is_adaptive = is_adaptive);
        found(&field(values.clone()), &request)
    });
    let [spectrum, degrees] = &reference.steep;
    let errors = |found: &Array2<f64>, expected: &[f64]| {
        let errors = found.iter().zip(expected);
        errors.fold(0.0, |m: f64, (a, b)| m.max((a / b - 1.0).abs()))
    };
    let worst = [
        errors(&one.spectrum, spectrum),
        errors(&one.degrees, degrees),
    ];
    assert!(worst.iter().all(|error| *error < 2e-9), "{worst:?}");
    assert!(one.parseval.abs() < 1e-12, "{:e}", one.parseval);
    let [least, _, most] = one.degrees_range().unwrap();
    assert!(least < 5.0 && most > 20.0 && most <= 24.0, "{least} {most}");
    let lowest =
        |found: &SpaceTimeEstimate| found.spectrum.iter().copied().fold(f64::INFINITY, f64::min);
    let leaked = lowest(&equal) / lowest(&one);
    assert!(leaked > 2.0, "{leaked}");
    // A still field has no energy to weigh.
    let still = found(&field(Array2::zeros((45, 9))), &request);
    assert!(still.spectrum.iter().all(|s| *s == 0.0));
    assert!(still.degrees.iter().all(|d| d.is_nan()));
}

/// White noise lies in the intervals as often as they say; its density is `2 variance dt dx / (2 pi)`.
#[test]
fn val_intervals_of_white_noise_hold() {
    let mut noise = Noise(23);
    for (times, sites, request, expected) in [
        (4096, 24, welch(64, 32), 2.0 * 120.4),
        (256, 40, tapers((3.0, 5), (2.0, 3)), 2.0 * 15.0),
        (256, 40, adaptive((3.0, 5), (2.0, 3)), 2.0 * 14.9),
    ] {
        let truth = 2.0 * 4.0 * DT * DX / TAU;
        let (mut inside, mut all) = (0, 0);
        for _ in 0..2 {
            let values = Array2::from_shape_fn((times, sites), |_| noise.gaussian());
            let found = found(&field(values), &request);
            let [_, degrees, _] = found.degrees_range().unwrap();
            assert!((0.93..1.07).contains(&(degrees / expected)), "{degrees}");
            let ends = found.low.indexed_iter().zip(&found.high);
            let rows = 4..found.frequency.len() - 4;
            for (((m, _), low), high) in ends {
                if rows.contains(&m) {
                    all += 1;
                    inside += u32::from(*low < truth && truth < *high);
                }
            }
        }
        let share = f64::from(inside) / f64::from(all);
        assert!((share - 0.95).abs() < 0.015, "{share}");
    }
}

/// A wave travels towards +x at positive k; its power is that of the samples.
#[test]
fn val_plane_waves_at_their_wavenumber_and_frequency() {
    let (times, sites) = (1000, 20);
    let (bin, wave) = (11, 3);
    let frequency = f64::from(bin) / (64.0 * DT);
    for (sign, shares) in [(1.0, [1.0, 0.0, 0.0]), (-1.0, [0.0, 1.0, 0.0])] {
        let k = sign * TAU * f64::from(wave) / (sites as f64 * DX);
        let values = Array2::from_shape_fn((times, sites), |(n, j)| {
            3.0 * (k * j as f64 * DX - TAU * frequency * n as f64 * DT).cos()
        });
        let whole = SpaceTimeRequest {
            space: Tapers::Window(Window::None),
            averaging: Averaging {
                tapers: Tapers::Window(Window::None),
                ..welch(64, 0).averaging
            },
            ..SpaceTimeRequest::default()
        };
        for request in [welch(64, 32), whole] {
            let found = found(&field(values.clone()), &request);
            let (row, column) = found.largest();
            assert!((found.frequency[row] - frequency).abs() < 1e-12);
            assert!((found.wavenumber[column] - k).abs() < 1e-12);
            for (share, expected) in found.directions().iter().zip(shares) {
                assert!((share - expected).abs() < 1e-9, "{share}");
            }
            assert!((found.power / 4.5 - 1.0).abs() < 1e-12, "{}", found.power);
            assert!((found.mean_square / 4.5 - 1.0).abs() < 1e-12);
        }
    }
}

/// A pulse that passes all sites is a transient, though the energy of all of them is steady.
#[test]
fn regress_a_transient_has_no_interval_without_shots() {
    let pulse = |shot: u64| {
        let mut noise = Noise(shot);
        field(Array2::from_shape_fn((640, 16), |(n, j)| {
            let late = (n as f64 - 40.0 * j as f64 - 10.0) / 6.0;
            (-late * late).exp() + 1e-3 * noise.uniform()
        }))
    };
    let shots: Vec<Field> = (0..3).map(pulse).collect();
    let request = welch(64, 32);
    let one = found(&shots[0], &request);
    assert!(!one.has_interval() && one.independence.is_transient());
    assert!(one.low.iter().chain(&one.degrees).all(|v| v.is_nan()));
    let all: Vec<&Field> = shots.iter().collect();
    let three = spacetime(&all, &request, &Silent).unwrap();
    assert_eq!(three.degrees_range(), Some([6.0; 3]));
    // Energy at one site of many: tapers along space see the same.
    let mut noise = Noise(9);
    let values = Array2::from_shape_fn((512, 32), |(_, j)| match j {
        7 => noise.gaussian(),
        _ => 1e-3 * noise.gaussian(),
    });
    let narrow = found(&field(values), &tapers((3.0, 5), (2.0, 3)));
    let [_, degrees, _] = narrow.degrees_range().unwrap();
    assert!((degrees - 10.0).abs() < 1e-6, "{degrees}");
}
