//! Budgets of chains whose energy exchange between wavenumbers is known from theory or literature.

use std::f64::consts::PI;

use ndarray::{Array1, Array2};
use test_support::changed;
use test_support::fields::{fixed, spring};
use wavecascade::arrays::{Arrays, LargeArray};
use wavecascade::budget::{Budget, BudgetRequest, Motion, Views, budget};
use wavecascade::chain::scene::SceneSource;
use wavecascade::chain::{Accuracy, Chain, EndTime, Ends, Law, Record, Run, Scheme, Simulation};
use wavecascade::observer::Silent;

const LINEAR: Law = spring(0.0, 0.0);

fn chain(mass: Vec<f64>, coefficient: Vec<f64>, law: Law, ends: Ends, static_force: f64) -> Chain {
    let chain = test_support::fields::chain(mass, coefficient, law, ends);
    changed(chain, |it| it.precompression = static_force)
}

/// The wavenumber budget alone.
fn of(run: &Run) -> (Budget, Arrays) {
    let request = BudgetRequest {
        views: changed(Views::ALL, |it| (it.frequency, it.scale) = (false, false)),
        ..BudgetRequest::default()
    };
    budget(&Motion::of(run).unwrap(), &request).unwrap()
}

fn array(arrays: &Arrays, which: LargeArray) -> &Array2<f64> {
    &arrays[&which]
}

/// Numbers between -0.9 and 0.9 from a seed.
fn random(n: usize, seed: u64) -> Vec<f64> {
    let scene = format!("sites = {n}\nmass_spread = 0.9\nseed = {seed}");
    let setup = SceneSource::new(None, scene).setup().unwrap();
    setup
        .simulation
        .chain
        .mass
        .iter()
        .map(|x| x - 1.0)
        .collect()
}

/// Random states in place of a trajectory: budgets do not need one.
struct States {
    chain: Chain,
    time: Array1<f64>,
    displacement: Array2<f64>,
    velocity: Array2<f64>,
}

impl States {
    fn random(chain: Chain, count: usize) -> States {
        let n = chain.n_sites();
        let rows = |first: u64| {
            let values = (0..count as u64)
                .flat_map(|i| random(n, first + i))
                .collect();
            Array2::from_shape_vec((count, n), values).unwrap()
        };
        States {
            chain,
            time: Array1::from_iter((0..count).map(|i| i as f64)),
            displacement: rows(1000),
            velocity: rows(2000),
        }
    }

    fn budget(&self) -> (Budget, Arrays) {
        let motion = Motion {
            chain: &self.chain,
            drive: None,
            time: self.time.view(),
            displacement: self.displacement.view(),
            velocity: self.velocity.view(),
            resonators: None,
            energy_passed: None,
            energy_lost: None,
            energy_input: None,
        };
        budget(
            &motion,
            &BudgetRequest {
                views: Views {
                    wavenumber: true,
                    frequency: false,
                    scale: false,
                },
                ..BudgetRequest::default()
            },
        )
        .unwrap()
    }
}

/// In a uniform linear chain each wavenumber keeps its energy: `T(k) = 0`, for any state.
#[test]
fn val_linear_chains_exchange_nothing_between_wavenumbers() {
    for n in [3, 4, 31, 64, 101] {
        for ends in [Ends::Periodic, fixed(2.5)] {
            let states = States::random(chain(vec![0.7; n], vec![2.5; n], LINEAR, ends, 0.0), 6);
            let (_, arrays) = states.budget();
            let energy = array(&arrays, LargeArray::ENERGY_SPECTRUM);
            let transfer = array(&arrays, LargeArray::TRANSFER);
            // 2 sqrt(c / m) is the highest frequency: |q^| |f^| is at most that times the energy.
            let highest = 2.0 * f64::sqrt(2.5 / 0.7);
            let scale = highest * energy.iter().fold(0.0, |m: f64, e| m.max(*e));
            let worst = transfer.iter().fold(0.0, |m: f64, t| m.max(t.abs())) / scale;
            assert!(worst < 2e-15, "{n} {ends:?} {worst:e}");
        }
    }
}

/// A linear dimer mixes k with k + pi / a, but not its acoustic with its optical modes.
#[test]
fn val_linear_dimers_exchange_nothing_between_branches() {
    for (mass, coefficient) in [
        ([1.0, 1.0], [1.0, 4.9]),
        ([1.0, 3.0], [1.0, 1.0]),
        ([0.2, 3.0], [2.0, 0.5]),
    ] {
        let n = 64;
        let cell = |cell: [f64; 2]| cell.repeat(n / 2);
        let dimer = chain(cell(mass), cell(coefficient), LINEAR, Ends::Periodic, 0.0);
        let states = States::random(dimer, 6);
        let (found, arrays) = states.budget();
        let branches = found.wavenumber.unwrap().branches.unwrap();
        let transfer = array(&arrays, LargeArray::TRANSFER);
        for (i, optical) in branches.optical_transfer.iter().enumerate() {
            let exchanged: f64 = transfer.row(i).iter().map(|t| t.abs()).sum();
            assert!(
                exchanged > 0.01,
                "k and k + pi / a do exchange: {exchanged}"
            );
            assert!(
                optical.abs() < 1e-14 * exchanged,
                "{optical:e} of {exchanged:e}"
            );
            let energy = branches.optical_energy[i];
            assert!(energy > 0.1 * (found.kinetic[i] + found.contact[i]));
        }
    }
}

