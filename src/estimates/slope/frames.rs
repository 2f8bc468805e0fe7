//! Spectra over wavenumbers, frame by frame of the times.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::estimates::realisations::{Realisations, Records, SegmentScratch};
use crate::field::Field;
use crate::numeric::least_squares::LineFit;
use crate::observer::Observer;
use crate::system::memory::half_of_free_memory;
use crate::transform::{RecordTransform, fold};

/// Snapshots that are transformed together.
const TOGETHER: usize = 8;

/// How the times are split.
pub(super) struct Frames<'a> {
    pub first: &'a Field,
    pub realisations: &'a Realisations,
    pub count: usize,
    pub memory: Option<u64>,
    pub observer: &'a dyn Observer,
}

/// One field in frames.
pub(super) struct FieldFrames {
    /// Spectra of the frames.
    spectra: Vec<Vec<f64>>,
    /// Snapshots of each.
    snapshots: Vec<u64>,
    /// Mean of the snapshots' `1 / max |dv/dx|`, of each.
    flatness: Vec<f64>,
    pub left_out: u64,
}

impl FieldFrames {
    /// Over all snapshots.
    pub fn mean(&self) -> Vec<f64> {
        let bins = self.spectra.first().map_or(0, Vec::len);
        let all = self.snapshots.iter().sum::<u64>() as f64;
        let mut mean = vec![0.0; bins];
        for (spectrum, count) in self.spectra.iter().zip(&self.snapshots) {
            if *count > 0 {
                for (sum, value) in mean.iter_mut().zip(spectrum) {
                    *sum += value * *count as f64 / all;
                }
            }
        }
        mean
    }
}

impl Frames<'_> {
    fn frames(&self) -> usize {
        self.count.clamp(1, self.first.n_times())
    }

    /// # Errors
    /// [`Error::Memory`]; [`Error::Cancelled`].
    pub fn of(&self, field: &Field) -> Result<FieldFrames> {
        let (n_times, n_sites) = (field.n_times(), field.n_sites());
        let (frames, bins) = (self.frames(), self.realisations.bins());
        let length = self.realisations.segments.length;
        let threads = rayon::current_num_threads() as u64;
        let together = TOGETHER as u64;
        let needed = threads
            * (together * (16 * n_sites + 16 * bins) as u64
                + RecordTransform::<f64>::working_bytes(length, length, TOGETHER))
            + 16 * (frames * bins * 2) as u64;
        let allowed = self.memory.unwrap_or_else(half_of_free_memory);
        if needed > allowed {
            return Err(Error::Memory {
                what: "the spectra of all frames",
                needed,
                allowed,
            });
        }
        self.observer.stage("spectra along x", n_times as u64);
        let density =
            field.space.step.abs() / std::f64::consts::TAU / self.realisations.count() as f64;
        let step = field.space.step.abs();
        let one = |scratch: &mut (SegmentScratch, Vec<f64>), i: usize| {
            let (segments, rows) = scratch;
            let times = i * n_times / frames..(i + 1) * n_times / frames;
            let (mut sums, mut count, mut inverse) = (vec![0.0; bins], 0u64, 0.0f64);
            for from in times.clone().step_by(TOGETHER) {
                if self.observer.cancelled() {
                    return Err(Error::Cancelled);
                }
                let some = from..times.end.min(from + TOGETHER);
                self.observer.advance(some.len() as u64);
                rows.resize(some.len() * n_sites, 0.0);
                field.read_time_major(some, 0..n_sites, rows);
                let whole: Vec<f64> = rows
                    .chunks_exact(n_sites)
                    .filter(|row| row.iter().all(|v| v.is_finite()))
                    .flatten()
                    .copied()
                    .collect();
                let width = whole.len() / n_sites;
                if width == 0 {
                    continue;
                }
                count += width as u64;
                for row in whole.chunks_exact(n_sites) {
                    let steps = row.windows(2).map(|pair| (pair[1] - pair[0]).abs());
                    inverse += step / steps.fold(0.0, f64::max);
                }
                let whole = Records::one_after_another(&whole, n_sites);
                self.realisations.each(whole, segments, |_, spectra| {
                    for (sum, row) in sums.iter_mut().zip(spectra.chunks_exact(width)) {
                        *sum += row.iter().map(|x| x.norm_sqr()).sum::<f64>();
                    }
                });
            }
            for (m, sum) in sums.iter_mut().enumerate() {
                *sum *= density * fold(m, length) / count as f64;
            }
            Ok((sums, count, inverse / count as f64))
        };
        let found: Vec<(Vec<f64>, u64, f64)> = (0..frames)
            .into_par_iter()
            .map_init(<(SegmentScratch, Vec<f64>)>::default, one)
            .collect::<Result<_>>()?;
        field.release_pages();
        let snapshots: Vec<u64> = found.iter().map(|one| one.1).collect();
        Ok(FieldFrames {
            left_out: n_times as u64 - snapshots.iter().sum::<u64>(),
            flatness: found.iter().map(|one| one.2).collect(),
            spectra: found.into_iter().map(|one| one.0).collect(),
            snapshots,
        })
    }

    /// Frames of all shots: mean times, slopes of mean spectra by `fit`, largest gradients.
    pub fn joined(
        &self,
        shots: &[FieldFrames],
        alpha: f64,
        fit: impl Fn(&[f64]) -> Option<LineFit>,
    ) -> SlopeFrames {
        let (frames, n_times) = (self.frames(), self.first.n_times());
        let time = |i: usize| {
            let last = (i + 1) * n_times / frames - 1;
            0.5 * (self.first.time.at(i * n_times / frames) + self.first.time.at(last))
        };
        let count = shots.len() as f64;
        let fit_of = |i: usize| {
            let mean = |m: usize| shots.iter().map(|shot| shot.spectra[i][m]).sum::<f64>() / count;
            fit(&(0..self.realisations.bins())
                .map(mean)
                .collect::<Vec<f64>>())
        };
        let gradient = |i: usize| count / shots.iter().map(|shot| shot.flatness[i]).sum::<f64>();
        let shared = self.realisations.shared_bins();
        let of_fit = |fit: Option<LineFit>| match fit {
            Some(fit) => (fit.slope, fit.half_interval_of(alpha, shared)),
            None => (f64::NAN, f64::NAN),
        };
        let (slope, half) = (0..frames).map(fit_of).map(of_fit).unzip();
        SlopeFrames {
            time: (0..frames).map(time).collect(),
            slope,
            half,
            gradient: (0..frames).map(gradient).collect(),
        }
    }
}

/// The slope against time.
#[derive(Debug, Clone)]
pub struct SlopeFrames {
    /// Middle of each frame.
    pub time: Vec<f64>,
    /// NaN where the frame has no power above rounding at a bin of the band.
    pub slope: Vec<f64>,
    /// Half of the interval of the regression.
    pub half: Vec<f64>,
    /// Harmonic mean of the snapshots' largest `|dv/dx|`, between neighbouring sites.
    pub gradient: Vec<f64>,
}
