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

use super::beside::{self, Beside};
use super::coordinates::{Coordinates, Listed};
use super::open::{Contents, FileSource, map};
use super::options::OpenOptions;
use super::scan::NamedNumber;
use super::sidecar::Sidecar;
use super::storage::Bytes;
use super::{Layout, Note, Quantity, VariableInfo, graded_masses, names, npy};
use crate::error::{Error, InputFault, MemberShape, Result};
use crate::system::memory::try_with_capacity;

const MEMBER_LIMIT: usize = 4096;

/// Characters of a text member.
const TEXT_LIMIT: u64 = 16 << 20;

/// Deflate encodes at most 258 bytes in two bits.
const MAX_INFLATION: u64 = 1032;

/// The field of an archive, with the axes that its other members state.
pub(super) fn read(source: &FileSource) -> Result<Contents> {
    let mut archive = Archive::open(source).map_err(|fault| source.fault(fault))?;
    let index = archive
        .choose(source.options.variable.as_deref())
        .map_err(|fault| source.fault(fault))?;
    let (header, bytes, start) = archive.load(index)?;
    let name = archive.members[index].name.clone();
    // Contacts are between sites and may be fewer.
    let along = match archive.find("contact_position") {
        Some(_) if matches!(name.as_str(), "force" | "energy_passed") => &["contact_position"][..],
        _ => &names::SPACE,
    };
    let time = archive.coordinates("time", &names::TIME, index)?;
    let space = archive.coordinates("space", along, index)?;
    let lengths = [&time, &space].map(|member| member.as_ref().map(|member| member.len));
    let implied = match header.shape[..] {
        [rows, columns] => implied_layout([rows, columns], lengths),
        _ => None,
    };
    let stated = &source.stated;
    let layout = stated.layout.or(implied).unwrap_or_default();
    let mut places = |name: &str| {
        let (shape, values) = archive.array(name).ok()??;
        (shape.len() == 1).then(|| (values, archive.unit(name).ok().flatten()))
    };
    source.check_at(&header)?;
    let at = &source.options.at;
    let contents = Contents::from_npy_at(&header, bytes, start, layout, at, &mut places);
    let mut contents = contents.map_err(|fault| archive.member_fault(index, fault))?;
    contents.quantity = quantity(&name);
    contents.unit = archive.unit(&name)?;
    if archive.find("schema").is_some() {
        contents.dispersion = archive.text("dispersion")?;
    }
    if is_run(&source.bytes) {
        contents.struck = archive.struck(contents.n_sites)?;
        let bodies = archive
            .array("mass")?
            .zip(archive.array("contact_coefficient")?);
        let bodies = bodies.filter(|((_, masses), _)| masses.len() == contents.n_sites);
        contents.masses = bodies.and_then(|((_, m), (_, c))| graded_masses(&m, &c));
    }
    // Coordinates that are stated in full are left unread.
    let time = time.filter(|_| stated.t0.is_none() || stated.dt.is_none());
    let space = space.filter(|_| stated.x0.is_none() || stated.dx.is_none());
    if let Some(member) = &time {
        let time = archive.axis(member, contents.n_times, stated.dt.is_some())?;
        contents.time = time.even;
        contents.notes.extend(time.note);
        contents.resampling[0] = time.resampling;
    }
    if let Some(member) = &space {
        let space = archive.axis(member, contents.n_sites, stated.dx.is_some())?;
        contents.space = space.even;
        contents.notes.extend(space.note);
        contents.resampling[1] = space.resampling;
    }
    if archive.find("schema").is_none() {
        beside::complete(&mut contents, stated, &mut |name| archive.beside(name))?;
        let own = |member: &Option<Coordinate>| member.as_ref().map(|member| member.name.clone());
        contents.notes.push(Note::Members {
            field: name,
            time: own(&time),
            space: own(&space),
        });
        if stated.layout.is_none() && implied == Some(Layout::SiteTime) {
            contents.notes.push(Note::Layout {
                layout: Layout::SiteTime,
            });
        }
        contents.note_doubts(stated.layout.or(implied).is_some());
    }
    Ok(contents)
}

