//! Passes over a field for its increments: sums of powers, and histograms.

use std::ops::Range;

use rayon::prelude::*;

use super::Along;
use super::moments::{LOCAL, MOVED, ORDERS, PowerSums, Sums};
use crate::error::{Error, Result};
use crate::estimates::FieldAxis;
use crate::estimates::realisations::TOGETHER;
use crate::field::Field;
use crate::system::check_memory;

/// Parts of the times whose sums are kept apart.
pub(super) const PARTS: usize = 16;
/// Blocks of a part, between which its level is taken as steady.
const QUARTERS: usize = 4;
/// Blocks of times.
const BLOCKS: usize = QUARTERS * PARTS;
/// Pairs of sites a separation apart, spread evenly, whose local flatness is looked at.
const PAIRS: usize = 256;
/// Samples that are read together.
const READ: usize = 1 << 17;
/// Cells of a histogram.
pub(super) const CELLS: usize = 80;
/// Its reach, in root mean squares to both sides.
pub(super) const REACH: f64 = 10.0;

/// Of a pair of sites, or of a record and itself a lag on, over a block of times: increments, those that are not 0, sums
/// of squares and of fourth powers.
type Cell = [f64; 4];

/// Numerator and denominator of the local flatness: `sum d^4` over a part, and what a normal distribution of
/// the same level has of it, times 3.
///
/// The square of the variance is a mean of products of blocks that are not neighbours. Those are independent, so that few
/// samples do not bias it, and their level is that of this pair and this part alone. Increments of
/// exactly 0 are of samples that are clipped, held or the same: those left over are taken as all there are, and the fourth
/// powers as many times smaller as held samples can make them larger.
fn local(blocks: [Cell; QUARTERS]) -> Sums {
    let product = |of: usize| {
        let [a, b, c, d] = blocks.map(|cell| cell[of]);
        a * c + a * d + b * d
    };
    let all = |of: usize| blocks.iter().map(|cell| cell[of]).sum::<f64>();
    let mut sums = Sums::default();
    if product(1) > 0.0 {
        sums[LOCAL[0]] = all(3) * all(1) / all(0);
        sums[LOCAL[1]] = all(1) * product(2) / product(1);
    }
    sums
}

/// Sums of parts and steps, and cells that are not yet part of them.
struct Tally {
    parts: Vec<Vec<PowerSums>>,
    cells: Vec<Cell>,
}

/// Counts of a histogram, and of what is beyond its ends.
pub(super) type Counts = [u64; CELLS + 2];

/// Adds the counts of histograms.
pub(super) fn add_counts(sums: &mut [Counts], counts: &[Counts]) {
    let cells = sums.iter_mut().flatten().zip(counts.iter().flatten());
    cells.for_each(|(sum, count)| *sum += count);
}

