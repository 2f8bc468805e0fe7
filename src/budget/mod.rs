//! Where the energy of a chain goes: four budgets, each with the residual of its balance.
//!
//! | budget | balance |
//! |---|---|
//! | real space | `de_j/dt = J_{j-1} - J_j - D_j` |
//! | wavenumber | `dE(k)/dt = T(k) - L(k)`, `sum T = 0`, `Pi(k) = - sum_{k' <= k} T(k')` |
//! | frequency | `sum P_j(f) df = W_j`, energy passed through contact j by the end |
//! | scale | `de_l/dt = J_{j-1} - J_j - (Pi_{j-1} + Pi_j) / 2 - D_j` of coarse-grained energies |
//!
//! Sums over sites and over k are identities that hold for any state. The balance over time
//! measures the numerical error: it compares the change of a quantity with the integral of its rate.
//!
//! Budgets need contact energies. They are computed from a [`Motion`], a chain with displacements
//! and velocities; a [`crate::Field`] of velocities alone is not enough.

mod arrays;
mod balance;
mod branches;
mod contacts;
mod equipartition;
mod filter;
mod frequency;
mod in_time;
pub mod measured;
mod modes;
mod motion;
mod place;
mod quadrature;
mod real_space;
mod request;
mod result;
mod rows;
mod scale;
mod scale_terms;
mod sheet;
mod spectral;
mod stepped;
mod sublattices;
mod triads;
mod units;
mod waiting;
mod wavenumber;

pub use equipartition::ModeBudget;
pub use filter::{Filter, ScaleOf};
pub(crate) use frequency::usual_pairs;
pub use frequency::{Between, FrequencyFlow, RefinedFlow};
pub use in_time::answer_of_run;
pub use modes::Basis;
pub use motion::Motion;
pub use request::{BudgetRequest, Views};
pub use result::{
    BranchBudget, Budget, Closure, Curves, Direction, Identities, IntegratedFluxCheck, Integration,
    LargestPassage, Residual, ScaleBudget, WavenumberBudget,
};
pub use sheet::ComparedBudgets;
pub use triads::{Locality, QuadraticLaw, TriadIdentities, Triads, TriadsRequest, chain_triads};
pub use units::BudgetUnits;

use crate::arrays::{Arrays, Sink};
use crate::chain::Chain;
use crate::error::Result;
use crate::observer::{Observer, Silent};
use contacts::Contacts;

/// Computes the budgets of a motion and collects the arrays over time in memory.
///
/// # Errors
/// As [`run`].
pub fn budget(motion: &Motion, request: &BudgetRequest) -> Result<(Budget, Arrays)> {
    let collect = crate::arrays::Collect::default();
    let budget = run(motion, request, &collect, &Silent)?;
    Ok((budget, collect.into_arrays()))
}

/// Computes the budgets of a motion; the arrays over time go to `sink` block by block.
///
/// # Errors
/// [`crate::Error::Request`] for arrays that do not fit the chain and for unsuitable scales;
/// [`crate::Error::Failed`]; [`crate::Error::Cancelled`] when the observer cancels; errors of the
/// sink.
pub fn run(
    motion: &Motion,
    request: &BudgetRequest,
    sink: &dyn Sink,
    observer: &dyn Observer,
) -> Result<Budget> {
    run_beside(motion, motion.chain, request, sink, observer)
}

/// As [`run`], with the unit cell and the branches of the chain `stated`. The chain of the motion
/// may be a perturbed copy of it, with other masses and coefficients.
fn run_beside(
    motion: &Motion,
    stated: &Chain,
    request: &BudgetRequest,
    sink: &dyn Sink,
    observer: &dyn Observer,
) -> Result<Budget> {
    motion.check()?;
    request.check(motion)?;
    crate::system::threads::in_pool(request.threads, || {
        let task = &Task {
            motion,
            contacts: &Contacts::of(motion),
            stated,
            request,
            sink,
            observer,
        };
        let mut budget = rows::pass(task)?;
        if request.views.frequency {
            let flow = frequency::power_flow(task)?;
            let off = |j: usize| (flow.passed(j) - budget.passed[j]).abs();
            let off: Vec<f64> = (0..budget.n_contacts).map(off).collect();
            budget.closure.frequency = match budget.followed {
                true => budget.relative(balance::worst_of(0.0, &off)),
                // Both sides would be the same sum over samples.
                false => Residual::Undefined("energy passed was not followed inside steps".into()),
            };
            budget.frequency = Some(flow);
        }
        if request.normal_modes {
            budget.modes = Some(equipartition::pass(task)?);
        }
        if request.integration == Integration::Stepping {
            stepped::close(task, &mut budget)?;
        }
        Ok(budget)
    })
}

/// What every pass works on.
struct Task<'a, 'm> {
    motion: &'a Motion<'m>,
    contacts: &'a Contacts<'m>,
    /// The chain whose unit cell and branches count.
    stated: &'a Chain,
    request: &'a BudgetRequest,
    sink: &'a dyn Sink,
    observer: &'a dyn Observer,
}
