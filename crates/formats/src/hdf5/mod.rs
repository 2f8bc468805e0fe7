//! HDF5, and what builds on it: NetCDF-4, MATLAB 7.3, DASDAE.

mod attributes;
mod axes;
mod dasdae;
mod data;
mod links;
mod lzf;
mod types;

use std::collections::HashSet;
use std::fmt::Display;

use hdf5_reader::error::Error as Cause;
use hdf5_reader::group::Group;
use hdf5_reader::messages::HdfMessage;
use hdf5_reader::object_header::ObjectHeader;
use hdf5_reader::{Dataset, FilterRegistry, Hdf5File, OpenOptions};

use crate::cursor::beginning;
use crate::{
    Attributes, Bytes, Container, Dimension, Error, Format, Options, Place, Result, SampleType,
    Shared, Variable,
};
use data::Stored;
use links::Target;

const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";
/// Groups within groups.
const MOST_LEVELS: usize = 64;
/// Objects of a file.
const MOST_OBJECTS: usize = 100_000;
const LARGEST_HEADER: usize = 16 << 20;
const CACHE: usize = 32 << 20;

/// The format of these bytes, if it is one of this module.
pub(crate) fn detect(bytes: &[u8]) -> Option<Format> {
    // A user block moves the signature to 512, 1024, 2048, ..
    let places = std::iter::once(0).chain((9..usize::BITS).map(|power| 1usize << power));
    places
        .take_while(|&place| place < bytes.len())
        .any(|place| bytes[place..].starts_with(&SIGNATURE))
        .then_some(Format::Hdf5)
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let len = (*bytes).as_ref().len();
    if detect((*bytes).as_ref()).is_none() {
        let found = beginning((*bytes).as_ref());
        return Err(Error::damaged("byte 0", "the signature of HDF5", found));
    }
    // Chunks that are larger than a thousand times the file are not data: deflate cannot pack more densely.
    let largest_chunk = len.saturating_mul(1100).max(16 << 20);
    let memory = options.memory.map_or(usize::MAX, |memory| {
        usize::try_from(memory).unwrap_or(usize::MAX)
    });
    let mut filters = FilterRegistry::new();
    filters.register(types::LZF, Box::new(|_, packed, _| lzf::unpack(packed)));
    let options = OpenOptions::default()
        .with_filter_registry(filters)
        .with_max_chunk_bytes(largest_chunk.min(memory))
        .with_max_object_header_bytes(LARGEST_HEADER)
        .with_chunk_cache_bytes(CACHE.min(memory));
    let file = Hdf5File::from_owner(Shared(bytes.clone()), options).map_err(at("the file"))?;
    let root = file.root_group().map_err(at("the root group"))?;
    let mut walk = Walk {
        file: &file,
        len: len as u64,
        visited: HashSet::new(),
        attributes: Attributes::default(),
        groups: Vec::new(),
        objects: Vec::new(),
        variables: Vec::new(),
    };
    walk.group(&root, "", 0)?;
    axes::assign(&mut walk);
    dasdae::assign(&mut walk);
    let mut container = Container::new(format, &bytes);
    container.attributes = walk.attributes;
    for (variable, object) in walk.variables.into_iter().zip(walk.objects) {
        match object.stored {
            Some(stored) => container.push_decoded(variable, stored),
            None => container.push(variable),
        }
    }
    Ok(container)
}

/// What is found on the way through the groups.
struct Walk<'a> {
    file: &'a Hdf5File,
    /// Bytes of the file.
    len: u64,
    /// Addresses of object headers: an object may have several names, and groups may hold each other.
    visited: HashSet<u64>,
    attributes: Attributes,
    /// Groups with their attributes.
    groups: Vec<(String, Attributes)>,
    /// One for each variable.
    objects: Vec<Object>,
    variables: Vec<Variable>,
}

/// What a variable is in HDF5.
#[derive(Default)]
struct Object {
    /// Its object header.
    address: Option<u64>,
    stored: Option<Stored>,
    /// For each dimension, the object headers of its scales.
    scales: Vec<Vec<u64>>,
}

