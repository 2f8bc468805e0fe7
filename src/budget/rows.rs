//! The pass over time: real space and wavenumbers, sample by sample.

use super::Task;
use super::balance::running;
use super::branches::Branches;
use super::contacts::Contacts;
use super::modes::{Basis, Modes};
use super::motion::Motion;
use super::real_space::{Exchanged, SiteBalance, SiteTerms};
use super::result::Budget;
use super::spectral::Spectral;
use super::waiting::Waiting;
use super::wavenumber::{Terms, Transfers};
use crate::arrays::LargeArray;
use crate::diagnostics::Keep;
use crate::error::Result;
use crate::numeric::sum;

/// Real space, and wavenumbers if requested.
pub(super) fn pass(task: &Task) -> Result<Budget> {
    let (motion, contacts, request) = (task.motion, task.contacts, task.request);
    let chain = motion.chain;
    let (samples, n, m) = (motion.samples(), chain.n_sites(), chain.n_contacts());
    let modes = Modes::new(Basis::of(chain.ends), n);
    let of_stated = Motion {
        chain: task.stated,
        ..*motion
    };
    let branches = Branches::of(&Contacts::of(&of_stated), &modes);
    let wavenumber = request.views.wavenumber;
    if wavenumber {
        contacts.check_roots(motion)?;
    }
    let transfers = Transfers::new(contacts, modes, branches, motion.drive.is_some());
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
    let mut spectral = wavenumber.then(spectral).transpose()?;
    let [times, sites] = request.window.clone().unwrap_or([0..samples, 0..n]);
    let mut balance = SiteBalance::new(times, sites, contacts);
    let mut exchanged = Exchanged::none(chain);
    let mut budget = Budget {
        n_sites: n,
        n_contacts: m,
        pitch: request.pitch,
        units: request.units.clone(),
        time: motion.time.to_vec(),
        followed: motion.energy_passed.is_some(),
        ..Budget::default()
    };
    task.observer.stage("budgets", samples as u64);
    waiting.each_sample(
        samples,
        task.observer,
        (SiteTerms::default(), Terms::default()),
        || transfers.scratch(),
        |scratch, i, (sites, spectra)| {
            let at = motion.at(i);
            match wavenumber {
                true => transfers.evaluate(at, scratch, spectra),
                false => contacts.evaluate(at, &mut scratch.contacts),
            }
            sites.evaluate(contacts, at, &scratch.contacts);
        },
        |waiting, i, (sites, spectra)| {
            let [before, behind] = motion.halves(i);
            exchanged.add(before, sites);
            exchanged.set(motion, i);
            balance.follow(i, &sites.energy, &exchanged);
            let total = sites.kinetic + sites.contact;
            let (passed, lost) = (&exchanged.passed, &exchanged.lost);
            budget.kinetic.push(sites.kinetic);
            budget.contact.push(sites.contact);
            budget.lost.push(sum(lost));
            budget.input.push(exchanged.input);
            budget.scale = budget.scale.max(total.abs()).max(exchanged.input.abs());
            if i + 1 == samples {
                running(
                    &mut budget.left_behind,
                    sites.energy.iter().copied().take(m),
                );
                budget.passed = passed.clone();
            }
            waiting.push(LargeArray::SITE_ENERGY, &sites.energy);
            waiting.push(LargeArray::ENERGY_FLUX, &sites.flux);
            waiting.push(LargeArray::ENERGY_PASSED, passed);
            waiting.push(LargeArray::ENERGY_LOST, lost);
            exchanged.add(behind, sites);
            if let Some(spectral) = &mut spectral {
                // What a moving wall puts into its damper never was energy of a wavenumber.
                let dissipation = sum(&sites.loss) - sites.wall_heat;
                spectral.take_in(i, [before, behind], spectra, [total, dissipation], waiting);
            }
        },
    )?;
    budget.closure.real_space = budget.relative(balance.worst());
    let (time, place) = (budget.units.time(), budget.units.position());
    let time = (&*time, budget.time[0], motion.step());
    let place = (&*place, 0.5 * budget.pitch, budget.pitch);
    let label = budget.units.power("energy flux J");
    budget.flux_map = waiting.map(LargeArray::ENERGY_FLUX, label, time, place);
    if let Some(spectral) = spectral {
        spectral.finish(time, &mut waiting, &mut budget);
    }
    Ok(budget)
}
