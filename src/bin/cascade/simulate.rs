//! `cascade simulate`: a scene with options over it, the run, the run file.

use std::io::Write;
use std::path::Path;
use std::time::Instant;

use serde_json::json;
use wavecascade::chain::scene::{Description, Setup, Units};
use wavecascade::chain::{CHECK_FACTOR, Run};
use wavecascade::measure::digits;
use wavecascade::report::{RUN_SCHEMA, RunFile};
use wavecascade::sheet::name_of;

use crate::advice;
use crate::chain_args::Simulate;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::scene::{chain_lines, describe, named_like, source_of};
use crate::terminal::{self, Lines, error_size, number, print_json};

/// Runs the command.
pub fn run(typed: Simulate) -> Result<(), Failure> {
    let source = source_of(None, typed.scene.as_deref())?.with(typed.keys.settings.clone());
    let setup = source.setup()?;
    if typed.plan {
        let text = describe(&setup.description(), typed.json)?;
        return Ok(terminal::stdout().write_all(text.as_bytes())?);
    }
    let out = typed
        .out
        .clone()
        .unwrap_or_else(|| named_like(typed.scene.as_deref(), "run", ".npz"));
    let progress = Progress::new(!typed.quiet);
    // Before any work: could the run be written?
    RunFile::check(&out, typed.force)?;
    let started = Instant::now();
    let run = typed.compute(&source, &setup, &progress)?;
    let seconds = started.elapsed().as_secs_f64();
    progress.begin_writing();
    RunFile::write(&out, typed.force, &setup, &run, &progress)?;
    progress.clear();
    tell(&typed, &setup, &run, &out, seconds)
}

fn tell(
    typed: &Simulate,
    setup: &Setup,
    run: &Run,
    out: &Path,
    seconds: f64,
) -> Result<(), Failure> {
    let description = setup.description();
    if typed.json {
        let warnings: Vec<_> = run
            .report
            .warnings
            .iter()
            .map(|w| json!({ "message": w.message(), "advice": advice::of_run(w) }))
            .collect();
        let summary = json!({
            "schema": RUN_SCHEMA,
            "file": out,
            "seconds": seconds,
            "end_time": run.time[run.time.len() - 1],
            "scene": description,
            "report": run.report,
            "gradient_error": run.gradient.as_ref().map(|gradient| &gradient.error),
            "warnings": warnings,
        });
        print_json(&summary)?;
    } else if !typed.quiet {
        let text = summary(&description, run, seconds, terminal::width());
        let mut stdout = terminal::stdout();
        stdout.write_all(text.as_bytes())?;
        writeln!(stdout, "wrote {}; next: cascade analyze {0}", out.display())?;
    }
    Ok(())
}

/// Summary of a run and its accuracy, in lines of at most `width` columns.
fn summary(description: &Description, run: &Run, seconds: f64, width: usize) -> String {
    let mut lines = Lines::new(width);
    chain_lines(&mut lines, description);
    let report = &run.report;
    let unit = if description.units == Units::Si {
        " s"
    } else {
        ""
    };
    let end = run.time[run.time.len() - 1];
    let auto = match description.end_time {
        Some(_) => "",
        None => ", when the front reached the last site",
    };
    let samples = description.samples;
    let past_wall = match (description.end_time, description.ends) {
        (None, "wall" | "fixed") => run.end_behind_wall_peak(),
        _ => None,
    };
    lines.line(
        "time",
        &format!("0 to {}{unit}{auto}, {samples} samples", number(end)),
    );
    if let Some(end) = past_wall {
        let text = format!(
            "the force there still rises at the end; its peak is in a run with --end-time {}",
            digits(end)
        );
        lines.line("wall", &text);
    }
    let error = match report.error {
        Some(0.0) => "0: a second run of other steps gave the same bits".into(),
        Some(error) => format!(
            "{} of {} in any velocity at any sample: twice the difference from a run of up to {} \
             times the error a step, or what rounding leaves, if that is more",
            error_size(error),
            number(report.velocity_scale),
            1.0 / CHECK_FACTOR
        ),
        None => "not estimated: a single run".into(),
    };
    lines.line("estimated error", &error);
    if let Some(drift) = report.energy_drift {
        let drift = error_size(drift);
        lines.line(
            "energy drift",
            &format!("{drift}, which bounds no error of velocities"),
        );
    }
    let cost = report.cost;
    lines.line(
        "stepping",
        &format!(
            "{}: {} steps and {} repeated, {} contact forces, {} openings and closings corrected",
            name_of(&description.scheme),
            cost.steps,
            cost.rejected_steps,
            cost.forces,
            cost.corrected_contacts
        ),
    );
    if let Some(gradient) = &run.gradient {
        let worst = gradient.error.iter().fold(0.0f64, |m, e| m.max(*e));
        let text = format!(
            "{}, to {} of the largest",
            gradient.names(),
            error_size(worst)
        );
        lines.line("gradient", &text);
    }
    if let Some(found) = &report.lyapunov {
        let [half, whole] = [found.convergence[2][1], found.exponent].map(number);
        lines.line(
            "Lyapunov exponent",
            &format!("{whole}, {half} up to half of the time"),
        );
    }
    lines.line("computation", &format!("{seconds:.3} s"));
    for warning in &report.warnings {
        lines.warning(&warning.message(), advice::of_run(warning));
    }
    lines.text
}
