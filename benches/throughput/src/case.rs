//! Benchmark cases: kind, shape, precision, threads.

use std::fmt;
use std::str::FromStr;

use crate::Precision;
use crate::kind::{HOP, SEGMENT};
use crate::planes::{Plane, ShortTime};
use crate::ways::TILE;
use crate::{Arrays, PlannedTransform, TransformKind};
use crate::{Error, Result};
use column_fft::{Real, RealToComplexColumns, ShortTimeColumns};
use wavecascade_system::memory::{half_of_free_memory, size as size_of_memory};

/// Rows (samples of a column) and columns of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
pub struct ArrayShape {
    pub rows: usize,
    pub columns: usize,
}

impl ArrayShape {
    pub fn new(rows: usize, columns: usize) -> ArrayShape {
        ArrayShape { rows, columns }
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
}

impl fmt::Display for ArrayShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.rows, self.columns)
    }
}

impl FromStr for ArrayShape {
    type Err = String;

    /// Parses `ROWSxCOLUMNS`; rejects arrays too large to address.
    fn from_str(text: &str) -> std::result::Result<ArrayShape, String> {
        let number = |text: &str| text.parse().ok().filter(|&n: &usize| n > 0);
        let shape = text.split_once('x').and_then(|(rows, columns)| {
            let (rows, columns) = (number(rows)?, number(columns)?);
            let bytes = rows.checked_add(2)?.checked_mul(columns)?.checked_mul(16)?;
            (bytes <= isize::MAX as usize).then_some(ArrayShape { rows, columns })
        });
        shape.ok_or_else(|| "expected ROWSxCOLUMNS, such as 4096x300, each at least 1".into())
    }
}

/// A benchmark case: the kind of transform, the array's shape, its precision and the number of
/// threads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct CaseOf {
    pub kind: TransformKind,
    #[serde(flatten)]
    pub shape: ArrayShape,
    pub precision: Precision,
    pub threads: usize,
}

impl CaseOf {
    /// Checks that there is something to transform.
    ///
    /// # Errors
    /// [`Error::Shape`] where columns are shorter than a segment.
    pub fn check(&self) -> Result<()> {
        match self.kind {
            TransformKind::ShortTime if self.shape.rows < SEGMENT => Err(Error::Shape {
                expected: format!("at least {SEGMENT} rows, a short-time segment"),
                found: self.shape.to_string(),
            }),
            _ => Ok(()),
        }
    }

    /// Allocates the arrays and plans all implementations for them.
    ///
    /// # Errors
    /// As [`CaseOf::check`]; [`Error::Memory`] where there is no memory.
    pub fn prepare(&self) -> Result<Box<dyn PlannedTransform>> {
        self.check()?;
        match self.precision {
            Precision::F64 => self.prepare_of::<f64>(),
            Precision::F32 => self.prepare_of::<f32>(),
        }
    }

    fn prepare_of<T: Real>(&self) -> Result<Box<dyn PlannedTransform>> {
        Ok(match self.kind {
            TransformKind::Columns => Box::new(Arrays::<T>::new(self.shape)?),
            TransformKind::Plane => Box::new(Plane::<T>::new(self.shape)?),
            TransformKind::ShortTime => Box::new(ShortTime::<T>::new(self.shape)?),
        })
    }

    /// Operations: `2.5 n log2 n` per real transform of n samples (a column, the plane, or a
    /// segment of a column).
    pub fn operations(&self) -> f64 {
        let ArrayShape { rows, columns } = self.shape;
        let (length, times) = match self.kind {
            TransformKind::Columns => (rows, columns),
            TransformKind::Plane => (self.shape.samples(), 1),
            TransformKind::ShortTime => (SEGMENT, self.segments() * columns),
        };
        2.5 * length as f64 * (length as f64).log2() * times as f64
    }

    /// Bytes of the array and of its spectra.
    pub fn bytes(&self) -> u64 {
        let ArrayShape { rows, columns } = self.shape;
        match self.kind {
            TransformKind::Columns | TransformKind::Plane => {
                self.shape.bytes(self.precision) as u64
            }
            TransformKind::ShortTime => {
                let bins = self.segments() as u64 * (SEGMENT as u64 / 2 + 1);
                let numbers = (rows as u64).saturating_add(bins.saturating_mul(2));
                let row = (columns * size(self.precision)) as u64;
                numbers.saturating_mul(row)
            }
        }
    }