/// Energy exchanged between wavenumbers in a strongly precompressed Hertz chain, relative to its
/// total energy, against the amplitude.
///
/// For overlaps r on a static overlap d the chain is alpha-FPUT to first order in r/d, so
/// `T = O((r/d) E)`. Three-wave exchange has a rate of first order in the amplitude. Without
/// resonance the energy returns, and the exchanged energy is of first order too.
#[test]
fn val_expansion_pressed_chains_approach_linear_ones_at_first_order() {
    let n = 32;
    let amplitudes = [1e-1, 1e-2, 1e-3, 1e-4];
    let exchanged = amplitudes.map(|amplitude| {
        let pressed = chain(vec![1.0; n], vec![1.0; n], Law::Hertz, Ends::Periodic, 1.0);
        let scaled = |seed| random(n, seed).iter().map(|x| amplitude * x).collect();
        let simulation = Simulation {
            displacement: scaled(1),
            accuracy: Accuracy::LocalError(1e-11),
            estimate_error: false,
            ..Simulation::impact(pressed, 0.0, 40.0, 401)
        };
        let run = changed(simulation, |it| it.velocity = scaled(2))
            .run(&Silent)
            .unwrap();
        let (found, arrays) = of(&run);
        // T is proportional to the amplitude; its rounding error is not.
        let identities = found.closure.identities;
        assert!(
            identities.transfer_sum * amplitude < 1e-12,
            "{identities:?}"
        );
        let energy = array(&arrays, LargeArray::ENERGY_SPECTRUM);
        let first = energy.row(0);
        let total = first.sum();
        let moved = |i: usize| {
            (&energy.row(i) - &first)
                .iter()
                .map(|e| 0.5 * e.abs())
                .sum::<f64>()
        };
        (0..energy.nrows()).map(moved).fold(0.0, f64::max) / total
    });
    for pair in exchanged.windows(2) {
        let order = (pair[0] / pair[1]).log10();
        assert!((order - 1.0).abs() < 0.1, "{exchanged:?}");
    }
}

/// An FPUT chain between walls: `F = r + alpha r^2` of the elongation r.
fn fput(n: usize, alpha: f64, ends: Ends) -> Chain {
    chain(
        vec![1.0; n],
        vec![1.0; n],
        Law::Spring { alpha, beta: 0.0 },
        ends,
        0.0,
    )
}

/// M. Gallone, A. Ponno, S. Ruffo, *Energy cascade and Burgers turbulence in the
/// Fermi-Pasta-Ulam-Tsingou chain* (arXiv:2407.16534): from one long wave that travels, mode
/// energies fall as `k^{-8/3}` when the Burgers shock forms and as about `k^{-2}` within two shock
/// times.
///
/// Elongations r travel at speed `sqrt(1 + 2 alpha r)`. A one-way wave of energy `epsilon` per site
/// is `r = sqrt(2 epsilon) cos(k x)`. Its steepest point becomes a shock after
/// `1 / (alpha k sqrt(2 epsilon))`.
#[test]
fn val_gallone_ponno_ruffo_slopes_of_the_mode_energies() {
    let (n, epsilon, alpha): (usize, f64, f64) = (4096, 0.001, 1.0);
    let k = 2.0 * PI / n as f64;
    let frequency = 2.0 * (0.5 * k).sin();
    let amplitude = (2.0 * epsilon).sqrt() / frequency;
    let shock = 1.0 / (alpha * k * (2.0 * epsilon).sqrt());
    let place = |j: usize| k * j as f64;
    let simulation = Simulation {
        velocity: (0..n)
            .map(|j| -amplitude * frequency * place(j).cos())
            .collect(),
        displacement: (0..n).map(|j| amplitude * place(j).sin()).collect(),
        scheme: Scheme::Symplectic6,
        accuracy: Accuracy::Step(1.0),
        estimate_error: false,
        record: Record {
            displacement: true,
            force: false,
            energy: false,
        },
        end_time: EndTime::At(2.0 * shock),
        ..Simulation::impact(fput(n, alpha, Ends::Periodic), 0.0, shock, 5)
    };
    let run = simulation.run(&Silent).unwrap();
    let (found, arrays) = of(&run);
    let energy = array(&arrays, LargeArray::ENERGY_SPECTRUM);
    let slope = |i: usize, modes: std::ops::RangeInclusive<usize>| {
        let points: Vec<[f64; 2]> = modes
            .map(|m| [(m as f64).ln(), energy[[i, m]].ln()])
            .collect();
        let mean = |c: usize| points.iter().map(|p| p[c]).sum::<f64>() / points.len() as f64;
        let (x, y) = (mean(0), mean(1));
        let products = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>();
        products / points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>()
    };
    let (at_shock, after) = (slope(2, 10..=80), slope(4, 10..=80));
    assert!((at_shock + 8.0 / 3.0).abs() < 0.03, "{at_shock}");
    assert!((after + 2.0).abs() < 0.1, "{after}");
    let transfer = array(&arrays, LargeArray::TRANSFER);
    // The initial state is a single wave, which exchanges no energy.
    for row in transfer.rows().into_iter().skip(1) {
        let largest = row.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        assert!(row.sum().abs() < 1e-9 * largest, "{} {largest}", row.sum());
    }
    assert!(found.closure.identities.energy_sum < 1e-13);
    let total = energy.row(0).sum();
    assert!((energy.row(4).sum() / total - 1.0).abs() < 1e-6);
}