/// The arrays of an archive.
pub(super) fn members(source: &FileSource) -> Result<Vec<VariableInfo>> {
    let mut archive = Archive::open(source).map_err(|fault| source.fault(fault))?;
    let infos = (0..archive.members.len()).map(|index| {
        let header = archive.header(index);
        let is_stored = archive
            .zip
            .by_index_raw(archive.members[index].index)
            .is_ok_and(|entry| entry.compression() == CompressionMethod::Stored);
        let lengths = |header: &npy::Header| {
            let lengths: Vec<String> = header.shape.iter().map(u64::to_string).collect();
            lengths.join(", ")
        };
        VariableInfo {
            path: archive.members[index].name.clone(),
            dimensions: header.as_ref().map(lengths).unwrap_or_default(),
            sample: header
                .as_ref()
                .map_or("no numbers", |header| header.sample.name())
                .to_owned(),
            is_in_place: is_stored,
            coordinates: Vec::new(),
            attributes: Vec::new(),
        }
    });
    Ok(infos.collect())
}

/// Members of one number that may be a position.
pub(super) fn positions(source: &FileSource, asked: Option<&str>) -> Result<Vec<NamedNumber>> {
    let mut archive = Archive::open(source).map_err(|fault| source.fault(fault))?;
    let names: Vec<String> = archive
        .members
        .iter()
        .map(|member| member.name.clone())
        .collect();
    let mut found = Vec::new();
    for (index, name) in names.into_iter().enumerate() {
        let is_it = match asked {
            Some(asked) => asked == name,
            None => names::POSITION.contains(&name.as_str()),
        };
        let count = archive
            .header(index)
            .map(|header| header.shape.iter().product::<u64>());
        if !is_it || count.ok() != Some(1) {
            continue;
        }
        let value = archive.number(index)?;
        let sample = archive.header(index).map(|header| header.sample);
        let relative = sample.map_or(f64::EPSILON, |sample| sample.relative_rounding());
        found.push(NamedNumber {
            unit: archive.unit(&name)?,
            name,
            value,
            rounding: relative * value.abs(),
        });
    }
    Ok(found)
}

/// The layout that the lengths of times and positions leave, where they leave one.
fn implied_layout([rows, columns]: [u64; 2], [times, sites]: [Option<u64>; 2]) -> Option<Layout> {
    let fits =
        |n_times, n_sites| times.is_none_or(|n| n == n_times) && sites.is_none_or(|n| n == n_sites);
    match (fits(rows, columns), fits(columns, rows)) {
        (true, false) => Some(Layout::TimeSite),
        (false, true) => Some(Layout::SiteTime),
        _ => None,
    }
}

/// Whether an archive is a run file or a field that this program wrote: it holds a schema.
pub(super) fn is_own(bytes: &[u8]) -> bool {
    ZipArchive::new(Cursor::new(bytes)).is_ok_and(|zip| zip.index_for_name("schema.npy").is_some())
}

/// Whether an archive is a run file: it holds a scene and a schema.
pub(super) fn is_run(bytes: &[u8]) -> bool {
    let has = |zip: &ZipArchive<_>, name| zip.index_for_name(name).is_some();
    ZipArchive::new(Cursor::new(bytes))
        .is_ok_and(|zip| has(&zip, "scene.npy") && has(&zip, "schema.npy"))
}

/// Whether an archive is a field that this program wrote: it holds a schema and no scene.
pub(super) fn is_field(bytes: &[u8]) -> bool {
    let has = |zip: &ZipArchive<_>, name| zip.index_for_name(name).is_some();
    ZipArchive::new(Cursor::new(bytes))
        .is_ok_and(|zip| !has(&zip, "scene.npy") && has(&zip, "schema.npy"))
}