    /// Segments per column; 0 where [`CaseOf::check`] fails.
    fn segments(&self) -> usize {
        let rest = self.shape.rows.checked_sub(SEGMENT);
        rest.map_or(0, |rest| rest / HOP + 1)
    }

    /// The case, and bytes of its arrays and working space or of the copy that is timed after them
    /// ([`crate::copy_rate`]), whichever are more; [`CaseOf::check`] comes first.
    pub fn memory(&self) -> (CaseOf, u64) {
        (*self, self.needed(free_memory()))
    }

    fn needed(&self, free: u64) -> u64 {
        let mut bytes = self.bytes();
        // Arrays that do not fit are not planned; planning takes time.
        if bytes <= free {
            bytes += self.threads as u64 * self.working_bytes();
        }
        bytes.max(crate::rounds::COPIED_BYTES)
    }

    /// Scratch of one thread: our own, and the columns gathered by the reference implementations.
    fn working_bytes(&self) -> u64 {
        let ArrayShape { rows, columns } = self.shape;
        let row = columns * size(self.precision);
        let (length, weighed) = match self.kind {
            TransformKind::Columns | TransformKind::Plane => (rows, 0),
            TransformKind::ShortTime => (SEGMENT, SEGMENT * row),
        };
        let ours = match self.precision {
            Precision::F64 => self.own_working_bytes::<f64>(length),
            Precision::F32 => self.own_working_bytes::<f32>(length),
        };
        ours + (weighed + ArrayShape::new(length, TILE).bytes(self.precision)) as u64
    }

    fn own_working_bytes<T: Real>(&self, length: usize) -> u64 {
        let columns = self.shape.columns;
        let numbers = match self.kind {
            TransformKind::Columns | TransformKind::Plane => {
                RealToComplexColumns::<T>::scratch_len_of(length, columns, columns)
            }
            TransformKind::ShortTime => {
                ShortTimeColumns::<T>::scratch_len_of(length, columns, columns)
            }
        };
        (numbers * 2 * size_of::<T>()) as u64
    }
}

/// The number of cases, given with their bytes, of which any choice fits into free memory at once;
/// at most `most`.
///
/// # Errors
/// [`Error::Shape`] where one of them alone does not fit.
pub fn fit_memory<C: fmt::Display>(
    cases: impl Iterator<Item = (C, u64)>,
    most: usize,
) -> Result<usize> {
    let free = free_memory();
    fitting(cases, most, free).map_err(|(case, needed)| Error::Shape {
        expected: format!("arrays that fit {} of free memory", size_of_memory(free)),
        found: format!("{case}, for which {} are needed", size_of_memory(needed)),
    })
}

/// The number of largest cases that fit together; the largest case as an error if it alone does not
/// fit.
fn fitting<C>(
    cases: impl Iterator<Item = (C, u64)>,
    most: usize,
    free: u64,
) -> std::result::Result<usize, (C, u64)> {
    let mut cases: Vec<(C, u64)> = cases.collect();
    cases.sort_by_key(|&(_, bytes)| std::cmp::Reverse(bytes));
    let mut left = free;
    let fit = cases.iter().take(most).take_while(|&&(_, bytes)| {
        let fits = bytes <= left;
        left = left.saturating_sub(bytes);
        fits
    });
    match (fit.count(), cases.into_iter().next()) {
        (0, Some(largest)) => Err(largest),
        (count, _) => Ok(count),
    }
}

fn free_memory() -> u64 {
    2 * half_of_free_memory()
}

