//! Universal files: functions at nodes (data sets 58 and 58b), coordinates of nodes (15 and 2411).

mod function;
mod text;

use std::collections::hash_map::DefaultHasher;
use std::collections::{HashMap, HashSet};
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use crate::{
    Attributes, Block, ByteOrder, Bytes, Container, Coordinate, Decoder, Dimension, Error, Format,
    Options, Place, Remark, Result, Sample, SampleType, Value, Variable,
};
use function::{Function, Kind, bits};
use text::{Lines, columns, float, integer, is_delimiter};

/// The format of a file with this extension (lower case) and these bytes, if it is one of this module.
pub(crate) fn detect(extension: &str, bytes: &[u8]) -> Option<Format> {
    // Only as far as two lines reach: another format may have no line end at all.
    let bytes = &bytes[..bytes.len().min(200)];
    let mut lines = Lines { bytes, at: 0 };
    let is_number = |line: &[u8]| columns(line, 0, 6).iter().all(u8::is_ascii_digit);
    let begins = lines.next().is_some_and(is_delimiter)
        && lines
            .next()
            .is_some_and(|line| is_number(line) && !columns(line, 0, 6).is_empty());
    (begins || matches!(extension, "uff" | "unv" | "uf" | "bunv")).then_some(Format::Uff)
}

/// Functions that form one variable.
struct Group {
    kind: Kind,
    functions: Vec<Function>,
    /// Their places among the functions of the file, from 1.
    numbers: Vec<usize>,
    rows: Vec<Row>,
    /// Abscissas of uneven spacing, the same for all functions.
    abscissas: Vec<f64>,
}

/// What a file holds.
#[derive(Default)]
struct Contents {
    groups: Vec<Group>,
    /// Places of groups by the hash of what their functions have in common.
    places: HashMap<u64, Vec<usize>>,
    nodes: HashMap<i64, [f64; 3]>,
    skipped: Vec<String>,
    /// How many functions were read.
    functions: usize,
    /// Bytes of memory for numbers in ASCII.
    held: u64,
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let held = Arc::clone(&bytes);
    let contents = Contents::read((*held).as_ref(), options)?;
    let mut sources = Vec::new();
    let mut variables = Vec::new();
    let is_single = contents.groups.len() == 1;
    let apart = left_out(&contents.groups);
    let mut remarks = Vec::new();
    for (number, group) in contents.groups.into_iter().enumerate() {
        let suffix = if is_single {
            String::new()
        } else {
            format!("/{}", number + 1)
        };
        let variable = Some(variables.len());
        let text = apart[number].clone();
        remarks.extend(text.map(|text| Remark { variable, text }));
        add(
            group,
            &contents.nodes,
            &suffix,
            &mut variables,
            &mut sources,
        );
    }
    let decoder = UffDecoder {
        bytes: held,
        sources,
    };
    let mut container = Container::new(format, bytes, Some(Box::new(decoder)));
    container.variables = variables;
    container.remarks = remarks;
    if !contents.skipped.is_empty() {
        container
            .attributes
            .insert("skipped", Value::Texts(contents.skipped));
    }
    Ok(container)
}

/// What is said of each group about functions of the file that are no part of it, although they measure the
/// same, or about some whose label is another one.
fn left_out(groups: &[Group]) -> Vec<Option<String>> {
    /// Functions after which no others are looked for.
    const ENOUGH: usize = 64;
    let named = |group: &Group, i: usize, why: &str| {
        let function = &group.functions[i];
        let name = match function.name.as_str() {
            "" => String::new(),
            name => format!(" ({name:?})"),
        };
        let node = function.response[0];
        format!("{}{name} at node {node}: {why}", group.numbers[i])
    };
    let text = |group: &Group| {
        let mut apart: Vec<(usize, String)> = Vec::new();
        if group.functions.len() == 1 {
            return None;
        }
        for other in groups.iter().filter(|other| !std::ptr::eq(*other, group)) {
            let Some(why) = other.kind.differs(&group.kind) else {
                continue;
            };
            let of_it =
                (0..other.functions.len()).map(|i| (other.numbers[i], named(other, i, &why)));
            apart.extend(of_it);
            if apart.len() > ENOUGH {
                break;
            }
        }
        apart.sort();
        let label = &group.functions[0].label;
        let renamed = (0..group.functions.len()).filter(|&i| group.functions[i].label != *label);
        let renamed = renamed.map(|i| {
            let why = format!("label {:?}, not {label:?}", group.functions[i].label);
            named(group, i, &why)
        });
        let apart = apart.into_iter().map(|(_, text)| text);
        let said = [
            Remark::listing(
                "records that are left out, so that those behind them move up:",
                apart,
            ),
            Remark::listing(
                "records with another label that are taken with the others:",
                renamed,
            ),
        ];
        let said: Vec<String> = said.into_iter().flatten().collect();
        (!said.is_empty()).then(|| said.join("; "))
    };
    groups.iter().map(text).collect()
}

