//! Tables of an analysis: the field, how spectra were made, how exact they are, what the run took.

use super::super::Analysis;
use crate::field::Axis;
use crate::prepare::WindowGains;
use crate::sheet::{Table, name_of, number};

pub(super) fn of(analysis: &Analysis) -> Vec<Table> {
    let (axes, of) = (&analysis.axes, &analysis.conventions);
    let span = |axis: &Axis, count: usize| {
        let last = axis.at(count.saturating_sub(1));
        let unit = axis.unit.as_deref().unwrap_or("(counted)");
        format!("{} to {} {unit}", number(axis.origin), number(last))
    };
    let quantity = name_of(&analysis.quantity).replace('-', " ");
    let quantity = match &analysis.unit {
        Some(unit) => format!("{quantity} ({unit})"),
        None => quantity,
    };
    let (row, site) = analysis.offset;
    let field = [
        ("times", span(&axes.time, axes.n_times)),
        ("positions", span(&axes.space, axes.n_sites)),
        ("quantity", quantity),
        ("offset in the file", format!("time row {row}, site {site}")),
    ];
    let hash = analysis.content_hash.clone();
    let hash = hash.map(|hash| ("BLAKE3 of the file", hash));

    let segments = format!(
        "{} of {} samples, overlap {}, padded to {}",
        of.segments, of.segment, of.overlap, of.padded_time
    );
    let last = |values: &[f64], unit: String| {
        let last = number(values.last().copied().unwrap_or(f64::NAN));
        format!("{last} {unit}")
    };
    let highest = last(&axes.frequency, axes.frequency_unit());
    let largest = last(&axes.wavenumber, axes.wavenumber_unit());
    let spectra = [
        ("scaling", name_of(&of.scaling)),
        ("window in time", window(&of.window_time)),
        ("window in space", window(&of.window_space)),
        ("segments in time", segments),
        ("padded in space to", of.padded_space.to_string()),
        ("95 % interval of S(f, x)", interval(analysis)),
        ("highest frequency", highest),
        ("highest wavenumber", largest),
    ];

    let (of, parseval) = (&analysis.accuracy, &analysis.parseval);
    let residual = |value: Option<f64>| value.map_or("not computed".into(), number);
    let checked = of.spot_check;
    let checked = checked.map(|e| format!("{} over {} amplitudes", number(e), of.spot_checks));
    let accuracy = [
        ("precision", name_of(&of.precision)),
        ("spot check", checked.unwrap_or("not made".into())),
        ("Parseval residual, time", residual(parseval.time)),
        ("Parseval residual, space", residual(parseval.space)),
        (
            "Parseval residual, space-time",
            residual(parseval.spacetime),
        ),
        ("unit of stored amplitudes", number(of.amplitude_unit)),
        ("estimated by", of.estimated_by.into()),
    ];

    let megabytes = |bytes: u64| format!("{:.2}", bytes as f64 / 1e6);
    let timings = analysis.timings.iter().map(|timing| {
        vec![
            timing.stage.to_owned(),
            number(timing.seconds),
            megabytes(timing.bytes_read),
            megabytes(timing.bytes_written),
            timing.transforms.to_string(),
            timing.transform_length.to_string(),
        ]
    });
    let head = "stage,seconds,MB read,MB written,transforms,length";
    let head: Vec<&str> = head.split(',').collect();
    vec![
        Table::of_values("Field", field.into_iter().chain(hash)),
        Table::of_values("Spectra", spectra),
        Table::of_values("Accuracy", accuracy),
        Table::of("Timings", &head, timings),
    ]
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
