//! `cascade inspect`: what a file holds, and what of it would be analyzed.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};
use wavecascade::analyze::{Warning, channel_findings};
use wavecascade::field::{
    Axis, Inspection, OpenOptions, ScanRecord, Scanned, VariableInfo, inspect,
};
use wavecascade::observer::Silent;
use wavecascade::sheet::Table;
use wavecascade::{Error, Field};

use crate::advice;
use crate::analyze::open_options;
use crate::args::Input;
use crate::failure::Failure;
use crate::scan_args::{ScanArgs, records_json};
use crate::table;
use crate::terminal::{self, HEADING, number, paragraphs, styled};
use crate::words::quoted;

/// What `cascade inspect` takes.
#[derive(Debug, Args)]
pub struct Inspect {
    /// File to look into; with `--position-from` all files of a scan.
    #[arg(required = true, value_name = "FILE")]
    pub fields: Vec<PathBuf>,
    /// Read all samples, and name the channels that are dead, quiet, clipped, too loud or noisy.
    #[arg(long)]
    pub channels: bool,
    /// Print the list as JSON.
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub scan: ScanArgs,
}

/// What `--json` prints.
pub fn json(typed: &Inspect, files: &[PathBuf]) -> Result<Value, Failure> {
    let options = options_of(typed);
    if let Some(scan) = typed.scan.scan() {
        let scanned = scan.open(files, &options)?;
        let doubts = channels(typed, &scanned.field)?;
        return Ok(scan_json(&scanned, &doubts));
    }
    typed.scan.check_files(files)?;
    let found = inspect(&files[0], &options)?;
    let doubts = match &found.field {
        Ok(field) => channels(typed, field)?,
        Err(_) => Vec::new(),
    };
    Ok(in_json(&found, &doubts))
}

fn options_of(typed: &Inspect) -> OpenOptions {
    OpenOptions {
        hash: false,
        ..open_options(&typed.input, None)
    }
}

/// Runs the command.
pub fn run(typed: Inspect, files: &[PathBuf]) -> Result<(), Failure> {
    if typed.json {
        let found = json(&typed, files)?;
        let text = serde_json::to_string_pretty(&found).map_err(std::io::Error::from)?;
        return Ok(writeln!(terminal::stdout(), "{text}")?);
    }
    let options = options_of(&typed);
    if let Some(scan) = typed.scan.scan() {
        let scanned = scan.open(files, &options)?;
        let doubts = channels(&typed, &scanned.field)?;
        return list_scan(&typed, &scanned, &doubts);
    }
    typed.scan.check_files(files)?;
    let file = &files[0];
    let found = inspect(file, &options)?;
    let doubts = match &found.field {
        Ok(field) => channels(&typed, field)?,
        Err(_) => Vec::new(),
    };
    let mut out = terminal::stdout();
    let width = terminal::width();
    let name = file.display();
    writeln!(
        out,
        "{}",
        styled(HEADING, &format!("{name}: {}", found.format))
    )?;
    write!(out, "{}", listed(&found, width))?;
    match &found.field {
        Ok(field) => {
            writeln!(out, "\n{}", styled(HEADING, "as a field"))?;
            let notes = field.notes.iter().map(|note| note.text.clone());
            for line in std::iter::once(shape(field)).chain(notes) {
                write!(out, "{}", paragraphs(&[line], width))?;
            }
            print_channels(&mut out, &typed, &doubts)?;
            writeln!(out, "next: {}", command(&typed, field))?;
        }
        Err(error) => {
            writeln!(out, "\n{}", styled(HEADING, "no field yet"))?;
            write!(out, "{}", paragraphs(&[reason(error)], width))?;
            if let Some(advice) = advice::of_error(error) {
                write!(out, "{}", paragraphs(&[advice], width))?;
            }
        }
    }
    Ok(())
}

/// What is found about single channels, if it is requested.
fn channels(typed: &Inspect, field: &Field) -> Result<Vec<Warning>, Failure> {
    match typed.channels {
        true => Ok(channel_findings(field, &Silent)?),
        false => Ok(Vec::new()),
    }
}

fn print_channels(
    out: &mut impl Write,
    typed: &Inspect,
    doubts: &[Warning],
) -> Result<(), Failure> {
    if !typed.channels {
        return Ok(());
    }
    let width = terminal::width();
    writeln!(out, "\n{}", styled(HEADING, "channels"))?;
    if doubts.is_empty() {
        let text = "none is dead, quiet, clipped, too loud or noisy, or misses samples";
        write!(out, "{}", paragraphs(&[text.into()], width))?;
    }
    for doubt in doubts {
        write!(
            out,
            "{}",
            paragraphs(std::slice::from_ref(&doubt.message), width)
        )?;
    }
    Ok(())
}

fn channels_json(doubts: &[Warning]) -> Value {
    let one = |doubt: &Warning| {
        let mut found = doubt.numbers.clone();
        found["code"] = json!(doubt.code);
        found["message"] = json!(doubt.message);
        found
    };
    doubts.iter().map(one).collect()
}

fn scan_json(scanned: &Scanned, doubts: &[Warning]) -> Value {
    json!({
        "schema": "cascade.inspect/1",
        "format": "a scan, one record a file",
        "records": records_json(&scanned.records),
        "field": of_field(&scanned.field),
        "channels": channels_json(doubts),
    })
}

