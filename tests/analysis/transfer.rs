//! Linear and quadratic transfer: known coefficients, errors that hold, Burgers' equation and chains against
//! their exact budgets, and laws without a quadratic expansion.

use std::f64::consts::TAU;

use ndarray::{Array2, s};
use num_complex::Complex;
use test_support::changed;
use test_support::fields::{Congruential, chain};
use wavecascade::Field;
use wavecascade::arrays::LargeArray;
use wavecascade::budget::{BudgetRequest, Integration, Motion, Views, budget};
use wavecascade::chain::{Accuracy, Ends, Law, Record, Run, Simulation};
use wavecascade::estimates::{Averaging, Tapers, Transfer, TransferRequest, transfer};
use wavecascade::observer::Silent;
use wavecascade::prepare::Window;
use wavecascade::sheet::Describe;

/// Nearly normal numbers, with variance 1.
struct Noise(Congruential);

impl Noise {
    fn new(seed: u64) -> Noise {
        Noise(Congruential(seed))
    }

    fn gaussian(&mut self) -> f64 {
        0.5 * self.0.gaussian()
    }
}

fn segments(length: usize) -> Averaging {
    Averaging {
        segment: Some(length),
        overlap: Some(0),
        tapers: Tapers::Window(Window::None),
        ..Averaging::default()
    }
}

fn request(length: usize, highest: f64) -> TransferRequest {
    TransferRequest {
        highest: Some(highest),
        averaging: segments(length),
        ..TransferRequest::default()
    }
}

fn found(values: Array2<f64>, request: &TransferRequest) -> Transfer {
    transfer(&[&Field::from_array(values)], request, &Silent).unwrap()
}

/// Periods of `length` samples of random waves with frequencies 1 to `modes` over the period, and the output
/// of a law with noise.
fn periods(
    [length, count, modes]: [usize; 3],
    noise: f64,
    random: &mut Noise,
    law: impl Fn(usize, f64) -> f64,
) -> Array2<f64> {
    let mut values = Array2::zeros((length * count, 2));
    for period in 0..count {
        let waves: Vec<[f64; 2]> = (0..modes)
            .map(|_| [random.gaussian(), random.gaussian()])
            .collect();
        for n in 0..length {
            let wave = |(m, [a, b]): (usize, &[f64; 2])| {
                let angle = TAU * ((m + 1) * n % length) as f64 / length as f64;
                a * angle.cos() + b * angle.sin()
            };
            let x: f64 = waves.iter().enumerate().map(wave).sum();
            values[[period * length + n, 0]] = x;
            values[[period * length + n, 1]] = law(period, x) + noise * random.gaussian();
        }
    }
    values
}

/// `y = 0.8 x + 0.3 x^2`: L = 0.8 and Q = 0.3 at all pairs, and the balance closes.
#[test]
fn val_closed_form_coefficients() {
    let law = |_: usize, x: f64| 0.8 * x + 0.3 * x * x;
    let values = periods([32, 200, 6], 0.0, &mut Noise::new(5), law);
    let found = found(values, &request(32, 12.0 / 32.0));
    assert_eq!((found.outputs.len(), found.unknowns), (12, 12));
    for output in &found.outputs {
        let sum = output.input + output.linear + output.gain + output.residual;
        assert!((sum / output.output - 1.0).abs() < 1e-12, "{output:?}");
        assert!(output.residual / output.output < 1e-12);
        if output.frequency < 6.5 / 32.0 {
            assert!((output.magnitude - 0.8).abs() < 1e-9 && output.phase.abs() < 1e-9);
            assert!(output.linear / output.input - (0.64 - 1.0) < 1e-9);
        } else {
            // No input there, and none in differences that reach it.
            assert!(output.undetermined > 0);
        }
    }
    let inside = |f: f64| f.abs() < 6.5 / 32.0;
    let mut pairs = 0;
    for pair in &found.pairs {
        let expected = if inside(pair.first) && inside(pair.second) {
            0.3
        } else {
            0.0
        };
        pairs += usize::from(expected > 0.0);
        let off = (pair.re - expected).hypot(pair.im);
        assert!(off < 1e-8, "{off:e} {pair:?}");
    }
    assert_eq!(pairs, 36 + 6 - 15 - 3 + 12);
    assert!(found.holds() && found.shares.held_out_quadratic > 0.1);
    assert!((found.shares.held_out_linear + found.shares.held_out_quadratic - 1.0).abs() < 1e-9);
}

