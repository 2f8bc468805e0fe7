//! The pass over time: real space and wavenumbers, sample by sample.

use ndarray::ArrayView1;
use rayon::prelude::*;

use super::balance::trapezoid;
use super::branches::Branches;
use super::contacts::Contacts;
use super::modes::{Basis, Modes};
use super::motion::Motion;
use super::real_space::{Balance, Exchanged, SiteTerms};
use super::request::BudgetRequest;
use super::result::{Budget, Closure, PassedError, empty_map};
use super::spectral::Spectral;
use super::waiting::{ShownArray, Waiting};
use super::wavenumber::{Terms, Transfers};
use crate::arrays::{LargeArray, Sink};
use crate::chain::Chain;
use crate::error::Result;
use crate::numeric::sum;
use crate::observer::Observer;

/// Samples that are computed before they are added up in order.
const BATCH: usize = 64;

/// Everything of one sample.
#[derive(Clone, Default)]
struct MotionSample {
    sites: SiteTerms,
    /// Empty if wavenumbers are not requested.
    spectra: Terms,
}

/// Real space, and wavenumbers if requested.
pub(super) fn pass(
    motion: &Motion,
    contacts: &Contacts,
    stated: &Chain,
    request: &BudgetRequest,
    sink: &dyn Sink,
    observer: &dyn Observer,
) -> Result<Budget> {
    let chain = motion.chain;
    let modes = Modes::new(Basis::of(chain.ends), chain.n_sites());
    let branches = Branches::of(
        &Contacts::of(&Motion {
            chain: stated,
            ..*motion
        }),
        &modes,
    );
    if request.views.wavenumber {
        contacts.check_roots(motion)?;
    }
    let transfers = Transfers::new(contacts, modes, branches, motion.drive.is_some());
    let samples = motion.samples();
    observer.stage("budgets", samples as u64);
    let mut pass = MotionPass::new(*motion, &transfers, request, sink)?;
    // The last sample of the batch before, then the batch.
    let mut found = vec![MotionSample::default(); BATCH + 1];
    for first in (0..samples).step_by(BATCH) {
        observer.go_on()?;
        let batch = first..(first + BATCH).min(samples);
        found[1..=batch.len()]
            .par_iter_mut()
            .zip(batch.clone())
            .for_each_init(
                || transfers.scratch(),
                |scratch, (MotionSample { sites, spectra }, i)| {
                    let at = motion.at(i);
                    match request.views.wavenumber {
                        true => transfers.evaluate(at, scratch, spectra),
                        false => contacts.evaluate(at, &mut scratch.contacts),
                    }
                    sites.evaluate(contacts, at, &scratch.contacts);
                },
            );
        for (i, pair) in batch.clone().zip(found.windows(2)) {
            pass.take_in(i, &pair[0].sites, &pair[1]);
        }
        found.swap(0, batch.len());
        pass.waiting.hand_on(sink, batch.start)?;
        observer.advance(batch.len() as u64);
    }
    Ok(pass.finish())
}

struct MotionPass<'a> {
    motion: Motion<'a>,
    dt: f64,
    waiting: Waiting,
    balance: Balance,
    exchanged: Exchanged,
    budget: Budget,
    spectral: Option<Spectral>,
}