/// The quantity of a member, if its name is that of one.
fn quantity(member: &str) -> Option<Quantity> {
    Quantity::ALL
        .into_iter()
        .find(|quantity| quantity.name() == member)
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

/// A member that holds the coordinates of an axis.
struct Coordinate {
    axis: &'static str,
    index: usize,
    name: String,
    len: u64,
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
    fn open(source: &'a FileSource<'a>) -> Result<Self, InputFault> {
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

    /// Shape and samples of a member, row-major, where there is one of this name.
    pub(crate) fn array(&mut self, name: &str) -> Result<Option<(Vec<u64>, Vec<f64>)>> {
        let Some(index) = self.find(name) else {
            return Ok(None);
        };
        let (header, bytes, start) = self.load(index)?;
        let contents = Contents::from_npy(&header, bytes, start, Layout::TimeSite)
            .map_err(|fault| self.member_fault(index, fault))?;
        let (rows, columns) = (contents.n_times, contents.n_sites);
        let mut values = vec![0.0; rows * columns];
        contents
            .storage
            .read(0..rows, 0..columns, false, &mut values);
        Ok(Some((header.shape, values)))
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
    fn struck(&mut self, n_sites: usize) -> Result<Option<usize>> {
        let mut last = None;
        for name in ["velocity", "displacement"] {
            let Some(index) = self.find(name) else {
                continue;
            };
            let (header, bytes, start) = self.load(index)?;
            let contents = Contents::from_npy(&header, bytes, start, Layout::TimeSite)
                .map_err(|fault| self.member_fault(index, fault))?;
            if contents.n_sites != n_sites || contents.n_times == 0 {
                return Ok(None);
            }
            let mut first = vec![0.0; n_sites];
            contents.storage.read(0..1, 0..n_sites, false, &mut first);
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

    /// The member of an axis by its name; under a short name only an array of one dimension is one.
    fn coordinates(
        &mut self,
        axis: &'static str,
        known: &[&str],
        field: usize,
    ) -> Result<Option<Coordinate>> {
        for (rank, name) in known.iter().enumerate() {
            let same = |member: &ArchiveMember| match rank {
                0 => member.name == *name,
                _ => member.name.eq_ignore_ascii_case(name),
            };
            let found = self.members.iter().position(same).filter(|&i| i != field);
            let Some(index) = found else { continue };
            let shape = match self.header(index).map(|header| header.shape) {
                // What holds no numbers is no coordinate.
                Err(fault) if rank > 0 && is_other_kind(&fault) => {
                    self.check_whole(index)?;
                    continue;
                }
                shape => shape.map_err(|fault| self.member_fault(index, fault))?,
            };
            if rank == 0 || shape.len() == 1 {
                return Ok(Some(Coordinate {
                    axis,
                    index,
                    name: self.members[index].name.clone(),
                    len: shape.iter().product(),
                }));
            }
            self.check_whole(index)?;
        }
        Ok(None)
    }

    /// The number or the text of a member, by a name whose case does not matter.
    fn beside(&mut self, name: &str) -> Result<Option<Beside>> {
        let same = |member: &ArchiveMember| member.name.eq_ignore_ascii_case(name);
        let Some(index) = self.members.iter().position(same) else {
            return Ok(None);
        };
        let place = self.members[index].name.clone();
        let shape = match self.header(index) {
            Ok(header) => header.shape,
            Err(fault) if is_other_kind(&fault) => {
                let text = self.text_of(&place)?;
                let value = text.map(beside::Value::Text);
                return Ok(value.map(|value| Beside { place, value }));
            }
            Err(fault) => return Err(self.member_fault(index, fault)),
        };
        if shape.iter().product::<u64>() != 1 {
            return Ok(None);
        }
        let value = beside::Value::Number(self.number(index)?);
        Ok(Some(Beside { place, value }))
    }

    /// The only number of a member.
    fn number(&mut self, index: usize) -> Result<f64> {
        let header = self.header(index);
        let header = header.map_err(|fault| self.member_fault(index, fault))?;
        let header = npy::Header {
            shape: vec![1],
            ..header
        };
        let expected = header
            .file_len()
            .map_err(|fault| self.member_fault(index, fault))?;
        let (bytes, start) = self.bytes(index, expected)?;
        let start = start + header.data_start;
        let contents = Contents::from_npy(&header, bytes, start, Layout::TimeSite)
            .map_err(|fault| self.member_fault(index, fault))?;
        let mut value = [0.0];
        contents.storage.read(0..1, 0..1, false, &mut value);
        Ok(value[0])
    }

    /// The requested member, else `velocity` or `v`, else the only array of two dimensions.
    fn choose(&mut self, asked: Option<&str>) -> Result<usize, InputFault> {
        if let Some(asked) = asked {
            let name = asked.strip_suffix(".npy").unwrap_or(asked);
            return self.find(name).ok_or_else(|| InputFault::NoSuchMember {
                name: name.into(),
                members: self.shapes(),
            });
        }
        let [long, short] = names::FIELD;
        if let Some(index) = self.find(long) {
            return Ok(index);
        }
        let members = self.shapes();
        let is_short = |member: &MemberShape| member.name.eq_ignore_ascii_case(short);
        if let Some(index) = members.iter().position(is_short) {
            return Ok(index);
        }
        let is_matrix =
            |member: &MemberShape| member.shape.as_ref().is_some_and(|shape| shape.len() == 2);
        let mut matrices = (0..members.len()).filter(|&i| is_matrix(&members[i]));
        match (matrices.next(), matrices.next(), members.len()) {
            (Some(index), None, _) => Ok(index),
            (None, None, 1) => Ok(0),
            _ => Err(InputFault::WhichMember { members }),
        }
    }

    fn shapes(&mut self) -> Vec<MemberShape> {
        (0..self.members.len())
            .map(|index| MemberShape {
                name: self.members[index].name.clone(),
                shape: self.header(index).ok().map(|header| header.shape),
            })
            .collect()
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
    fn load(&mut self, index: usize) -> Result<(npy::Header, Bytes, usize)> {
        let header = self.header(index).and_then(|header| {
            header.check_samples()?;
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
        let Some(index) = self.find(name) else {
            return Ok(None);
        };
        let header = self.prefix(index).and_then(|prefix| {
            let header = npy::TextHeader::parse(&prefix)?;
            if header.length > TEXT_LIMIT {
                return Err(InputFault::TextLength {
                    found: header.length,
                    limit: TEXT_LIMIT,
                });
            }
            Ok(header)
        });
        let header = header.map_err(|fault| self.member_fault(index, fault))?;
        let expected = header.file_len();
        let (bytes, start) = self.bytes(index, expected)?;
        let range = start + header.data_start..start + expected as usize;
        let text = header.decode(&bytes.as_slice()[range]);
        text.map(Some)
            .map_err(|fault| self.member_fault(index, fault))
    }

    /// The unit of a member as stated by the archive; `None` unless it is a text.
    fn unit(&mut self, member: &str) -> Result<Option<String>> {
        self.text_of(&format!("{member}_unit"))
    }

    /// As [`Archive::text`]; `None` for what is no text.
    fn text_of(&mut self, name: &str) -> Result<Option<String>> {
        match self.text(name) {
            Err(Error::Input {
                fault: InputFault::Member { fault, .. },
                ..
            }) if is_other_kind(&fault) => {
                if let Some(index) = self.find(name) {
                    self.check_whole(index)?;
                }
                Ok(None)
            }
            text => text,
        }
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
            Place::Stored { range, checksum } => {
                let file = &self.source.bytes;
                let mut hasher = crc32fast::Hasher::new();
                file.stream(range.clone(), |chunk| hasher.update(chunk));
                check_sum(checksum, hasher).map_err(|fault| self.member_fault(index, fault))?;
                Ok((Bytes::File(Arc::clone(file)), range.start))
            }
            Place::Deflated { len, checksum } => {
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
    fn place(&mut self, index: usize, expected: u64) -> Result<Place, InputFault> {
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
            return Ok(Place::Stored { range, checksum });
        }
        let possible = packed.saturating_mul(MAX_INFLATION);
        let found = size.min(possible);
        if found != expected {
            return Err(InputFault::InflatedSize { expected, found });
        }
        let len = expected as usize;
        Ok(Place::Deflated { len, checksum })
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

    /// What the coordinate member of an axis of `n` states, and what it deviates by.
    fn axis(&mut self, member: &Coordinate, n: usize, has_step: bool) -> Result<Listed> {
        let Coordinate {
            axis, index, name, ..
        } = member;
        let (axis, index) = (*axis, *index);
        let (header, bytes, start) = self.load(index)?;
        if header.shape != [n as u64] {
            let fault = InputFault::AxisLength {
                axis,
                expected: n as u64,
                found: header.shape.iter().product(),
            };
            return Err(self.member_fault(index, fault));
        }
        let record = Contents::from_npy(&header, bytes, start, Layout::TimeSite)
            .map_err(|fault| self.member_fault(index, fault))?;
        let mut values = vec![0.0; n];
        record.storage.read(0..n, 0..1, false, &mut values);
        let known = (header.sample.spacing(&values), None);
        let rules = (!has_step).then(|| self.source.options.evenness(axis));
        let mut listed = Coordinates::listed(axis, &values, known, rules)
            .map_err(|uneven| self.member_fault(index, uneven.fault(axis)))?;
        if !has_step {
            listed.even.unit = self.unit(name)?;
        }
        Ok(listed)
    }

    fn member_fault(&self, index: usize, fault: InputFault) -> Error {
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

enum Place {
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
