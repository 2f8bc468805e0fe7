//! Fields in files of named arrays with dimensions and coordinates: HDF5, NetCDF, MATLAB, SEG-Y, TDMS
//! and others.
//!
//! `choose` decides which variable is the field and which of its dimensions are times and sites, `axes`
//! what their coordinates say, `load` where the samples are, `delays` what becomes of traces that begin at
//! different times.

mod axes;
mod choose;
mod delays;
mod load;
mod packing;

use std::ops::Range;
use std::sync::Arc;

use wavecascade_formats::{
    Attributes, Container, Dimension, Format, Options, Place, Remark, Value, Variable,
};

use super::coordinates::{Coordinates, Listed};
use super::file_bytes::FileBytes;
use super::meaning::{Meaning, known_as, may_scale, quantity, with_unit};
use super::memory::SharedBytes;
use super::open::{Contents, FileSource};
use super::options::Delays;
use super::scan::NamedNumber;
use super::statements::{Statement, Statements};
use super::storage::{Bytes, Factor, Storage};
use super::{Field, Layout, Note, graded_masses};
use crate::error::{Error, InputFault, Result};
use crate::measure::{Length, symbol_or};

pub(super) use axes::counted;
use choose::Choice;
pub(super) use choose::{dimensions, last_name};

/// The arrays of a file, and how they are read.
pub(crate) struct Arrays<'a> {
    source: &'a FileSource<'a>,
    pub(super) container: Container,
}

