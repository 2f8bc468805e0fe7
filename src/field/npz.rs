//! Arrays in NumPy's `.npz` archives: zip files of `.npy` members.
//!
//! A stored member stays where it is in the mapped file. A deflated one is inflated to exactly
//! the bytes that its own header promises, and not one more.

use std::io::{Cursor, Read};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use zip::CompressionMethod;
use zip::read::{ZipArchive, ZipReadOptions};
use zip::result::ZipError;

use wavecascade_formats::{
    Attributes, ByteOrder, Container, Format, Place, Sample, SampleType, Variable,
};

use super::meaning::{Meaning, known_as};
use super::npy;
use super::open::{FileSource, map};
use super::options::OpenOptions;
use super::sidecar::Sidecar;
use super::statements::Statements;
use super::storage::{Bytes, Storage};
use crate::error::{Error, InputFault, Result};
use crate::system::memory::try_with_capacity;

const MEMBER_LIMIT: usize = 4096;

/// Characters of a text member.
const TEXT_LIMIT: u64 = 16 << 20;

/// Deflate encodes at most 258 bytes in two bits.
const MAX_INFLATION: u64 = 1032;

/// Whether an archive holds texts of this program: a schema, as its fields and runs do, and a scene, as runs do.
pub(super) fn own_parts(bytes: &[u8]) -> [bool; 2] {
    ZipArchive::new(Cursor::new(bytes)).map_or([false; 2], |zip| {
        ["schema.npy", "scene.npy"].map(|name| zip.index_for_name(name).is_some())
    })
}

/// Checks that the header before a member, at `start`, has the name that the archive's directory
/// gives it; where they differ, one of the two belongs to another array.
fn check_local_name(archive: &[u8], start: u64, name: &[u8]) -> Result<(), InputFault> {
    const LENGTH: usize = 26;
    const NAME: usize = 30;
    let header = archive.get(start as usize..).unwrap_or_default();
    let length = header.get(LENGTH..).and_then(<[u8]>::first_chunk);
    let length = length.map_or(0, |bytes| usize::from(u16::from_le_bytes(*bytes)));
    let found = header.get(NAME..NAME + length).unwrap_or_default();
    if found == name {
        return Ok(());
    }
    let text = String::from_utf8_lossy;
    Err(InputFault::MemberName {
        directory: text(name).into_owned(),
        local: text(found).into_owned(),
    })
}

/// Reads members of the archive at `path`.
pub(crate) fn read_members<T>(
    path: &Path,
    read: impl FnOnce(&mut Archive<'_>) -> Result<T>,
) -> Result<T> {
    let options = OpenOptions::default();
    let source = FileSource {
        path,
        bytes: map(path)?,
        options: &options,
        stated: Sidecar::default(),
    };
    let mut archive = Archive::open(&source).map_err(|fault| source.fault(fault))?;
    read(&mut archive)
}

struct ArchiveMember {
    /// Without its `.npy`.
    name: String,
    index: usize,
}

/// The members of an archive.
pub(crate) struct Archive<'a> {
    source: &'a FileSource<'a>,
    zip: ZipArchive<Cursor<&'a [u8]>>,
    members: Vec<ArchiveMember>,
}

impl<'a> Archive<'a> {
    pub(super) fn open(source: &'a FileSource<'a>) -> Result<Self, InputFault> {
        let zip = ZipArchive::new(Cursor::new(&source.bytes[..])).map_err(archive_fault)?;
        if zip.len() > MEMBER_LIMIT {
            return Err(InputFault::TooManyMembers {
                found: zip.len(),
                limit: MEMBER_LIMIT,
            });
        }
        if zip.has_duplicate_names() {
            return Err(InputFault::Archive {
                reason: "two members have the same name".into(),
            });
        }
        let names = zip.file_names_raw().enumerate();
        let members = names
            .filter_map(|(index, name)| {
                let name = name.strip_suffix(b".npy")?;
                let name = String::from_utf8_lossy(name).into_owned();
                Some(ArchiveMember { name, index })
            })
            .collect();
        Ok(Archive {
            source,
            zip,
            members,
        })
    }

