//! Text dumps of LAMMPS: columns of numbers for each atom, frame by frame.

mod scan;
mod text;
mod units;

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::container::{Block, Decoder};
use crate::cursor::Budget;
use crate::{
    Bytes, Container, Coordinate, Dimension, Error, Format, Options, Remark, Result, Sample,
    SampleType, Value, Variable,
};
use scan::{Cell, Frame, Headers, OTHER_ATOMS};
use text::{float, id, is_blank, lines, pick, values, wrong};

/// Share of the largest extent below which atoms lie in a row.
const IN_A_ROW: f64 = 1e-6;

/// The format of these bytes, if it is the one of this module.
pub(crate) fn detect(bytes: &[u8]) -> Option<Format> {
    bytes.starts_with(b"ITEM: ").then_some(Format::Lammps)
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let mut container = Container::new(format, &bytes);
    let headers = scan::headers((*bytes).as_ref(), options)?;
    let first = First::read((*bytes).as_ref(), &headers, options)?;
    let style = headers.style.clone().unwrap_or_default();
    let units = units::of_style(&style);
    let attributes = &mut container.attributes;
    attributes.insert_text("lammps_units", style);
    attributes.insert_text("boundary", &*headers.boundary);
    let bounds = headers.bounds.concat();
    if !bounds.is_empty() {
        attributes.insert("box_bounds", Value::Numbers(bounds));
    }
    container.remarks.extend(first.wrapped(&headers));
    let dump = Arc::new(Dump {
        bytes,
        headers,
        first,
    });
    if let Some(last) = dump.headers.frames.last() {
        // The frame that a run did not finish.
        dump.each(last, [dump.first.id_column], |_, _| Ok(()))?;
    }
    list(&dump, units, &mut container);
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
        Budget::new("the order of the atoms", options).take(needed)?;
        let axes = [0, 1, 2].map(|axis| Axis::find(axis, headers));
        let mut numbers = Vec::new();
        let mut ids = Vec::new();
        let mut positions = [0, 1, 2].map(|_| Vec::new());
        let mut is_text = vec![false; columns.len()];
        for row in lines(&bytes[frame.rows.clone()]).filter(|row| !is_blank(row)) {
            let found = values(row).count();
            if ids.len() == atoms || found != columns.len() {
                return Err(not_a_row(frame, headers, found));
            }
            numbers.clear();
            for (column, value) in values(row).enumerate() {
                if column == id_column {
                    ids.push(id(value, frame)?);
                }
                let number = float(value);
                is_text[column] |= number.is_none();
                numbers.push(number.unwrap_or(f64::NAN));
            }
            for (axis, positions) in axes.iter().zip(&mut positions) {
                let cell = frame.cell.as_deref();
                positions.extend(axis.iter().map(|axis| axis.position(&numbers, cell)));
            }
        }
        if ids.len() != atoms {
            return Err(frame.damaged(format!("{atoms} atoms"), ids.len()));
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
            return Err(frame.damaged("every atom once", format!("atom {} twice", pair[0].0)));
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
        let steps = places.windows(2).map(|pair| pair[1] - pair[0]);
        let (longest, letter) = (steps.fold(0.0, f64::max), LETTERS[axis]);
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
        let is_it = |at: &usize| self.by_id.get(*at).is_some_and(|(found, _)| *found == id);
        let search = || self.by_id.binary_search_by_key(&id, |(id, _)| *id).ok();
        let at = Some(guess).filter(is_it).or_else(search)?;
        Some(self.by_id[at].1)
    }
}

const LETTERS: [&str; 3] = ["x", "y", "z"];

/// The columns of a position along one axis.
#[derive(Debug, Clone)]
struct Axis {
    axis: usize,
    column: usize,
    /// Lower bound and length of the box, if positions are shares of it.
    scale: Option<[f64; 2]>,
    /// What unwraps positions within the box: the columns `ix`, `iy` and `iz`, which count how often each atom has
    /// crossed the boundaries.
    images: Option<[Option<usize>; 3]>,
    /// Whether atoms that crossed a boundary are still beside their neighbours.
    is_unwrapped: bool,
}

