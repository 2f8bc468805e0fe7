//! Budgets of simulated and of measured chains.

mod balance;
mod equipartition;
mod identities;
mod known;
mod measured;
mod measured_spectra;
mod passage;
mod states;
mod triads;

use test_support::changed;
use test_support::scenes::simulation;
use wavecascade::arrays::Arrays;
use wavecascade::budget::{Budget, BudgetRequest, Integration, Motion, Views, budget};
use wavecascade::chain::{Accuracy, Run};
use wavecascade::observer::Silent;

/// Chains of every end, law, loss and drive: name, end of a run, keys.
const CHAINS: &str = include_str!("../chain/chains.txt");

/// A run of a scene near rounding.
fn exact(keys: &str, end: f64, samples: usize) -> Run {
    let mut simulation = simulation(&format!("samples = {samples}\nend_time = {end:?}\n{keys}"));
    simulation.accuracy = Accuracy::LocalError(1e-12);
    simulation.estimate_error = false;
    simulation.run(&Silent).unwrap()
}

/// The request of the wavenumber budget alone.
fn wavenumber_only() -> BudgetRequest {
    let views = changed(Views::ALL, |it| (it.frequency, it.scale) = (false, false));
    changed(BudgetRequest::default(), |it| it.views = views)
}

fn budget_of(run: &Run, request: &BudgetRequest) -> (Budget, Arrays) {
    budget(&Motion::of(run).unwrap(), request).unwrap()
}

/// The budget whose rates are integrated so.
fn integrated(run: &Run, request: BudgetRequest, integration: Integration) -> (Budget, Arrays) {
    budget_of(run, &changed(request, |it| it.integration = integration))
}