    /// The members, by their places, as arrays; short texts among them are attributes, too.
    ///
    /// # Errors
    /// A member that is damaged and whose name says something about the field.
    pub(super) fn container(&mut self) -> Result<Container> {
        let mut container = Container::new(Format::Npz, &(Arc::clone(&self.source.bytes) as _));
        for index in 0..self.members.len() {
            let name = self.members[index].name.clone();
            let matters = Statements::default().is_one(&name)
                || [Meaning::Time, Meaning::Position, Meaning::Field]
                    .into_iter()
                    .any(|meaning| known_as(&name, meaning).is_some());
            let found = self.header(index);
            let fault = found.as_ref().err();
            let is_other = fault.is_some_and(is_other_kind);
            if let Some(fault) = fault.filter(|_| matters && !is_other) {
                return Err(self.member_fault(index, fault.clone()));
            }
            let text = is_other
                .then(|| self.short_text(index))
                .transpose()?
                .flatten();
            if is_other && matters && text.is_none() {
                self.check_whole(index)?;
            }
            let mut variable = match found {
                Ok(header) => header.variable(name.clone()),
                Err(_) => Variable {
                    path: name.clone(),
                    dimensions: Vec::new(),
                    sample_type: SampleType::Other(
                        if is_other { "no numbers" } else { "unreadable" }.into(),
                    ),
                    attributes: Attributes::default(),
                    place: Place::Encoded { rows: 1 },
                },
            };
            if !self.is_stored(index) {
                variable.place = Place::Encoded { rows: 1 };
            }
            container.push(variable);
            if let Some(text) = text {
                container.attributes.insert_text(name, text);
            }
        }
        Ok(container)
    }

    /// The text of a member; `None` for what is no text, or a long one.
    fn short_text(&mut self, index: usize) -> Result<Option<String>> {
        const SHORT: u64 = 1000;
        let header = self
            .prefix(index)
            .and_then(|prefix| npy::Header::parse_text(&prefix));
        match header {
            Ok(header) if header.shape[0] <= SHORT => self.text_at(index).map(Some),
            _ => Ok(None),
        }
    }

    pub(super) fn is_stored(&mut self, index: usize) -> bool {
        let entry = self.zip.by_index_raw(self.members[index].index);
        entry.is_ok_and(|entry| entry.compression() == CompressionMethod::Stored)
    }

    /// The stored numbers of a member, each as `of` reads them.
    pub(super) fn numbers<T>(
        &mut self,
        index: usize,
        of: impl Fn(Sample, ByteOrder, &[u8]) -> T,
    ) -> Result<Vec<T>> {
        let (header, bytes, start) = self.load(index)?;
        let length = header.data_len().unwrap_or(0) as usize;
        let numbers = bytes.as_slice()[start..start + length].chunks_exact(header.sample.bytes());
        Ok(numbers
            .map(|one| of(header.sample, header.order, one))
            .collect())
    }

    /// Shape and samples of a member, row-major, where there is one of this name.
    pub(crate) fn array(&mut self, name: &str) -> Result<Option<(Vec<u64>, Vec<f64>)>> {
        let Some(index) = self.find(name) else {
            return Ok(None);
        };
        let (header, storage) = self.storage(index)?;
        let [rows, columns] = header.lengths();
        let mut values = vec![0.0; rows * columns];
        storage.read(0..rows, 0..columns, false, &mut values);
        Ok(Some((header.shape, values)))
    }

    /// A member of at most two dimensions, as `(first, second)`.
    fn storage(&mut self, index: usize) -> Result<(npy::Header, Storage)> {
        let (header, bytes, start) = self.load(index)?;
        if header.shape.len() > 2 {
            let shape = header.shape;
            return Err(self.member_fault(index, InputFault::Dimensions { shape }));
        }
        let strides = header.strides();
        let stride = |d: usize| {
            strides
                .get(d)
                .copied()
                .unwrap_or(header.sample.bytes() as u64)
        };
        let strides = [0, 1].map(|d| stride(d) as isize);
        let numbers = (header.sample, header.order);
        let storage = Storage::of_strides(bytes, numbers, start, header.lengths(), strides);
        Ok((header, storage))
    }

    /// A fault of the member of this name, or of the archive where there is none.
    pub(crate) fn fault(&self, name: &str, fault: InputFault) -> Error {
        match self.find(name) {
            Some(index) => self.member_fault(index, fault),
            None => self.source.fault(fault),
        }
    }

