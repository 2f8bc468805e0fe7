//! Coherence against a reference: its map, delays along x, phase velocity.

use ndarray::Axis as Along;

use super::Figure;
use super::chart::{BLUE, Chart, Level, Look, Series};
use super::heat_chart::HeatChart;
use super::sheet::{PlotRow, Sheet};
use super::short::edges;
use super::style::Style;
use super::uprights::Mark;
use crate::estimates::Coherence;
use crate::unit::label;

/// The coherence of all sites with the reference, their delays, and the phase velocity.
pub fn coherence(found: &Coherence, name: &str, style: &Style) -> Figure {
    let mut rows = vec![PlotRow::of([coherence_map(found)]).high(1.3)];
    let charts = coherence_charts(found);
    if !charts.is_empty() {
        rows.push(PlotRow::of(charts));
    }
    let note = match found.level() {
        Some(level) => format!(
            "A cell exceeds {level:.3} by chance with probability {}.",
            found.alpha
        ),
        None => "No significance can be stated: too few independent realisations.".into(),
    };
    let sheet = Sheet {
        title: "Coherence with a reference site".into(),
        data: name.into(),
        rows,
        notes: vec![note],
        ..Sheet::default()
    };
    sheet.figure("coherence", style)
}

pub(crate) fn coherence_map(found: &Coherence) -> HeatChart {
    let (time_unit, space_unit) = found.units();
    let positions: Vec<f64> = found.positions();
    let (left, right) = edges(&positions);
    let (low, high) = edges(&found.frequency);
    // Time runs upwards in maps of fields, frequency here.
    HeatChart {
        title: String::new(),
        x_label: label("position x", &space_unit),
        y_label: label("frequency f", &crate::measure::cycles_per(&time_unit)),
        label: "coherence γ²".into(),
        x: left..right,
        y: low.max(0.0)..high,
        log_x: false,
        values: found.coherence.clone(),
        scale: 0.0..1.0,
        marks: vec![Mark {
            at: positions[found.reference],
            label: "reference".into(),
        }],
    }
}

/// Delays and phase velocities, where there are any.
pub(crate) fn coherence_charts(found: &Coherence) -> Vec<Chart> {
    let (time_unit, space_unit) = found.units();
    let mut charts = Vec::new();
    let delays: Vec<(f64, f64, f64)> = found
        .delays
        .iter()
        .zip(found.positions())
        .filter_map(|(delay, x)| delay.map(|delay| (x, delay.delay, delay.error)))
        .collect();
    if delays.len() > 1 {
        let points = delays.iter().map(|(x, delay, _)| (*x, *delay)).collect();
        let series = Series {
            errors: delays.iter().map(|(_, _, error)| *error).collect(),
            ..Series::line("", BLUE, points).with(Look::Dots)
        };
        charts.push(Chart {
            levels: vec![Level {
                at: 0.0,
                label: String::new(),
            }],
            ..Chart::of(
                "delay behind the reference",
                label("position x", &space_unit),
                label("delay", &time_unit),
                vec![series],
            )
        });
    }
    // Where the wavenumber is not resolved, the velocity is not.
    let resolved = found
        .speeds
        .iter()
        .filter(|speed| speed.velocity_error < 0.5 * speed.velocity.abs());
    let resolved: Vec<_> = resolved.collect();
    if resolved.len() > 1 {
        let points = resolved
            .iter()
            .map(|speed| (speed.frequency, speed.velocity));
        let series = Series {
            errors: resolved.iter().map(|speed| speed.velocity_error).collect(),
            ..Series::line("", BLUE, points.collect()).with(Look::Dots)
        };
        charts.push(Chart::of(
            "phase velocity",
            label("frequency f", &crate::measure::cycles_per(&time_unit)),
            label("velocity", &format!("{space_unit}/{time_unit}")),
            vec![series],
        ));
    }
    charts
}

/// Largest coherence away from the reference at each frequency, and its mean.
pub(crate) fn coherence_by_frequency(found: &Coherence) -> Chart {
    let mean = |row: ndarray::ArrayView1<f64>| {
        let others = row
            .iter()
            .enumerate()
            .filter(|(j, _)| *j != found.reference);
        let known: Vec<f64> = others.map(|(_, g)| *g).filter(|g| g.is_finite()).collect();
        known.iter().sum::<f64>() / known.len() as f64
    };
    let means: Vec<f64> = found.coherence.axis_iter(Along(0)).map(mean).collect();
    let (time_unit, _) = found.units();
    let levels = found.level().map(|at| Level {
        at,
        label: "level of one cell".into(),
    });
    Chart {
        y: 0.0..1.0,
        levels: levels.into_iter().collect(),
        ..Chart::of(
            "mean coherence of the other sites",
            label("frequency f", &crate::measure::cycles_per(&time_unit)),
            "coherence γ²",
            vec![Series::of("", BLUE, &found.frequency, &means)],
        )
    }
}
