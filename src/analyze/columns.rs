//! The pass along time: every site's record to its spectrum.

use std::ops::Range;

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayViewMut2, Axis, s};
use num_complex::Complex;

use super::between::Between;
use super::plan::Plan;
use super::sink::{LargeArray, Sink};
use crate::analyze::Observer;
use crate::buffer::Buffer;
use crate::chain::lanes::Block;
use crate::diagnostics::{MapBuilder, Row, moments_across};
use crate::error::{Error, Result};
use crate::prepare::{Ahead, Prepared, Trend};
use crate::sum::sum;
use crate::transform::{Real, RecordScratch, RecordTransform, Scale, direct_sums, fold, power};

/// What the pass leaves behind beside the arrays.
#[derive(Debug)]
pub(super) struct Columns {
    pub rows: Vec<Row>,
    /// `sum (w v)^2` over all segments, one a site.
    pub energies: Vec<f64>,
    /// Of the spectra; `None` where they are not written by this pass.
    pub map: Option<MapBuilder>,
}

/// Samples of a few sites.
enum Samples<'a> {
    /// Record after record.
    Records(&'a [f64]),
    /// Side by side, time by time.
    Columns(&'a [f64]),
}

/// Records of a few sites to spectra, with the thread's own buffers.
struct Worker<'a, T: Real> {
    plan: &'a Plan,
    transform: &'a RecordTransform<T>,
    scale: Scale,
    scratch: RecordScratch<T>,
    /// Segments without their trends, one a record.
    segments: Vec<f64>,
    fit: Vec<f64>,
    /// Transforms of one segment, where they are not kept.
    passing: Array2<Complex<T>>,
    /// Mean power spectra of the segments, of each site a lane.
    power: Vec<Block>,
    /// `sum (w v)^2` over the segments of each record.
    energies: Vec<f64>,
}

impl<T: Real> Worker<'_, T> {
    /// Spectra and energies of `samples` of `width` sites from `first` on.
    ///
    /// `kept`, `(bin x segment, site)`, gets the transforms.
    fn spectra(
        &mut self,
        prepared: &Prepared,
        sites: Range<usize>,
        samples: Samples,
        mut kept: Option<ArrayViewMut2<Complex<T>>>,
    ) {
        let segments = self.plan.segments;
        let (bins, width) = (self.transform.bins(), sites.len());
        self.power.clear();
        self.power.resize(bins, Block::default());
        self.energies.clear();
        self.energies.resize(width, 0.0);
        let mut passing = std::mem::take(&mut self.passing);
        if kept.is_none() && passing.dim() != (bins, width) {
            passing = Array2::default((bins, width));
        }
        for (s, start) in segments.starts().enumerate() {
            let mut spectra = match &mut kept {
                Some(kept) => kept.slice_mut(s![s..;segments.count(), ..]),
                None => passing.view_mut(),
            };
            let span = start..start + segments.length;
            self.segment(prepared, &sites, &samples, span, spectra.view_mut());
            for (sums, spectra) in self.power.iter_mut().zip(spectra.outer_iter()) {
                for (sum, &x) in sums.0.iter_mut().zip(spectra) {
                    *sum += power(x);
                }
            }
        }
        self.passing = passing;
        let n = self.transform.padded();
        let mean = self.scale.factor / segments.count() as f64;
        for (m, row) in self.power.iter_mut().enumerate() {
            let factor = mean * fold(m, n);
            row.0.iter_mut().for_each(|p| *p *= factor);
        }
    }

    /// Transforms of the times `span`; adds their energies.
    fn segment(
        &mut self,
        prepared: &Prepared,
        sites: &Range<usize>,
        samples: &Samples,
        span: Range<usize>,
        spectra: ArrayViewMut2<Complex<T>>,
    ) {
        let n_times = self.plan.axes.n_times;
        let energies = match *samples {
            Samples::Columns(values) => {
                let values = &values[span.start * sites.len()..span.end * sites.len()];
                self.transform
                    .transform_columns(values, spectra, &mut self.scratch)
            }
            Samples::Records(records) if self.plan.request.welch.is_some() => {
                let length = span.len();
                self.detrended(prepared, sites.start, records, span);
                let pieces = self.segments.chunks_exact(length);
                self.transform
                    .transform_into(pieces, spectra, &mut self.scratch)
            }
            Samples::Records(records) => {
                let pieces = records.chunks_exact(n_times).map(|r| &r[span.clone()]);
                self.transform
                    .transform_into(pieces, spectra, &mut self.scratch)
            }
        };
        for (sum, energy) in self.energies.iter_mut().zip(energies) {
            *sum += energy;
        }
    }

    /// The times `span` of all records to `segments`, each without its own trend; masked samples
    /// have no weight.
    fn detrended(
        &mut self,
        prepared: &Prepared,
        first: usize,
        records: &[f64],
        span: Range<usize>,
    ) {
        let kind = self.plan.request.detrend_time;
        let records = records.chunks_exact(self.plan.axes.n_times);
        self.segments.clear();
        for (c, record) in records.enumerate() {
            let begin = self.segments.len();
            self.segments.extend_from_slice(&record[span.clone()]);
            let segment = &mut self.segments[begin..];
            let masked = prepared.masked(first + c);
            let from = masked.partition_point(|gap| gap.time < span.start);
            let masked = masked[from..].iter().take_while(|gap| gap.time < span.end);
            let is_masked = |i: usize| masked.clone().any(|gap| gap.time == span.start + i);
            Trend::remove_from(segment, kind, |i| !is_masked(i), &mut self.fit);
            for gap in masked.clone() {
                segment[gap.time - span.start] = 0.0;
            }
        }
    }
}