    /// The last of `n_sites` bodies of a run that moves, or is out of place, in its first sample;
    /// the first body where none is, since then the first end is driven. `None` for another number
    /// of bodies.
    pub(super) fn struck(&mut self, n_sites: usize) -> Result<Option<usize>> {
        let mut last = None;
        for name in ["velocity", "displacement"] {
            let Some(index) = self.find(name) else {
                continue;
            };
            let (header, storage) = self.storage(index)?;
            if header.lengths()[1] != n_sites {
                return Ok(None);
            }
            let mut first = vec![0.0; n_sites];
            storage.read(0..1, 0..n_sites, false, &mut first);
            last = last.max(first.iter().rposition(|&v| v != 0.0));
        }
        match last {
            Some(last) => Ok(Some(last)),
            None => self.driven().map(Some),
        }
    }

    /// The body that the scene of a run drives, by default the first.
    fn driven(&mut self) -> Result<usize> {
        let scene = self.text("scene")?.unwrap_or_default();
        let scene = scene.parse::<toml::Table>().unwrap_or_default();
        let site = scene.get("drive_site").and_then(toml::Value::as_integer);
        Ok(site.and_then(|site| site.try_into().ok()).unwrap_or(0))
    }

    fn find(&self, name: &str) -> Option<usize> {
        self.members.iter().position(|member| member.name == name)
    }

    fn header(&mut self, index: usize) -> Result<npy::Header, InputFault> {
        npy::Header::parse(&self.prefix(index)?)
    }

    fn prefix(&mut self, index: usize) -> Result<Vec<u8>, InputFault> {
        let mut prefix = Vec::new();
        self.reader(index)?
            .take(npy::PREFIX_LIMIT)
            .read_to_end(&mut prefix)
            .map_err(deflate_fault)?;
        Ok(prefix)
    }

