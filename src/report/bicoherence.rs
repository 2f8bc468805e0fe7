//! Bicoherence as files: a summary, and arrays.

use serde::Serialize;

use super::estimate_arrays::{Arrays, Units};
use super::{LabelledArrays, Provenance, TransferSummary};
use crate::error::Result;
use crate::estimates::{Bicoherence, CoupledTriple, Independence, Transfer};

/// The schema of the summary of a bicoherence.
pub const BICOHERENCE_SCHEMA: &str = "cascade.bicoherence/2";

/// Triples that a summary lists at most.
const LISTED: usize = 20;

/// `summary.json` of a bicoherence; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct BicoherenceSummary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    time_unit: String,
    space_unit: String,
    site: usize,
    position: f64,
    output: usize,
    output_position: f64,
    segment: usize,
    overlap: usize,
    independence: Independence,
    alpha: f64,
    /// Triples of frequencies with a value.
    cells: usize,
    cell_level: Option<f64>,
    above_cell_level: Option<usize>,
    correction: &'static str,
    map_level: Option<f64>,
    above_map_level: Option<usize>,
    /// Triples above the level of the map, the most coupled first.
    strongest: Vec<CoupledTriple>,
    along: AlongSummary<'a>,
    transfer: Option<TransferSummary<'a>>,
}

/// Of the sites along x.
#[derive(Debug, Serialize)]
struct AlongSummary<'a> {
    sites: &'a [usize],
    positions: Vec<f64>,
    /// Output frequencies whose largest bicoherence is above its level, at each site.
    above_level: Vec<usize>,
}

impl<'a> BicoherenceSummary<'a> {
    pub fn new(
        found: &'a Bicoherence,
        transfer: Option<&'a Transfer>,
        provenance: &'a Provenance,
    ) -> Self {
        let (time_unit, space_unit) = found.units();
        let along = &found.along;
        BicoherenceSummary {
            schema: BICOHERENCE_SCHEMA,
            provenance,
            time_unit,
            space_unit,
            site: found.site,
            position: found.space.at(found.site),
            output: found.output,
            output_position: found.space.at(found.output),
            segment: found.segment[0],
            overlap: found.segment[1],
            independence: found.independence,
            alpha: found.alpha,
            cells: found.cells(),
            cell_level: found.cell_level(),
            above_cell_level: found.cell_level().map(|level| found.above(level)),
            correction: "Sidak",
            map_level: found.map_level(),
            above_map_level: found.map_level().map(|level| found.above(level)),
            strongest: found.strongest(LISTED),
            along: AlongSummary {
                sites: &along.sites,
                positions: along.sites.iter().map(|j| found.space.at(*j)).collect(),
                above_level: along.coupled_outputs(),
            },
            transfer: transfer.map(TransferSummary::new),
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Hands a bicoherence to `file`: `frequency` (nf); of each triple `first`, `second`, `third` (frequencies),
/// `bicoherence`, `biphase` (triples); `along_site`, `along_position` (n) and `along_largest`, `along_first`,
/// `along_biphase`, `along_summed`, `along_largest_level`, `along_summed_level` (nf, n), left out if no site was
/// chosen.
///
/// # Errors
/// Those of `file`.
pub fn bicoherence_arrays(found: &Bicoherence, file: &dyn LabelledArrays) -> Result<()> {
    let to = Arrays(file);
    let units = Units::of(&found.time, &found.space, None);
    let cycles = &units.frequency[..];
    to.line("frequency", "frequency", cycles, &found.frequency)?;
    let df = found.frequency[1];
    for (i, name) in ["first", "second", "third"].into_iter().enumerate() {
        let of = |bins: &[isize; 3]| bins[i] as f64 * df;
        let values: Vec<f64> = found.map.bins.iter().map(of).collect();
        to.line(name, "triple", cycles, &values)?;
    }
    to.line("bicoherence", "triple", "", &found.map.bicoherence)?;
    to.line("biphase", "triple", "rad", &found.map.biphase)?;
    let along = &found.along;
    if along.sites.is_empty() {
        return Ok(());
    }
    let sites: Vec<f64> = along.sites.iter().map(|j| *j as f64).collect();
    to.line("along_site", "along_site", "", &sites)?;
    let positions: Vec<f64> = along.sites.iter().map(|j| found.space.at(*j)).collect();
    to.line("along_position", "along_site", &units.space, &positions)?;
    for (name, unit, array) in [
        ("along_largest", "", &along.largest),
        ("along_first", cycles, &along.first),
        ("along_biphase", "rad", &along.biphase),
        ("along_summed", "", &along.summed),
        ("along_largest_level", "", &along.largest_level),
        ("along_summed_level", "", &along.summed_level),
    ] {
        to.plane(name, ["frequency", "along_site"], unit, array)?;
    }
    Ok(())
}
