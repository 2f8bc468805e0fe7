//! Energy that has passed each wavenumber: with losses at any sampling interval, and where it is
//! zero.

use ndarray::{Array2, s};
use test_support::scenes::{apart, largest};
use wavecascade::arrays::{Arrays, LargeArray};
use wavecascade::budget::{Budget, Direction, Integration};
use wavecascade::chain::Run;

use crate::{exact, integrated, wavenumber_only};

const DIMER: &str = "sites = 60\nstiffness_ratio = 2.398\n";
const LOSSES: &str = "dashpot = 0.02\ntangent = 0.03\ndrag = 0.01\n";

fn found(run: &Run, integration: Integration) -> (Budget, Arrays) {
    integrated(run, wavenumber_only(), integration)
}

fn share(budget: &Budget) -> f64 {
    let found = budget.wavenumber.as_ref().unwrap();
    found.passed_edge().unwrap() / budget.scale
}

/// Shares found by both integrations, and the directions.
fn both(run: &Run) -> [(f64, Direction); 2] {
    [Integration::Stepping, Integration::Samples].map(|integration| {
        let (budget, _) = found(run, integration);
        (share(&budget), budget.direction().unwrap())
    })
}

/// The integral follows the motion and does not depend on the samples. It vanishes at the largest k
/// and agrees with the energies, from which it is not computed.
#[test]
fn val_identity_losses_are_integrated_inside_the_stepping() {
    let passed = |arrays: &Arrays| arrays[&LargeArray::INTEGRATED_SPECTRAL_FLUX].clone();
    let [few, many] = [65, 2001].map(|samples| {
        let run = exact(&format!("{DIMER}{LOSSES}"), 50.0, samples);
        let (budget, arrays) = found(&run, Integration::Stepping);
        let array: Array2<f64> = passed(&arrays);
        let top = largest(array.column(array.ncols() - 1));
        let check = budget.closure.integrated_flux.unwrap();
        assert_eq!(top / budget.scale, check.at_largest_wavenumber);
        assert!(check.at_largest_wavenumber < 2e-14, "{check:?}");
        assert!(check.two_ways > 0.0 && check.two_ways < 2e-12, "{check:?}");
        let found = budget.wavenumber.as_ref().unwrap();
        let last = array.row(array.nrows() - 1);
        assert_eq!(last.to_vec(), found.integrated_flux);
        let half = array.row((array.nrows() - 1) / 2);
        assert_eq!((&last - &half).to_vec(), found.late_flux);
        assert_eq!(budget.direction().unwrap(), Direction::TowardsLowK);
        (share(&budget), array)
    });
    // Integrated over samples, the two shares were -0.040 and -0.061.
    assert!((few.0 - many.0).abs() < 2e-12, "{} {}", few.0, many.0);
    // 16 of 64 intervals last as long as 500 of 2000.
    let off = apart(few.1.slice(s![..;16, ..]), many.1.slice(s![..;500, ..]));
    assert!(off < 2e-12, "{off:e}");
}

/// The integral over samples converges to that of the stepping with the order of the trapezoid
/// rule: 2 for drag, 1 for dashpots, whose power jumps where a contact opens. The residual at the
/// largest k indicates the error.
#[test]
fn val_observed_order_of_losses_from_samples() {
    for (losses, orders, ratios) in [
        (LOSSES, 0.85..1.25, 0.5..5.0),
        ("drag = 0.01", 1.7..2.3, 0.5..20.0),
    ] {
        let run = |samples| exact(&format!("{DIMER}{losses}"), 50.0, samples);
        let truth = share(&found(&run(65), Integration::Stepping).0);
        let errors = [65, 501, 4001, 16001].map(|samples| {
            let (budget, _) = found(&run(samples), Integration::Samples);
            let check = budget.closure.integrated_flux.unwrap();
            let error = (share(&budget) - truth).abs();
            // The residual contains the whole loss, the error only the loss below the edge.
            let ratio = check.at_largest_wavenumber / error;
            assert!(ratios.contains(&ratio), "{samples} {error:e} {check:?}");
            let stated = budget.wavenumber.unwrap().passed_error;
            assert_eq!(stated / budget.scale, check.at_largest_wavenumber);
            error
        });
        let order = (errors[1] / errors[3]).log2() / 5.0;
        assert!(orders.contains(&order), "{order} {errors:?}");
    }
}

/// Without losses the two integrations agree to the departure of the stepping from the record.
#[test]
fn val_identity_without_losses_the_samples_are_exact() {
    let [(a, _), (b, _)] = both(&exact(DIMER, 50.0, 65));
    assert!((a - b).abs() < 2e-12, "{a} {b}");
}

/// Each wavenumber of a uniform linear chain keeps its energy: there is no direction.
#[test]
fn val_linear_chains_have_no_direction() {
    for ends in ["periodic", "fixed"] {
        for (samples, end) in [(9, 5.0), (257, 5.0), (9, 60.0), (257, 60.0)] {
            let run = exact(
                &format!("sites = 32\nlaw = 'spring'\nends = '{ends}'"),
                end,
                samples,
            );
            for (share, direction) in both(&run) {
                assert_eq!(direction, Direction::None, "{ends} {samples} {end}");
                assert!(share.abs() < 2e-12, "{ends} {samples} {end} {share:e}");
            }
        }
    }
}

/// A weak cubic term moves little energy, but in a definite direction and in proportion to beta.
#[test]
fn val_weak_nonlinearity_keeps_its_direction() {
    let shares = [1e-4, 1e-3].map(|beta| {
        let keys = format!("sites = 32\nlaw = 'spring'\nbeta = {beta}\nends = 'periodic'");
        let [(share, direction), _] = both(&exact(&keys, 30.0, 65));
        let definite = [Direction::TowardsHighK, Direction::TowardsLowK];
        assert!(definite.contains(&direction), "{beta}");
        share
    });
    assert!(shares[0].abs() < 1e-4, "{shares:?}");
    // The cubic force is linear in beta, and so is the first exchange of energy.
    assert!((shares[1] / shares[0] - 10.0).abs() < 0.5, "{shares:?}");
}
