//! The variables of a file while they are found.

use super::columns::{Source, Stored};
use crate::{
    Attributes, ByteOrder, Dimension, Error, Place, Result, Sample, SampleType, Value, Variable,
};

/// Structs and cells of a few bytes each must not fill the memory with their names.
const MOST_VARIABLES: usize = 1 << 16;

/// The variables of a file while they are found.
pub(super) struct Listing {
    pub(super) attributes: Attributes,
    pub(super) variables: Vec<Variable>,
    /// One a variable; `None` for what is not decoded.
    pub(super) stored: Vec<Option<Stored>>,
    memory: Option<u64>,
    used: u64,
}

impl Listing {
    pub(super) fn new(memory: Option<u64>) -> Listing {
        Listing {
            attributes: Attributes::default(),
            variables: Vec::new(),
            stored: Vec::new(),
            memory,
            used: 0,
        }
    }

    /// Counts memory before it is taken.
    pub(super) fn count(&mut self, what: &str, bytes: u64) -> Result<()> {
        self.used = self.used.saturating_add(bytes);
        match self.memory {
            Some(allowed) if self.used > allowed => Err(Error::Memory {
                what: what.to_owned(),
                needed: self.used,
                allowed,
            }),
            _ => Ok(()),
        }
    }

    /// Lists what holds no numbers.
    pub(super) fn push_other(&mut self, path: String, shape: &[u64], what: String) -> Result<()> {
        let place = Place::Encoded { rows: 1 };
        self.push(path, shape, SampleType::Other(what), place, None)
    }

    /// Lists a text, one a row, which becomes an attribute too.
    pub(super) fn push_text(
        &mut self,
        path: String,
        shape: &[u64],
        mut rows: Vec<String>,
    ) -> Result<()> {
        if rows.len() > 1 {
            self.attributes.insert(path.clone(), Value::Texts(rows));
        } else if let Some(text) = rows.pop() {
            self.attributes.insert_text(path.clone(), text);
        }
        self.push_other(path, shape, "text".into())
    }

    /// Lists numbers stored by columns as `disk`, which MATLAB holds as `class`. The caller has checked
    /// that they lie within their source.
    pub(super) fn push_numbers(
        &mut self,
        path: String,
        shape: &[u64],
        class: Sample,
        disk: Sample,
        (source, start, order): (Source, usize, ByteOrder),
    ) -> Result<()> {
        let is_empty = shape.contains(&0);
        let mut next = disk.bytes() as u64;
        let strides: Vec<u64> = shape
            .iter()
            .map(|len| {
                // Lengths beside a 0 are free to overflow; those of samples that exist are not.
                let stride = if is_empty { 0 } else { next };
                next = next.saturating_mul(*len);
                stride
            })
            .collect();
        let is_bool = class == Sample::Bool && disk.bytes() == 1;
        let (place, stored) = if source == Source::File && (disk == class || is_bool) {
            let place = Place::Strided {
                start: start as u64,
                strides,
                order,
            };
            (place, None)
        } else {
            // A column is contiguous: a cache line of it at once.
            let rows = (64 / disk.bytes()) as u64;
            let stored = Stored {
                path: path.clone(),
                source,
                start,
                strides,
                order,
                disk,
                class,
            };
            (Place::Encoded { rows }, Some(stored))
        };
        self.push(path, shape, SampleType::Number(class), place, stored)
    }

    fn push(
        &mut self,
        path: String,
        shape: &[u64],
        sample_type: SampleType,
        place: Place,
        stored: Option<Stored>,
    ) -> Result<()> {
        if self.variables.len() == MOST_VARIABLES {
            return Err(Error::unsupported(
                format!("a file of more than {MOST_VARIABLES} arrays"),
                "save those that are needed to a file of their own",
            ));
        }
        let names = 2 * path.len() + shape.len() * size_of::<Dimension>();
        self.count("the list of variables", (256 + names) as u64)?;
        self.variables.push(Variable {
            path,
            dimensions: shape.iter().map(|len| Dimension::new(*len)).collect(),
            sample_type,
            attributes: Attributes::default(),
            place,
        });
        self.stored.push(stored);
        Ok(())
    }
}

/// How many samples an array has; an error beyond a `u64`.
pub(super) fn count(shape: &[u64], place: impl Fn() -> String) -> Result<u64> {
    let count = shape.iter().try_fold(1u64, |n, len| n.checked_mul(*len));
    count.ok_or_else(|| Error::damaged(place(), "lengths of dimensions", format!("{shape:?}")))
}

/// Characters stored by columns as rows; those of a rank beyond 2 are none.
pub(super) fn rows_of_text(shape: &[u64], text: &[char], place: String) -> Result<Vec<String>> {
    let &[rows, columns] = shape else {
        return Ok(Vec::new());
    };
    if rows <= 1 {
        return Ok(vec![text.iter().collect()]);
    }
    if rows.checked_mul(columns) != Some(text.len() as u64) {
        let expected = format!("{rows} rows of {columns} characters");
        let found = format!("{} characters", text.len());
        return Err(Error::damaged(place, expected, found));
    }
    let rows = if text.is_empty() { 0 } else { rows as usize };
    let row = |i| text.iter().skip(i).step_by(rows).collect();
    Ok((0..rows).map(row).collect())
}
