//! Spectra of all sites, that of one site with its intervals, and the test for lines.

use super::Figure;
use super::chart::{BLACK, BLUE, Chart, Level, Look, Series};
use super::heat_chart::HeatChart;
use super::sheet::{PlotRow, Sheet};
use super::short::{edges, six_digits};
use super::style::Style;
use super::uprights::Mark;
use crate::estimates::{LeftOutEach, SpectrumAxis, SpectrumEstimate};
use crate::unit::label;

/// Decades that a map and a chart of a spectrum show at most.
const DECADES: f64 = 10.0;

/// The spectra of all sites; that of the site with the most energy with its intervals; its test for lines.
pub fn spectrum(found: &SpectrumEstimate, name: &str, style: &Style) -> Figure {
    let mut rows = vec![PlotRow::of([spectrum_map(found)]).high(1.1)];
    rows.extend(mean_spectrum_chart(found).map(|chart| PlotRow::of([chart])));
    rows.push(PlotRow::of([spectrum_chart(found)]).high(1.1));
    rows.extend(spectrum_lines(found).map(|chart| PlotRow::of([chart]).high(0.8)));
    let sheet = Sheet {
        title: "Spectra with intervals".into(),
        data: name.into(),
        rows,
        notes: vec![spectrum_note(found)],
        ..Sheet::default()
    };
    sheet.figure("spectrum", style)
}

fn spectrum_note(found: &SpectrumEstimate) -> String {
    let confidence = 100.0 * (1.0 - found.alpha);
    match found.degrees_range() {
        Some([least, median, most]) => format!(
            "{confidence} % intervals by {median:.3} degrees of freedom ({least:.3} to {most:.3}). {}",
            match found.left_out {
                _ if !found.has_jackknife => "There is no jackknife.",
                LeftOutEach::Realisation =>
                    "The jackknife leaves out one segment and taper at a time.",
                LeftOutEach::Record => "The jackknife leaves out one record at a time.",
            }
        ),
        None => format!("No interval can be stated: {}.", found.independence.why()),
    }
}

pub(crate) fn density_label(found: &SpectrumEstimate) -> String {
    let unit = match &found.unit {
        Some(unit) => match found.along {
            SpectrumAxis::Time => format!("({unit})²/{}", found.bin_unit()),
            SpectrumAxis::Space => format!("({unit})²/({})", found.bin_unit()),
        },
        None => format!("per {}", found.bin_unit()),
    };
    label("power spectral density", &unit)
}

fn bin_label(found: &SpectrumEstimate) -> String {
    let name = match found.along {
        SpectrumAxis::Time => "frequency f",
        SpectrumAxis::Space => "wavenumber k",
    };
    label(name, &found.bin_unit())
}

/// The spectra of all sites, or at all times.
pub(crate) fn spectrum_map(found: &SpectrumEstimate) -> HeatChart {
    let (time_unit, space_unit) = found.units();
    let coordinates = found.coordinates();
    let (left, right) = edges(&coordinates);
    let (low, high) = edges(&found.bins);
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
    HeatChart {
        title: String::new(),
        x_label: match found.along {
            SpectrumAxis::Time => label("position x", &space_unit),
            SpectrumAxis::Space => label("time t", &time_unit),
        },
        y_label: bin_label(found),
        label: format!("log10 of the {}", density_label(found)),
        x: left..right,
        y: low.max(0.0)..high,
        log_x: false,
        values,
        scale,
        marks: vec![Mark {
            at: coordinates[found.loudest()],
            label: "below".into(),
        }],
    }
}

