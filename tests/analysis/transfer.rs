//! Linear and quadratic transfer: known coefficients, errors that hold, Burgers' equation and chains against
//! their exact budgets, and laws without a quadratic expansion.

use std::f64::consts::{PI, TAU};

use ndarray::{Array2, ArrayView1, s};
use num_complex::Complex;
use test_support::changed;
use test_support::estimate::transfer;
use test_support::fields::{Congruential as Noise, chain, red, stepped};
use test_support::{lies, near, rms, worst};
use wavecascade::Field;
use wavecascade::arrays::LargeArray;
use wavecascade::budget::{BudgetRequest, Integration, Motion, Views, budget};
use wavecascade::chain::{Accuracy, Ends, Law, Record, Run, Simulation};
use wavecascade::estimates::Transfer;
use wavecascade::observer::Silent;
use wavecascade::sheet::Describe;

fn found(words: &str, values: Array2<f64>) -> Transfer {
    let words = format!("overlap=0 window=none {words}");
    transfer(&words, [&Field::from_array(values)]).unwrap()
}

/// Periods of `length` samples of random waves with frequencies 1 to `modes` over the period, and the output
/// of a law with noise.
fn periods(
    [length, count, modes]: [usize; 3],
    noise: f64,
    random: &mut Noise,
    law: impl Fn(f64) -> f64,
) -> Array2<f64> {
    let mut values = Array2::zeros((length * count, 2));
    for mut period in values.exact_chunks_mut((length, 2)) {
        let waves = random.white(modes, 2);
        for (n, mut row) in period.rows_mut().into_iter().enumerate() {
            let wave = |(m, wave): (usize, ArrayView1<f64>)| {
                let angle = TAU * ((m + 1) * n % length) as f64 / length as f64;
                wave[0] * angle.cos() + wave[1] * angle.sin()
            };
            row[0] = waves.outer_iter().enumerate().map(wave).sum();
            row[1] = law(row[0]) + noise * random.normal();
        }
    }
    values
}

/// `y = 0.8 x + 0.3 x^2`: L = 0.8 and Q = 0.3 at all pairs, and the balance closes.
#[test]
fn val_closed_form_coefficients() {
    let values = periods([32, 200, 6], 0.0, &mut Noise(5), |x| 0.8 * x + 0.3 * x * x);
    let found = found("segment=32 highest=0.375", values);
    assert_eq!((found.outputs.len(), found.unknowns), (12, 12));
    let inside = |f: f64| f.abs() < 6.5 / 32.0;
    for output in &found.outputs {
        let sum = output.input + output.linear + output.gain + output.residual;
        near(sum / output.output, 1.0, 1e-12);
        assert!(output.residual / output.output < 1e-12);
        if inside(output.frequency) {
            near(output.magnitude, 0.8, 1e-9);
            near(output.phase, 0.0, 1e-9);
            near(output.linear / output.input, 0.64 - 1.0, 1e-9);
        } else {
            // No input there, and none in differences that reach it.
            assert!(output.undetermined > 0);
        }
    }
    let mut pairs = 0;
    for pair in &found.pairs {
        let is_inside = inside(pair.first) && inside(pair.second);
        let expected = if is_inside { 0.3 } else { 0.0 };
        near((pair.re - expected).hypot(pair.im), 0.0, 1e-8);
        pairs += usize::from(is_inside);
    }
    assert_eq!(pairs, 36 + 6 - 15 - 3 + 12);
    let shares = &found.shares;
    assert!(found.holds() && shares.held_out_quadratic > 0.1);
    near(
        shares.held_out_linear + shares.held_out_quadratic,
        1.0,
        1e-9,
    );
}

