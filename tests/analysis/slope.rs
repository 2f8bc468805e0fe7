//! Spectral slopes against closed forms: power laws, Burgers' equation before and after shocks, the
//! Fermi-Pasta-Ulam-Tsingou chain.

use ndarray::Array2;
use test_support::changed;
use test_support::fields::{chain, noise};
use wavecascade::Field;
use wavecascade::chain::{Accuracy, EndTime, Ends, Law, Record, Scheme, Simulation};
use wavecascade::estimates::{
    Averaging, ExponentBasis, FieldAxis, Slope, SlopeRequest, Tapers, slope,
};
use wavecascade::observer::Silent;
use wavecascade::prepare::{Detrend, Window};
use wavecascade::reference::bessel_j;

const TAU: f64 = std::f64::consts::TAU;

fn found(field: &Field, request: &SlopeRequest) -> Slope {
    slope(&[field], request, &Silent).unwrap()
}

/// Of periodic profiles, untapered.
fn periodic(band: (f64, f64)) -> SlopeRequest {
    SlopeRequest {
        band,
        averaging: Averaging {
            tapers: Tapers::Window(Window::None),
            detrend: Detrend::None,
            ..Averaging::default()
        },
        ..SlopeRequest::default()
    }
}

/// Profiles over one period of 2 pi, at times from `from` on.
fn profiles(n: usize, times: &[f64], of: impl Fn(f64, f64) -> f64) -> Field {
    let dx = TAU / n as f64;
    let values = Array2::from_shape_fn((times.len(), n), |(i, j)| of(times[i], dx * j as f64));
    let mut field = Field::from_array(values);
    field.space.step = dx;
    field.time.origin = times[0];
    field.time.step = (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64;
    field
}

/// Slope of `ln e_m` against `ln m` from `from` to `to`.
fn regression(from: usize, to: usize, e: impl Fn(usize) -> f64) -> f64 {
    let points: Vec<(f64, f64)> = (from..=to).map(|m| ((m as f64).ln(), e(m).ln())).collect();
    let n = points.len() as f64;
    let (x, y) = points
        .iter()
        .fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xy, xx) = points.iter().fold((0.0, 0.0), |(xy, xx), p| {
        (xy + (p.0 - x) * (p.1 - y), xx + (p.0 - x) * (p.0 - x))
    });
    xy / xx
}

/// Waves whose powers follow a law, along x and in time, with a break.
#[test]
fn val_exact_power_laws_and_their_break() {
    let power = |m: usize| {
        let m = m as f64;
        0.3 * m.powf(-1.7) * if m > 40.0 { (m / 40.0).powf(-2.0) } else { 1.0 }
    };
    let wave = |phase: f64, angle: f64| {
        let term = |m: usize| power(m).sqrt() * (m as f64 * angle + phase * (m * m) as f64).cos();
        (1..128).map(term).sum::<f64>()
    };
    let values = Array2::from_shape_fn((12, 512), |(i, j)| wave(i as f64, TAU * j as f64 / 512.0));
    let mut field = Field::from_array(values.clone());
    field.space.step = 0.5;
    let k = |m: f64| TAU * m / 256.0;
    let low = found(&field, &periodic((k(2.0), k(35.0))));
    assert!((low.law.slope + 1.7).abs() < 1e-12, "{:?}", low.law);
    assert!(low.law.half < 1e-11, "{:?}", low.law);
    assert_eq!(low.law.points, 34);
    assert_eq!(low.law.basis, ExponentBasis::Regression);
    assert!(low.breaks.is_none(), "{:?}", low.breaks);
    // A cosine of power p has p / 2 in one bin of the width 2 pi / L.
    let expected = 0.5 * power(10) / k(1.0);
    assert!((low.spectrum[10] / expected - 1.0).abs() < 1e-12);
    assert!((low.compensated()[10] - 1.0).abs() < 1e-12);
    let all = found(&field, &periodic((k(2.0), k(120.0))));
    let breaks = all.breaks.unwrap();
    assert_eq!(breaks.at.len(), 1);
    assert!((breaks.at[0] / k(40.0) - 1.0).abs() < 0.05, "{breaks:?}");
    assert!((breaks.slopes[0] + 1.7).abs() < 0.05 && (breaks.slopes[1] + 3.7).abs() < 0.05);
    // In time.
    let mut transposed = Field::from_array(values.t().to_owned());
    transposed.time.step = 0.5;
    let request = SlopeRequest {
        axis: FieldAxis::Time,
        averaging: changed(periodic((0.0, 1.0)).averaging, |it| it.segment = Some(512)),
        ..periodic((2.0 / 256.0, 35.0 / 256.0))
    };
    let found = found(&transposed, &request);
    assert!((found.law.slope + 1.7).abs() < 1e-12, "{:?}", found.law);
    assert!((found.spectrum[10] / (0.5 * power(10) * 256.0) - 1.0).abs() < 1e-12);
}

