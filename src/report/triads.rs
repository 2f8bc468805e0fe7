//! Transfers by triads as files: a summary, and arrays.

use serde::Serialize;

use super::estimate_arrays::Arrays;
use super::{LabelledArrays, Provenance};
use crate::budget::{BudgetUnits, Disparity, QuadraticLaw, TriadIdentities, Triads};
use crate::error::Result;

/// The schema of the summary of transfers by triads.
pub const TRIADS_SCHEMA: &str = "cascade.triads/2";

/// `summary.json` of transfers by triads; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct TriadsSummary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    units: &'a BudgetUnits,
    law: QuadraticLaw,
    window: [f64; 2],
    samples: usize,
    energy: f64,
    largest_flux: FluxSummary,
    /// What terms beyond the quadratic one moved, as a share of what it moved.
    share_beyond: f64,
    is_quadratic: bool,
    /// The largest change that neither has: losses, drives, ends, sampling.
    unexplained: f64,
    identities: TriadIdentities,
}

/// The flux at the wavenumber past which it is largest.
#[derive(Debug, Serialize)]
struct FluxSummary {
    wavenumber: f64,
    flux: f64,
    error: f64,
    resolved: bool,
    /// Share of it that triads carry whose wavenumbers are within a factor of 4, and of 8.
    share_within_4: f64,
    share_within_8: f64,
}

impl<'a> TriadsSummary<'a> {
    pub fn new(found: &'a Triads, provenance: &'a Provenance) -> Self {
        let at = found.locality.at;
        let unexplained = found.unexplained();
        TriadsSummary {
            schema: TRIADS_SCHEMA,
            provenance,
            units: &found.units,
            law: found.law,
            window: found.window,
            samples: found.samples,
            energy: found.energy,
            largest_flux: FluxSummary {
                wavenumber: found.wavenumber[at],
                flux: found.flux[at],
                error: found.flux_error(),
                resolved: found.is_resolved(),
                share_within_4: found.locality.share_below(4.0),
                share_within_8: found.locality.share_below(8.0),
            },
            share_beyond: found.share_beyond(),
            is_quadratic: found.is_quadratic(),
            unexplained: unexplained.iter().fold(0.0, |m, value| m.max(value.abs())),
            identities: found.identities,
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Hands transfers by triads to `file`: `wavenumber`, `gained`, `change`, `flux` and, of a chain, `beyond`
/// (wavenumber); `transfer` and, of a chain, `umklapp` (wavenumber, partner); `disparity` (group), the least ratio of a
/// group of triads, 0 for those with wavenumber 0, NaN for umklapp, and `flux_of_group` (group, wavenumber).
///
/// # Errors
/// Those of `file`.
pub fn triad_arrays(found: &Triads, file: &dyn LabelledArrays) -> Result<()> {
    let to = Arrays(file);
    let energy = found.units.energy.clone().unwrap_or_default();
    let per_length = match &found.units.length {
        Some(unit) => format!("rad/{unit}"),
        None => String::new(),
    };
    let line = |name: &str, values: &[f64]| to.line(name, "wavenumber", &energy, values);
    to.line("wavenumber", "wavenumber", &per_length, &found.wavenumber)?;
    line("gained", &found.gained)?;
    line("change", &found.change)?;
    line("flux", &found.flux)?;
    if let Some(beyond) = &found.beyond {
        line("beyond", beyond)?;
    }
    let axes = ["wavenumber", "partner"];
    to.plane("transfer", axes, &energy, &found.transfer)?;
    if let Some(umklapp) = &found.umklapp {
        to.plane("umklapp", axes, &energy, umklapp)?;
    }
    let groups = &found.locality.flux;
    let least: Vec<f64> = groups
        .iter()
        .map(|(disparity, _)| match disparity {
            Disparity::Octave { from } => *from,
            Disparity::WithMean => 0.0,
            Disparity::Umklapp => f64::NAN,
        })
        .collect();
    to.line("disparity", "group", "", &least)?;
    let flux: Vec<f64> = groups.iter().flat_map(|(_, flux)| flux.clone()).collect();
    let axes = [
        ("group", groups.len()),
        ("wavenumber", found.wavenumber.len()),
    ];
    to.of_axes("flux_of_group", &axes, &energy, &flux)
}