impl Contents {
    fn read(bytes: &[u8], options: &Options) -> Result<Contents> {
        let mut contents = Contents::default();
        let mut skipped = HashSet::new();
        let mut lines = Lines { bytes, at: 0 };
        while let Some(line) = lines.next() {
            if line.trim_ascii().is_empty() {
                continue;
            }
            if !is_delimiter(line) {
                let found = String::from_utf8_lossy(&line[..line.len().min(20)]).into_owned();
                return Err(Error::damaged(
                    format!("before byte {}", lines.at),
                    "-1",
                    found,
                ));
            }
            let Some(id) = lines.next() else { break };
            match columns(id, 0, 6) {
                b"58" => contents.function(id, &mut lines, options)?,
                b"15" => contents.nodes(&mut lines, false)?,
                b"2411" => contents.nodes(&mut lines, true)?,
                other => {
                    if columns(id, 6, 7).eq_ignore_ascii_case(b"b") {
                        let what = format!("binary data set {}", String::from_utf8_lossy(other));
                        return Err(Error::unsupported(what, "write the file without it"));
                    }
                    let other = String::from_utf8_lossy(other).into_owned();
                    if skipped.insert(other.clone()) {
                        contents.skipped.push(other);
                    }
                    while !is_delimiter(lines.expect("the end of the data set")?) {}
                }
            }
        }
        if contents.groups.is_empty() {
            return Err(Error::damaged("the file", "a data set 58 or 58b", "none"));
        }
        Ok(contents)
    }

    fn function(&mut self, id: &[u8], lines: &mut Lines, options: &Options) -> Result<()> {
        let function = function::header(id, lines)?;
        let kind = function.kind.clone();
        let (mut start, mut ordinates, mut abscissas) = (0, Vec::new(), Vec::new());
        self.functions += 1;
        if function.binary.is_some() {
            start = function::skip_binary(&function, lines)?;
        } else if kind.is_complex {
            while !is_delimiter(lines.expect("the end of data set 58")?) {}
        } else {
            let needed = self.held + 8 * (kind.count * kind.per_point()) as u64;
            if let Some(allowed) = options.memory.filter(|&allowed| needed > allowed) {
                let what = "the numbers of data sets 58".into();
                return Err(Error::Memory {
                    what,
                    needed,
                    allowed,
                });
            }
            self.held = needed;
            ordinates = function::ascii(&function, lines)?;
        }
        if kind.even.is_none() && !kind.is_complex {
            if let Some(order) = function.binary {
                let size = function.sample.bytes();
                let points = lines.bytes[start..].chunks_exact(2 * size).take(kind.count);
                abscissas = points
                    .map(|point| function.sample.to_f64(order, &point[..size]))
                    .collect();
            } else {
                abscissas = ordinates.iter().step_by(2).copied().collect();
                ordinates = ordinates.into_iter().skip(1).step_by(2).collect();
            }
        }
        let row = match function.binary {
            None => Row::Held(ordinates),
            Some(order) => {
                let (sample, step) = (function.sample, function.sample.bytes() * kind.per_point());
                Row::Binary(Binary {
                    // Behind the abscissa, if each point has one.
                    start: start + step - sample.bytes(),
                    step,
                    sample,
                    order,
                })
            }
        };
        let mut hasher = DefaultHasher::new();
        kind.hash(&mut hasher);
        abscissas.iter().for_each(|&x| bits(x).hash(&mut hasher));
        let places = self.places.entry(hasher.finish()).or_default();
        let equal =
            |a: &[f64], b: &[f64]| a.iter().copied().map(bits).eq(b.iter().copied().map(bits));
        let groups = &self.groups;
        let is_same = |&place: &usize| {
            groups[place].kind == kind && equal(&groups[place].abscissas, &abscissas)
        };
        if let Some(place) = places.iter().copied().find(is_same) {
            let group = &mut self.groups[place];
            group.functions.push(function);
            group.numbers.push(self.functions);
            group.rows.push(row);
        } else {
            places.push(self.groups.len());
            self.groups.push(Group {
                kind,
                functions: vec![function],
                numbers: vec![self.functions],
                rows: vec![row],
                abscissas,
            });
        }
        Ok(())
    }

