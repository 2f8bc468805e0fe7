//! Eigenvalue spectra and modes of a spectral proper orthogonal decomposition.

use super::Figure;
use super::chart::{BLACK, BLUE, Chart, GREEN, Look, SKY, Series, VERMILLION, extent};
use super::sheet::{PlotRow, Sheet};
use super::style::Style;
use crate::estimates::{ModeShapes, Modes};
use crate::unit::{compose, label, square};

/// Eigenvalues that are drawn.
const SHOWN: usize = 3;
/// Chosen frequencies whose first mode is drawn.
const FREQUENCIES: usize = 4;
/// Ordinates of a logarithmic chart reach this far below the largest.
const DEEPEST: f64 = 1e-9;

/// The eigenvalues by frequency, the share of the first, and the first mode of each chosen frequency.
pub fn modes(found: &Modes, name: &str, style: &Style) -> Figure {
    let mut charts = mode_charts(found).into_iter();
    let mut rows = vec![PlotRow::of(charts.by_ref().take(2).collect::<Vec<_>>())];
    let shapes: Vec<Chart> = charts.collect();
    rows.extend(shapes.chunks(2).map(|pair| PlotRow::of(pair.to_vec())));
    let note = match found.interval(1) {
        Some([low, high]) => format!(
            "The {} % interval of an eigenvalue reaches from {low:.2} to {high:.2} of it, by chi-square.",
            100.0 * (1.0 - found.alpha)
        ),
        None => "No interval can be stated: too few independent realisations.".into(),
    };
    let sheet = Sheet {
        title: "Modes that are coherent along x".into(),
        data: name.into(),
        rows,
        notes: vec![note],
        ..Sheet::default()
    };
    sheet.figure("modes", style)
}

/// Eigenvalues, the share of the first, and first modes.
pub(crate) fn mode_charts(found: &Modes) -> Vec<Chart> {
    let mut charts = vec![eigenvalue_chart(found), share_chart(found)];
    let shapes = found.chosen.iter().take(FREQUENCIES);
    charts.extend(shapes.filter_map(|shapes| shape_chart(found, shapes)));
    charts
}

fn frequency_label(found: &Modes) -> String {
    label("frequency f", &crate::measure::cycles_per(&found.units().0))
}

fn eigenvalue_chart(found: &Modes) -> Chart {
    let unit = found.unit.as_deref().unwrap_or_default();
    let word = |axis: &crate::field::Axis| axis.unit.clone().unwrap_or_default();
    let unit = compose(
        &[&square(unit), &word(&found.time), &word(&found.space)],
        &[],
    );
    let inside = || (1..found.frequency.len()).map(|bin| (bin, found.frequency[bin]));
    let curve = |n: usize| -> Vec<(f64, f64)> {
        let points = inside().map(|(bin, f)| (f, found.eigenvalues[[bin, n]]));
        points.collect()
    };
    let total = inside().map(|(bin, f)| (f, found.total[bin])).collect();
    let mut series = vec![Series::line("all modes", BLACK, total).with(Look::Dashed)];
    for (n, colour) in [BLUE, VERMILLION, GREEN]
        .into_iter()
        .enumerate()
        .take(SHOWN)
    {
        if n < found.eigenvalues.ncols() {
            series.push(Series::line(format!("mode {}", n + 1), colour, curve(n)));
        }
    }
    if found.interval(1).is_some() {
        let percent = 100.0 * (1.0 - found.alpha);
        for end in 0..2 {
            let points = inside().filter_map(|(bin, f)| {
                let factor = found.interval(bin)?[end];
                Some((f, found.eigenvalues[[bin, 0]] * factor))
            });
            let name = match end {
                0 => format!("mode 1, {percent} % interval"),
                _ => String::new(),
            };
            series.push(Series::line(name, SKY, points.collect()).with(Look::Dashed));
        }
    }
    let values = series.iter().flat_map(|s| &s.points).map(|p| p.1);
    let y = extent(values.filter(|v| *v > 0.0));
    Chart {
        log_x: found.frequency.len() > 16,
        log_y: true,
        y: y.start.max(DEEPEST * y.end) / 1.5..1.5 * y.end,
        ..Chart::of(
            "eigenvalues",
            frequency_label(found),
            label("eigenvalue λ", &unit),
            series,
        )
    }
}

fn share_chart(found: &Modes) -> Chart {
    let points =
        (1..found.frequency.len()).map(|bin| (found.frequency[bin], found.leading_share(bin)));
    Chart {
        log_x: found.frequency.len() > 16,
        y: 0.0..1.0,
        ..Chart::of(
            "share of the first mode",
            frequency_label(found),
            "share of the power",
            vec![Series::line("", BLUE, points.collect())],
        )
    }
}

fn shape_chart(found: &Modes, shapes: &ModeShapes) -> Option<Chart> {
    let (time_unit, space_unit) = found.units();
    let mode = shapes.modes.rows().into_iter().next()?;
    let positions = found.positions();
    let points = |of: fn(&num_complex::Complex<f64>) -> f64| -> Vec<(f64, f64)> {
        positions.iter().copied().zip(mode.iter().map(of)).collect()
    };
    let wave = match shapes
        .waves
        .first()
        .copied()
        .flatten()
        .filter(|wave| wave.is_wave)
    {
        Some(wave) => format!(", k = {:.4} rad/{space_unit}", wave.wavenumber),
        None => String::new(),
    };
    let mut chart = Chart::of(
        format!(
            "mode 1 at f = {:.4} {}{wave}",
            shapes.frequency,
            crate::measure::cycles_per(&time_unit)
        ),
        label("position x", &space_unit),
        label("mode φ", &root_of_one_over(&space_unit)),
        vec![
            Series::line("real part", BLUE, points(|z| z.re)),
            Series::line("modulus", BLACK, points(|z| z.norm())).with(Look::Dashed),
        ],
    );
    let most = extent(mode.iter().map(|z| z.norm())).end;
    chart.y = -1.15 * most..1.15 * most;
    Some(chart)
}

fn root_of_one_over(unit: &str) -> String {
    format!("1/√{unit}")
}
