//! The pass along time: every site's record to its spectrum.

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayViewMut2, Axis, s};
use num_complex::Complex;

use super::front::{Passed, WindowScratch, WindowTransforms};
use super::intermediate::Intermediate;
use super::noise::Subtracted;
use super::stages::Stages;
use super::worker::Worker;
use crate::arrays::LargeArray;
use crate::diagnostics::{Bins, Keep, MapBuilder, SpectrumMoments, interleaved_moments};
use crate::error::Result;
use crate::numeric::sum;
use crate::prepare::ReadAhead;
use crate::system::buffer::Buffer;
use crate::system::scratch_pool::ScratchPool;
use crate::transform::{Real, RecordScratch, RecordTransform, direct_sums};

/// What the pass leaves behind beside the arrays.
#[derive(Debug)]
pub(super) struct TemporalPassResult {
    pub rows: Vec<SpectrumMoments>,
    /// `sum (w v)^2` over all segments, one a site.
    pub energies: Vec<f64>,
    /// Results of the front windows, one per site; empty if not requested.
    pub passed: Vec<Passed>,
    /// Of the spectra; `None` where they are not written by this pass, or no maps are wanted.
    pub map: Option<MapBuilder>,
    /// Of the noise at each site, where it is subtracted.
    pub subtracted: Vec<Subtracted>,
    /// Sum over sites at each frequency, with the map.
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
    workers: ScratchPool<SiteScratch<T>>,
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
            workers: ScratchPool::default(),
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
        let spectrum: Vec<f64> = worker.power.iter().map(|lanes| lanes.0[0]).collect();
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
        let (spectrum, energies) = transform.transform(std::iter::once(&record[..]), &mut scratch);
        let energy = energies[0];
        if count == 0 || energy <= 0.0 {
            return None;
        }
        let tapered = record.iter().zip(&plan.window_time);
        let mut tapered: Vec<f64> = tapered.map(|(v, w)| v * w).collect();
        tapered.resize(length, 0.0);
        let chosen = (0..count).map(|i| (2 * i + 1) * bins / (2 * count));
        let chosen: Vec<usize> = chosen.collect();
        let both = chosen.iter().zip(direct_sums(&tapered, &chosen));
        let squares = both.map(|(&m, z)| {
            let re = spectrum[m].re.to_f64() - z.re;
            let im = spectrum[m].im.to_f64() - z.im;
            re * re + im * im
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
        let (plan, prepared, stored) = (self.stages.plan, self.stages.prepared, self.stages.stored);
        let (nx, nf) = (plan.axes.n_sites, plan.axes.frequency.len());
        self.stages.observer.stage("along time", nx as u64);
        let wanted = between.is_none();
        let has_map = wanted && plan.request.maps;
        let mut done = TemporalPassResult {
            rows: Vec::with_capacity(nx),
            energies: Vec::with_capacity(nx),
            passed: Vec::new(),
            subtracted: Vec::new(),
            map: has_map.then(|| plan.map_builder((nf, nx), Keep::Largest)),
            frequency_energies: has_map.then(|| vec![0.0; nf]),
        };
        let rows = usize::from(wanted) * nf;
        let mut buffer = Buffer::zeros((rows, plan.blocks.sites))?;
        let mut room = ReadAhead::default();
        for from in (0..nx).step_by(plan.blocks.sites) {
            let width = plan.blocks.sites.min(nx - from);
            let mut spectra = buffer.view_mut((rows, width))?;
            let ahead = prepared.read_ahead(from..from + width, &mut room);
            let kept = between.as_deref_mut();
            let seen = self.stripes((from, ahead), spectra.view_mut(), kept)?;
            for site in seen {
                done.rows.push(site.row);
                done.energies.push(site.energy);
                done.passed.extend(site.passed);
                done.subtracted.extend(site.subtracted);
            }
            if wanted {
                if stored != 1.0 {
                    spectra.par_mapv_inplace(|p| p * stored);
                }
                if let Some(map) = &mut done.map {
                    map.add(0, from, spectra.view());
                }
                if let Some(sums) = &mut done.frequency_energies {
                    // Site by site, so that the bits do not depend on the blocks.
                    let rows = spectra.axis_iter(Axis(0)).into_par_iter();
                    rows.zip(&mut sums[..]).for_each(|(row, sum)| {
                        *sum = row.iter().fold(*sum, |sum, p| sum + p);
                    });
                }
                for (j, mut column) in spectra.columns_mut().into_iter().enumerate() {
                    if prepared.is_left_out(from + j) {
                        column.fill(f64::NAN);
                    }
                }
                let array = LargeArray::TEMPORAL_SPECTRUM;
                self.stages.sink.put(array, 0, from, spectra.view())?;
            }
            prepared.release_pages();
        }
        // The next stage needs the memory.
        self.workers = ScratchPool::default();
        Ok(done)
    }
}

/// What a thread works with.
#[derive(Default)]
struct SiteScratch<T> {
    worker: Worker<T>,
    samples: Vec<f64>,
    /// For the passage of the front.
    front: WindowScratch<T>,
    /// Transforms to be written to a scratch file.
    kept: Array2<Complex<T>>,
}

/// Findings at one site: measures of its spectrum, its energy, the noise that was in it, and the passage of the front.
struct SiteFindings {
    row: SpectrumMoments,
    energy: f64,
    subtracted: Option<Subtracted>,
    passed: Option<Passed>,
}

impl<T: Real> AlongTime<'_, T> {
    /// Fills `spectra` (no rows: not wanted), `(frequency, site)`, and `kept` with a block of sites, shared out in stripes
    /// of a few each.
    fn stripes(
        &self,
        (from, ahead): (usize, Option<&ReadAhead>),
        mut spectra: ArrayViewMut2<f64>,
        kept: Option<&mut Intermediate<T>>,
    ) -> Result<Vec<SiteFindings>> {
        let tile = self.stages.plan.tiles.sites;
        let width = spectra.ncols();
        let mut nothing = Array2::default((0, width));
        let (mut kept, scratch) = match kept {
            None => (nothing.view_mut(), None),
            Some(Intermediate::Memory { buffer, shape }) => {
                let columns = s![.., from..from + width];
                (buffer.view_mut(*shape)?.slice_move(columns), None)
            }
            Some(Intermediate::SpillFile(scratch)) => (nothing.view_mut(), Some(&*scratch)),
        };
        let done: Result<Vec<Vec<SiteFindings>>> = spectra
            .axis_chunks_iter_mut(Axis(1), tile)
            .into_par_iter()
            .zip(kept.axis_chunks_iter_mut(Axis(1), tile))
            .enumerate()
            .map_init(
                || self.workers.take(|_| true, SiteScratch::default),
                |room, (i, (spectra, kept))| {
                    let first = from + i * tile;
                    let Some(scratch) = scratch else {
                        return self.stripe((first, ahead), room, spectra, kept);
                    };
                    let shape = (self.stages.plan.between_rows(), spectra.ncols());
                    let mut kept = std::mem::take(&mut room.kept);
                    if kept.dim() != shape {
                        drop(kept);
                        kept = Array2::default(shape);
                    }
                    let seen = self.stripe((first, ahead), room, spectra, kept.view_mut())?;
                    scratch.put(first, kept.view())?;
                    room.kept = kept;
                    Ok(seen)
                },
            )
            .collect();
        Ok(done?.into_iter().flatten().collect())
    }

