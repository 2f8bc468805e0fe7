//! The site and the time whose spectra set the band edges.

use super::along::REFERENCE;
use super::front::arrivals;
use super::noise::KnownNoise;
use super::plan::Plan;
use crate::error::{Error, Result};
use crate::observer::Observer;
use crate::prepare::{ChannelScan, Prepared};

/// Sites that the front has passed at the reference time of a run, at most.
const PASSED: usize = 10;

/// Part of the largest magnitude of all that a body moves at least: at a node of a standing wave there is rounding.
const ROUNDING: f64 = 1e-12;

/// Indices of the rows in the range analyzed; `None` where no row has energy, or none is wanted.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct References {
    pub site: Option<usize>,
    pub time: Option<usize>,
}

impl References {
    /// As requested, otherwise by the rules of
    /// [`Request::reference_site`](super::Request::reference_site) and
    /// [`Request::reference_time`](super::Request::reference_time). Where noise is subtracted, a site by
    /// default is one whose noise is known.
    ///
    /// # Errors
    /// [`Error::Request`] for a requested site whose noise is unknown where that of others is subtracted;
    /// those of reading.
    pub fn find(
        plan: &Plan,
        prepared: &Prepared,
        scans: &[ChannelScan],
        noise: Option<&KnownNoise>,
        observer: &dyn Observer,
    ) -> Result<References> {
        let results = plan.request.results;
        let is_known = |site: usize| noise.is_none_or(|noise| noise.is_known(site));
        let largest = scans.iter().fold(0.0, |m: f64, scan| m.max(scan.largest));
        let moves = |site: usize| scans[site].largest >= ROUNDING * largest;
        let site = || match plan.request.reference_site {
            Some(site) => Some(site - plan.sites.start),
            None => {
                let (site, _) = behind_the_struck(plan, prepared, 1)?;
                (moves(site) && is_known(site)).then_some(site)
            }
        };
        let passed = PASSED.min(prepared.field.n_sites() / 4).max(1);
        let time = || match plan.request.reference_time {
            Some(t) => Some(plan.axes.row_at(t)),
            None => behind_the_struck(plan, prepared, passed).map(|(_, arrival)| arrival),
        };
        let mut found = References {
            site: results.temporal.then(site).flatten(),
            time: results.spatial.then(time).flatten(),
        };
        if let Some(site) = found.site.filter(|site| !is_known(*site)) {
            let expected = "a site whose noise is known, since noise is subtracted";
            let found = format!("{}, whose noise is not known", site + plan.sites.start);
            return Err(Error::request("reference-site", expected, found));
        }
        let no_site = results.temporal && found.site.is_none();
        let no_time = results.spatial && found.time.is_none();
        if no_site || no_time {
            let (mut sites, times) = prepared.energies(observer)?;
            for (site, energy) in sites.iter_mut().enumerate() {
                *energy = if is_known(site) { *energy } else { 0.0 };
            }
            let first = |energies: &[f64]| first_with_energy(energies, REFERENCE);
            if no_site {
                found.site = first(&sites);
            }
            if no_time {
                found.time = first(&times);
            }
        }
        Ok(found)
    }
}

/// The first row with at least this share of the largest energy.
pub(super) fn first_with_energy(energies: &[f64], share: f64) -> Option<usize> {
    let largest = energies.iter().fold(0.0, |m: f64, &e| m.max(e));
    energies
        .iter()
        .position(|&energy| energy > 0.0 && energy >= share * largest)
}

/// Of a run, the body so many behind those that are struck or driven, if it is analyzed, and when the front arrives
/// there, if it moves.
fn behind_the_struck(plan: &Plan, prepared: &Prepared, bodies: usize) -> Option<(usize, usize)> {
    let site = prepared.field.struck? + bodies;
    let site = plan.sites.clone().position(|analyzed| analyzed == site)?;
    let mut record = vec![0.0; plan.axes.n_times];
    prepared.record(site, &mut record);
    Some((site, arrivals(&record, 1)[0]?))
}
