//! Universal files: functions at nodes (data sets 58 and 58b), coordinates of nodes (15 and 2411).

mod function;
mod text;

use std::collections::{HashMap, HashSet};

use indexmap::IndexSet;

use crate::cursor::{Budget, beginning};
use crate::rows::{Record, Rows};
use crate::sets::{Sets, Traits, only_rising, others, sets};
use crate::{
    Bytes, Container, Coordinate, Dimension, Error, Format, Options, Place, Remark, Result, Sample,
    SampleType, Value, Variable,
};
use function::Function;
use text::Lines;

/// The format of these bytes, if it is one of this module.
pub(crate) fn detect(bytes: &[u8]) -> Option<Format> {
    // Only as far as two lines reach: another format may have no line end at all.
    let bytes = &bytes[..bytes.len().min(200)];
    let mut lines = Lines { bytes, at: 0 };
    let is_number = |digits: &[u8]| !digits.is_empty() && digits.iter().all(u8::is_ascii_digit);
    let begins = lines.next()?.is_delimiter() && is_number(lines.next()?.columns(0, 6));
    begins.then_some(Format::Uff)
}

/// What a file holds.
struct Contents {
    functions: Vec<(Traits, (Function, Record))>,
    nodes: HashMap<i64, [f64; 3]>,
    skipped: IndexSet<String>,
    /// Of numbers in ASCII.
    budget: Budget,
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let contents = Contents::read((*bytes).as_ref(), options)?;
    let sets = sets(contents.functions);
    let remarks: Vec<_> = sets.keys().map(|traits| doubts(&sets, traits)).collect();
    let mut container = Container::new(format, &bytes);
    if !contents.skipped.is_empty() {
        let skipped = Value::Texts(contents.skipped.into_iter().collect());
        container.attributes.insert("skipped", skipped);
    }
    let is_single = sets.len() == 1;
    for (number, ((_, set), remark)) in sets.into_iter().zip(remarks).enumerate() {
        let suffix = match is_single {
            true => String::new(),
            false => format!("/{}", number + 1),
        };
        container.remark_on_next(remark);
        add(set, &contents.nodes, &suffix, &bytes, &mut container);
    }
    Ok(container)
}

/// What is said of functions that form one variable: which others are no part of it, which of its own are
/// doubtful.
fn doubts(sets: &Sets<(Function, Record)>, traits: &Traits) -> Option<String> {
    let set = &sets[traits];
    if set.len() == 1 {
        return None;
    }
    let named = |(function, _): &(Function, Record)| {
        let name = match function.name.as_str() {
            "" => String::new(),
            name => format!(" ({name:?})"),
        };
        format!("{}{name} at node {}", function.number, function.response[0])
    };
    let label = &set[0].0.label;
    let renamed = set.iter().filter(|one| one.0.label != *label);
    let renamed = renamed.map(|one| format!("{}: label {:?}", named(one), one.0.label));
    // Where a hammer roves, the nodes of the references tell the records apart.
    let responses = |function: &Function| function.response[0];
    let references = |function: &Function| function.reference[0];
    let varies = |of: &dyn Fn(&Function) -> i64| set.iter().any(|one| of(&one.0) != of(&set[0].0));
    let node: &dyn Fn(&Function) -> i64 = match !varies(&responses) && varies(&references) {
        true => &references,
        false => &responses,
    };
    let mut seen = HashSet::new();
    let is_again = |one: &&(Function, Record)| node(&one.0) != 0 && !seen.insert(node(&one.0));
    let again = set.iter().filter(is_again).map(named);
    let left_out = "records that are left out, so that those behind them move up:";
    let other =
        format!("records with another label than {label:?} that are taken with the others:");
    let said = [
        Remark::listing(left_out, others(sets, traits, named)),
        Remark::listing("records of a node that has one already:", again),
        Remark::listing(&other, renamed),
    ];
    let said: Vec<String> = said.into_iter().flatten().collect();
    (!said.is_empty()).then(|| said.join("; "))
}

impl Contents {
    fn read(bytes: &[u8], options: &Options) -> Result<Contents> {
        let mut contents = Contents {
            functions: Vec::new(),
            nodes: HashMap::new(),
            skipped: IndexSet::new(),
            budget: Budget::new("the numbers of data sets 58", options),
        };
        let mut lines = Lines { bytes, at: 0 };
        while let Some(line) = lines.next() {
            if line.text.trim_ascii().is_empty() {
                continue;
            }
            if !line.is_delimiter() {
                let place = format!("before byte {}", lines.at);
                return Err(Error::damaged(place, "-1", beginning(line.text)));
            }
            let Some(id) = lines.next() else { break };
            match id.columns(0, 6) {
                b"58" => {
                    let number = contents.functions.len() + 1;
                    let mut function = Function::header(id, &mut lines, number)?;
                    contents.budget.take(function.memory())?;
                    let record = function.numbers(&mut lines)?;
                    let traits = function.traits();
                    contents.functions.push((traits, (function, record)));
                }
                b"15" => contents.nodes(&mut lines, false)?,
                b"2411" => contents.nodes(&mut lines, true)?,
                other => {
                    let other = String::from_utf8_lossy(other).into_owned();
                    if id.columns(6, 7).eq_ignore_ascii_case(b"b") {
                        let what = format!("binary data set {other}");
                        return Err(Error::unsupported(what, "write the file without it"));
                    }
                    contents.skipped.insert(other);
                    while !lines.expect("the end of the data set")?.is_delimiter() {}
                }
            }
        }
        match contents.functions.is_empty() {
            true => Err(Error::damaged("the file", "a data set 58 or 58b", "none")),
            false => Ok(contents),
        }
    }

