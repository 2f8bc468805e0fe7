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

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use wavecascade_formats::{
    Attributes, ByteOrder, Container, Format, Options, Place, Remark, Sample, Value, Variable,
};

use super::coordinates::{Coordinates, Listed};
use super::file_bytes::FileBytes;
use super::meaning::{Meaning, known_as, may_scale, quantity, with_unit};
use super::npz::Archive;
use super::open::{Contents, FileSource};
use super::options::Delays;
use super::scan::NamedNumber;
use super::statements::{Statement, Statements};
use super::storage::{Bytes, Factor};
use super::{Field, Note, graded_masses, npy};
use crate::error::{Error, InputFault, Result};
use crate::measure::{Length, symbol_or};

pub(super) use axes::counted;
use choose::Choice;
pub(super) use choose::{dimensions, last_name};

/// Texts, and arrays with their shapes, by their names.
pub(crate) type Parts = (
    BTreeMap<String, String>,
    BTreeMap<String, (Vec<u64>, Vec<f64>)>,
);

/// The arrays of a file, and how they are read.
pub(super) struct Arrays<'a> {
    source: &'a FileSource<'a>,
    pub(super) container: Container,
    /// Of an archive of NumPy, its members.
    archive: Option<RefCell<Archive<'a>>>,
}

impl<'a> Arrays<'a> {
    /// Those of a file of `format`.
    pub(super) fn open(source: &'a FileSource<'a>, format: Format) -> Result<Arrays<'a>> {
        let mut options = Options::default();
        options.memory = source.options.memory;
        let mut archive = None;
        let container = match format {
            Format::Npz => {
                let mut opened = Archive::open(source).map_err(|fault| source.fault(fault))?;
                let container = opened.container()?;
                archive = Some(RefCell::new(opened));
                Ok(container)
            }
            Format::Npy => Ok(npy::container(&source.bytes).map_err(|fault| source.fault(fault))?),
            Format::Zarr => wavecascade_formats::open_directory(format, source.path, &options),
            _ => wavecascade_formats::open(format, source.bytes.clone(), &options),
        };
        let mut container = container.map_err(|fault| source.container_fault(fault))?;
        if matches!(format, Format::Npy | Format::Npz) {
            for variable in &mut container.variables {
                npy::name_dimensions(&mut variable.dimensions, source.layout());
            }
        }
        Ok(Arrays {
            source,
            container,
            archive,
        })
    }

    fn variable(&self, i: usize) -> &Variable {
        &self.container.variables[i]
    }

    /// The bytes of a variable that lies in one piece, and where its first sample is.
    fn bytes(&self, i: usize) -> Result<Option<(Bytes, Placed)>> {
        if let Some(archive) = &self.archive {
            let (header, bytes, start) = archive.borrow_mut().load(i)?;
            let (strides, order) = (header.strides(), header.order);
            return Ok(Some((bytes, (start as u64, strides, order))));
        }
        Ok(match &self.variable(i).place {
            Place::Strided {
                start,
                strides,
                order,
            } => Some((
                Bytes::File(Arc::clone(&self.source.bytes)),
                (*start, strides.clone(), *order),
            )),
            Place::Encoded { .. } => None,
        })
    }

    /// The numbers of a variable as they are stored.
    fn numbers(&self, i: usize) -> Result<Vec<f64>> {
        match &self.archive {
            Some(archive) => archive.borrow_mut().numbers(i, Sample::to_f64),
            None => self
                .container
                .numbers(i)
                .map_err(|fault| self.source.container_fault(fault)),
        }
    }

    /// Its integers; `None` of floats.
    fn integers(&self, i: usize) -> Result<Option<Vec<i64>>> {
        match &self.archive {
            Some(archive) => {
                let integers = archive.borrow_mut().numbers(i, Sample::to_i64)?;
                Ok(integers.into_iter().collect())
            }
            None => self
                .container
                .integers(i)
                .map_err(|fault| self.source.container_fault(fault)),
        }
    }

    /// The numbers that those of a variable stand for.
    fn unpacked(&self, i: usize) -> Result<Vec<f64>> {
        let (scale, offset) = self.own(i).linear();
        let numbers = self.numbers(i)?.into_iter();
        Ok(numbers.map(|v| scale * v + offset).collect())
    }

    /// A fault of one array.
    fn fault(&self, i: usize, fault: InputFault) -> Error {
        match &self.archive {
            Some(archive) => archive.borrow().member_fault(i, fault),
            None => self.source.fault(fault),
        }
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
            let beside = self.statements_in(group).unit_of(name);
            beside.or(with_unit(name).1.map(str::to_owned))
        })
    }

    /// The attributes of a variable.
    fn own(&self, i: usize) -> Statements {
        let variable = self.variable(i);
        let path = variable.path.trim_start_matches('/');
        let all = variable.attributes.0.iter().filter_map(|(name, _)| {
            statement(&variable.attributes, name, name, &format!("{path}/{name}"))
        });
        Statements::of_all(all.collect())
    }

    /// The attributes of a group, by the path before their names.
    fn statements_in(&self, group: &str) -> Statements {
        let mut statements = Statements::default();
        for (path, _) in &self.container.attributes.0 {
            let bare = path.trim_start_matches('/');
            let name = bare.strip_prefix(group);
            if let Some(name) = name.filter(|name| !name.contains(['/', '.'])) {
                statements
                    .all
                    .extend(statement(&self.container.attributes, path, name, bare));
            }
        }
        statements
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
            let mut found = self.statements_in(prefix).all;
            for (i, other) in self.container.variables.iter().enumerate() {
                let place = other.path.trim_start_matches('/');
                let Some(name) = place
                    .strip_prefix(prefix)
                    .filter(|name| !name.contains(['/', '.']))
                else {
                    continue;
                };
                let is_list = other.sample_type.number().is_some()
                    && other.dimensions.iter().filter(|d| d.len > 1).count() == 1
                    && may_scale(&of_it(name));
                if i != variable && (is_list || self.is_number(i)) {
                    found.push(Statement {
                        name: name.to_owned(),
                        place: place.to_owned(),
                        value: Value::Numbers(self.unpacked(i)?),
                        unit: self.unit(i),
                    });
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

/// Where samples lie in bytes: the first one, steps from one index to the next, their order.
type Placed = (u64, Vec<u64>, ByteOrder);

/// An attribute as a statement.
fn statement(attributes: &Attributes, key: &str, name: &str, place: &str) -> Option<Statement> {
    Some(Statement {
        name: name.to_owned(),
        place: place.to_owned(),
        value: attributes.get(key)?.clone(),
        unit: None,
    })
}

/// The field of a file of `format`.
pub(super) fn read(source: &FileSource, format: Format) -> Result<Contents> {
    let arrays = Arrays::open(source, format)?;
    let container = &arrays.container;
    let choice = Choice::of(&arrays)?;
    let variable = arrays.variable(choice.variable);
    let shape = [choice.n_times(&arrays)?, choice.n_sites(&arrays)?];
    let attributes = &variable.attributes;
    // What this program wrote says itself what is the field.
    let is_own = own_schema(container).is_some();
    let own = arrays.own(choice.variable);
    let statements = match is_own {
        true => Statements::default(),
        false => arrays.statements(choice.variable)?,
    };
    let fault = |fault| source.fault(fault);
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
    let time = statements.time(stated, options).map_err(fault)?;
    let space = statements.space(stated, options).map_err(fault)?;
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
        true => <[f64; 2]>::from(own.linear()).map(Factor::One),
        false => statements.scaling(shape, &mut notes).map_err(fault)?,
    };
    let unit = match is_own || stated.unit.is_some() {
        true => arrays.unit(choice.variable),
        false => statements.unit(&mut notes).map_err(fault)?,
    };
    let counts = |listed: &Listed| listed.even == Coordinates::default();
    notes.extend(statements.unused([
        counts(&time) && stated.dt.is_none(),
        counts(&space) && stated.dx.is_none(),
    ]));
    let standard_name = attributes.text("standard_name");
    let packing = own.packing(
        variable.sample_type.number(),
        format,
        [scale, offset],
        &mut notes,
    );
    let packing = packing.map_err(fault)?;
    let quantity = quantity(&variable.path, standard_name, unit.as_deref());
    let field = Field {
        unit,
        notes,
        axis_names: [Some(&choice.times), choice.sites.as_ref()]
            .map(|place| Some(last_name(place?.name.as_deref()?).to_owned())),
        ..Field::of_storage(storage.packed(packing), (shape[0], shape[1]))
    };
    let mut contents = Contents::of(field, [time, space], quantity);
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
            self.container
                .find(name)
                .map(|i| self.numbers(i))
                .transpose()
        };
        field.struck = match (attributes.get("struck_site"), &self.archive) {
            (Some(Value::Integers(sites)), _) => {
                sites.first().and_then(|&site| site.try_into().ok())
            }
            (_, Some(archive)) if self.container.find("scene").is_some() => {
                archive.borrow_mut().struck(n_sites)?
            }
            _ => None,
        };
        field.struck = field.struck.filter(|site| *site < n_sites);
        let bodies = numbers("mass")?.zip(numbers("contact_coefficient")?);
        let bodies = bodies.filter(|(masses, _)| masses.len() == n_sites);
        field.masses = bodies.and_then(|(masses, contacts)| graded_masses(&masses, &contacts));
        Ok(())
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
            let all = all.filter_map(|(name, _)| statement(attributes, name, name, name));
            let statements = Statements::of_all(all.collect());
            found.extend(statements.numbers(is_it));
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
fn own_schema(container: &Container) -> Option<&str> {
    let schema = container.attributes.text("schema");
    schema.filter(|schema| schema.starts_with("cascade."))
}

/// The schema of a NetCDF file that this program or its Python package wrote, and whether it holds a whole run;
/// `None` for any other file.
pub(super) fn own(bytes: Arc<FileBytes>) -> Option<(String, bool)> {
    let container = own_container(bytes)?;
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

fn own_container(bytes: Arc<FileBytes>) -> Option<Container> {
    let is_netcdf = |format: &Format| matches!(format, Format::NetCdf3 | Format::Hdf5);
    let format = Format::detect("a.nc", &bytes).filter(is_netcdf)?;
    wavecascade_formats::open(format, bytes, &Options::default()).ok()
}

/// The texts and the arrays of a NetCDF file; `None` for any other file.
pub(super) fn parts(bytes: Arc<FileBytes>) -> Option<wavecascade_formats::Result<Parts>> {
    let container = own_container(bytes)?;
    let texts = container.attributes.0.iter();
    let texts = texts.filter_map(|(name, _)| {
        let text = container.attributes.text(name)?;
        Some((name.clone(), text.to_owned()))
    });
    let is_number = |i: &usize| container.variables[*i].sample_type.number().is_some();
    let arrays = (0..container.variables.len()).filter(is_number).map(|i| {
        let variable = &container.variables[i];
        let name = variable.path.trim_start_matches('/').to_owned();
        Ok((name, (variable.shape(), container.numbers(i)?)))
    });
    let arrays: wavecascade_formats::Result<_> = arrays.collect();
    let texts = texts.collect();
    Some(arrays.map(|arrays| (texts, arrays)))
}

impl FileSource<'_> {
    /// A fault of a container as one of its file.
    fn container_fault(&self, fault: wavecascade_formats::Error) -> Error {
        match fault {
            wavecascade_formats::Error::Memory {
                needed, allowed, ..
            } => Error::Memory {
                what: "what has to be decoded of the file",
                needed,
                allowed,
            },
            fault => self.fault(InputFault::Container {
                fault: Box::new(fault),
            }),
        }
    }
}

fn is_float(sample: Sample) -> bool {
    matches!(
        sample,
        Sample::F16 | Sample::F32 | Sample::F64 | Sample::IbmF32
    )
}
