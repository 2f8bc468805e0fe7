//! The pass along time: every site's record to its spectrum.

use std::ops::Range;
use std::sync::Mutex;

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayViewMut2, Axis, s};
use num_complex::Complex;

use super::blocks::fill;
use super::front::{Passed, WindowTransforms};
use super::intermediate::Intermediate;
use super::noise::Subtracted;
use super::stages::Stages;
use super::worker::Worker;
use crate::arrays::LargeArray;
use crate::diagnostics::{Bins, SpectrumMoments};
use crate::error::Result;
use crate::numeric::{pieces, sum, sum_of_squares};
use crate::prepare::ReadAhead;
use crate::system::buffer::Buffer;
use crate::transform::{Real, RecordScratch, RecordTransform, direct_sums};

/// What the pass leaves behind beside the arrays.
#[derive(Debug)]
pub(super) struct TemporalPassResult {
    pub rows: Vec<SpectrumMoments>,
    /// `sum (w v)^2` over all segments, one a site.
    pub energies: Vec<f64>,
    /// Results of the front windows, one per site; empty if not requested.
    pub passed: Vec<Passed>,
    /// Of the noise at each site, where it is subtracted.
    pub subtracted: Vec<Subtracted>,
    /// Sum over sites at each frequency, where spectra are written by this pass and maps are wanted.
    pub frequency_energies: Option<Vec<f64>>,
}

/// Amplitudes checked at most, and samples summed for them at most.
const CHECKED_BINS: usize = 8;
const CHECKED_SAMPLES: usize = 1 << 18;

/// The pass along time, planned.
pub(super) struct AlongTime<'a, T: Real> {
    pub stages: &'a Stages<'a>,
    pub transform: RecordTransform<T>,
    /// Transforms of the front windows, if requested.
    pub passage: Option<WindowTransforms<T>>,
    /// Where low frequencies end.
    pub edge: f64,
    bins: Bins<'a>,
    workers: Mutex<Vec<SiteScratch<T>>>,
}

impl<'a, T: Real> AlongTime<'a, T> {
    pub fn new(stages: &'a Stages<'a>) -> Self {
        let padded = stages.plan.conventions.padded_time;
        AlongTime {
            stages,
            transform: RecordTransform::new(&stages.plan.window_time, padded),
            passage: None,
            edge: f64::NAN,
            bins: stages.plan.frequency_bins(),
            workers: Mutex::default(),
        }
    }

    /// The record of site `j` and its spectrum; `None` without energy.
    pub fn reference(&self, j: usize) -> Option<(Vec<f64>, Vec<f64>)> {
        let mut worker = Worker::default();
        let record = self.stages.record(j);
        worker.spectra(self, j..j + 1, &record, None);
        if let Some(noise) = self.stages.noise {
            noise.subtract(j, 1, &mut worker.power);
        }
        let spectrum = worker.first();
        (sum(&spectrum) > 0.0).then_some((record, spectrum))
    }

    /// Root mean square difference of a few amplitudes of site `j` from direct sums, relative to the
    /// root mean square of all, which estimates the relative error of the transform; and how many.
    pub fn spot_check(&self, j: usize) -> Option<(f64, usize)> {
        let (plan, transform) = (self.stages.plan, &self.transform);
        let (length, bins) = (transform.padded(), transform.bins());
        let count = CHECKED_BINS.min(bins).min(CHECKED_SAMPLES / length);
        let mut record = self.stages.record(j);
        record.truncate(plan.segments.length);
        let mut scratch = RecordScratch::default();
        let spectrum = transform.spectra_of_rows(&record, 1, &mut scratch);
        let tapered = record.iter().zip(&plan.window_time);
        let mut tapered: Vec<f64> = tapered.map(|(v, w)| v * w).collect();
        let energy = sum_of_squares(&tapered);
        if count == 0 || energy <= 0.0 {
            return None;
        }
        tapered.resize(length, 0.0);
        let chosen = Vec::from_iter((0..count).map(|i| (2 * i + 1) * bins / (2 * count)));
        let both = chosen.iter().zip(direct_sums(&tapered, &chosen));
        let squares = both.map(|(&m, z)| {
            let found = spectrum[m];
            (Complex::new(found.re.to_f64(), found.im.to_f64()) - z).norm_sqr()
        });
        let squared: f64 = squares.sum();
        Some(((squared / count as f64 / energy).sqrt(), count))
    }