/// Burgers' equation without viscosity from `size sin(x - phase)`: `u = size sin(x - phase - u t)` until the shock forms at
/// `t = 1 / size`.
fn fubini(n: usize, times: &[f64], size: f64, phase: f64) -> Field {
    profiles(n, times, |t, x| {
        // From where the velocity came: x = y + t size sin(y - phase).
        let (mut low, mut high) = (x - size * t, x + size * t);
        for _ in 0..54 {
            let middle = 0.5 * (low + high);
            match middle + t * size * (middle - phase).sin() < x {
                true => low = middle,
                false => high = middle,
            }
        }
        size * (0.5 * (low + high) - phase).sin()
    })
}

/// Fubini's amplitudes are `2 J_m(m t) / (m t)`, whose squares fall like `m^{-8/3}` at the shock time.
#[test]
fn val_fubini_before_the_shock_of_burgers() {
    let times: Vec<f64> = (0..41).map(|i| f64::from(i) / 40.0).collect();
    let field = fubini(1024, &times, 1.0, 0.0);
    let found = found(&field, &periodic((3.5, 40.5)));
    let frames = found.frames.as_ref().unwrap();
    let steep = found.steepening.unwrap();
    assert!((steep.shock_time - 1.0).abs() < 5e-6, "{steep:?}");
    assert!((steep.shock_time - 1.0).abs() < steep.half && steep.half < 1e-4);
    let power =
        |t: f64| move |m: usize| (bessel_j(m as f64 * t, m + 1)[m] / (m as f64 * t)).powi(2);
    let expected = regression(4, 40, power(1.0));
    // Samples of a cube root alias a little.
    assert!((steep.slope_at_shock - expected).abs() < 0.003);
    assert!(
        (steep.slope_at_shock + 8.0 / 3.0).abs() < 0.002,
        "{steep:?}"
    );
    for i in [28, 32, 36] {
        let expected = regression(4, 40, power(times[i]));
        let slope = frames.slope[i];
        assert!((slope / expected - 1.0).abs() < 1e-6, "{i} {slope}");
    }
    for (found, expected) in frames.time.iter().zip(&times) {
        assert!((found - expected).abs() < 1e-12);
    }
}

/// The interval of the shock time holds the exact one with noise from none to a hundredth, of several sizes and samplings.
#[test]
fn val_shock_times_are_in_their_intervals() {
    let (mut stated, mut inside, mut worst) = (0, 0, 0.0f64);
    let all = noise(80 * 48, 256);
    for trial in 0..48 {
        let (size, n) = ([0.3, 1.0, 2.7][trial % 3], [128, 256][trial / 3 % 2]);
        let level = [0.0, 1e-4, 1e-3, 1e-2][trial / 6 % 4];
        let times: Vec<f64> = (0..80).map(|i| f64::from(i) / 79.0 / size).collect();
        let exact = fubini(n, &times, size, 0.02 * trial as f64 - 0.5);
        let mut values = Array2::zeros((80, n));
        exact.read_time_major(0..80, 0..n, values.as_slice_mut().unwrap());
        values.scaled_add(
            level * size,
            &all.slice(ndarray::s![80 * trial..80 * (trial + 1), ..n]),
        );
        let mut field = Field::from_array(values);
        (field.time, field.space) = (exact.time, exact.space);
        let Some(steep) = found(&field, &periodic((3.5, 40.5))).steepening else {
            continue;
        };
        stated += 1;
        inside += usize::from((steep.shock_time * size - 1.0).abs() < steep.half * size);
        worst = worst.max(steep.half * size / (4.0 * level + 1e-3));
    }
    assert!(stated >= 46 && inside >= stated - 4, "{inside} of {stated}");
    assert!(worst < 1.0, "{worst}");
}

/// Burgers' equation with viscosity after the shock has formed: Fay's solution, with the amplitudes
/// `2 nu / sinh(nu m (1 + t))`, whose squares fall like `m^{-2}` where `nu m (1 + t)` is small.
#[test]
fn val_fay_after_the_shock_of_viscous_burgers() {
    let (viscosity, modes) = (0.002, 255);
    let times: Vec<f64> = (0..8).map(|i| 3.0 + 0.25 * f64::from(i)).collect();
    let amplitude = |t: f64, m: usize| 2.0 * viscosity / (viscosity * m as f64 * (1.0 + t)).sinh();
    let field = profiles(512, &times, |t, x| {
        (1..=modes)
            .map(|m| amplitude(t, m) * (m as f64 * x).sin())
            .sum()
    });
    let found = found(&field, &periodic((1.5, 20.5)));
    let power = |m: usize| times.iter().map(|t| amplitude(*t, m).powi(2)).sum::<f64>();
    let expected = regression(2, 20, power);
    assert!((found.law.slope / expected - 1.0).abs() < 1e-10);
    // From 2 to 20, where viscosity bends it by a hundredth.
    assert!((found.law.slope + 2.0).abs() < 0.008, "{:?}", found.law);
    // A shock that is there already does not steepen.
    assert!(found.steepening.is_none());
}

