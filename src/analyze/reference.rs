//! The site and the time whose spectra set the band edges.

use super::along::REFERENCE;
use super::front::arrivals;
use super::nearest;
use super::noise::KnownNoise;
use super::plan::Plan;
use crate::error::{Error, Result};
use crate::observer::Observer;
use crate::prepare::{ChannelScan, Prepared};

/// Sites that the front has passed at the reference time of a run, at most.
const PASSED: usize = 10;

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
        let site = || match plan.request.reference_site {
            Some(site) => Some(site - plan.sites.start),
            None => behind_the_struck(plan, prepared, scans).filter(|site| is_known(*site)),
        };
        let time = || match plan.request.reference_time {
            Some(t) => Some(nearest(&plan.axes.time, t, plan.axes.n_times)),
            None => front_has_passed(plan, prepared),
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
            let unknown = sites.iter_mut().enumerate();
            let unknown = unknown.filter(|(site, _)| !is_known(*site));
            unknown.for_each(|(_, energy)| *energy = 0.0);
            if no_site {
                found.site = first_with_energy(&sites, REFERENCE);
            }
            if no_time {
                found.time = first_with_energy(&times, REFERENCE);
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

/// Of a run, the first body behind those that are struck or driven, if it is analyzed and moves: more
/// than the rounding of a node of a standing wave.
fn behind_the_struck(plan: &Plan, prepared: &Prepared, scans: &[ChannelScan]) -> Option<usize> {
    const ROUNDING: f64 = 1e-12;
    let site = within(plan, prepared.struck()? + 1)?;
    let largest = scans.iter().fold(0.0, |m: f64, scan| m.max(scan.largest));
    if scans[site].largest < ROUNDING * largest {
        return None;
    }
    arrival_at(plan, prepared, site).map(|_| site)
}

/// Of a run, when the front arrives at the tenth body behind those that are struck or driven, or
/// after a quarter of the chain.
fn front_has_passed(plan: &Plan, prepared: &Prepared) -> Option<usize> {
    let passed = PASSED.min(prepared.sites_in_file() / 4).max(1);
    let site = within(plan, prepared.struck()? + passed)?;
    arrival_at(plan, prepared, site)
}

/// A site of the file, counted in the range analyzed.
fn within(plan: &Plan, site: usize) -> Option<usize> {
    let inside = plan.sites.contains(&site);
    inside.then(|| site - plan.sites.start)
}

fn arrival_at(plan: &Plan, prepared: &Prepared, site: usize) -> Option<usize> {
    let mut record = vec![0.0; plan.axes.n_times];
    prepared.record(site, &mut record);
    arrivals(&record, 1)[0]
}
