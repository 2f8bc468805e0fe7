//! Transfers between wavenumbers by triads: the map of the pairs, and the flux with what carries it.

use ndarray::Array2;

use super::Figure;
use super::chart::{BLUE, Chart, GREEN, Level, Look, PURPLE, SKY, Series, VERMILLION};
use super::heat_chart::HeatChart;
use super::sheet::{PlotRow, Sheet};
use super::style::Style;
use super::uprights::Mark;
use crate::budget::{Disparity, Triads};

/// Wavenumbers whose transfers are below this share of the largest are not drawn.
const SHOWN: f64 = 2e-3;

/// The map of the pairs, and the flux.
pub fn triads(found: &Triads, name: &str, style: &Style) -> Figure {
    let note = format!(
        "Energies as shares of that at the start, over {} samples. Identities hold to {:.0e}.",
        found.samples,
        found.identities.detailed.max(found.identities.sums)
    );
    let [change, flux] = triad_charts(found);
    let sheet = Sheet {
        title: "Transfer between wavenumbers by triads".into(),
        data: name.into(),
        rows: vec![
            PlotRow::of([triad_map(found)]).high(1.3),
            PlotRow::of([change, flux]),
        ],
        notes: vec![note],
        ..Sheet::default()
    };
    sheet.figure("triads", style)
}

/// Wavenumbers up to the last one that takes part.
fn shown(found: &Triads) -> usize {
    let sizes: Vec<f64> = (0..found.gained.len())
        .map(|k| {
            let row = found.transfer.row(k);
            row.iter().fold(0.0, |m: f64, value| m.max(value.abs()))
        })
        .collect();
    let most = sizes.iter().fold(0.0, |m: f64, size| m.max(*size));
    let last = sizes.iter().rposition(|size| *size > SHOWN * most);
    (last.unwrap_or(0) + 2).clamp(3.min(sizes.len()), sizes.len())
}

/// Energy that each wavenumber gained with each larger partner.
pub(crate) fn triad_map(found: &Triads) -> HeatChart {
    let n = shown(found);
    let values = Array2::from_shape_fn((n, n), |(p, k)| {
        let wrapped = found.umklapp.as_ref().map_or(0.0, |map| map[[k, p]]);
        match 2 * p < k {
            true => f64::NAN,
            false => (found.transfer[[k, p]] + wrapped) / found.energy,
        }
    });
    let known = values.iter().filter(|v| v.is_finite());
    let largest = known.fold(0.0, |m: f64, v| m.max(v.abs()));
    let largest = if largest > 0.0 { largest } else { 1.0 };
    let step = found.wavenumber[1];
    let ends = -0.5 * step..(n as f64 - 0.5) * step;
    HeatChart {
        title: String::new(),
        x_label: found.units.wavenumber(),
        y_label: found
            .units
            .wavenumber()
            .replacen("wavenumber k", "larger partner p", 1),
        label: "energy gained, share".into(),
        x: ends.clone(),
        y: ends,
        log_x: false,
        values,
        scale: -largest..largest,
        marks: Vec::new(),
    }
}

/// What each wavenumber gained, and the flux with the groups of triads that carry it.
pub(crate) fn triad_charts(found: &Triads) -> [Chart; 2] {
    let n = shown(found);
    let line = |label: &str, colour: usize, values: &[f64]| {
        let shares: Vec<f64> = values[..n]
            .iter()
            .map(|value| value / found.energy)
            .collect();
        Series::of(label, colour, &found.wavenumber[..n], &shares)
    };
    let zero = || {
        vec![Level {
            at: 0.0,
            label: String::new(),
        }]
    };
    let around = |series: &[Series]| {
        let all = series.iter().flat_map(|s| &s.points).map(|p| p.1);
        let (low, high) = all.fold((0.0f64, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
        let space = 0.05 * (high - low).max(f64::MIN_POSITIVE);
        low - space..high + space
    };
    let mut series = vec![
        line("change of energy", PURPLE, &found.change).with(Look::Dashed),
        line("gained from pairs", VERMILLION, &found.gained),
    ];
    if let Some(beyond) = &found.beyond {
        series.push(line("beyond the quadratic force", SKY, beyond));
    }
    let change = Chart {
        levels: zero(),
        y: around(&series),
        ..Chart::of("", found.units.wavenumber(), "energy gained, share", series)
    };
    let mut series = vec![line("all triads", PURPLE, &found.flux)];
    // Triads of near wavenumbers, of far ones, and the rest.
    let sum = |wanted: &dyn Fn(&Disparity) -> bool| -> Vec<f64> {
        let groups = || found.locality.flux.iter().filter(|(d, _)| wanted(d));
        (0..found.flux.len())
            .map(|k| groups().map(|(_, flux)| flux[k]).sum())
            .collect()
    };
    let octave = |low: f64, high: f64| move |d: &Disparity| matches!(d, Disparity::Octave { from } if (low..high).contains(from));
    for (label, colour, low, high) in [
        ("ratios of 2 to 4", BLUE, 2.0, 4.0),
        ("4 to 8", GREEN, 4.0, 8.0),
        ("8 and more", VERMILLION, 8.0, f64::INFINITY),
    ] {
        series.push(line(label, colour, &sum(&octave(low, high))));
    }
    let others = sum(&|d| !matches!(d, Disparity::Octave { .. }));
    let most = others.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    if most > 1e-3 * found.flux.iter().fold(0.0, |m: f64, v| m.max(v.abs())) {
        series.push(line("with k = 0, umklapp", SKY, &others));
    }
    let marks = match found.is_quadratic() && found.is_resolved() {
        true => vec![Mark {
            at: found.wavenumber[found.locality.at],
            label: "largest".into(),
        }],
        false => Vec::new(),
    };
    let flux = Chart {
        levels: zero(),
        y: around(&series),
        marks,
        ..Chart::of("", found.units.wavenumber(), "flux past k, share", series)
    };
    [change, flux]
}
