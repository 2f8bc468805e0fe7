//! Bicoherence: its map over two frequencies, and along x.

use ndarray::Array2;

use super::Figure;
use super::chart::{BLUE, Chart, Level, Series, VERMILLION};
use super::heat_chart::HeatChart;
use super::sheet::{PlotRow, Sheet};
use super::short::edges;
use super::style::Style;
use crate::estimates::Bicoherence;
use crate::unit::label;

/// The map of the triples, the largest at each output frequency, and both along x.
pub fn bicoherence(found: &Bicoherence, name: &str, style: &Style) -> Figure {
    let mut rows = vec![PlotRow::of([bicoherence_map(found)]).high(1.2)];
    if let Some(map) = bicoherence_along_map(found) {
        rows.push(PlotRow::of([map]));
    } else {
        rows.push(PlotRow::of([bicoherence_by_output(found)]));
    }
    let note = match (found.cell_level(), found.map_level()) {
        (Some(cell), Some(map)) => format!(
            "With probability {}, by chance: one cell exceeds {cell:.3}, any of the {} cells {map:.3}.",
            found.alpha,
            found.cells()
        ),
        _ => "No significance can be stated: too few independent realisations.".into(),
    };
    let sheet = Sheet {
        title: match found.site == found.output {
            true => format!("Bicoherence of site {}", found.site),
            false => format!(
                "Bicoherence of site {} with site {}",
                found.site, found.output
            ),
        },
        data: name.into(),
        rows,
        notes: vec![note],
        ..Sheet::default()
    };
    sheet.figure("bicoherence", style)
}

fn per_time(found: &Bicoherence) -> String {
    crate::measure::cycles_per(&found.units().0)
}

/// Upper end of a colour scale that shows what is above the level.
fn top(values: impl Iterator<Item = f64>, level: Option<f64>) -> f64 {
    let largest = values.filter(|b| b.is_finite()).fold(0.0, f64::max);
    largest.max(1.2 * level.unwrap_or(0.0)).clamp(0.05, 1.0)
}

/// Bicoherence over the two frequencies that are added.
pub(crate) fn bicoherence_map(found: &Bicoherence) -> HeatChart {
    let bins = &found.map.bins;
    let extreme = |i: usize, sign: isize| bins.iter().map(|b| sign * b[i]).max().unwrap_or(1);
    let (last, lowest, highest) = (extreme(0, 1), -extreme(1, -1), extreme(1, 1));
    let rows = (highest - lowest + 1) as usize;
    let mut values = Array2::from_elem((rows, last as usize), f64::NAN);
    for ([first, second, _], b) in bins.iter().zip(&found.map.bicoherence) {
        values[[(second - lowest) as usize, *first as usize - 1]] = *b;
    }
    let df = found.frequency[1];
    let unit = per_time(found);
    let top = top(found.map.bicoherence.iter().copied(), found.map_level());
    HeatChart {
        title: String::new(),
        x_label: label("frequency f₁", &unit),
        y_label: label("frequency f₂", &unit),
        label: "bicoherence b²".into(),
        x: 0.5 * df..(last as f64 + 0.5) * df,
        y: (lowest as f64 - 0.5) * df..(highest as f64 + 0.5) * df,
        log_x: false,
        values,
        scale: 0.0..top,
        marks: Vec::new(),
    }
}

/// The largest bicoherence at each output frequency along x; `None` for fewer than two sites.
pub(crate) fn bicoherence_along_map(found: &Bicoherence) -> Option<HeatChart> {
    let along = &found.along;
    if along.sites.len() < 2 {
        return None;
    }
    let positions: Vec<f64> = along.sites.iter().map(|j| found.space.at(*j)).collect();
    let (left, right) = edges(&positions);
    let (low, high) = edges(&found.frequency);
    let level = along.largest_level.iter().copied();
    let level = level.filter(|level| level.is_finite()).reduce(f64::max);
    Some(HeatChart {
        title: String::new(),
        x_label: label("position x", &found.units().1),
        y_label: label("frequency f₃ = f₁ + f₂", &per_time(found)),
        label: "largest b² over f₁".into(),
        x: left..right,
        y: low.max(0.0)..high,
        log_x: false,
        values: along.largest.clone(),
        scale: 0.0..top(along.largest.iter().copied(), level),
        marks: Vec::new(),
    })
}

/// The largest bicoherence of the map at each output frequency, with its mean over all pairs.
pub(crate) fn bicoherence_by_output(found: &Bicoherence) -> Chart {
    let bins = found.frequency.len();
    let mut largest = vec![f64::NAN; bins];
    let (mut sums, mut counts) = (vec![0.0; bins], vec![0.0; bins]);
    for ([_, _, third], b) in found.map.bins.iter().zip(&found.map.bicoherence) {
        let third = *third as usize;
        if b.is_finite() {
            largest[third] = b.max(largest[third]);
            sums[third] += b;
            counts[third] += 1.0;
        }
    }
    let means: Vec<f64> = sums.iter().zip(&counts).map(|(s, n)| s / n).collect();
    let levels = [
        (found.map_level(), "level of the map"),
        (found.cell_level(), "level of one cell"),
    ];
    let levels = levels.into_iter().filter_map(|(at, name)| {
        Some(Level {
            at: at?,
            label: name.into(),
        })
    });
    Chart {
        levels: levels.collect(),
        ..Chart::of(
            "coupling into each frequency",
            label("frequency f₃ = f₁ + f₂", &per_time(found)),
            "bicoherence b²",
            vec![
                Series::of("largest", VERMILLION, &found.frequency, &largest),
                Series::of("mean", BLUE, &found.frequency, &means),
            ],
        )
    }
}
