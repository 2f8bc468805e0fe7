//! Text dumps of LAMMPS: columns of numbers for each atom, frame by frame.

mod scan;
mod text;
mod units;

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::{
    Attributes, Block, Bytes, Container, Coordinate, Decoder, Dimension, Error, Format, Options,
    Place, Remark, Result, Sample, SampleType, Value, Variable,
};
use scan::{Cell, Frame, Headers};
use text::{float, id, is_blank, lines, pick, values, wrong};
use units::Units;

/// Share of the largest extent below which atoms lie in a row.
const IN_A_ROW: f64 = 1e-6;

/// The format of a file with this extension (lower case) and these bytes, if it is one of this module.
pub(crate) fn detect(extension: &str, bytes: &[u8]) -> Option<Format> {
    let begins = bytes.starts_with(b"ITEM: ");
    // What is compressed begins with a control character.
    let is_text = bytes
        .first()
        .is_some_and(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace());
    let is_named = is_text && matches!(extension, "lammpstrj" | "dump");
    (begins || is_named).then_some(Format::Lammps)
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let held = Arc::clone(&bytes);
    let headers = scan::headers((*held).as_ref(), options)?;
    let first = First::read((*held).as_ref(), &headers, options)?;
    let units = Units::of(headers.style.as_deref().unwrap_or_default());
    let mut container_attributes = Attributes::default();
    container_attributes.insert_text("lammps_units", headers.style.clone().unwrap_or_default());
    container_attributes.insert_text("boundary", headers.boundary.clone());
    let bounds = headers.bounds.concat();
    if !bounds.is_empty() {
        container_attributes.insert("box_bounds", Value::Numbers(bounds));
    }
    let remark = first.wrapped(&headers);
    let (variables, sources) = list(&headers, &first, units);
    let decoder = Dump {
        bytes: held,
        columns: headers.columns.len(),
        frames: headers.frames,
        first,
        sources,
    };
    if let Some(last) = decoder.frames.last() {
        // The frame that a run did not finish.
        decoder.each(last, [decoder.first.id_column], |_, _| Ok(()))?;
    }
    let mut container = Container::new(format, bytes, Some(Box::new(decoder)));
    container.attributes = container_attributes;
    container.variables = variables;
    container.remarks.extend(remark);
    Ok(container)
}

/// What the first frame says about all.
struct First {
    /// The column of the ids.
    id_column: usize,
    /// The atoms in their order.
    ids: Vec<i64>,
    /// The atoms by their ids, with their place in the order.
    by_id: Vec<(i64, usize)>,
    /// Columns that hold text.
    is_text: Vec<bool>,
    /// The positions along x, y and z, as far as the dump has them, in the order of the atoms.
    positions: [Option<Vec<f64>>; 3],
    /// The columns of these positions.
    axes: [Option<Axis>; 3],
    /// The direction along which the atoms lie in a row.
    row: Option<usize>,
}

