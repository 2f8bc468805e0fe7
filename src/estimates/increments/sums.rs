//! Passes over a field for its increments: sums of powers, and histograms.

use std::ops::Range;

use rayon::prelude::*;

use super::moments::{ORDERS, PowerSums, SUMS};
use crate::error::{Error, Result};
use crate::estimates::realisations::TOGETHER;
use crate::field::Field;
use crate::observer::Observer;
use crate::system::memory::half_of_free_memory;

/// Parts of the times whose sums are kept apart.
pub(super) const PARTS: usize = 16;
/// Blocks of times that are read in parallel, four a part.
const BLOCKS: usize = 64;
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
pub(super) type PartSums = Vec<Vec<[f64; SUMS]>>;

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
        let sums = 16 * (PARTS * self.steps.len() * SUMS * 8) as u64;
        let needed = threads * (8 * samples + sums);
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
        let empty = || vec![vec![PowerSums::default(); self.steps.len()]; PARTS];
        let visit =
            |sums: &mut Vec<Vec<PowerSums>>, part: usize, step: usize, a: &[f64], b: &[f64]| {
                sums[part][step].add(a, b);
            };
        let all = self.each(empty, visit)?;
        let mut joined = empty();
        for sums in &all {
            for (joined, sums) in joined.iter_mut().flatten().zip(sums.iter().flatten()) {
                joined.join(&sums.total());
            }
        }
        let totals = |part: &Vec<PowerSums>| part.iter().map(PowerSums::total).collect();
        let found: PartSums = joined.iter().map(totals).collect();
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

    /// Visits all pairs: part of the times, index of the step, samples, samples a step on.
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
                        visit(&mut found, i * PARTS / BLOCKS, step, a, b);
                    });
                }
                FieldAxis::Time => self.records(i, samples, |part, step, a, b| {
                    visit(&mut found, part, step, a, b);
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
                let begins = split(times, PARTS, part);
                for (step, lag) in self.steps.iter().enumerate() {
                    let end = begins.end.min(times - lag);
                    if begins.start < end {
                        let a = &record[begins.start..end];
                        visit(part, step, a, &record[begins.start + lag..end + lag]);
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
