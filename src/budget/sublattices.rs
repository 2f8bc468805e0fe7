//! Filters over unit cells, of several rows along a chain at once.
//!
//! Each sublattice is filtered by itself. Gains are real, and alike at k and -k, so that filtering a
//! complex row filters its two parts: two sublattices of a row go through one transform.

use std::sync::Arc;

use column_fft::{Fft, FftDirection, rows};
use num_complex::Complex;

/// The transforms over a ring of cells, planned.
pub(super) struct Sublattices {
    /// Sites in a cell.
    cell: usize,
    cells: usize,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
}

/// Rows of one instant, transformed, and what filtering them needs.
#[derive(Debug, Clone, Default)]
pub(super) struct Filtered {
    /// Pairs of sublattices, row by row.
    transformed: Vec<Complex<f64>>,
    weighted: Vec<Complex<f64>>,
    pairs: Vec<Complex<f64>>,
    work: Vec<Complex<f64>>,
    rows: Vec<f64>,
}

impl Sublattices {
    pub(super) fn new(cell: usize, cells: usize) -> Sublattices {
        Sublattices {
            cell,
            cells,
            forward: rows::plan_fft_complex(cells, FftDirection::Forward),
            inverse: rows::plan_fft_complex(cells, FftDirection::Inverse),
        }
    }

    /// Sites of a row, in whole cells.
    pub(super) fn sites(&self) -> usize {
        self.cells * self.cell
    }

    /// Gains at all wavenumbers of the ring from those at `0 ..= cells / 2`, with the factor of the
    /// inverse transform, each for both parts of a number.
    pub(super) fn gains(&self, gains: &[f64]) -> Vec<f64> {
        let gain = |m: usize| gains[m.min(self.cells - m)] / self.cells as f64;
        (0..self.cells).flat_map(|m| [gain(m); 2]).collect()
    }

    /// Transforms rows; places behind the end of one count as 0.
    pub(super) fn transform(&self, rows: &[&[f64]], scratch: &mut Filtered) {
        let (transformed, work) = (&mut scratch.transformed, &mut scratch.work);
        let zero = Complex::default();
        transformed.clear();
        for row in rows {
            for first in (0..self.cell).step_by(2) {
                let cells = row.chunks(self.cell);
                let pair = |cell: &[f64]| {
                    let part = |i: usize| match first + i < self.cell {
                        true => cell.get(first + i).copied().unwrap_or(0.0),
                        false => 0.0,
                    };
                    Complex::new(part(0), part(1))
                };
                let end = transformed.len() + self.cells;
                transformed.extend(cells.map(pair));
                transformed.resize(end, zero);
            }
        }
        for buffer in [&mut scratch.weighted, &mut scratch.pairs] {
            buffer.resize(transformed.len(), zero);
        }
        let forward = self.forward.get_inplace_scratch_len();
        let inverse = self.inverse.get_outofplace_scratch_len();
        work.resize(forward.max(inverse), zero);
        self.forward.process_with_scratch(transformed, work);
    }

    /// The transformed rows, filtered; each is [`Sublattices::sites`] long.
    pub(super) fn filter<'s>(
        &self,
        gains: &[f64],
        scratch: &'s mut Filtered,
    ) -> std::slice::ChunksExact<'s, f64> {
        let (weighted, pairs) = (&mut scratch.weighted, &mut scratch.pairs);
        let from = scratch.transformed.chunks_exact(self.cells);
        for (to, from) in weighted.chunks_exact_mut(self.cells).zip(from) {
            let parts: (&mut [f64], &[f64]) =
                (bytemuck::cast_slice_mut(to), bytemuck::cast_slice(from));
            for ((to, from), gain) in parts.0.iter_mut().zip(parts.1).zip(gains) {
                *to = from * gain;
            }
        }
        self.inverse
            .process_outofplace_with_scratch(weighted, pairs, &mut scratch.work);
        if self.cell == 2 {
            // The two parts of a cell are its sites.
            return bytemuck::cast_slice(pairs).chunks_exact(self.sites());
        }
        let of_a_row = self.cell.div_ceil(2);
        let rows = &mut scratch.rows;
        rows.resize(pairs.len() / of_a_row * self.cell, 0.0);
        for (i, pair) in pairs.chunks_exact(self.cells).enumerate() {
            let (row, first) = (i / of_a_row, 2 * (i % of_a_row));
            let row = &mut rows[row * self.sites()..][..self.sites()];
            for (cell, z) in row.chunks_exact_mut(self.cell).zip(pair) {
                for (to, part) in cell[first..].iter_mut().zip([z.re, z.im]) {
                    *to = part;
                }
            }
        }
        rows.chunks_exact(self.sites())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the sum that defines a filter, over each sublattice of rows shorter than the ring.
    #[test]
    fn val_defining_sum() {
        for (cell, cells) in [(1, 7), (2, 6), (3, 5), (4, 1), (5, 8)] {
            let lattice = Sublattices::new(cell, cells);
            let gain = |m: usize| 1.0 / (1.0 + m as f64);
            let gains: Vec<f64> = (0..=cells / 2).map(gain).collect();
            let gains = lattice.gains(&gains);
            let length = lattice.sites() - usize::from(cells > 1);
            let row = |seed: f64| -> Vec<f64> {
                let value = |j: usize| (seed * j as f64).sin() + 0.3;
                (0..length).map(value).collect()
            };
            let rows = [row(1.3), row(2.1), row(0.4)];
            let mut scratch = Filtered::default();
            lattice.transform(&[&rows[0], &rows[1], &rows[2]], &mut scratch);
            let found = lattice.filter(&gains, &mut scratch);
            assert_eq!(found.len(), 3);
            for (found, row) in found.zip(&rows) {
                for (j, found) in found.iter().enumerate() {
                    let weight = |i: usize| -> f64 {
                        let angle = |m: usize| {
                            let turns = m * (j / cell + cells - i / cell) % cells;
                            2.0 * std::f64::consts::PI * turns as f64 / cells as f64
                        };
                        (0..cells).map(|m| gains[2 * m] * angle(m).cos()).sum()
                    };
                    let sublattice = (j % cell..length).step_by(cell);
                    let expected: f64 = sublattice.map(|i| weight(i) * row[i]).sum();
                    assert!((found - expected).abs() < 2e-15, "{cell} {cells} {j}");
                }
            }
        }
    }
}
