//! Large arrays reduced for the eye: what comes of it, and how fine.

use std::ops::Range;

use crate::unit::in_powers_of_ten;

/// Largest number of cells of a map, `(rows, columns)`: the resolution of a page.
pub(crate) const MAP_LIMIT: (usize, usize) = (400, 300);

/// Numbers held while a map is collected in fine cells, 4 MB.
const FINE_NUMBERS: usize = 1 << 19;

/// Most fine cells along an axis, and along the shorter one of two.
const FINE_LIMIT: (usize, usize) = (4096, 512);

/// What of a block is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Keep {
    Largest,
    Extreme,
}

impl Keep {
    /// Numbers held for each cell.
    pub(super) fn numbers(self) -> usize {
        match self {
            Keep::Largest => 1,
            Keep::Extreme => 2,
        }
    }

    /// Most cells of an array of `shape` that is collected so fine that parts of it can be shown:
    /// many along its longer axis, at least those of a map.
    pub fn fine_limit(self, (rows, columns): (usize, usize)) -> (usize, usize) {
        let all = FINE_NUMBERS / self.numbers();
        let short = rows.min(columns).clamp(1, FINE_LIMIT.1);
        let long = (all / short).min(FINE_LIMIT.0);
        match rows < columns {
            true => (short, long),
            false => (long, short),
        }
    }

    /// Bytes of a map of an array of `shape`, while it is collected in at most `limit` cells and
    /// when it is finished with its detail.
    pub fn bytes(self, shape: (usize, usize), limit: (usize, usize)) -> u64 {
        let cells = |limit: (usize, usize)| {
            let (rows, columns) = block_size(shape, limit);
            (shape.0.div_ceil(rows) * shape.1.div_ceil(columns)) as u64
        };
        let singles = 2 * self.numbers() as u64 - 1;
        8 * self.numbers() as u64 * cells(limit) + 2 * 4 * singles * cells(MAP_LIMIT)
    }
}

/// Rows and columns of the blocks of an array of `shape` in at most `limit` cells a side. Where cells are
/// finer than those of a map, whole numbers of them make one of at most its size.
pub(super) fn block_size(shape: (usize, usize), limit: (usize, usize)) -> (usize, usize) {
    let side = |all: usize, limit: usize, coarse: usize| {
        let (least, coarse) = (all.div_ceil(limit).max(1), all.div_ceil(coarse).max(1));
        let parts = (coarse / least).max(1);
        coarse.div_ceil(parts).max(least)
    };
    let rows = side(shape.0, limit.0, MAP_LIMIT.0);
    (rows, side(shape.1, limit.1, MAP_LIMIT.1))
}

/// Rows and columns of an array that figures show, each by index.
pub(crate) type Part = (Range<usize>, Range<usize>);

/// A power of ten in whose units values are within single precision; 1 where they are anyway.
#[derive(Debug, Clone, Copy)]
pub(super) struct PowerOfTen {
    exponent: i32,
    /// In two steps, since 10^-exponent may be out of range.
    factors: (f64, f64),
}

impl PowerOfTen {
    pub fn of(largest: f64) -> Self {
        let fits = largest == 0.0 || (1e-20..1e20).contains(&largest) || !largest.is_finite();
        let exponent = match fits {
            true => 0,
            false => largest.log10().floor() as i32,
        };
        let half = -exponent / 2;
        let factors = (10f64.powi(half), 10f64.powi(-exponent - half));
        PowerOfTen { exponent, factors }
    }

    pub fn single(self, value: f64) -> f32 {
        (value * self.factors.0 * self.factors.1) as f32
    }

    pub fn label(self, label: String) -> String {
        match self.exponent {
            0 => label,
            exponent => in_powers_of_ten(&label, exponent),
        }
    }
}
