//! Bicoherence as files: a summary, and arrays.

use std::path::Path;

use ndarray::Array2;
use serde::Serialize;

use super::{Archive, Provenance};
use crate::arrays::Precision;
use crate::error::Result;
use crate::estimates::{Bicoherence, CoupledTriple, Independence};

/// The schema of the summary of a bicoherence.
pub const BICOHERENCE_SCHEMA: &str = "cascade.bicoherence/1";

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
    pub fn new(found: &'a Bicoherence, provenance: &'a Provenance) -> Self {
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
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Writes a bicoherence to the new file `path` (`.npz`): `frequency` (nf); of each triple `first`, `second`,
/// `third` (frequencies), `bicoherence`, `biphase` (cells); `along_site`, `along_position` (n) and
/// `along_largest`, `along_first`, `along_biphase`, `along_summed`, `along_largest_level`,
/// `along_summed_level` (nf, n), left out if no site was chosen.
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_bicoherence(path: &Path, found: &Bicoherence) -> Result<()> {
    let archive = Archive::create(path, Precision::F64)?;
    let line = |name: &str, values: &[f64]| archive.append(name, &[values.len()], values);
    line("frequency", &found.frequency)?;
    let df = found.frequency[1];
    for (i, name) in ["first", "second", "third"].into_iter().enumerate() {
        let of = |bins: &[isize; 3]| bins[i] as f64 * df;
        let values: Vec<f64> = found.map.bins.iter().map(of).collect();
        line(name, &values)?;
    }
    line("bicoherence", &found.map.bicoherence)?;
    line("biphase", &found.map.biphase)?;
    let along = &found.along;
    if along.sites.is_empty() {
        return archive.finish();
    }
    let sites: Vec<f64> = along.sites.iter().map(|j| *j as f64).collect();
    line("along_site", &sites)?;
    let positions: Vec<f64> = along.sites.iter().map(|j| found.space.at(*j)).collect();
    line("along_position", &positions)?;
    let map = |name: &str, array: &Array2<f64>| {
        let values: Vec<f64> = array.iter().copied().collect();
        archive.append(name, &[array.nrows(), array.ncols()], &values)
    };
    map("along_largest", &along.largest)?;
    map("along_first", &along.first)?;
    map("along_biphase", &along.biphase)?;
    map("along_summed", &along.summed)?;
    map("along_largest_level", &along.largest_level)?;
    map("along_summed_level", &along.summed_level)?;
    archive.finish()
}
