//! Kinds of transforms that are measured.

use std::fmt;

use crate::Shape;

/// Samples of a short-time segment, and from one to the next.
pub const SEGMENT: usize = 256;
pub const HOP: usize = 32;

/// The type of the numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    F64,
    F32,
}

/// What is transformed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// All columns of an array: [`column_fft::RealToComplexColumns`].
    Columns,
    /// Both axes of an array: [`column_fft::RealToComplex2d`].
    Plane,
    /// Segments of 256 samples, 32 apart, of all columns, weighed by Hann's window:
    /// [`column_fft::ShortTimeColumns`].
    ShortTime,
}

impl Kind {
    pub const ALL: [Kind; 3] = [Kind::Columns, Kind::Plane, Kind::ShortTime];

    /// The short form's arrays; of columns `2^12` and `2^14` rows, and a prime number of them.
    pub fn short(self) -> &'static [Shape] {
        const fn of(rows: usize, columns: usize) -> Shape {
            Shape { rows, columns }
        }
        match self {
            Kind::Columns => const { &[of(4096, 300), of(16384, 300), of(10007, 300)] },
            Kind::Plane => const { &[of(2048, 2048)] },
            Kind::ShortTime => const { &[of(16384, 300)] },
        }
    }

    /// The short form's number types.
    pub fn precisions(self) -> &'static [Precision] {
        match self {
            Kind::Columns => &[Precision::F64, Precision::F32],
            Kind::Plane | Kind::ShortTime => &[Precision::F64],
        }
    }

    /// As it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Columns => "columns",
            Kind::Plane => "plane",
            Kind::ShortTime => "short-time",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