impl<'a> MotionPass<'a> {
    fn new(
        motion: Motion<'a>,
        transfers: &Transfers,
        request: &BudgetRequest,
        sink: &dyn Sink,
    ) -> Result<MotionPass<'a>> {
        let chain = motion.chain;
        let (samples, n, m) = (motion.samples(), chain.n_sites(), chain.n_contacts());
        let mut waiting = Waiting::default();
        let lossy = chain.is_lossy();
        waiting.reserve(sink, LargeArray::SITE_ENERGY, (samples, n), ShownArray::Not)?;
        waiting.reserve(
            sink,
            LargeArray::ENERGY_FLUX,
            (samples, m),
            ShownArray::Extreme,
        )?;
        waiting.reserve(
            sink,
            LargeArray::ENERGY_PASSED,
            (samples, m),
            ShownArray::Not,
        )?;
        if lossy {
            waiting.reserve(sink, LargeArray::ENERGY_LOST, (samples, n), ShownArray::Not)?;
        }
        let spectral = match request.views.wavenumber {
            true => Some(Spectral::new(
                &motion,
                transfers,
                request,
                sink,
                &mut waiting,
            )?),
            false => None,
        };
        let [times, sites] = request.window.clone().unwrap_or([0..samples, 0..n]);
        Ok(MotionPass {
            motion,
            dt: motion.step(),
            waiting,
            balance: Balance::new(times, sites, transfers.contacts),
            exchanged: Exchanged {
                passed: vec![0.0; m],
                lost: vec![0.0; if lossy { n } else { 0 }],
                input: 0.0,
            },
            spectral,
            budget: Budget {
                n_sites: n,
                n_contacts: m,
                pitch: request.pitch,
                units: request.units.clone(),
                time: motion.time.to_vec(),
                kinetic: Vec::with_capacity(samples),
                contact: Vec::with_capacity(samples),
                lost: Vec::with_capacity(samples),
                input: Vec::with_capacity(samples),
                scale: 0.0,
                passed: Vec::new(),
                left_behind: Vec::new(),
                followed: motion.energy_passed.is_some(),
                flux_map: empty_map(),
                wavenumber: None,
                frequency: None,
                scales: None,
                modes: None,
                closure: Closure::default(),
                errors: None,
            },
        })
    }

    /// Energies passed, lost and put in up to sample i: as followed inside the steps, else by the
    /// trapezoid rule.
    fn exchange(&mut self, i: usize, before: &SiteTerms, now: &SiteTerms) {
        let Exchanged {
            passed,
            lost,
            input,
        } = &mut self.exchanged;
        let (motion, dt) = (&self.motion, self.dt);
        match motion.energy_passed {
            Some(array) => set(passed, array.row(i)),
            None if i > 0 => trapezoid(passed, dt, &before.flux, &now.flux),
            None => {}
        }
        match motion.energy_lost {
            Some(array) => set(lost, array.row(i)),
            None if i > 0 => trapezoid(lost, dt, &before.loss, &now.loss),
            None => {}
        }
        match &motion.energy_input {
            Some(array) => *input = array[i],
            None if i > 0 => *input += 0.5 * dt * (before.input + now.input),
            None => {}
        }
    }

    fn take_in(&mut self, i: usize, before: &SiteTerms, sample: &MotionSample) {
        let MotionSample { sites, spectra } = sample;
        self.exchange(i, before, sites);
        self.balance.follow(i, &sites.energy, &self.exchanged);
        let total = sites.kinetic + sites.contact;
        let budget = &mut self.budget;
        budget.kinetic.push(sites.kinetic);
        budget.contact.push(sites.contact);
        budget.lost.push(sum(&self.exchanged.lost));
        budget.input.push(self.exchanged.input);
        budget.scale = budget
            .scale
            .max(total.abs())
            .max(self.exchanged.input.abs());
        if i + 1 == self.motion.samples() {
            let mut held = 0.0;
            let sums = sites.energy.iter().map(|e| {
                held += e;
                held
            });
            budget.left_behind = sums.take(budget.n_contacts).collect();
            budget.passed = self.exchanged.passed.clone();
        }
        let waiting = &mut self.waiting;
        waiting.push(LargeArray::SITE_ENERGY, &sites.energy);
        waiting.push(LargeArray::ENERGY_FLUX, &sites.flux);
        waiting.push(LargeArray::ENERGY_PASSED, &self.exchanged.passed);
        waiting.push(LargeArray::ENERGY_LOST, &self.exchanged.lost);
        if let Some(spectral) = &mut self.spectral {
            // What a moving wall puts into its damper never was energy of a wavenumber.
            let dissipation = sum(&sites.loss) - sites.wall_heat;
            spectral.take_in(i, self.dt, spectra, [total, dissipation], waiting);
        }
    }

    fn finish(self) -> Budget {
        let mut budget = self.budget;
        budget.closure.real_space = budget.relative(self.balance.worst());
        let units = budget.units.clone();
        let (time, place) = (units.time(), units.position());
        let time = (&*time, budget.time[0], self.dt);
        let place = (&*place, 0.5 * budget.pitch, budget.pitch);
        let mut waiting = self.waiting;
        let label = units.power("energy flux J");
        let map = waiting.map(LargeArray::ENERGY_FLUX, label, time, place);
        budget.flux_map = map.unwrap_or_else(empty_map);
        if let Some(spectral) = self.spectral {
            budget.closure.wavenumber = budget.relative(spectral.worst());
            budget.closure.identities = spectral.identities();
            let check = spectral.check();
            budget.closure.integrated_flux = check.relative_to(budget.scale);
            let mut found = spectral.finish(time, &units, &mut waiting);
            // From samples the transfer integrates poorly; the balance does so only with losses.
            found.passed_error = PassedError::numerical(check.at_largest_wavenumber, budget.scale);
            budget.wavenumber = Some(found);
        }
        budget
    }
}

fn set(values: &mut Vec<f64>, row: ArrayView1<f64>) {
    values.clear();
    match row.to_slice() {
        Some(row) => values.extend_from_slice(row),
        None => values.extend(row),
    }
}
