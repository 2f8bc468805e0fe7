//! A spectrum with its power law, compensated, and the slope against time.

use super::Figure;
use super::chart::{BLACK, BLUE, Chart, GREEN, Level, Look, Series, VERMILLION, extent};
use super::legend::Marker;
use super::sheet::{PlotRow, Sheet};
use super::style::Style;
use super::uprights::Mark;
use crate::estimates::{ExponentBasis, FieldAxis, Slope};
use crate::unit::{compose, label, square};

/// Ordinates of a spectrum reach this far below the largest.
const DEEPEST: f64 = 1e-16;
/// Slopes are drawn down to this.
const STEEPEST: f64 = -12.0;

/// The spectrum with its law, compensated beside it, and the slope against time below.
pub fn slope(found: &Slope, name: &str, style: &Style) -> Figure {
    let charts = slope_charts(found);
    let rows = charts
        .chunks(2)
        .map(|pair| PlotRow::of(pair.to_vec()))
        .collect();
    let basis = match found.law.basis {
        ExponentBasis::Shots => format!("over {} shots", found.shots),
        ExponentBasis::Regression => "of the regression".into(),
    };
    let note = format!(
        "Slope {:.3} ± {:.3}: {} % interval {basis}, over {} bins.",
        found.law.slope,
        found.law.half,
        100.0 * (1.0 - found.alpha),
        found.law.points
    );
    let sheet = Sheet {
        title: "Slope of the spectrum".into(),
        data: name.into(),
        rows,
        notes: vec![note],
        ..Sheet::default()
    };
    sheet.figure("slope", style)
}

/// The spectrum, compensated, and along x slope and gradient against time.
pub(crate) fn slope_charts(found: &Slope) -> Vec<Chart> {
    let (time_unit, space_unit) = found.units();
    let unit = found.unit.as_deref().unwrap_or_default();
    let x_label = match found.axis {
        FieldAxis::Space => label("wavenumber k", &format!("rad/{space_unit}")),
        FieldAxis::Time => label("frequency f", &crate::measure::cycles_per(&time_unit)),
    };
    let density = match found.axis {
        FieldAxis::Space => compose(&[&square(unit)], &[&format!("rad/{space_unit}")]),
        FieldAxis::Time => compose(&[&square(unit)], &[&crate::measure::cycles_per(&time_unit)]),
    };
    let positive = |values: &[f64]| -> Vec<(f64, f64)> {
        let pairs = found.abscissa.iter().copied().zip(values.iter().copied());
        pairs.filter(|(x, y)| *x > 0.0 && *y > 0.0).collect()
    };
    let law = &found.law;
    let on_law = |x: f64| (x, law.prefactor * x.powf(law.slope));
    let mut series = vec![
        Series::line("spectrum", BLUE, positive(&found.spectrum)),
        Series::line(
            format!("slope {:.3}", law.slope),
            VERMILLION,
            law.band.map(on_law).to_vec(),
        )
        .with(Look::Dashed),
    ];
    if let Some(breaks) = &found.breaks {
        let mut ends = vec![law.band[0]];
        ends.extend(&breaks.at);
        ends.push(law.band[1]);
        let slopes: Vec<String> = breaks
            .slopes
            .iter()
            .map(|slope| format!("{slope:.2}"))
            .collect();
        let points = ends.iter().map(|x| (*x, breaks.at_logarithm(x.ln()).exp()));
        let name = format!("with breaks: {}", slopes.join(", "));
        series.push(Series::line(name, GREEN, points.collect()));
    }
    let drawn = extent(series[0].points.iter().map(|p| p.1));
    let bands = law.band.map(|at| Mark {
        at,
        label: String::new(),
    });
    let spectrum = Chart {
        log_x: true,
        log_y: true,
        y: drawn.start.max(DEEPEST * drawn.end) / 2.0..3.0 * drawn.end,
        marks: bands.to_vec(),
        ..Chart::of(
            "",
            &x_label,
            label("power spectral density", &density),
            series,
        )
    };
    let points = positive(&found.compensated());
    let in_band = points
        .iter()
        .filter(|p| (law.band[0]..=law.band[1]).contains(&p.0));
    let seen = extent(in_band.map(|p| p.1));
    let compensated = Chart {
        log_x: true,
        log_y: true,
        y: (seen.start / 10.0).min(0.1)..(seen.end * 10.0).max(10.0),
        levels: vec![Level {
            at: 1.0,
            label: "the law".into(),
        }],
        marks: bands.to_vec(),
        ..Chart::of(
            "",
            &x_label,
            format!(
                "spectrum over {}^{:.3}",
                abscissa_symbol(found.axis),
                law.slope
            ),
            vec![Series::line("compensated spectrum", BLUE, points)],
        )
    };
    let mut charts = vec![spectrum, compensated];
    charts.extend(frame_charts(found, &time_unit));
    charts
}

fn abscissa_symbol(axis: FieldAxis) -> &'static str {
    match axis {
        FieldAxis::Space => "k",
        FieldAxis::Time => "f",
    }
}

fn frame_charts(found: &Slope, time_unit: &str) -> Vec<Chart> {
    let Some(frames) = found.frames.as_ref().filter(|frames| frames.time.len() > 2) else {
        return Vec::new();
    };
    let pairs = frames
        .time
        .iter()
        .copied()
        .zip(frames.slope.iter().copied());
    let points: Vec<(f64, f64)> = pairs.filter(|(_, slope)| slope.is_finite()).collect();
    let errors = frames
        .half
        .iter()
        .zip(&frames.slope)
        .filter(|(_, slope)| slope.is_finite());
    let series = Series {
        errors: errors
            .map(|(half, _)| if half.is_finite() { *half } else { 0.0 })
            .collect(),
        ..Series::line("", BLUE, points).marked(Marker::Circle)
    };
    let marks: Vec<Mark> = found
        .steepening
        .iter()
        .map(|steep| Mark {
            at: steep.shock_time,
            label: "shock time".into(),
        })
        .collect();
    let seen = extent(series.points.iter().map(|p| p.1));
    let slope = Chart {
        y: (seen.start - 0.5).max(STEEPEST)..(seen.end + 0.5).max(0.0),
        marks: marks.clone(),
        levels: [(-2.0, "−2 and −8/3"), (-8.0 / 3.0, "")]
            .map(|(at, words)| Level {
                at,
                label: words.into(),
            })
            .to_vec(),
        ..Chart::of(
            "",
            label("time t", time_unit),
            "slope over the band",
            vec![series],
        )
    };
    let first = frames.gradient.first().copied().unwrap_or(1.0);
    let inverse: Vec<f64> = frames.gradient.iter().map(|g| first / g).collect();
    let mut series = vec![Series::of("", BLUE, &frames.time, &inverse).marked(Marker::Circle)];
    if let Some(steep) = &found.steepening {
        let start = (frames.time[0], 1.0);
        let line = vec![start, (steep.shock_time, 0.0)];
        series.push(Series::line("to the shock time", BLACK, line).with(Look::Dashed));
    }
    let gradient = Chart {
        marks,
        ..Chart::of(
            "",
            label("time t", time_unit),
            "first over largest |∂v/∂x|",
            series,
        )
    };
    vec![slope, gradient]
}
