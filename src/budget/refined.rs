//! Power flow of chosen contacts from finely sampled records made inside the stepping.
//!
//! Forces open like `t^{3/2}`, so the sum of `P_j(f) df` converges to `W_j` with order 5/2 in the
//! time between samples, for every quadrature rule. The chain is therefore stepped again with many
//! more samples than the record has, and the energy passed is integrated inside the same steps. The
//! spectrum then extends far above the frequencies of the record, and its sum closes to the
//! stepping's error.

use column_fft::rows;

use super::balance::worst_of;
use super::contacts::{Contacts, PowerRow};
use super::frequency::RefinedFlow;
use super::request::BudgetRequest;
use super::result::Budget;
use super::stepped::instant;
use super::wavenumber::dot;
use crate::chain::{NodeState, Simulation};
use crate::error::Result;
use crate::numeric::count_at_or_below;
use crate::observer::Observer;
use crate::transform::{fold, frequencies};

/// Intervals between samples; a power of two less one, so that records have a fast length.
const INTERVALS: usize = (1 << 19) - 1;

/// Of the record whose low band ends at this frequency.
pub(super) fn refine(
    simulation: &Simulation,
    contacts: &Contacts,
    local_error: f64,
    request: &BudgetRequest,
    [edge, duration]: [f64; 2],
    observer: &dyn Observer,
) -> Result<Vec<RefinedFlow>> {
    let chosen = chosen(contacts, request);
    let samples = INTERVALS + 1;
    let mut records: Vec<[Vec<f64>; 2]> = chosen
        .iter()
        .map(|_| [0, 1].map(|_| Vec::with_capacity(samples)))
        .collect();
    let mut passed = vec![0.0; chosen.len()];
    let times: Vec<f64> = (0..samples)
        .map(|i| duration * (i as f64 / INTERVALS as f64))
        .collect();
    let mut row = PowerRow::default();
    let mut keep = |place: NodeState, followed: &[f64]| {
        let at = instant(0.0, place);
        for ((j, [force, speed]), passed) in chosen.iter().zip(&mut records).zip(&mut passed) {
            contacts.forces_and_speeds(*j..j + 1, at, &mut row);
            force.push(row.force[0]);
            speed.push(row.speed[0]);
            *passed = followed[*j];
        }
    };
    simulation.sampled(&times, &chosen, local_error, observer, &mut keep)?;
    let dt = duration / INTERVALS as f64;
    let (df, frequency) = (1.0 / (samples as f64 * dt), frequencies(samples, dt));
    let low_bins = count_at_or_below(&frequency, edge);
    let plan = rows::plan_fft_forward(samples);
    let mut work = plan.make_scratch_vec();
    let [mut of_force, mut of_speed] = [0, 1].map(|_| plan.make_output_vec());
    let mut flows = Vec::with_capacity(chosen.len());
    for ((contact, [mut force, mut speed]), passed) in chosen.into_iter().zip(records).zip(passed) {
        force[0] *= 0.5;
        force[samples - 1] *= 0.5;
        // The lengths are the plan's own, so these cannot fail.
        let _ = plan.process_with_scratch(&mut force, &mut of_force, &mut work);
        let _ = plan.process_with_scratch(&mut speed, &mut of_speed, &mut work);
        let spectra = of_force.iter().zip(&of_speed).enumerate();
        let power = spectra.map(|(bin, (f, v))| dt * dt * fold(bin, samples) * dot(*f, *v));
        let power: Vec<f64> = power.collect();
        let band = |power: &[f64]| df * crate::numeric::sum(power);
        flows.push(RefinedFlow {
            contact,
            low: band(&power[..low_bins]),
            high: band(&power[low_bins..]),
            passed,
        });
    }
    Ok(flows)
}

/// Puts refined flows, and their residual, in place of that of the samples.
pub(super) fn put_into(budget: &mut Budget, flows: Vec<RefinedFlow>) {
    let off = flows.iter().map(|of| (of.low + of.high - of.passed).abs());
    let off: Vec<f64> = off.collect();
    if !off.is_empty() {
        budget.closure.frequency = budget.relative(worst_of(0.0, &off));
    }
    if let Some(flow) = &mut budget.frequency {
        flow.refined = flows;
    }
}

/// The first, the middle and the last contact between two sites, and the requested ones.
fn chosen(contacts: &Contacts, request: &BudgetRequest) -> Vec<usize> {
    let count = contacts.chain().n_contacts();
    let joins = |j: &usize| matches!(contacts.sites(j + contacts.offset), [Some(_), Some(_)]);
    let inner: Vec<usize> = (0..count).filter(joins).collect();
    let Some(last) = inner.len().checked_sub(1) else {
        return Vec::new();
    };
    let usual = [inner[0], inner[last / 2], inner[last]];
    let asked = request.between.iter().flatten().copied().filter(joins);
    let mut chosen: Vec<usize> = usual.into_iter().chain(asked).collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}
