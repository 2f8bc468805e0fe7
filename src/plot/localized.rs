//! Localized waves: their profile, and how they travel.

use super::Figure;
use super::axis::around;
use super::layout::FigureLayout;
use super::style::Style;
use crate::localized::{Alternation, Journey, Ratio, Snapshot, Wave};
use crate::sheet::{BLUE, Chart, Series, VERMILLION};

/// The profile of a wave: overlaps as `psi = F^{1/p}`, forces, velocities, slow and fast part.
pub fn wave(wave: &Wave, profile: &Snapshot, style: &Style) -> Figure {
    let sheet = FigureLayout {
        data: format!("order {}, {}", wave.order, titled(wave.ratio())),
        ..FigureLayout::grid("Localized wave", 2, wave_charts(wave, profile))
    };
    sheet.figure("wave", style)
}

pub(crate) fn wave_charts(wave: &Wave, profile: &Snapshot) -> Vec<Chart> {
    let contacts = match wave.alternation {
        Alternation::Stiffness => ["soft contact", "stiff contact"],
        Alternation::Mass => ["before the light site", "behind it"],
    };
    let sites = match wave.alternation {
        Alternation::Stiffness => ["before the soft contact", "behind it"],
        Alternation::Mass => ["heavy site", "light site"],
    };
    let end = 0.55 * profile.time[profile.time.len() - 1];
    let curve = |label: &str, colour, values: &[f64]| {
        let points = profile.time.iter().copied().zip(values.iter().copied());
        let near = points.filter(|point| point.0.abs() <= end);
        Series::line(label, colour, near.collect())
    };
    let pair = |labels: [&str; 2], values: [&[f64]; 2]| {
        let colours = [BLUE, VERMILLION];
        let pairs = labels.into_iter().zip(colours).zip(values);
        pairs
            .map(|((label, colour), values)| curve(label, colour, values))
            .collect()
    };
    let chart = |name: &str, y_label: &str, series: Vec<Series>| Chart {
        x: -end..end,
        y: around(ordinates(&series)),
        ..Chart::of(name, "time (cells)", y_label, series)
    };
    let both = |values: &'_ [Vec<f64>; 2], labels| pair(labels, [&values[0], &values[1]]);
    let parts = pair(["slow part", "fast part"], [&profile.slow, &profile.fast]);
    vec![
        chart("overlap", "ψ = F^(1/p)", both(&profile.psi, contacts)),
        chart("force", "force", both(&profile.force, contacts)),
        chart("velocity", "velocity", both(&profile.velocity, sites)),
        chart("parts", "ψ = F^(1/p)", parts),
    ]
}

fn ordinates(series: &[Series]) -> impl Iterator<Item = f64> + '_ {
    let points = series.iter().flat_map(|series| &series.points);
    points.map(|point| point.1)
}

/// A launched wave: velocities at the start and at the end, in cells from the first one that the
/// wave could be felt in, and how the shape and the energy kept on the way.
pub fn journey(journey: &Journey, style: &Style) -> Figure {
    let sheet = FigureLayout {
        data: format!("order {}, {}", journey.order, titled(journey.ratio)),
        ..FigureLayout::grid("Launched wave", 2, journey_charts(journey))
    };
    sheet.figure("launch", style)
}

pub(crate) fn journey_charts(journey: &Journey) -> Vec<Chart> {
    let [start, end] = &journey.velocity;
    let moved = 2 * journey.arrived.cells;
    let length = start.len() - moved;
    let curve = |label: &str, colour, values: &[f64]| {
        let points = values.iter().enumerate();
        let points = points.map(|(j, v)| (0.5 * j as f64, *v));
        Series::line(label, colour, points.collect())
    };
    let velocities = vec![
        curve("at the start", BLUE, &start[..length]),
        curve("at the end, moved back", VERMILLION, &end[moved..]),
    ];
    // Zeros are drawn as rounding.
    let along = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        (0..journey.travels.len())
            .map(|i| (journey.travels[i].cells as f64, value(i).abs().max(1e-17)))
            .collect()
    };
    let changes = vec![
        Series::line(
            "shape change",
            BLUE,
            along(&|i| journey.travels[i].shape_change),
        ),
        Series::line(
            "energy drift",
            VERMILLION,
            along(&|i| journey.travels[i].energy_drift),
        ),
    ];
    vec![
        Chart {
            x: 0.0..0.5 * length as f64,
            y: around(ordinates(&velocities)),
            ..Chart::of("velocity", "cell", "velocity", velocities)
        },
        Chart {
            x: 0.0..journey.arrived.cells as f64,
            y: 3e-18..1.0,
            log_y: true,
            ..Chart::of(
                "what changes on the way",
                "cells travelled",
                "relative change",
                changes,
            )
        },
    ]
}

fn titled(ratio: Ratio) -> String {
    match ratio {
        Ratio::Kappa(kappa) => format!("kappa = {kappa:.6}"),
        Ratio::MassRatio(ratio) => format!("mass ratio = {ratio:.6}"),
    }
}