impl First {
    fn read(bytes: &[u8], headers: &Headers, options: &Options) -> Result<First> {
        let columns = &headers.columns;
        let Some(id_column) = columns.iter().position(|column| column == "id") else {
            return Err(Error::unsupported(
                "a LAMMPS dump without the column id, whose atoms cannot be told apart",
                "add `id` to the columns of the dump",
            ));
        };
        let Some(frame) = headers.frames.first() else {
            return Err(Error::damaged("the file", "ITEM: ATOMS", "none"));
        };
        let atoms = headers.atoms;
        let per_atom = size_of::<i64>() + size_of::<(i64, usize)>() + 3 * size_of::<f64>();
        let needed = (atoms as u64).saturating_mul(2 * per_atom as u64);
        if let Some(allowed) = options.memory.filter(|&allowed| needed > allowed) {
            let what = "the order of the atoms".into();
            return Err(Error::Memory {
                what,
                needed,
                allowed,
            });
        }
        let axes = [0, 1, 2].map(|axis| Axis::find(axis, headers));
        let mut numbers = Vec::new();
        let mut ids = Vec::new();
        let mut positions = [0, 1, 2].map(|_| Vec::new());
        let mut is_text = vec![false; columns.len()];
        for row in lines(&bytes[frame.rows.clone()]).filter(|row| !is_blank(row)) {
            let found = values(row).count();
            if ids.len() == atoms || found != columns.len() {
                return Err(not_a_row(frame, atoms, columns.len(), found));
            }
            numbers.clear();
            for (column, value) in values(row).enumerate() {
                if column == id_column {
                    ids.push(id(value, frame.step)?);
                }
                let number = float(value);
                is_text[column] |= number.is_none();
                numbers.push(number.unwrap_or(f64::NAN));
            }
            for (axis, positions) in axes.iter().zip(&mut positions) {
                positions.extend(
                    axis.as_ref()
                        .map(|axis| axis.position(&numbers, frame.cell.as_deref())),
                );
            }
        }
        if ids.len() != atoms {
            return Err(not_all(frame, atoms, ids.len()));
        }
        let row = row(&positions);
        let mut order: Vec<usize> = (0..atoms).collect();
        match row {
            Some(axis) => order.sort_by(|&a, &b| positions[axis][a].total_cmp(&positions[axis][b])),
            None => order.sort_by_key(|&atom| ids[atom]),
        }
        let ids: Vec<i64> = order.iter().map(|&atom| ids[atom]).collect();
        let mut by_id: Vec<(i64, usize)> = ids.iter().copied().zip(0..).collect();
        by_id.sort_unstable();
        if let Some(pair) = by_id.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err(twice(pair[0].0, frame));
        }
        let positions = positions.map(|along| {
            (!along.is_empty()).then(|| order.iter().map(|&atom| along[atom]).collect())
        });
        Ok(First {
            id_column,
            ids,
            by_id,
            is_text,
            positions,
            axes,
            row,
        })
    }

    /// That the row of atoms may begin at another one: it reaches across a periodic boundary, and nothing
    /// says at which atom.
    fn wrapped(&self, headers: &Headers) -> Option<Remark> {
        let axis = self.row?;
        let places = self.positions[axis].as_ref()?;
        // Names of the columns of a tilted box stand before.
        let mut boundaries = headers.boundary.split_ascii_whitespace().rev();
        let is_periodic = boundaries.nth(2 - axis)?.starts_with('p');
        if !is_periodic || self.axes[axis].as_ref()?.is_unwrapped {
            return None;
        }
        let length = headers.frames.first()?.cell.as_ref()?[axis][axis];
        let across = places.first()? + length - places.last()?;
        let longest = places
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .fold(0.0, f64::max);
        let letter = LETTERS[axis];
        (across < 1.5 * longest).then(|| Remark {
            variable: None,
            text: format!(
                "the row of atoms reaches across the periodic boundary along {letter}, and without image \
                 flags (the column `i{letter}` or `{letter}u`) it may begin at another atom than that of \
                 the smallest {letter}"
            ),
        })
    }

    /// Whether image flags give unwrapped positions along an axis, which the dump does not hold.
    fn unwraps(&self, axis: usize) -> bool {
        let axis = self.axes[axis].as_ref();
        axis.is_some_and(|axis| axis.images.is_some())
    }

    /// The place of an atom in the order of the atoms.
    fn place(&self, id: i64) -> Option<usize> {
        let first = self.by_id.first()?.0;
        // Ids mostly count without gaps.
        let guess = usize::try_from(id.checked_sub(first)?).ok()?;
        match self.by_id.get(guess) {
            Some((found, place)) if *found == id => Some(*place),
            _ => {
                let found = self.by_id.binary_search_by_key(&id, |(id, _)| *id);
                found.ok().map(|at| self.by_id[at].1)
            }
        }
    }
}

const LETTERS: [&str; 3] = ["x", "y", "z"];

/// The columns of a position along one axis.
#[derive(Debug, Clone)]
struct Axis {
    column: usize,
    /// Lower bound and length of the box, if positions are shares of it.
    scale: Option<[f64; 2]>,
    /// What unwraps positions within the box.
    images: Option<Images>,
    /// Whether atoms that crossed a boundary are still beside their neighbours.
    is_unwrapped: bool,
}

