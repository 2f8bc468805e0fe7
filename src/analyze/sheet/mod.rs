//! What an analysis says.
//!
//! Its large arrays, which come in blocks, are not in its sheet.

mod answer;
mod evidence;
mod numbers;
mod pictures;
mod sides;
mod variables;

use serde_json::Value;

use super::Analysis;
use crate::field::Axis;
use crate::measure::digits;
use crate::sheet::{Describe, FigureLayout, Sheet, Table, number};

const DEFINITIONS: &str = "\
    Moved share: The largest difference of two cumulative spectra: the share of energy that lies above a frequency at \
        one place and below it at the other (up), or the reverse (down).
    Front, tail: The front is the energy in a window of ten widths of the pulse that begins at, or a little before, \
        each arrival; the tail is what follows.
    Launch: Of a struck chain, the way to the second half of the bodies that its front reaches; what moves is told \
        over that half.
    Spectra: Scaled to energy, of a transient, their integral is the sum of squares times the sample spacing; to \
        density, the mean square; as spectrum, a sine of amplitude A peaks at A²/2.
    Frequency and wavenumber: f counts cycles, k counts rad; k a / π = 1 is the Nyquist wavenumber of sites spaced a \
        apart. Waves exp(i (k x − ω t)): for f > 0, k > 0 travels towards +x.
    Centroid, median, 90 %: The mean of f (or k) weighted by energy, every bin counted; where the cumulative energy \
        reaches 50 % and 90 %, read off at the ends of bins, each of which stands for half a bin to both sides.
    Undefined: A site or time with less than a millionth of the largest energy, or less than the noise where that is \
        known, has no centroid: a gap in the curves.";

/// Tables of the numbers, with their titles: how the field was read, how spectra were made, how exact they are, what the run took.
const TABLES: [(&str, &str); 4] = [
    ("Field", "field"),
    ("Spectra", "conventions"),
    ("Accuracy", "accuracy"),
    ("Timings", "timings"),
];

impl Describe for Analysis {
    /// Variables: all arrays but those of the [`Sink`](crate::arrays::Sink), under the names of the manual.
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = self.words();
        variables::add(self, &mut sheet);
        sheet
    }

    fn figures(&self) -> Vec<FigureLayout> {
        // Moves along the profile beside the spectra that they are read off.
        let mut figures = evidence::figures(self);
        figures.extend(pictures::figures(self));
        figures
    }
}

impl Analysis {
    /// The sheet without variables.
    pub fn words(&self) -> Sheet<'static> {
        let axes = &self.axes;
        let unit = self.unit.as_ref().map(|unit| format!(" in {unit}"));
        let quantity = self.quantity.in_words();
        let size = format!("{} times by {} sites", axes.n_times, axes.n_sites);
        let mut sheet = Sheet::of("analyze", "Analysis", DEFINITIONS);
        sheet.version = 4;
        sheet.about = format!("{quantity}{}, {size}", unit.unwrap_or_default());
        // It is not known which axis is time.
        let guessed = self.warnings.iter().find(|of| of.code == "wide-array");
        sheet.answer = match guessed {
            Some(guessed) => guessed.message.clone(),
            None => "what moves was not requested, or nothing moves".into(),
        };
        if let Some(said) = answer::describe(self) {
            (sheet.answer, sheet.facts) = said;
        }
        let steps = step("dt", &axes.time, "time counts samples")
            + &step("dx", &axes.space, "x counts sites");
        sheet.fact("field", size + &steps);
        let transforms: u64 = self.timings.iter().map(|of| of.transforms).sum();
        sheet.detail("computation", format!("{transforms} transforms"));
        sheet.warnings.clone_from(&self.warnings);
        sheet.numbers(numbers::of(self));
        let tables = TABLES.map(|(title, name)| table(title, &sheet.numbers[name]));
        sheet.tables.extend(tables);
        sheet
    }
}

/// Members of an object, with those of objects inside, as names and values; objects of the same members as rows.
fn table(title: &str, numbers: &Value) -> Table {
    if let Value::Array(rows) = numbers {
        let members = rows.iter().filter_map(Value::as_object);
        let head = members
            .clone()
            .next()
            .into_iter()
            .flat_map(|row| row.keys());
        let head: Vec<&str> = head.map(|name| &**name).collect();
        return Table::of(
            title,
            &head,
            members.map(|row| row.values().map(text).collect()),
        );
    }
    let mut rows = Vec::new();
    add_rows("", numbers, &mut rows);
    Table::of(title, &[], rows)
}

fn add_rows(name: &str, value: &Value, rows: &mut Vec<Vec<String>>) {
    let Value::Object(members) = value else {
        return rows.push(vec![name.into(), text(value)]);
    };
    for (member, value) in members {
        let name = format!("{name} {}", member.replace('_', " "));
        add_rows(name.trim_start(), value, rows);
    }
}

fn text(value: &Value) -> String {
    match value {
        Value::Null => "none".into(),
        Value::String(text) => text.clone(),
        Value::Number(count) if !count.is_f64() => count.to_string(),
        Value::Array(values) => values.iter().map(text).collect::<Vec<_>>().join(", "),
        value => value.as_f64().map_or(value.to_string(), number),
    }
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
