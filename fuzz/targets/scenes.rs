//! A scene, checked and run for a short while.

#![no_main]

use cascade_fuzz::{Deadline, is_small};
use libfuzzer_sys::fuzz_target;
use wavecascade::chain::scene::SceneSource;

fuzz_target!(|text: &str| {
    let Ok(setup) = SceneSource::new(None, text).setup() else {
        return;
    };
    let simulation = setup.simulation;
    if !is_small(simulation.samples, simulation.chain.n_sites()) {
        return;
    }
    if let Ok(run) = simulation.run(&Deadline::start()) {
        assert!(run.velocity.iter().all(|v| v.is_finite()));
    }
});
