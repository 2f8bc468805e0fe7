//! The variables of a file while they are found.

use crate::container::{Block, Decoder};
use crate::cursor::Budget;
use crate::rows::{Strided, misfit};
use crate::{
    ByteOrder, Bytes, Container, Dimension, Error, Format, Options, Place, Result, Sample, Value,
    Variable, strides,
};

/// Structs and cells of a few bytes each must not fill the memory with their names.
const MOST_VARIABLES: usize = 1 << 16;

/// The variables of a file while they are found.
pub(super) struct Listing {
    pub(super) container: Container,
    pub(super) budget: Budget,
    pub(super) file: Bytes,
}

/// Where the numbers of an array are: in the file, or in a variable that was inflated.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) order: ByteOrder,
    /// An inflated variable, and its number from 1.
    pub(super) inflated: Option<(&'a Bytes, usize)>,
}

impl Part<'_> {
    pub(super) fn damaged(
        &self,
        at: usize,
        expected: impl Into<String>,
        found: impl ToString,
    ) -> Error {
        let place = match self.inflated {
            None => format!("byte {at}"),
            Some((_, number)) => format!("byte {at} of compressed variable {number}"),
        };
        Error::damaged(place, expected.into(), found.to_string())
    }
}

impl Listing {
    pub(super) fn new(format: Format, file: &Bytes, options: &Options) -> Listing {
        Listing {
            container: Container::new(format, file),
            budget: Budget::new("the variables of a MATLAB file", options),
            file: Bytes::clone(file),
        }
    }

    /// Lists what holds no numbers.
    pub(super) fn push_other(&mut self, path: String, shape: &[u64], what: &str) -> Result<()> {
        self.count(&path, shape)?;
        let variable = Variable::other(path, dimensions(shape), what);
        self.container.push(variable);
        Ok(())
    }

    /// Lists a text, one a row, which becomes an attribute too.
    pub(super) fn push_text(
        &mut self,
        path: String,
        shape: &[u64],
        mut rows: Vec<String>,
    ) -> Result<()> {
        let attributes = &mut self.container.attributes;
        if rows.len() > 1 {
            attributes.insert(path.clone(), Value::Texts(rows));
        } else if let Some(text) = rows.pop() {
            attributes.insert_text(path.clone(), text);
        }
        self.push_other(path, shape, "text")
    }

    /// Lists numbers from byte `start` of `part`, stored by columns as `disk`, which MATLAB holds as `class`. The
    /// caller has checked that they lie within the part.
    pub(super) fn push_numbers(
        &mut self,
        path: String,
        shape: &[u64],
        [class, disk]: [Sample; 2],
        part: Part,
        start: usize,
    ) -> Result<()> {
        self.count(&path, shape)?;
        let strides = strides(shape, disk, true);
        let (order, start) = (part.order, start as u64);
        let mut variable = Variable::new(path.clone(), dimensions(shape), class);
        let is_bool = class == Sample::Bool && disk.bytes() == 1;
        if disk == class || is_bool {
            variable.place = Place::Strided {
                start,
                strides,
                order,
                is_in_file: part.inflated.is_none(),
            };
            match part.inflated {
                None => self.container.push(variable),
                Some((inflated, _)) => {
                    let inflated = Bytes::clone(inflated);
                    self.container
                        .push_in(variable, move || Ok(Bytes::clone(&inflated)));
                }
            }
            return Ok(());
        }
        // A column is contiguous: a cache line of it at once.
        let rows = (64 / disk.bytes()) as u64;
        variable.place = Place::Encoded { rows };
        let columns = Columns {
            path,
            bytes: Bytes::clone(part.inflated.map_or(&self.file, |(bytes, _)| bytes)),
            start,
            strides,
            order,
            disk,
            class,
        };
        self.container.push_decoded(variable, columns);
        Ok(())
    }

    fn count(&mut self, path: &str, shape: &[u64]) -> Result<()> {
        if self.container.variables.len() == MOST_VARIABLES {
            return Err(Error::unsupported(
                format!("a file of more than {MOST_VARIABLES} arrays"),
                "save those that are needed to a file of their own",
            ));
        }
        let names = 2 * path.len() + shape.len() * size_of::<Dimension>();
        self.budget.take((256 + names) as u64)
    }
}

fn dimensions(shape: &[u64]) -> Vec<Dimension> {
    shape.iter().map(|len| Dimension::new(*len)).collect()
}

/// An array that is decoded. All of it lies within its bytes.
struct Columns {
    path: String,
    bytes: Bytes,
    start: u64,
    strides: Vec<u64>,
    order: ByteOrder,
    /// Type of the stored numbers.
    disk: Sample,
    /// Type that MATLAB gives them.
    class: Sample,
}

impl Decoder for Columns {
    fn read(&self, block: Block, out: &mut [u8]) -> Result<()> {
        let stored = Strided {
            start: self.start,
            strides: &self.strides,
            order: self.order,
            sample: self.disk,
        };
        let copied = stored.copy((*self.bytes).as_ref(), block, self.class, out);
        copied.map_err(|number| misfit(&self.path, self.class, number))
    }
}

/// How many samples an array has; none beyond a `u64`.
pub(super) fn count(shape: &[u64]) -> Option<u64> {
    shape.iter().try_fold(1u64, |n, len| n.checked_mul(*len))
}

/// Characters stored by columns as rows; those of a rank beyond 2 are none.
///
/// # Errors
/// What is expected, if there are more or fewer.
pub(super) fn rows_of_text(
    shape: &[u64],
    text: &[char],
) -> std::result::Result<Vec<String>, String> {
    let &[rows, columns] = shape else {
        return Ok(Vec::new());
    };
    if rows <= 1 {
        return Ok(vec![text.iter().collect()]);
    }
    if rows.checked_mul(columns) != Some(text.len() as u64) {
        return Err(format!("{rows} rows of {columns} characters"));
    }
    let rows = if text.is_empty() { 0 } else { rows as usize };
    let row = |i| text.iter().skip(i).step_by(rows).collect();
    Ok((0..rows).map(row).collect())
}
