//! What results on records share: places and units in words, records beside those of a run, what is left.

use ndarray::Array2;

use super::records::Records;
use super::verdict::{Misfit, frequencies, mean_density};
use crate::field::Quantity;
use crate::measure::cycles_per;
use crate::sheet::{
    BLUE, Chart, Colors, HeatChart, Look, Role, Series, VERMILLION, listed, number, range,
};
use crate::unit::{compose, label, square};

/// Records that are drawn, and bodies that a sentence names, at most.
const DRAWN: usize = 4;
const NAMED: usize = 4;

/// What records of a quantity are at.
pub(super) fn places(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Force => "contacts",
        _ => "bodies",
    }
}

/// Some places of a quantity: `body 3`, `bodies 3, 5 and others`.
pub(super) fn some_places(quantity: Quantity, bodies: &[usize], most: usize) -> String {
    let shown: Vec<String> = bodies.iter().take(most).map(usize::to_string).collect();
    match (bodies.len(), quantity) {
        (1, Quantity::Force) => format!("contact {}", shown[0]),
        (1, _) => format!("body {}", shown[0]),
        (count, _) if count > most => format!(
            "{} {} and {} more",
            places(quantity),
            shown.join(", "),
            count - most
        ),
        _ => format!("{} {}", places(quantity), listed(&shown)),
    }
}

/// The unit of frequencies beside times of a unit; empty for none.
pub(super) fn per_time(time: &str) -> String {
    if time.is_empty() {
        String::new()
    } else {
        cycles_per(time)
    }
}

/// A number with its unit, if it has one.
pub(super) fn with_unit(value: f64, unit: &str) -> String {
    format!("{} {unit}", number(value)).trim().to_owned()
}

impl Misfit {
    /// Where noise explains nothing, in words.
    pub(super) fn place(&self, records: &Records) -> String {
        let mut words = match self.is_everywhere {
            true => format!("at all {}", places(records.quantity)),
            false => format!("at {}", some_places(records.quantity, &self.bodies, NAMED)),
        };
        let time = &records.units[0];
        let ends = [records.times[0], records.times[records.times.len() - 1]];
        if let Some([from, to]) = self.times {
            words += &match (from <= ends[0], to >= ends[1]) {
                (false, true) => format!(", after {}", with_unit(from, time)),
                (true, false) => format!(", until {}", with_unit(to, time)),
                _ => format!(
                    ", from {} to {}",
                    with_unit(from, time),
                    with_unit(to, time)
                ),
            };
        }
        let at = |f: f64| with_unit(f, &per_time(time));
        let nyquist = 0.5 / records.step();
        let [low, high] = self.frequencies;
        words += &match (low < 0.02 * nyquist, high > 0.9 * nyquist) {
            (true, true) => String::new(),
            (false, true) => format!(", above {}", at(low)),
            (true, false) => format!(", below {}", at(high)),
            (false, false) => format!(", between {} and {}", at(low), at(high)),
        };
        words
    }
}

/// Some measured records with those of a run.
pub(super) fn record_charts(
    records: &Records,
    measured: &Array2<f64>,
    (name, run): (&str, &Array2<f64>),
) -> Vec<Chart> {
    let sites = records.bodies.len();
    let count = DRAWN.min(sites);
    let shown = (0..count).map(|i| i * (sites - 1) / (count - 1).max(1));
    let chart = |site: usize| {
        let of = |values: &Array2<f64>| values.column(site).to_vec();
        Chart::of(
            some_places(records.quantity, &records.bodies[site..=site], 1),
            label("time t", &records.units[0]),
            label(records.quantity.name(), &records.units[1]),
            vec![
                Series::of("measured", BLUE, &records.times, &of(measured)),
                Series::of(name, VERMILLION, &records.times, &of(run)).with(Look::Dashed),
            ],
        )
    };
    shown.map(chart).collect()
}

/// What is measured beyond a run.
pub(super) fn residual_map(records: &Records, residual: &Array2<f64>, name: &str) -> HeatChart {
    let known = residual.iter().filter(|v| v.is_finite());
    let bodies: Vec<f64> = records.bodies.iter().map(|body| *body as f64).collect();
    let is_even = bodies.windows(3).all(|at| at[2] - at[1] == at[1] - at[0]);
    let is_rising = bodies.windows(2).all(|at| at[1] > at[0]);
    let (x_label, x) = match is_even && is_rising {
        true => ("body", range(&bodies)),
        false => ("record", -0.5..bodies.len() as f64 - 0.5),
    };
    let largest = known.fold(0.0, |m: f64, v| m.max(v.abs()));
    HeatChart {
        title: "what is left".into(),
        caption: format!("Measured less {name}. Noise looks the same everywhere."),
        x_label: x_label.into(),
        y_label: label("time t", &records.units[0]),
        label: label(records.quantity.name(), &records.units[1]),
        x,
        y: range(&records.times),
        values: residual.clone(),
        colors: Colors::Between(-largest..largest),
        roles: Some([Role::Position, Role::Time]),
        ..HeatChart::default()
    }
}

/// Mean power spectral densities of records, missing samples as 0.
pub(super) fn spectrum_chart<const N: usize>(
    records: &Records,
    planes: [(&str, usize, &Array2<f64>); N],
) -> Chart {
    let series = planes.map(|(name, colour, plane)| {
        let columns = plane.columns().into_iter().flatten();
        let grid: Vec<f64> = columns
            .map(|v| if v.is_finite() { *v } else { 0.0 })
            .collect();
        let density = mean_density(&grid, records);
        Series::of(name, colour, &frequencies(records)[1..], &density[1..])
    });
    let [frequency, density] = spectral_units(records);
    Chart::of(
        "by frequency",
        label("frequency f", &frequency),
        label("mean power spectral density", &density),
        series.into(),
    )
    .logarithmic()
}

/// Of frequencies and of power spectral densities.
pub(super) fn spectral_units(records: &Records) -> [String; 2] {
    let [time, sample] = &records.units;
    let frequency = per_time(time);
    let density = match sample.is_empty() {
        true => String::new(),
        false => compose(&[&square(sample)], &[&frequency]),
    };
    [frequency, density]
}