/// The first site with energy (or the one named) and its spectrum; `None` without energy.
pub(super) fn reference<T: Real>(
    plan: &Plan,
    prepared: &Prepared,
    observer: &dyn Observer,
) -> Result<Option<(usize, Vec<f64>)>> {
    let transform = RecordTransform::<T>::new(&plan.window_time, plan.conventions.padded_time);
    let mut worker = worker(plan, &transform);
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
            worker.spectra(prepared, j..j + 1, Samples::Columns(&record), None);
            let spectrum: Vec<f64> = worker.power.iter().map(|lanes| lanes.0[0]).collect();
            if sum(&spectrum) > 0.0 {
                return Ok(Some((j, spectrum)));
            }
        }
    }
    Ok(None)
}

/// Amplitudes checked at most, and samples summed for them at most.
const CHECKED_BINS: usize = 8;
const CHECKED_SAMPLES: usize = 1 << 18;

/// Root mean square difference of a few amplitudes of site `j` from direct sums, relative to the
/// root mean square of all, which estimates the relative error of the transform; and how many.
pub(super) fn spot_check<T: Real>(
    plan: &Plan,
    prepared: &Prepared,
    j: usize,
) -> Option<(f64, usize)> {
    let transform = RecordTransform::<T>::new(&plan.window_time, plan.conventions.padded_time);
    let (length, bins) = (transform.padded(), transform.bins());
    let count = CHECKED_BINS.min(bins).min(CHECKED_SAMPLES / length);
    let mut record = vec![0.0; plan.axes.n_times];
    prepared.record(j, &mut record);
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
    let sums: Vec<_> = chosen
        .par_iter()
        .flat_map_iter(|&bin| direct_sums(&tapered, &[bin]))
        .collect();
    let squared: f64 = chosen
        .iter()
        .zip(sums)
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

fn worker<'a, T: Real>(plan: &'a Plan, transform: &'a RecordTransform<T>) -> Worker<'a, T> {
    Worker {
        plan,
        transform,
        scale: plan.time_scale,
        scratch: RecordScratch::default(),
        segments: Vec::new(),
        fit: Vec::new(),
        passing: Array2::default((0, 0)),
        power: Vec::new(),
        energies: Vec::new(),
    }
}

/// Transforms all records. The transforms go to `between`, where there is one; where there is
/// none, spectra go to `sink`.
pub(super) fn transform_records<T: Real>(
    plan: &Plan,
    prepared: &Prepared,
    edge: f64,
    stored: f64,
    mut between: Option<&mut Between<T>>,
    sink: &dyn Sink,
    observer: &dyn Observer,
) -> Result<Columns> {
    let (nx, nf) = (plan.axes.n_sites, plan.axes.frequency.len());
    observer.stage("along time", nx as u64);
    let transform = RecordTransform::<T>::new(&plan.window_time, plan.conventions.padded_time);
    let wanted = between.is_none();
    let mut done = Columns {
        rows: Vec::with_capacity(nx),
        energies: Vec::with_capacity(nx),
        map: wanted.then(|| MapBuilder::largest((nf, nx), super::MAP_LIMIT)),
    };
    let rows = if wanted { nf } else { 0 };
    let mut buffer = Buffer::zeros((rows, plan.blocks.sites))?;
    for from in (0..nx).step_by(plan.blocks.sites) {
        let width = plan.blocks.sites.min(nx - from);
        let mut spectra = buffer.view_mut((rows, width))?;
        let ahead = prepared.read_ahead(from..from + width);
        let stripes = Stripes {
            plan,
            prepared,
            ahead: ahead.as_ref(),
            transform: &transform,
            edge,
            observer,
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
        if let Some(map) = &mut done.map {
            if stored != 1.0 {
                spectra.par_mapv_inplace(|p| p * stored);
            }
            map.add(0, from, spectra.view());
            sink.put(LargeArray::TemporalSpectrum, 0, from, spectra.view())?;
        }
        prepared.release_pages();
    }
    Ok(done)
}

/// A block of sites, shared out in stripes of a few sites each.
struct Stripes<'a, T: Real> {
    plan: &'a Plan,
    prepared: &'a Prepared<'a>,
    ahead: Option<&'a Ahead>,
    transform: &'a RecordTransform<T>,
    edge: f64,
    observer: &'a dyn Observer,
    from: usize,
}

impl<T: Real> Stripes<'_, T> {
    /// Fills `spectra` (no rows: not wanted) and `between`, both `(.., site)`.
    fn run(
        &self,
        mut spectra: ArrayViewMut2<f64>,
        between: Option<ArrayViewMut2<Complex<T>>>,
    ) -> Result<Vec<(Row, f64)>> {
        let tile = self.plan.tiles.sites;
        let width = spectra.ncols();
        let mut nothing = Array2::default((0, width));
        let mut between = between.unwrap_or_else(|| nothing.view_mut());
        let done: Result<Vec<Vec<(Row, f64)>>> = spectra
            .axis_chunks_iter_mut(Axis(1), tile)
            .into_par_iter()
            .zip(between.axis_chunks_iter_mut(Axis(1), tile))
            .enumerate()
            .map_init(
                || (worker(self.plan, self.transform), Vec::new()),
                |(worker, values), (i, (spectra, between))| {
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
        values.resize(width * self.plan.axes.n_times, 0.0);
        // Segments need records, and what was read ahead holds them.
        let samples = if self.plan.request.welch.is_some() || self.ahead.is_some() {
            self.prepared.records(self.ahead, sites.clone(), values);
            Samples::Records(values)
        } else {
            self.prepared.columns(sites.clone(), values);
            Samples::Columns(values)
        };
        let kept = (between.nrows() > 0).then_some(between);
        worker.spectra(self.prepared, sites, samples, kept);
        for (mut row, power) in spectra.outer_iter_mut().zip(&worker.power) {
            row.iter_mut().zip(&power.0).for_each(|(to, &p)| *to = p);
        }
        let axis = &self.plan.axes.frequency;
        let rows = moments_across(&mut worker.power, axis, self.edge);
        let seen = rows.into_iter().zip(worker.energies.iter().copied());
        self.observer.advance(width as u64);
        Ok(seen.take(width).collect())
    }
}
