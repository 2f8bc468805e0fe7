//! Structure functions, flatness, third moment and histograms of increments.

use super::Figure;
use super::chart::{BLACK, BLUE, Chart, Level, Look, Series, extent};
use super::legend::Marker;
use super::sheet::{PlotRow, Sheet};
use super::style::Style;
use crate::estimates::{AxisIncrements, FieldAxis, Increments, IntervalBasis, ScaleMoments};
use crate::unit::label;

/// Largest exponent of ten between the ends of an axis of histograms.
const DEEPEST: f64 = 1e-7;

/// A figure of structure functions, with a row an axis.
pub fn increments(found: &Increments, name: &str, style: &Style) -> Figure {
    let mut rows = Vec::new();
    for axis in &found.axes {
        let charts = increment_charts(found, axis);
        rows.extend(charts.chunks(2).map(|pair| PlotRow::of(pair.to_vec())));
    }
    let percent = 100.0 * (1.0 - found.alpha);
    let note = match found.basis {
        IntervalBasis::Shots => format!("Bars: {percent} % intervals over {} shots.", found.shots),
        IntervalBasis::Parts => {
            format!("Bars: {percent} % intervals over 16 parts of the record, taken as stationary.")
        }
        IntervalBasis::None => "A transient is one realisation: no interval can be stated.".into(),
    };
    let sheet = Sheet {
        title: "Increments against scale".into(),
        data: name.into(),
        rows,
        notes: vec![note],
        ..Sheet::default()
    };
    sheet.figure("increments", style)
}

/// Structure functions, flatness, skewness and histograms along one axis.
pub(crate) fn increment_charts(found: &Increments, axis: &AxisIncrements) -> Vec<Chart> {
    let (time_unit, space_unit) = found.units();
    let (scale_label, along) = match axis.axis {
        FieldAxis::Space => (label("separation r", &space_unit), "along x"),
        FieldAxis::Time => (label("lag τ", &time_unit), "in time"),
    };
    let points = |of: &dyn Fn(&ScaleMoments) -> f64| -> Vec<(f64, f64)> {
        axis.scales.iter().map(|m| (m.scale, of(m))).collect()
    };
    let errors = |of: &dyn Fn(&ScaleMoments) -> f64| -> Vec<f64> {
        let halves = axis.scales.iter().map(of);
        halves
            .map(|half| if half.is_finite() { half } else { 0.0 })
            .collect()
    };
    let logarithmic = axis.scales.len() > 3;
    let structure = (0..6).map(|p| {
        let name = format!("p = {}", p + 1);
        // The roots have the unit of the samples and one range.
        let root = 1.0 / (p + 1) as f64;
        Series::line(name, p, points(&|m| m.structure[p].powf(root)))
    });
    let mut structure: Vec<Series> = structure.collect();
    if let Some(fit) = &axis.exponents {
        let at = |p: usize, scale: f64| {
            let in_band = |m: &&ScaleMoments| (fit.band[0]..=fit.band[1]).contains(&m.scale);
            let logs: Vec<(f64, f64)> = axis
                .scales
                .iter()
                .filter(in_band)
                .map(|m| (m.scale.ln(), m.structure[p].ln()))
                .collect();
            let n = logs.len() as f64;
            let (x, y) = logs
                .iter()
                .fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
            ((y + fit.exponents[p] * (scale.ln() - x)) / (p + 1) as f64).exp()
        };
        for p in [0, 1, 2, 3, 4, 5] {
            let ends = fit.band.map(|scale| (scale, at(p, scale)));
            let name = if p == 0 {
                "power laws over the band"
            } else {
                ""
            };
            structure.push(Series::line(name, 6, ends.to_vec()).with(Look::Dashed));
        }
    }
    let unit = found.unit.as_deref().unwrap_or_default();
    let values = structure.iter().flat_map(|s| &s.points).map(|p| p.1);
    let y = extent(values.filter(|v| *v > 0.0));
    let flatness = Series {
        errors: errors(&ScaleMoments::flatness_half),
        ..Series::line("", BLUE, points(&|m| m.flatness)).marked(Marker::Circle)
    };
    let skewness = Series {
        errors: errors(&ScaleMoments::skewness_half),
        ..Series::line("", BLUE, points(&|m| m.skewness)).marked(Marker::Circle)
    };
    let normal = |at: f64, words: &str| {
        vec![Level {
            at,
            label: words.into(),
        }]
    };
    let mut flat = Chart {
        log_x: logarithmic,
        levels: normal(3.0, "normal distribution"),
        ..Chart::of(
            format!("flatness, {along}"),
            &scale_label,
            "flatness ⟨d⁴⟩/⟨d²⟩²",
            vec![flatness],
        )
    };
    flat.y = 0.0..flat.y.end.max(3.5);
    let mut skew = Chart {
        log_x: logarithmic,
        levels: normal(0.0, ""),
        ..Chart::of(
            format!("third moment with its sign, {along}"),
            &scale_label,
            "skewness ⟨d³⟩/⟨d²⟩^(3/2)",
            vec![skewness],
        )
    };
    let most = skew.y.start.abs().max(skew.y.end.abs()).max(0.1);
    skew.y = -most..most;
    let mut charts = vec![
        Chart {
            log_x: logarithmic,
            log_y: true,
            y: y.start / 1.2..1.2 * y.end,
            ..Chart::of(
                format!("structure functions, {along}"),
                &scale_label,
                label("⟨|d|ᵖ⟩^(1/p)", unit),
                structure,
            )
        },
        flat,
        skew,
    ];
    charts.extend(histogram_chart(found, axis, along));
    charts
}

fn histogram_chart(found: &Increments, axis: &AxisIncrements, along: &str) -> Option<Chart> {
    let (time_unit, space_unit) = found.units();
    let (symbol, unit) = match axis.axis {
        FieldAxis::Space => ("r", space_unit),
        FieldAxis::Time => ("τ", time_unit),
    };
    let centres = |edges: &[f64]| -> Vec<f64> {
        edges
            .windows(2)
            .map(|pair| 0.5 * (pair[0] + pair[1]))
            .collect()
    };
    let series = axis.histograms.iter().enumerate().map(|(i, histogram)| {
        let scale = axis.scales[histogram.index].scale;
        let points = centres(&histogram.edges)
            .into_iter()
            .zip(histogram.density.iter().copied());
        let there = points.filter(|(_, density)| *density > 0.0);
        Series::line(format!("{symbol} = {scale:.4} {unit}"), i, there.collect())
    });
    let mut series: Vec<Series> = series.collect();
    let first = axis.histograms.first()?;
    let normal = centres(&first.edges).into_iter().map(|x| {
        let density = (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
        (x, density)
    });
    series.push(Series::line("normal distribution", BLACK, normal.collect()).with(Look::Dashed));
    let densities = axis
        .histograms
        .iter()
        .flat_map(|h| h.density.iter().copied());
    let seen = extent(densities.filter(|v| *v > 0.0));
    Some(Chart {
        log_y: true,
        x: -10.0..10.0,
        y: seen.start.max(DEEPEST) / 2.0..2.0 * seen.end.max(0.4),
        ..Chart::of(
            format!("histograms of increments, {along}"),
            "increment over its root mean square",
            "probability density",
            series,
        )
    })
}
