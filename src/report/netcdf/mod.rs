//! NetCDF files whose arrays are written in blocks, in any order.
//!
//! A classic file is a header and then the samples of one variable after another, so that their places
//! are known when an array is announced. The header is written last, into space that is kept for it.

mod header;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use super::samples::{Order, bytes_of, in_bytes};
use super::{ArrayFile, ArrayLabels, Attribute};
use crate::arrays::Precision;
use crate::error::{Error, Result};
use crate::system::file_io::{allocate, begin_sync, read_at, write_at};

use header::{Header, Variable};

/// A NetCDF file being written: classic with offsets of 64 bits (CDF-2), or, where an array takes 4 GiB
/// or more, with lengths of 64 bits, too (CDF-5).
///
/// Arrays are written in any order, in blocks if they are large. An array without samples has
/// no place in the format and is left out.
#[derive(Debug)]
pub struct NetCdf {
    file: File,
    path: PathBuf,
    precision: Precision,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    header: Header,
    /// Bytes before the samples.
    kept: u64,
    end: u64,
}

/// Bytes that are kept for the header: those of a hundred arrays.
const KEPT: u64 = 64 << 10;
/// The same for a field.
pub(super) const KEPT_FOR_A_FIELD: u64 = 4 << 10;
/// Samples start at multiples of this, so that readers can map them aligned.
const ALIGNMENT: u64 = 64;