    fn reader(&mut self, index: usize) -> Result<impl Read + '_, InputFault> {
        let options = ZipReadOptions::new().ignore_crc32(true);
        let reader = self
            .zip
            .by_index_with_options(self.members[index].index, options)
            .map_err(archive_fault)?;
        check_local_name(&self.source.bytes, reader.header_start(), reader.name_raw())?;
        Ok(reader)
    }

    /// The header of a member, the bytes that hold its samples, and where these start.
    pub(super) fn load(&mut self, index: usize) -> Result<(npy::Header, Bytes, usize)> {
        let header = self.header(index).and_then(|header| {
            if !header.shape.is_empty() {
                header.check_samples()?;
            }
            let expected = header.file_len()?;
            Ok((header, expected))
        });
        let (header, expected) = header.map_err(|fault| self.member_fault(index, fault))?;
        let (bytes, start) = self.bytes(index, expected)?;
        let start = start + header.data_start;
        Ok((header, bytes, start))
    }

    /// The text of a member, where there is one of this name.
    pub(crate) fn text(&mut self, name: &str) -> Result<Option<String>> {
        let index = self.find(name);
        index.map(|index| self.text_at(index)).transpose()
    }

    fn text_at(&mut self, index: usize) -> Result<String> {
        let header = self.prefix(index).and_then(|prefix| {
            let header = npy::Header::parse_text(&prefix)?;
            let (found, limit) = (header.shape[0], TEXT_LIMIT);
            match found > limit {
                true => Err(InputFault::TextLength { found, limit }),
                false => Ok((header.file_len()?, header)),
            }
        });
        let (expected, header) = header.map_err(|fault| self.member_fault(index, fault))?;
        let (bytes, start) = self.bytes(index, expected)?;
        let range = start + header.data_start..start + expected as usize;
        let text = header.text(&bytes.as_slice()[range]);
        text.map_err(|fault| self.member_fault(index, fault))
    }

    /// That a member of another kind is not one whose header was damaged; none of many bytes is read for that.
    fn check_whole(&mut self, index: usize) -> Result<()> {
        const MOST: u64 = 16 << 20;
        let read = |zip: &mut ZipArchive<_>, index| {
            let mut entry = zip.by_index(index).map_err(archive_fault)?;
            if entry.size() <= MOST {
                std::io::copy(&mut entry, &mut std::io::sink()).map_err(deflate_fault)?;
            }
            Ok(())
        };
        read(&mut self.zip, self.members[index].index)
            .map_err(|fault| self.member_fault(index, fault))
    }

    /// The bytes that hold a member of `expected` bytes, and where it starts in them.
    fn bytes(&mut self, index: usize, expected: u64) -> Result<(Bytes, usize)> {
        let place = self.place(index, expected);
        match place.map_err(|fault| self.member_fault(index, fault))? {
            Packed::Stored { range, checksum } => {
                let file = &self.source.bytes;
                let mut hasher = crc32fast::Hasher::new();
                file.stream(range.clone(), |chunk| hasher.update(chunk));
                check_sum(checksum, hasher).map_err(|fault| self.member_fault(index, fault))?;
                Ok((Bytes::File(Arc::clone(file)), range.start))
            }
            Packed::Deflated { len, checksum } => {
                self.source.allow("the inflated member", len as u64)?;
                let mut bytes = try_with_capacity(len).map_err(|refused| Error::Read {
                    path: self.source.path.to_owned(),
                    action: "hold the inflated samples of",
                    source: refused.into(),
                })?;
                self.inflate(index, len, checksum, &mut bytes)
                    .map_err(|fault| self.member_fault(index, fault))?;
                Ok((Bytes::Inflated(Arc::new(bytes)), 0))
            }
        }
    }

    /// Where the bytes of a member are, once the lengths in the archive agree with its header.
    fn place(&mut self, index: usize, expected: u64) -> Result<Packed, InputFault> {
        let file_len = self.source.bytes.len();
        let entry = self
            .zip
            .by_index_raw(self.members[index].index)
            .map_err(archive_fault)?;
        let checksum = entry.crc32();
        let (size, packed) = (entry.size(), entry.compressed_size());
        let start = entry.data_start().unwrap_or(u64::MAX);
        let end = start.saturating_add(packed);
        if end > file_len as u64 {
            return Err(InputFault::Truncated {
                expected: end,
                found: file_len as u64,
            });
        }
        if entry.compression() == CompressionMethod::Stored {
            npy::check_len(expected, packed)?;
            let range = start as usize..end as usize;
            return Ok(Packed::Stored { range, checksum });
        }
        let possible = packed.saturating_mul(MAX_INFLATION);
        let found = size.min(possible);
        if found != expected {
            return Err(InputFault::InflatedSize { expected, found });
        }
        let len = expected as usize;
        Ok(Packed::Deflated { len, checksum })
    }

    fn inflate(
        &mut self,
        index: usize,
        len: usize,
        checksum: u32,
        bytes: &mut Vec<u8>,
    ) -> Result<(), InputFault> {
        // Pages of the file would count beside what they are inflated to.
        const CHUNK: usize = 16 << 20;
        let file = Arc::clone(&self.source.bytes);
        let mut reader = self.reader(index)?;
        loop {
            let left = CHUNK.min(len - bytes.len());
            let read = reader.by_ref().take(left as u64).read_to_end(bytes);
            let read = read.map_err(deflate_fault)?;
            file.release(0..file.len());
            if read == 0 {
                break;
            }
        }
        let beyond = reader.read(&mut [0]).map_err(deflate_fault)?;
        let (expected, found) = (len as u64, (bytes.len() + beyond) as u64);
        if found != expected {
            return Err(InputFault::InflatedSize { expected, found });
        }
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(bytes);
        check_sum(checksum, hasher)
    }

    pub(super) fn member_fault(&self, index: usize, fault: InputFault) -> Error {
        self.source.fault(InputFault::Member {
            member: self.members[index].name.clone(),
            fault: Box::new(fault),
        })
    }
}

/// Whether a member is sound, but of another kind than what is looked for.
fn is_other_kind(fault: &InputFault) -> bool {
    use InputFault::*;
    matches!(
        fault,
        PickledObjects
            | StructuredType { .. }
            | ComplexType { .. }
            | SampleType { .. }
            | NoText { .. }
            | NotOneText { .. }
            | TextLength { .. }
    )
}

enum Packed {
    Stored { range: Range<usize>, checksum: u32 },
    Deflated { len: usize, checksum: u32 },
}

fn check_sum(expected: u32, hasher: crc32fast::Hasher) -> Result<(), InputFault> {
    let found = hasher.finalize();
    if found == expected {
        Ok(())
    } else {
        Err(InputFault::Checksum { expected, found })
    }
}

fn deflate_fault(error: std::io::Error) -> InputFault {
    InputFault::Deflate {
        reason: error.to_string(),
    }
}

fn archive_fault(error: ZipError) -> InputFault {
    match error {
        ZipError::CompressionMethodNotSupported(method) => InputFault::Compression { method },
        ZipError::UnsupportedArchive(ZipError::PASSWORD_REQUIRED) => InputFault::Encrypted,
        other => InputFault::Archive {
            reason: other.to_string(),
        },
    }
}