    /// Nodes of one line (data set 15) or of two (2411).
    fn nodes(&mut self, lines: &mut Lines, has_two_lines: bool) -> Result<()> {
        loop {
            let mut line = lines.expect("the end of the nodes")?;
            if line.is_delimiter() {
                return Ok(());
            }
            let node = line.integer(0, 10)?;
            let (from, width) = if has_two_lines { (0, 25) } else { (40, 13) };
            if has_two_lines {
                line = lines.expect("the coordinates of a node")?;
            }
            let along = |i: usize| line.float(from + i * width, from + (i + 1) * width);
            self.nodes.insert(node, [along(0)?, along(1)?, along(2)?]);
        }
    }
}

/// Adds the variables of functions that have their traits in common.
fn add(
    set: Vec<(Function, Record)>,
    nodes: &HashMap<i64, [f64; 3]>,
    suffix: &str,
    file: &Bytes,
    container: &mut Container,
) {
    let (functions, records): (Vec<Function>, Vec<Record>) = set.into_iter().unzip();
    let first = &functions[0];
    let record = Dimension::new(functions.len() as u64).named("record");
    let name = match first.function_type == 1 && first.abscissa_type == 17 {
        true => "time",
        false => "abscissa",
    };
    let abscissa = Dimension::new(first.count as u64).named(name);
    let abscissa_unit = match (first.abscissa_unit.as_str(), first.abscissa_type) {
        ("", 17) => "s",
        ("", 18) => "Hz",
        (unit, _) => unit,
    };

    let path = format!("/records{suffix}");
    let dimensions = vec![record.clone(), abscissa.clone()];
    let mut variable = Variable::new(path.clone(), dimensions, Sample::F64);
    let attributes = &mut variable.attributes;
    attributes.insert_text("long_name", &*first.name);
    attributes.insert_text("ordinate", &*first.label);
    // What the standard calls displacement, reaction force, velocity, acceleration and excitation force.
    let quantity = match first.ordinate_type {
        8 => "displacement",
        9 | 13 => "force",
        11 => "velocity",
        12 => "acceleration",
        _ => "",
    };
    attributes.insert_text("standard_name", quantity);
    let ordinate = match first.denominator_unit.as_str() {
        "" => "units",
        _ => "numerator_units",
    };
    attributes.insert_text(ordinate, &*first.ordinate_unit);
    attributes.insert_text("denominator_units", &*first.denominator_unit);
    attributes.insert("function_type", Value::Integers(vec![first.function_type]));

    let mut listed: Vec<(&str, Vec<f64>)> = Vec::new();
    for (name, of) in [
        (
            "response_node",
            (|one| one.response[0]) as fn(&Function) -> i64,
        ),
        ("response_direction", |one| one.response[1]),
        ("reference_node", |one| one.reference[0]),
        ("reference_direction", |one| one.reference[1]),
    ] {
        match functions.iter().all(|one| of(one) == of(first)) {
            true => attributes.insert(name, Value::Integers(vec![of(first)])),
            false => listed.push((name, functions.iter().map(|one| of(one) as f64).collect())),
        }
    }

    let position = |function: &Function| {
        let found = nodes.get(&function.response[0]).copied();
        found.unwrap_or([f64::NAN; 3])
    };
    let positions: Vec<[f64; 3]> = functions.iter().map(position).collect();
    let at = container.variables.len() + 1;
    if positions.iter().any(|position| !position[0].is_nan()) {
        let along = |axis: usize| positions.iter().map(|at| at[axis]).collect();
        let axes: [Vec<f64>; 3] = [0, 1, 2].map(along);
        let rising = only_rising(axes.iter().map(|axis| &axis[..]));
        let coordinate = rising.map(|axis| Coordinate::Listed(at + listed.len() + axis));
        variable.dimensions[0].coordinate = coordinate;
        listed.extend(["x", "y", "z"].into_iter().zip(axes));
    }
    let even = first.even;
    let even = even.map(|[origin, step]| Coordinate::even(origin, step, abscissa_unit));
    let is_listed = first.even.is_none() && !first.is_complex;
    let at_end = || Coordinate::Listed(at + listed.len());
    variable.dimensions[1].coordinate = even.or_else(|| is_listed.then(at_end));

    if first.is_complex || !first.is_record() {
        let kind = first.function_type;
        let what = match first.is_record() {
            true => "complex numbers".to_owned(),
            false => format!("functions of type {kind}, no records of time"),
        };
        variable.sample_type = SampleType::Other(what);
        container.push(variable);
    } else {
        let mut types = records.iter().filter_map(|record| record.sample);
        let sample = types.next().filter(|first| types.all(|one| one == *first));
        let sample = sample.unwrap_or(Sample::F64);
        let mut rows = Rows {
            path,
            file: Bytes::clone(file),
            records,
            sample,
            is_time_first: false,
        };
        if let Some(strided) = rows.strided() {
            variable.place = Place::Strided(strided);
        }
        variable.sample_type = SampleType::Number(sample);
        container.push_decoded(variable, rows);
    }
    let mut list = |name: &str, dimension: &Dimension, unit: &str, values: Vec<f64>| {
        container.push_floats(format!("/{name}{suffix}"), dimension, unit, values);
    };
    for (name, values) in listed {
        list(name, &record, "", values);
    }
    if is_listed {
        list(
            "abscissa",
            &abscissa,
            abscissa_unit,
            first.abscissas.clone(),
        );
    }
}
