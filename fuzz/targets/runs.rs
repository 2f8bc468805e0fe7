//! A run file, and the budget of its motion.

#![no_main]

use cascade_fuzz::{file, is_small};
use libfuzzer_sys::fuzz_target;
use wavecascade::budget::{BudgetRequest, Motion, budget};
use wavecascade::report::RunFile;

fuzz_target!(|bytes: &[u8]| {
    let Ok(found) = RunFile::read(&file("run.npz", bytes)) else {
        return;
    };
    let run = &found.run;
    if !is_small(run.time.len(), run.chain.n_sites()) {
        return;
    }
    if let Ok(motion) = Motion::of(run) {
        let _ = budget(&motion, &BudgetRequest::default());
    }
});