    /// The sites from `first` on; `kept` has no rows where transforms are not.
    fn stripe(
        &self,
        (first, ahead): (usize, Option<&ReadAhead>),
        room: &mut SiteScratch<T>,
        mut spectra: ArrayViewMut2<f64>,
        kept: ArrayViewMut2<Complex<T>>,
    ) -> Result<Vec<SiteFindings>> {
        let all = self.stages;
        all.observer.go_on()?;
        let (worker, samples) = (&mut room.worker, &mut room.samples);
        let (plan, prepared) = (all.plan, all.prepared);
        let width = spectra.ncols();
        let sites = first..first + width;
        samples.resize(width * plan.axes.n_times, 0.0);
        // Segments that are detrended one by one need records.
        let by_record = plan.request.welch.is_some();
        let kept = (kept.nrows() > 0).then_some(kept);
        match by_record {
            true => prepared.records(ahead, sites.clone(), samples),
            false => prepared.columns(ahead, sites.clone(), samples),
        }
        worker.spectra(self, sites, samples, kept);
        let power = &mut worker.power;
        let subtracted = all.noise.map(|noise| noise.subtract(first, width, power));
        for (mut row, power) in spectra.outer_iter_mut().zip(&worker.power) {
            row.iter_mut().zip(&power.0).for_each(|(to, &p)| *to = p);
        }
        let rows = interleaved_moments(&worker.power, &self.bins, self.edge);
        let rows = rows.into_iter().zip(&worker.energies).enumerate();
        let seen = rows.map(|(lane, (row, &energy))| SiteFindings {
            row,
            energy,
            subtracted: subtracted.map(|lanes| lanes[lane]),
            passed: None,
        });
        let mut seen: Vec<SiteFindings> = seen.collect();
        if let Some(passage) = &self.passage {
            if passage.is_long(plan) {
                *worker = Worker::default();
            }
            let front = &mut room.front;
            if by_record {
                prepared.columns(ahead, first..first + width, samples);
            }
            let passed = passage.of_columns(samples, width, front);
            for (seen, passed) in seen.iter_mut().zip(passed) {
                seen.passed = Some(passed);
            }
            if passage.is_long(plan) {
                *front = WindowScratch::default();
            }
        }
        all.observer.advance(width as u64);
        Ok(seen)
    }
}
