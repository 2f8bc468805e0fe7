//! NumPy arrays as samples of a field, without a copy.

use numpy::{PyArrayDescrMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use wavecascade::chain::scene::SceneSource;
use wavecascade::field::{
    ByteOrder, Layout, ListedAxis, MemoryLabels, MemorySamples, OpenOptions, Sample, SharedBytes,
};
use wavecascade::report::RunFile;

use super::faults;
use crate::analyze::open_options;
use crate::prelude::*;

/// The memory of an array, which lives as long as anything refers to it.
struct ArrayMemory {
    start: *const u8,
    length: usize,
    _array: Py<PyUntypedArray>,
}

// SAFETY: the memory belongs to the array that is held, and is only read.
unsafe impl Send for ArrayMemory {}
// SAFETY: as above.
unsafe impl Sync for ArrayMemory {}

impl AsRef<[u8]> for ArrayMemory {
    fn as_ref(&self) -> &[u8] {
        // SAFETY: from the lowest to the highest byte of the elements of an array that is alive. As for every
        // function that releases the lock of the interpreter, nobody may write to it meanwhile.
        unsafe { std::slice::from_raw_parts(self.start, self.length) }
    }
}

/// An array of one or two dimensions with what is known of its axes.
#[pyclass(frozen, from_py_object, module = "wavecascade._native")]
#[derive(Clone)]
pub struct Samples {
    samples: MemorySamples,
    /// Of the array; one of one dimension is the record of one site.
    labels: MemoryLabels,
    is_record: bool,
    /// Of a run: its scene, and the step of its times.
    scene: Option<(String, f64)>,
}

/// `(values, rounding, unit, step)`.
type Coordinates = (Vec<f64>, f64, Option<String>, Option<f64>);

#[pymethods]
impl Samples {
    /// `array` is `(time, site)` if `is_layout_known`, else as the option `layout` says.
    #[new]
    #[pyo3(signature = (array, *, name, quantity=None, unit=None, time=None, space=None,
                        axis_names=(None, None), start=None, is_layout_known=false, struck=None,
                        scene=None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        array: &Bound<'_, PyUntypedArray>,
        name: String,
        quantity: Option<String>,
        unit: Option<String>,
        time: Option<Coordinates>,
        space: Option<Coordinates>,
        axis_names: (Option<String>, Option<String>),
        start: Option<String>,
        is_layout_known: bool,
        struck: Option<usize>,
        scene: Option<(String, f64)>,
    ) -> PyResult<Samples> {
        let (sample, order) = sample_of(array)?;
        let size = sample.bytes();
        let (shape, strides) = match (array.shape(), array.strides()) {
            (&[n], &[stride]) => ([n, 1], [stride, size as isize]),
            (&[n, m], &[first, second]) => ([n, m], [first, second]),
            (shape, _) => {
                let text = format!(
                    "field: expected an array of one or two dimensions, found {} of shape {shape:?}",
                    shape.len()
                );
                return Err(PyValueError::new_err(text));
            }
        };
        // Elements before and behind the first one.
        let reach = |is_behind: bool| -> usize {
            let axes = shape.iter().zip(strides);
            let axes = axes.filter(|(_, stride)| (*stride > 0) == is_behind);
            let parts = axes.map(|(n, stride)| n.saturating_sub(1) * stride.unsigned_abs());
            parts.sum()
        };
        let before = reach(false);
        let length = match shape.contains(&0) {
            true => 0,
            false => before + reach(true) + size,
        };
        let interface = array.getattr("__array_interface__")?;
        let (first, _): (usize, bool) = interface.get_item("data")?.extract()?;
        let memory = ArrayMemory {
            start: match length {
                0 => std::ptr::NonNull::dangling().as_ptr(),
                _ => (first - before) as *const u8,
            },
            length,
            _array: array.clone().unbind(),
        };
        let axis = |of: Option<Coordinates>| {
            of.map(|(values, rounding, unit, step)| ListedAxis {
                values,
                rounding,
                unit,
                step,
            })
        };
        Ok(Samples {
            samples: MemorySamples {
                bytes: SharedBytes::new(memory),
                sample,
                order,
                start: before,
                shape,
                strides,
            },
            labels: MemoryLabels {
                name,
                quantity,
                unit,
                time: axis(time),
                space: axis(space),
                axis_names: [axis_names.0, axis_names.1],
                start,
                is_layout_known,
                struck,
            },
            is_record: array.ndim() == 1,
            scene,
        })
    }
}

