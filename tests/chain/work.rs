//! The work of one run each of the schemes, so that a change of it is seen.

use wavecascade::chain::{Accuracy, Chain, Record, Scheme, Simulation};
use wavecascade::observer::Silent;

fn work(scheme: Scheme, accuracy: Accuracy) -> [u64; 4] {
    let mut simulation = Simulation::impact(Chain::dimer(60, 4.9272), 1.0, 50.0, 11);
    simulation.record = Record::default();
    simulation.estimate_error = false;
    simulation.scheme = scheme;
    simulation.accuracy = accuracy;
    let cost = simulation.run(&Silent).unwrap().report.cost;
    [
        cost.steps,
        cost.rejected_steps,
        cost.forces,
        cost.corrected_contacts,
    ]
}

#[test]
fn regress_work_of_every_scheme() {
    for (scheme, accuracy, expected) in [
        (
            Scheme::Nystrom,
            Accuracy::LocalError(1e-9),
            [465, 0, 191232, 77],
        ),
        (
            Scheme::RungeKutta,
            Accuracy::LocalError(1e-9),
            [594, 0, 367488, 77],
        ),
        (
            Scheme::VelocityVerlet,
            Accuracy::Step(0.02),
            [2500, 0, 130944, 0],
        ),
        (
            Scheme::Symplectic4,
            Accuracy::Step(0.1),
            [500, 0, 156528, 0],
        ),
        (
            Scheme::Symplectic6,
            Accuracy::Step(0.2),
            [250, 0, 144232, 0],
        ),
    ] {
        assert_eq!(work(scheme, accuracy), expected, "{scheme:?}");
    }
}

/// Chains whose contacts open and close all the time, at local errors near rounding.
#[test]
fn regress_few_steps_near_rounding_are_repeated() {
    for (kappa, expected) in [
        (2.0, [9386, 316, 8306624, 2480]),
        (8.0, [12783, 203, 16447808, 4778]),
    ] {
        let mut simulation = Simulation::impact(Chain::dimer(300, kappa), 1.0, 250.0, 2);
        simulation.record = Record::default();
        simulation.estimate_error = false;
        simulation.accuracy = Accuracy::LocalError(1e-13);
        let cost = simulation.run(&Silent).unwrap().report.cost;
        assert!(20 * cost.rejected_steps < cost.steps, "{kappa}: {cost:?}");
        let found = [
            cost.steps,
            cost.rejected_steps,
            cost.forces,
            cost.corrected_contacts,
        ];
        assert_eq!(found, expected, "{kappa}");
    }
}
