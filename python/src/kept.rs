//! Arrays of a result in memory, in the precision of the result, on their way to NumPy.

use std::sync::{Mutex, MutexGuard, PoisonError};

use ndarray::ArrayView2;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use wavecascade::arrays::{LargeArray, Precision, Sink};
use wavecascade::report::{ArrayLabels, Attribute, LabelledArrays};
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
    /// Empty where they are not known.
    axes: Vec<String>,
    shape: Vec<usize>,
    numbers: Numbers,
    attributes: Vec<(String, Attribute)>,
    array: Option<LargeArray>,
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

    fn add(&self, name: &str, axes: Vec<String>, shape: &[usize], values: &[f64]) {
        let numbers = match self.precision {
            Precision::F64 => Numbers::F64(values.to_vec()),
            Precision::F32 => Numbers::F32(values.iter().map(|&x| x as f32).collect()),
        };
        self.lock().arrays.push(KeptArray {
            name: name.to_owned(),
            axes,
            shape: shape.to_vec(),
            numbers,
            attributes: Vec::new(),
            array: None,
        });
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

fn dict(py: Python<'_>, attributes: Vec<(String, Attribute)>) -> PyResult<Bound<'_, PyDict>> {
    let out = PyDict::new(py);
    for (name, value) in attributes {
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

impl Sink for Kept {
    fn reserve(&self, array: LargeArray, (rows, columns): (usize, usize)) -> Result<()> {
        let numbers = match self.precision {
            Precision::F64 => Numbers::F64(zeros(rows * columns)?),
            Precision::F32 => Numbers::F32(zeros(rows * columns)?),
        };
        self.lock().arrays.push(KeptArray {
            name: array.name().to_owned(),
            axes: array.axes().map(str::to_owned).to_vec(),
            shape: vec![rows, columns],
            numbers,
            attributes: Vec::new(),
            array: Some(array),
        });
        Ok(())
    }

    fn put(
        &self,
        array: LargeArray,
        row: usize,
        column: usize,
        block: ArrayView2<f64>,
    ) -> Result<()> {
        let mut state = self.lock();
        let mut kept = state.arrays.iter_mut();
        if let Some(kept) = kept.find(|kept| kept.array == Some(array)) {
            let columns = kept.shape[1];
            for (i, line) in block.outer_iter().enumerate() {
                let first = (row + i) * columns + column;
                let place = first..first + line.len();
                match &mut kept.numbers {
                    Numbers::F64(all) => {
                        let to = all[place].iter_mut();
                        to.zip(line).for_each(|(to, from)| *to = *from);
                    }
                    Numbers::F32(all) => {
                        let to = all[place].iter_mut();
                        to.zip(line).for_each(|(to, from)| *to = *from as f32);
                    }
                }
            }
        }
        Ok(())
    }
}

impl LabelledArrays for Kept {
    fn append(&self, labels: &ArrayLabels, values: &[f64]) -> Result<()> {
        let axes = labels.axes.iter().map(|(name, _)| (*name).to_owned());
        let shape: Vec<usize> = labels.axes.iter().map(|(_, len)| *len).collect();
        self.add(labels.name, axes.collect(), &shape, values);
        let texts = [("units", labels.unit), ("long_name", labels.about)];
        let texts = texts.into_iter().filter(|(_, text)| !text.is_empty());
        let texts = texts.map(|(name, text)| (name, Attribute::Text(text.into())));
        self.describe(labels.name, texts.collect());
        Ok(())
    }

    fn describe(&self, array: &str, attributes: Vec<(&str, Attribute)>) {
        let mut state = self.lock();
        if let Some(kept) = state.arrays.iter_mut().find(|kept| kept.name == array) {
            let named = attributes.into_iter();
            kept.attributes
                .extend(named.map(|(name, value)| (name.to_owned(), value)));
        }
    }

    fn attribute(&self, name: &str, value: Attribute) {
        self.lock().attributes.push((name.to_owned(), value));
    }
}
