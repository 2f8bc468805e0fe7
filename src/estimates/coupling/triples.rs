//! Triples of frequencies `f1 + f2 = f3`.

use std::ops::Range;

/// The triples of bins that hold all there is: no bin 0, none at or above the Nyquist frequency.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Triples {
    /// The highest bin.
    pub last: usize,
    pub rows: Vec<TripleRow>,
}

/// Triples with one second bin, which is negative in a difference.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct TripleRow {
    pub second: isize,
    pub first: Range<usize>,
    /// Index of the first of its cells.
    pub offset: usize,
}

impl Triples {
    /// `first >= second >= least`: of one record the others repeat these. Bins less than `least` apart share
    /// power, which the first and the third must not.
    pub fn of_one(last: usize, least: usize) -> Triples {
        let sums = (least..=last / 2).map(|second| (second as isize, second..last + 1 - second));
        Triples::new(last, sums)
    }

    /// With differences, `first + second` of both signs of `second`: another record at the third frequency tells
    /// them apart. Without those whose third bin shares power with the one that is subtracted.
    pub fn of_two(last: usize, least: usize) -> Triples {
        let differences = (least..last).rev().flat_map(|size| {
            let below = size + 1..(2 * size + 1).saturating_sub(least).min(last + 1);
            let above = 2 * size + least..last + 1;
            [below, above].map(|first| (-(size as isize), first))
        });
        let sums = (least..=last / 2).map(|second| (second as isize, second..last + 1 - second));
        Triples::new(last, differences.chain(sums))
    }

    fn new(last: usize, rows: impl Iterator<Item = (isize, Range<usize>)>) -> Triples {
        let mut offset = 0;
        let rows = rows.filter(|(_, first)| !first.is_empty());
        let rows = rows.map(|(second, first)| {
            let row = TripleRow {
                second,
                offset,
                first,
            };
            offset += row.first.len();
            row
        });
        Triples {
            rows: rows.collect(),
            last,
        }
    }

    /// Number of triples.
    pub fn cells(&self) -> usize {
        let last = self.rows.last();
        last.map_or(0, |row| row.offset + row.first.len())
    }

    /// Bins of all triples, `[first, second, third]`.
    pub fn bins(&self) -> impl Iterator<Item = [isize; 3]> {
        self.rows.iter().flat_map(|row| {
            row.first.clone().map(|first| {
                let first = first as isize;
                [first, row.second, first + row.second]
            })
        })
    }
}
