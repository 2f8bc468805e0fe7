//! Spectral proper orthogonal decompositions against NumPy's singular values and PySPOD
//! (`data/modes.json`, made by `data/make_modes.py`), and against fields whose modes are known.

use ndarray::Array2;
use num_complex::Complex;
use serde::Deserialize;
use test_support::fields::{Congruential, averaging, noise, stepped};
use wavecascade::Field;
use wavecascade::estimates::{Averaging, Modes, ModesRequest, Tapers, modes};
use wavecascade::observer::Silent;
use wavecascade::prepare::{Detrend, Window};
use wavecascade::transform::fold;

const DT: f64 = 0.25;
const DX: f64 = 0.5;
const TAU: f64 = std::f64::consts::TAU;

fn field(values: Array2<f64>) -> Field {
    stepped(values, DT, DX)
}

fn segmented(length: usize) -> ModesRequest {
    ModesRequest {
        averaging: averaging(length, length / 2),
        ..ModesRequest::default()
    }
}

fn found(field: &Field, request: &ModesRequest) -> Modes {
    modes(&[field], request, &Silent).unwrap()
}

/// The records of `make_modes.py`.
fn records(sites: usize) -> Array2<f64> {
    let mut random = Congruential(1);
    Array2::from_shape_fn((272, sites), |(n, j)| {
        let (t, x) = (DT * n as f64, DX * j as f64);
        let back = 0.7 * (0.4 * x + TAU * 1.1 * t).cos() * (1.0 + 0.1 * x);
        (0.9 * x - TAU * 0.4 * t).cos() + back + random.uniform()
    })
}

/// The largest deviation from these eigenvalues, over the largest of them.
fn off<'a>(expected: impl Iterator<Item = &'a f64>, found: &Modes) -> f64 {
    let expected: Vec<f64> = expected.copied().collect();
    assert_eq!(expected.len(), found.eigenvalues.len());
    let largest = expected.iter().fold(0.0, |m: f64, v| m.max(*v));
    let pairs = expected.iter().zip(&found.eigenvalues);
    pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs() / largest))
}

#[derive(Deserialize)]
struct Expected {
    eigenvalues: Vec<Vec<f64>>,
    real: Vec<Vec<Vec<f64>>>,
    imag: Vec<Vec<Vec<f64>>>,
}

#[derive(Deserialize)]
struct Reference {
    wide: Expected,
    narrow: Expected,
    pyspod: Vec<Vec<f64>>,
}

fn reference() -> Reference {
    serde_json::from_str(include_str!("../data/modes.json")).unwrap()
}

/// Of more sites than realisations, and of fewer.
#[test]
fn val_numpy_svd_of_the_realisations() {
    let reference = reference();
    for (expected, sites) in [(&reference.wide, 22), (&reference.narrow, 11)] {
        let bins = [3.0, 4.0, 9.0];
        let request = ModesRequest {
            frequencies: bins.map(|m| m / (32.0 * DT)).to_vec(),
            ..segmented(32)
        };
        let found = found(&field(records(sites)), &request);
        let theirs = expected.eigenvalues.iter().flatten();
        let mut worst = [off(theirs, &found), 0.0f64];
        for (c, shapes) in found.chosen.iter().enumerate() {
            for n in 0..3 {
                let mode = shapes.modes.row(n);
                let (re, im) = (&expected.real[c][n], &expected.imag[c][n]);
                let theirs = re.iter().zip(im).map(|(re, im)| Complex::new(*re, *im));
                // 1 for the same mode, whatever the phases.
                let pairs = mode.iter().zip(theirs);
                let product: Complex<f64> = pairs.map(|(a, b)| a.conj() * b * DX).sum();
                worst[1] = worst[1].max((product.norm() - 1.0).abs());
            }
        }
        assert!(worst[0] < 2e-15 && worst[1] < 1e-12, "{worst:?}");
    }
}

#[test]
fn val_pyspod_eigenvalues() {
    let found = found(&field(records(22)), &segmented(32));
    let worst = off(reference().pyspod.iter().flatten(), &found);
    assert!(worst < 1e-14, "{worst:e}");
}

/// The eigenvalues of a frequency sum up to the power spectral density of all sites, which is that of
/// the samples: with no taper, to their variance.
#[test]
fn val_parseval_of_all_eigenvalues() {
    let values = noise(960, 21);
    let segments_of = values.axis_chunks_iter(ndarray::Axis(0), 64);
    let variance = segments_of.map(|segment| segment.var_axis(ndarray::Axis(0), 0.0).sum());
    let variance = variance.sum::<f64>() * DX / 15.0;
    let request = ModesRequest {
        averaging: Averaging {
            tapers: Tapers::Window(Window::None),
            detrend: Detrend::Mean,
            ..averaging(64, 0)
        },
        ..ModesRequest::default()
    };
    let found = found(&field(values), &request);
    let mut sum = 0.0;
    for (row, total) in found.eigenvalues.outer_iter().zip(&found.total) {
        let off = row.sum() / total - 1.0;
        assert!(row[0] == 0.0 || off.abs() < 3e-15, "{off:e}");
        sum += row.sum() / (64.0 * DT);
    }
    let off = sum / variance - 1.0;
    assert!(off.abs() < 2e-14, "{off:e}");
    assert_eq!(fold(0, 64), 1.0);
}

