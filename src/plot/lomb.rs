//! Spectra by least squares: a map over sites, and the spectrum of the record with the largest power.

use super::Figure;
use super::chart::{BLUE, Chart, Level, Series};
use super::heat_chart::HeatChart;
use super::sheet::{Plot, PlotRow, Sheet};
use super::short::edges;
use super::style::Style;
use crate::estimates::{Lomb, LombAxis};
use crate::unit::label;

/// Most frequencies of a map.
const ROWS: usize = 600;

/// The powers of all sites, and of the record with the largest.
pub fn lomb(found: &Lomb, name: &str, style: &Style) -> Figure {
    let mut rows = Vec::new();
    if let Some(map) = lomb_map(found) {
        rows.push(PlotRow::of([map]).high(1.2));
    }
    rows.push(PlotRow::of([Plot::from(lomb_chart(found))]));
    let note = match found.axis {
        LombAxis::Time => format!(
            "White noise exceeds the level anywhere with probability {}.",
            found.alpha
        ),
        LombAxis::Space => format!("Averaged over profiles at {} times.", found.averaged),
    };
    let sheet = Sheet {
        title: "Spectra by least squares".into(),
        data: name.into(),
        rows,
        notes: vec![note],
        ..Sheet::default()
    };
    sheet.figure("lomb", style)
}

/// Of several sites; each row is the largest of the frequencies that it stands for.
pub(crate) fn lomb_map(found: &Lomb) -> Option<HeatChart> {
    if found.power.ncols() < 2 {
        return None;
    }
    let together = found.frequency.len().div_ceil(ROWS);
    let blocks = found.power.axis_chunks_iter(ndarray::Axis(0), together);
    let rows: Vec<Vec<f64>> = blocks
        .map(|block| {
            let columns = block.columns().into_iter();
            columns
                .map(|column| column.iter().fold(f64::NAN, |m: f64, p| m.max(*p)))
                .collect()
        })
        .collect();
    let values =
        ndarray::Array2::from_shape_vec((rows.len(), found.power.ncols()), rows.concat()).ok()?;
    let largest = values
        .iter()
        .filter(|p| p.is_finite())
        .fold(0.0, |m: f64, p| m.max(*p));
    let (left, right) = edges(&found.positions);
    let space_unit = found.space.unit.clone().unwrap_or_default();
    Some(HeatChart {
        title: String::new(),
        x_label: label("position x", &space_unit),
        y_label: label("frequency f", &found.unit()),
        label: "power p".into(),
        x: left..right,
        y: 0.0..found.frequency[found.frequency.len() - 1],
        log_x: false,
        values,
        scale: 0.0..if largest > 0.0 { largest } else { 1.0 },
        marks: Vec::new(),
    })
}

/// The record with the largest power.
pub(crate) fn lomb_chart(found: &Lomb) -> Chart {
    let known = (0..found.peaks.len()).filter(|j| found.peaks[*j][1].is_finite());
    let loudest = known.max_by(|a, b| found.peaks[*a][1].total_cmp(&found.peaks[*b][1]));
    let loudest = loudest.unwrap_or(0);
    let powers = found.power.column(loudest).to_vec();
    let level = found.level[loudest];
    let title = match found.axis {
        LombAxis::Time => format!("power of site {loudest}"),
        LombAxis::Space => "power along x".into(),
    };
    let highest = powers
        .iter()
        .copied()
        .filter(|p| p.is_finite())
        .fold(level.max(0.0), f64::max);
    let levels = level.is_finite().then(|| Level {
        at: level,
        label: "level".into(),
    });
    Chart {
        y: 0.0..if highest > 0.0 { 1.08 * highest } else { 1.0 },
        levels: levels.into_iter().collect(),
        ..Chart::of(
            title,
            label("frequency f", &found.unit()),
            "power p",
            vec![Series::of("", BLUE, &found.frequency, &powers)],
        )
    }
}
