//! Followed pulses as a result that describes itself, with measured ones beside them.

mod key;
mod length;

use serde_json::{Value, json};

use super::{Attenuation, Beside, Compared, Computed, Measured, MeasuredPoint, Transmission};
use crate::chain::scene::Units;
use crate::sheet::{Chart, Describe, Look, PlotRow, Series, Sheet, Table, listed, number};

/// Reasons of failures that are told; all are among the numbers.
const TOLD: usize = 3;

const FORCE: &str = "force / that of the homogeneous chain";

/// Pulses of struck chains, and measured ones beside those of the first curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Followed {
    pub curves: Curves,
    pub measured: Measured,
    pub beside: Beside,
}

/// Against what pulses are followed.
#[derive(Debug, Clone, PartialEq)]
pub enum Curves {
    Length(Attenuation),
    Key(Transmission),
}

impl Followed {
    pub fn new(curves: Curves, measured: Measured) -> Followed {
        let computed = match &curves {
            Curves::Length(found) => found.computed_points(),
            Curves::Key(found) => found.computed_points(),
        };
        Followed {
            beside: measured.beside(&computed.unwrap_or_default()),
            curves,
            measured,
        }
    }

    /// Chains whose run failed, and why.
    pub fn failed(&self) -> &[(String, String)] {
        match &self.curves {
            Curves::Length(found) => &found.failed,
            Curves::Key(found) => &found.failed,
        }
    }

    /// Measured points beside the computed ones, and what could not be compared.
    fn compared(&self, sheet: &mut Sheet) {
        let beside = &self.beside;
        let all = [
            ("measured", &beside.measured),
            ("measured arrival", &beside.measured_arrivals),
        ];
        for (what, points) in all {
            for compared in points {
                let name = format!("{what} at {}", number(compared.measured.at));
                sheet.fact(name, compared_words(compared));
            }
        }
        if !beside.not_compared.is_empty() {
            let text = format!("outside the curve at {}", places(&beside.not_compared));
            sheet.fact("not compared", text);
        }
        let mut none = |what: &str, at: &[f64], why: &str| {
            let message = format!("{what} to compare at {} ({} in all)", places(at), at.len());
            if !at.is_empty() {
                sheet.warn(message, why);
            }
        };
        let why = "where the record begins or ends there, or nothing moves forward, there is none";
        none(
            "no measured largest velocity",
            &beside.measured_without_peak,
            why,
        );
        let why = "what moves from the first sample on, measured or computed, has none";
        none("no measured arrival", &beside.measured_without_arrival, why);
    }
}

impl Describe for Followed {
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = match &self.curves {
            Curves::Length(found) => found.describe(),
            Curves::Key(found) => found.describe(),
        };
        self.compared(&mut sheet);
        let failed = self.failed();
        for (name, why) in failed.iter().take(TOLD) {
            sheet.warn(format!("{name} failed: {why}"), "");
        }
        if failed.len() > TOLD {
            sheet.warn(format!("{} more failed", failed.len() - TOLD), "");
        }
        sheet.numbers(json!(self.beside));
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let charts = match &self.curves {
            Curves::Length(found) => found.charts(&self.measured),
            Curves::Key(found) => found.charts(&self.measured),
        };
        let columns = if charts.len() > 1 { 2 } else { 1 };
        PlotRow::grid(columns, charts)
    }
}

fn places(at: &[f64]) -> String {
    let at: Vec<String> = at.iter().map(|at| number(*at)).collect();
    at.join(", ")
}

fn compared_words(compared: &Compared) -> String {
    let known = |value: Option<f64>, words: fn(String) -> String| value.map(number).map(words);
    let error = known(compared.measured.error, |error| format!(" +- {error}"));
    let within = known(compared.in_errors, |errors| {
        format!(" ({errors} standard errors)")
    });
    let [error, within] = [error, within].map(Option::unwrap_or_default);
    format!(
        "{}{error}, computed {}, difference {}{within}",
        number(compared.measured.value),
        number(compared.computed),
        number(compared.difference)
    )
}

/// Largest velocities and arrivals of the first curve, computed and measured.
fn field_charts(
    x_label: &str,
    units: Units,
    computed: &Computed,
    measured: &Measured,
) -> Vec<Chart> {
    if measured.velocities.is_empty() {
        return Vec::new();
    }
    let [velocity, time] = match units {
        Units::Si => ["velocity (m/s)", "time (s)"],
        Units::None => ["velocity", "time"],
    };
    let chart = |title, label, computed: &[(f64, f64)], measured| {
        let mut series = vec![Series::line("computed", 0, computed.to_vec())];
        series.extend(laid_over(measured));
        Chart::of(title, x_label, label, series)
    };
    let arrival = "arrival: half of the largest velocity";
    vec![
        chart(
            "largest velocity",
            velocity,
            &computed.velocities,
            &measured.velocities,
        ),
        chart(arrival, time, &computed.arrivals, &measured.arrivals),
    ]
}

fn laid_over(measured: &[MeasuredPoint]) -> Option<Series> {
    let points = measured.iter();
    let points = points.map(|p| [p.at, p.value, p.error.unwrap_or(0.0)]);
    (!measured.is_empty()).then(|| Series::with_errors("measured", 6, points).with(Look::Dots))
}

/// The points that rows have.
fn points<T>(rows: &[T], of: impl Fn(&T) -> Option<(f64, f64)>) -> Vec<(f64, f64)> {
    rows.iter().filter_map(of).collect()
}

/// Names of keys with their values.
fn named(settings: &[(String, String)]) -> String {
    let named = settings.iter();
    let named = named.map(|(key, text)| format!("{} {text}", key.replace('_', " ")));
    listed(&named.collect::<Vec<_>>())
}

/// The numbers of a pulse: their names, and where they are in the JSON of a row.
const PULSE: &str = "\
peak_force: /pulse/peak_force/value
peak_force_error: /pulse/peak_force/error
peak_time: /pulse/peak_time/value
peak_time_error: /pulse/peak_time/error
peak_velocity: /pulse/peak_velocity/value
peak_velocity_error: /pulse/peak_velocity/error
velocity_time: /pulse/velocity_time/value
velocity_time_error: /pulse/velocity_time/error
arrival_time: /pulse/arrival_time/value
arrival_time_error: /pulse/arrival_time/error
width: /pulse/width/value
width_error: /pulse/width/error
velocity_rise_time: /pulse/velocity_rise_time/value
velocity_rise_time_error: /pulse/velocity_rise_time/error
energy_pulse: /pulse/energy_pulse/value
energy_passed: /pulse/energy_passed/value
energy_passed_error: /pulse/energy_passed/error
energy_behind: /pulse/energy_behind
energy_lost: /pulse/energy_lost
energy_closure: /pulse/closure";

/// Rows with these columns, and behind them the numbers of their pulse.
fn records(columns: &[(&str, &str)], rows: impl Iterator<Item = Value>) -> Table {
    let pulse = PULSE.lines().filter_map(|line| line.split_once(": "));
    let columns: Vec<(&str, &str)> = columns.iter().copied().chain(pulse).collect();
    Table::of_places(&columns, rows)
}