/// Independent sources with known shapes: their eigenvalues lie within the intervals as often as stated,
/// and the modes of waves have their wavenumbers.
#[test]
fn val_known_sources_lie_within_the_intervals() {
    let (n, sites) = (8192, 30);
    let (mut inside, mut all) = (0.0, 0.0);
    let source = noise(n, 2);
    // Orthogonal shapes: one half wave and one whole wave over the sites.
    let shape = |k: usize, j: usize| (TAU * k as f64 * (j as f64 + 0.5) / (2 * sites) as f64).sin();
    let values = Array2::from_shape_fn((n, sites), |(t, j)| {
        3.0 * source[[t, 0]] * shape(1, j) + source[[t, 1]] * shape(2, j)
    });
    let request = segmented(128);
    let found = found(&field(values), &request);
    // White noise of variance 1 has the density 2 dt; each shape has the square sum sites / 2.
    let strength = 2.0 * DT * DX * sites as f64 / 2.0;
    for bin in 2..63 {
        let [low, high] = found.interval(bin).unwrap();
        for (mode, expected) in [(0, 9.0 * strength), (1, strength)] {
            let value = found.eigenvalues[[bin, mode]];
            all += 1.0;
            inside += f64::from((value * low..value * high).contains(&expected));
        }
        assert!(found.eigenvalues[[bin, 2]] < 1e-12 * strength);
    }
    assert!((0.9..0.99).contains(&(inside / all)), "{inside} of {all}");
}

#[test]
fn regress_one_transient_has_no_interval() {
    let pulses = |sites: usize, start: f64, later: f64| {
        field(Array2::from_shape_fn((2048, sites), |(n, j)| {
            let t = (n as f64 - start - later * j as f64) / 6.0;
            (-t * t).exp()
        }))
    };
    let (request, pulse) = (segmented(256), pulses(6, 300.0, 5.0));
    assert_eq!(found(&pulse, &request).interval(3), None);
    // A pulse that passes all sites is one at each, though their energy together is steady.
    assert_eq!(found(&pulses(64, 20.0, 31.0), &request).interval(3), None);
    let shots = modes(&[&pulse; 5], &request, &Silent).unwrap();
    assert_eq!(shots.independence.independent, Some(5.0));
    assert!(shots.interval(3).is_some());
}

/// White and red records, one of them loud, of more sites than realisations and of fewer.
#[test]
fn val_unrelated_records_have_no_coherent_motion() {
    let mut said = 0;
    for (sites, length) in [(2, 64), (8, 64), (24, 128), (60, 256)] {
        let white = noise(2048, 20 * sites);
        for (k, memory) in (0..20).flat_map(|k| [(k, 0.0), (k, 0.9)]) {
            let mut values = Array2::from_shape_fn((2048, sites), |(n, j)| {
                white[[n, k * sites + j]] * if j == 1 { 5.0 } else { 1.0 }
            });
            for n in 1..2048 {
                let before = memory * &values.row(n - 1);
                values.row_mut(n).zip_mut_with(&before, |v, b| *v += b);
            }
            let found = found(&field(values), &segmented(length));
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
    type Motion<'a> = &'a dyn Fn(usize, usize) -> f64;
    let cases: [(usize, Motion<'_>); 4] = [
        (1, &|t, j| wave(t, j) * (-0.3 * j as f64).exp()),
        (1, &|t, _| source[[t, 0]]),
        (2, &|t, j| {
            source[[t, 0]] + source[[t, 1]] * if j % 2 == 0 { 1.0 } else { -1.0 }
        }),
        (1, &|t, j| {
            if j == 3 {
                20.0 * source[[t, 2]]
            } else {
                wave(t, j)
            }
        }),
    ];
    for (case, (expected, motion)) in cases.into_iter().enumerate() {
        let values = Array2::from_shape_fn((4096, 12), |(t, j)| motion(t, j));
        let found = found(&field(values), &segmented(256));
        for bin in 3..100 {
            assert_eq!(found.above_noise(bin), Some(expected), "{case} {bin}");
        }
        let first = usize::from(case == 3);
        let coherent = &found.chosen[0].is_coherent;
        assert_eq!(coherent.iter().position(|is| *is), Some(first), "{case}");
        assert!(case != 1 || (found.coherencies[[5, 0]] - 12.0).abs() < 1e-12);
    }
}

/// Tones anywhere between bins, in noise as loud as they are. Standing ones are no waves.
#[test]
fn val_velocities_lie_within_their_intervals() {
    let noise = noise(2048, 1200);
    let mut inside = 0;
    for (k, velocity) in (0..100).zip([3.0, -4.0].into_iter().cycle()) {
        let omega = TAU * (0.5 + 3e-4 * k as f64);
        let first = |back: f64| {
            let values = Array2::from_shape_fn((2048, 12), |(n, j)| {
                let (x, t) = (DX * j as f64 / velocity, DT * n as f64);
                let both = (omega * (x - t)).cos() + back * (omega * (x + t)).cos();
                2.0f64.sqrt() * both + noise[[n, 12 * k + j]]
            });
            found(&field(values), &segmented(128)).chosen[0].waves[0].unwrap()
        };
        let (wave, standing) = (first(0.0), first(1.0));
        let half = wave.velocity_half.unwrap();
        assert!(wave.is_wave && half < 0.05 * velocity.abs(), "{wave:?}");
        assert!(!standing.is_wave, "{standing:?}");
        assert!((0.5..0.8).contains(&standing.share), "{standing:?}");
        inside += usize::from((wave.velocity - velocity).abs() < half);
    }
    assert!((92..=98).contains(&inside), "{inside} of 100");
}