    /// Nodes of one line (data set 15) or of two (2411).
    fn nodes(&mut self, lines: &mut Lines, has_two_lines: bool) -> Result<()> {
        loop {
            let mut at = lines.at;
            let mut line = lines.expect("the end of the nodes")?;
            if is_delimiter(line) {
                return Ok(());
            }
            let node = integer(line, 0, 10, at)?;
            let (from, width) = if has_two_lines { (0, 25) } else { (40, 13) };
            if has_two_lines {
                at = lines.at;
                line = lines.expect("the coordinates of a node")?;
            }
            let mut position = [0.0; 3];
            for (i, value) in position.iter_mut().enumerate() {
                *value = float(line, from + i * width, from + (i + 1) * width, at)?;
            }
            self.nodes.insert(node, position);
        }
    }
}

/// Adds the variables of a group.
fn add(
    group: Group,
    nodes: &HashMap<i64, [f64; 3]>,
    suffix: &str,
    variables: &mut Vec<Variable>,
    sources: &mut Vec<Source>,
) {
    let kind = &group.kind;
    let records = group.functions.len() as u64;
    let first = &group.functions[0];
    let mut attributes = Attributes::default();
    attributes.insert_text("long_name", first.name.clone());
    attributes.insert_text("ordinate", first.label.clone());
    if kind.denominator_unit.is_empty() {
        attributes.insert_text("units", kind.ordinate_unit.clone());
    } else {
        attributes.insert_text("numerator_units", kind.ordinate_unit.clone());
        attributes.insert_text("denominator_units", kind.denominator_unit.clone());
    }
    attributes.insert("function_type", Value::Integers(vec![kind.function]));

    let mut listed: Vec<(&str, Vec<f64>)> = Vec::new();
    let mut per_record = |name: &'static str, of: fn(&Function) -> i64| {
        let values: Vec<i64> = group.functions.iter().map(of).collect();
        if values.iter().all(|&value| value == values[0]) {
            attributes.insert(name, Value::Integers(vec![values[0]]));
        } else {
            listed.push((name, values.into_iter().map(|value| value as f64).collect()));
        }
    };
    per_record("response_node", |function| function.response[0]);
    per_record("response_direction", |function| function.response[1]);
    per_record("reference_node", |function| function.reference[0]);
    per_record("reference_direction", |function| function.reference[1]);

    let positions: Vec<[f64; 3]> = group
        .functions
        .iter()
        .map(|function| {
            nodes
                .get(&function.response[0])
                .copied()
                .unwrap_or([f64::NAN; 3])
        })
        .collect();
    let mut coordinate = None;
    if positions.iter().any(|position| !position[0].is_nan()) {
        let axes = ["x", "y", "z"];
        let along = |axis: usize| positions.iter().map(move |position| position[axis]);
        let varies = |&axis: &usize| along(axis).any(|value| value != positions[0][axis]);
        let varying: Vec<usize> = (0..3).filter(varies).collect();
        if let [axis] = varying[..]
            && along(axis).is_sorted_by(|a, b| a < b)
        {
            coordinate = Some(listed.len() + axis);
        }
        listed.extend((0..3).map(|axis| (axes[axis], along(axis).collect())));
    }

    let at = variables.len();
    let unit = match (kind.abscissa_unit.as_str(), kind.abscissa_type) {
        ("", 17) => Some("s".to_owned()),
        ("", 18) => Some("Hz".to_owned()),
        ("", _) => None,
        (unit, _) => Some(unit.to_owned()),
    };
    let name = if kind.function == 1 && kind.abscissa_type == 17 {
        "time"
    } else {
        "abscissa"
    };
    let record = Dimension::new(records).named("record");
    let abscissa = Dimension::new(kind.count as u64).named(name);
    let abscissa_at = at + 1 + listed.len();
    let abscissa_coordinate = match kind.even {
        Some([origin, step]) => Some(Coordinate::Even {
            origin,
            step,
            unit: unit.clone(),
        }),
        None => (!kind.is_complex).then_some(Coordinate::Listed(abscissa_at)),
    };
    let (sample, place, source) = ordinates(kind, group.rows);
    variables.push(Variable {
        path: format!("/records{suffix}"),
        dimensions: vec![
            Dimension {
                coordinate: coordinate.map(|field| Coordinate::Listed(at + 1 + field)),
                ..record.clone()
            },
            Dimension {
                coordinate: abscissa_coordinate,
                ..abscissa.clone()
            },
        ],
        sample_type: if kind.is_complex {
            SampleType::Other("complex numbers".into())
        } else {
            SampleType::Number(sample)
        },
        attributes,
        place,
    });
    sources.push(source);
    let mut list = |name: &str, dimension: Dimension, unit: Option<String>, values: Vec<f64>| {
        let mut attributes = Attributes::default();
        attributes.insert_text("units", unit.unwrap_or_default());
        variables.push(Variable {
            path: format!("/{name}{suffix}"),
            place: Place::Encoded {
                rows: dimension.len,
            },
            dimensions: vec![dimension],
            sample_type: SampleType::Number(Sample::F64),
            attributes,
        });
        sources.push(Source::Held(values));
    };
    for (name, values) in listed {
        list(name, record.clone(), None, values);
    }
    if kind.even.is_none() && !kind.is_complex {
        list("abscissa", abscissa, unit, group.abscissas);
    }
}