    /// Transforms all records. The transforms go to `between`, where there is one; where there is
    /// none, spectra go to the sink.
    pub fn transform_records(
        &mut self,
        mut between: Option<&mut Intermediate<T>>,
    ) -> Result<TemporalPassResult> {
        let all = self.stages;
        let (plan, prepared) = (all.plan, all.prepared);
        let (nx, nf) = (plan.axes.n_sites, plan.axes.frequency.len());
        all.observer.stage("along time", nx as u64);
        let is_written = between.is_none();
        let mut done = TemporalPassResult {
            rows: Vec::with_capacity(nx),
            energies: Vec::with_capacity(nx),
            passed: Vec::new(),
            subtracted: Vec::new(),
            frequency_energies: (is_written && plan.request.maps).then(|| vec![0.0; nf]),
        };
        let rows = usize::from(is_written) * nf;
        let mut buffer = Buffer::zeros((rows, plan.blocks.sites))?;
        let mut room = ReadAhead::default();
        for sites in pieces(nx, plan.blocks.sites) {
            let (from, width) = (sites.start, sites.len());
            let mut spectra = buffer.view_mut((rows, width))?;
            let ahead = prepared.read_ahead(sites.clone(), &mut room);
            let kept = between.as_deref_mut();
            for site in self.block((sites, ahead), spectra.view_mut(), kept)? {
                done.rows.push(site.row);
                done.energies.push(site.energy);
                done.passed.extend(site.passed);
                done.subtracted.extend(site.subtracted);
            }
            if let Some(sums) = &mut done.frequency_energies {
                // Site by site, so that the bits do not depend on the blocks.
                let rows = spectra.axis_iter(Axis(0)).into_par_iter();
                rows.zip(&mut sums[..]).for_each(|(row, sum)| {
                    *sum = row.iter().fold(*sum, |sum, p| sum + p);
                });
            }
            if is_written {
                for (j, mut column) in spectra.columns_mut().into_iter().enumerate() {
                    if prepared.is_left_out(from + j) {
                        column.fill(f64::NAN);
                    }
                }
                let array = LargeArray::TEMPORAL_SPECTRUM;
                all.outputs.put(array, (0, from), spectra.view())?;
            }
            prepared.release_pages();
        }
        // The next stage needs the memory.
        self.workers = Mutex::default();
        Ok(done)
    }
}

/// What a thread works with.
#[derive(Default)]
struct SiteScratch<T> {
    worker: Worker<T>,
    samples: Vec<f64>,
    /// Transforms to be written to a scratch file.
    kept: Vec<Complex<T>>,
}

/// Findings at one site: measures of its spectrum, its energy, the noise that was in it, and the passage of the front.
struct SiteFindings {
    row: SpectrumMoments,
    energy: f64,
    subtracted: Option<Subtracted>,
    passed: Option<Passed>,
}

impl<T: Real> AlongTime<'_, T> {
    /// Fills `spectra` (no rows: not wanted), `(frequency, site)`, and `kept` with a block of sites.
    fn block(
        &self,
        (sites, ahead): (Range<usize>, Option<&ReadAhead>),
        spectra: ArrayViewMut2<f64>,
        kept: Option<&mut Intermediate<T>>,
    ) -> Result<Vec<SiteFindings>> {
        let plan = self.stages.plan;
        let mut nothing = Array2::default((0, sites.len()));
        let (kept, file) = match kept {
            None => (nothing.view_mut(), None),
            Some(Intermediate::Memory { buffer, shape }) => {
                let columns = s![.., sites.clone()];
                (buffer.view_mut(*shape)?.slice_move(columns), None)
            }
            Some(Intermediate::Spilled { file, .. }) => (nothing.view_mut(), Some(&*file)),
        };
        let of = (sites, plan.tiles.sites, Axis(1));
        let with = (&self.workers, self.stages.observer);
        fill(of, (spectra, kept), with, |sites, (spectra, kept), room| {
            let Some(file) = file else {
                let kept = (kept.nrows() > 0).then_some(kept);
                return Ok(self.stripe((sites, ahead), room, spectra, kept));
            };
            let (first, shape) = (sites.start, (plan.between_rows(), sites.len()));
            let mut values = std::mem::take(&mut room.kept);
            values.resize(shape.0 * shape.1, Complex::default());
            let kept = ArrayViewMut2::from_shape(shape, &mut values[..]);
            let kept = kept.expect("as long as its shape");
            let seen = self.stripe((sites, ahead), room, spectra, Some(kept));
            file.write((0, first), &values)?;
            room.kept = values;
            Ok(seen)
        })
    }

    /// A few sites.
    fn stripe(
        &self,
        (sites, ahead): (Range<usize>, Option<&ReadAhead>),
        room: &mut SiteScratch<T>,
        mut spectra: ArrayViewMut2<f64>,
        kept: Option<ArrayViewMut2<Complex<T>>>,
    ) -> Vec<SiteFindings> {
        let all = self.stages;
        let (worker, samples) = (&mut room.worker, &mut room.samples);
        let (first, width) = (sites.start, sites.len());
        samples.resize(width * all.plan.axes.n_times, 0.0);
        all.prepared.columns(ahead, sites.clone(), samples);
        worker.spectra(self, sites, samples, kept);
        let power = &mut worker.power;
        let subtracted = all.noise.map(|noise| noise.subtract(first, width, power));
        for (mut row, power) in spectra.outer_iter_mut().zip(&worker.power) {
            let values = row.iter_mut().zip(&power.0);
            values.for_each(|(to, &p)| *to = p * all.stored);
        }
        let rows = worker.measured(&self.bins, self.edge);
        let passage = self.passage.as_ref();
        let passed = passage.map(|passage| passage.of_columns(samples, width, worker));
        let seen = rows.into_iter().enumerate();
        let seen = seen.map(|(lane, (row, energy))| SiteFindings {
            row,
            energy,
            subtracted: subtracted.map(|lanes| lanes[lane]),
            passed: passed.as_ref().map(|lanes| lanes[lane]),
        });
        seen.collect()
    }
}