/// How often each atom has crossed the boundaries of the box.
#[derive(Debug, Clone)]
struct Images {
    axis: usize,
    /// The columns `ix`, `iy` and `iz`.
    columns: [Option<usize>; 3],
}

impl Images {
    fn find(axis: usize, headers: &Headers) -> Option<Images> {
        let column = |letter| headers.column(&format!("i{letter}"));
        let columns = LETTERS.map(column);
        columns[axis].is_some().then_some(Images { axis, columns })
    }

    /// What is added to a position within the box `cell` of an atom with such counts.
    fn shift(&self, count: impl Fn(usize) -> f64, cell: Option<&Cell>) -> f64 {
        let edges = cell.into_iter().flatten().zip(self.columns);
        let along = edges.map(|(edge, column)| match column {
            Some(column) if edge[self.axis] != 0.0 => count(column) * edge[self.axis],
            _ => 0.0,
        });
        along.sum()
    }
}

impl Axis {
    /// Unwrapped positions first: an atom that left a periodic box is still beside its neighbours.
    fn find(axis: usize, headers: &Headers) -> Option<Axis> {
        let find = |suffix: &str| headers.column(&format!("{}{suffix}", LETTERS[axis]));
        let has_box = headers
            .frames
            .first()
            .is_some_and(|frame| frame.cell.is_some());
        let images = || Images::find(axis, headers).filter(|_| has_box);
        let stored = |suffix: &str| {
            let images = match suffix {
                "u" | "su" => None,
                _ => images(),
            };
            Some(Axis {
                column: find(suffix)?,
                scale: None,
                is_unwrapped: suffix.ends_with('u') || images.is_some(),
                images,
            })
        };
        if let Some(axis) = stored("u").or_else(|| stored("")) {
            return Some(axis);
        }
        // Shares of a tilted box mix the axes.
        let [low, high] = headers.bounds.get(axis)?[..] else {
            return None;
        };
        let scale = Some([low, high - low]);
        let shares = stored("su").or_else(|| stored("s"))?;
        Some(Axis { scale, ..shares })
    }

    /// The position in a row of `numbers`.
    fn position(&self, numbers: &[f64], cell: Option<&Cell>) -> f64 {
        let value = numbers[self.column];
        let within = match self.scale {
            None => value,
            Some([low, length]) => low + value * length,
        };
        let images = self.images.as_ref();
        within + images.map_or(0.0, |images| images.shift(|column| numbers[column], cell))
    }
}

/// The direction along which atoms lie in a row, one after the other.
fn row(positions: &[Vec<f64>; 3]) -> Option<usize> {
    let extents = positions.each_ref().map(|along| {
        let low = along.iter().copied().fold(f64::INFINITY, f64::min);
        let high = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if along.is_empty() { 0.0 } else { high - low }
    });
    let largest = extents.iter().copied().fold(0.0, f64::max);
    let varies = |&axis: &usize| extents[axis] > IN_A_ROW * largest;
    let varying: Vec<usize> = (0..3).filter(varies).collect();
    let [axis] = varying[..] else { return None };
    let mut sorted = positions[axis].clone();
    sorted.sort_by(f64::total_cmp);
    let rises = sorted.is_sorted_by(|a, b| a < b) && sorted.iter().all(|x| x.is_finite());
    rises.then_some(axis)
}

/// Where the samples of a variable come from.
#[derive(Clone, Copy)]
enum Source {
    Column(usize),
    /// The position along an axis, unwrapped by image flags.
    Unwrapped(usize),
    Steps,
    Times,
    Ids,
    Position(usize),
}

