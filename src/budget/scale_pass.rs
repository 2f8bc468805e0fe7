//! The pass over time for coarse-grained energies and fluxes.

use super::balance::{RunningBalance, add, worst_of};
use super::contacts::Contacts;
use super::filter::Filter;
use super::motion::Motion;
use super::request::BudgetRequest;
use super::result::{Budget, Residual, ScaleBudget};
use super::scale::{PlannedFilter, Scales};
use super::scale_terms::{ScaleScratch, ScaleTerms};
use super::waiting::Waiting;
use crate::arrays::{LargeArray, Sink};
use crate::chain::Chain;
use crate::diagnostics::Keep;
use crate::error::{Error, Result};
use crate::numeric::sum;
use crate::observer::Observer;

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
    let scales = match Scales::new(contacts, stated, request) {
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
    let mapped = mapped(&scales, request.map_scale);
    let mut waiting = Waiting::new(sink);
    let shown = Some(Keep::Extreme);
    waiting.reserve(LargeArray::SCALE_FLUX, (samples, m), shown)?;
    waiting.reserve(LargeArray::SCALE_FLUX_IN_TIME, (samples, count), None)?;
    let mut balances = vec![RunningBalance::default(); count];
    let mut integrated = vec![0.0; count];
    // Undefined where the filter reaches an end.
    let mut row = vec![f64::NAN; m];
    observer.stage("scales", samples as u64);
    waiting.each_sample(
        samples,
        observer,
        vec![ScaleTerms::default(); count],
        ScaleScratch::default,
        |scratch, i, found| {
            scales.load(motion.at(i), scratch);
            for (planned, terms) in scales.scales.iter().zip(found) {
                scales.terms(planned, scratch, terms);
            }
        },
        |waiting, i, found| {
            let halves = motion.halves(i);
            let sums: Vec<f64> = found.iter().map(|terms| sum(&terms.flux)).collect();
            add(&mut integrated, halves[0] + halves[1], &sums);
            for (balance, terms) in balances.iter_mut().zip(found) {
                balance.sample(halves, &terms.energy_rate, &terms.energy);
            }
            row[scales.scales[mapped].contacts.clone()].copy_from_slice(&found[mapped].flux);
            waiting.push(LargeArray::SCALE_FLUX, &row);
            waiting.push(LargeArray::SCALE_FLUX_IN_TIME, &sums);
        },
    )?;
    let worst: Vec<f64> = balances.iter().map(RunningBalance::worst).collect();
    budget.closure.scale = budget.relative(worst_of(0.0, &worst));
    let units = &budget.units;
    let (time, place) = (units.time(), units.position());
    let time = (&*time, budget.time[0], motion.step());
    let place = (&*place, 0.5 * budget.pitch, budget.pitch);
    let label = units.power("scale flux Π_l");
    let of_all = |planned: &PlannedFilter| [planned.contacts.start, planned.contacts.end];
    budget.scales = Some(ScaleBudget {
        scales: scales.scales.iter().map(|planned| planned.of).collect(),
        contacts: scales.scales.iter().map(of_all).collect(),
        integrated_flux: integrated,
        map_scale: scales.scales[mapped].of.scale,
        flux_map: Some(waiting.map(LargeArray::SCALE_FLUX, label, time, place)),
        residual: worst
            .iter()
            .map(|worst| Some(worst / budget.scale))
            .collect(),
    });
    Ok(())
}

/// The scale that is mapped: the nearest to the requested one, else the middle one.
fn mapped(scales: &Scales, asked: Option<f64>) -> usize {
    let count = scales.scales.len();
    let nearest = asked.and_then(|asked| {
        let off = |i: &usize| (scales.scales[*i].of.scale / asked).ln().abs();
        (0..count).min_by(|a, b| off(a).total_cmp(&off(b)))
    });
    nearest.unwrap_or((count - 1) / 2)
}
