//! All that views need to know of a chain at one place of its motion, and the balances that follow from place to place.

use std::ops::Range;

use super::balance::{GivenRate, Passage, RunningBalance};
use super::contacts::{ContactState, Contacts};
use super::motion::Motion;
use super::real_space::{SiteBalance, SiteTerms};
use super::scale::{PlannedFilter, Scales};
use super::scale_terms::{ScaleScratch, ScaleTerms};
use super::wavenumber::{Terms, TransferScratch, Transfers};
use crate::chain::NodeState;

/// What is evaluated at a place, beside the energies of the sites.
pub(super) struct Evaluation<'a> {
    pub(super) contacts: &'a Contacts<'a>,
    pub(super) transfers: Option<&'a Transfers<'a>>,
    /// The filters of some scales.
    pub(super) scales: Option<(&'a Scales<'a>, &'a [PlannedFilter])>,
}

#[derive(Debug, Clone, Default)]
pub(super) struct PlaceTerms {
    pub(super) sites: SiteTerms,
    pub(super) spectra: Terms,
    pub(super) scales: Vec<ScaleTerms>,
}

/// Working space of one thread.
#[derive(Default)]
pub(super) struct PlaceScratch {
    pub(super) contacts: ContactState,
    spectra: Option<TransferScratch>,
    scales: ScaleScratch,
}

impl Evaluation<'_> {
    pub(super) fn evaluate(
        &self,
        at: NodeState,
        scratch: &mut PlaceScratch,
        terms: &mut PlaceTerms,
    ) {
        let (contacts, state) = (self.contacts, &mut scratch.contacts);
        contacts.evaluate(at, state);
        terms.sites.evaluate(contacts, at, state);
        if let Some(transfers) = self.transfers {
            contacts.evaluate_roots(state);
            let spectra = &mut scratch.spectra;
            let spectra = spectra.get_or_insert_with(|| transfers.scratch());
            transfers.evaluate(at, state, spectra, &mut terms.spectra);
        }
        if let Some((scales, filters)) = self.scales {
            scales.load(at, state, &mut scratch.scales);
            terms.scales.resize_with(filters.len(), ScaleTerms::default);
            for (filter, terms) in filters.iter().zip(&mut terms.scales) {
                scales.terms(filter, &mut scratch.scales, terms);
            }
        }
    }
}

/// What each view holds against the integral of its rates.
pub(super) struct Balances {
    pub(super) sites: SiteBalance,
    pub(super) passage: Option<Passage>,
    /// Of each scale that is evaluated.
    pub(super) scales: Vec<RunningBalance>,
}

impl Balances {
    /// Of what is evaluated along a motion, in real space over these samples and sites.
    pub(super) fn new(
        evaluation: &Evaluation,
        motion: &Motion,
        way: GivenRate,
        window: Option<[Range<usize>; 2]>,
    ) -> Balances {
        let samples = motion.samples();
        let [times, sites] = window.unwrap_or([0..samples, 0..motion.chain.n_sites()]);
        let passage = |of: &Transfers| Passage::new(way, samples, of.modes.len());
        let scales = evaluation.scales.map_or(0, |(_, filters)| filters.len());
        Balances {
            sites: SiteBalance::new(times, sites, evaluation.contacts),
            passage: evaluation.transfers.map(passage),
            scales: vec![RunningBalance::default(); scales],
        }
    }

    /// Adds a node of a quadrature.
    pub(super) fn add(&mut self, weight: f64, terms: &PlaceTerms) {
        self.sites.exchanged.add(weight, &terms.sites);
        if let Some(passage) = &mut self.passage {
            passage.add(weight, &terms.spectra);
        }
        for (balance, terms) in self.scales.iter_mut().zip(&terms.scales) {
            balance.add(weight, &terms.energy_rate);
        }
    }

    /// Compares at sample i.
    pub(super) fn compare(&mut self, i: usize, terms: &PlaceTerms) {
        self.sites.compare(i, &terms.sites.energy);
        if let Some(passage) = &mut self.passage {
            passage.compare(i, &terms.spectra.energy);
        }
        for (balance, terms) in self.scales.iter_mut().zip(&terms.scales) {
            balance.compare(&terms.energy);
        }
    }
}
