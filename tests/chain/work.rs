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
            [422, 38, 187008, 77],
        ),
        (
            Scheme::RungeKutta,
            Accuracy::LocalError(1e-9),
            [537, 44, 355392, 77],
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
