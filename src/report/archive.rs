//! `.npz` archives whose large arrays are written in blocks, in any order.
//!
//! A member's offset and size follow from its shape. Its bytes are reserved first, blocks are
//! written at their final offsets, and only the checksum is filled in at the end. Members are
//! stored, not deflated: spectra hardly shrink, and a stored member can be mapped by its reader.
//! Layout: PKWARE APPNOTE 6.3.10 (zip, zip64), NumPy enhancement proposal 1 (`.npy`).

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use super::samples::{Order, bytes_of, in_bytes};
use super::{ArrayFile, ArrayLabels};
use crate::arrays::Precision;
use crate::error::{Error, Result};
use crate::system::file_io::{allocate, begin_sync, read_at, write_at};

/// An archive being written.
#[derive(Debug)]
pub struct Archive {
    file: File,
    path: PathBuf,
    precision: Precision,
    state: Mutex<ArchiveState>,
}

#[derive(Debug, Default)]
struct ArchiveState {
    members: Vec<ArchiveEntry>,
    end: u64,
}

/// One array's place in the file.
#[derive(Debug, Clone)]
struct ArchiveEntry {
    name: String,
    /// Where the local header starts.
    header: u64,
    /// Where the member's content (the `.npy` header) starts.
    content: u64,
    /// Where the samples start.
    data: u64,
    end: u64,
    columns: usize,
    precision: Precision,
    /// Checksum of `content .. hashed`, as long as blocks come in order.
    checksum: crc32fast::Hasher,
    hashed: u64,
}

/// Samples start at multiples of this, so that readers can map them aligned.
const ALIGNMENT: u64 = 64;
const LOCAL_HEADER: u64 = 30;
const ZIP64_EXTRA: u64 = 20;
const LIMIT_32: u64 = u32::MAX as u64;

impl Archive {
    /// Creates the file `path`; arrays are stored in `precision`.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn create(path: &Path, precision: Precision) -> Result<Self> {
        let file = File::options()
            .read(true)
            .write(true)
            .create_new(true)
            .open(path)
            .map_err(Error::write("create", path))?;
        Ok(Archive {
            file,
            path: path.to_owned(),
            precision,
            state: Mutex::default(),
        })
    }

    /// Appends a text, which NumPy reads as an array of no dimension: `str(archive["scene"])`.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn append_text(&self, name: &str, text: &str) -> Result<()> {
        // NumPy has no text of no characters, and drops NULs at the end.
        let text = if text.is_empty() { "\0" } else { text };
        let characters = text.chars().count() as u64;
        let bytes: Vec<u8> = text
            .chars()
            .flat_map(|c| u32::from(c).to_le_bytes())
            .collect();
        let header = |content| npy_header(&format!("<U{characters}"), "()", content);
        let member = self.reserve_bytes(name, header, bytes.len() as u64, 1)?;
        self.write_bytes(member, 0, &bytes)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, ArchiveState> {
        self.state
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    fn reserve_bytes(
        &self,
        name: &str,
        npy_header: impl Fn(u64) -> Vec<u8>,
        bytes: u64,
        columns: usize,
    ) -> Result<usize> {
        let mut state = self.lock();
        let name = format!("{name}.npy");
        let header = state.end;
        let content = header + LOCAL_HEADER + name.len() as u64 + ZIP64_EXTRA;
        let npy = npy_header(content);
        let data = content + npy.len() as u64;
        let end = data + bytes;
        let failed = Error::write("reserve room in", &self.path);
        allocate(&self.file, header, end).map_err(failed)?;
        write_at(&self.file, &npy, content).map_err(Error::write("write to", &self.path))?;
        let mut checksum = crc32fast::Hasher::new();
        checksum.update(&npy);
        state.end = end;
        state.members.push(ArchiveEntry {
            name,
            header,
            content,
            data,
            end,
            columns,
            precision: self.precision,
            checksum,
            hashed: data,
        });
        Ok(state.members.len() - 1)
    }

    /// Writes at `offset` into the content of a member.
    fn write_bytes(&self, member: usize, offset: u64, bytes: &[u8]) -> Result<()> {
        let at = self.lock().members[member].data + offset;
        write_at(&self.file, bytes, at).map_err(Error::write("write to", &self.path))?;
        let member = &mut self.lock().members[member];
        if member.hashed == at {
            member.checksum.update(bytes);
            member.hashed = at + bytes.len() as u64;
        }
        Ok(())
    }

    /// The member's checksum; what came out of order is read back.
    fn checksum(&self, member: &ArchiveEntry) -> Result<u32> {
        if member.hashed == member.end {
            return Ok(member.checksum.clone().finalize());
        }
        let mut hasher = crc32fast::Hasher::new();
        let mut block = vec![0; 1 << 20];
        let mut at = member.content;
        while at < member.end {
            let length = block.len().min((member.end - at) as usize);
            read_at(&self.file, &mut block[..length], at)
                .map_err(Error::read("read back", &self.path))?;
            hasher.update(&block[..length]);
            at += length as u64;
        }
        Ok(hasher.finalize())
    }
}