impl Samples {
    fn field(&self, options: &OpenOptions) -> Result<Field, Error> {
        let mut samples = self.samples.clone();
        let is_turned = options.layout == Some(Layout::SiteTime);
        if is_turned && !self.labels.is_layout_known && !self.is_record {
            samples.shape.reverse();
            samples.strides.reverse();
        }
        Field::from_memory(samples, self.labels.clone(), options)
    }
}

/// The type and byte order of the elements.
fn sample_of(array: &Bound<'_, PyUntypedArray>) -> PyResult<(Sample, ByteOrder)> {
    let dtype = array.dtype();
    let sample = match (dtype.kind(), dtype.itemsize()) {
        (b'f', 8) => Sample::F64,
        (b'f', 4) => Sample::F32,
        (b'f', 2) => Sample::F16,
        (b'i', 1) => Sample::I8,
        (b'i', 2) => Sample::I16,
        (b'i', 4) => Sample::I32,
        (b'i', 8) => Sample::I64,
        (b'u', 1) => Sample::U8,
        (b'u', 2) => Sample::U16,
        (b'u', 4) => Sample::U32,
        (b'u', 8) => Sample::U64,
        (b'b', 1) => Sample::Bool,
        _ => {
            let text = format!("field: expected real numbers, found {}", dtype.str()?);
            return Err(PyValueError::new_err(text));
        }
    };
    let order = match dtype.byteorder() {
        b'<' => ByteOrder::Little,
        b'>' => ByteOrder::Big,
        _ => ByteOrder::NATIVE,
    };
    Ok((sample, order))
}

/// Where samples come from: an array, or paths of files.
#[derive(FromPyObject)]
#[expect(clippy::large_enum_variant, reason = "a call has few")]
pub enum Source {
    Memory(Samples),
    Files(Vec<PathBuf>),
}

impl Source {
    pub fn from(&self) -> faults::From {
        match self {
            Source::Memory(_) => faults::From::Memory,
            Source::Files(_) => faults::From::Files,
        }
    }

    /// The field.
    pub fn open(self, reading: Reading) -> Result<Field, Error> {
        self.open_as(reading, true)
    }

    /// The field without the hash of its file, which reads all of it.
    pub fn open_unhashed(self, reading: Reading) -> Result<Field, Error> {
        self.open_as(reading, false)
    }

    fn open_as(self, reading: Reading, hash: bool) -> Result<Field, Error> {
        let options = OpenOptions {
            hash,
            ..open_options(reading.input, reading.memory)
        };
        match (self, reading.scan) {
            (Source::Memory(samples), _) => samples.field(&options),
            (Source::Files(paths), Some(scan)) => scan.open(&paths, &options).map(|(f, _)| f),
            (Source::Files(paths), None) => Field::open(&paths[0], &options),
        }
    }

    /// The field with the chain that it is a part of, of this run if that is known.
    pub fn open_of_chain(
        self,
        reading: Reading,
        run: Option<&RunFile>,
    ) -> Result<(Field, Option<Chain>), Error> {
        let scene = match &self {
            Source::Memory(samples) => samples.scene.clone(),
            Source::Files(_) => None,
        };
        let mut field = self.open(reading)?;
        let chain =
            scene.map(|(text, step)| Ok::<_, Error>((SceneSource::new(None, text).setup()?, step)));
        let chain: Option<Chain> = chain.transpose()?;
        let sites = |(setup, _): &Chain| setup.simulation.chain.n_sites();
        let is_part = chain
            .as_ref()
            .is_some_and(|of| sites(of) != field.n_sites());
        if is_part {
            // Of a part of the chain it is not known which body was struck.
            field.struck = None;
        }
        if let Some(run) = run.filter(|file| file.run.velocity.ncols() == field.n_sites()) {
            run.run.label(&mut field);
        }
        Ok((field, chain))
    }

    /// The file, if it is one.
    pub fn path(&self) -> Option<PathBuf> {
        match self {
            Source::Files(paths) => paths.first().cloned(),
            Source::Memory(_) => None,
        }
    }
}
