//! Arrays in NumPy's `.npz` archives: zip files of `.npy` members.
//!
//! A stored member stays where it is in the file. A deflated one is inflated when it is read, to exactly the bytes
//! that its own header promises, and not one more.

use std::io::{Cursor, Read, sink};
use std::sync::Arc;

use zip::CompressionMethod;
use zip::read::{ZipArchive, ZipReadOptions};
use zip::result::ZipError;

use crate::container::MAX_INFLATION;
use crate::npy::{self, Header};
use crate::{ByteOrder, Bytes, Container, Error, Format, Options, Result, Shared, Variable};

const MOST_MEMBERS: usize = 4096;
/// Characters of a text, and those of one that is an attribute.
const LONGEST_TEXT: u64 = 16 << 20;
const SHORT_TEXT: u64 = 1000;
/// Pages of the file would count beside what they are inflated to.
const CHUNK: u64 = 16 << 20;

/// Whether an archive has a member of each name.
pub fn has_members<const N: usize>(archive: &[u8], names: [&str; N]) -> [bool; N] {
    ZipArchive::new(Cursor::new(archive)).map_or([false; N], |zip| {
        names.map(|name| zip.index_for_name(&format!("{name}.npy")).is_some())
    })
}

/// Opens a file of `format`. A member that holds no numbers is listed by what it holds, a short text is an attribute,
/// too; a damaged one is listed with its fault.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let zip = ZipArchive::new(Cursor::new(Shared(Arc::clone(&bytes)))).map_err(fault)?;
    if zip.len() > MOST_MEMBERS {
        let what = format!("an archive of more than {MOST_MEMBERS} members");
        return Err(Error::unsupported(what, "save the field by itself"));
    }
    if zip.has_duplicate_names() {
        let expected = "a name of its own for each member";
        return Err(Error::damaged("the archive", expected, "two of one name"));
    }
    let mut container = Container::new(format, &bytes);
    for (index, name) in zip.file_names_raw().enumerate() {
        let Some(name) = name.strip_suffix(b".npy") else {
            continue;
        };
        let name = String::from_utf8_lossy(name).into_owned();
        let member = Member {
            zip: zip.clone(),
            index,
            file: Arc::clone(&bytes),
            memory: options.memory,
        };
        let place = format!("member {name:?}");
        let within = move |fault: Error| fault.within(&place);
        match member.prefix().map(|prefix| Header::parse(&prefix)) {
            Ok(Ok(header)) if header.is_text => {
                let is_short = header.shape[0] <= SHORT_TEXT;
                let text = move || member.text(&header).map_err(&within);
                if is_short {
                    let text = text()?;
                    let text = String::from_utf8_lossy((*text).as_ref());
                    container.attributes.insert_text(&*name, text);
                }
                container.push_in(Variable::other(name, Vec::new(), "text"), text);
            }
            Ok(Ok(header)) => {
                let variable = header.variable(&name, member.place());
                let unpack = move || member.bytes(&header).map_err(&within);
                container.push_in(variable, unpack);
            }
            // Sound but something else, unless damage makes it look so.
            Ok(Err(Error::Unsupported { .. })) => match member.check() {
                Ok(()) => container.push(Variable::other(name, Vec::new(), "no numbers")),
                Err(fault) => container.push_damaged(name, within(fault)),
            },
            Ok(Err(fault)) | Err(fault) => container.push_damaged(name, within(fault)),
        }
    }
    Ok(container)
}

/// A member of an archive.
struct Member {
    zip: ZipArchive<Cursor<Shared>>,
    index: usize,
    file: Bytes,
    memory: Option<u64>,
}

impl Member {
    /// The byte of the file before it, if it is stored.
    fn place(&self) -> Option<u64> {
        let mut zip = self.zip.clone();
        let entry = zip.by_index_raw(self.index).ok()?;
        let is_stored = entry.compression() == CompressionMethod::Stored;
        is_stored.then(|| entry.data_start().unwrap_or(u64::MAX))
    }

    /// The bytes that hold its header.
    fn prefix(&self) -> Result<Vec<u8>> {
        let mut prefix = Vec::new();
        // The sum is that of all of it.
        self.read(ZipReadOptions::new().ignore_crc32(true), |entry| {
            entry.take(npy::PREFIX).read_to_end(&mut prefix)
        })?;
        Ok(prefix)
    }