/// What was taken of the files of a scan: of the first and the last ones.
fn list_scan(typed: &Inspect, scanned: &Scanned, doubts: &[Warning]) -> Result<(), Failure> {
    const SHOWN: usize = 4;
    let Scanned { field, records } = scanned;
    let mut out = terminal::stdout();
    let width = terminal::width();
    let title = format!("{} files as a field", records.len());
    writeln!(out, "{}", styled(HEADING, &title))?;
    let notes = field.notes.iter().map(|note| note.text.clone());
    for line in std::iter::once(shape(field)).chain(notes) {
        write!(out, "{}", paragraphs(&[line], width))?;
    }
    let row = |record: &ScanRecord| {
        vec![
            record.path.display().to_string(),
            number(record.position),
            record.n_times.to_string(),
            number(record.delay),
            record.correlation.map(number).unwrap_or_default(),
        ]
    };
    let mut rows: Vec<Vec<String>> = records.iter().map(row).collect();
    if rows.len() > 2 * SHOWN {
        let left_out = vec![
            "..".into(),
            String::new(),
            String::new(),
            String::new(),
            String::new(),
        ];
        rows.splice(SHOWN..rows.len() - SHOWN, [left_out]);
    }
    let head = ["file", "position", "times", "delay, samples", "correlation"];
    write!(out, "\n{}", table::text(&Table::of("", &head, rows), width))?;
    print_channels(&mut out, typed, doubts)?;
    Ok(writeln!(out, "next: {}", command(typed, field))?)
}

/// The attributes of the file, its arrays, and their attributes.
fn listed(found: &Inspection, width: usize) -> String {
    let mut text = String::new();
    let mut attributes = |title: &str, values: &[(String, String)]| {
        for (name, value) in values {
            text += &paragraphs(&[format!("  {title}{name} = {value}")], width);
        }
    };
    attributes("", &found.attributes);
    if found.variables.is_empty() {
        return text;
    }
    let row = |v: &VariableInfo| {
        let place = if v.is_in_place { "in place" } else { "decoded" };
        let unit = v.attributes.iter().find(|(name, _)| name == "units");
        let coordinates: Vec<String> = v.coordinates.iter().flatten().cloned().collect();
        vec![
            v.path.clone(),
            v.dimensions.clone(),
            v.sample.clone(),
            place.to_owned(),
            unit.map(|(_, unit)| unit.clone()).unwrap_or_default(),
            coordinates.join("; "),
        ]
    };
    let head = [
        "array",
        "dimensions",
        "type",
        "samples",
        "unit",
        "coordinates",
    ];
    let rows = found.variables.iter().map(row);
    text + &table::text(&Table::of("", &head, rows), width)
}

/// Lengths, steps and units of a field.
fn shape(field: &Field) -> String {
    let axis = |axis: &Axis, count: usize, what: &str| match (&axis.unit, *axis == Axis::index()) {
        (_, true) => format!("{count} {what}, counted"),
        (unit, _) => {
            let unit = unit
                .as_deref()
                .map_or(String::new(), |unit| format!(" {unit}"));
            let (first, step) = (number(axis.origin), number(axis.step));
            format!("{count} {what} from {first}{unit} by {step}{unit}")
        }
    };
    let times = axis(&field.time, field.n_times(), "times");
    let sites = axis(&field.space, field.n_sites(), "sites");
    let quantity = field.quantity.name().replace('_', " ");
    let unit = field
        .unit
        .as_deref()
        .map_or(String::new(), |unit| format!(" in {unit}"));
    format!("{quantity}{unit}: {times}; {sites}")
}

/// The command that analyzes the field as it was read here.
fn command(typed: &Inspect, field: &Field) -> String {
    let words = crate::words::as_text();
    let after = words
        .iter()
        .position(|word| word == "inspect")
        .map_or(1, |at| at + 1);
    let rest = words[after..].iter().filter(|word| *word != "--channels");
    let mut rest: Vec<String> = rest.map(|word| quoted(word)).collect();
    let counts = |axis: &Axis| *axis == Axis::index();
    if counts(&field.time) && typed.input.dt.is_none() && typed.input.rate.is_none() {
        rest.push("--dt STEP".into());
    }
    let is_scan = typed.scan.position_from.is_some();
    if !is_scan && counts(&field.space) && typed.input.dx.is_none() && field.n_sites() > 1 {
        rest.push("--dx STEP".into());
    }
    format!("cascade analyze {}", rest.join(" "))
}

/// An error without the name of the file, which stands above.
fn reason(error: &Error) -> String {
    match error {
        Error::Input { fault, .. } => fault.to_string(),
        error => error.to_string(),
    }
}

fn in_json(found: &Inspection, doubts: &[Warning]) -> Value {
    let attributes = |values: &[(String, String)]| -> Value {
        values
            .iter()
            .map(|(name, value)| (name.clone(), json!(value)))
            .collect()
    };
    let variables = found.variables.iter().map(|v| {
        json!({
            "path": v.path,
            "dimensions": v.dimensions,
            "type": v.sample,
            "in_place": v.is_in_place,
            "coordinates": v.coordinates,
            "attributes": attributes(&v.attributes),
        })
    });
    let field = match &found.field {
        Ok(field) => of_field(field),
        Err(error) => json!({ "error": reason(error), "advice": advice::of_error(error) }),
    };
    json!({
        "schema": "cascade.inspect/1",
        "format": found.format,
        "attributes": attributes(&found.attributes),
        "variables": variables.collect::<Vec<_>>(),
        "field": field,
        "channels": channels_json(doubts),
    })
}

fn of_field(field: &Field) -> Value {
    let axis = |axis: &Axis, count: usize| json!({ "count": count, "origin": axis.origin, "step": axis.step, "unit": axis.unit });
    json!({
        "quantity": field.quantity,
        "unit": field.unit,
        "time": axis(&field.time, field.n_times()),
        "space": axis(&field.space, field.n_sites()),
        "notes": field.notes.iter().map(|note| note.text.clone()).collect::<Vec<_>>(),
    })
}
