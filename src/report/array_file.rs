//! Files of named arrays, each written whole or in blocks, in any order.

use std::path::Path;

use ndarray::ArrayView2;

use super::{Archive, NetCdf};
use crate::arrays::{LargeArray, Precision, Sink, in_runs};
use crate::error::Result;

/// What an array of a file is called, what its axes count, and its unit.
#[derive(Debug, Clone, Copy)]
pub struct ArrayLabels<'a> {
    pub name: &'a str,
    /// Name and length of each axis, the slowest first. An array of one dimension with the name of its
    /// axis holds the coordinates of that axis.
    pub axes: &'a [(&'a str, usize)],
    /// Empty for none.
    pub unit: &'a str,
    /// What it is in words; empty for none.
    pub about: &'a str,
}

impl<'a> ArrayLabels<'a> {
    /// Without unit and meaning.
    pub fn of(name: &'a str, axes: &'a [(&'a str, usize)]) -> ArrayLabels<'a> {
        ArrayLabels {
            name,
            axes,
            unit: "",
            about: "",
        }
    }

    pub fn shape(&self) -> Vec<usize> {
        self.axes.iter().map(|(_, len)| *len).collect()
    }

    /// Unit and meaning, those of them that it has.
    pub fn attributes(&self) -> Vec<(&'static str, Attribute)> {
        let texts = [("units", self.unit), ("long_name", self.about)].into_iter();
        let texts = texts.filter(|(_, text)| !text.is_empty());
        texts
            .map(|(name, text)| (name, Attribute::Text(text.into())))
            .collect()
    }
}

/// A value beside a file or an array.
#[derive(Debug, Clone, PartialEq)]
pub enum Attribute {
    Text(String),
    Number(f64),
    /// In single precision, which a fill value of such an array has to be.
    Single(f32),
    Integer(i32),
}

/// Takes arrays with their labels, and values that belong to all of them: a file ([`Archive`], [`NetCdf`]), or memory.
/// As a [`Sink`] it takes the large ones in blocks.
pub trait ArrayFile: Sink {
    /// That of arrays for which none is stated.
    fn precision(&self) -> Precision;

    /// Announces an array, all samples of which will be written; its place, or `None` where the format has no place for an
    /// array without samples.
    ///
    /// # Errors
    /// If there is no room for it.
    fn reserve_array(&self, labels: &ArrayLabels, precision: Precision) -> Result<Option<usize>>;

    /// Place and columns of the array of this name.
    fn find_array(&self, name: &str) -> Option<(usize, usize)>;

    /// Writes samples of the array at `place` from its sample `first` on, row-major.
    ///
    /// # Errors
    /// If they cannot be written.
    fn write_samples(&self, place: usize, first: usize, values: &[f64]) -> Result<()>;

    /// Adds values to the array of this name, if there is one and the format has such.
    fn describe(&self, _array: &str, _attributes: Vec<(&'static str, Attribute)>) {}

    /// Adds a value that belongs to all arrays, if the format has such.
    fn attribute(&self, _name: &str, _value: Attribute) {}

    /// Ends the file.
    ///
    /// # Errors
    /// If it cannot be written.
    fn finish(&self) -> Result<()>;

    /// Takes a whole array, row-major.
    ///
    /// # Errors
    /// If it cannot be kept.
    fn append(&self, labels: &ArrayLabels, values: &[f64]) -> Result<()> {
        debug_assert_eq!(labels.shape().iter().product::<usize>(), values.len());
        match self.reserve_array(labels, self.precision())? {
            Some(place) => self.write_samples(place, 0, values),
            None => Ok(()),
        }
    }
}

impl<F: ArrayFile> Sink for F {
    fn reserve(&self, array: LargeArray, (rows, columns): (usize, usize)) -> Result<()> {
        let [first, second] = array.axes();
        let axes = [(first, rows), (second, columns)];
        let labels = ArrayLabels::of(array.name(), &axes);
        self.reserve_array(&labels, self.precision()).map(|_| ())
    }

    fn put(
        &self,
        array: LargeArray,
        row: usize,
        column: usize,
        block: ArrayView2<f64>,
    ) -> Result<()> {
        let Some((place, columns)) = self.find_array(array.name()) else {
            return Ok(());
        };
        in_runs(block, (row, column), columns, |first, values| {
            self.write_samples(place, first, values)
        })
    }
}

/// The format of the arrays of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ArrayFormat {
    /// [`Archive`].
    #[default]
    Npz,
    /// [`NetCdf`].
    NetCdf,
}

impl ArrayFormat {
    /// Name of the file of these arrays: `spectra.npz` or `spectra.nc` of `spectra`.
    pub fn file_name(self, arrays: &str) -> String {
        match self {
            ArrayFormat::Npz => format!("{arrays}.npz"),
            ArrayFormat::NetCdf => format!("{arrays}.nc"),
        }
    }

    /// Creates the file of these arrays in a directory.
    ///
    /// # Errors
    /// [`crate::Error::Write`].
    pub fn create(
        self,
        directory: &Path,
        arrays: &str,
        precision: Precision,
    ) -> Result<Box<dyn ArrayFile>> {
        let path = directory.join(self.file_name(arrays));
        Ok(match self {
            ArrayFormat::Npz => Box::new(Archive::create(&path, precision)?),
            ArrayFormat::NetCdf => Box::new(NetCdf::create(&path, precision)?),
        })
    }
}
