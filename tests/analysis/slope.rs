//! Spectral slopes against closed forms: power laws, Burgers' equation before and after shocks, the
//! Fermi-Pasta-Ulam-Tsingou chain.

use std::f64::consts::TAU;

use ndarray::{Array2, Axis, concatenate, s};
use test_support::estimate::slope;
use test_support::fields::{chain, noise, stepped};
use test_support::{hold, lies, near};
use wavecascade::Field;
use wavecascade::chain::{Accuracy, EndTime, Ends, Law, Record, Scheme, Simulation};
use wavecascade::estimates::{IntervalBasis, Slope};
use wavecascade::observer::Silent;
use wavecascade::reference::bessel_j;

/// Of periodic profiles, untapered.
fn found(field: &Field, [low, high]: [f64; 2], more: &str) -> Slope {
    let words = format!("window=none detrend=none band={low},{high} {more}");
    slope(&words, [field]).unwrap()
}

/// Profiles over one period of 2 pi at these times.
fn profiles(n: usize, times: &[f64], of: impl Fn(f64, f64) -> f64) -> Field {
    let dx = TAU / n as f64;
    let values = Array2::from_shape_fn((times.len(), n), |(i, j)| of(times[i], dx * j as f64));
    let mut field = stepped(values, times[1] - times[0], dx);
    field.time.origin = times[0];
    field
}

/// Slope of `ln e_m` against `ln m` from `from` to `to`.
fn regression(from: usize, to: usize, e: impl Fn(usize) -> f64) -> f64 {
    let points = (from..=to).map(|m| ((m as f64).ln(), e(m).ln()));
    let n = points.clone().count() as f64;
    let mean = |of: fn((f64, f64)) -> f64| points.clone().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let (xy, xx) = (mean(|p| p.0 * p.1), mean(|p| p.0 * p.0));
    (xy - x * y) / (xx - x * x)
}

/// Waves whose powers follow a law, along x and in time, with a break.
#[test]
fn val_exact_power_laws_and_their_break() {
    let power = |m: usize| {
        let m = m as f64;
        0.3 * m.powf(-1.7) * if m > 40.0 { (m / 40.0).powf(-2.0) } else { 1.0 }
    };
    let values = Array2::from_shape_fn((12, 512), |(i, j)| {
        let angle = |m: usize| m as f64 * TAU * j as f64 / 512.0 + (i * m * m) as f64;
        let term = |m: usize| power(m).sqrt() * angle(m).cos();
        (1..128).map(term).sum::<f64>()
    });
    let along = stepped(values.clone(), 1.0, 0.5);
    let k = TAU / 256.0;
    let low = found(&along, [2.0 * k, 35.0 * k], "");
    let law = &low.law;
    assert_eq!((law.points, law.basis), (34, IntervalBasis::Regression));
    assert!(law.half < 1e-11 && low.breaks.is_none(), "{law:?}");
    near(low.compensated()[10], 1.0, 1e-12);
    let breaks = found(&along, [2.0 * k, 120.0 * k], "").breaks.unwrap();
    assert_eq!(breaks.at.len(), 1);
    near(breaks.at[0] / (40.0 * k), 1.0, 0.05);
    near(breaks.slopes[0], -1.7, 0.05);
    near(breaks.slopes[1], -3.7, 0.05);
    let in_time = stepped(values.t().to_owned(), 0.5, 1.0);
    let band = [2.0 / 256.0, 35.0 / 256.0];
    let in_time = found(&in_time, band, "axis=time segment=512");
    // A cosine of power p has p / 2 in one bin of the width 2 pi / L.
    for (found, bin) in [(low, k), (in_time, 1.0 / 256.0)] {
        near(found.law.slope, -1.7, 1e-12);
        near(found.spectrum[10] / (0.5 * power(10) / bin), 1.0, 1e-12);
    }
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
    let found = found(&fubini(1024, &times, 1.0, 0.0), [3.5, 40.5], "");
    let frames = found.frames.as_ref().unwrap();
    let steep = found.steepening.unwrap();
    near(steep.shock_time, 1.0, 5e-6f64.min(steep.half));
    lies(steep.half, 0.0..1e-4);
    let power =
        |t: f64| move |m: usize| (bessel_j(m as f64 * t, m + 1)[m] / (m as f64 * t)).powi(2);
    // Samples of a cube root alias a little.
    near(steep.slope_at_shock, regression(4, 40, power(1.0)), 0.003);
    near(steep.slope_at_shock, -8.0 / 3.0, 0.002);
    for i in [28, 32, 36] {
        let expected = regression(4, 40, power(times[i]));
        near(frames.slope[i] / expected, 1.0, 1e-6);
    }
    for (found, expected) in frames.time.iter().zip(&times) {
        near(*found, *expected, 1e-12);
    }
}

