//! Where samples lie, and how they are decoded.

use hdf5_reader::error::{Error as Cause, Result as CauseResult};
use hdf5_reader::io::Cursor;
use hdf5_reader::messages::HdfMessage;
use hdf5_reader::messages::layout::DataLayout;
use hdf5_reader::object_header::ObjectHeader;
use hdf5_reader::{
    ByteOrder as StoredOrder, Dataset, Datatype, H5Type, Hdf5File, SliceInfo, SliceInfoElem,
};

use super::at;
use crate::container::{Block, Decoder};
use crate::{ByteOrder, Error, Place, Result, Sample, strides};

/// Bytes that are decoded at once where the file has no chunks.
const SLAB: u64 = 1 << 20;

/// The place of the samples of a data set of numbers, all of which lie within the `len` bytes of the file.
pub(super) fn place(
    (file, len): (&Hdf5File, u64),
    path: &str,
    dataset: &Dataset,
    header: &ObjectHeader,
    (sample, order): (Sample, ByteOrder),
) -> Result<Place> {
    let shape = dataset.shape();
    let strides = strides(shape, sample, false);
    let damaged = |expected: String, found: String| {
        Err(Error::damaged(format!("variable {path}"), expected, found))
    };
    let row = strides.first().map_or(1, |row| (*row).max(1));
    let slab = Place::Encoded {
        rows: (SLAB / row).max(1),
    };
    let layout = header.messages.iter().find_map(|message| match message {
        HdfMessage::DataLayout(found) => Some(&found.layout),
        _ => None,
    });
    match layout {
        Some(DataLayout::Contiguous { address, size }) => {
            let superblock = file.superblock();
            let is_nowhere = Cursor::is_undefined_offset(*address, superblock.offset_size);
            if is_nowhere || *size == 0 || shape.contains(&0) {
                return Ok(slab);
            }
            let mut lengths = shape.iter();
            let total = lengths.try_fold(sample.bytes() as u64, |n, len| n.checked_mul(*len));
            let start = address.checked_add(superblock.base_address);
            let end = start.and_then(|start| start.checked_add(total?));
            match start.filter(|_| end.is_some_and(|end| end <= len)) {
                Some(start) => Ok(Place::in_file(start, strides, order)),
                None => {
                    let expected = format!("samples of shape {shape:?} from byte {address}");
                    damaged(expected, format!("a file of {len} bytes"))
                }
            }
        }
        Some(DataLayout::Chunked { .. }) => match &dataset.chunks().unwrap_or_default()[..] {
            chunks if chunks.len() != shape.len() || chunks.contains(&0) => {
                let expected = format!("chunks of {} dimensions", shape.len());
                damaged(expected, format!("chunks {chunks:?}"))
            }
            chunks => Ok(Place::Encoded {
                rows: chunks.first().copied().map_or(1, u64::from),
            }),
        },
        Some(DataLayout::Compact { .. }) => Ok(slab),
        None => damaged("a layout of its samples".into(), "none".into()),
    }
}

/// Whether what was never written would be filled by an attribute of another type than the samples.
///
/// The reader of HDF5 falls back on the bits of `_FillValue` where the data set has no fill value.
pub(super) fn has_foreign_fill(dataset: &Dataset, header: &ObjectHeader) -> bool {
    let has_own = header
        .messages
        .iter()
        .any(|message| matches!(message, HdfMessage::FillValue(fill) if fill.value.is_some()));
    let fill = dataset.attribute("_FillValue");
    !has_own && fill.is_ok_and(|fill| fill.datatype != *dataset.dtype())
}

/// A data set and its path.
pub(super) struct Stored {
    pub(super) path: String,
    pub(super) dataset: Dataset,
}