/// Where the ordinates of a group are, and of which type.
fn ordinates(kind: &Kind, rows: Vec<Row>) -> (Sample, Place, Source) {
    let types = rows.iter().map(|row| match row {
        Row::Held(_) => Sample::F64,
        Row::Binary(binary) => binary.sample,
    });
    let first = types.clone().next().unwrap_or(Sample::F64);
    let is_one = types.clone().all(|sample| sample == first);
    let sample = if is_one { first } else { Sample::F64 };
    let binary = rows.iter().map(|row| match row {
        Row::Binary(binary) => Some(binary),
        Row::Held(_) => None,
    });
    let binary = binary.collect::<Option<Vec<_>>>().unwrap_or_default();
    let place = match binary[..] {
        [first, ..] if !kind.is_complex => {
            let second = binary.get(1).map(|second| second.start - first.start);
            let stride = second.unwrap_or(kind.count * first.step);
            let is_next = |pair: &[&Binary]| {
                pair[1].start - pair[0].start == stride
                    && (pair[1].sample, pair[1].order) == (first.sample, first.order)
            };
            binary.windows(2).all(is_next).then(|| Place::Strided {
                start: first.start as u64,
                strides: vec![stride as u64, first.step as u64],
                order: first.order,
            })
        }
        _ => None,
    };
    let place = place.unwrap_or(Place::Encoded { rows: 1 });
    (sample, place, Source::Rows(rows, sample))
}

/// Where the samples of a variable come from.
enum Source {
    /// All of them, along one dimension.
    Held(Vec<f64>),
    /// Ordinates as numbers of this type.
    Rows(Vec<Row>, Sample),
}

/// The ordinates of a function.
enum Row {
    Held(Vec<f64>),
    Binary(Binary),
}

/// Numbers of a binary data set.
struct Binary {
    start: usize,
    step: usize,
    sample: Sample,
    order: ByteOrder,
}

struct UffDecoder {
    bytes: Bytes,
    sources: Vec<Source>,
}

impl Decoder for UffDecoder {
    fn read(&self, variable: usize, block: Block, out: &mut [u8]) -> Result<()> {
        let bytes = (*self.bytes).as_ref();
        let put = |out: &mut [u8], values: &[f64]| {
            for (one, value) in out.chunks_exact_mut(8).zip(values) {
                one.copy_from_slice(&value.to_ne_bytes());
            }
        };
        let range = |d: usize| block[d].start as usize..block[d].end as usize;
        let (rows, wanted) = match &self.sources[variable] {
            Source::Held(values) => {
                put(out, &values[range(0)]);
                return Ok(());
            }
            Source::Rows(rows, wanted) => (&rows[range(0)], *wanted),
        };
        let columns = range(1);
        let size = wanted.bytes();
        for (row, out) in rows.iter().zip(out.chunks_exact_mut(columns.len() * size)) {
            let binary = match row {
                Row::Held(values) => {
                    put(out, &values[columns.clone()]);
                    continue;
                }
                Row::Binary(binary) => binary,
            };
            for (one, i) in out.chunks_exact_mut(size).zip(columns.clone()) {
                let stored = &bytes[binary.start + i * binary.step..][..binary.sample.bytes()];
                if binary.sample != wanted {
                    let number = binary.sample.to_f64(binary.order, stored);
                    one.copy_from_slice(&number.to_ne_bytes());
                    continue;
                }
                one.copy_from_slice(stored);
                if binary.order != ByteOrder::NATIVE {
                    one.reverse();
                }
            }
        }
        Ok(())
    }
}