/// Gains deviate from their expectation as far as their errors say, and nothing remains of what chance explains.
#[test]
fn val_errors_of_gains_hold() {
    let mut scores = Vec::new();
    for seed in 1..40 {
        let values = periods([16, 160, 7], 2.0, &mut Noise(seed), |x| 0.9 * x);
        let found = found("segment=16 highest=0.4375 resamplings=60", values);
        scores.extend(found.outputs.iter().map(|o| o.gain / o.gain_error));
        assert!(found.shares.held_out_quadratic < 0.0 || found.passage().is_none());
    }
    lies(rms(scores.iter().copied()), 0.55..0.75);
    near(scores.iter().sum::<f64>() / scores.len() as f64, 0.0, 0.25);
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

/// By the method of Runge and Kutta.
fn later(u: &[Complex<f64>], step: f64) -> Vec<Complex<f64>> {
    let plus = |k: &[Complex<f64>], h: f64| -> Vec<Complex<f64>> {
        u.iter().zip(k).map(|(u, k)| u + k * h).collect()
    };
    let a = tendency(u);
    let b = tendency(&plus(&a, step / 2.0));
    let c = tendency(&plus(&b, step / 2.0));
    let d = tendency(&plus(&c, step));
    let rate = (0..u.len()).map(|m| (a[m] + b[m] * 2.0 + c[m] * 2.0 + d[m]) / 6.0);
    plus(&rate.collect::<Vec<_>>(), step)
}

/// Nonlinear waves from random low frequencies, followed along x by Burgers' equation: what each frequency gains
/// between two sites is the exact transfer of the budget, within the errors, and so is the flux.
#[test]
fn val_burgers_transfer_is_that_of_the_budget() {
    let (samples, sites, shots, step) = (64, 9, 120, 2.5e-4);
    let mut random = Noise(9);
    let mut exact = [0.0; MODES + 1];
    let mut fields = Vec::new();
    for _ in 0..shots {
        let mut u = vec![Complex::default(); MODES + 1];
        for mode in &mut u[1..5] {
            *mode = Complex::new(random.normal(), random.normal()) * 0.08;
        }
        for _ in 0..40 {
            u = later(&u, 0.01);
        }
        let mut values = Array2::zeros((samples, sites));
        for (j, mut record) in values.columns_mut().into_iter().enumerate() {
            for (n, v) in record.iter_mut().enumerate() {
                let wave = |m: usize| {
                    let angle = TAU * ((m * n) % samples) as f64 / samples as f64;
                    2.0 * (u[m] * Complex::from_polar(1.0, angle)).re
                };
                *v = (1..=MODES).map(wave).sum();
            }
            // Simpson's rule along x; twice the energy, without what viscosity takes.
            let weight = [1.0, 4.0, 2.0, 4.0, 2.0, 4.0, 2.0, 4.0, 1.0][j];
            for (m, (u, rate)) in u.iter().zip(tendency(&u)).enumerate() {
                let lost = VISCOSITY * (m * m) as f64 * u.norm_sqr();
                let gain = (u.conj() * rate).re + lost;
                exact[m] += 4.0 * gain * weight * step / 3.0 / f64::from(shots);
            }
            u = later(&u, step);
        }
        fields.push(stepped(values, TAU / samples as f64, 1.0));
    }
    let highest = MODES as f64 / TAU;
    let words = format!("segment=64 overlap=0 window=none to=8 highest={highest}");
    let found = transfer(&words, &fields).unwrap();
    let df = found.outputs[0].frequency;
    let exact = &exact[1..];
    let largest = worst(exact.iter().map(|t| t.abs()));
    let off = found.outputs.iter().zip(exact);
    let off = off.map(|(found, t)| (found.gain * df - t).abs());
    lies(worst(off) / largest, 0.002..0.012);
    let flux = (1..=MODES).map(|m| -exact[..m].iter().sum::<f64>());
    let off = found.outputs.iter().zip(flux.clone());
    let off = worst(off.map(|(found, flux)| (found.flux - flux).abs()));
    lies(off / worst(flux.map(f64::abs)), 0.0..0.025);
    assert!(found.passage().unwrap().flux > 0.0 && found.holds());
    // Of the strongest pairs, Q = - i m s / 2 to first order.
    let distance = step * (sites - 1) as f64;
    let is_strong = |f: f64| f < 4.5 / TAU;
    let pairs = found.pairs.iter();
    for pair in pairs.filter(|p| is_strong(p.third) && is_strong(p.first)) {
        let expected = -0.5 * pair.third * TAU * distance;
        near((pair.im - expected).hypot(pair.re) / expected, 0.0, 0.1);
    }
}

/// Between samples of chains.
const STEP: f64 = 0.625;

/// A chain of 130 bodies of which the first are thrown, one shot a seed.
fn chain_run(precompression: f64, speed: f64, random: &mut Noise) -> Run {
    let n = 130;
    let mut chain = chain(vec![1.0; n], vec![1.0; n], Law::Hertz, Ends::default());
    chain.precompression = precompression;
    let mut velocity = vec![0.0; n];
    for _ in 0..3 {
        let (size, at) = (speed * random.normal(), 12.0 + 6.0 * random.uniform());
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

/// What each frequency gains between two sites of a precompressed chain is the difference of the power flow
/// through them, by the forces in the contacts, which the transfer does not know.
#[test]
fn val_precompressed_chains_against_the_power_flow() {
    let (shots, from, to) = (60, 46, 50);
    let mut random = Noise(21);
    let mut flow = vec![0.0; 65];
    let mut fields = Vec::new();
    for _ in 0..shots {
        let run = chain_run(1.0, 0.05, &mut random);
        let request = BudgetRequest {
            views: changed(Views::ALL, |it| {
                (it.wavenumber, it.scale) = (false, false);
            }),
            integration: Integration::Samples,
            ..BudgetRequest::default()
        };
        let (_, arrays) = budget(&Motion::of(&run).unwrap(), &request).unwrap();
        let power = &arrays[&LargeArray::POWER_FLOW];
        for (m, sum) in flow.iter_mut().enumerate() {
            let through = |site: usize| 0.5 * (power[[m, site - 1]] + power[[m, site]]);
            *sum += (through(to) - through(from)) / f64::from(shots);
        }
        fields.push(stepped(run.velocity, STEP, 1.0));
    }
    let words = "segment=128 overlap=0 window=none highest=0.2 resamplings=40 from=46 to=50";
    let found = transfer(words, &fields).unwrap();
    // Of a travelling wave in a chain of stiffness 3/2 the flow is this times the density of the velocity.
    let stiffness = 1.5f64;
    let impedance = |f: f64| {
        let highest = stiffness.sqrt() / PI;
        stiffness.sqrt() * (1.0 - (f / highest).powi(2)).sqrt() * 128.0 * STEP
    };
    let outputs = found.outputs.iter().zip(&flow[1..]);
    let outputs = outputs.map(|(output, flow)| (output, flow / impedance(output.frequency)));
    let largest = worst(outputs.clone().map(|(_, exact)| exact.abs()));
    // What waves lose to others at third order is in the linear term, see the guide.
    for (output, exact) in outputs.clone() {
        near(output.gain, exact, 0.7 * output.gain_error);
    }
    let off = outputs.clone().map(|(o, exact)| (o.gain - exact).abs());
    lies(worst(off) / largest, 0.1..0.2);
    let all = outputs.map(|(o, exact)| (o.gain + o.linear + o.residual - exact).abs());
    lies(worst(all) / largest, 0.05..0.15);
}

/// Under precompression weak waves have a quadratic expansion; without it they have none, and that is said.
#[test]
fn val_hertz_chains_with_and_without_precompression() {
    for (precompression, speed) in [(1.0, 0.05), (0.0, 0.3)] {
        let mut random = Noise(21);
        let shot = |_| {
            let velocity = chain_run(precompression, speed, &mut random).velocity;
            stepped(velocity.slice(s![.., 28..44]).to_owned(), STEP, 1.0)
        };
        let fields: Vec<Field> = (0..40).map(shot).collect();
        let words = "segment=128 overlap=0 window=none highest=0.2 resamplings=40 from=2 to=12";
        let found = transfer(words, &fields).unwrap();
        assert_eq!(found.holds(), precompression > 0.0);
    }
}

/// An odd law has no quadratic term: nothing is predicted, and nothing is said to pass.
#[test]
fn val_odd_law_fails_honestly() {
    let values = periods([32, 200, 6], 0.0, &mut Noise(5), |x| x * x.abs());
    let found = found("segment=32 highest=0.1875", values);
    assert!(!found.holds() && found.shares.held_out_quadratic < 0.0);
    let answer = found.describe().answer;
    let said = "no quadratic transfer is shown";
    assert!(answer.starts_with(said), "{answer}");
    assert!(found.shares.held_out_linear > 0.5);
}

/// A wave that is a few samples later at the output is aligned by the lag; threads do not matter.
#[test]
fn regress_lag_and_threads() {
    let (count, lag) = (6400, 9);
    let x = red(Noise(3).white(count + lag, 1), 0.6);
    let values = Array2::from_shape_fn((count, 2), |(n, j)| match j {
        0 => x[[n + lag, 0]],
        _ => x[[n, 0]] + 0.1 * x[[n, 0]].powi(2),
    });
    let field = Field::from_array(values);
    let of = |lag: usize, threads: usize| {
        let words = format!("lag={lag} threads={threads} resamplings=40");
        transfer(&words, [&field]).unwrap()
    };
    let (aligned, late) = (of(lag, 1), of(0, 1));
    assert_eq!(aligned.segment, [64, 32]);
    assert!(aligned.shares.held_out_linear > late.shares.held_out_linear + 0.1);
    assert!(aligned.holds());
    // A window that a product has twice: the coefficient is freed of it.
    let pairs = aligned.pairs.iter();
    let strong = pairs.filter(|p| p.first < 0.1 && p.third < 0.2);
    let sum: f64 = strong.clone().map(|p| p.re).sum();
    near(sum / strong.count() as f64, 0.1, 0.01);
    for threads in [2, 5] {
        let other = of(lag, threads);
        assert_eq!(other.outputs, aligned.outputs);
        assert_eq!(other.pairs, aligned.pairs);
    }
}
