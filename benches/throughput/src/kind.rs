//! Kinds of benchmarked transforms.

use std::fmt;

use crate::ArrayShape;

/// Length and hop of short-time segments, in samples.
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
pub enum TransformKind {
    /// All columns of an array: [`column_fft::RealToComplexColumns`].
    Columns,
    /// Both axes of an array: [`column_fft::RealToComplex2d`].
    Plane,
    /// Segments of 256 samples, 32 apart, of all columns, weighed by Hann's window:
    /// [`column_fft::ShortTimeColumns`].
    ShortTime,
}

impl TransformKind {
    pub const ALL: [TransformKind; 3] = [
        TransformKind::Columns,
        TransformKind::Plane,
        TransformKind::ShortTime,
    ];

    /// Arrays of the short benchmark. For columns: `2^12`, `2^14` and a prime number of rows.
    pub fn short(self) -> &'static [ArrayShape] {
        const fn of(rows: usize, columns: usize) -> ArrayShape {
            ArrayShape { rows, columns }
        }
        match self {
            TransformKind::Columns => const { &[of(4096, 300), of(16384, 300), of(10007, 300)] },
            TransformKind::Plane => const { &[of(2048, 2048)] },
            TransformKind::ShortTime => const { &[of(16384, 300)] },
        }
    }

    /// Precisions of the short benchmark.
    pub fn precisions(self) -> &'static [Precision] {
        match self {
            TransformKind::Columns => &[Precision::F64, Precision::F32],
            TransformKind::Plane | TransformKind::ShortTime => &[Precision::F64],
        }
    }

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            TransformKind::Columns => "columns",
            TransformKind::Plane => "plane",
            TransformKind::ShortTime => "short-time",
        }
    }
}

impl fmt::Display for TransformKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
