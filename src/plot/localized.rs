//! Localized waves: their profile, and how they travel.

use std::ops::Range;

use super::Format;
use super::charts::{Curve, Panel, around, draw_panels};
use crate::Result;
use crate::localized::{Alternation, Journey, Ratio, Snapshot, Wave};

/// The profile of a wave: overlaps as `psi = F^{1/p}`, forces, velocities, slow and fast part.
///
/// # Errors
/// [`crate::Error::Draw`].
pub fn wave(wave: &Wave, profile: &Snapshot, format: Format) -> Result<Vec<u8>> {
    let contacts = match wave.alternation {
        Alternation::Stiffness => ["soft contact", "stiff contact"],
        Alternation::Mass => ["before the light site", "behind it"],
    };
    let sites = match wave.alternation {
        Alternation::Stiffness => ["before the soft contact", "behind it"],
        Alternation::Mass => ["heavy site", "light site"],
    };
    let end = 0.55 * profile.time[profile.time.len() - 1];
    let curve = |label: &'static str, values: &[f64]| -> Curve {
        let points = profile.time.iter().copied().zip(values.iter().copied());
        (label, points.filter(|point| point.0.abs() <= end).collect())
    };
    let pair = |labels: [&'static str; 2], values: &[Vec<f64>; 2]| -> Vec<Curve> {
        (labels.into_iter().zip(values))
            .map(|(label, values)| curve(label, values))
            .collect()
    };
    let panel = |name: &str, y_label, curves: Vec<Curve>| Panel {
        title: format!("{name}, order {}, {}", wave.order, titled(wave.ratio())),
        x_label: "time (cells)",
        y_label,
        x: -end..end,
        y: below_names(&curves),
        curves,
    };
    let parts = vec![
        curve("slow part", &profile.slow),
        curve("fast part", &profile.fast),
    ];
    let panels = [
        panel("overlap", "psi", pair(contacts, &profile.psi)),
        panel("force", "force", pair(contacts, &profile.force)),
        panel("velocity", "velocity", pair(sites, &profile.velocity)),
        panel("parts", "psi", parts),
    ];
    draw_panels("localized wave", 2, &panels, format)
}

/// A launched wave: velocities at the start and at the end, in cells from the first one that the
/// wave could be felt in, and how the shape and the energy kept on the way.
///
/// # Errors
/// [`crate::Error::Draw`].
pub fn journey(journey: &Journey, format: Format) -> Result<Vec<u8>> {
    let [start, end] = &journey.velocity;
    let moved = 2 * journey.arrived.cells;
    let length = start.len() - moved;
    let curve = |label: &'static str, values: &[f64]| -> Curve {
        let points = values.iter().enumerate();
        (label, points.map(|(j, v)| (0.5 * j as f64, *v)).collect())
    };
    let velocities = vec![
        curve("at the start", &start[..length]),
        curve("at the end, moved back", &end[moved..]),
    ];
    let title = format!("order {}, {}", journey.order, titled(journey.ratio));
    // Zeros are drawn as rounding.
    let decades = |value: f64| value.abs().max(1e-17).log10();
    let along = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        (0..journey.course.len())
            .map(|i| (journey.course[i].cells as f64, decades(value(i))))
            .collect()
    };
    let course = vec![
        ("shape change", along(&|i| journey.course[i].shape_change)),
        ("energy drift", along(&|i| journey.course[i].energy_drift)),
    ];
    let panels = [
        Panel {
            title: format!("velocity, {title}"),
            x_label: "cell",
            y_label: "velocity",
            x: 0.0..0.5 * length as f64,
            y: below_names(&velocities),
            curves: velocities,
        },
        Panel {
            title: format!("what changes, {title}"),
            x_label: "cells travelled",
            y_label: "decimal logarithm",
            x: 0.0..journey.arrived.cells as f64,
            y: -17.5..0.0,
            curves: course,
        },
    ];
    draw_panels("launched wave", 2, &panels, format)
}

/// A range with room for the curves' names above them.
fn below_names(curves: &[Curve]) -> Range<f64> {
    let range = around(curves);
    range.start..range.end + 0.3 * (range.end - range.start)
}

fn titled(ratio: Ratio) -> String {
    match ratio {
        Ratio::Kappa(kappa) => format!("kappa = {kappa:.6}"),
        Ratio::MassRatio(ratio) => format!("mass ratio = {ratio:.6}"),
    }
}
