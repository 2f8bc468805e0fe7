//! The numbers of a run in tables, and its warnings.

use maud::{Markup, html as markup};

use super::words::percent;
use crate::analyze::{Analysis, Timing};
use crate::field::Axis;
use crate::prepare::WindowGains;
use crate::report::page::{self, number, sentence_case, table};
use crate::report::{Advice, AnswerWords, Doubt, sentences};

type Row = (&'static str, String);

/// What was analysed, in one sentence.
pub(super) fn sentence(analysis: &Analysis) -> String {
    let axes = &analysis.axes;
    let quantity = kebab(&analysis.quantity);
    let unit = match &analysis.unit {
        Some(unit) => format!(" in {unit}"),
        None => String::new(),
    };
    format!(
        "{quantity}{unit}, {} times by {} sites",
        axes.n_times, axes.n_sites
    )
}

/// The answers beside the picture that shows the verdict.
pub(super) fn answer(words: &AnswerWords) -> Markup {
    let lines = words.lines.iter();
    page::facts(
        &lines
            .map(|line| (line.name, line.text.clone()))
            .collect::<Vec<_>>(),
    )
}

pub(super) fn warnings(analysis: &Analysis, advice: Advice) -> Markup {
    let advised = analysis.warnings.iter();
    let advised = advised.map(|w| (w.message(), advice(Doubt::Warning(w))));
    page::warnings(&advised.collect::<Vec<_>>())
}

pub(super) fn tables(analysis: &Analysis, advice: Advice) -> Markup {
    page::numbers(markup! {
        div class="tables" {
            (table("Field", &field(analysis)))
            (table("Spectra", &spectra(analysis)))
            (table("Redistribution", &redistribution(analysis, advice)))
        }
    })
}

/// How the numbers were computed, folded.
pub(super) fn provenance(analysis: &Analysis) -> Markup {
    let mut rows = accuracy(analysis);
    if let Some(hash) = &analysis.content_hash {
        rows.push(("BLAKE3 of the file", hash.clone()));
    }
    let content = markup! {
        div class="tables" {
            (table("Accuracy", &rows))
            (timings(&analysis.timings))
        }
    };
    page::folded("provenance", "Accuracy, provenance and timings", content)
}

fn field(analysis: &Analysis) -> Vec<Row> {
    let axes = &analysis.axes;
    let span = |axis: &Axis, count: usize| {
        let last = axis.at(count.saturating_sub(1));
        let unit = axis.unit.as_deref().unwrap_or("(counted)");
        format!(
            "{} to {} in steps of {} {unit}",
            number(axis.origin),
            number(last),
            number(axis.step)
        )
    };
    vec![
        (
            "Samples",
            format!("{} times × {} sites", axes.n_times, axes.n_sites),
        ),
        ("Time", span(&axes.time, axes.n_times)),
        ("Position", span(&axes.space, axes.n_sites)),
        ("Quantity", sentence_quantity(analysis)),
        (
            "Offset in the file",
            format!("time row {}, site {}", analysis.offset.0, analysis.offset.1),
        ),
    ]
}

fn sentence_quantity(analysis: &Analysis) -> String {
    match &analysis.unit {
        Some(unit) => format!("{} ({unit})", kebab(&analysis.quantity)),
        None => kebab(&analysis.quantity),
    }
}

fn spectra(analysis: &Analysis) -> Vec<Row> {
    let of = &analysis.conventions;
    let last = |values: &[f64]| number(values.last().copied().unwrap_or(f64::NAN));
    let axes = &analysis.axes;
    vec![
        ("Scaling", kebab(&of.scaling)),
        ("Window in time", window(&of.window_time)),
        ("Window in space", window(&of.window_space)),
        (
            "Segments in time",
            format!(
                "{} of {} samples, overlap {}, padded to {}",
                of.segments, of.segment, of.overlap, of.padded_time
            ),
        ),
        ("Padded in space to", of.padded_space.to_string()),
        ("95 % interval of S(f, x)", interval(analysis)),
        (
            "Highest frequency",
            format!("{} {}", last(&axes.frequency), axes.frequency_unit()),
        ),
        (
            "Highest wavenumber",
            format!("{} {}", last(&axes.wavenumber), axes.wavenumber_unit()),
        ),
    ]
}

fn interval(analysis: &Analysis) -> String {
    match analysis
        .interval
        .map(|of| (of, of.degrees_of_freedom.zip(of.factors)))
    {
        Some((_, Some((degrees, [low, high])))) => format!(
            "{} to {} of a value ({} degrees of freedom)",
            number(low),
            number(high),
            number(degrees)
        ),
        Some((of, None)) => format!(
            "none: the record is a transient, which is one realisation (steadiness {})",
            number(of.steadiness)
        ),
        None => "not computed".into(),
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

fn redistribution(analysis: &Analysis, advice: Advice) -> Vec<(String, String)> {
    let axes = &analysis.axes;
    let mut rows = Vec::new();
    if let Some(direction) = analysis.direction {
        rows.push(("Towards +x".into(), percent(direction.toward_plus_x)));
        rows.push(("Towards −x".into(), percent(direction.toward_minus_x)));
        rows.push(("Undirected".into(), percent(direction.undirected)));
        let (from, to) = direction.band;
        let unit = axes.frequency_unit();
        rows.push((
            "Directions summed over".into(),
            format!("{} to {} {unit}", number(from), number(to)),
        ));
    }
    let mut about = "";
    for sentence in sentences(analysis) {
        if !sentence.is_detail {
            about = sentence.name;
        }
        let name = match sentence.is_detail {
            true => format!("{about}: {}", sentence.name),
            false => sentence.name.into(),
        };
        let advice = sentence.unresolved.map(Doubt::Unresolved).and_then(advice);
        let text = match advice {
            Some(advice) => format!("{}: {advice}", sentence.text),
            None => sentence.text,
        };
        rows.push((sentence_case(&name), text));
    }
    rows
}

fn accuracy(analysis: &Analysis) -> Vec<Row> {
    let (of, parseval) = (&analysis.accuracy, &analysis.parseval);
    let residual = |value: Option<f64>| value.map_or("not computed".into(), number);
    vec![
        ("Precision", kebab(&of.precision)),
        (
            "Spot check",
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
        ("Unit of stored amplitudes", number(of.amplitude_unit)),
        ("Estimated by", of.estimated_by.into()),
    ]
}

fn timings(timings: &[Timing]) -> Markup {
    markup! {
        table class="timings" {
            caption { "Timings" }
            thead {
                tr {
                    th scope="col" { "Stage" }
                    th scope="col" { "Seconds" }
                    th scope="col" { "MB read" }
                    th scope="col" { "MB written" }
                    th scope="col" { "Transforms" }
                }
            }
            tbody {
                @for timing in timings {
                    tr {
                        th scope="row" { (timing.stage) }
                        td { (number(timing.seconds)) }
                        td { (megabytes(timing.bytes_read)) }
                        td { (megabytes(timing.bytes_written)) }
                        td {
                            @if timing.transforms > 0 {
                                (timing.transforms) " of length " (timing.transform_length)
                            } @else { "none" }
                        }
                    }
                }
            }
        }
    }
}

fn megabytes(bytes: u64) -> String {
    format!("{:.2}", bytes as f64 / 1e6)
}

/// The name that an enum has in JSON, in words.
fn kebab(value: &impl serde::Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(name)) => name.replace('-', " "),
        _ => String::new(),
    }
}