impl ArrayFile for Archive {
    fn precision(&self) -> Precision {
        self.precision
    }

    fn reserve_array(&self, labels: &ArrayLabels, precision: Precision) -> Result<Option<usize>> {
        let (shape, item) = (labels.shape(), bytes_of(precision));
        let header = |content| npy_header(&format!("<f{item}"), &tuple(&shape), content);
        let bytes = shape.iter().product::<usize>() as u64 * item;
        let columns = shape.get(1).copied().unwrap_or(1);
        let member = self.reserve_bytes(labels.name, header, bytes, columns)?;
        self.lock().members[member].precision = precision;
        Ok(Some(member))
    }

    fn find_array(&self, name: &str) -> Option<(usize, usize)> {
        let members = &self.lock().members;
        let is_it = |member: &ArchiveEntry| member.name.strip_suffix(".npy") == Some(name);
        let place = members.iter().position(is_it)?;
        Some((place, members[place].columns))
    }

    fn write_samples(&self, member: usize, first: usize, values: &[f64]) -> Result<()> {
        let precision = self.lock().members[member].precision;
        let start = first as u64 * bytes_of(precision);
        in_bytes(values, precision, Order::Little, |at, bytes| {
            self.write_bytes(member, start + at, bytes)
        })
    }

    /// Fills in headers and checksums and writes the directory of members.
    fn finish(&self) -> Result<()> {
        let write = |bytes: &[u8], at: u64| {
            write_at(&self.file, bytes, at).map_err(Error::write("write to", &self.path))
        };
        let state = std::mem::take(&mut *self.lock());
        let mut directory = Vec::new();
        for member in &state.members {
            let checksum = self.checksum(member)?;
            write(&member.local_header(checksum), member.header)?;
            directory.extend(member.directory_entry(checksum));
        }
        let start = state.end;
        directory.extend(end_records(
            state.members.len() as u64,
            start,
            directory.len() as u64,
        ));
        write(&directory, start)?;
        let length = start + directory.len() as u64;
        self.file
            .set_len(length)
            .map_err(Error::write("finish", &self.path))?;
        begin_sync(&self.file);
        Ok(())
    }
}

/// A shape as Python writes it.
fn tuple(shape: &[usize]) -> String {
    let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
    match lengths.as_slice() {
        [one] => format!("({one},)"),
        all => format!("({})", all.join(", ")),
    }
}

/// The `.npy` header of a row-major array whose content starts at `content`, padded so that its
/// samples are aligned in the file.
pub(super) fn npy_header(descr: &str, shape: &str, content: u64) -> Vec<u8> {
    let fields = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    // Magic, version and length take 10 bytes; a newline ends the header.
    let plain = 10 + fields.len() as u64 + 1;
    let padding = (content + plain).next_multiple_of(ALIGNMENT) - (content + plain);
    let length = (fields.len() as u64 + padding + 1) as u16;
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend(length.to_le_bytes());
    header.extend(fields.as_bytes());
    header.extend(std::iter::repeat_n(b' ', padding as usize));
    header.push(b'\n');
    header
}

impl ArchiveEntry {
    fn size(&self) -> u64 {
        self.end - self.content
    }

    /// Version 4.5 (zip64), UTF-8 names, stored, 1980-01-01: the bytes depend on the data alone.
    fn common_fields(&self, checksum: u32) -> Vec<u8> {
        let size = self.size().min(LIMIT_32) as u32;
        let mut fields = Vec::new();
        for word in [45u16, 0x0800, 0, 0, 0x0021] {
            fields.extend(word.to_le_bytes());
        }
        for word in [checksum, size, size] {
            fields.extend(word.to_le_bytes());
        }
        fields.extend((self.name.len() as u16).to_le_bytes());
        fields
    }

    fn local_header(&self, checksum: u32) -> Vec<u8> {
        let mut header = b"PK\x03\x04".to_vec();
        header.extend(self.common_fields(checksum));
        header.extend((ZIP64_EXTRA as u16).to_le_bytes());
        header.extend(self.name.as_bytes());
        // Where the size fits 32 bits the field is kept as padding under a private tag, since a
        // zip64 field must not repeat a size that is given elsewhere.
        let tag: u16 = if self.size() >= LIMIT_32 { 1 } else { 0x4343 };
        header.extend(tag.to_le_bytes());
        header.extend(16u16.to_le_bytes());
        let size = if tag == 1 { self.size() } else { 0 };
        header.extend(size.to_le_bytes());
        header.extend(size.to_le_bytes());
        header
    }