/// The alpha chain of Fermi, Pasta, Ulam and Tsingou, one wave along the ring that travels to the right: the slope
/// of the velocity's spectrum is -8/3 at the shock time and -2 after it, over modes 3 to 20
/// (arXiv:2407.16534). The shock time of its Burgers' equation is `1 / (alpha max |dv/dx|)`.
#[test]
fn val_fput_chain_at_and_after_its_shock() {
    let (n, alpha, speed) = (512, 1.0, 0.05);
    let k = TAU / n as f64;
    let shock = 1.0 / (alpha * speed * k);
    let omega = 2.0 * (0.5 * k).sin();
    let chain = chain(
        vec![1.0; n],
        vec![1.0; n],
        Law::Spring { alpha, beta: 0.0 },
        Ends::Periodic,
    );
    let wave = |j: usize| k * j as f64;
    let simulation = Simulation {
        velocity: (0..n).map(|j| speed * wave(j).sin()).collect(),
        displacement: (0..n).map(|j| speed / omega * wave(j).cos()).collect(),
        scheme: Scheme::VelocityVerlet,
        accuracy: Accuracy::Step(0.2),
        end_time: EndTime::At(2.0 * shock),
        record: Record::default(),
        estimate_error: false,
        ..Simulation::impact(chain, 0.0, 1.0, 81)
    };
    let field = simulation.run(&Silent).unwrap().to_field();
    let found = found(&field, &periodic((2.5 * k, 20.5 * k)));
    let steep = found.steepening.unwrap();
    assert!((steep.shock_time / shock - 1.0).abs() < 0.003, "{steep:?}");
    assert!(
        (steep.slope_at_shock + 8.0 / 3.0).abs() < 0.025,
        "{steep:?}"
    );
    assert!((steep.slope_after + 2.0).abs() < 0.04, "{steep:?}");
    for after in steep.slope_after_range {
        assert!((after + 2.0).abs() < 0.12, "{steep:?}");
    }
}

/// White noise has the slope 0; intervals over shots hold it as often as stated.
#[test]
fn val_intervals_over_shots_hold() {
    let all = noise(40 * 6 * 4, 64);
    let mut inside = 0;
    for trial in 0..40 {
        let shots: Vec<Field> = (0..6)
            .map(|s| {
                let from = (trial * 6 + s) * 4;
                Field::from_array(all.slice(ndarray::s![from..from + 4, ..]).to_owned())
            })
            .collect();
        let fields: Vec<&Field> = shots.iter().collect();
        let request = changed(SlopeRequest::default(), |it| it.band = (0.2, 3.0));
        let law = slope(&fields, &request, &Silent).unwrap().law;
        assert_eq!(law.basis, ExponentBasis::Shots);
        inside += usize::from(law.slope.abs() < law.half);
    }
    assert!((35..=40).contains(&inside), "{inside}");
}

/// So do those of the regression along time, where a window gives neighbouring bins a part in common.
#[test]
fn val_intervals_of_the_regression_hold() {
    let trials = 300;
    let all = noise(1024 * trials, 1);
    let inside = (0..trials).filter(|trial| {
        let from = 1024 * trial;
        let field = Field::from_array(all.slice(ndarray::s![from..from + 1024, ..]).to_owned());
        let request = SlopeRequest {
            axis: FieldAxis::Time,
            band: (0.02, 0.48),
            ..SlopeRequest::default()
        };
        let law = slope(&[&field], &request, &Silent).unwrap().law;
        assert_eq!(law.basis, ExponentBasis::Regression);
        law.slope.abs() < law.half
    });
    let inside = inside.count();
    assert!((276..=294).contains(&inside), "{inside}");
}

#[test]
fn regress_snapshots_with_gaps_are_left_out() {
    let whole = noise(10, 64);
    let mut holed = ndarray::concatenate![ndarray::Axis(0), whole, noise(1, 64)];
    holed[[10, 7]] = f64::NAN;
    let request = SlopeRequest {
        band: (0.2, 3.0),
        frames: 1,
        ..SlopeRequest::default()
    };
    let expected = found(&Field::from_array(whole), &request);
    let found = found(&Field::from_array(holed), &request);
    assert_eq!(found.left_out, 1);
    for (a, b) in found.spectrum.iter().zip(&expected.spectrum) {
        assert!((a / b - 1.0).abs() < 1e-13 || *b < 1e-20);
    }
}
