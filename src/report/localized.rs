//! Localized waves as files: a table of orders, a wave's arrays, a launched wave's.

use std::path::Path;

use serde::Serialize;

use super::scan_records::quoted;
use super::{Archive, NamedArrays};
use crate::Result;
use crate::arrays::Precision;
use crate::localized::{Direct, Family, Journey, OrderRow, Snapshot, Wave};

/// The schema of `localized.json`.
pub const LOCALIZED_SCHEMA: &str = "cascade.localize/1";

/// The fields of `localized.json` besides the result.
#[derive(Debug, Serialize)]
pub struct LocalizedSummary<'a, T> {
    schema: &'static str,
    version: &'static str,
    family: Family,
    #[serde(flatten)]
    result: &'a T,
}

impl<'a, T: Serialize> LocalizedSummary<'a, T> {
    /// `result` must serialize as named fields.
    pub fn new(family: Family, result: &'a T) -> Self {
        LocalizedSummary {
            schema: LOCALIZED_SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            family,
            result,
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Writes a wave's arrays to the new file `path` (`.npz`): `time` (nt), in units of the wave's
/// travel time over one cell; `overlap`, `psi`, `force`, `velocity` (2, nt), of the soft and the
/// stiff contact (or those before and behind the light site) and the sites before them; `slow`,
/// `fast` (nt); `ratio`, `exponent`, `order` (1).
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_profile(path: &Path, wave: &Wave, profile: &Snapshot) -> Result<()> {
    let archive = Archive::create(path, Precision::F64)?;
    profile_arrays(wave, profile, &archive)?;
    archive.finish()
}

/// The arrays of [`write_profile`].
///
/// # Errors
/// Those of `archive`.
pub fn profile_arrays(wave: &Wave, profile: &Snapshot, archive: &dyn NamedArrays) -> Result<()> {
    let line = |name: &str, values: &[f64]| archive.append(name, &[values.len()], values);
    line("time", &profile.time)?;
    for (name, values) in [
        ("overlap", &profile.overlap),
        ("psi", &profile.psi),
        ("force", &profile.force),
        ("velocity", &profile.velocity),
    ] {
        archive.append(name, &[2, profile.time.len()], &values.concat())?;
    }
    line("slow", &profile.slow)?;
    line("fast", &profile.fast)?;
    line("ratio", &[wave.ratio])?;
    line("exponent", &[wave.exponent])?;
    line("order", &[wave.order as f64])
}

/// Writes what a launched wave did to the new file `path` (`.npz`): `velocity` (2, sites), at the
/// start and at the end; `cells`, `shape_change`, `leak`, `energy_drift` after each cell.
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_journey(path: &Path, journey: &Journey) -> Result<()> {
    let archive = Archive::create(path, Precision::F64)?;
    journey_arrays(journey, &archive)?;
    archive.finish()
}

/// The arrays of [`write_journey`].
///
/// # Errors
/// Those of `archive`.
pub fn journey_arrays(journey: &Journey, archive: &dyn NamedArrays) -> Result<()> {
    let sites = journey.velocity[0].len();
    archive.append("velocity", &[2, sites], &journey.velocity.concat())?;
    let travels = &journey.travels;
    let columns: [(&str, Vec<f64>); 4] = [
        ("cells", travels.iter().map(|t| t.cells as f64).collect()),
        (
            "shape_change",
            travels.iter().map(|t| t.shape_change).collect(),
        ),
        ("leak", travels.iter().map(|t| t.leak).collect()),
        (
            "energy_drift",
            travels.iter().map(|t| t.energy_drift).collect(),
        ),
    ];
    for (name, values) in &columns {
        archive.append(name, &[values.len()], values)?;
    }
    Ok(())
}

/// Orders as CSV, one row for each order, with all digits; unknown values are empty.
pub fn table_csv(rows: &[OrderRow]) -> String {
    let mut table = COLUMNS.join(",");
    for row in rows {
        let exact = row.exact.as_ref();
        let number = |value: Option<f64>| value.map(|x| x.to_string()).unwrap_or_default();
        let count = |value: Option<usize>| value.map(|x| x.to_string()).unwrap_or_default();
        let extreme = |direct: Option<Direct>| {
            [
                number(direct.map(|d| d.ratio.value())),
                number(direct.map(|d| d.error)),
                number(direct.map(|d| d.leak)),
                number(direct.and_then(|d| Some(d.angle?.degrees))),
            ]
        };
        let mut cells = vec![
            row.order.to_string(),
            number(exact.map(|e| e.ratio.value())),
            number(exact.map(|e| e.error)),
            count(exact.map(|e| e.digits as usize)),
            number(exact.map(|e| e.convergence.residual)),
            count(exact.map(|e| e.convergence.iterations)),
            number(exact.map(|e| e.convergence.tail)),
            count(exact.map(|e| e.convergence.points)),
            number(exact.map(|e| e.convergence.period)),
            number(exact.map(|e| e.speed_coefficient)),
            number(exact.map(|e| e.width)),
            number(exact.map(|e| e.energy)),
            number(exact.map(|e| e.momentum)),
            number(row.angle.map(|angle| angle.degrees)),
            number(row.asymptotic.map(|a| a.exact_profile)),
            number(row.asymptotic.and_then(|a| a.fitted_profile)),
        ];
        cells.extend(extreme(row.direct));
        cells.extend(extreme(row.most_dispersive));
        cells.extend([
            count(row.published.map(|p| p.printed_order)),
            number(row.published.map(|p| p.direct)),
            number(row.published.map(|p| p.estimate)),
            number(row.differences.exact_profile),
            number(row.differences.fitted_profile),
            number(row.differences.direct),
            number(row.differences.published_direct),
            number(row.differences.published_estimate),
            quoted(row.reason.as_deref().unwrap_or_default()),
        ]);
        table.push('\n');
        table += &cells.join(",");
    }
    table.push('\n');
    table
}

const COLUMNS: [&str; 33] = [
    "order",
    "ratio",
    "error",
    "digits",
    "residual",
    "iterations",
    "tail",
    "points",
    "period",
    "speed_coefficient",
    "width",
    "energy",
    "momentum",
    "angle",
    "exact_profile",
    "fitted_profile",
    "direct",
    "direct_error",
    "direct_leak",
    "direct_angle",
    "most_dispersive",
    "most_dispersive_error",
    "most_dispersive_leak",
    "most_dispersive_angle",
    "printed_order",
    "published_direct",
    "published_estimate",
    "exact_profile_difference",
    "fitted_profile_difference",
    "direct_difference",
    "published_direct_difference",
    "published_estimate_difference",
    "reason",
];
