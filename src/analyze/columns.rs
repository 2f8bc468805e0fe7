//! The pass along time: every site's record to its spectrum.

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayViewMut2, Axis};
use num_complex::Complex;

use super::between::Between;
use super::plan::Plan;
use super::sink::{LargeArray, Sink};
use super::worker::{Samples, Worker};
use crate::analyze::Observer;
use crate::buffer::Buffer;
use crate::diagnostics::{MapBuilder, Row, moments_across};
use crate::error::{Error, Result};
use crate::prepare::{Ahead, Prepared};
use crate::spare::Spare;
use crate::sum::sum;
use crate::transform::{Real, RecordScratch, RecordTransform, direct_sums};

/// What the pass leaves behind beside the arrays.
#[derive(Debug)]
pub(super) struct Columns {
    pub rows: Vec<Row>,
    /// `sum (w v)^2` over all segments, one a site.
    pub energies: Vec<f64>,
    /// Of the spectra; `None` where they are not written by this pass, or no maps are wanted.
    pub map: Option<MapBuilder>,
}

/// Amplitudes checked at most, and samples summed for them at most.
const CHECKED_BINS: usize = 8;
const CHECKED_SAMPLES: usize = 1 << 18;

/// The pass along time, planned.
pub(super) struct AlongTime<'a, T: Real> {
    plan: &'a Plan,
    prepared: &'a Prepared<'a>,
    transform: RecordTransform<T>,
}

impl<'a, T: Real> AlongTime<'a, T> {
    pub fn new(plan: &'a Plan, prepared: &'a Prepared<'a>) -> Self {
        let transform = RecordTransform::new(&plan.window_time, plan.conventions.padded_time);
        AlongTime {
            plan,
            prepared,
            transform,
        }
    }

    /// With room for samples of a few sites.
    fn worker(&self) -> (Worker<'_, T>, Vec<f64>) {
        (Worker::new(self.plan, &self.transform), Vec::new())
    }

    /// The first site with energy (or the one named) and its spectrum; `None` without energy.
    pub fn reference(&self, observer: &dyn Observer) -> Result<Option<(usize, Vec<f64>)>> {
        let (plan, prepared) = (self.plan, self.prepared);
        let mut worker = Worker::new(plan, &self.transform);
        let mut record = vec![0.0; plan.axes.n_times];
        let candidates = match plan.request.reference_site {
            Some(site) => site - plan.sites.start..site - plan.sites.start + 1,
            None => 0..plan.axes.n_sites,
        };
        for j in candidates {
            if observer.cancelled() {
                return Err(Error::Cancelled);
            }
            prepared.record(j, &mut record);
            if record.iter().any(|&v| v != 0.0) {
                worker.spectra(prepared, j..j + 1, Samples::Records(&record), None);
                let spectrum: Vec<f64> = worker.power.iter().map(|lanes| lanes.0[0]).collect();
                if sum(&spectrum) > 0.0 {
                    return Ok(Some((j, spectrum)));
                }
            }
        }
        Ok(None)
    }

    /// Root mean square difference of a few amplitudes of site `j` from direct sums, relative to the
    /// root mean square of all, which estimates the relative error of the transform; and how many.
    pub fn spot_check(&self, j: usize) -> Option<(f64, usize)> {
        let (plan, transform) = (self.plan, &self.transform);
        let (length, bins) = (transform.padded(), transform.bins());
        let count = CHECKED_BINS.min(bins).min(CHECKED_SAMPLES / length);
        let mut record = vec![0.0; plan.axes.n_times];
        self.prepared.record(j, &mut record);
        record.truncate(plan.segments.length);
        let mut scratch = RecordScratch::default();
        let (spectrum, energies) = transform.transform(std::iter::once(&record[..]), &mut scratch);
        let energy = energies[0];
        if count == 0 || energy <= 0.0 {
            return None;
        }
        let mut tapered: Vec<f64> = record
            .iter()
            .zip(&plan.window_time)
            .map(|(v, w)| v * w)
            .collect();
        tapered.resize(length, 0.0);
        let chosen: Vec<usize> = (0..count)
            .map(|i| (2 * i + 1) * bins / (2 * count))
            .collect();
        let squared: f64 = chosen
            .iter()
            .zip(direct_sums(&tapered, &chosen))
            .map(|(&m, z)| {
                let (re, im) = (
                    spectrum[m].re.to_f64() - z.re,
                    spectrum[m].im.to_f64() - z.im,
                );
                re * re + im * im
            })
            .sum();
        Some(((squared / count as f64 / energy).sqrt(), count))
    }