/// The spectrum of the site with the most energy.
pub(crate) fn spectrum_chart(found: &SpectrumEstimate) -> Chart {
    let (time_unit, space_unit) = found.units();
    let site = found.loudest();
    let at = six_digits(found.coordinate(site));
    let column = |array: &ndarray::Array2<f64>| without_mean(found, array.column(site).to_vec());
    let (spectrum, low, high) = (
        column(&found.spectrum),
        column(&found.low),
        column(&found.high),
    );
    let confidence = 100.0 * (1.0 - found.alpha);
    let has_interval = low.iter().any(|v| v.is_finite());
    let line = Series::of("", BLUE, &found.bins, &spectrum);
    let ends: Vec<(f64, f64)> = low.iter().copied().zip(high.iter().copied()).collect();
    let mut series = match has_interval {
        true => vec![line.with_band(format!("{confidence} % interval"), ends)],
        false => vec![line],
    };
    let half = column(&found.jackknife);
    if half.iter().any(|h| h.is_finite()) {
        for (sign, label) in [(-1.0, "by the jackknife"), (1.0, "")] {
            let end = spectrum
                .iter()
                .zip(&half)
                .map(|(s, h)| s * (sign * h).exp());
            let end: Vec<f64> = end.collect();
            series.push(Series {
                width: 1.4,
                ..Series::of(label, BLACK, &found.bins, &end).with(Look::Dashed)
            });
        }
    }
    let y = shown([&spectrum, &low, &high]);
    let noise = found
        .noise
        .as_ref()
        .filter(|noise| noise.subtracted.is_none());
    let noise = noise.and_then(|noise| noise.sites[site]);
    Chart {
        y,
        log_y: true,
        levels: noise.map_or(Vec::new(), |noise| {
            vec![Level {
                at: noise.density,
                label: "noise".into(),
            }]
        }),
        ..Chart::of(
            match found.along {
                SpectrumAxis::Time => format!("spectrum of site {site} at {at} {space_unit}"),
                SpectrumAxis::Space => format!("spectrum at the time {at} {time_unit}"),
            },
            bin_label(found),
            density_label(found),
            series,
        )
    }
}

/// The values without that at 0, where nothing is estimated if the mean is removed.
fn without_mean(found: &SpectrumEstimate, mut values: Vec<f64>) -> Vec<f64> {
    if found.mean_is_removed {
        values[0] = f64::NAN;
    }
    values
}

/// The range of a logarithmic axis that shows these values, the first up to its largest.
fn shown(values: [&[f64]; 3]) -> std::ops::Range<f64> {
    let positive = |v: &f64| v.is_finite() && *v > 0.0;
    let all = || values.into_iter().flatten().copied().filter(positive);
    let (least, largest) = (
        all().fold(f64::INFINITY, f64::min),
        all().fold(0.0, f64::max),
    );
    match largest > 0.0 {
        true => 0.7 * least.max(largest * 10.0_f64.powf(-DECADES))..1.4 * largest,
        false => 0.1..1.0,
    }
}

/// Along space, the mean over the times.
pub(crate) fn mean_spectrum_chart(found: &SpectrumEstimate) -> Option<Chart> {
    let mean = found.mean.as_ref()?;
    let spectrum = without_mean(found, mean.spectrum.clone());
    let line = Series::of("", BLUE, &found.bins, &spectrum);
    let ends: Vec<(f64, f64)> = mean
        .low
        .iter()
        .copied()
        .zip(mean.high.iter().copied())
        .collect();
    let series = match ends.iter().any(|(low, _)| low.is_finite()) {
        true => {
            let label = format!(
                "{} % interval, by parts of the record",
                100.0 * (1.0 - found.alpha)
            );
            line.with_band(label, ends)
        }
        false => line,
    };
    Some(Chart {
        y: shown([&spectrum, &mean.low, &mean.high]),
        log_y: true,
        ..Chart::of(
            "mean over all times",
            bin_label(found),
            density_label(found),
            vec![series],
        )
    })
}

/// The test for lines of that site.
pub(crate) fn spectrum_lines(found: &SpectrumEstimate) -> Option<Chart> {
    let test = found.line_test.as_ref()?;
    let statistic = test.statistic.column(found.loudest()).to_vec();
    let positive = statistic
        .iter()
        .copied()
        .filter(|f| f.is_finite() && *f > 0.0);
    let largest = positive.fold(test.level_of_all, f64::max);
    let has_interval = found.degrees_range().is_some();
    let levels = [
        (test.level, format!("level of one cell, {:.3}", test.level)),
        (
            test.level_of_all,
            format!("level of all cells, {:.3}", test.level_of_all),
        ),
    ];
    let levels = levels.into_iter().filter(|_| has_interval);
    let of_site = test
        .lines
        .iter()
        .filter(|line| line.column == found.loudest());
    let marks = of_site.take(5).map(|line| Mark {
        at: line.at,
        label: "line".into(),
    });
    Some(Chart {
        marks: marks.collect(),
        y: 0.1..2.0 * largest,
        log_y: true,
        levels: levels.map(|(at, label)| Level { at, label }).collect(),
        ..Chart::of(
            "test for lines",
            bin_label(found),
            "statistic F",
            vec![Series::of("", BLUE, &found.bins, &statistic)],
        )
    })
}