/// All variables, and where their samples come from.
fn list(headers: &Headers, first: &First, units: Units) -> (Vec<Variable>, Vec<Source>) {
    let mut listed: Vec<(Variable, Source)> = Vec::new();
    let columns = headers.columns.len() - 1 + (0..3).filter(|&axis| first.unwraps(axis)).count();
    let (step_at, time_at, id_at) = (
        columns,
        columns + 1,
        columns + 1 + usize::from(headers.has_times),
    );
    let present = |axis: usize| first.positions[..axis].iter().flatten().count();
    let time = Dimension::new(headers.frames.len() as u64)
        .named("time")
        .at(Coordinate::Listed(if headers.has_times {
            time_at
        } else {
            step_at
        }));
    let mut atom = Dimension::new(headers.atoms as u64).named("atom");
    if let Some(axis) = first.row {
        atom = atom.at(Coordinate::Listed(id_at + 1 + present(axis)));
    }
    let stored = headers.columns.iter().enumerate();
    let stored = stored.filter(|(column, _)| *column != first.id_column);
    let stored =
        stored.map(|(column, name)| (name.clone(), first.is_text[column], Source::Column(column)));
    let unwrapped = (0..3).filter(|&axis| first.unwraps(axis));
    let unwrapped = unwrapped.map(|axis| {
        (
            format!("{}u", LETTERS[axis]),
            false,
            Source::Unwrapped(axis),
        )
    });
    for (name, is_text, source) in stored.chain(unwrapped) {
        let (unit, quantity) = units.of_column(&name);
        let mut attributes = Attributes::default();
        attributes.insert_text("units", unit);
        attributes.insert_text("standard_name", quantity);
        if matches!(source, Source::Unwrapped(_)) {
            attributes.insert_text("long_name", "position, unwrapped by the image flags");
        }
        let variable = Variable {
            path: format!("/{name}"),
            dimensions: vec![time.clone(), atom.clone()],
            sample_type: match is_text {
                true => SampleType::Other("text".into()),
                false => SampleType::Number(Sample::F64),
            },
            attributes,
            place: Place::Encoded { rows: 1 },
        };
        listed.push((variable, source));
    }
    let mut add = |path: &str, dimension: &Dimension, sample, [name, unit]: [&str; 2], source| {
        let mut attributes = Attributes::default();
        attributes.insert_text("long_name", name);
        attributes.insert_text("units", unit);
        let variable = Variable {
            path: path.to_owned(),
            dimensions: vec![dimension.clone()],
            sample_type: SampleType::Number(sample),
            attributes,
            place: Place::Encoded {
                rows: dimension.len,
            },
        };
        listed.push((variable, source));
    };
    add(
        "/step",
        &time,
        Sample::I64,
        ["time step", ""],
        Source::Steps,
    );
    if headers.has_times {
        add(
            "/time",
            &time,
            Sample::F64,
            ["time", units.time],
            Source::Times,
        );
    }
    add(
        "/id",
        &atom,
        Sample::I64,
        ["id of the atom", ""],
        Source::Ids,
    );
    for (axis, letter) in LETTERS.iter().enumerate() {
        if first.positions[axis].is_some() {
            let path = format!("/first/{letter}");
            let texts = ["position in the first frame", units.length];
            add(&path, &atom, Sample::F64, texts, Source::Position(axis));
        }
    }
    listed.into_iter().unzip()
}

struct Dump {
    bytes: Bytes,
    /// Values of a row.
    columns: usize,
    frames: Vec<Frame>,
    first: First,
    sources: Vec<Source>,
}

impl Decoder for Dump {
    fn read(&self, variable: usize, block: Block, out: &mut [u8]) -> Result<()> {
        let range = |d: usize| block[d].start as usize..block[d].end as usize;
        match self.sources[variable] {
            Source::Column(_) | Source::Unwrapped(_) => {
                let source = self.sources[variable];
                let atoms = range(1);
                let rows = out.par_chunks_mut(8 * atoms.len());
                let decoded = rows
                    .zip(&self.frames[range(0)])
                    .map(|(out, frame)| self.frame(frame, source, atoms.clone(), out));
                decoded.find_first(Result::is_err).unwrap_or(Ok(()))
            }
            Source::Steps => {
                let frames = self.frames[range(0)].iter();
                put(out, frames.map(|frame| frame.step.to_ne_bytes()))
            }
            Source::Times => {
                let frames = self.frames[range(0)].iter();
                put(out, frames.map(|frame| frame.time.to_ne_bytes()))
            }
            Source::Ids => put(
                out,
                self.first.ids[range(0)].iter().map(|id| id.to_ne_bytes()),
            ),
            Source::Position(axis) => {
                let along = self.first.positions[axis].as_deref().unwrap_or_default();
                put(out, along[range(0)].iter().map(|value| value.to_ne_bytes()))
            }
        }
    }
}

