//! The variables of a file while they are found.

use crate::container::{Block, Decoder};
use crate::cursor::Budget;
use crate::{
    ByteOrder, Bytes, Container, Dimension, Error, Format, Options, Place, Result, Sample, Strided,
    Value, Variable, strides,
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

    /// Lists a text at byte `at` of `part`, which becomes an attribute too: its rows, whose characters are stored by
    /// columns. A text of more than two dimensions has none.
    pub(super) fn push_text(
        &mut self,
        path: String,
        shape: &[u64],
        text: String,
        (part, at): (Part, usize),
    ) -> Result<()> {
        let all: Vec<char> = text.chars().collect();
        let attributes = &mut self.container.attributes;
        match *shape {
            [0 | 1, _] => attributes.insert_text(path.clone(), text),
            [rows, columns] if rows.checked_mul(columns) != Some(all.len() as u64) => {
                let expected = format!("{rows} rows of {columns} characters");
                return Err(part.damaged(at, expected, format!("{} characters", all.len())));
            }
            [rows, _] if !all.is_empty() => {
                let row = |i| all.iter().skip(i).step_by(rows as usize).collect();
                let rows = (0..rows as usize).map(row).collect();
                attributes.insert(path.clone(), Value::Texts(rows));
            }
            _ => {}
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
        let strided = Strided {
            is_in_file: part.inflated.is_none(),
            ..Strided::new(start as u64, strides(shape, disk, true), part.order)
        };
        let mut variable = Variable::new(path.clone(), dimensions(shape), class);
        let inflated = part.inflated.map(|(bytes, _)| Bytes::clone(bytes));
        let is_bool = class == Sample::Bool && disk.bytes() == 1;
        if disk == class || is_bool {
            variable.place = Place::Strided(strided);
            match inflated {
                None => self.container.push(variable),
                Some(bytes) => {
                    let unpack = move || Ok(Bytes::clone(&bytes));
                    self.container.push_in(variable, unpack);
                }
            }
            return Ok(());
        }
        // A column is contiguous: a cache line of it at once.
        let rows = (64 / disk.bytes()) as u64;
        variable.place = Place::Encoded { rows };
        let columns = Columns {
            path,
            bytes: inflated.unwrap_or_else(|| Bytes::clone(&self.file)),
            strided,
            samples: [disk, class],
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
    strided: Strided,
    /// Types of the stored numbers and of those that MATLAB holds.
    samples: [Sample; 2],
}

impl Decoder for Columns {
    fn read(&self, block: Block, out: &mut [u8]) -> Result<()> {
        let bytes = (*self.bytes).as_ref();
        let copied = self.strided.copy(bytes, block, self.samples, out);
        copied.map_err(|number| Variable::misfit(&self.path, self.samples[1], number))
    }
}
