//! The pass over time: all views that follow from places, sample by sample.

use super::Task;
use super::balance::{GivenRate, Passage, RunningBalance, running};
use super::branches::Branches;
use super::contacts::Contacts;
use super::modes::{Basis, Modes};
use super::motion::Motion;
use super::place::{Balances, Evaluation, PlaceScratch, PlaceTerms};
use super::real_space::SiteBalance;
use super::result::Budget;
use super::scale::{self, KeptScales};
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
    let modes = Modes::new(Basis::of(chain.ends), n);
    let of_stated = Motion {
        chain: task.stated,
        ..*motion
    };
    let branches = Branches::of(&Contacts::of(&of_stated), &modes);
    if views.wavenumber {
        contacts.check_roots(motion)?;
    }
    let transfers = Transfers::new(contacts, modes, branches, motion.drive.is_some());
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
    let kept = scales.as_ref();
    let kept = kept.map(|scales| KeptScales::new(scales, task, &mut waiting));
    let mut kept = kept.transpose()?;
    let filters = scales.as_ref().map_or(&[][..], |scales| &scales.scales);
    let evaluation = Evaluation {
        contacts,
        transfers: views.wavenumber.then_some(&transfers),
        scales: scales.as_ref().map(|scales| (scales, filters)),
    };
    let [times, sites] = request.window.clone().unwrap_or([0..samples, 0..n]);
    let passage = || Passage::new(GivenRate::Balance, samples, transfers.modes.len());
    let mut balances = Balances {
        sites: SiteBalance::new(times, sites, contacts),
        passage: views.wavenumber.then(passage),
        scales: vec![RunningBalance::default(); filters.len()],
    };
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
            waiting.push(LargeArray::SITE_ENERGY, &sites.energy);
            waiting.push(LargeArray::ENERGY_FLUX, &sites.flux);
            waiting.push(LargeArray::ENERGY_PASSED, &exchanged.passed);
            waiting.push(LargeArray::ENERGY_LOST, &exchanged.lost);
            if let (Some(spectral), Some(passage)) = (&mut spectral, &balances.passage) {
                // What a moving wall puts into its damper never was energy of a wavenumber.
                let dissipation = sum(&sites.loss) - sites.wall_heat;
                let known = [total, dissipation];
                spectral.take_in(&terms.spectra, passage.passed(), known, waiting);
            }
            if let (Some(kept), Some(scales)) = (&mut kept, &scales) {
                kept.add(before + behind, (scales, &terms.scales), waiting);
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
    if let (Some(kept), Some(scales)) = (kept, &scales) {
        let balances = (scales, &*balances.scales);
        kept.finish(balances, [time, place], &mut waiting, &mut budget);
    }
    Ok(budget)
}
