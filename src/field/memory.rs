//! Fields whose samples lie in memory that another owner keeps, at any strides: arrays of other languages.

use std::fmt;
use std::sync::Arc;

use super::beside::{Given, Listing};
use super::open::{Contents, completed};
use super::options::OpenOptions;
use super::sidecar::Sidecar;
use super::statements::Statements;
use super::storage::{Bytes, Storage};
use super::{ByteOrder, Field, Note, Sample, labelled, meaning};
use crate::error::{Fault, Result, UNFINISHED};

/// Bytes of another owner, which stay as they are while anything refers to them.
#[derive(Clone)]
pub struct SharedBytes(pub(super) Arc<dyn AsRef<[u8]> + Send + Sync>);

impl SharedBytes {
    /// What `owner` refers to. It must refer to the same bytes on every call.
    pub fn new(owner: impl AsRef<[u8]> + Send + Sync + 'static) -> SharedBytes {
        SharedBytes(Arc::new(owner))
    }

    pub(super) fn as_slice(&self) -> &[u8] {
        (*self.0).as_ref()
    }
}

impl fmt::Debug for SharedBytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SharedBytes({} bytes)", self.as_slice().len())
    }
}

/// Samples `(time, site)` in memory: number `(n, j)` is at byte `start + n strides[0] + j strides[1]`.
#[derive(Debug, Clone)]
pub struct MemorySamples {
    pub bytes: SharedBytes,
    pub sample: Sample,
    pub order: ByteOrder,
    /// Byte of the first sample.
    pub start: usize,
    /// Times and sites.
    pub shape: [usize; 2],
    /// Bytes from one time to the next, and from one site to the next; of either sign.
    pub strides: [isize; 2],
}

/// Coordinates of an axis, one a sample.
#[derive(Debug, Clone, Default)]
pub struct ListedAxis {
    pub values: Vec<f64>,
    /// Absolute rounding error of the values.
    pub rounding: f64,
    pub unit: Option<String>,
    /// The distance that is stated beside them; taken if it gives each value to the last bit.
    pub step: Option<f64>,
}

/// What is known of samples in memory.
#[derive(Debug, Clone, Default)]
pub struct MemoryLabels {
    /// Name of the field in results and messages.
    pub name: String,
    /// Name of what the samples measure, from which the quantity follows.
    pub quantity: Option<String>,
    pub unit: Option<String>,
    pub time: Option<ListedAxis>,
    pub space: Option<ListedAxis>,
    /// Names of both axes.
    pub axis_names: [Option<String>; 2],
    /// Date and time from which times count.
    pub start: Option<String>,
    /// Whether it is known which axis is time.
    pub is_layout_known: bool,
    /// As [`Field::struck`].
    pub struck: Option<usize>,
}

impl MemorySamples {
    /// The samples in rows, if they lie so; otherwise by their strides.
    fn storage(self) -> Result<Storage, Fault> {
        let (shape, strides, start) = (self.shape, self.strides, self.start);
        let size = self.sample.bytes();
        let length = self.bytes.as_slice().len();
        // From the lowest to the highest byte.
        let reach = |sign: isize| -> isize {
            let axes = shape.iter().zip(strides);
            let parts = axes.map(|(n, s)| (n.saturating_sub(1) as isize).saturating_mul(s));
            let parts = parts.filter(|part| part.signum() == sign);
            parts.fold(0, isize::saturating_add)
        };
        let start_at = isize::try_from(start).unwrap_or(isize::MAX);
        let end = (start_at.saturating_add(reach(1)) as usize).saturating_add(size);
        if end > length || start_at.saturating_add(reach(-1)) < 0 {
            let (claimed, most) = (end as u64, length as u64);
            return Err(Fault::overclaimed(claimed, most));
        }
        let (bytes, numbers) = (Bytes::Held(self.bytes), (self.sample, self.order));
        Ok(Storage::new(bytes, numbers, start, shape, strides))
    }
}

impl Field {
    /// A field over samples in memory, which are not copied. Axes come from `options`, else from `labels`, as
    /// for [`Field::open`]; options that choose among the arrays of a file have no effect.
    ///
    /// # Errors
    /// - [`crate::Error::Input`]: samples outside of their bytes; coordinates that are not even.
    /// - [`crate::Error::Request`]: a step, an origin or a selection that does not fit.
    /// - [`crate::Error::Memory`]: samples to resample that exceed [`OpenOptions::memory`].
    pub fn from_memory(
        samples: MemorySamples,
        labels: MemoryLabels,
        options: &OpenOptions,
    ) -> Result<Field> {
        options.check()?;
        let path = std::path::PathBuf::from(&labels.name);
        Field::of_memory(samples, labels, options).map_err(|error| error.at(&path))
    }