impl Along<'_> {
    /// Sums of powers `[part][step]`, of the increments of a field that begin in each part of the times.
    ///
    /// # Errors
    /// [`Error::Memory`]; [`Error::Cancelled`].
    pub fn sums(&self, field: &Field) -> Result<Vec<Vec<Sums>>> {
        let count = self.steps.len();
        let threads = rayon::current_num_threads() as u64;
        let (times, sites) = (field.n_times() as u64, field.n_sites() as u64);
        let samples = [sites.max(READ as u64), times * TOGETHER as u64];
        let sums = (16 * PARTS * count * size_of::<Sums>()) as u64;
        let cells = (BLOCKS * count * PAIRS * size_of::<Cell>()) as u64;
        let needed = threads * (8 * self.axis.of(samples) + sums) + cells;
        check_memory("the records of a few sites", needed, self.request.memory)?;
        let empty = || Tally {
            parts: vec![vec![PowerSums::default(); count]; PARTS],
            cells: vec![Cell::default(); self.axis.of([count * PAIRS, 0])],
        };
        let visit = |tally: &mut Tally, block: usize, step: usize, a: &[f64], b: &[f64]| {
            let sums = &mut tally.parts[block / QUARTERS][step];
            if self.axis == FieldAxis::Space {
                sums.add(a, b);
                let apart = a.len().div_ceil(PAIRS);
                let cells = tally.cells[step * PAIRS..].iter_mut();
                for (cell, (a, b)) in cells.zip(a.iter().zip(b).step_by(apart)) {
                    let d = b - a;
                    if d.is_finite() {
                        let of_one = [1.0, f64::from(d != 0.0), d * d, d.powi(4)];
                        *cell = std::array::from_fn(|i| cell[i] + of_one[i]);
                    }
                }
                return;
            }
            let mut of_block = PowerSums::default();
            of_block.add(a, b);
            let total = of_block.total();
            sums.join(total);
            tally.cells.push([0, MOVED, 2, 4].map(|i| total[i]));
            if let Ok(blocks) = tally.cells.as_slice().try_into() {
                sums.join(local(blocks));
                tally.cells.clear();
            }
        };
        let all = self.each(field, empty, visit)?;
        let mut joined = empty().parts;
        for tally in &all {
            let parts = joined.iter_mut().zip(&tally.parts);
            for (joined, sums) in parts.flat_map(|(joined, sums)| joined.iter_mut().zip(sums)) {
                joined.join(sums.total());
            }
        }
        if self.axis == FieldAxis::Space {
            for (part, blocks) in joined.iter_mut().zip(all.chunks_exact(QUARTERS)) {
                for i in 0..count * PAIRS {
                    part[i / PAIRS].join(local(std::array::from_fn(|b| blocks[b].cells[i])));
                }
            }
        }
        // Of each part one flatness, whatever its level.
        let totals = |sums: &PowerSums| {
            let mut total = sums.total();
            let [above, below] = LOCAL.map(|i| total[i]);
            let is_known = below > 0.0;
            total[LOCAL[0]] = if is_known { above / below } else { 0.0 };
            total[LOCAL[1]] = f64::from(is_known);
            total
        };
        let found = joined.iter().map(|part| part.iter().map(totals).collect());
        let found: Vec<Vec<Sums>> = found.collect();
        // Of every sum of magnitudes, there is one of their sixth powers.
        let is_number = |step: usize| {
            let all = |order: usize| found.iter().map(|part| part[step][order]).sum::<f64>();
            let sixth = all(ORDERS);
            sixth.is_finite() && (sixth > 0.0 || all(1) == 0.0)
        };
        let expected =
            "increments from 1e-50 to 1e50, whose sixth powers are numbers: another unit";
        let others = format!("larger or smaller ones in {}", field.name);
        Error::require((0..count).all(is_number), "field", expected, others)?;
        Ok(found)
    }

    /// Histograms of the increments of a field over `scales[step]`.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn counts(&self, field: &Field, scales: &[f64]) -> Result<Vec<Counts>> {
        let empty = || vec![[0; CELLS + 2]; self.steps.len()];
        let visit = |counts: &mut Vec<Counts>, _: usize, step: usize, a: &[f64], b: &[f64]| {
            let scale = CELLS as f64 / (2.0 * REACH) / scales[step];
            for (a, b) in a.iter().zip(b) {
                let at = (b - a) * scale + 0.5 * CELLS as f64;
                // Where a sample is missing, in no cell.
                if at.is_finite() {
                    let cell = (at.floor() + 1.0).clamp(0.0, (CELLS + 1) as f64);
                    counts[step][cell as usize] += 1;
                }
            }
        };
        let mut sum = empty();
        for counts in self.each(field, empty, visit)? {
            add_counts(&mut sum, &counts);
        }
        Ok(sum)
    }

    /// Visits all pairs: block of the times, index of the step, samples, samples a step on. In time all blocks of a part
    /// one after another.
    fn each<T: Send>(
        &self,
        field: &Field,
        empty: impl Fn() -> T + Sync,
        visit: impl Fn(&mut T, usize, usize, &[f64], &[f64]) + Sync,
    ) -> Result<Vec<T>> {
        let count = self.axis.of([BLOCKS, field.n_sites().div_ceil(TOGETHER)]);
        let stage = self.axis.of(["increments along x", "increments in time"]);
        self.observer.stage(stage, count as u64);
        let done = (0..count).into_par_iter().map_init(Vec::new, |samples, i| {
            self.observer.go_on()?;
            let mut found = empty();
            let mut visit = |block: usize, step: usize, a: &[f64], b: &[f64]| {
                visit(&mut found, block, step, a, b);
            };
            match self.axis {
                FieldAxis::Space => self.rows(field, i, samples, &mut visit),
                FieldAxis::Time => self.records(field, i, samples, &mut visit),
            }
            self.observer.advance(1);
            Ok(found)
        });
        let done = done.collect();
        field.release_pages();
        done
    }

    fn rows(&self, field: &Field, block: usize, samples: &mut Vec<f64>, visit: Visit<'_>) {
        let sites = field.n_sites();
        let together = (READ / sites).max(1);
        let times = split(field.n_times(), block);
        for from in times.clone().step_by(together) {
            let some = from..times.end.min(from + together);
            samples.resize(some.len() * sites, 0.0);
            field.read_time_major(some, 0..sites, samples);
            for row in samples.chunks_exact(sites) {
                for (step, separation) in self.steps.iter().enumerate() {
                    visit(block, step, &row[..sites - separation], &row[*separation..]);
                }
            }
        }
    }

    fn records(&self, field: &Field, tile: usize, samples: &mut Vec<f64>, visit: Visit<'_>) {
        let times = field.n_times();
        let from = tile * TOGETHER;
        let sites = from..field.n_sites().min(from + TOGETHER);
        samples.resize(sites.len() * times, 0.0);
        field.read_site_major(0..times, sites, samples);
        for record in samples.chunks_exact(times) {
            for part in 0..PARTS {
                for (step, lag) in self.steps.iter().enumerate() {
                    for block in part * QUARTERS..(part + 1) * QUARTERS {
                        let Range { start, end } = split(times, block);
                        let [start, end] = [start, end].map(|i| i.min(times - lag));
                        let (a, b) = (&record[start..end], &record[start + lag..end + lag]);
                        visit(block, step, a, b);
                    }
                }
            }
        }
    }
}

/// What visits pairs.
type Visit<'v> = &'v mut dyn FnMut(usize, usize, &[f64], &[f64]);

/// A block of the times.
fn split(n: usize, block: usize) -> Range<usize> {
    block * n / BLOCKS..(block + 1) * n / BLOCKS
}