/// The interval of the shock time holds the exact one with noise from none to a hundredth, of several sizes and samplings.
#[test]
fn val_shock_times_are_in_their_intervals() {
    let (mut stated, mut inside) = (0, 0);
    let all = noise(80 * 48, 256);
    for (trial, noise) in all.axis_chunks_iter(Axis(0), 80).enumerate() {
        let (size, n) = ([0.3, 1.0, 2.7][trial % 3], [128, 256][trial / 3 % 2]);
        let level = [0.0, 1e-4, 1e-3, 1e-2][trial / 6 % 4];
        let times: Vec<f64> = (0..80).map(|i| f64::from(i) / 79.0 / size).collect();
        let exact = fubini(n, &times, size, 0.02 * trial as f64 - 0.5);
        let mut values = test_support::made::values(&exact);
        values.scaled_add(level * size, &noise.slice(s![.., ..n]));
        let field = stepped(values, exact.time.step, exact.space.step);
        let Some(steep) = found(&field, [3.5, 40.5], "").steepening else {
            continue;
        };
        stated += 1;
        inside += usize::from((steep.shock_time * size - 1.0).abs() < steep.half * size);
        lies(steep.half * size, 0.0..4.0 * level + 1e-3);
    }
    assert!(stated >= 46 && inside >= stated - 4, "{inside} of {stated}");
}

/// Burgers' equation with viscosity after the shock has formed: Fay's solution, with the amplitudes
/// `2 nu / sinh(nu m (1 + t))`, whose squares fall like `m^{-2}` where `nu m (1 + t)` is small.
#[test]
fn val_fay_after_the_shock_of_viscous_burgers() {
    let viscosity = 0.002;
    let times: Vec<f64> = (0..8).map(|i| 3.0 + 0.25 * f64::from(i)).collect();
    let amplitude = |t: f64, m: usize| 2.0 * viscosity / (viscosity * m as f64 * (1.0 + t)).sinh();
    let field = profiles(512, &times, |t, x| {
        let term = |m: usize| amplitude(t, m) * (m as f64 * x).sin();
        (1..256).map(term).sum()
    });
    let found = found(&field, [1.5, 20.5], "");
    let power = |m: usize| times.iter().map(|t| amplitude(*t, m).powi(2)).sum::<f64>();
    near(found.law.slope / regression(2, 20, power), 1.0, 1e-10);
    // From 2 to 20, where viscosity bends it by a hundredth.
    near(found.law.slope, -2.0, 0.008);
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
    let law = Law::Spring { alpha, beta: 0.0 };
    let chain = chain(vec![1.0; n], vec![1.0; n], law, Ends::Periodic);
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
    let steep = found(&field, [2.5 * k, 20.5 * k], "").steepening.unwrap();
    near(steep.shock_time / shock, 1.0, 0.003);
    near(steep.slope_at_shock, -8.0 / 3.0, 0.025);
    near(steep.slope_after, -2.0, 0.04);
    for after in steep.slope_after_range {
        near(after, -2.0, 0.12);
    }
}

/// White noise has the slope 0; intervals over shots hold it as often as stated.
#[test]
fn val_intervals_over_shots_hold() {
    let all = noise(40 * 6 * 4, 64);
    let mut trials = all.axis_chunks_iter(Axis(0), 6 * 4);
    hold(40, 35..=40, |_| {
        let trial = trials.next().unwrap();
        let shots = trial.axis_chunks_iter(Axis(0), 4);
        let shots = shots.map(|shot| Field::from_array(shot.to_owned()));
        let law = slope("band=0.2,3", &shots.collect::<Vec<_>>()).unwrap().law;
        assert_eq!(law.basis, IntervalBasis::Shots);
        law.slope.abs() < law.half
    });
}

/// So do those of the regression along time, where a window gives neighbouring bins a part in common.
#[test]
fn val_intervals_of_the_regression_hold() {
    let all = noise(1024 * 300, 1);
    let mut trials = all.axis_chunks_iter(Axis(0), 1024);
    hold(300, 276..=294, |_| {
        let field = Field::from_array(trials.next().unwrap().to_owned());
        let law = slope("axis=time band=0.02,0.48", [&field]).unwrap().law;
        assert_eq!(law.basis, IntervalBasis::Regression);
        law.slope.abs() < law.half
    });
}

#[test]
fn regress_snapshots_with_gaps_are_left_out() {
    let whole = noise(10, 64);
    let mut holed = concatenate![Axis(0), whole, noise(1, 64)];
    holed[[10, 7]] = f64::NAN;
    let [expected, found] = [whole, holed].map(|values| {
        let field = Field::from_array(values);
        slope("band=0.2,3 frames=1", [&field]).unwrap()
    });
    assert_eq!(found.left_out, 1);
    for (a, b) in found.spectrum.iter().zip(&expected.spectrum) {
        assert!((a / b - 1.0).abs() < 1e-13 || *b < 1e-20);
    }
}