fn put(out: &mut [u8], values: impl Iterator<Item = [u8; 8]>) -> Result<()> {
    for (one, value) in out.chunks_exact_mut(8).zip(values) {
        one.copy_from_slice(&value);
    }
    Ok(())
}

impl Dump {
    /// Copies a column of `atoms` of a frame, or their unwrapped positions.
    fn frame(
        &self,
        frame: &Frame,
        source: Source,
        atoms: Range<usize>,
        out: &mut [u8],
    ) -> Result<()> {
        let number =
            |value: &[u8]| float(value).ok_or_else(|| wrong(value, frame.step, "a number"));
        let mut put = |atom: usize, number: f64| {
            if atoms.contains(&atom) {
                let at = 8 * (atom - atoms.start);
                out[at..at + 8].copy_from_slice(&number.to_ne_bytes());
            }
        };
        let unwrapped = match source {
            Source::Unwrapped(axis) => self.first.axes[axis].as_ref(),
            _ => None,
        };
        match (
            source,
            unwrapped.and_then(|axis| Some((axis, axis.images.as_ref()?))),
        ) {
            (_, Some((axis, images))) => {
                let flags = images.columns.map(|column| column.unwrap_or(axis.column));
                let columns = [axis.column, flags[0], flags[1], flags[2]];
                let mut row = vec![0.0; self.columns];
                self.each(frame, columns, |atom, values| {
                    for (column, value) in columns.into_iter().zip(values) {
                        row[column] = number(value)?;
                    }
                    put(atom, axis.position(&row, frame.cell.as_deref()));
                    Ok(())
                })
            }
            (Source::Column(column), None) => self.each(frame, [column], |atom, [value]| {
                put(atom, number(value)?);
                Ok(())
            }),
            _ => Ok(()),
        }
    }

    /// Calls `take` with the place of every atom of a frame and its values in `columns`.
    fn each<const N: usize>(
        &self,
        frame: &Frame,
        columns: [usize; N],
        mut take: impl FnMut(usize, [&[u8]; N]) -> Result<()>,
    ) -> Result<()> {
        let bytes = &(*self.bytes).as_ref()[frame.rows.clone()];
        let atoms = self.first.ids.len();
        let mut is_found = vec![false; atoms];
        let mut found = 0;
        for row in lines(bytes).filter(|row| !is_blank(row)) {
            let (name, picked) = pick(row, self.columns, self.first.id_column, columns)
                .map_err(|found| not_a_row(frame, atoms, self.columns, found))?;
            let id = id(name, frame.step)?;
            let Some(atom) = self.first.place(id) else {
                return Err(Error::unsupported(
                    format!(
                        "the frame of time step {} with the atom {id}, which the first lacks",
                        frame.step
                    ),
                    "dump a group whose atoms do not change, or the frames apart",
                ));
            };
            if std::mem::replace(&mut is_found[atom], true) {
                return Err(twice(id, frame));
            }
            found += 1;
            take(atom, picked)?;
        }
        match found == atoms {
            true => Ok(()),
            false => Err(not_all(frame, atoms, found)),
        }
    }
}

fn not_a_row(frame: &Frame, atoms: usize, columns: usize, found: usize) -> Error {
    Error::damaged(
        format!("the frame of time step {}", frame.step),
        format!("{atoms} rows of {columns} values"),
        format!("another row, of {found} values"),
    )
}

fn not_all(frame: &Frame, atoms: usize, found: usize) -> Error {
    Error::damaged(
        format!("the frame of time step {}", frame.step),
        format!("{atoms} atoms"),
        format!("{found}"),
    )
}

fn twice(id: i64, frame: &Frame) -> Error {
    Error::damaged(
        format!("the frame of time step {}", frame.step),
        "every atom once",
        format!("atom {id} twice"),
    )
}
