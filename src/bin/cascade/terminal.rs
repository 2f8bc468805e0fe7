//! What the program prints, and what a plan would do in words.

use std::io::Write;

use wavecascade::analyze::Plan;
use wavecascade::sheet::Warning;
pub use wavecascade::sheet::{error_size, number};

use crate::failure::Failure;
pub use crate::text::{HEADING, Lines, Tone, message, paragraphs, stdout, styled, width, wrapped};

/// What a plan would do, in lines of at most `width` columns.
pub fn plan(plan: &Plan, width: usize) -> String {
    let mut lines = Lines::new(width);
    for stage in &plan.stages {
        let transforms = match stage.transforms {
            0 => "no transforms".into(),
            n => format!("{n} transforms of length {}", stage.length),
        };
        let [read, written] = [stage.bytes_read, stage.bytes_written].map(size);
        let text = format!("{transforms}, {read} read, {written} written");
        lines.line(stage.stage, &text);
    }
    for (array, (rows, columns)) in &plan.arrays {
        let ([along, across], name) = (array.axes(), array.name());
        let text = format!("{name} {rows} x {columns} ({along} x {across})");
        lines.line("array", &text);
    }
    let (at, once) = (plan.blocks(), "frequencies at once");
    let text = format!(
        "{} sites, {} times, {} {once}",
        at.sites, at.times, at.frequencies
    );
    lines.line("blocks", &text);
    let scratch = match plan.scratch_file {
        0 => String::new(),
        bytes => format!(", and a scratch file of {}", size(bytes)),
    };
    let [needed, allowed] = [plan.memory_needed, plan.memory_allowed].map(size);
    let text = format!("{needed} of {allowed} allowed{scratch}");
    lines.line("memory", &text);
    lines.line("threads", &plan.threads.to_string());
    lines.text
}

/// Prints warnings to standard error, with what to do.
pub fn warn(warnings: &[Warning]) {
    for warning in warnings {
        message(Tone::Warning, &warning.message);
        if !warning.advice.is_empty() {
            message(Tone::Help, &warning.advice);
        }
    }
}

/// Prints a value as JSON on standard output.
pub fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value)?;
    Ok(writeln!(stdout(), "{text}")?)
}

pub fn size(bytes: u64) -> String {
    indicatif::HumanBytes(bytes).to_string()
}
