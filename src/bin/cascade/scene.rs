//! `cascade scene`: a scene to start from, its schema, what a scene describes.

use wavecascade::chain::scene::{
    Description, PRESETS, Preset, SceneSource, Units, preset, schema, template,
};
use wavecascade::measure::digits;
use wavecascade::sheet::name_of;

use crate::chain_args::SceneCommand;
use crate::prelude::*;
use crate::terminal::{Lines, number, print_json};

/// Runs the command.
pub fn run(typed: SceneCommand) -> Result<(), Failure> {
    if typed.schema {
        return print_json(&schema());
    }
    let mut out = terminal::stdout();
    if typed.presets {
        let width = PRESETS.iter().map(|preset| preset.name.len()).max();
        for Preset { name, shows, .. } in PRESETS {
            writeln!(out, "{name:width$}  {shows}", width = width.unwrap_or(0))?;
        }
        return Ok(());
    }
    if let Some(preset) = typed.preset.as_deref().and_then(preset) {
        return Ok(out.write_all(preset.text.as_bytes())?);
    }
    let Some(path) = typed.check else {
        return Ok(out.write_all(template().as_bytes())?);
    };
    let description = SceneSource::read(&path)?.setup()?.description();
    Ok(out.write_all(describe(&description, typed.json)?.as_bytes())?)
}

/// A scene as its text, else of a file, else without any key.
pub fn source_of(text: Option<String>, file: Option<&Path>) -> Result<SceneSource, Error> {
    match (text, file) {
        (Some(text), _) => Ok(SceneSource::new(None, text)),
        (None, Some(path)) => SceneSource::read(path),
        (None, None) => Ok(SceneSource::default()),
    }
}

/// A name here after that of a scene, if there is one.
pub fn named_like(scene: Option<&Path>, usual: &str, ending: &str) -> PathBuf {
    let mut name = scene.map_or(usual.into(), stem_of);
    name.push_str(ending);
    name.into()
}

/// A description in lines, or in JSON.
pub fn describe(description: &Description, json: bool) -> Result<String, Failure> {
    if json {
        return Ok(serde_json::to_string_pretty(description)? + "\n");
    }
    let mut lines = Lines::new(terminal::width());
    chain_lines(&mut lines, description);
    run_lines(&mut lines, description);
    Ok(lines.text)
}

/// What the chain is.
pub fn chain_lines(lines: &mut Lines, d: &Description) {
    let unit = |unit: &str| match d.units {
        Units::Si => format!(" {unit}"),
        Units::None => String::new(),
    };
    let with = |value: f64, of: &str| number(value) + &unit(of);
    let range = |ends: [f64; 2], of: &str| between(ends) + &unit(of);
    let (sites, contacts, law, ends) = (d.sites, d.contacts, &d.law, d.ends);
    let chain = format!("{sites} sites, {contacts} contacts, law {law}, ends {ends}");
    lines.line("chain", &chain);
    if let Some(range) = d.coefficient {
        let ratio = match d.stiffness_ratio {
            Some(ratio) => format!(", stiffness ratio {}", seven_digits(ratio)),
            None => String::new(),
        };
        let unit = d.coefficient_unit.as_deref().map(unit).unwrap_or_default();
        lines.line("coefficients", &format!("{}{unit}{ratio}", between(range)));
    }
    let (mass, total) = (range(d.mass, "kg"), with(d.total_mass, "kg"));
    lines.line("masses", &format!("{mass}, {total} in all"));
    let mut start = Vec::new();
    if d.striker_velocity != 0.0 && d.moving_sites == 1 {
        let (mass, velocity) = (with(d.striker_mass, "kg"), with(d.striker_velocity, "m/s"));
        start.push(format!("striker of {mass} at {velocity}"));
    } else if d.largest_velocity > 0.0 {
        let sites = match d.moving_sites {
            1 => "one site".to_owned(),
            n => format!("{n} sites"),
        };
        let velocity = with(d.largest_velocity, "m/s");
        start.push(format!("velocities up to {velocity} at {sites}"));
    }
    if d.largest_displacement > 0.0 {
        let displacement = with(d.largest_displacement, "m");
        start.push(format!("displacements up to {displacement}"));
    }
    if !start.is_empty() {
        lines.line("start", &start.join(", "));
    }
    if let Some(drive) = &d.drive {
        lines.line("drive", drive);
    }
    if d.precompression > 0.0 {
        lines.line("precompression", &with(d.precompression, "N"));
    }
    if d.gravity > 0.0 {
        lines.line("gravity", &with(d.gravity, "m/s^2"));
    }
    if let Some((law, range)) = &d.ground {
        let text = format!("law {law}, coefficients {}", between(*range));
        lines.line("ground", &text);
    }
    if let Some(all) = &d.resonators {
        let damped = match all.damping[1] > 0.0 {
            true => format!(", dashpots {}", range(all.damping, "N s/m")),
            false => String::new(),
        };
        let (mass, frequency) = (range(all.mass, "kg"), range(all.frequency, "Hz"));
        let text = format!(
            "{} of mass {mass}, frequency {frequency}{damped}",
            all.number
        );
        lines.line("resonators", &text);
    }
    let losses = [
        ("dashpot", d.dashpot, "N s/m"),
        ("tangent", d.tangent, "s"),
        ("drag", d.drag, "N s/m"),
    ];
    let losses = losses.into_iter().filter(|(_, value, _)| *value > 0.0);
    let losses = losses.map(|(name, value, of)| format!("{name} {}", with(value, of)));
    let losses: Vec<String> = losses.collect();
    if !losses.is_empty() {
        lines.line("losses", &losses.join(", "));
    }
}

fn run_lines(lines: &mut Lines, d: &Description) {
    let seconds = if d.units == Units::Si { " s" } else { "" };
    let accuracy = match (d.tolerance, d.step) {
        (Some(tolerance), _) => format!("tolerance {tolerance:e}"),
        (None, Some(step)) => format!("step {step:e}{seconds}"),
        (None, None) => String::new(),
    };
    lines.line("stepping", &format!("{}, {accuracy}", name_of(&d.scheme)));
    let end = match d.end_time {
        Some(time) => format!("{}{seconds}", number(time)),
        None => "when the front reaches the last site".into(),
    };
    lines.line("end", &format!("{end}, {} samples", d.samples));
    lines.line("kept", &d.record.join(", "));
    lines.line("memory", &terminal::size(d.memory));
    let limit = match d.work.limit {
        "motion" => "as the motion needs them".to_owned(),
        "step" => "as `step` states".to_owned(),
        loss => format!("as short as `{loss}` needs them"),
    };
    if let Some(steps) = d.work.steps {
        lines.line("work", &format!("about {steps:.1e} steps, {limit}"));
    }
}

/// A number with enough digits to tell chains apart.
pub fn seven_digits(x: f64) -> String {
    digits(format!("{x:.6e}").parse().unwrap_or(x))
}

fn between([least, most]: [f64; 2]) -> String {
    match least == most {
        true => number(least),
        false => format!("{} to {}", number(least), number(most)),
    }
}
