//! The summary of a run, on one screen.

use wavecascade::analyze::{Analysis, Plan};
use wavecascade::field::Axis;
use wavecascade::measure::digits;
pub use wavecascade::report::number;
use wavecascade::report::{percent, sentences};

use crate::advice;
pub use crate::text::{HEADING, Lines, Tone, message, paragraphs, stdout, styled, width, wrapped};

/// What a person wants to know first, in lines of at most `width` columns.
///
/// `read_as`: how the file was read, where it does not state it.
pub fn summary(analysis: &Analysis, read_as: &[String], width: usize) -> String {
    let axes = &analysis.axes;
    let mut lines = Lines::new(width);
    lines.line(
        "field",
        &format!(
            "{}: {} times x {} sites{}{}",
            analysis.name,
            axes.n_times,
            axes.n_sites,
            step("dt", &axes.time, "time counts samples"),
            step("dx", &axes.space, "x counts sites")
        ),
    );
    for conclusion in read_as {
        lines.line("read as", conclusion);
    }
    for sentence in sentences(analysis) {
        let indent = if sentence.is_detail { "  " } else { "" };
        let name = format!("{indent}{}", sentence.name);
        match sentence.unresolved.map(advice::of_unresolved) {
            Some(advice) => lines.line(&name, &format!("{} -> {advice}", sentence.text)),
            None => lines.line(&name, &sentence.text),
        }
    }
    if let Some(d) = analysis.direction {
        let shares = format!(
            "{} towards +x, {} towards -x, {} undirected",
            percent(d.toward_plus_x),
            percent(d.toward_minus_x),
            percent(d.undirected)
        );
        let undefined = match analysis.axes.n_sites {
            1 => "undefined: a single site has no wavenumber axis".to_owned(),
            _ => "undefined: no energy".to_owned(),
        };
        let defined = d.undirected.is_finite();
        lines.line("direction", if defined { &shares } else { &undefined });
    }
    let p = analysis.parseval;
    let residuals = [
        ("time", p.time),
        ("space", p.space),
        ("space-time", p.spacetime),
    ];
    let residuals: Vec<String> = residuals
        .into_iter()
        .filter_map(|(name, residual)| Some(format!("{name} {}", error_size(residual?))))
        .collect();
    if !residuals.is_empty() {
        lines.line("Parseval residual", &residuals.join(", "));
    }
    if let Some(check) = analysis.accuracy.spot_check {
        lines.line(
            "transform error",
            &format!(
                "{} of the root mean square ({} amplitudes against direct sums)",
                error_size(check),
                analysis.accuracy.spot_checks
            ),
        );
    }
    let seconds = analysis.seconds;
    let transforms: u64 = analysis.timings.iter().map(|t| t.transforms).sum();
    lines.line(
        "computation",
        &format!("{transforms} transforms in {seconds:.3} s"),
    );
    for warning in &analysis.warnings {
        lines.warning(&warning.message(), advice::of_warning(warning));
    }
    lines.text
}

/// What a plan would do, in lines of at most `width` columns.
pub fn plan(plan: &Plan, width: usize) -> String {
    let mut lines = Lines::new(width);
    for stage in &plan.stages {
        let transforms = match stage.transforms {
            0 => "no transforms".into(),
            n => format!("{n} transforms of length {}", stage.length),
        };
        lines.line(
            stage.stage,
            &format!(
                "{transforms}, {} read, {} written",
                size(stage.bytes_read),
                size(stage.bytes_written)
            ),
        );
    }
    for (array, (rows, columns)) in &plan.arrays {
        let [along, across] = array.axes();
        let axes = format!("{along} x {across}");
        lines.line(
            "array",
            &format!("{} {rows} x {columns} ({axes})", array.name()),
        );
    }
    let blocks = plan.blocks();
    lines.line(
        "blocks",
        &format!(
            "{} sites, {} times, {} frequencies at once",
            blocks.sites, blocks.times, blocks.frequencies
        ),
    );
    let scratch = match plan.scratch_file {
        0 => String::new(),
        bytes => format!(", and a scratch file of {}", size(bytes)),
    };
    lines.line(
        "memory",
        &format!(
            "{} of {} allowed{scratch}",
            size(plan.memory_needed),
            size(plan.memory_allowed)
        ),
    );
    lines.line("threads", &plan.threads.to_string());
    lines.text
}

/// `, dt 0.01 s`; of an axis that counts, that it does: `, no dt: time counts samples`.
fn step(name: &str, axis: &Axis, counts: &str) -> String {
    let step = digits(axis.step);
    match &axis.unit {
        None if axis.step == 1.0 => format!(", no {name}: {counts}"),
        None => format!(", {name} {step} (no unit stated)"),
        Some(unit) => format!(", {name} {step} {unit}"),
    }
}

pub fn error_size(x: f64) -> String {
    if x == 0.0 {
        "0".into()
    } else {
        format!("{x:.1e}")
    }
}

pub fn size(bytes: u64) -> String {
    indicatif::HumanBytes(bytes).to_string()
}
