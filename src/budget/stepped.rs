//! Integrals of rates inside the stepping: the chain is stepped anew from its first sample.

use super::contacts::Contacts;
use super::ledger::{Ledger, ScaleLedgers, energy_rates};
use super::modes::{Basis, Modes};
use super::motion::{Instant, Motion};
use super::request::BudgetRequest;
use super::result::{Budget, Integration};
use super::wavenumber::Transfers;
use crate::analyze::Observer;
use crate::chain::{Place, Scheme, Simulation, Visit};
use crate::error::Result;

/// Error of a velocity a step, relative to the velocity scale.
const LOCAL_ERROR: f64 = 1e-12;

/// Puts the residuals of integrals along the stepping in place of those from samples.
pub(super) fn close(
    motion: &Motion,
    contacts: &Contacts,
    request: &BudgetRequest,
    observer: &dyn Observer,
    budget: &mut Budget,
) -> Result<()> {
    let chain = motion.chain;
    let first = motion.at(0);
    let mut simulation = Simulation::impact(chain.clone(), 0.0, motion.duration(), 2);
    simulation.displacement = first.x.to_vec();
    simulation.velocity = first.v.to_vec();
    simulation.drive = motion.drive.copied();
    if chain.losses.any() {
        simulation.scheme = Scheme::RungeKutta;
    }
    let modes = Modes::new(Basis::of(chain.ends), chain.n_sites());
    let transfers = Transfers::new(contacts, modes, motion.drive.is_some());
    let mut scratch = transfers.scratch();
    let mut spectral = budget.wavenumber.is_some().then(Ledger::default);
    let scales = match &budget.scales {
        Some(_) => Some(request.scales_of(contacts)?),
        None => None,
    };
    let mut scaled = scales.as_ref().map(|scales| {
        let count = scales.scales.len();
        let mut chosen = vec![0, count / 2, count - 1];
        chosen.dedup();
        (scales, ScaleLedgers::new(scales), scales.scratch(), chosen)
    });
    let times: Vec<f64> = motion.time.iter().map(|t| t - motion.time[0]).collect();
    observer.stage("integrals inside the stepping", times.len() as u64);
    let mut visit = |visit: Visit, place: Place| {
        let at = Instant {
            t: motion.time[0] + place.t,
            x: place.x,
            v: place.v,
        };
        if let Some(ledger) = &mut spectral {
            let terms = transfers.evaluate(at, &mut scratch);
            match visit {
                Visit::Node(weight) => ledger.add(weight, energy_rates(&terms)),
                Visit::Sample => ledger.compare(&terms.energy),
            }
        }
        if let Some((scales, ledgers, scratch, chosen)) = &mut scaled {
            scales.load(at, scratch);
            for &scale in &*chosen {
                let terms = scales.terms(&scales.scales[scale], scratch);
                match visit {
                    Visit::Node(weight) => ledgers.add(scale, weight, &terms),
                    Visit::Sample => ledgers.compare(scale, &terms),
                }
            }
        }
    };
    simulation.along(&times, LOCAL_ERROR, observer, &mut visit)?;
    if let Some(ledger) = spectral {
        budget.closure.wavenumber = budget.relative(ledger.worst());
    }
    if let Some((_, ledgers, _, chosen)) = scaled {
        let worst = ledgers.worst();
        let found = chosen.iter().map(|&scale| worst[scale]);
        budget.closure.scale = budget.relative(found.clone().fold(0.0, f64::max));
        let size = budget.scale;
        if let Some(scales) = &mut budget.scales {
            scales.residual = vec![None; worst.len()];
            for (&scale, worst) in chosen.iter().zip(found) {
                scales.residual[scale] = Some(worst / size);
            }
        }
    }
    budget.closure.integration = Integration::Stepping;
    Ok(())
}