impl Walk<'_> {
    fn group(&mut self, group: &Group, path: &str, level: usize) -> Result<()> {
        if !self.visited.insert(group.address()) {
            return Ok(());
        }
        let place = format!("group {path}/");
        if level > MOST_LEVELS {
            let what = format!("groups more than {MOST_LEVELS} levels deep");
            return Err(Error::unsupported(what, "store fewer levels"));
        }
        let header = self.file.get_or_parse_header(group.address());
        let header = header.map_err(at(&place))?;
        let found = group.attributes().map_err(at(&place))?;
        let mut own = attributes::read(&found);
        for (name, value) in &own.0 {
            let name = format!("{path}/{name}").trim_start_matches('/').to_owned();
            self.attributes.insert(name, value.clone());
        }
        dasdae::keep_units(&found, &mut own);
        self.groups.push((path.to_owned(), own));
        for link in links::read(self.file, &header).map_err(at(&place))? {
            let path = format!("{path}/{}", link.name);
            match link.target {
                Target::Object(address) => {
                    self.object(group, &link.name, path, address, level)?;
                }
                Target::File(file) => {
                    let other = format!("a link to the file {file}, which is not followed");
                    self.push_other(path, other);
                }
            }
            if self.visited.len() > MOST_OBJECTS || self.variables.len() > MOST_OBJECTS {
                let what = format!("more than {MOST_OBJECTS} objects");
                return Err(Error::unsupported(what, "store fewer objects in a file"));
            }
        }
        Ok(())
    }

    fn object(
        &mut self,
        parent: &Group,
        name: &str,
        path: String,
        address: u64,
        level: usize,
    ) -> Result<()> {
        use HdfMessage::*;
        if self.visited.contains(&address) {
            return Ok(());
        }
        let header = match self.file.get_or_parse_header(address) {
            Ok(header) => header,
            Err(cause) => {
                let other = unsupported(&cause).ok_or_else(|| at(&path)(cause))?;
                self.visited.insert(address);
                self.push_other(path, other);
                return Ok(());
            }
        };
        let has = |is: fn(&HdfMessage) -> bool| header.messages.iter().any(is);
        if has(|it| matches!(it, SymbolTable(_) | Link(_) | LinkInfo(_) | GroupInfo(_))) {
            let group = parent.group(name).map_err(at(&path))?;
            return self.group(&group, &path, level + 1);
        }
        if has(|it| matches!(it, Dataspace(_))) {
            self.visited.insert(address);
            let dataset = parent.dataset(name).map_err(at(&path))?;
            return self.dataset(parent, dataset, &header, path);
        }
        Ok(())
    }

    fn dataset(
        &mut self,
        parent: &Group,
        dataset: Dataset,
        header: &ObjectHeader,
        path: String,
    ) -> Result<()> {
        let dimensions = dataset.shape().iter().map(|&len| Dimension::new(len));
        let mut variable = Variable::other(path.clone(), dimensions.collect(), "text");
        let found = dataset.attributes();
        variable.attributes = attributes::read(&found);
        let scales = axes::scales(parent, &found, dataset.ndim());
        let stored = Stored {
            path: path.clone(),
            dataset,
        };
        let dataset = &stored.dataset;
        let address = Some(dataset.address());
        if variable.attributes.text("MATLAB_class") == Some("char") {
            // As in MATLAB 5 files.
            let text = stored.short_text().unwrap_or_default();
            let name = path.trim_start_matches('/');
            self.attributes.insert_text(name, text);
        } else {
            let kind = types::read(dataset, header).map_err(at(&path))?;
            variable.sample_type = match kind {
                Err(other) => SampleType::Other(other),
                Ok((sample, order)) => {
                    let file = (self.file, self.len);
                    variable.place = data::place(file, &path, dataset, header, (sample, order))?;
                    let is_decoded = matches!(variable.place, Place::Encoded { .. });
                    match is_decoded && data::has_foreign_fill(dataset, header) {
                        true => SampleType::Other("data whose _FillValue has another type".into()),
                        false => SampleType::Number(sample),
                    }
                }
            };
        }
        self.variables.push(variable);
        self.objects.push(Object {
            address,
            stored: Some(stored),
            scales,
        });
        Ok(())
    }

    fn push_other(&mut self, path: String, other: String) {
        self.variables
            .push(Variable::other(path, Vec::new(), other));
        self.objects.push(Object::default());
    }
}

/// What an object is that is sound but not read.
fn unsupported(cause: &Cause) -> Option<String> {
    match cause {
        Cause::Context { source, .. } => unsupported(source),
        Cause::UnsupportedLayoutClass(3) => {
            Some("a virtual data set, whose parts are not read".into())
        }
        Cause::UnsupportedDatatypeClass(11) => Some("complex numbers".into()),
        Cause::UnsupportedDatatypeClass(class) => Some(format!("data of the HDF5 class {class}")),
        Cause::UnsupportedEncoding(what) => Some(what.clone()),
        _ => None,
    }
}

/// The error of the reader of HDF5 as one of this crate.
fn at(place: impl Display) -> impl FnOnce(Cause) -> Error {
    move |cause| explain(&place.to_string(), &cause)
}

fn explain(place: &str, cause: &Cause) -> Error {
    use Cause::*;
    let (what, way_out) = match cause {
        Context { source, .. } => return explain(place, source),
        ResourceLimit(what) => (what.clone(), "allow more memory, or store smaller chunks"),
        UnsupportedFilter(what) => (what.clone(), types::WAY_OUT),
        UnsupportedSuperblockVersion(_)
        | UnsupportedObjectHeaderVersion(_)
        | UnsupportedLayoutClass(_)
        | UnsupportedLayoutVersion(_)
        | UnsupportedEncoding(_) => (cause.to_string(), types::WAY_OUT),
        _ => return Error::damaged(place, "sound HDF5", cause),
    };
    Error::unsupported(format!("{place}: {what}"), way_out)
}