/// Gains deviate from their expectation as far as their errors say, and nothing remains of what chance explains.
#[test]
fn val_errors_of_gains_hold() {
    let (length, count, modes) = (16, 160, 7);
    let (mut square, mut sum, mut trials) = (0.0f64, 0.0f64, 0.0f64);
    for seed in 1..40 {
        let mut random = Noise::new(seed);
        let values = periods([length, count, modes], 2.0, &mut random, |_, x| 0.9 * x);
        let request = changed(request(length, 7.0 / 16.0), |it| it.resamplings = 60);
        let found = found(values, &request);
        for output in &found.outputs {
            let score = output.gain / output.gain_error;
            square += score * score;
            sum += score;
            trials += 1.0;
        }
        assert!(found.shares.held_out_quadratic < 0.0 || found.passage().is_none());
    }
    let (rms, mean) = ((square / trials).sqrt(), sum / trials);
    assert!((0.55..0.75).contains(&rms), "{rms}");
    assert!(mean.abs() < 0.25, "{mean}");
}

/// Modes of a wave over a period: `u_s = - u u_theta + nu u_theta_theta`, with `|m|` up to `MODES`.
const MODES: usize = 20;
const VISCOSITY: f64 = 5e-3;

fn tendency(u: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let at = |m: isize| match m {
        0 => Complex::default(),
        m if m.unsigned_abs() > MODES => Complex::default(),
        m if m > 0 => u[m as usize],
        m => u[m.unsigned_abs()].conj(),
    };
    let all = MODES as isize;
    let of = |m: isize| {
        let sum: Complex<f64> = (m - all..=all).map(|p| at(p) * at(m - p)).sum();
        Complex::new(0.0, -0.5 * m as f64) * sum - u[m as usize] * (VISCOSITY * (m * m) as f64)
    };
    (0..=all).map(of).collect()
}

fn stepped(u: &[Complex<f64>], step: f64) -> Vec<Complex<f64>> {
    let plus = |k: &[Complex<f64>], h: f64| -> Vec<Complex<f64>> {
        u.iter().zip(k).map(|(u, k)| u + k * h).collect()
    };
    let a = tendency(u);
    let b = tendency(&plus(&a, step / 2.0));
    let c = tendency(&plus(&b, step / 2.0));
    let d = tendency(&plus(&c, step));
    let rate: Vec<Complex<f64>> = (0..u.len())
        .map(|m| (a[m] + b[m] * 2.0 + c[m] * 2.0 + d[m]) / 6.0)
        .collect();
    plus(&rate, step)
}