    /// Transforms all records. The transforms go to `between`, where there is one; where there is
    /// none, spectra go to `sink`.
    pub fn transform_records(
        &self,
        edge: f64,
        stored: f64,
        mut between: Option<&mut Between<T>>,
        sink: &dyn Sink,
        observer: &dyn Observer,
    ) -> Result<Columns> {
        let (plan, prepared) = (self.plan, self.prepared);
        let (nx, nf) = (plan.axes.n_sites, plan.axes.frequency.len());
        observer.stage("along time", nx as u64);
        let workers = Spare::default();
        let wanted = between.is_none();
        let mut done = Columns {
            rows: Vec::with_capacity(nx),
            energies: Vec::with_capacity(nx),
            map: (wanted && plan.request.maps)
                .then(|| MapBuilder::largest((nf, nx), super::MAP_LIMIT)),
        };
        let rows = if wanted { nf } else { 0 };
        let mut buffer = Buffer::zeros((rows, plan.blocks.sites))?;
        for from in (0..nx).step_by(plan.blocks.sites) {
            let width = plan.blocks.sites.min(nx - from);
            let mut spectra = buffer.view_mut((rows, width))?;
            let ahead = prepared.read_ahead(from..from + width);
            let stripes = Stripes {
                all: self,
                workers: &workers,
                observer,
                ahead: ahead.as_ref(),
                edge,
                from,
            };
            let seen = match between.as_deref_mut() {
                None => stripes.run(spectra.view_mut(), None)?,
                Some(between) => {
                    let mut seen = Vec::new();
                    between.with_columns(from, width, |columns| {
                        seen = stripes.run(spectra.view_mut(), Some(columns))?;
                        Ok(())
                    })?;
                    seen
                }
            };
            for (row, energy) in seen {
                done.rows.push(row);
                done.energies.push(energy);
            }
            if wanted {
                if stored != 1.0 {
                    spectra.par_mapv_inplace(|p| p * stored);
                }
                if let Some(map) = &mut done.map {
                    map.add(0, from, spectra.view());
                }
                sink.put(LargeArray::TemporalSpectrum, 0, from, spectra.view())?;
            }
            prepared.release_pages();
        }
        Ok(done)
    }
}

/// A block of sites, shared out in stripes of a few sites each.
struct Stripes<'a, 'w, T: Real> {
    all: &'w AlongTime<'w, T>,
    workers: &'a Spare<(Worker<'w, T>, Vec<f64>)>,
    observer: &'a dyn Observer,
    ahead: Option<&'a Ahead>,
    edge: f64,
    from: usize,
}

impl<T: Real> Stripes<'_, '_, T> {
    /// Fills `spectra` (no rows: not wanted) and `between`, both `(.., site)`.
    fn run(
        &self,
        mut spectra: ArrayViewMut2<f64>,
        between: Option<ArrayViewMut2<Complex<T>>>,
    ) -> Result<Vec<(Row, f64)>> {
        let tile = self.all.plan.tiles.sites;
        let width = spectra.ncols();
        let mut nothing = Array2::default((0, width));
        let mut between = between.unwrap_or_else(|| nothing.view_mut());
        let done: Result<Vec<Vec<(Row, f64)>>> = spectra
            .axis_chunks_iter_mut(Axis(1), tile)
            .into_par_iter()
            .zip(between.axis_chunks_iter_mut(Axis(1), tile))
            .enumerate()
            .map_init(
                || self.workers.take(|_| true, || self.all.worker()),
                |worker, (i, (spectra, between))| {
                    let (worker, values) = &mut **worker;
                    self.stripe(self.from + i * tile, worker, values, spectra, between)
                },
            )
            .collect();
        Ok(done?.concat())
    }

    fn stripe(
        &self,
        first: usize,
        worker: &mut Worker<T>,
        values: &mut Vec<f64>,
        mut spectra: ArrayViewMut2<f64>,
        between: ArrayViewMut2<Complex<T>>,
    ) -> Result<Vec<(Row, f64)>> {
        if self.observer.cancelled() {
            return Err(Error::Cancelled);
        }
        let width = spectra.ncols();
        let sites = first..first + width;
        values.resize(width * self.all.plan.axes.n_times, 0.0);
        // Segments need records, and what was read ahead holds them.
        let samples = if self.all.plan.request.welch.is_some() || self.ahead.is_some() {
            self.all.prepared.records(self.ahead, sites.clone(), values);
            Samples::Records(values)
        } else {
            self.all.prepared.columns(sites.clone(), values);
            Samples::Columns(values)
        };
        let kept = (between.nrows() > 0).then_some(between);
        worker.spectra(self.all.prepared, sites, samples, kept);
        for (mut row, power) in spectra.outer_iter_mut().zip(&worker.power) {
            row.iter_mut().zip(&power.0).for_each(|(to, &p)| *to = p);
        }
        let axis = &self.all.plan.axes.frequency;
        let rows = moments_across(&worker.power, axis, self.edge);
        let seen = rows.into_iter().zip(worker.energies.iter().copied());
        self.observer.advance(width as u64);
        Ok(seen.take(width).collect())
    }
}
