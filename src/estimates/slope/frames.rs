//! Spectra over wavenumbers, frame by frame of the times.

use std::ops::Range;

use rayon::prelude::*;

use super::{Work, add_powers, mean_spectrum};
use crate::error::Result;
use crate::estimates::realisations::{Records, SegmentScratch, interleave};
use crate::field::Field;
use crate::numeric::LineFit;
use crate::system::check_memory;
use crate::transform::{RecordTransform, fold};

/// Powers below this share of the largest of their spectrum are rounding.
const ROUNDING: f64 = 1e-26;
/// Snapshots that are transformed together.
const TOGETHER: usize = 8;

/// A part of the times of one field.
pub(super) struct Frame {
    spectrum: Vec<f64>,
    pub snapshots: u64,
    /// Mean of the snapshots' `1 / max |dv/dx|`.
    flatness: f64,
}

impl Frame {
    /// The spectrum of all snapshots.
    pub fn mean(frames: &[Frame]) -> Vec<f64> {
        let all = frames.iter().map(|frame| frame.snapshots).sum::<u64>() as f64;
        let some = frames.iter().filter(|frame| frame.snapshots > 0);
        let weighted = some.map(|frame| (frame.snapshots as f64 / all, &frame.spectrum));
        let at = |m: usize| weighted.clone().map(|(share, of)| share * of[m]).sum();
        let bins = frames.first().map_or(0, |frame| frame.spectrum.len());
        (0..bins).map(at).collect()
    }
}

impl Work<'_> {
    pub fn frames(&self) -> usize {
        self.request.frames.clamp(1, self.first.n_times())
    }

    /// Snapshots of a frame.
    pub fn times(&self, frame: usize) -> Range<usize> {
        let (n_times, frames) = (self.first.n_times(), self.frames());
        frame * n_times / frames..(frame + 1) * n_times / frames
    }

    /// # Errors
    /// [`crate::Error::Memory`]; [`crate::Error::Cancelled`].
    pub fn in_frames(&self, field: &Field) -> Result<Vec<Frame>> {
        let (n_times, n_sites) = (field.n_times(), field.n_sites());
        let (frames, bins) = (self.frames(), self.realisations.bins());
        let length = self.realisations.segments.length;
        let threads = rayon::current_num_threads() as u64;
        let of_thread = (TOGETHER * (16 * n_sites + 16 * bins)) as u64
            + RecordTransform::<f64>::working_bytes(length, length, TOGETHER);
        // Those of all shots are held.
        let held = 16 * (frames * bins * 2 * self.fields.len()) as u64;
        let needed = threads * of_thread + held;
        check_memory("the spectra of all frames", needed, self.request.memory)?;
        self.observer.stage("spectra along x", n_times as u64);
        let step = field.space.step.abs();
        let density = step / std::f64::consts::TAU / self.realisations.count() as f64;
        let one = |scratch: &mut (SegmentScratch, Vec<f64>), i: usize| {
            let (segments, rows) = scratch;
            let times = self.times(i);
            let (mut spectrum, mut count, mut inverse) = (vec![0.0; bins], 0u64, 0.0f64);
            for from in times.clone().step_by(TOGETHER) {
                self.observer.go_on()?;
                let some = from..times.end.min(from + TOGETHER);
                self.observer.advance(some.len() as u64);
                rows.resize(some.len() * n_sites, 0.0);
                field.read_time_major(some, 0..n_sites, rows);
                let is_whole = |row: &&[f64]| row.iter().all(|v| v.is_finite());
                let whole = rows.chunks_exact(n_sites).filter(is_whole);
                let whole: Vec<f64> = whole.flatten().copied().collect();
                let width = whole.len() / n_sites;
                if width == 0 {
                    continue;
                }
                count += width as u64;
                for row in whole.chunks_exact(n_sites) {
                    let steps = row.windows(2).map(|pair| (pair[1] - pair[0]).abs());
                    inverse += step / steps.fold(0.0, f64::max);
                }
                interleave(&whole, n_sites, rows);
                let whole = Records::interleaved(rows, width);
                self.realisations.each(whole, segments, |_, spectra| {
                    add_powers(&mut spectrum, spectra, width);
                });
            }
            for (m, sum) in spectrum.iter_mut().enumerate() {
                *sum *= density * fold(m, length) / count as f64;
            }
            Ok(Frame {
                spectrum,
                snapshots: count,
                flatness: inverse / count as f64,
            })
        };
        let scratch = <(SegmentScratch, Vec<f64>)>::default;
        let found = (0..frames).into_par_iter().map_init(scratch, one);
        let found = found.collect::<Result<_>>()?;
        field.release_pages();
        Ok(found)
    }

    /// Frames of all shots: mean times, slopes of mean spectra, largest gradients.
    pub fn joined(&self, shots: &[Vec<Frame>]) -> SlopeFrames {
        let frames = 0..self.frames();
        let time = |i: usize| {
            let times = self.times(i);
            0.5 * (self.first.time.at(times.start) + self.first.time.at(times.end - 1))
        };
        let gradient =
            |i: usize| shots.len() as f64 / shots.iter().map(|shot| shot[i].flatness).sum::<f64>();
        let shared = self.realisations.shared_bins();
        let fit_of = |i: usize| {
            let spectra: Vec<&[f64]> = shots.iter().map(|shot| &shot[i].spectrum[..]).collect();
            let spectrum = mean_spectrum(&spectra);
            let largest = spectrum.iter().copied().fold(0.0, f64::max);
            let is_whole = self.bins.iter().all(|m| spectrum[*m] > ROUNDING * largest);
            let line = LineFit::through(&self.points(&spectrum)).filter(|_| is_whole);
            let half = |line: LineFit| line.half_interval_of(self.request.alpha, shared);
            line.map_or((f64::NAN, f64::NAN), |line| (line.slope, half(line)))
        };
        let (slope, half) = frames.clone().map(fit_of).unzip();
        SlopeFrames {
            time: frames.clone().map(time).collect(),
            slope,
            half,
            gradient: frames.map(gradient).collect(),
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