impl NetCdf {
    /// Creates the file `path`; arrays are stored in `precision`.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn create(path: &Path, precision: Precision) -> Result<NetCdf> {
        NetCdf::create_keeping(path, precision, KEPT)
    }

    /// The same with so many bytes kept for the header. If it takes more, all samples move at the end.
    pub(super) fn create_keeping(path: &Path, precision: Precision, kept: u64) -> Result<NetCdf> {
        let file = File::options()
            .read(true)
            .write(true)
            .create_new(true)
            .open(path)
            .map_err(Error::write("create", path))?;
        Ok(NetCdf {
            file,
            path: path.to_owned(),
            precision,
            state: Mutex::new(State {
                header: Header::default(),
                kept,
                end: kept,
            }),
        })
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, State> {
        self.state
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// An array whose name another has is an error, one without samples is left out.
impl ArrayFile for NetCdf {
    fn precision(&self) -> Precision {
        self.precision
    }

    fn reserve_array(&self, labels: &ArrayLabels, precision: Precision) -> Result<Option<usize>> {
        let samples: u64 = labels.axes.iter().map(|(_, len)| *len as u64).product();
        if samples == 0 {
            return Ok(None);
        }
        let mut state = self.lock();
        let is_there = |variable: &Variable| variable.name == labels.name;
        if state.header.variables.iter().any(is_there) {
            let message = format!("two arrays are called {:?}", labels.name);
            let twice = std::io::Error::new(std::io::ErrorKind::InvalidInput, message);
            return Err(Error::write("reserve room in", &self.path)(twice));
        }
        let size = samples * bytes_of(precision);
        let begin = state.end.next_multiple_of(ALIGNMENT);
        // The netCDF library expects the padding of the last array, too.
        let end = (begin + size).next_multiple_of(4);
        allocate(&self.file, state.end, end)
            .map_err(Error::write("reserve room in", &self.path))?;
        let axes = labels.axes.iter();
        let dimensions = axes.map(|(name, len)| state.dimension(name, *len as u64));
        let dimensions = dimensions.collect();
        let attributes = labels.attributes().into_iter();
        let attributes = attributes.map(|(name, value)| (name.into(), value));
        state.header.variables.push(Variable {
            name: labels.name.into(),
            dimensions,
            attributes: attributes.collect(),
            precision,
            begin,
            size,
        });
        state.end = end;
        Ok(Some(state.header.variables.len() - 1))
    }

    fn find_array(&self, name: &str) -> Option<(usize, usize)> {
        let header = &self.lock().header;
        let variables = &header.variables;
        let place = variables.iter().position(|one| one.name == name)?;
        let columns = variables[place].dimensions.get(1);
        Some((
            place,
            columns.map_or(1, |&at| header.dimensions[at].1 as usize),
        ))
    }

    fn write_samples(&self, variable: usize, first: usize, values: &[f64]) -> Result<()> {
        let (begin, precision) = {
            let state = self.lock();
            let variable = &state.header.variables[variable];
            (variable.begin, variable.precision)
        };
        let begin = begin + first as u64 * bytes_of(precision);
        in_bytes(values, precision, Order::Big, |at, bytes| {
            write_at(&self.file, bytes, begin + at).map_err(Error::write("write to", &self.path))
        })
    }

    fn describe(&self, array: &str, attributes: Vec<(&'static str, Attribute)>) {
        let mut state = self.lock();
        let mut variables = state.header.variables.iter_mut();
        if let Some(variable) = variables.find(|variable| variable.name == array) {
            for (name, value) in attributes {
                variable.attributes.retain(|(known, _)| known != name);
                variable.attributes.push((name.into(), value));
            }
        }
    }

    fn attribute(&self, name: &str, value: Attribute) {
        self.lock().header.attributes.push((name.into(), value));
    }

    /// Writes the header.
    fn finish(&self) -> Result<()> {
        let failed = |action| Error::write(action, &self.path);
        let mut state = self.lock();
        let needed = state.header.encode().len() as u64;
        if needed > state.kept {
            let by = (needed - state.kept).next_multiple_of(ALIGNMENT);
            state
                .shift(&self.file, by)
                .map_err(failed("make room in"))?;
        }
        write_at(&self.file, &state.header.encode(), 0).map_err(failed("write to"))?;
        self.file.set_len(state.end).map_err(failed("finish"))?;
        begin_sync(&self.file);
        Ok(())
    }
}

impl State {
    /// The place of the dimension of this name and length. Another length under the same name makes a
    /// dimension `name_2` and so on.
    fn dimension(&mut self, name: &str, len: u64) -> usize {
        for n in 1.. {
            let name = match n {
                1 => name.to_owned(),
                n => format!("{name}_{n}"),
            };
            let dimensions = &mut self.header.dimensions;
            match dimensions.iter().position(|(known, _)| *known == name) {
                Some(place) if dimensions[place].1 == len => return place,
                Some(_) => {}
                None => {
                    dimensions.push((name, len));
                    return dimensions.len() - 1;
                }
            }
        }
        unreachable!("a name that is free ends the search")
    }

    /// Moves all samples towards the end of the file, the last ones first.
    fn shift(&mut self, file: &File, by: u64) -> std::io::Result<()> {
        allocate(file, self.end, self.end + by)?;
        let mut block = vec![0; 1 << 20];
        let mut at = self.end;
        while at > self.kept {
            let length = (at - self.kept).min(block.len() as u64);
            at -= length;
            let block = &mut block[..length as usize];
            read_at(file, block, at)?;
            write_at(file, block, at + by)?;
        }
        self.header.variables.iter_mut().for_each(|v| v.begin += by);
        (self.kept, self.end) = (self.kept + by, self.end + by);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{Array2, s};
    use wavecascade_formats::{Container, Format, Options};

    use super::*;
    use crate::arrays::{LargeArray, Sink};

    fn read(path: &Path) -> Container {
        let bytes = std::fs::read(path).unwrap();
        let format = Format::detect("a.nc", &bytes).unwrap();
        wavecascade_formats::open(format, std::sync::Arc::new(bytes), &Options::default()).unwrap()
    }

    fn bits(container: &Container, name: &str) -> Vec<u64> {
        let place = container.find(name).unwrap();
        let numbers = container.numbers(place).unwrap();
        numbers.into_iter().map(f64::to_bits).collect()
    }

    /// Little space for the header, so that the samples move, and enough, so that they stay.
    #[test]
    fn regress_blocks_in_any_order_are_read_back_bit_for_bit() -> Result<()> {
        let folder = tempfile::tempdir().unwrap();
        let (rows, columns) = (37, 11);
        let whole = Array2::from_shape_fn((rows, columns), |(i, j)| match (i, j) {
            (3, 4) => f64::NAN,
            (5, 6) => -0.0,
            _ => i as f64 - 0.1 * j as f64,
        });
        let expected: Vec<u64> = whole.iter().map(|v| v.to_bits()).collect();
        for kept in [4, 1 << 12] {
            let path = folder.path().join(format!("{kept}.nc"));
            let file = NetCdf::create_keeping(&path, Precision::F64, kept)?;
            file.reserve(LargeArray::TEMPORAL_SPECTRUM, (rows, columns))?;
            file.reserve(LargeArray::SPATIAL_SPECTRUM, (rows, columns))?;
            let axis = [1.0, 2.0, f64::NAN];
            file.append(&ArrayLabels::of("\u{f8}rsted", &[("\u{3b1}", 3)]), &axis)?;
            for part in [8..11, 0..8] {
                let block = whole.slice(s![.., part.clone()]);
                file.put(LargeArray::TEMPORAL_SPECTRUM, 0, part.start, block)?;
            }
            for part in [20..37, 0..20] {
                let block = whole.slice(s![part.clone(), ..]);
                file.put(LargeArray::SPATIAL_SPECTRUM, part.start, 0, block)?;
            }
            file.attribute("text", Attribute::Text("\u{3a3} S(k, f)".into()));
            let unit = vec![("units", Attribute::Text("(m/s)\u{b2}/Hz".into()))];
            file.describe("spatial_spectrum", unit);
            file.finish()?;

            let found = read(&path);
            assert_eq!(bits(&found, "temporal_spectrum"), expected, "{kept}");
            assert_eq!(bits(&found, "spatial_spectrum"), expected, "{kept}");
            let axis: Vec<u64> = axis.iter().map(|v| v.to_bits()).collect();
            assert_eq!(bits(&found, "\u{f8}rsted"), axis);
            assert_eq!(found.attributes.text("text"), Some("\u{3a3} S(k, f)"));
            let spatial = &found.variables[found.find("spatial_spectrum").unwrap()];
            assert_eq!(spatial.attributes.text("units"), Some("(m/s)\u{b2}/Hz"));
            let names: Vec<_> = spatial.dimensions.iter().map(|d| d.name.clone()).collect();
            assert_eq!(names, [Some("time".into()), Some("wavenumber".into())]);
        }
        Ok(())
    }

    #[test]
    fn one_name_is_one_length_and_one_array() -> Result<()> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.nc");
        let file = NetCdf::create(&path, Precision::F32)?;
        let values = [0.1, 2.0, 3.0];
        let append =
            |name, axis, len| file.append(&ArrayLabels::of(name, &[(axis, len)]), &values[..len]);
        append("a", "x", 2)?;
        append("b", "x", 3)?;
        append("c", "x", 3)?;
        append("none", "y", 0)?;
        assert!(matches!(append("a", "x", 2), Err(Error::Write { .. })));
        file.finish()?;
        let found = read(&path);
        let names: Vec<_> = found.variables.iter().map(|v| &v.path[..]).collect();
        assert_eq!(names, ["a", "b", "c"]);
        let dimension = |v: usize| found.variables[v].dimensions[0].name.clone().unwrap();
        assert_eq!(
            [dimension(0), dimension(1), dimension(2)],
            ["x", "x_2", "x_2"]
        );
        assert_eq!(bits(&found, "a")[0], f64::from(0.1f32).to_bits());
        Ok(())
    }
}
