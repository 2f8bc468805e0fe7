//! Passes over a field for its increments: sums of powers, and histograms.

use std::ops::Range;

use rayon::prelude::*;

use super::moments::{LOCAL, MOVED, ORDERS, PowerSums, Sums};
use crate::error::{Error, Result};
use crate::estimates::realisations::TOGETHER;
use crate::field::Field;
use crate::observer::Observer;
use crate::system::memory::half_of_free_memory;

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

/// Along which axis increments are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FieldAxis {
    Space,
    Time,
}

/// Increments of one field along one axis.
pub(super) struct IncrementPass<'a> {
    pub field: &'a Field,
    pub axis: FieldAxis,
    /// Separations in sites, or lags in samples.
    pub steps: &'a [usize],
    pub observer: &'a dyn Observer,
}

/// `[part][step]`.
pub(super) type PartSums = Vec<Vec<Sums>>;

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
        blocks[0][of] * blocks[2][of]
            + blocks[0][of] * blocks[3][of]
            + blocks[1][of] * blocks[3][of]
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

impl IncrementPass<'_> {
    /// # Errors
    /// [`Error::Memory`].
    pub fn check_memory(&self, memory: Option<u64>) -> Result<()> {
        let threads = rayon::current_num_threads() as u64;
        let (times, sites) = (self.field.n_times() as u64, self.field.n_sites() as u64);
        let samples = match self.axis {
            FieldAxis::Space => sites.max(READ as u64),
            FieldAxis::Time => times * TOGETHER as u64,
        };
        let sums = (16 * PARTS * self.steps.len() * size_of::<Sums>()) as u64;
        let cells = (BLOCKS * self.steps.len() * PAIRS * size_of::<Cell>()) as u64;
        let needed = threads * (8 * samples + sums) + cells;
        let allowed = memory.unwrap_or_else(half_of_free_memory);
        match needed > allowed {
            true => Err(Error::Memory {
                what: "the records of a few sites",
                needed,
                allowed,
            }),
            false => Ok(()),
        }
    }

    /// Sums of powers, of the increments that begin in each part of the times.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn sums(&self) -> Result<PartSums> {
        let empty = || Tally {
            parts: vec![vec![PowerSums::default(); self.steps.len()]; PARTS],
            cells: match self.axis {
                FieldAxis::Space => vec![Cell::default(); self.steps.len() * PAIRS],
                FieldAxis::Time => Vec::new(),
            },
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
            sums.join(&total);
            tally
                .cells
                .push([total[0], total[MOVED], total[2], total[4]]);
            if let Ok(blocks) = tally.cells.as_slice().try_into() {
                sums.join(&local(blocks));
                tally.cells.clear();
            }
        };
        let all = self.each(empty, visit)?;
        let mut joined = empty().parts;
        for tally in &all {
            for (joined, sums) in joined
                .iter_mut()
                .flatten()
                .zip(tally.parts.iter().flatten())
            {
                joined.join(&sums.total());
            }
        }
        if self.axis == FieldAxis::Space {
            for (part, blocks) in joined.iter_mut().zip(all.chunks_exact(QUARTERS)) {
                for (i, _) in blocks[0].cells.iter().enumerate() {
                    part[i / PAIRS].join(&local(std::array::from_fn(|b| blocks[b].cells[i])));
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
        let found: PartSums = found.collect();
        // Of every sum of magnitudes, there is one of their sixth powers.
        let is_number = |step: usize| {
            let all = |order: usize| found.iter().map(|part| part[step][order]).sum::<f64>();
            let sixth = all(ORDERS);
            sixth.is_finite() && (sixth > 0.0 || all(1) == 0.0)
        };
        if !(0..self.steps.len()).all(is_number) {
            return Err(Error::Request {
                option: "field",
                expected:
                    "increments from 1e-50 to 1e50, whose sixth powers are numbers: another unit"
                        .into(),
                found: format!("larger or smaller ones in {}", self.field.name),
            });
        }
        Ok(found)
    }

    /// Histograms of the increments over `scales[step]`.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn histograms(&self, scales: &[f64]) -> Result<Vec<Counts>> {
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
        let all = self.each(empty, visit)?;
        let mut sum = empty();
        for counts in &all {
            for (sum, count) in sum.iter_mut().flatten().zip(counts.iter().flatten()) {
                *sum += count;
            }
        }
        Ok(sum)
    }

    /// Visits all pairs: block of the times, index of the step, samples, samples a step on. In time all blocks of a part
    /// one after another.
    fn each<T: Send>(
        &self,
        empty: impl Fn() -> T + Sync,
        visit: impl Fn(&mut T, usize, usize, &[f64], &[f64]) + Sync,
    ) -> Result<Vec<T>> {
        let field = self.field;
        let count = match self.axis {
            FieldAxis::Space => BLOCKS,
            FieldAxis::Time => field.n_sites().div_ceil(TOGETHER),
        };
        let stage = match self.axis {
            FieldAxis::Space => "increments along x",
            FieldAxis::Time => "increments in time",
        };
        self.observer.stage(stage, count as u64);
        let done = (0..count).into_par_iter().map_init(Vec::new, |samples, i| {
            if self.observer.cancelled() {
                return Err(Error::Cancelled);
            }
            let mut found = empty();
            match self.axis {
                FieldAxis::Space => {
                    let times = split(field.n_times(), BLOCKS, i);
                    self.rows(times, samples, |step, a, b| {
                        visit(&mut found, i, step, a, b);
                    });
                }
                FieldAxis::Time => self.records(i, samples, |block, step, a, b| {
                    visit(&mut found, block, step, a, b);
                }),
            }
            self.observer.advance(1);
            Ok(found)
        });
        let done = done.collect();
        field.release_pages();
        done
    }

    fn rows(
        &self,
        times: Range<usize>,
        samples: &mut Vec<f64>,
        mut visit: impl FnMut(usize, &[f64], &[f64]),
    ) {
        let sites = self.field.n_sites();
        let together = (READ / sites).max(1);
        for from in times.clone().step_by(together) {
            let some = from..times.end.min(from + together);
            samples.resize(some.len() * sites, 0.0);
            self.field.read_time_major(some, 0..sites, samples);
            for row in samples.chunks_exact(sites) {
                for (step, separation) in self.steps.iter().enumerate() {
                    visit(step, &row[..sites - separation], &row[*separation..]);
                }
            }
        }
    }

    fn records(
        &self,
        tile: usize,
        samples: &mut Vec<f64>,
        mut visit: impl FnMut(usize, usize, &[f64], &[f64]),
    ) {
        let (times, n_sites) = (self.field.n_times(), self.field.n_sites());
        let from = tile * TOGETHER;
        let sites = from..n_sites.min(from + TOGETHER);
        samples.resize(sites.len() * times, 0.0);
        self.field.read_site_major(0..times, sites, samples);
        for record in samples.chunks_exact(times) {
            for part in 0..PARTS {
                for (step, lag) in self.steps.iter().enumerate() {
                    for block in part * QUARTERS..(part + 1) * QUARTERS {
                        let Range { start, end } = split(times, BLOCKS, block);
                        let [start, end] = [start, end].map(|i| i.min(times - lag));
                        visit(
                            block,
                            step,
                            &record[start..end],
                            &record[start + lag..end + lag],
                        );
                    }
                }
            }
        }
    }
}

/// Part `i` of `count` nearly equal ones.
fn split(n: usize, count: usize, i: usize) -> Range<usize> {
    i * n / count..(i + 1) * n / count
}