impl<'a> Arrays<'a> {
    /// Those of `container`.
    ///
    /// # Errors
    /// An array that is damaged and whose name says something about the field.
    pub(super) fn new(source: &'a FileSource<'a>, mut container: Container) -> Result<Arrays<'a>> {
        let matters = |name: &str| {
            Statements::default().is_one(name)
                || [Meaning::Time, Meaning::Position, Meaning::Field]
                    .into_iter()
                    .any(|meaning| known_as(name, meaning).is_some())
        };
        for (i, variable) in container.variables.iter().enumerate() {
            if let Some(fault) = container.damage(i).filter(|_| matters(&variable.path)) {
                return Err(fault.clone().into());
            }
        }
        if matches!(container.format, Format::Npy | Format::Npz) {
            for variable in &mut container.variables {
                name_dimensions(&mut variable.dimensions, source.layout());
            }
        }
        Ok(Arrays { source, container })
    }

    fn variable(&self, i: usize) -> &Variable {
        &self.container.variables[i]
    }

    /// The samples of a variable along two of its dimensions, if they lie in one piece; of the others, which are `fixed`,
    /// those at one index.
    fn piece(
        &self,
        i: usize,
        dimensions: [Option<usize>; 2],
        fixed: &[(usize, u64)],
    ) -> Result<Option<Storage>> {
        let variable = self.variable(i);
        let Some(sample) = variable.sample_type.number() else {
            unreachable!("a chosen variable holds numbers")
        };
        let bytes = self.container.bytes(i)?;
        let (Some(bytes), Place::Strided(strided)) = (bytes, &variable.place) else {
            return Ok(None);
        };
        let bytes = match strided.is_in_file {
            true => Bytes::File(Arc::clone(&self.source.bytes)),
            false => Bytes::Held(SharedBytes(bytes)),
        };
        let strides = &strided.strides;
        let skipped = fixed.iter().map(|&(d, index)| index * strides[d]);
        let start = (strided.start + skipped.sum::<u64>()) as usize;
        let lengths = dimensions.map(|d| d.map_or(1, |d| variable.dimensions[d].len as usize));
        // The only site lies wherever the records begin.
        let strides = dimensions.map(|d| d.map_or(sample.bytes() as u64, |d| strides[d]) as isize);
        let numbers = (sample, strided.order);
        Ok(Some(Storage::new(bytes, numbers, start, lengths, strides)))
    }

    /// A block of an array of one or two dimensions, as `of` says of their lengths, row-major; all of it where it does not
    /// lie in one piece.
    fn rows(&self, i: usize, of: impl FnOnce(usize) -> Range<usize>) -> Result<Vec<f64>> {
        let shape = self.variable(i).shape();
        let dimensions = [0, 1].map(|d| (d < shape.len()).then_some(d));
        let piece = match shape.len() {
            1 | 2 => self.piece(i, dimensions, &[])?,
            _ => None,
        };
        let Some(storage) = piece else {
            return Ok(self.container.numbers(i)?);
        };
        let [rows, columns] = [0, 1].map(|d| shape.get(d).map_or(1, |&len| len as usize));
        let rows = of(rows);
        let mut values = vec![0.0; rows.len() * columns];
        storage.read(rows, 0..columns, false, &mut values);
        Ok(values)
    }

    /// Shape and samples of an array, row-major, where there is one of this name.
    pub(crate) fn array(&self, name: &str) -> Result<Option<(Vec<u64>, Vec<f64>)>> {
        let found = self.container.find(name);
        let read = |i| Ok((self.variable(i).shape(), self.rows(i, |rows| 0..rows)?));
        found.map(read).transpose()
    }

    /// The text of this name, where there is one.
    pub(crate) fn text(&self, name: &str) -> Result<Option<String>> {
        let member = self.container.find(name);
        let member = member.map(|i| self.container.text(i)).transpose()?;
        let attribute = || self.container.attributes.text(name).map(str::to_owned);
        Ok(member.flatten().or_else(attribute))
    }

    /// A fault of the array of this name, or of the file where there is none.
    pub(crate) fn fault(&self, name: &str, fault: InputFault) -> Error {
        Error::from(match self.container.find(name) {
            Some(_) => fault.within(name),
            None => fault,
        })
    }

    /// The numbers that those of a variable stand for.
    fn unpacked(&self, i: usize) -> Result<Vec<f64>> {
        let (scale, offset) = self.own(i).linear();
        let numbers = self.container.numbers(i)?.into_iter();
        Ok(numbers.map(|v| scale * v + offset).collect())
    }

    /// Whether a variable holds one number.
    fn is_number(&self, i: usize) -> bool {
        let variable = self.variable(i);
        variable.count() == Some(1) && variable.sample_type.number().is_some()
    }

    /// The unit of a variable, by its attributes, the text `NAME_unit` beside it, or its name.
    fn unit(&self, i: usize) -> Option<String> {
        self.own(i).own_unit().or_else(|| {
            let path = self.variable(i).path.trim_start_matches('/');
            let (group, name) = path.split_at(path.len() - last_name(path).len());
            let beside = Statements::of_all(stated(&self.container.attributes, group, ""));
            let beside = beside.unit_of(name);
            beside.or(with_unit(name).1.map(str::to_owned))
        })
    }

    /// The attributes of a variable.
    fn own(&self, i: usize) -> Statements {
        let variable = self.variable(i);
        let holder = format!("{}/", variable.path.trim_start_matches('/'));
        Statements::of_all(stated(&variable.attributes, "", &holder))
    }

    /// What the attributes of a variable, its group or struct and the groups around it state: attributes, and arrays
    /// whose name states something.
    fn statements(&self, variable: usize) -> Result<Statements> {
        let path = self.variable(variable).path.trim_start_matches('/');
        let mut statements = self.own(variable);
        // `velocity_unit` and `velocity_scale` are those of `velocity`, or of `v` where no array is called so.
        let own_name = format!("{}_", last_name(path));
        let is_of_field = |base: &str, rest: &str| {
            let is = |name, meaning| known_as(name, meaning).is_some();
            is(rest, Meaning::Unit)
                && is(base, Meaning::Field)
                && self.container.find(base).is_none()
        };
        let of_it = |name: &'_ str| {
            let split = name.rsplit_once('_');
            let split = split.filter(|(base, rest)| is_of_field(base, rest));
            let rest = name.strip_prefix(&own_name).or(split.map(|(_, rest)| rest));
            rest.unwrap_or(name).to_owned()
        };
        let mut group = path;
        while let Some(end) = group.rfind(['/', '.']).or((!group.is_empty()).then_some(0)) {
            let prefix = &path[..end + usize::from(end > 0)];
            group = &path[..end];
            let mut found = stated(&self.container.attributes, prefix, "");
            for (i, other) in self.container.variables.iter().enumerate() {
                let Some((name, place)) = within(&other.path, prefix) else {
                    continue;
                };
                let is_list = other.sample_type.number().is_some()
                    && other.dimensions.iter().filter(|d| d.len > 1).count() == 1
                    && may_scale(&of_it(name));
                if i != variable && (is_list || self.is_number(i)) {
                    let numbers = Value::Numbers(self.unpacked(i)?);
                    found.push(Statement::new(name, place, numbers, self.unit(i)));
                }
            }
            for one in &mut found {
                one.name = of_it(&one.name);
            }
            statements.add_outer(found);
        }
        Ok(statements)
    }
}

/// Names three dimensions and more: time, y and x; with the layout site-time y, x and time.
fn name_dimensions(dimensions: &mut [Dimension], layout: Layout) {
    if dimensions.len() < 3 {
        return;
    }
    let mut from_last = dimensions.iter_mut().rev().collect::<Vec<_>>();
    let time = match layout {
        Layout::TimeSite => from_last.pop(),
        Layout::SiteTime => Some(from_last.remove(0)),
    };
    for (d, name) in time
        .into_iter()
        .chain(from_last)
        .zip(["time", "x", "y", "z"])
    {
        d.name = Some(name.into());
    }
}

