//! Stepping only where a force acts changes no bit.

use test_support::fields::{losses, spring};
use wavecascade::chain::{
    Accuracy, Chain, EndTime, Ends, Law, Record, Scheme, Simulation, SteppedSites,
};
use wavecascade::observer::Silent;

fn same_bits(name: &str, mut simulation: Simulation) {
    simulation.estimate_error = false;
    simulation.record = Record::ALL;
    simulation.window = SteppedSites::Whole;
    let whole = simulation.run(&Silent).unwrap();
    simulation.window = SteppedSites::Active;
    let active = simulation.run(&Silent).unwrap();
    assert!(active.report.cost.forces < whole.report.cost.forces);
    assert_eq!(active.report.cost.steps, whole.report.cost.steps, "{name}");
    let bits = |values: &ndarray::Array2<f64>| -> Vec<u64> {
        // Zeros of either sign are the same number.
        values.iter().map(|v| (v + 0.0).to_bits()).collect()
    };
    assert_eq!(bits(&active.velocity), bits(&whole.velocity));
    for (a, w) in [
        (&active.displacement, &whole.displacement),
        (&active.force, &whole.force),
        (&active.energy_passed, &whole.energy_passed),
    ] {
        assert_eq!(bits(a.as_ref().unwrap()), bits(w.as_ref().unwrap()));
    }
    if let (Some(a), Some(w)) = (&active.energy_lost, &whole.energy_lost) {
        assert_eq!(bits(a), bits(w));
    }
}

fn dimer(kappa: f64) -> Simulation {
    Simulation::impact(Chain::dimer(60, kappa), 1.0, 40.0, 50)
}

#[test]
fn val_whole_chain_dimers() {
    for kappa in [1.0, 2.398, 4.9272, 1631.0, 1e6] {
        for tolerance in [1e-3, 1e-7, 1e-11] {
            let mut simulation = dimer(kappa);
            simulation.accuracy = Accuracy::LocalError(tolerance);
            same_bits(&format!("{kappa} {tolerance}"), simulation);
        }
    }
}

#[test]
fn val_whole_chain_other_laws_and_schemes() {
    let mut power = dimer(3.0);
    power.chain.law = Law::Power { exponent: 2.5 }.into();
    let mut pressed = dimer(3.0);
    pressed.chain.precompression = 0.01;
    let mut linear = dimer(2.0);
    linear.chain.law = spring(0.0, 0.0).into();
    linear.end_time = EndTime::At(10.0);
    let mut free = dimer(4.9272);
    free.chain.ends = Ends::Free;
    free.chain.coefficient.pop();
    let mut lossy = dimer(2.0);
    lossy.scheme = Scheme::RungeKutta;
    lossy.chain.losses = losses([0.02, 0.01, 0.003]);
    for (name, simulation) in [
        ("power", power),
        ("pressed", pressed),
        ("linear", linear),
        ("free", free),
        ("lossy", lossy),
    ] {
        same_bits(name, simulation);
    }
    for scheme in [
        Scheme::VelocityVerlet,
        Scheme::Symplectic4,
        Scheme::Symplectic6,
    ] {
        let mut simulation = dimer(4.9272);
        simulation.scheme = scheme;
        simulation.accuracy = Accuracy::Step(0.02);
        same_bits(&format!("{scheme:?}"), simulation);
    }
}
