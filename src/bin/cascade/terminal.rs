//! The summary of a run, on one screen.

use wavecascade::analyze::{Analysis, Plan};
use wavecascade::field::Axis;
use wavecascade::measure::digits;
pub use wavecascade::report::number;
use wavecascade::report::{AnswerWords, blocks, percent, sentences};
pub use wavecascade::sheet::error_size;

use crate::advice;
use crate::summary::Summary;
pub use crate::text::{HEADING, Lines, Tone, message, paragraphs, stdout, styled, width, wrapped};

/// Blocks of a profile.
const PROFILE: usize = 16;

/// The answer of an analysis, its numbers, a line for each question, warnings, checks; in detail how content is distributed.
///
/// `read_as`: how the file was read, where it does not state it.
pub fn summary(analysis: &Analysis, read_as: &[String]) -> Summary {
    let axes = &analysis.axes;
    let words = AnswerWords::of(analysis);
    let nothing = || "what moves cannot be told: nothing moves".to_owned();
    let answer = words
        .as_ref()
        .map_or_else(nothing, |words| words.verdict.clone());
    let mut summary = Summary::new(&analysis.name, &answer);
    if let Some(words) = &words {
        summary.fact("moved", &words.numbers);
        for line in &words.lines {
            let profile = match has_blocks() {
                true => blocks(&line.profile, PROFILE),
                false => String::new(),
            };
            summary.fact(line.name, format!("{profile} {}", line.text).trim_start());
        }
    }
    summary.fact(
        "field",
        &format!(
            "{} times x {} sites{}{}",
            axes.n_times,
            axes.n_sites,
            step("dt", &axes.time, "time counts samples"),
            step("dx", &axes.space, "x counts sites")
        ),
    );
    let checks = checks(analysis);
    if !checks.is_empty() {
        summary.fact("checks", &checks);
    }
    for conclusion in read_as {
        summary.fact("read as", conclusion);
    }
    for sentence in sentences(analysis) {
        let indent = if sentence.is_detail { "  " } else { "" };
        let name = format!("{indent}{}", sentence.name);
        match sentence.unresolved.map(advice::of_unresolved) {
            Some(advice) => summary.detail(&name, &format!("{} -> {advice}", sentence.text)),
            None => summary.detail(&name, &sentence.text),
        }
    }
    if let Some(d) = analysis.direction.filter(|d| d.undirected.is_finite()) {
        let shares = format!(
            "{} towards +x, {} towards -x, {} undirected",
            percent(d.toward_plus_x),
            percent(d.toward_minus_x),
            percent(d.undirected)
        );
        summary.detail("direction", &shares);
    }
    let transforms: u64 = analysis.timings.iter().map(|t| t.transforms).sum();
    let seconds = analysis.seconds;
    summary.detail(
        "computation",
        &format!("{transforms} transforms in {seconds:.3} s"),
    );
    for warning in &analysis.warnings {
        summary.warning(&warning.message(), advice::of_warning(warning));
    }
    summary
}

/// The largest residual of Parseval's identity, and the error of the transforms.
fn checks(analysis: &Analysis) -> String {
    let p = analysis.parseval;
    let residuals = [p.time, p.space, p.spacetime].into_iter().flatten();
    let largest = residuals.map(f64::abs).reduce(f64::max);
    let parseval = largest.map(|residual| format!("Parseval {}", error_size(residual)));
    let transform = analysis.accuracy.spot_check;
    let transform = transform.map(|error| format!("transform {}", error_size(error)));
    parseval
        .into_iter()
        .chain(transform)
        .collect::<Vec<_>>()
        .join(", ")
}

/// Whether the terminal has block characters.
fn has_blocks() -> bool {
    let stated = ["LC_ALL", "LC_CTYPE", "LANG"]
        .into_iter()
        .filter_map(std::env::var_os);
    let first = stated
        .map(|value| value.to_string_lossy().to_lowercase())
        .find(|value| !value.is_empty());
    first.is_some_and(|locale| locale.contains("utf-8") || locale.contains("utf8"))
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

pub fn size(bytes: u64) -> String {
    indicatif::HumanBytes(bytes).to_string()
}