/// Nonlinear waves from random low frequencies, followed along x by Burgers' equation: what each frequency gains
/// between two sites is the exact transfer of the budget, within the errors, and so is the flux.
#[test]
fn val_burgers_transfer_is_that_of_the_budget() {
    let (samples, sites, shots, step) = (64, 9, 120, 2.5e-4);
    let mut random = Noise::new(9);
    let mut exact = [0.0; MODES + 1];
    let mut fields = Vec::new();
    for _ in 0..shots {
        let mut u = vec![Complex::default(); MODES + 1];
        for mode in u.iter_mut().take(5).skip(1) {
            *mode = Complex::new(random.gaussian(), random.gaussian()) * 0.08;
        }
        for _ in 0..40 {
            u = stepped(&u, 0.01);
        }
        let mut values = Array2::zeros((samples, sites));
        for j in 0..sites {
            for n in 0..samples {
                let wave = |m: usize| {
                    let angle = TAU * ((m * n) % samples) as f64 / samples as f64;
                    2.0 * (u[m] * Complex::from_polar(1.0, angle)).re
                };
                values[[n, j]] = (1..=MODES).map(wave).sum();
            }
            // Simpson's rule along x; twice the energy, without what viscosity takes.
            let weight = match j {
                0 | 8 => 1.0,
                j if j % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let gains = u.iter().zip(tendency(&u)).enumerate();
            for (m, (u, rate)) in gains {
                let lost = VISCOSITY * (m * m) as f64 * u.norm_sqr();
                let gain = (u.conj() * rate).re + lost;
                exact[m] += 4.0 * gain * weight * step / 3.0 / f64::from(shots);
            }
            u = stepped(&u, step);
        }
        let mut field = Field::from_array(values);
        field.time.step = TAU / samples as f64;
        fields.push(field);
    }
    let all: Vec<&Field> = fields.iter().collect();
    let request = changed(request(samples, MODES as f64 / TAU), |it| it.to = sites - 1);
    let found = transfer(&all, &request, &Silent).unwrap();
    let df = found.outputs[0].frequency;
    let largest = exact.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
    let (mut worst, mut flux, mut worst_flux) = (0.0f64, 0.0, 0.0f64);
    let mut largest_flux = 0.0f64;
    for (m, output) in found.outputs.iter().enumerate() {
        let gain = output.gain * df;
        worst = worst.max((gain - exact[m + 1]).abs() / largest);
        flux -= exact[m + 1];
        largest_flux = largest_flux.max(flux.abs());
        worst_flux = worst_flux.max((output.flux - flux).abs());
    }
    assert!((0.002..0.012).contains(&worst), "{worst}");
    assert!(worst_flux / largest_flux < 0.025);
    let passage = found.passage().unwrap();
    assert!(passage.flux > 0.0 && found.holds());
    // Of the strongest pairs, Q = - i m s / 2 to first order.
    let distance = step * (sites - 1) as f64;
    for pair in found
        .pairs
        .iter()
        .filter(|p| p.third < 4.5 / TAU && p.first < 4.5 / TAU)
    {
        let expected = -0.5 * pair.third * TAU * distance;
        let off = (pair.im - expected).hypot(pair.re) / expected.abs();
        assert!(off < 0.1, "{off} {pair:?}");
    }
}

/// Between samples of chains.
const STEP: f64 = 0.625;

/// A chain of 130 bodies of which the first are thrown, one shot a seed.
fn chain_run(precompression: f64, speed: f64, random: &mut Noise) -> Run {
    let n = 130;
    let chain = changed(
        chain(vec![1.0; n], vec![1.0; n], Law::Hertz, Ends::default()),
        |it| it.precompression = precompression,
    );
    let mut velocity = vec![0.0; n];
    for _ in 0..3 {
        let (size, at) = (speed * random.gaussian(), 12.0 + 6.0 * random.0.uniform());
        for (j, v) in velocity.iter_mut().enumerate().take(40) {
            *v += size * (-((j as f64 - at) / 3.0).powi(2)).exp();
        }
    }
    let simulation = Simulation {
        velocity,
        estimate_error: false,
        accuracy: Accuracy::Tolerance(1e-7),
        record: Record::ALL,
        ..Simulation::impact(chain, 0.0, 127.0 * STEP, 128)
    };
    simulation.run(&Silent).unwrap()
}

fn chain_shot(precompression: f64, speed: f64, random: &mut Noise) -> Field {
    let run = chain_run(precompression, speed, random);
    let mut field = Field::from_array(run.velocity.slice(s![.., 28..44]).to_owned());
    field.time.step = STEP;
    field
}

/// What each frequency gains between two sites of a precompressed chain is the difference of the power flow
/// through them, by the forces in the contacts, which the transfer does not know.
#[test]
fn val_precompressed_chains_against_the_power_flow() {
    let (shots, from, to) = (60, 46, 50);
    let mut random = Noise::new(21);
    let mut flow = vec![0.0; 65];
    let mut fields = Vec::new();
    for _ in 0..shots {
        let run = chain_run(1.0, 0.05, &mut random);
        let request = BudgetRequest {
            views: Views {
                wavenumber: false,
                frequency: true,
                scale: false,
            },
            integration: Integration::Samples,
            ..BudgetRequest::default()
        };
        let (_, arrays) = budget(&Motion::of(&run).unwrap(), &request).unwrap();
        let power = &arrays[&LargeArray::POWER_FLOW];
        for (m, sum) in flow.iter_mut().enumerate() {
            let through = |site: usize| 0.5 * (power[[m, site - 1]] + power[[m, site]]);
            *sum += (through(to) - through(from)) / f64::from(shots);
        }
        let mut field = Field::from_array(run.velocity.to_owned());
        field.time.step = STEP;
        fields.push(field);
    }
    let all: Vec<&Field> = fields.iter().collect();
    let request = TransferRequest {
        from,
        to,
        resamplings: 40,
        ..request(128, 0.2)
    };
    let found = transfer(&all, &request, &Silent).unwrap();
    // Of a travelling wave in a chain of stiffness 3/2 the flow is this times the density of the velocity.
    let stiffness = 1.5f64;
    let impedance = |f: f64| {
        let highest = stiffness.sqrt() / std::f64::consts::PI;
        stiffness.sqrt() * (1.0 - (f / highest).powi(2)).sqrt() * 128.0 * STEP
    };
    let outputs = found.outputs.iter().zip(&flow[1..]);
    let exact: Vec<f64> = outputs.map(|(o, p)| p / impedance(o.frequency)).collect();
    let largest = exact.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
    let (mut worst, mut changed, mut scores) = (0.0f64, 0.0f64, 0.0f64);
    for (output, exact) in found.outputs.iter().zip(&exact) {
        worst = worst.max((output.gain - exact).abs() / largest);
        scores = scores.max((output.gain - exact).abs() / output.gain_error);
        let all = output.gain + output.linear + output.residual;
        changed = changed.max((all - exact).abs() / largest);
    }
    // What waves lose to others at third order is in the linear term, see the guide.
    assert!((0.1..0.2).contains(&worst), "{worst}");
    assert!(scores < 0.7, "{scores}");
    assert!((0.05..0.15).contains(&changed), "{changed}");
}

/// Under precompression weak waves have a quadratic expansion; without it they have none, and that is said.
#[test]
fn val_hertz_chains_with_and_without_precompression() {
    for (precompression, speed) in [(1.0, 0.05), (0.0, 0.3)] {
        let mut random = Noise::new(21);
        let fields: Vec<Field> = (0..40)
            .map(|_| chain_shot(precompression, speed, &mut random))
            .collect();
        let all: Vec<&Field> = fields.iter().collect();
        let request = TransferRequest {
            from: 2,
            to: 12,
            resamplings: 40,
            ..request(128, 0.2)
        };
        let found = transfer(&all, &request, &Silent).unwrap();
        if precompression > 0.0 {
            assert!(found.holds());
        } else {
            assert!(!found.holds());
        }
    }
}

/// An odd law has no quadratic term: nothing is predicted, and nothing is said to pass.
#[test]
fn val_odd_law_fails_honestly() {
    let values = periods([32, 200, 6], 0.0, &mut Noise::new(5), |_, x| x * x.abs());
    let found = found(values, &request(32, 6.0 / 32.0));
    assert!(!found.holds() && found.shares.held_out_quadratic < 0.0);
    assert!(
        found
            .describe()
            .answer
            .starts_with("no quadratic transfer is shown")
    );
    assert!(found.shares.held_out_linear > 0.5);
}

/// A wave that is a few samples later at the output is aligned by the lag; threads do not matter.
#[test]
fn regress_lag_and_threads() {
    let mut random = Noise::new(3);
    let (count, lag) = (6400, 9);
    let mut x = vec![0.0; count + lag];
    for n in 1..count + lag {
        x[n] = 0.6 * x[n - 1] + random.gaussian();
    }
    let values = Array2::from_shape_fn((count, 2), |(n, j)| match j {
        0 => x[n + lag],
        _ => x[n] + 0.1 * x[n] * x[n],
    });
    let field = Field::from_array(values);
    let of = |lag, threads| {
        let request = TransferRequest {
            lag,
            threads: Some(threads),
            resamplings: 40,
            ..TransferRequest::default()
        };
        transfer(&[&field], &request, &Silent).unwrap()
    };
    let (aligned, late) = (of(lag, 1), of(0, 1));
    assert_eq!(aligned.segment, [64, 32]);
    assert!(aligned.shares.held_out_linear > late.shares.held_out_linear + 0.1);
    assert!(aligned.holds());
    // A window that a product has twice: the coefficient is freed of it.
    let strong: Vec<f64> = aligned
        .pairs
        .iter()
        .filter(|p| p.first < 0.1 && p.third < 0.2)
        .map(|p| p.re)
        .collect();
    let mean = strong.iter().sum::<f64>() / strong.len() as f64;
    assert!((mean - 0.1).abs() < 0.01, "{mean}");
    for threads in [2, 5] {
        let other = of(lag, threads);
        assert_eq!(other.outputs, aligned.outputs);
        assert_eq!(other.pairs, aligned.pairs);
    }
}