    fn of_memory(
        samples: MemorySamples,
        labels: MemoryLabels,
        options: &OpenOptions,
    ) -> Result<Field> {
        let stated = options.over(Sidecar::default());
        let [n_times, n_sites] = samples.shape;
        if n_times == 0 || n_sites == 0 {
            return Err(Fault::expected("samples", "an empty file", UNFINISHED).into());
        }
        let storage = samples.storage()?;
        let start = labels.start.map(|time| Note::start(&time));
        let mut notes = Vec::from_iter(start);
        let statements = Statements::default();
        let time = statements.time(&stated, options)?;
        let space = statements.space(&stated, options)?;
        let time = time.axis(labels.time.map(ListedAxis::given), &mut notes)?;
        let space = space.axis(labels.space.map(ListedAxis::given), &mut notes)?;
        let named = labels.quantity.as_deref().unwrap_or_default();
        let quantity = meaning::quantity(named, None, labels.unit.as_deref());
        let field = Field {
            unit: labels.unit,
            notes,
            axis_names: labels.axis_names,
            struck: labels.struck.filter(|site| *site < n_sites),
            ..Field::of_storage(storage, (n_times, n_sites))
        };
        let mut contents = Contents {
            field,
            time,
            space,
            quantity,
        };
        contents.note_doubts(labels.is_layout_known || stated.layout.is_some());
        completed(contents, stated, options, &labels.name)
    }
}

impl ListedAxis {
    /// Counted from the first, if the unit counts from a date.
    fn given(self) -> Given {
        let stored = (&self.values[..], None);
        let found = labelled::counted(stored, [1.0, 0.0], self.rounding, self.unit, false);
        let step = self.step.filter(|_| found.start.is_none());
        Given::Listed(Listing { step, ..found })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    /// 6 x 5 numbers, row-major, behind 3 others.
    fn bytes() -> SharedBytes {
        let values = (-3..30).flat_map(|i| f64::from(i).to_ne_bytes());
        SharedBytes::new(values.collect::<Vec<u8>>())
    }

    fn field(start: usize, shape: [usize; 2], strides: [isize; 2]) -> Result<Field> {
        let samples = MemorySamples {
            bytes: bytes(),
            sample: Sample::F64,
            order: ByteOrder::NATIVE,
            start: 8 * start,
            shape,
            strides: strides.map(|stride| 8 * stride),
        };
        let labels = MemoryLabels::default();
        Field::from_memory(samples, labels, &OpenOptions::default())
    }

    #[test]
    fn val_definition_samples_at_any_strides() {
        for (start, shape, strides) in [
            (3, [6, 5], [5, 1]),
            (3, [5, 6], [1, 5]),
            (3, [3, 5], [10, 1]),
            (3, [3, 3], [10, 2]),
            (3, [3, 2], [2, 15]),
            (32, [6, 5], [-5, -1]),
            (28, [6, 5], [-5, 1]),
            (7, [5, 6], [-1, 5]),
            (3, [30, 1], [1, 30]),
            (3, [1, 30], [30, 1]),
            (3, [6, 1], [5, 1]),
            (3, [4, 5], [0, 1]),
        ] {
            let found = field(start, shape, strides).unwrap();
            let [times, sites] = shape;
            let at = |n: usize, j: usize| {
                (start as isize + n as isize * strides[0] + j as isize * strides[1] - 3) as f64
            };
            let mut out = vec![0.0; times * sites];
            found.read_time_major(0..times, 0..sites, &mut out);
            let expected = (0..times).flat_map(|n| (0..sites).map(move |j| at(n, j)));
            assert_eq!(out, expected.collect::<Vec<_>>(), "{strides:?}");
            found.read_site_major(0..times, 0..sites, &mut out);
            let expected = (0..sites).flat_map(|j| (0..times).map(move |n| at(n, j)));
            assert_eq!(out, expected.collect::<Vec<_>>(), "{strides:?}");
            // A block of it.
            if times > 2 && sites > 1 {
                let mut out = vec![0.0; 2];
                found.read_time_major(1..3, 1..2, &mut out);
                assert_eq!(out, [at(1, 1), at(2, 1)]);
            }
        }
    }

    #[test]
    fn samples_outside_of_their_bytes_are_refused() {
        for (start, shape, strides) in [
            (3, [7, 5], [5, 1]),
            (4, [6, 5], [5, 1]),
            (4, [6, 2], [-1, 1]),
            (0, [2, isize::MAX as usize], [1, 1]),
        ] {
            let found = field(start, shape, strides);
            assert!(matches!(found, Err(Error::Input { .. })), "{strides:?}");
        }
        assert!(field(3, [0, 5], [5, 1]).is_err());
    }
}