    fn directory_entry(&self, checksum: u32) -> Vec<u8> {
        let mut extra = Vec::new();
        if self.size() >= LIMIT_32 {
            extra.extend(self.size().to_le_bytes());
            extra.extend(self.size().to_le_bytes());
        }
        if self.header >= LIMIT_32 {
            extra.extend(self.header.to_le_bytes());
        }
        let length = if extra.is_empty() { 0 } else { extra.len() + 4 };
        let mut entry = b"PK\x01\x02".to_vec();
        entry.extend(45u16.to_le_bytes());
        entry.extend(self.common_fields(checksum));
        entry.extend((length as u16).to_le_bytes());
        // No comment, disk 0, no attributes.
        entry.extend([0; 10]);
        entry.extend((self.header.min(LIMIT_32) as u32).to_le_bytes());
        entry.extend(self.name.as_bytes());
        if !extra.is_empty() {
            entry.extend(1u16.to_le_bytes());
            entry.extend((extra.len() as u16).to_le_bytes());
            entry.extend(extra);
        }
        entry
    }
}

/// The records that close an archive whose directory of `length` bytes is at `start`.
fn end_records(count: u64, start: u64, length: u64) -> Vec<u8> {
    let mut records = Vec::new();
    if start >= LIMIT_32 || length >= LIMIT_32 || count >= u64::from(u16::MAX) {
        let at = start + length;
        records.extend(b"PK\x06\x06");
        records.extend(44u64.to_le_bytes());
        records.extend(45u16.to_le_bytes());
        records.extend(45u16.to_le_bytes());
        records.extend([0; 8]);
        for word in [count, count, length, start] {
            records.extend(word.to_le_bytes());
        }
        records.extend(b"PK\x06\x07");
        records.extend(0u32.to_le_bytes());
        records.extend(at.to_le_bytes());
        records.extend(1u32.to_le_bytes());
    }
    let short = count.min(u64::from(u16::MAX)) as u16;
    records.extend(b"PK\x05\x06");
    records.extend([0; 4]);
    records.extend(short.to_le_bytes());
    records.extend(short.to_le_bytes());
    records.extend((length.min(LIMIT_32) as u32).to_le_bytes());
    records.extend((start.min(LIMIT_32) as u32).to_le_bytes());
    records.extend(0u16.to_le_bytes());
    records
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arrays::{LargeArray, Sink};
    use ndarray::{Array1, Array2, s};

    #[test]
    fn val_ndarray_npy_reads_blocks_written_in_any_order()
    -> std::result::Result<(), Box<dyn std::error::Error>> {
        let place = tempfile::tempdir()?;
        let path = place.path().join("a.npz");
        let whole = Array2::from_shape_fn((37, 11), |(i, j)| i as f64 - 0.5 * j as f64);
        let archive = Archive::create(&path, Precision::F64)?;
        archive.reserve(LargeArray::TEMPORAL_SPECTRUM, (37, 11))?;
        archive.reserve(LargeArray::SPATIAL_SPECTRUM, (37, 11))?;
        archive.append(
            &ArrayLabels::of("axis", &[("axis", 3)]),
            &[1.0, 2.0, f64::NAN],
        )?;
        for columns in [8..11, 0..8] {
            let block = whole.slice(s![.., columns.clone()]);
            archive.put(LargeArray::TEMPORAL_SPECTRUM, 0, columns.start, block)?;
        }
        archive.put(LargeArray::SPATIAL_SPECTRUM, 0, 0, whole.view())?;
        archive.finish()?;

        let mut read = ndarray_npy::NpzReader::new(File::open(&path)?)?;
        assert_eq!(
            read.by_name::<ndarray::OwnedRepr<f64>, ndarray::Ix2>("temporal_spectrum")?,
            whole
        );
        assert_eq!(
            read.by_name::<ndarray::OwnedRepr<f64>, ndarray::Ix2>("spatial_spectrum")?,
            whole
        );
        let axis: Array1<f64> = read.by_name("axis")?;
        assert!(axis[2].is_nan() && axis[1] == 2.0);
        Ok(())
    }

    #[test]
    fn samples_start_aligned() {
        for content in 0..130 {
            let header = npy_header("<f8", "(5, 7)", content);
            assert_eq!((content + header.len() as u64) % ALIGNMENT, 0);
        }
    }
}