impl Axis {
    /// Unwrapped positions first: an atom that left a periodic box is still beside its neighbours.
    fn find(axis: usize, headers: &Headers) -> Option<Axis> {
        let find = |suffix: &str| headers.column(&format!("{}{suffix}", LETTERS[axis]));
        let cell = headers.frames.first().and_then(|frame| frame.cell.as_ref());
        let counts = LETTERS.map(|letter| headers.column(&format!("i{letter}")));
        let has_images = cell.is_some() && counts[axis].is_some();
        let stored = |suffix: &str| {
            let is_unwrapped = suffix.ends_with('u');
            Some(Axis {
                axis,
                column: find(suffix)?,
                scale: None,
                is_unwrapped: is_unwrapped || has_images,
                images: (has_images && !is_unwrapped).then_some(counts),
            })
        };
        // Shares of a tilted box mix the axes.
        let scale = || match headers.bounds.get(axis)?[..] {
            [low, high] => Some(Some([low, high - low])),
            _ => None,
        };
        let shares = || {
            let shares = stored("su").or_else(|| stored("s"))?;
            let scale = scale()?;
            Some(Axis { scale, ..shares })
        };
        stored("u").or_else(|| stored("")).or_else(shares)
    }

    /// The position in a row of `numbers`.
    fn position(&self, numbers: &[f64], cell: Option<&Cell>) -> f64 {
        let value = numbers[self.column];
        let within = match self.scale {
            None => value,
            Some([low, length]) => low + value * length,
        };
        let images = self.images.unwrap_or_default();
        let edges = cell.into_iter().flatten().zip(images);
        let along = edges.map(|(edge, column)| match column {
            Some(column) if edge[self.axis] != 0.0 => numbers[column] * edge[self.axis],
            _ => 0.0,
        });
        within + (0.0 + along.sum::<f64>())
    }
}

/// The direction along which atoms lie in a row, one after the other.
fn row(positions: &[Vec<f64>; 3]) -> Option<usize> {
    let extents = positions.each_ref().map(|along| {
        let end = |of: fn(f64, f64) -> f64| along.iter().copied().reduce(of).unwrap_or(0.0);
        end(f64::max) - end(f64::min)
    });
    let largest = extents.into_iter().fold(0.0, f64::max);
    let varies = |&axis: &usize| extents[axis] > IN_A_ROW * largest;
    let varying: Vec<usize> = (0..3).filter(varies).collect();
    let [axis] = varying[..] else { return None };
    let mut sorted = positions[axis].clone();
    sorted.sort_by(f64::total_cmp);
    let rises = sorted.is_sorted_by(|a, b| a < b) && sorted.iter().all(|x| x.is_finite());
    rises.then_some(axis)
}

