//! What is measured: shape, precision, threads.

use std::fmt;
use std::str::FromStr;

use crate::analyze::Precision;
use crate::error::{Error, Result};

/// Rows (samples of a column) and columns of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
pub struct Shape {
    pub rows: usize,
    pub columns: usize,
}

impl Shape {
    pub fn new(rows: usize, columns: usize) -> Shape {
        Shape { rows, columns }
    }

    /// Rows of the spectrum.
    pub fn bins(self) -> usize {
        self.rows / 2 + 1
    }

    pub fn samples(self) -> usize {
        self.rows * self.columns
    }

    /// Bytes of the array and of its spectrum.
    pub fn bytes(self, precision: Precision) -> usize {
        self.columns * (self.rows + 2 * self.bins()) * size(precision)
    }

    /// `2.5 n log2 n` operations a column.
    pub fn operations(self) -> f64 {
        2.5 * self.samples() as f64 * (self.rows as f64).log2()
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.rows, self.columns)
    }
}

impl FromStr for Shape {
    type Err = String;

    /// `ROWSxCOLUMNS`; not larger than could be addressed.
    fn from_str(text: &str) -> std::result::Result<Shape, String> {
        let number = |text: &str| text.parse().ok().filter(|&n: &usize| n > 0);
        let shape = text.split_once('x').and_then(|(rows, columns)| {
            let (rows, columns) = (number(rows)?, number(columns)?);
            let bytes = rows.checked_add(2)?.checked_mul(columns)?.checked_mul(16)?;
            (bytes <= isize::MAX as usize).then_some(Shape { rows, columns })
        });
        shape.ok_or_else(|| "expected ROWSxCOLUMNS, such as 4096x300, each at least 1".into())
    }
}

/// A shape, the numbers' type and the threads that share the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct CaseOf {
    #[serde(flatten)]
    pub shape: Shape,
    pub precision: Precision,
    pub threads: usize,
}

impl CaseOf {
    /// The short form: `2^12` and `2^14` rows, and a prime number of them.
    pub const SHORT: [Shape; 3] = [
        Shape {
            rows: 4096,
            columns: 300,
        },
        Shape {
            rows: 16384,
            columns: 300,
        },
        Shape {
            rows: 10007,
            columns: 300,
        },
    ];

    /// The shape, and bytes of its array and spectrum or of the copy that is timed after them
    /// ([`super::copy_rate`]), whichever are more.
    pub fn memory(&self) -> (Shape, u64) {
        let bytes = self.shape.bytes(self.precision) as u64;
        (self.shape, bytes.max(super::rounds::COPIED_BYTES))
    }
}

/// How many cases, given by their shapes and bytes, fit the memory that is free at once, whichever
/// they are; `most` at most.
///
/// # Errors
/// [`Error::Request`] for `--shape` where one of them alone does not fit.
pub fn fit_memory(cases: impl Iterator<Item = (Shape, u64)>, most: usize) -> Result<usize> {
    let free = free_memory();
    fitting(cases, most, free).map_err(|(shape, needed)| Error::Request {
        option: "shape",
        expected: format!(
            "arrays that fit {} of free memory",
            crate::error::size(free)
        ),
        found: format!(
            "{shape}, for which {} are needed",
            crate::error::size(needed)
        ),
    })
}

/// How many of the largest cases fit together, or the largest where it does not.
fn fitting(
    cases: impl Iterator<Item = (Shape, u64)>,
    most: usize,
    free: u64,
) -> std::result::Result<usize, (Shape, u64)> {
    let mut cases: Vec<(Shape, u64)> = cases.collect();
    cases.sort_by_key(|&(_, bytes)| std::cmp::Reverse(bytes));
    let mut left = free;
    let fit = cases.iter().take(most).take_while(|&&(_, bytes)| {
        let fits = bytes <= left;
        left = left.saturating_sub(bytes);
        fits
    });
    match (fit.count(), cases.first()) {
        (0, Some(&largest)) => Err(largest),
        (count, _) => Ok(count),
    }
}

fn free_memory() -> u64 {
    2 * crate::analyze::half_of_free_memory()
}

impl fmt::Display for CaseOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let CaseOf {
            shape,
            precision,
            threads,
        } = self;
        let s = if *threads == 1 { "" } else { "s" };
        write!(f, "{shape} {}, {threads} thread{s}", name(*precision))
    }
}

/// `f64` or `f32`.
pub fn name(precision: Precision) -> &'static str {
    match precision {
        Precision::F64 => "f64",
        Precision::F32 => "f32",
    }
}

fn size(precision: Precision) -> usize {
    match precision {
        Precision::F64 => size_of::<f64>(),
        Precision::F32 => size_of::<f32>(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_two_numbers() {
        assert_eq!("4096x300".parse(), Ok(Shape::new(4096, 300)));
        for wrong in [
            "",
            "4096",
            "0x3",
            "3x0",
            "-1x2",
            "1x2x3",
            "4096×300",
            "99999999999999999999x1",
        ] {
            assert!(wrong.parse::<Shape>().is_err(), "{wrong}");
        }
        let too_large = format!("{}x{}", 1_u64 << 40, 1_u64 << 30);
        assert!(too_large.parse::<Shape>().is_err());
    }

    /// By hand: the copy is of 128 MiB to as many, and goes after the arrays.
    #[test]
    fn memory_is_that_of_the_arrays_or_of_the_copy() {
        let bytes = |shape: Shape| {
            let precision = Precision::F64;
            CaseOf {
                shape,
                precision,
                threads: 1,
            }
            .memory()
            .1
        };
        assert_eq!(bytes(Shape::new(64, 9)), 256 << 20);
        let large = 3000 * (16384 + 2 * 8193) * 8;
        assert_eq!(bytes(Shape::new(16384, 3000)), large);
    }

    #[test]
    fn as_many_run_at_once_as_the_largest_fit() {
        let of = |rows| Shape::new(rows, 1);
        let cases = [(of(1), 10), (of(2), 1000), (of(3), 100)];
        let found = |most, free| fitting(cases.into_iter(), most, free);
        assert_eq!([1, 2, 9].map(|most| found(most, 9999)), [1, 2, 3].map(Ok));
        let free = [1000, 1099, 1100, 1109, 1110];
        assert_eq!(free.map(|free| found(9, free)), [1, 1, 2, 2, 3].map(Ok));
        assert_eq!(found(9, 999), Err((of(2), 1000)));
        let refused = fit_memory([(of(1), 1), (of(2), u64::MAX)].into_iter(), 2);
        let said = refused.unwrap_err().to_string();
        assert!(said.contains("2x1, for which"), "{said}");
    }

    #[test]
    fn bytes_are_those_of_array_and_spectrum() {
        let shape = Shape::new(5, 3);
        assert_eq!(shape.bytes(Precision::F64), (5 * 3 + 3 * 3 * 2) * 8);
        assert_eq!(Shape::new(4, 2).operations(), 2.5 * 8.0 * 2.0);
    }
}
