//! Energy that has passed each wavenumber: with losses at any sampling interval, and where it is
//! zero.

use test_support::changed;
use test_support::fields::{chain, fixed, losses, spring};
use wavecascade::arrays::{Arrays, LargeArray};
use wavecascade::budget::{Budget, BudgetRequest, Direction, Integration, Motion, Views, budget};
use wavecascade::chain::{Accuracy, Chain, Ends, Law, Losses, Record, Run, Scheme, Simulation};
use wavecascade::observer::Silent;

fn run(chain: Chain, end: f64, samples: usize) -> Run {
    let mut simulation = Simulation::impact(chain, 1.0, end, samples);
    simulation.accuracy = Accuracy::LocalError(1e-12);
    simulation.estimate_error = false;
    simulation.record = Record::ALL;
    if simulation.chain.losses.any() {
        simulation.scheme = Scheme::RungeKutta;
    }
    simulation.run(&Silent).unwrap()
}

fn found(run: &Run, integration: Integration) -> (Budget, Arrays) {
    let request = BudgetRequest {
        views: changed(Views::ALL, |it| (it.frequency, it.scale) = (false, false)),
        integration,
        ..BudgetRequest::default()
    };
    budget(&Motion::of(run).unwrap(), &request).unwrap()
}

fn share(budget: &Budget) -> f64 {
    let found = budget.wavenumber.as_ref().unwrap();
    found.passed_edge().unwrap() / budget.scale
}

fn direction(budget: &Budget) -> Direction {
    budget.direction().unwrap()
}

fn lossy() -> Chain {
    Chain {
        losses: losses([0.02, 0.03, 0.01]),
        ..Chain::dimer(60, 2.398)
    }
}

/// The integral follows the motion and does not depend on the samples. It vanishes at the largest k
/// and agrees with the energies, from which it is not computed.
#[test]
fn val_identity_losses_are_integrated_inside_the_stepping() {
    let [coarse, fine] = [65, 2001].map(|samples| run(lossy(), 50.0, samples));
    let [(few, few_arrays), (many, many_arrays)] =
        [&coarse, &fine].map(|run| found(run, Integration::Stepping));
    // Integrated over samples, the two shares were -0.040 and -0.061.
    let share = share(&few) - share(&many);
    assert!(share.abs() < 2e-12, "{share:e}");
    let rows = |arrays: &Arrays, every: usize| {
        let array = &arrays[&LargeArray::INTEGRATED_SPECTRAL_FLUX];
        array.slice(ndarray::s![..;every, ..]).to_owned()
    };
    // 16 of 64 intervals last as long as 500 of 2000.
    let off = rows(&few_arrays, 16) - rows(&many_arrays, 500);
    let worst = off.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    assert!(worst < 2e-12, "{worst:e}");
    for (budget, arrays) in [(&few, &few_arrays), (&many, &many_arrays)] {
        let array = &arrays[&LargeArray::INTEGRATED_SPECTRAL_FLUX];
        let top = array.column(array.ncols() - 1);
        let top = top.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let check = budget.closure.integrated_flux.unwrap();
        assert_eq!(top / budget.scale, check.at_largest_wavenumber);
        assert!(check.at_largest_wavenumber < 2e-14, "{check:?}");
        assert!(check.two_ways > 0.0 && check.two_ways < 2e-12, "{check:?}");
        let found = budget.wavenumber.as_ref().unwrap();
        let last = array.row(array.nrows() - 1);
        assert_eq!(last.to_vec(), found.integrated_flux);
        let half = array.row((array.nrows() - 1) / 2);
        assert_eq!((&last - &half).to_vec(), found.late_flux);
        assert_eq!(direction(budget), Direction::TowardsLowK);
    }
}

/// The integral over samples converges to that of the stepping with the order of the trapezoid
/// rule: 2 for drag, 1 for dashpots, whose power jumps where a contact opens. The residual at the
/// largest k indicates the error.
#[test]
fn val_observed_order_of_losses_from_samples() {
    let drag = changed(Losses::default(), |it| it.drag = 0.01);
    for (losses, orders, ratios) in [
        (lossy().losses, 0.85..1.25, 0.5..5.0),
        (drag, 1.7..2.3, 0.5..20.0),
    ] {
        let chain = Chain { losses, ..lossy() };
        let truth = share(&found(&run(chain.clone(), 50.0, 65), Integration::Stepping).0);
        let mut errors = Vec::new();
        for samples in [65, 501, 4001, 16001] {
            let (budget, _) = found(&run(chain.clone(), 50.0, samples), Integration::Samples);
            let check = budget.closure.integrated_flux.unwrap();
            let error = (share(&budget) - truth).abs();
            // The residual contains the whole loss, the error only the loss below the edge.
            let ratio = check.at_largest_wavenumber / error;
            assert!(ratios.contains(&ratio), "{samples} {error:e} {check:?}");
            let stated = budget.wavenumber.unwrap().passed_error;
            assert_eq!(stated / budget.scale, check.at_largest_wavenumber);
            errors.push(error);
        }
        let order = (errors[1] / errors[3]).log2() / 5.0;
        assert!(orders.contains(&order), "{order} {errors:?}");
    }
}

/// Without losses the two integrations agree to the departure of the stepping from the record.
#[test]
fn val_identity_without_losses_the_samples_are_exact() {
    let run = run(Chain::dimer(60, 2.398), 50.0, 65);
    let shares = [Integration::Stepping, Integration::Samples]
        .map(|integration| share(&found(&run, integration).0));
    assert!((shares[0] - shares[1]).abs() < 2e-12, "{shares:?}");
}

fn uniform(law: Law, ends: Ends) -> Chain {
    let n = 32;
    chain(vec![1.0; n], vec![1.0; n], law, ends)
}

/// Each wavenumber of a uniform linear chain keeps its energy: there is no direction.
#[test]
fn val_linear_chains_have_no_direction() {
    let linear = spring(0.0, 0.0);
    for ends in [Ends::Periodic, fixed(1.0)] {
        for samples in [9, 257] {
            for end in [5.0, 60.0] {
                let run = run(uniform(linear.clone(), ends), end, samples);
                for integration in [Integration::Stepping, Integration::Samples] {
                    let (budget, _) = found(&run, integration);
                    let case = format!("{ends:?} {samples} {end} {integration:?}");
                    assert_eq!(direction(&budget), Direction::None, "{case}");
                    assert!(share(&budget).abs() < 2e-12, "{case} {:e}", share(&budget));
                }
            }
        }
    }
}

/// A weak cubic term moves little energy, but in a definite direction and in proportion to beta.
#[test]
fn val_weak_nonlinearity_keeps_its_direction() {
    let shares = [1e-4, 1e-3].map(|beta| {
        let chain = uniform(Law::Spring { alpha: 0.0, beta }, Ends::Periodic);
        let (budget, _) = found(&run(chain, 30.0, 65), Integration::Stepping);
        assert!(
            matches!(
                direction(&budget),
                Direction::TowardsHighK | Direction::TowardsLowK
            ),
            "{beta}"
        );
        share(&budget)
    });
    assert!(shares[0].abs() < 1e-4, "{shares:?}");
    // The cubic force is linear in beta, and so is the first exchange of energy.
    assert!((shares[1] / shares[0] - 10.0).abs() < 0.5, "{shares:?}");
}
