//! Arrays of a result in memory, in the precision of the result, on their way to NumPy.

use std::sync::{Mutex, MutexGuard, PoisonError};

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use wavecascade::arrays::Precision;
use wavecascade::report::{ArrayFile, ArrayLabels, Attribute};
use wavecascade::{Error, Result};

/// All arrays of a result.
#[derive(Debug)]
pub struct Kept {
    precision: Precision,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    arrays: Vec<KeptArray>,
    attributes: Vec<(String, Attribute)>,
}

#[derive(Debug)]
struct KeptArray {
    name: String,
    axes: Vec<String>,
    shape: Vec<usize>,
    numbers: Numbers,
    attributes: Vec<(&'static str, Attribute)>,
}

#[derive(Debug)]
enum Numbers {
    F64(Vec<f64>),
    F32(Vec<f32>),
}

impl Kept {
    pub fn new(precision: Precision) -> Kept {
        Kept {
            precision,
            state: Mutex::default(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// `{"arrays": [(name, axes, array, attributes)], "attributes": {}}`.
    pub fn into_python(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let state = self
            .state
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        let arrays = PyList::empty(py);
        for array in state.arrays {
            let numbers = match array.numbers {
                Numbers::F64(values) => {
                    let flat = PyArray1::from_vec(py, values);
                    flat.reshape(&array.shape[..])?.into_any()
                }
                Numbers::F32(values) => {
                    let flat = PyArray1::from_vec(py, values);
                    flat.reshape(&array.shape[..])?.into_any()
                }
            };
            arrays.append((array.name, array.axes, numbers, dict(py, array.attributes)?))?;
        }
        let out = PyDict::new(py);
        out.set_item("arrays", arrays)?;
        out.set_item("attributes", dict(py, state.attributes)?)?;
        Ok(out)
    }
}

fn dict<N: AsRef<str>>(
    py: Python<'_>,
    attributes: Vec<(N, Attribute)>,
) -> PyResult<Bound<'_, PyDict>> {
    let out = PyDict::new(py);
    for (name, value) in attributes {
        let name = name.as_ref();
        match value {
            Attribute::Text(text) => out.set_item(name, text)?,
            Attribute::Number(number) => out.set_item(name, number)?,
            Attribute::Single(number) => out.set_item(name, number)?,
            Attribute::Integer(number) => out.set_item(name, number)?,
        }
    }
    Ok(out)
}

fn zeros<T: Clone + Default>(len: usize) -> Result<Vec<T>> {
    let needed = (len * size_of::<T>()) as u64;
    let mut all = Vec::new();
    all.try_reserve_exact(len).map_err(|_| Error::Refused {
        what: "an array of the result",
        needed,
    })?;
    all.resize(len, T::default());
    Ok(all)
}

impl ArrayFile for Kept {
    fn precision(&self) -> Precision {
        self.precision
    }

    fn reserve_array(&self, labels: &ArrayLabels, precision: Precision) -> Result<Option<usize>> {
        let (axes, shape) = (labels.axes.iter(), labels.shape());
        let len = shape.iter().product();
        let numbers = match precision {
            Precision::F64 => Numbers::F64(zeros(len)?),
            Precision::F32 => Numbers::F32(zeros(len)?),
        };
        let arrays = &mut self.lock().arrays;
        arrays.push(KeptArray {
            name: labels.name.to_owned(),
            axes: axes.map(|(name, _)| (*name).to_owned()).collect(),
            shape,
            numbers,
            attributes: labels.attributes(),
        });
        Ok(Some(arrays.len() - 1))
    }

    fn find_array(&self, name: &str) -> Option<(usize, usize)> {
        let arrays = &self.lock().arrays;
        let place = arrays.iter().position(|array| array.name == name)?;
        Some((place, arrays[place].shape.get(1).copied().unwrap_or(1)))
    }

    fn write_samples(&self, place: usize, first: usize, values: &[f64]) -> Result<()> {
        let to = first..first + values.len();
        match &mut self.lock().arrays[place].numbers {
            Numbers::F64(all) => all[to].copy_from_slice(values),
            Numbers::F32(all) => {
                let pairs = all[to].iter_mut().zip(values);
                pairs.for_each(|(to, from)| *to = *from as f32);
            }
        }
        Ok(())
    }

    fn describe(&self, array: &str, attributes: Vec<(&'static str, Attribute)>) {
        let mut state = self.lock();
        if let Some(kept) = state.arrays.iter_mut().find(|kept| kept.name == array) {
            kept.attributes.extend(attributes);
        }
    }

    fn attribute(&self, name: &str, value: Attribute) {
        self.lock().attributes.push((name.to_owned(), value));
    }

    fn finish(&self) -> Result<()> {
        Ok(())
    }
}