impl fmt::Display for CaseOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let CaseOf {
            kind,
            shape,
            precision,
            threads,
        } = self;
        // Names of columns have no kind: their baselines predate the other kinds.
        if *kind != TransformKind::Columns {
            write!(f, "{kind} ")?;
        }
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
        assert_eq!("4096x300".parse(), Ok(ArrayShape::new(4096, 300)));
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
            assert!(wrong.parse::<ArrayShape>().is_err(), "{wrong}");
        }
        let too_large = format!("{}x{}", 1_u64 << 40, 1_u64 << 30);
        assert!(too_large.parse::<ArrayShape>().is_err());
    }

    fn of(kind: TransformKind, rows: usize, columns: usize) -> CaseOf {
        CaseOf {
            kind,
            shape: ArrayShape::new(rows, columns),
            precision: Precision::F64,
            threads: 1,
        }
    }

    /// By hand: the copy takes two buffers of 128 MiB, after the arrays are freed. Rows of 20480
    /// samples are 40 x 4096 bytes apart (a critical stride), so 8 cache lines of each are copied;
    /// 2048 = 64 x 32. Rows of 3001 samples have no critical stride; 256 = 32 x 8.
    #[test]
    fn val_memory_is_that_of_the_arrays_or_of_the_copy() {
        let bytes = |case: CaseOf| case.needed(u64::MAX);
        assert_eq!(bytes(of(TransformKind::Columns, 64, 9)), 256 << 20);
        let width = RealToComplexColumns::<f64>::new(2048).unwrap().width() as u64;
        let arrays = 20480 * (2048 + 2 * 1025) * 8;
        // Plus a cache line for the alignment.
        let scratch = 2 * width * (64 + 33 * 34) * 8 + 64;
        let tile = 8 * (2048 + 2 * 1025) * 8;
        let working = scratch + 2048 * 512 + tile;
        for kind in [TransformKind::Columns, TransformKind::Plane] {
            let case = of(kind, 2048, 20480);
            assert_eq!(bytes(case), arrays + working);
            assert_eq!(bytes(CaseOf { threads: 3, ..case }), arrays + 3 * working);
        }
        let hopeless = of(TransformKind::Columns, 2048, 20480);
        assert_eq!(hopeless.needed(arrays - 1), arrays);
        let arrays = 3001 * (16384 + 505 * 129 * 2) * 8;
        let working =
            2 * width * (32 + 17 * 10) * 8 + 64 + 256 * 3001 * 8 + 8 * (256 + 2 * 129) * 8;
        // A megabyte holds 508 columns, rounded down to whole tiles.
        let assembled = 129 * (508 / width * width) * 16;
        assert_eq!(
            bytes(of(TransformKind::ShortTime, 16384, 3001)),
            arrays + working + assembled
        );
        // Rows of whole cache lines need no assembly buffer.
        let arrays = 3000 * (16384 + 505 * 129 * 2) * 8;
        let working = working - 256 * 8;
        assert_eq!(
            bytes(of(TransformKind::ShortTime, 16384, 3000)),
            arrays + working
        );
    }

    #[test]
    fn as_many_run_at_once_as_the_largest_fit() {
        let of = |rows| ArrayShape::new(rows, 1);
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
    fn val_bytes_and_operations_by_hand() {
        assert_eq!(
            of(TransformKind::Columns, 5, 3).bytes(),
            (5 * 3 + 3 * 3 * 2) * 8
        );
        let operations = |kind, rows, columns| of(kind, rows, columns).operations();
        assert_eq!(operations(TransformKind::Columns, 4, 2), 2.5 * 8.0 * 2.0);
        assert_eq!(operations(TransformKind::Plane, 4, 2), 2.5 * 8.0 * 3.0);
        // Three segments begin in 320 rows.
        assert_eq!(
            of(TransformKind::ShortTime, 320, 7).bytes(),
            7 * (320 + 3 * 129 * 2) * 8
        );
        let one = 2.5 * 256.0 * 8.0;
        assert_eq!(
            operations(TransformKind::ShortTime, 320, 7),
            3.0 * 7.0 * one
        );
    }

    #[test]
    fn records_of_columns_keep_their_names() {
        let names = TransformKind::ALL.map(|kind| of(kind, 256, 3).to_string());
        let expected = ["", "plane ", "short-time "];
        assert_eq!(
            names,
            expected.map(|kind| format!("{kind}256x3 f64, 1 thread"))
        );
        assert!(of(TransformKind::ShortTime, 255, 3).check().is_err());
        assert!(of(TransformKind::Plane, 1, 1).check().is_ok());
    }
}
