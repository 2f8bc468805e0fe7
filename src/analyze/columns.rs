//! The pass along time: every site's record to its spectrum.

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayViewMut2, Axis};
use num_complex::Complex;

use super::between::Between;
use super::plan::Plan;
use super::sink::{LargeArray, Sink};
use crate::analyze::Observer;
use crate::buffer::Buffer;
use crate::diagnostics::{MapBuilder, Row, moments_of};
use crate::error::{Error, Result};
use crate::prepare::{Ahead, Gap, Prepared, Trend};
use crate::sum::sum;
use crate::transform::{Real, RealTransform, Scale, Scratch, direct_sums, fold, power};

/// What the pass leaves behind beside the arrays.
#[derive(Debug)]
pub(super) struct Columns {
    pub rows: Vec<Row>,
    /// `sum (w v)^2` over all segments, one a site.
    pub energies: Vec<f64>,
    /// Of the spectra; `None` where they are not written by this pass.
    pub map: Option<MapBuilder>,
}

/// One site's records to spectra, with the thread's own buffers.
struct Worker<'a, T: Real> {
    plan: &'a Plan,
    transform: &'a RealTransform<T>,
    scale: Scale,
    scratch: Scratch<T>,
    segment: Vec<f64>,
    fit: Vec<f64>,
}

impl<T: Real> Worker<'_, T> {
    /// Mean power spectrum of the segments of `record`, and `sum (w v)^2` over them.
    ///
    /// `masked` are the times of the record that have no weight; `keep` gets each segment's
    /// transform.
    fn spectrum(
        &mut self,
        record: &[f64],
        masked: &[Gap],
        power_sum: &mut [f64],
        mut keep: impl FnMut(usize, &[Complex<T>]),
    ) -> f64 {
        let segments = self.plan.segments;
        power_sum.fill(0.0);
        let mut energy = 0.0;
        for (s, start) in segments.starts().enumerate() {
            let piece = &record[start..start + segments.length];
            let piece = if self.plan.request.welch.is_some() {
                self.segment.clear();
                self.segment.extend_from_slice(piece);
                let kind = self.plan.request.detrend_time;
                let first = masked.partition_point(|gap| gap.time < start);
                let end = start + segments.length;
                let masked = masked[first..].iter().take_while(|gap| gap.time < end);
                let is_masked = |i: usize| masked.clone().any(|gap| gap.time == start + i);
                Trend::remove_from(&mut self.segment, kind, |i| !is_masked(i), &mut self.fit);
                for gap in masked.clone() {
                    self.segment[gap.time - start] = 0.0;
                }
                &self.segment
            } else {
                piece
            };
            let (spectrum, segment_energy) = self.transform.transform(piece, &mut self.scratch);
            energy += segment_energy;
            for (sum, &x) in power_sum.iter_mut().zip(spectrum) {
                *sum += power(x);
            }
            keep(s, spectrum);
        }
        let n = self.transform.padded();
        let mean = self.scale.factor / segments.count() as f64;
        for (m, p) in power_sum.iter_mut().enumerate() {
            *p *= mean * fold(m, n);
        }
        energy
    }
}

/// The first site with energy (or the one named) and its spectrum; `None` without energy.
pub(super) fn reference<T: Real>(
    plan: &Plan,
    prepared: &Prepared,
    observer: &dyn Observer,
) -> Result<Option<(usize, Vec<f64>)>> {
    let transform = RealTransform::<T>::new(&plan.window_time, plan.conventions.padded_time);
    let mut worker = worker(plan, &transform);
    let mut record = vec![0.0; plan.axes.n_times];
    let mut spectrum = vec![0.0; transform.bins()];
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
            worker.spectrum(&record, prepared.masked(j), &mut spectrum, |_, _| {});
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
    let transform = RealTransform::<T>::new(&plan.window_time, plan.conventions.padded_time);
    let (length, bins) = (transform.padded(), transform.bins());
    let count = CHECKED_BINS.min(bins).min(CHECKED_SAMPLES / length);
    let mut record = vec![0.0; plan.axes.n_times];
    prepared.record(j, &mut record);
    record.truncate(plan.segments.length);
    let mut scratch = Scratch::default();
    let (spectrum, energy) = transform.transform(&record, &mut scratch);
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
    let sums = direct_sums(&tapered, &chosen);
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

fn worker<'a, T: Real>(plan: &'a Plan, transform: &'a RealTransform<T>) -> Worker<'a, T> {
    Worker {
        plan,
        transform,
        scale: plan.time_scale,
        scratch: Scratch::default(),
        segment: Vec::new(),
        fit: Vec::new(),
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
    let transform = RealTransform::<T>::new(&plan.window_time, plan.conventions.padded_time);
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
    transform: &'a RealTransform<T>,
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
                || (worker(self.plan, self.transform), Tile::default()),
                |(worker, tile_buffers), (i, (spectra, between))| {
                    self.stripe(self.from + i * tile, worker, tile_buffers, spectra, between)
                },
            )
            .collect();
        Ok(done?.concat())
    }

    fn stripe(
        &self,
        first: usize,
        worker: &mut Worker<T>,
        tile: &mut Tile<T>,
        mut spectra: ArrayViewMut2<f64>,
        mut between: ArrayViewMut2<Complex<T>>,
    ) -> Result<Vec<(Row, f64)>> {
        if self.observer.cancelled() {
            return Err(Error::Cancelled);
        }
        let width = spectra.ncols();
        let n_times = self.plan.axes.n_times;
        let (nf, segments) = (self.transform.bins(), self.plan.segments.count());
        tile.records.resize(width * n_times, 0.0);
        self.prepared
            .records(self.ahead, first..first + width, &mut tile.records);
        tile.power.resize(width * nf, 0.0);
        let keep = between.nrows() > 0;
        tile.transforms.resize(
            if keep { width * nf * segments } else { 0 },
            Complex::default(),
        );
        let axis = &self.plan.axes.frequency;
        let mut seen = Vec::with_capacity(width);
        for (c, record) in tile.records.chunks_exact(n_times).enumerate() {
            let power = &mut tile.power[c * nf..][..nf];
            let kept = &mut tile.transforms;
            let masked = self.prepared.masked(first + c);
            let energy = worker.spectrum(record, masked, power, |s, spectrum| {
                if keep {
                    kept[(c * segments + s) * nf..][..nf].copy_from_slice(spectrum);
                }
            });
            seen.push((moments_of(power, axis, self.edge), energy));
        }
        if spectra.nrows() > 0 {
            for (m, mut row) in spectra.outer_iter_mut().enumerate() {
                for (c, value) in row.iter_mut().enumerate() {
                    *value = tile.power[c * nf + m];
                }
            }
        }
        for (at, mut row) in between.outer_iter_mut().enumerate() {
            let (m, s) = (at / segments, at % segments);
            for (c, value) in row.iter_mut().enumerate() {
                *value = tile.transforms[(c * segments + s) * nf + m];
            }
        }
        self.observer.advance(width as u64);
        Ok(seen)
    }
}

/// Buffers of one thread for one stripe, site by site.
struct Tile<T> {
    records: Vec<f64>,
    power: Vec<f64>,
    transforms: Vec<Complex<T>>,
}

impl<T> Default for Tile<T> {
    fn default() -> Self {
        Tile {
            records: Vec::new(),
            power: Vec::new(),
            transforms: Vec::new(),
        }
    }
}
