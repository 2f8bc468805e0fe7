//! Tables of an analysis: the field, how spectra were made, how exact they are, what the run took.

use super::super::{Analysis, Timing};
use crate::field::Axis;
use crate::prepare::WindowGains;
use crate::sheet::{Table, name_of, number};

pub(super) fn of(analysis: &Analysis) -> Vec<Table> {
    vec![
        field(analysis),
        spectra(analysis),
        accuracy(analysis),
        timings(&analysis.timings),
    ]
}

fn field(analysis: &Analysis) -> Table {
    let axes = &analysis.axes;
    let span = |axis: &Axis, count: usize| {
        let last = axis.at(count.saturating_sub(1));
        let unit = axis.unit.as_deref().unwrap_or("(counted)");
        format!("{} to {} {unit}", number(axis.origin), number(last))
    };
    let quantity = name_of(&analysis.quantity).replace('-', " ");
    let rows = [
        ("times", span(&axes.time, axes.n_times)),
        ("positions", span(&axes.space, axes.n_sites)),
        (
            "quantity",
            match &analysis.unit {
                Some(unit) => format!("{quantity} ({unit})"),
                None => quantity,
            },
        ),
        (
            "offset in the file",
            format!("time row {}, site {}", analysis.offset.0, analysis.offset.1),
        ),
    ];
    let hash = analysis.content_hash.clone();
    let hash = hash.map(|hash| ("BLAKE3 of the file", hash));
    Table::of_values("Field", rows.into_iter().chain(hash))
}

fn spectra(analysis: &Analysis) -> Table {
    let (of, axes) = (&analysis.conventions, &analysis.axes);
    let last = |values: &[f64], unit: String| {
        format!(
            "{} {unit}",
            number(values.last().copied().unwrap_or(f64::NAN))
        )
    };
    let rows = [
        ("scaling", name_of(&of.scaling)),
        ("window in time", window(&of.window_time)),
        ("window in space", window(&of.window_space)),
        (
            "segments in time",
            format!(
                "{} of {} samples, overlap {}, padded to {}",
                of.segments, of.segment, of.overlap, of.padded_time
            ),
        ),
        ("padded in space to", of.padded_space.to_string()),
        ("95 % interval of S(f, x)", interval(analysis)),
        (
            "highest frequency",
            last(&axes.frequency, axes.frequency_unit()),
        ),
        (
            "highest wavenumber",
            last(&axes.wavenumber, axes.wavenumber_unit()),
        ),
    ];
    Table::of_values("Spectra", rows)
}

fn interval(analysis: &Analysis) -> String {
    let Some(of) = analysis.interval else {
        return "not computed".into();
    };
    match of.degrees_of_freedom.zip(of.factors) {
        Some((degrees, [low, high])) => format!(
            "{} to {} of a value ({} degrees of freedom)",
            number(low),
            number(high),
            number(degrees)
        ),
        None => format!(
            "none: the record is a transient, which is one realisation (steadiness {})",
            number(of.steadiness)
        ),
    }
}

fn window(gains: &WindowGains) -> String {
    format!(
        "{} (coherent gain {}, power gain {}, noise bandwidth {} bins)",
        gains.name,
        number(gains.coherent_gain),
        number(gains.power_gain),
        number(gains.noise_bandwidth_bins)
    )
}

fn accuracy(analysis: &Analysis) -> Table {
    let (of, parseval) = (&analysis.accuracy, &analysis.parseval);
    let residual = |value: Option<f64>| value.map_or("not computed".into(), number);
    let rows = [
        ("precision", name_of(&of.precision)),
        (
            "spot check",
            match of.spot_check {
                Some(error) => format!("{} over {} amplitudes", number(error), of.spot_checks),
                None => "not made".into(),
            },
        ),
        ("Parseval residual, time", residual(parseval.time)),
        ("Parseval residual, space", residual(parseval.space)),
        (
            "Parseval residual, space-time",
            residual(parseval.spacetime),
        ),
        ("unit of stored amplitudes", number(of.amplitude_unit)),
        ("estimated by", of.estimated_by.into()),
    ];
    Table::of_values("Accuracy", rows)
}

fn timings(timings: &[Timing]) -> Table {
    let megabytes = |bytes: u64| format!("{:.2}", bytes as f64 / 1e6);
    let rows = timings.iter().map(|timing| {
        vec![
            timing.stage.to_owned(),
            number(timing.seconds),
            megabytes(timing.bytes_read),
            megabytes(timing.bytes_written),
            timing.transforms.to_string(),
            timing.transform_length.to_string(),
        ]
    });
    let head = [
        "stage",
        "seconds",
        "MB read",
        "MB written",
        "transforms",
        "length",
    ];
    Table {
        title: "Timings".into(),
        head: head.map(str::to_owned).to_vec(),
        rows: rows.collect(),
        is_fact: false,
    }
}
