//! The pass over time for coarse-grained energies and fluxes.

use rayon::prelude::*;

use super::balance::{RunningBalance, worst_of};
use super::contacts::Contacts;
use super::filter::Filter;
use super::motion::Motion;
use super::request::BudgetRequest;
use super::result::{Budget, Residual, ScaleBudget};
use super::scale::{PlannedFilter, Scales};
use super::scale_terms::{ScaleScratch, ScaleTerms};
use super::waiting::{ShownArray, Waiting};
use crate::arrays::{LargeArray, Sink};
use crate::chain::Chain;
use crate::error::{Error, Result};
use crate::numeric::sum;
use crate::observer::Observer;

/// Samples that are computed before they are added up in order.
const BATCH: usize = 64;

/// Adds the budget over scales to `budget`, or why the chain has none.
pub(super) fn pass(
    motion: &Motion,
    contacts: &Contacts,
    stated: &Chain,
    request: &BudgetRequest,
    sink: &dyn Sink,
    observer: &dyn Observer,
    budget: &mut Budget,
) -> Result<()> {
    let scales = match request.scales_of(contacts, stated) {
        Ok(scales) => scales,
        Err(Error::Request {
            expected, found, ..
        }) if request.scales.is_empty() && request.filter != Filter::Sharp => {
            budget.closure.scale =
                Residual::Undefined(format!("expected {expected}, found {found}"));
            return Ok(());
        }
        Err(error) => return Err(error),
    };
    let count = scales.scales.len();
    let (samples, m) = (motion.samples(), budget.n_contacts);
    let Some(mapped) = mapped(&scales, request.map_scale) else {
        let reason = "the chain is shorter than the reach of the smallest filter";
        budget.closure.scale = Residual::Undefined(reason.into());
        return Ok(());
    };
    let mut waiting = Waiting::default();
    waiting.reserve(
        sink,
        LargeArray::SCALE_FLUX,
        (samples, m),
        ShownArray::Extreme,
    )?;
    waiting.reserve(
        sink,
        LargeArray::SCALE_FLUX_IN_TIME,
        (samples, count),
        ShownArray::Not,
    )?;
    let mut balances = vec![RunningBalance::default(); count];
    let mut integrated = vec![0.0; count];
    // The last sample of the batch before, then the batch.
    let mut found = vec![vec![ScaleTerms::default(); count]; BATCH + 1];
    // Undefined where the filter reaches an end.
    let mut row = vec![f64::NAN; m];
    let mut sums = Vec::with_capacity(count);
    let dt = motion.step();
    observer.stage("scales", samples as u64);
    for first in (0..samples).step_by(BATCH) {
        observer.go_on()?;
        let batch = first..(first + BATCH).min(samples);
        found[1..=batch.len()]
            .par_iter_mut()
            .zip(batch.clone())
            .for_each_init(ScaleScratch::default, |scratch, (found, i)| {
                scales.load(motion.at(i), scratch);
                for (planned, terms) in scales.scales.iter().zip(found) {
                    scales.terms(planned, scratch, terms);
                }
            });
        for (i, pair) in batch.clone().zip(found.windows(2)) {
            let (before, terms) = (&pair[0], &pair[1]);
            sums.clear();
            sums.extend(terms.iter().map(|terms| sum(&terms.flux)));
            let weight = if i == 0 || i + 1 == samples {
                0.5 * dt
            } else {
                dt
            };
            for (scale, (before, now)) in before.iter().zip(terms).enumerate() {
                integrated[scale] += weight * sums[scale];
                if i > 0 {
                    balances[scale].trapezoid(dt, &before.energy_rate, &now.energy_rate);
                }
                balances[scale].compare(&now.energy);
            }
            row[scales.scales[mapped].contacts.clone()].copy_from_slice(&terms[mapped].flux);
            waiting.push(LargeArray::SCALE_FLUX, &row);
            waiting.push(LargeArray::SCALE_FLUX_IN_TIME, &sums);
        }
        found.swap(0, batch.len());
        waiting.hand_on(sink, batch.start)?;
        observer.advance(batch.len() as u64);
    }
    let worst: Vec<f64> = balances.iter().map(RunningBalance::worst).collect();
    budget.closure.scale = budget.relative(worst_of(0.0, &worst));
    let units = &budget.units;
    let (time, place) = (units.time(), units.position());
    let time = (&*time, budget.time[0], dt);
    let place = (&*place, 0.5 * budget.pitch, budget.pitch);
    let label = units.power("scale flux Π_l");
    let of_all = |planned: &PlannedFilter| [planned.contacts.start, planned.contacts.end];
    budget.scales = Some(ScaleBudget {
        scales: scales.scales.iter().map(|planned| planned.of).collect(),
        contacts: scales.scales.iter().map(of_all).collect(),
        integrated_flux: integrated,
        map_scale: scales.scales[mapped].of.scale,
        flux_map: waiting.map(LargeArray::SCALE_FLUX, label, time, place),
        residual: worst
            .iter()
            .map(|worst| Some(worst / budget.scale))
            .collect(),
    });
    Ok(())
}

/// The scale that is mapped: the nearest to the requested one, else the middle one.
fn mapped(scales: &Scales, asked: Option<f64>) -> Option<usize> {
    let count = scales.scales.len();
    let off = |i: &usize| asked.map_or(0.0, |l| (scales.scales[*i].of.scale / l).ln().abs());
    match asked {
        None => count.checked_sub(1).map(|last| last / 2),
        Some(_) => (0..count).min_by(|a, b| off(a).total_cmp(&off(b))),
    }
}
