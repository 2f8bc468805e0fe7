//! `cascade simulate`: a scene with options over it, the run, the run file.

use std::time::Instant;

use serde_json::json;
use wavecascade::chain::scene::{Description, Setup, Units};
use wavecascade::chain::{CHECK_FACTOR, Run};
use wavecascade::measure::digits;
use wavecascade::report::{RUN_SCHEMA, RunFile};
use wavecascade::sheet::{Warning, name_of};

use crate::advice;
use crate::chain_args::Simulate;
use crate::prelude::*;
use crate::scene::{chain_lines, describe, named_like, source_of};
use crate::terminal::{Lines, error_size, number, print_json};

/// Runs the command.
pub fn run(typed: Simulate) -> Result<(), Failure> {
    let source = source_of(None, typed.scene.as_deref())?.with(typed.keys.settings.clone());
    let setup = source.setup()?;
    if typed.plan {
        let text = describe(&setup.description(), typed.json)?;
        return Ok(terminal::stdout().write_all(text.as_bytes())?);
    }
    let named = || named_like(typed.scene.as_deref(), "run", ".npz");
    let out = typed.out.clone().unwrap_or_else(named);
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
    let warnings: Vec<Warning> = run.report.warnings.iter().map(advice::of_run).collect();
    if typed.json {
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
        let text = summary(&description, run, &warnings, seconds);
        let mut stdout = terminal::stdout();
        stdout.write_all(text.as_bytes())?;
        writeln!(stdout, "wrote {}; next: cascade analyze {0}", out.display())?;
    }
    Ok(())
}

/// Summary of a run and its accuracy.
fn summary(description: &Description, run: &Run, warnings: &[Warning], seconds: f64) -> String {
    let mut lines = Lines::new(terminal::width());
    chain_lines(&mut lines, description);
    let report = &run.report;
    let unit = if description.units == Units::Si {
        " s"
    } else {
        ""
    };
    let end = number(run.time[run.time.len() - 1]);
    let auto = match description.end_time {
        Some(_) => "",
        None => ", when the front reached the last site",
    };
    let text = format!("0 to {end}{unit}{auto}, {} samples", description.samples);
    lines.line("time", &text);
    let past_wall = match (description.end_time, description.ends) {
        (None, "wall" | "fixed") => run.end_behind_wall_peak(),
        _ => None,
    };
    if let Some(end) = past_wall.map(digits) {
        let text = format!(
            "the force there still rises at the end; its peak is in a run with --end-time {end}"
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
    if let Some(drift) = report.energy_drift.map(error_size) {
        let text = format!("{drift}, which bounds no error of velocities");
        lines.line("energy drift", &text);
    }
    let (cost, scheme) = (report.cost, name_of(&description.scheme));
    let text = format!(
        "{scheme}: {} steps and {} repeated, {} contact forces, {} openings and closings corrected",
        cost.steps, cost.rejected_steps, cost.forces, cost.corrected_contacts
    );
    lines.line("stepping", &text);
    if let Some(gradient) = &run.gradient {
        let worst = gradient.error.iter().fold(0.0f64, |m, e| m.max(*e));
        let (names, worst) = (gradient.names(), error_size(worst));
        let text = format!("{names}, to {worst} of the largest");
        lines.line("gradient", &text);
    }
    if let Some(found) = &report.lyapunov {
        let [half, whole] = [found.convergence[2][1], found.exponent].map(number);
        let text = format!("{whole}, {half} up to half of the time");
        lines.line("Lyapunov exponent", &text);
    }
    lines.line("computation", &format!("{seconds:.3} s"));
    for warning in warnings {
        lines.warning(&warning.message, &warning.advice);
    }
    lines.text
}