/// The last name of a path in a group, and the path as it is shown; `None` elsewhere, and in groups within.
fn within<'p>(path: &'p str, group: &str) -> Option<(&'p str, &'p str)> {
    let shown = path.trim_start_matches('/');
    let name = shown.strip_prefix(group)?;
    (!name.contains(['/', '.'])).then_some((name, shown))
}

/// The attributes in a group as statements, which are shown behind what holds them.
fn stated(attributes: &Attributes, group: &str, holder: &str) -> Vec<Statement> {
    let one = |(path, value): (&String, &Value)| {
        let (name, shown) = match group {
            "" if !holder.is_empty() => (path.as_str(), path.as_str()),
            group => within(path, group)?,
        };
        let place = format!("{holder}{shown}");
        Some(Statement::new(name, &place, value.clone(), None))
    };
    attributes.0.iter().filter_map(one).collect()
}

/// The field of a file of arrays.
pub(super) fn read(source: &FileSource, container: Container) -> Result<Contents> {
    let arrays = Arrays::new(source, container)?;
    let container = &arrays.container;
    let format = container.format;
    let choice = Choice::of(&arrays)?;
    let variable = arrays.variable(choice.variable);
    let shape = choice.shape(&arrays);
    let attributes = &variable.attributes;
    // What this program wrote says itself what is the field.
    let is_own = own_schema(container).is_some();
    let own = arrays.own(choice.variable);
    let statements = match is_own {
        true => Statements::default(),
        false => arrays.statements(choice.variable)?,
    };
    let storage = load::storage(&arrays, &choice)?;
    let mut notes = match is_own || format == Format::Npy {
        true => Vec::new(),
        false => vec![choice.note(&arrays)],
    };
    notes.extend(choice.notes.iter().cloned());
    let of_it = |remark: &&Remark| remark.variable.is_none_or(|about| about == choice.variable);
    let remarks = container.remarks.iter().filter(of_it);
    notes.extend(remarks.map(|remark| Note::doubt("remark", remark.text.clone())));
    let (stated, options) = (&source.stated, source.options);
    let time = statements.time(stated, options)?;
    let space = statements.space(stated, options)?;
    let time = axes::axis(&arrays, &time, Some(&choice.times), &mut notes)?;
    let space = axes::axis(&arrays, &space, choice.sites.as_ref(), &mut notes)?;
    // Times that count from a date say so themselves.
    let is_dated = |note: &Note| note.code == "start";
    if let Some(start) = attributes.text("start_time")
        && matches!(format, Format::Tdms | Format::MiniSeed)
        && !notes.iter().any(is_dated)
    {
        notes.push(Note::start(start));
    }
    let [scale, offset] = match is_own {
        true => <[f64; 2]>::from(own.linear()).map(Factor::one),
        false => statements.scaling(shape, &mut notes)?,
    };
    let unit = match is_own || stated.unit.is_some() {
        true => arrays.unit(choice.variable),
        false => statements.unit(&mut notes)?,
    };
    let counts = |listed: &Listed| listed.even == Coordinates::default();
    notes.extend(statements.unused([
        counts(&time) && stated.dt.is_none(),
        counts(&space) && stated.dx.is_none(),
    ]));
    let standard_name = attributes.text("standard_name");
    let sample = variable.sample_type.number();
    let packing = own.packing(sample, format, [scale, offset], &mut notes)?;
    let quantity = quantity(&variable.path, standard_name, unit.as_deref());
    let field = Field {
        unit,
        notes,
        axis_names: [Some(&choice.times), choice.sites.as_ref()]
            .map(|place| Some(last_name(place?.name.as_deref()?).to_owned())),
        ..Field::of_storage(storage.packed(packing), (shape[0], shape[1]))
    };
    let mut contents = Contents {
        field,
        time,
        space,
        quantity,
    };
    if is_own {
        arrays.of_run(&mut contents.field)?;
    } else {
        contents.note_doubts(choice.is_layout_known || stated.layout.is_some());
    }
    if attributes.get("delays").is_none() {
        return Ok(contents);
    }
    match options.delays {
        Delays::Ignore => {
            let text = "the traces begin at different times and are read as if they began at one";
            let advice = "take the times that all have in common with `--delays align`";
            let note = Note::doubt("delays", text).advising(advice);
            contents.field.notes.push(note);
            Ok(contents)
        }
        treated => delays::aligned(&arrays, contents, treated),
    }
}

