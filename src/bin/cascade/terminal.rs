//! What the program prints, and what a plan would do in words.

use std::io::Write;

use wavecascade::analyze::Plan;
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

/// Prints a value as JSON on standard output.
pub fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value)?;
    Ok(writeln!(stdout(), "{text}")?)
}

pub fn size(bytes: u64) -> String {
    indicatif::HumanBytes(bytes).to_string()
}