    /// The bytes in which the array lies: those of the file, or inflated, once lengths and checksum agree.
    fn bytes(&self, header: &Header) -> Result<Bytes> {
        let (expected, length) = (header.file_len()?, (*self.file).as_ref().len() as u64);
        let mut zip = self.zip.clone();
        let entry = zip.by_index_raw(self.index).map_err(fault)?;
        let (size, packed) = (entry.size(), entry.compressed_size());
        let start = entry.data_start().unwrap_or(u64::MAX);
        let end = start.saturating_add(packed);
        if end > length {
            return Err(npy::too_short(end, length));
        }
        if entry.compression() == CompressionMethod::Stored {
            header.check_len(packed)?;
            self.whole(|chunk| std::io::copy(chunk, &mut sink()))?;
            return Ok(Arc::clone(&self.file));
        }
        let inflated = |found: u64| {
            let wrong = (found != expected).then_some(found);
            let expected = format!("{expected} bytes once inflated");
            wrong.map_or(Ok(()), |found| {
                Err(Error::damaged("the array", expected, found))
            })
        };
        inflated(size.min(packed.saturating_mul(MAX_INFLATION)))?;
        let memory = |allowed| Error::Memory {
            what: "the inflated member".into(),
            needed: expected,
            allowed,
        };
        if let Some(allowed) = self.memory.filter(|allowed| *allowed < expected) {
            return Err(memory(allowed));
        }
        let mut out = Vec::new();
        let reserved = out.try_reserve_exact(expected as usize + 1);
        reserved.map_err(|_| memory(0))?;
        self.whole(|chunk| {
            let left = expected + 1 - out.len() as u64;
            let read = chunk.take(left).read_to_end(&mut out)?;
            Ok(read as u64)
        })?;
        inflated(out.len() as u64)?;
        Ok(Arc::new(out))
    }

    /// The text in UTF-8.
    fn text(&self, header: &Header) -> Result<Bytes> {
        let characters = header.shape[0];
        if characters > LONGEST_TEXT {
            let what = format!("a text of more than {LONGEST_TEXT} characters");
            return Err(Error::unsupported(what, "save a shorter one"));
        }
        let bytes = self.bytes(header)?;
        let start = self.place().unwrap_or(0) as usize + header.start;
        let text = &(*bytes).as_ref()[start..][..4 * characters as usize];
        Ok(Arc::new(header.text(text)?.into_bytes()))
    }

    /// Checks the sum of all bytes, if these are few.
    fn check(&self) -> Result<()> {
        let mut zip = self.zip.clone();
        let size = zip.by_index_raw(self.index).map_err(fault)?.size();
        match size <= CHUNK {
            true => self.whole(|chunk| std::io::copy(chunk, &mut sink())),
            false => Ok(()),
        }
    }

    /// Has `take` read all bytes, a chunk at a time, and checks their sum.
    fn whole(&self, mut take: impl FnMut(&mut dyn Read) -> std::io::Result<u64>) -> Result<()> {
        let length = (*self.file).as_ref().len();
        self.read(ZipReadOptions::new(), |mut entry| {
            while take(&mut (&mut entry).take(CHUNK))? > 0 {
                self.file.release(0..length);
            }
            Ok(())
        })
    }

    fn read<T>(
        &self,
        options: ZipReadOptions,
        of: impl FnOnce(&mut dyn Read) -> std::io::Result<T>,
    ) -> Result<T> {
        let mut zip = self.zip.clone();
        let entry = zip.by_index_with_options(self.index, options);
        let mut entry = entry.map_err(fault)?;
        let archive = (*self.file).as_ref();
        check_local_name(archive, entry.header_start(), entry.name_raw())?;
        of(&mut entry).map_err(|cause| Error::damaged("its bytes", "sound ones", cause))
    }
}

/// Checks that the header before a member, at `start`, has the name that the archive's directory
/// gives it; where they differ, one of the two belongs to another array.
fn check_local_name(archive: &[u8], start: u64, name: &[u8]) -> Result<()> {
    const LENGTH: usize = 26;
    const NAME: usize = 30;
    let header = archive.get(start as usize..).unwrap_or_default();
    let length = header.get(LENGTH..LENGTH + 2).unwrap_or_default();
    let length = ByteOrder::Little.unsigned(length) as usize;
    let found = header.get(NAME..NAME + length).unwrap_or_default();
    match found == name {
        true => Ok(()),
        false => {
            let [found, name] = [found, name].map(String::from_utf8_lossy);
            let expected = format!("the name {name:?} that the directory gives it");
            Err(Error::damaged("the header before it", expected, found))
        }
    }
}

fn fault(error: ZipError) -> Error {
    match error {
        ZipError::CompressionMethodNotSupported(method) => Error::unsupported(
            format!("the compression method {method}"),
            "write it with `numpy.savez` or `numpy.savez_compressed`",
        ),
        ZipError::UnsupportedArchive(ZipError::PASSWORD_REQUIRED) => {
            Error::unsupported("encrypted bytes", "decrypt the archive first")
        }
        other => Error::damaged("the archive", "a whole zip archive", other),
    }
}