/// Adds all variables.
fn list(dump: &Arc<Dump>, units: [&'static str; 4], container: &mut Container) {
    let (headers, first) = (&dump.headers, &dump.first);
    let unwrapped = (0..3).filter(|&axis| first.unwraps(axis));
    // The lists follow the columns.
    let lists = headers.columns.len() - 1 + unwrapped.clone().count();
    let id_at = lists + 1 + usize::from(headers.has_times);
    let mut time = Dimension::new(headers.frames.len() as u64).named("time");
    time.coordinate = Some(Coordinate::Listed(id_at - 1));
    let mut atom = Dimension::new(headers.atoms as u64).named("atom");
    atom.coordinate = first.row.map(|axis| {
        let before = first.positions[..axis].iter().flatten().count();
        Coordinate::Listed(id_at + 1 + before)
    });
    let stored = headers.columns.iter().enumerate();
    let stored = stored.filter(|(column, _)| *column != first.id_column);
    let stored = stored.map(|(column, name)| (name.clone(), Source::Column(column)));
    let unwrapped = unwrapped.map(|axis| (format!("{}u", LETTERS[axis]), Source::Unwrapped(axis)));
    for (name, source) in stored.chain(unwrapped) {
        let [unit, quantity] = units::of_column(units, &name);
        let dimensions = vec![time.clone(), atom.clone()];
        let mut variable = Variable::new(format!("/{name}"), dimensions, Sample::F64);
        let attributes = &mut variable.attributes;
        attributes.insert_text("units", unit);
        attributes.insert_text("standard_name", quantity);
        match source {
            Source::Column(column) if first.is_text[column] => {
                variable.sample_type = SampleType::Other("text".into());
            }
            Source::Column(_) => {}
            Source::Unwrapped(_) => {
                attributes.insert_text("long_name", "position, unwrapped by the image flags");
            }
        }
        let dump = Arc::clone(dump);
        container.push_decoded(variable, Column { dump, source });
    }
    let variable = |path: &str, dimension: &Dimension, sample, [name, unit]: [&str; 2]| {
        let mut variable = Variable::new(path, vec![dimension.clone()], sample);
        variable.attributes.insert_text("long_name", name);
        variable.attributes.insert_text("units", unit);
        variable
    };
    let step = variable("/step", &time, Sample::I64, ["time step", ""]);
    let frames = || headers.frames.iter();
    container.push_list(step, frames().map(|frame| frame.step.to_ne_bytes()));
    if headers.has_times {
        let times = variable("/time", &time, Sample::F64, ["time", units[1]]);
        container.push_list(times, frames().map(|frame| frame.time.to_ne_bytes()));
    }
    let ids = variable("/id", &atom, Sample::I64, ["id of the atom", ""]);
    container.push_list(ids, first.ids.iter().map(|id| id.to_ne_bytes()));
    for (letter, along) in LETTERS.iter().zip(&first.positions) {
        let texts = ["position in the first frame", units[0]];
        if let Some(along) = along {
            let list = variable(&format!("/first/{letter}"), &atom, Sample::F64, texts);
            container.push_list(list, along.iter().map(|x| x.to_ne_bytes()));
        }
    }
}

struct Dump {
    bytes: Bytes,
    headers: Headers,
    first: First,
}

/// Where the samples of a variable come from.
#[derive(Clone, Copy)]
enum Source {
    Column(usize),
    /// The position along an axis, unwrapped by image flags.
    Unwrapped(usize),
}

/// A number of each atom in each frame.
struct Column {
    dump: Arc<Dump>,
    source: Source,
}

impl Decoder for Column {
    fn read(&self, block: Block, out: &mut [u8]) -> Result<()> {
        let range = |d: usize| block[d].start as usize..block[d].end as usize;
        let atoms = range(1);
        let frames = &self.dump.headers.frames[range(0)];
        let rows = out.par_chunks_mut(8 * atoms.len()).zip(frames);
        let decoded = rows.map(|(out, frame)| self.frame(frame, atoms.clone(), out));
        decoded.find_first(Result::is_err).unwrap_or(Ok(()))
    }
}

impl Column {
    /// Copies the numbers of `atoms` of a frame.
    fn frame(&self, frame: &Frame, atoms: Range<usize>, out: &mut [u8]) -> Result<()> {
        let number = |value: &[u8]| float(value).ok_or_else(|| wrong(value, frame, "a number"));
        let mut put = |atom: usize, number: f64| {
            if atoms.contains(&atom) {
                let at = 8 * (atom - atoms.start);
                out[at..at + 8].copy_from_slice(&number.to_ne_bytes());
            }
        };
        let axis = match self.source {
            Source::Column(column) => {
                return self.dump.each(frame, [column], |atom, [value]| {
                    put(atom, number(value)?);
                    Ok(())
                });
            }
            Source::Unwrapped(axis) => self.dump.first.axes[axis].as_ref(),
        };
        let Some((axis, images)) = axis.and_then(|axis| Some((axis, axis.images?))) else {
            return Ok(());
        };
        let flags = images.map(|column| column.unwrap_or(axis.column));
        let columns = [axis.column, flags[0], flags[1], flags[2]];
        let mut row = vec![0.0; self.dump.headers.columns.len()];
        self.dump.each(frame, columns, |atom, values| {
            for (column, value) in columns.into_iter().zip(values) {
                row[column] = number(value)?;
            }
            put(atom, axis.position(&row, frame.cell.as_deref()));
            Ok(())
        })
    }
}

impl Dump {
    /// Calls `take` with the place of every atom of a frame and its values in `columns`.
    fn each<const N: usize>(
        &self,
        frame: &Frame,
        columns: [usize; N],
        mut take: impl FnMut(usize, [&[u8]; N]) -> Result<()>,
    ) -> Result<()> {
        let bytes = &(*self.bytes).as_ref()[frame.rows.clone()];
        let (all, atoms) = (self.headers.columns.len(), self.headers.atoms);
        let mut is_found = vec![false; atoms];
        let mut found = 0;
        for row in lines(bytes).filter(|row| !is_blank(row)) {
            let (name, picked) = pick(row, all, self.first.id_column, columns)
                .map_err(|found| not_a_row(frame, &self.headers, found))?;
            let id = id(name, frame)?;
            let atom = self.first.place(id).ok_or_else(|| {
                let frame = format!("the frame of time step {}", frame.step);
                let what = format!("{frame} with the atom {id}, which the first lacks");
                Error::unsupported(what, OTHER_ATOMS)
            })?;
            if std::mem::replace(&mut is_found[atom], true) {
                return Err(frame.damaged("every atom once", format!("atom {id} twice")));
            }
            found += 1;
            take(atom, picked)?;
        }
        match found == atoms {
            true => Ok(()),
            false => Err(frame.damaged(format!("{atoms} atoms"), found)),
        }
    }
}

fn not_a_row(frame: &Frame, headers: &Headers, found: usize) -> Error {
    let expected = format!("{} rows of {} values", headers.atoms, headers.columns.len());
    frame.damaged(expected, format!("another row, of {found} values"))
}
