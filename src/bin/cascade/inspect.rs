//! `cascade inspect`: what a file holds, and what of it would be analyzed.

use serde_json::{Value, json};
use wavecascade::analyze::{Warning, channel_findings};
use wavecascade::field::{Axis, Inspection, ScanRecord, VariableInfo, inspect};
use wavecascade::observer::Silent;
use wavecascade::report::{records_json, records_table};
use wavecascade::sheet::Table;

use crate::advice;
use crate::analyze::open_options;
use crate::fields::expanded;
use crate::prelude::*;
use crate::scan_args::ScanArgs;
use crate::table;
use crate::terminal::{HEADING, number, paragraphs, print_json, styled};
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

/// What the files hold.
struct Seen {
    /// The first of them.
    file: PathBuf,
    found: Inspection,
    /// Of a scan.
    records: Option<Vec<ScanRecord>>,
    doubts: Vec<Warning>,
}

impl Seen {
    fn of(typed: &Inspect) -> Result<Seen, Failure> {
        let files = expanded(&typed.fields)?;
        let options = open_options(&typed.input, None);
        let (found, records) = match typed.scan.scan() {
            Some(scan) => {
                let scanned = scan.open(&files, &options)?;
                let found = Inspection {
                    format: "a scan, one record a file".into(),
                    attributes: Vec::new(),
                    variables: Vec::new(),
                    field: Ok(scanned.field),
                };
                (found, Some(scanned.records))
            }
            None => {
                typed.scan.check_files(&files)?;
                (inspect(&files[0], &options)?, None)
            }
        };
        let doubts = match &found.field {
            Ok(field) if typed.channels => channel_findings(field, &Silent)?,
            _ => Vec::new(),
        };
        Ok(Seen {
            file: files[0].clone(),
            found,
            records,
            doubts,
        })
    }
}

/// Runs the command.
pub fn run(typed: &Inspect) -> Result<(), Failure> {
    if typed.json {
        return print_json(&json(typed)?);
    }
    let seen = Seen::of(typed)?;
    let Seen { file, found, .. } = &seen;
    let mut out = terminal::stdout();
    let width = terminal::width();
    let heading = |text: &str| styled(HEADING, text);
    if let Some(records) = &seen.records {
        let title = format!("{} files as a field", records.len());
        writeln!(out, "{}", heading(&title))?;
    } else {
        let title = format!("{}: {}", file.display(), found.format);
        let what = match found.field {
            Ok(_) => "as a field",
            Err(_) => "no field yet",
        };
        let listed = listed(found, width);
        writeln!(out, "{}\n{listed}\n{}", heading(&title), heading(what))?;
    }
    let field = match &found.field {
        Ok(field) => field,
        Err(error) => {
            let advice = advice::of_error(error).into_iter();
            let lines: Vec<String> = [reason(error)].into_iter().chain(advice).collect();
            return Ok(write!(out, "{}", paragraphs(&lines, width))?);
        }
    };
    let notes = field.notes.iter().map(|note| note.text.clone());
    let lines: Vec<String> = [shape(field)].into_iter().chain(notes).collect();
    write!(out, "{}", paragraphs(&lines, width))?;
    if let Some(records) = &seen.records {
        write!(out, "\n{}", table::text(&first_and_last(records), width))?;
    }
    if typed.channels {
        writeln!(out, "\n{}", heading("channels"))?;
        let doubts = seen.doubts.iter();
        let mut lines: Vec<String> = doubts.map(|doubt| doubt.message.clone()).collect();
        if lines.is_empty() {
            let text = "none is dead, quiet, clipped, too loud or noisy, or misses samples";
            lines.push(text.into());
        }
        write!(out, "{}", paragraphs(&lines, width))?;
    }
    Ok(writeln!(out, "next: {}", command(typed, field))?)
}

/// What `--json` prints.
pub fn json(typed: &Inspect) -> Result<Value, Failure> {
    let seen = Seen::of(typed)?;
    let found = &seen.found;
    let one = |doubt: &Warning| {
        let mut found = doubt.numbers.clone();
        found["code"] = json!(doubt.code);
        found["message"] = json!(doubt.message);
        found
    };
    let mut all = json!({
        "schema": "cascade.inspect/1",
        "format": found.format,
        "field": match &found.field {
            Ok(field) => of_field(field),
            Err(error) => json!({ "error": reason(error), "advice": advice::of_error(error) }),
        },
        "channels": seen.doubts.iter().map(one).collect::<Value>(),
    });
    match &seen.records {
        Some(records) => all["records"] = records_json(records),
        None => {
            all["attributes"] = attributes_json(&found.attributes);
            all["variables"] = found.variables.iter().map(variable_json).collect();
        }
    }
    Ok(all)
}

fn attributes_json(values: &[(String, String)]) -> Value {
    let values = values.iter();
    values
        .map(|(name, value)| (name.clone(), json!(value)))
        .collect()
}

fn variable_json(v: &VariableInfo) -> Value {
    json!({
        "path": v.path,
        "dimensions": v.dimensions,
        "type": v.sample,
        "in_place": v.is_in_place,
        "coordinates": v.coordinates,
        "attributes": attributes_json(&v.attributes),
    })
}

/// What was taken of the files of a scan: of the first and the last ones.
fn first_and_last(records: &[ScanRecord]) -> Table {
    const SHOWN: usize = 4;
    let mut table = records_table(records);
    if table.rows.len() > 2 * SHOWN {
        let mut left_out = vec![String::new(); table.head.len()];
        left_out[0] = "..".into();
        let middle = SHOWN..table.rows.len() - SHOWN;
        table.rows.splice(middle, [left_out]);
    }
    table
}

/// The attributes of the file, its arrays, and their attributes.
fn listed(found: &Inspection, width: usize) -> String {
    let attributes = found.attributes.iter();
    let lines: Vec<String> = attributes
        .map(|(name, value)| format!("  {name} = {value}"))
        .collect();
    let text = paragraphs(&lines, width);
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
    let head: Vec<&str> = "array dimensions type samples unit coordinates"
        .split(' ')
        .collect();
    let rows = found.variables.iter().map(row);
    text + &table::text(&Table::of("", &head, rows), width)
}

/// Lengths, steps and units of a field.
fn shape(field: &Field) -> String {
    let with = |before: &str, unit: &Option<String>| match unit {
        Some(unit) => format!("{before}{unit}"),
        None => String::new(),
    };
    let axis = |axis: &Axis, count: usize, what: &str| {
        if *axis == Axis::index() {
            return format!("{count} {what}, counted");
        }
        let unit = with(" ", &axis.unit);
        let (first, step) = (number(axis.origin), number(axis.step));
        format!("{count} {what} from {first}{unit} by {step}{unit}")
    };
    let times = axis(&field.time, field.n_times(), "times");
    let sites = axis(&field.space, field.n_sites(), "sites");
    let quantity = field.quantity.name().replace('_', " ");
    let unit = with(" in ", &field.unit);
    format!("{quantity}{unit}: {times}; {sites}")
}

/// The command that analyzes the field as it was read here.
fn command(typed: &Inspect, field: &Field) -> String {
    let words = crate::words::as_text();
    let at = words.iter().position(|word| word == "inspect");
    let after = at.map_or(1, |at| at + 1);
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
