//! `S(k, f)` with intervals: the map, and cuts through its largest value.

use super::Figure;
use super::chart::{BLUE, Chart, Series};
use super::heat_chart::HeatChart;
use super::sheet::{PlotRow, Sheet};
use super::short::{edges, six_digits};
use super::style::Style;
use crate::estimates::SpaceTimeEstimate;
use crate::measure::cycles_per;
use crate::unit::label;

/// Decades that the map shows at most.
const DECADES: f64 = 8.0;

/// The map over wavenumbers of both signs and frequencies; cuts along both with their intervals.
pub fn spacetime(found: &SpaceTimeEstimate, name: &str, style: &Style) -> Figure {
    let sheet = Sheet {
        title: "Space-time spectrum with intervals".into(),
        data: name.into(),
        rows: vec![
            PlotRow::of([spacetime_map(found)]).high(1.4),
            PlotRow::of(spacetime_cuts(found)),
        ],
        notes: vec![spacetime_note(found)],
        ..Sheet::default()
    };
    sheet.figure("spectrum", style)
}

fn spacetime_note(found: &SpaceTimeEstimate) -> String {
    let confidence = 100.0 * (1.0 - found.alpha);
    match found.degrees_range() {
        Some([least, _, most]) => {
            let degrees = match least < most {
                true => format!("{least:.1} to {most:.1}"),
                false => format!("{most:.1}"),
            };
            format!(
                "{confidence} % intervals by {degrees} degrees of freedom. Positive k travels towards +x."
            )
        }
        None => format!(
            "No interval can be stated: {}. Positive k travels towards +x.",
            found.independence.why()
        ),
    }
}

pub(crate) fn spacetime_density_label(found: &SpaceTimeEstimate) -> String {
    let (time_unit, space_unit) = found.units();
    let per = format!("({} · rad/{space_unit})", cycles_per(&time_unit));
    label(
        "power spectral density",
        &match &found.unit {
            Some(unit) => format!("({unit})²/{per}"),
            None => format!("per {per}"),
        },
    )
}

fn axis_labels(found: &SpaceTimeEstimate) -> [String; 2] {
    let (time_unit, space_unit) = found.units();
    [
        label("wavenumber k", &format!("rad/{space_unit}")),
        label("frequency f", &cycles_per(&time_unit)),
    ]
}

/// The logarithm of the density over k and f.
pub(crate) fn spacetime_map(found: &SpaceTimeEstimate) -> HeatChart {
    let (left, right) = edges(&found.wavenumber);
    let (low, high) = edges(&found.frequency);
    let mut values = found
        .spectrum
        .mapv(|s| if s > 0.0 { s.log10() } else { f64::NAN });
    if found.mean_is_removed {
        values.row_mut(0).fill(f64::NAN);
    }
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let scale = match largest > least {
        true => least.max(largest - DECADES)..largest,
        false => 0.0..1.0,
    };
    let [x_label, y_label] = axis_labels(found);
    HeatChart {
        title: String::new(),
        x_label,
        y_label,
        label: format!("log10 of the {}", spacetime_density_label(found)),
        x: left..right,
        y: low.max(0.0)..high,
        log_x: false,
        values,
        scale,
        marks: Vec::new(),
    }
}

/// The density along k at the frequency of its largest value, and along f at its wavenumber.
pub(crate) fn spacetime_cuts(found: &SpaceTimeEstimate) -> [Chart; 2] {
    let (row, column) = found.largest();
    let [k_label, f_label] = axis_labels(found);
    let units = found.units();
    let confidence = 100.0 * (1.0 - found.alpha);
    let cut = |title: String, x_label: String, x: &[f64], of: &dyn Fn(usize) -> (usize, usize)| {
        let cells = || (0..x.len()).map(of);
        let spectrum: Vec<f64> = cells().map(|at| found.spectrum[at]).collect();
        let ends: Vec<(f64, f64)> = cells().map(|at| (found.low[at], found.high[at])).collect();
        let has_interval = ends.iter().any(|(low, _)| low.is_finite());
        let all = ends.iter().flat_map(|(low, high)| [*low, *high]);
        let all = all.chain(spectrum.iter().copied());
        let shown: Vec<f64> = all.filter(|v| v.is_finite() && *v > 0.0).collect();
        let most = shown.iter().copied().fold(0.0, f64::max);
        let least = shown.iter().copied().fold(f64::INFINITY, f64::min);
        let line = Series::of("", BLUE, x, &spectrum);
        let line = match has_interval {
            true => line.with_band(format!("{confidence} % interval"), ends),
            false => line,
        };
        let density = spacetime_density_label(found);
        Chart {
            y: match most > 0.0 {
                true => least.max(most * 10f64.powf(-DECADES))..most * 1.5,
                false => 0.1..1.0,
            },
            log_y: true,
            ..Chart::of(title, x_label, density, vec![line])
        }
    };
    let at_f = six_digits(found.frequency[row]);
    let at_k = six_digits(found.wavenumber[column]);
    [
        cut(
            format!("at f = {at_f} {}", cycles_per(&units.0)),
            k_label,
            &found.wavenumber,
            &|i| (row, i),
        ),
        cut(
            format!("at k = {at_k} rad/{}", units.1),
            f_label,
            &found.frequency,
            &|m| (m, column),
        ),
    ]
}
