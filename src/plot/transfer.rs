//! Transfer between two sites: what each frequency gains, and what each pair brings.

use ndarray::Array2;

use super::Figure;
use super::chart::{BLUE, Chart, GREEN, Level, Look, Series, VERMILLION};
use super::heat_chart::HeatChart;
use super::sheet::{PlotRow, Sheet};
use super::style::Style;
use crate::estimates::{OutputTransfer, Transfer};
use crate::unit::label;

/// A column of the outputs.
type Of = fn(&OutputTransfer) -> f64;

/// Gains, flux, pairs and explained shares.
pub fn transfer(found: &Transfer, name: &str, style: &Style) -> Figure {
    let [gain, flux, shares] = transfer_charts(found);
    let sheet = Sheet {
        title: format!("Transfer from site {} to site {}", found.from, found.to),
        data: name.into(),
        rows: vec![
            PlotRow::of([gain, flux]),
            PlotRow::of([transfer_map(found)]).high(1.2),
            PlotRow::of([shares]),
        ],
        notes: vec![format!(
            "Bars are standard errors by {} resamplings of {} blocks of realisations.",
            found.resamplings, found.blocks
        )],
        ..Sheet::default()
    };
    sheet.figure("transfer", style)
}

fn per_time(found: &Transfer) -> String {
    crate::measure::cycles_per(&found.units().0)
}

fn points(found: &Transfer, of: Of) -> Vec<(f64, f64)> {
    let outputs = found.outputs.iter();
    outputs
        .map(|output| (output.frequency, of(output)))
        .collect()
}

fn zero() -> Vec<Level> {
    vec![Level {
        at: 0.0,
        label: String::new(),
    }]
}

/// Gains by frequency, power that passes each frequency, and explained shares.
pub(crate) fn transfer_charts(found: &Transfer) -> [Chart; 3] {
    let frequency = label("frequency f", &per_time(found));
    // In shares of the power of the input, which need no unit.
    let input = found.input();
    let df = found.outputs[0].frequency;
    let share = |of: Of, factor: f64| -> Vec<(f64, f64)> {
        let all = points(found, of).into_iter();
        all.map(|(f, value)| (f, value * factor)).collect()
    };
    let errors = |of: Of, factor: f64| -> Vec<f64> {
        found.outputs.iter().map(|o| of(o) * factor).collect()
    };
    let each = df / input;
    // With the bars of errors inside.
    let around = |all: &[[Of; 2]], factor: f64| {
        let mut range = 0.0f64..0.0f64;
        for output in &found.outputs {
            for [of, error] in all {
                let (value, error) = (of(output) * factor, error(output) * factor);
                range = range.start.min(value - error)..range.end.max(value + error);
            }
        }
        let space = 0.05 * (range.end - range.start);
        range.start - space..range.end + space
    };
    let gain = Chart {
        levels: zero(),
        y: around(
            &[
                [|o| o.linear, |o| o.linear_error],
                [|o| o.gain, |o| o.gain_error],
            ],
            each,
        ),
        ..Chart::of(
            "gained by each frequency",
            frequency.clone(),
            "share of the input's power",
            vec![
                Series {
                    errors: errors(|o| o.linear_error, each),
                    ..Series::line("linear", BLUE, share(|o| o.linear, each))
                },
                Series {
                    errors: errors(|o| o.gain_error, each),
                    ..Series::line("from pairs", VERMILLION, share(|o| o.gain, each))
                },
            ],
        )
    };
    let flux = Chart {
        levels: zero(),
        y: around(&[[|o| o.flux, |o| o.flux_error]], 1.0 / input),
        ..Chart::of(
            "passes f towards higher frequencies",
            frequency.clone(),
            "share of the input's power",
            vec![Series {
                errors: errors(|o| o.flux_error, 1.0 / input),
                ..Series::line("", VERMILLION, share(|o| o.flux, 1.0 / input))
            }],
        )
    };
    let shares = Chart {
        levels: zero(),
        y: -0.25..1.0,
        ..Chart::of(
            "explained of realisations that were not fitted",
            frequency,
            "share of the output's power",
            vec![
                Series::line("linear", BLUE, points(found, |o| o.held_out_linear)),
                Series::line(
                    "quadratic",
                    VERMILLION,
                    points(found, |o| o.held_out_quadratic),
                ),
                Series::line("residual", GREEN, points(found, |o| o.residual / o.output))
                    .with(Look::Dashed),
            ],
        )
    };
    [gain, flux, shares]
}

/// What each pair brings to its sum or difference, over output and second frequency.
pub(crate) fn transfer_map(found: &Transfer) -> HeatChart {
    let df = found.outputs[0].frequency;
    let bin = |f: f64| (f / df).round() as isize;
    let last = found.outputs.len() as isize;
    let lowest = found
        .pairs
        .iter()
        .map(|p| bin(p.second))
        .min()
        .unwrap_or(-1);
    let highest = found.pairs.iter().map(|p| bin(p.second)).max().unwrap_or(1);
    let mut values = Array2::from_elem(((highest - lowest + 1) as usize, last as usize), f64::NAN);
    let each = df / found.input();
    for pair in &found.pairs {
        let row = (bin(pair.second) - lowest) as usize;
        values[[row, bin(pair.third) as usize - 1]] = pair.gain * each;
    }
    let known = values.iter().filter(|v| v.is_finite());
    let largest = known.fold(0.0, |m: f64, v| m.max(v.abs()));
    let largest = if largest > 0.0 { largest } else { 1.0 };
    let unit = per_time(found);
    HeatChart {
        title: String::new(),
        x_label: label("output frequency f = f₁ + f₂", &unit),
        y_label: label("frequency f₂", &unit),
        label: "gain, share of the input".into(),
        x: 0.5 * df..(last as f64 + 0.5) * df,
        y: (lowest as f64 - 0.5) * df..(highest as f64 + 0.5) * df,
        log_x: false,
        values,
        scale: -largest..largest,
        marks: Vec::new(),
    }
}
