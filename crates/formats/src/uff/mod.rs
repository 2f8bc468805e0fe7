//! Universal files: functions at nodes (data sets 58 and 58b), coordinates of nodes (15 and 2411).

mod function;
mod text;

use std::collections::hash_map::DefaultHasher;
use std::collections::{HashMap, HashSet};
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use crate::{
    Attributes, Block, Bytes, Container, Coordinate, Decoder, Dimension, Error, Format, Options,
    Place, Result, Sample, SampleType, Value, Variable,
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
    /// Bytes where binary numbers begin.
    starts: Vec<usize>,
    /// Ordinates in ASCII.
    ordinates: Vec<f64>,
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
    for (number, group) in contents.groups.into_iter().enumerate() {
        let suffix = if is_single {
            String::new()
        } else {
            format!("/{}", number + 1)
        };
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
    if !contents.skipped.is_empty() {
        container
            .attributes
            .insert("skipped", Value::Texts(contents.skipped));
    }
    Ok(container)
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
        if kind.binary.is_some() {
            start = function::skip_binary(&kind, lines)?;
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
            if let Some(order) = kind.binary {
                let size = kind.sample.bytes();
                let points = lines.bytes[start..].chunks_exact(2 * size).take(kind.count);
                abscissas = points
                    .map(|point| kind.sample.to_f64(order, &point[..size]))
                    .collect();
            } else {
                abscissas = ordinates.iter().step_by(2).copied().collect();
                ordinates = ordinates.into_iter().skip(1).step_by(2).collect();
            }
        }
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
            group.starts.push(start);
            group.ordinates.extend(ordinates);
        } else {
            places.push(self.groups.len());
            self.groups.push(Group {
                kind,
                functions: vec![function],
                starts: vec![start],
                ordinates,
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
    attributes.insert_text("ordinate", kind.ordinate_label.clone());
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
    let (place, source) = ordinates(kind, &group.starts, group.ordinates);
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
            SampleType::Number(kind.sample)
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
        sources.push(Source::Held {
            width: values.len(),
            values,
        });
    };
    for (name, values) in listed {
        list(name, record.clone(), None, values);
    }
    if kind.even.is_none() && !kind.is_complex {
        list("abscissa", abscissa, unit, group.abscissas);
    }
}

/// Where the ordinates of a group are.
fn ordinates(kind: &Kind, starts: &[usize], held: Vec<f64>) -> (Place, Source) {
    let encoded = Place::Encoded { rows: 1 };
    let Some(order) = kind.binary.filter(|_| !kind.is_complex) else {
        return (
            encoded,
            Source::Held {
                values: held,
                width: kind.count,
            },
        );
    };
    let size = kind.sample.bytes();
    let step = size * kind.per_point();
    // Behind the abscissa, if each point has one.
    let starts: Vec<usize> = starts.iter().map(|start| start + step - size).collect();
    let stride = starts
        .get(1)
        .map_or(kind.count * step, |second| second - starts[0]);
    if starts.windows(2).all(|pair| pair[1] - pair[0] == stride) {
        let place = Place::Strided {
            start: starts[0] as u64,
            strides: vec![stride as u64, step as u64],
            order,
        };
        return (
            place,
            Source::Held {
                values: Vec::new(),
                width: 0,
            },
        );
    }
    let source = Source::Binary {
        kind: kind.clone(),
        starts,
        step,
    };
    (encoded, source)
}

/// Where the samples of a variable come from.
enum Source {
    /// All of them, in rows of `width`.
    Held { values: Vec<f64>, width: usize },
    /// Ordinates of binary data sets at uneven distances.
    Binary {
        kind: Kind,
        starts: Vec<usize>,
        step: usize,
    },
}

struct UffDecoder {
    bytes: Bytes,
    sources: Vec<Source>,
}

impl Decoder for UffDecoder {
    fn read(&self, variable: usize, block: Block, out: &mut [u8]) -> Result<()> {
        match &self.sources[variable] {
            Source::Held { values, width } => {
                let (rows, columns) = match block {
                    [rows, columns] => (rows.clone(), columns.clone()),
                    _ => (0..1, block[0].clone()),
                };
                let wanted = rows.flat_map(|row| {
                    let row = &values[row as usize * width..][..*width];
                    &row[columns.start as usize..columns.end as usize]
                });
                for (one, value) in out.chunks_exact_mut(8).zip(wanted) {
                    one.copy_from_slice(&value.to_ne_bytes());
                }
            }
            Source::Binary { kind, starts, step } => {
                let bytes = (*self.bytes).as_ref();
                let size = kind.sample.bytes();
                let is_foreign = kind.binary != Some(crate::ByteOrder::NATIVE);
                let rows = block[0].start as usize..block[0].end as usize;
                let wanted = starts[rows].iter().flat_map(|start| {
                    (block[1].start..block[1].end).map(move |i| start + i as usize * step)
                });
                for (one, at) in out.chunks_exact_mut(size).zip(wanted) {
                    one.copy_from_slice(&bytes[at..at + size]);
                    if is_foreign {
                        one.reverse();
                    }
                }
            }
        }
        Ok(())
    }
}
