//! Attenuation and transmission as files.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::attenuation::{Attenuation, Pulse, Transmission};

/// The schemas of `attenuation.json` and `transmission.json`.
pub const ATTENUATION_SCHEMA: &str = "cascade.attenuation/1";
pub const TRANSMISSION_SCHEMA: &str = "cascade.transmission/1";

/// A result with what made it.
#[derive(Debug, Serialize)]
struct Versioned<'a, T> {
    schema: &'static str,
    version: &'static str,
    #[serde(flatten)]
    result: &'a T,
}

/// `result` with its schema, as JSON; it must serialize as named fields. NaN is written as null.
///
/// # Errors
/// None for results of this library.
pub fn versioned_json<T: Serialize>(
    schema: &'static str,
    result: &T,
) -> serde_json::Result<String> {
    let version = env!("CARGO_PKG_VERSION");
    serde_json::to_string_pretty(&Versioned {
        schema,
        version,
        result,
    })
}

/// Writes a file of a directory that keeps results, whole or not at all.
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_beside(directory: &Path, name: &str, bytes: &[u8]) -> crate::Result<PathBuf> {
    crate::system::journal::write_whole(directory, name, bytes)
}

/// Columns of a pulse, each located value with its error.
const PULSE: [&str; 20] = [
    "peak_force",
    "peak_force_error",
    "peak_time",
    "peak_time_error",
    "peak_velocity",
    "peak_velocity_error",
    "velocity_time",
    "velocity_time_error",
    "arrival_time",
    "arrival_time_error",
    "width",
    "width_error",
    "velocity_rise_time",
    "velocity_rise_time_error",
    "energy_pulse",
    "energy_passed",
    "energy_passed_error",
    "energy_behind",
    "energy_lost",
    "energy_closure",
];

fn pulse(pulse: &Pulse) -> Vec<String> {
    let mut cells = Vec::new();
    for located in [
        pulse.peak_force,
        pulse.peak_time,
        pulse.peak_velocity,
        pulse.velocity_time,
        pulse.arrival_time,
        pulse.width,
    ] {
        cells.extend([number(located.value), number(located.error)]);
    }
    let rise = pulse.velocity_rise_time;
    cells.extend([
        optional(rise.map(|t| t.value)),
        optional(rise.map(|t| t.error)),
    ]);
    cells.push(optional(pulse.energy_pulse.map(|e| e.value)));
    for value in [
        pulse.energy_passed.value,
        pulse.energy_passed.error,
        pulse.energy_behind,
        pulse.energy_lost,
        pulse.closure,
    ] {
        cells.push(number(value));
    }
    cells
}

fn number(value: f64) -> String {
    if value.is_finite() {
        format!("{value:?}")
    } else {
        String::new()
    }
}

fn optional(value: Option<f64>) -> String {
    value.map_or(String::new(), number)
}

/// Attenuation as CSV, one row for each point of a curve: chain, sense, number of bodies, kind of
/// contact, values relative to the homogeneous chain, the share of the high band, and the pulse,
/// with all digits. Unknown values are empty.
///
/// # Errors
/// None for results of this library.
pub fn attenuation_csv(attenuation: &Attenuation) -> Result<String, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let own = [
        "chain",
        "sense",
        "bodies",
        "contact_kind",
        "relative_force",
        "relative_velocity",
        "relative_energy",
        "high_band_share",
    ];
    writer.write_record(own.into_iter().chain(PULSE))?;
    for curve in &attenuation.curves {
        for row in &curve.rows {
            let mut cells = vec![
                curve.name.clone(),
                curve.sense.name().to_owned(),
                row.bodies.to_string(),
                row.kind.name().to_owned(),
                optional(row.relative_force),
                optional(row.relative_velocity),
                optional(row.relative_energy),
                optional(row.high_share),
            ];
            cells.extend(pulse(&row.pulse));
            writer.write_record(cells)?;
        }
    }
    text(writer)
}

/// Transmission as CSV, one row for each value of the key and for each extremum: the other keys,
/// the kind of row (`value`, `maximum`, `minimum`), the key, and the force at the wall.
///
/// # Errors
/// None for results of this library.
pub fn transmission_csv(transmission: &Transmission) -> Result<String, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let others = transmission.curves.first();
    let others = others.map_or(Vec::new(), |curve| curve.settings.clone());
    let mut header: Vec<String> = others.into_iter().map(|(key, _)| key).collect();
    header.extend(["row".to_owned(), transmission.key.clone()]);
    let own = [
        "value_error",
        "largest_over_smallest_coefficient",
        "relative_force",
        "relative_force_error",
        "time_of_flight",
        "mean_speed",
    ];
    header.extend(own.into_iter().chain(PULSE).map(str::to_owned));
    writer.write_record(&header)?;
    for curve in &transmission.curves {
        let values = curve.points.iter().map(|point| ("value", 0.0, point));
        let extremes = curve.extremes.iter().map(|extreme| {
            let row = match extreme.is_maximum {
                true => "maximum",
                false => "minimum",
            };
            (row, extreme.value_error, &extreme.point)
        });
        for (row, error, point) in values.chain(extremes) {
            let mut cells: Vec<String> = curve.settings.iter().map(|(_, v)| v.clone()).collect();
            cells.extend([row.to_owned(), number(point.value), number(error)]);
            cells.extend([
                number(point.stiffness_ratio),
                number(point.relative_force),
                number(point.relative_force_error),
                number(point.time_of_flight.value),
                number(point.mean_speed),
            ]);
            cells.extend(pulse(&point.pulse));
            writer.write_record(cells)?;
        }
    }
    text(writer)
}

fn text(writer: csv::Writer<Vec<u8>>) -> Result<String, csv::Error> {
    let bytes = writer.into_inner().map_err(|error| error.into_error())?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
