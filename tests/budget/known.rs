//! Budgets of chains whose energy exchange between wavenumbers is known from theory or literature.

use std::f64::consts::PI;

use test_support::fields::{chain, spring};
use test_support::measured::Normal;
use test_support::scenes::{largest, simulation, slope};
use wavecascade::arrays::LargeArray;
use wavecascade::chain::{Accuracy, Chain, EndTime, Ends, Scheme, Simulation};
use wavecascade::observer::Silent;

use crate::{budget_of, wavenumber_only};

/// Energy exchanged between wavenumbers in a strongly precompressed Hertz chain, relative to its
/// total energy, against the amplitude.
///
/// For overlaps r on a static overlap d the chain is alpha-FPUT to first order in r/d, so
/// `T = O((r/d) E)`. Three-wave exchange has a rate of first order in the amplitude. Without
/// resonance the energy returns, and the exchanged energy is of first order too.
#[test]
fn val_expansion_pressed_chains_approach_linear_ones_at_first_order() {
    let keys = "sites = 32\nends = 'periodic'\nprecompression = 1.0\nsamples = 401\nend_time = 40.0\nestimate_error = false";
    let exchanged = [1e-1, 1e-2, 1e-3, 1e-4].map(|amplitude| {
        let mut simulation = simulation(keys);
        let mut random = Normal(1);
        for value in simulation
            .displacement
            .iter_mut()
            .chain(&mut simulation.velocity)
        {
            *value = amplitude * random.between(-0.9, 0.9);
        }
        simulation.accuracy = Accuracy::LocalError(1e-11);
        let run = simulation.run(&Silent).unwrap();
        let (found, arrays) = budget_of(&run, &wavenumber_only());
        // T is proportional to the amplitude; its rounding error is not.
        let of = found.closure.identities;
        assert!(of.transfer_sum * amplitude < 1e-12, "{of:?}");
        let energy = &arrays[&LargeArray::ENERGY_SPECTRUM];
        let first = energy.row(0);
        let rows = energy.rows().into_iter();
        let moved = rows.map(|row| 0.5 * (&row - &first).mapv(f64::abs).sum());
        largest(moved) / first.sum()
    });
    for pair in exchanged.windows(2) {
        let order = (pair[0] / pair[1]).log10();
        assert!((order - 1.0).abs() < 0.1, "{exchanged:?}");
    }
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
    let sites = |of: &dyn Fn(f64) -> f64| Vec::from_iter((0..n).map(|j| of(k * j as f64)));
    let ones = vec![1.0; n];
    let ring: Chain = chain(ones.clone(), ones, spring(alpha, 0.0), Ends::Periodic);
    let mut simulation = Simulation {
        velocity: sites(&|x| -amplitude * frequency * x.cos()),
        displacement: sites(&|x| amplitude * x.sin()),
        scheme: Scheme::Symplectic6,
        accuracy: Accuracy::Step(1.0),
        estimate_error: false,
        end_time: EndTime::At(2.0 * shock),
        ..Simulation::impact(ring, 0.0, shock, 5)
    };
    (simulation.record.force, simulation.record.energy) = (false, false);
    let run = simulation.run(&Silent).unwrap();
    let (found, arrays) = budget_of(&run, &wavenumber_only());
    let energy = &arrays[&LargeArray::ENERGY_SPECTRUM];
    let falls = |i: usize| {
        let modes = (10..=80).map(|m| [(m as f64).ln(), energy[[i, m]].ln()]);
        slope(&modes.collect::<Vec<_>>())
    };
    let (at_shock, after) = (falls(2), falls(4));
    assert!((at_shock + 8.0 / 3.0).abs() < 0.03, "{at_shock}");
    assert!((after + 2.0).abs() < 0.1, "{after}");
    // The initial state is a single wave, which exchanges no energy.
    let transfer = &arrays[&LargeArray::TRANSFER];
    for row in transfer.rows().into_iter().skip(1) {
        assert!(row.sum().abs() < 1e-9 * largest(row), "{}", row.sum());
    }
    assert!(found.closure.identities.energy_sum < 1e-13);
    let totals = [0, 4].map(|i| energy.row(i).sum());
    assert!((totals[1] / totals[0] - 1.0).abs() < 1e-6);
}
