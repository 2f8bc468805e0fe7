//! Ridges: over the spectrum, and the velocities along them.

use super::chart::{BLACK, BLUE, Chart, Level, Look, Series, VERMILLION, extent};
use super::figures::spacetime_spectrum;
use super::labels;
use super::sheet::{PlotRow, Sheet};
use super::style::Style;
use super::{Figure, PALETTE};
use crate::ridges::{RidgePoint, Ridges};
use crate::unit::label;

/// Velocities known no better than this share of them are not drawn.
const RESOLVED: f64 = 0.3;

/// The space-time spectrum with its ridges and fitted laws, and the points with their velocities.
pub fn ridges(found: &Ridges, name: &str, style: &Style) -> Vec<Figure> {
    let mut figures: Vec<Figure> = spacetime_spectrum(&found.analysis, style)
        .into_iter()
        .collect();
    let mut charts = ridge_charts(found);
    if charts.is_empty() {
        return figures;
    }
    let mut rows = vec![PlotRow::of([charts.remove(0)]).high(1.2)];
    if !charts.is_empty() {
        rows.push(PlotRow::of(charts));
    }
    let sheet = Sheet {
        title: "Ridges of S(k, f)".into(),
        data: name.into(),
        rows,
        notes: vec![match found.is_single() {
            true => format!(
                "Peaks exceed {:.1} times the background about them.",
                found.level
            ),
            false => format!(
                "Peaks exceed {:.1} times the noise about them; noise does so anywhere with probability {}.",
                found.level, found.alpha
            ),
        }],
        ..Sheet::default()
    };
    figures.push(sheet.figure("ridges", style));
    figures
}

/// f over k with the fitted laws, phase velocity and group velocity over f; none without ridges.
pub(crate) fn ridge_charts(found: &Ridges) -> Vec<Chart> {
    if found.ridges.is_empty() {
        return Vec::new();
    }
    let axes = &found.analysis.axes;
    let mut places = Vec::new();
    for branch in 0..found.branches() {
        let name = if branch < PALETTE.len() - 1 {
            format!("branch {branch}")
        } else {
            String::new()
        };
        let points = of_branch(found, branch, |p| (p.wavenumber, p.frequency));
        places.push(Series::line(name, branch % (PALETTE.len() - 1), points).with(Look::Dots));
    }
    for fit in &found.fits {
        for (n, branch) in fit.curve.branches.iter().enumerate() {
            let name = if n == 0 {
                fit.curve.name.clone()
            } else {
                String::new()
            };
            places.push(Series::of(name, BLACK, &fit.curve.wavenumber, branch).with(Look::Dashed));
        }
    }
    let frequency = labels::frequency(axes);
    let mut charts = vec![Chart {
        x: extent(axes.wavenumber_signed.iter().copied()),
        ..Chart::of("", labels::wavenumber(axes), frequency.clone(), places)
    }];
    let unit = format!("{}/{}", axes.space_unit(), axes.time_unit());
    let velocity = |value: f64, error: f64| {
        if error < RESOLVED * value.abs() {
            value
        } else {
            f64::NAN
        }
    };
    let phase = velocities(found, "phase velocity", BLUE, |p| {
        // That of a transient is as good as the place of its peak, without an error; slopes are not.
        if found.is_single() {
            return (p.phase_velocity, 0.0);
        }
        (
            velocity(p.phase_velocity, p.phase_velocity_error),
            p.phase_velocity_error,
        )
    });
    let group = velocities(found, "group velocity", VERMILLION, |p| {
        (
            velocity(p.group_velocity, p.group_velocity_error),
            p.group_velocity_error,
        )
    });
    for series in [phase, group].into_iter().flatten() {
        let title = series.label.clone();
        let series = Series {
            label: String::new(),
            ..series
        };
        charts.push(Chart {
            levels: vec![Level {
                at: 0.0,
                label: String::new(),
            }],
            ..Chart::of(
                title,
                frequency.clone(),
                label("velocity", &unit),
                vec![series],
            )
        });
    }
    charts
}

fn of_branch(
    found: &Ridges,
    branch: usize,
    of: impl Fn(&RidgePoint) -> (f64, f64),
) -> Vec<(f64, f64)> {
    let ridges = found.ridges.iter().filter(|ridge| ridge.branch == branch);
    ridges
        .flat_map(|ridge| ridge.points.iter().map(&of))
        .collect()
}

fn velocities(
    found: &Ridges,
    name: &str,
    colour: usize,
    of: impl Fn(&RidgePoint) -> (f64, f64),
) -> Option<Series> {
    let known = found.points().map(|point| (point.frequency, of(point)));
    let known: Vec<_> = known.filter(|(_, (value, _))| value.is_finite()).collect();
    (known.len() > 1).then(|| Series {
        errors: known.iter().map(|(_, (_, error))| *error).collect(),
        ..Series::line(
            name,
            colour,
            known.iter().map(|(f, (v, _))| (*f, *v)).collect(),
        )
        .with(Look::Dots)
    })
}