impl Stored {
    /// The characters of a row of MATLAB, if they are few.
    pub(super) fn short_text(&self) -> Option<String> {
        const MOST: u64 = 256;
        let shape = self.dataset.shape();
        let mut lengths = shape.iter();
        let count = lengths.try_fold(1u64, |count, len| count.checked_mul(*len))?;
        let is_row = shape.iter().filter(|len| **len > 1).count() <= 1;
        if !is_row || !(1..=MOST).contains(&count) {
            return None;
        }
        let all: Vec<_> = shape.iter().map(|&len| 0..len).collect();
        let mut bytes = vec![0; 2 * count as usize];
        self.read(&all, &mut bytes).ok()?;
        let units = bytes
            .chunks_exact(2)
            .map(|unit| ByteOrder::NATIVE.unsigned(unit) as u16);
        String::from_utf16(&units.collect::<Vec<_>>()).ok()
    }
}

impl Decoder for Stored {
    fn read(&self, block: Block, out: &mut [u8]) -> Result<()> {
        let selections = block.iter().map(|range| SliceInfoElem::Slice {
            start: range.start,
            end: range.end,
            step: 1,
        });
        let slice = SliceInfo {
            selections: selections.collect(),
        };
        let count: u64 = block.iter().map(|range| range.end - range.start).product();
        let read = match out.len() as u64 / count.max(1) {
            1 => copy::<1>(&self.dataset, &slice, out),
            2 => copy::<2>(&self.dataset, &slice, out),
            4 => copy::<4>(&self.dataset, &slice, out),
            _ => copy::<8>(&self.dataset, &slice, out),
        };
        read.map_err(at(format!("variable {}", self.path)))
    }
}

fn copy<const N: usize>(dataset: &Dataset, slice: &SliceInfo, out: &mut [u8]) -> CauseResult<()> {
    let numbers = dataset.read_slice::<Number<N>>(slice)?;
    if numbers.len() != out.len() / N {
        let found = format!("{} samples instead of {}", numbers.len(), out.len() / N);
        return Err(Cause::InvalidData(found));
    }
    for (one, number) in out.chunks_exact_mut(N).zip(numbers.iter()) {
        one.copy_from_slice(&number.0);
    }
    Ok(())
}

/// The bits of a number of `N` bytes in native byte order, whatever they mean: half precision and booleans
/// are none of the types that the reader of HDF5 knows.
#[derive(Clone)]
struct Number<const N: usize>([u8; N]);

/// The byte order of numbers of `N` bytes.
fn order_of(datatype: &Datatype, bytes: usize) -> Option<StoredOrder> {
    match datatype {
        Datatype::FixedPoint {
            size, byte_order, ..
        }
        | Datatype::Bitfield { size, byte_order }
        | Datatype::FloatingPoint { size, byte_order } => {
            (usize::from(*size) == bytes).then_some(*byte_order)
        }
        Datatype::Enum { base, .. } => order_of(base, bytes),
        _ => None,
    }
}

const NATIVE: StoredOrder = match ByteOrder::NATIVE {
    ByteOrder::Little => StoredOrder::LittleEndian,
    ByteOrder::Big => StoredOrder::BigEndian,
};

impl<const N: usize> H5Type for Number<N> {
    fn hdf5_type() -> Datatype {
        Datatype::Opaque {
            size: N as u32,
            tag: String::new(),
        }
    }

    fn from_bytes(bytes: &[u8], datatype: &Datatype) -> CauseResult<Self> {
        let order = order_of(datatype, N);
        let number = bytes.get(..N).and_then(|bytes| bytes.try_into().ok());
        let (Some(order), Some(mut number)) = (order, number) else {
            return Err(Cause::InvalidData(format!(
                "{} bytes instead of a number of {N}",
                bytes.len()
            )));
        };
        let number: &mut [u8; N] = &mut number;
        if order != NATIVE {
            number.reverse();
        }
        Ok(Number(*number))
    }

    fn element_size(_datatype: &Datatype) -> usize {
        N
    }

    fn native_copy_compatible(datatype: &Datatype) -> bool {
        order_of(datatype, N) == Some(NATIVE)
    }
}