impl Arrays<'_> {
    /// What a file of this program says beside a field: a dispersion relation, the body that was struck, and the masses
    /// of a graded chain.
    fn of_run(&self, field: &mut Field) -> Result<()> {
        let n_sites = field.n_sites;
        let attributes = &self.container.attributes;
        field.dispersion = attributes.text("dispersion").map(str::to_owned);
        let numbers = |name| {
            let found = self.container.find(name);
            found.map(|i| self.container.numbers(i)).transpose()
        };
        field.struck = match attributes.get("struck_site") {
            Some(Value::Integers(sites)) => sites.first().and_then(|&site| site.try_into().ok()),
            _ => self.struck(n_sites)?,
        };
        field.struck = field.struck.filter(|site| *site < n_sites);
        let bodies = numbers("mass")?.zip(numbers("contact_coefficient")?);
        let bodies = bodies.filter(|(masses, _)| masses.len() == n_sites);
        field.masses = bodies.and_then(|(masses, contacts)| graded_masses(&masses, &contacts));
        Ok(())
    }

    /// The last of `n_sites` bodies of a run that moves, or is out of place, in its first sample; the body that its scene
    /// drives where none is, by default the first. `None` for another number of bodies, and of no run.
    fn struck(&self, n_sites: usize) -> Result<Option<usize>> {
        let Some(scene) = self.text("scene")? else {
            return Ok(None);
        };
        let mut last = None;
        for name in ["velocity", "displacement"] {
            let Some(i) = self.container.find(name) else {
                continue;
            };
            if self.variable(i).dimensions.last().map(|d| d.len) != Some(n_sites as u64) {
                return Ok(None);
            }
            let first = self.rows(i, |rows| 0..rows.min(1))?;
            last = last.max(first.iter().rposition(|&v| v != 0.0));
        }
        let scene = scene.parse::<toml::Table>().unwrap_or_default();
        let site = scene.get("drive_site").and_then(toml::Value::as_integer);
        Ok(last
            .or(site.and_then(|site| site.try_into().ok()))
            .or(Some(0)))
    }

    /// Single numbers of a file that may be the position of its record, or have the name `asked`: attributes of the field
    /// and of the file, variables of one number.
    pub(super) fn positions(&self, asked: Option<&str>) -> Result<Vec<NamedNumber>> {
        // Of several groups of records the coordinates are `/x/1`, `/x/2`.
        let is_it = |name: &str| {
            let bare = name.trim_start_matches('/');
            let mut parts = bare.split(['/', '.']);
            match asked {
                Some(asked) => {
                    bare == asked.trim_start_matches('/') || parts.any(|part| part == asked)
                }
                None => parts.any(|part| known_as(part, Meaning::RecordPosition).is_some()),
            }
        };
        let choice = Choice::of(self).ok();
        let own = choice.map(|choice| &self.variable(choice.variable).attributes);
        let mut found = Vec::new();
        for attributes in own.into_iter().chain([&self.container.attributes]) {
            let all = attributes.0.iter();
            let all = all.map(|(name, value)| Statement::new(name, name, value.clone(), None));
            found.extend(Statements::of_all(all.collect()).numbers(is_it));
        }
        for (i, variable) in self.container.variables.iter().enumerate() {
            if !self.is_number(i) || !is_it(&variable.path) {
                continue;
            }
            let value = self.unpacked(i)?[0];
            let sample = variable.sample_type.number();
            let relative = sample.map_or(f64::EPSILON, |sample| sample.relative_rounding());
            found.push(NamedNumber {
                name: variable.path.trim_start_matches('/').to_owned(),
                value,
                unit: self.unit(i).map(|unit| symbol_or::<Length>(&unit)),
                rounding: relative * value.abs(),
            });
        }
        Ok(found)
    }
}

/// What a file that this program wrote states as its schema.
pub(super) fn own_schema(container: &Container) -> Option<&str> {
    let schema = container.attributes.text("schema");
    schema.filter(|schema| schema.starts_with("cascade."))
}

/// The schema of a NetCDF file that this program or its Python package wrote, and whether it holds a whole run;
/// `None` for any other file.
pub(super) fn own(bytes: Arc<FileBytes>) -> Option<(String, bool)> {
    let format = netcdf(&bytes)?;
    let container = wavecascade_formats::open(format, bytes, &Options::default()).ok()?;
    let schema = own_schema(&container)?.to_owned();
    // A part of a run, which arrays of other languages are easily cut to, is a field.
    let is_whole = || {
        let shape = &container.variables[container.find("velocity")?].shape();
        let words: Vec<String> = shape.iter().map(u64::to_string).collect();
        (container.attributes.text("shape")? == words.join(" x ")).then_some(())
    };
    let is_run = schema.starts_with("cascade.run/") && is_whole().is_some();
    Some((schema, is_run))
}

/// The format of a NetCDF file; `None` for any other file.
pub(super) fn netcdf(bytes: &[u8]) -> Option<Format> {
    let is_netcdf = |format: &Format| matches!(format, Format::NetCdf3 | Format::Hdf5);
    // By its bytes alone: any text that was called so would be one.
    Format::detect("", bytes).filter(is_netcdf)
}
