//! The pass over time: all views that follow from places, sample by sample.

use super::Task;
use super::balance::{GivenRate, RunningBalance, running, worst_of};
use super::place::{Balances, Evaluation, PlaceScratch, PlaceTerms};
use super::result::Budget;
use super::scale;
use super::spectral::Spectral;
use super::waiting::Waiting;
use super::wavenumber::Transfers;
use crate::arrays::LargeArray;
use crate::diagnostics::Keep;
use crate::error::Result;
use crate::numeric::sum;

/// Real space, and wavenumbers and scales if requested.
pub(super) fn pass(task: &Task) -> Result<Budget> {
    let (motion, contacts, request) = (task.motion, task.contacts, task.request);
    let (chain, views) = (motion.chain, request.views);
    let (samples, n, m) = (motion.samples(), chain.n_sites(), chain.n_contacts());
    if views.wavenumber {
        contacts.check_roots(motion)?;
    }
    let transfers = Transfers::new(contacts, Some(task.stated));
    let mut budget = Budget {
        n_sites: n,
        n_contacts: m,
        pitch: request.pitch,
        units: request.units.clone(),
        time: motion.time.to_vec(),
        followed: motion.energy_passed.is_some(),
        ..Budget::default()
    };
    let lossy = if chain.is_lossy() { n } else { 0 };
    let mut waiting = Waiting::new(task.sink);
    for (array, columns, shown) in [
        (LargeArray::SITE_ENERGY, n, None),
        (LargeArray::ENERGY_FLUX, m, Some(Keep::Extreme)),
        (LargeArray::ENERGY_PASSED, m, None),
        (LargeArray::ENERGY_LOST, lossy, None),
    ] {
        waiting.reserve(array, (samples, columns), shown)?;
    }
    let spectral = || Spectral::new(motion, &transfers, request, &mut waiting);
    let mut spectral = views.wavenumber.then(spectral).transpose()?;
    let scales = match views.scale {
        true => scale::planned(task, &mut budget)?,
        false => None,
    };
    if let Some(scales) = &scales {
        scales.reserve(samples, &mut waiting)?;
        budget.scales = Some(scales.budget());
    }
    let evaluation = Evaluation {
        contacts,
        transfers: views.wavenumber.then_some(&transfers),
        scales: scales.as_ref().map(|scales| (scales, &scales.scales[..])),
    };
    let window = request.window.clone();
    let mut balances = Balances::new(&evaluation, motion, GivenRate::Balance, window);
    task.observer.stage("budgets", samples as u64);
    waiting.each_sample(
        samples,
        task.observer,
        PlaceTerms::default(),
        PlaceScratch::default,
        |scratch, i, terms| evaluation.evaluate(motion.at(i), scratch, terms),
        |waiting, i, terms| {
            let (sites, [before, behind]) = (&terms.sites, motion.halves(i));
            balances.add(before, terms);
            balances.sites.exchanged.set(motion, i);
            balances.compare(i, terms);
            let exchanged = &balances.sites.exchanged;
            let total = sites.kinetic + sites.contact;
            budget.kinetic.push(sites.kinetic);
            budget.contact.push(sites.contact);
            budget.lost.push(sum(&exchanged.lost));
            budget.input.push(exchanged.input);
            budget.scale = budget.scale.max(total.abs()).max(exchanged.input.abs());
            if i + 1 == samples {
                running(
                    &mut budget.left_behind,
                    sites.energy.iter().copied().take(m),
                );
                budget.passed = exchanged.passed.clone();
            }
            for (array, row) in [
                (LargeArray::SITE_ENERGY, &sites.energy),
                (LargeArray::ENERGY_FLUX, &sites.flux),
                (LargeArray::ENERGY_PASSED, &exchanged.passed),
                (LargeArray::ENERGY_LOST, &exchanged.lost),
            ] {
                waiting.push(array, row);
            }
            if let (Some(spectral), Some(passage)) = (&mut spectral, &balances.passage) {
                // What a moving wall puts into its damper never was energy of a wavenumber.
                let dissipation = sum(&sites.loss) - sites.wall_heat;
                let known = [total, dissipation];
                spectral.take_in(&terms.spectra, passage.passed(), known, waiting);
            }
            if let (Some(scales), Some(found)) = (&scales, &mut budget.scales) {
                scales.take_in(before + behind, &terms.scales, found, waiting);
            }
            balances.add(behind, terms);
        },
    )?;
    budget.closure.real_space = budget.relative(balances.sites.worst());
    let (time, place) = (budget.units.time(), budget.units.position());
    let time = (&*time, budget.time[0], motion.step());
    let place = (&*place, 0.5 * budget.pitch, budget.pitch);
    let label = budget.units.power("energy flux J");
    budget.flux_map = waiting.map(LargeArray::ENERGY_FLUX, label, time, place);
    if let (Some(spectral), Some(passage)) = (spectral, balances.passage) {
        spectral.finish(passage, time, &mut waiting, &mut budget);
    }
    if let Some(found) = &mut budget.scales {
        let worst: Vec<f64> = balances.scales.iter().map(RunningBalance::worst).collect();
        let relative = |worst: &f64| Some(worst / budget.scale);
        found.residual = worst.iter().map(relative).collect();
        let label = budget.units.power("scale flux Π_l");
        found.flux_map = Some(waiting.map(LargeArray::SCALE_FLUX, label, time, place));
        budget.closure.scale = budget.relative(worst_of(0.0, &worst));
    }
    Ok(budget)
}
