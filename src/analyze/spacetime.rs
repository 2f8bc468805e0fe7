//! The second half of the space-time transform: along space at each frequency.

use std::ops::Range;

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayViewMut2, Axis, s};
use num_complex::Complex;

use super::intermediate::{Intermediate, Rows};
use super::plan::Plan;
use super::rows::add_rows;
use crate::arrays::{LargeArray, Sink};
use crate::diagnostics::{Keep, MapBuilder};
use crate::error::{Error, Result};
use crate::numeric::sum;
use crate::observer::Observer;
use crate::system::scratch_pool::ScratchPool;
use crate::transform::{ComplexScratch, ComplexTransform, Real, fold, power};

/// Largest number of frequencies per tile.
const TILE: usize = 16;

/// Energy of one frequency, by direction (sums over bins, one-sided in f).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ByDirection {
    pub toward_plus_x: f64,
    pub toward_minus_x: f64,
    pub undirected: f64,
}

impl ByDirection {
    /// Splits the ascending row of frequency bin `m` of a transform of length `n`.
    fn of(row: &[f64], m: usize, n: usize) -> Self {
        if m == 0 || 2 * m == n {
            return ByDirection {
                undirected: sum(row),
                ..Self::default()
            };
        }
        let zero = row.len() / 2;
        // For an even number of bins the lowest wavenumber is the Nyquist line.
        let lowest = usize::from(row.len().is_multiple_of(2));
        let nyquist = sum(&row[..lowest]);
        ByDirection {
            toward_minus_x: sum(&row[lowest..zero]),
            toward_plus_x: sum(&row[zero + 1..]),
            undirected: nyquist + row[zero],
        }
    }

    pub fn total(&self) -> f64 {
        self.toward_plus_x + self.toward_minus_x + self.undirected
    }
}

/// What the pass leaves behind beside the arrays.
#[derive(Debug)]
pub(super) struct Frequencies {
    /// One entry a frequency.
    pub directions: Vec<ByDirection>,
    /// `None` where no maps are wanted.
    pub map: Option<MapBuilder>,
    /// Of the spectra along time, which this pass has by rows; see [`transform_frequencies`].
    pub temporal_map: Option<MapBuilder>,
    /// Sum over frequencies at each wavenumber of both signs, with the map.
    pub wavenumber_energies: Option<Vec<f64>>,
    /// Of these, what stands still: energy at f = 0.
    pub static_energies: Vec<f64>,
}

/// Transforms all frequencies; the spectrum goes to `sink`.
///
/// So do the spectra along time if requested: `between` holds their transforms row by row, in the
/// order of the array.
pub(super) fn transform_frequencies<T: Real>(
    plan: &Plan,
    between: &mut Intermediate<T>,
    stored: f64,
    sink: &dyn Sink,
    observer: &dyn Observer,
) -> Result<Frequencies> {
    let (nf, nk) = (plan.axes.frequency.len(), plan.axes.wavenumber_signed.len());
    let nx = plan.axes.n_sites;
    observer.stage("space-time", nf as u64);
    let transform = ComplexTransform::<T>::new(&plan.window_space, plan.conventions.padded_space);
    let pass = SpacetimePass {
        plan,
        transform: &transform,
        pool: &ScratchPool::default(),
        stored,
        observer,
    };
    let map = |wanted: bool, columns: usize| {
        (wanted && plan.request.maps).then(|| plan.map_builder((nf, columns), Keep::Largest))
    };
    let mut done = Frequencies {
        directions: Vec::with_capacity(nf),
        map: map(true, nk),
        temporal_map: map(plan.request.results.temporal, nx),
        wavenumber_energies: Some(vec![0.0; nk]),
        static_energies: vec![0.0; nk],
    };
    let width = if plan.request.results.temporal { nx } else { 0 };
    let room = || FrequencyBlock {
        from: 0,
        powers: Array2::zeros((plan.blocks.frequencies, nk)),
        records: Array2::zeros((plan.blocks.frequencies, width)),
        directions: Vec::new(),
    };
    // While one block is handed on, the next is computed.
    let (mut computed, mut next) = (room(), room());
    let starts = (0..nf).step_by(plan.blocks.frequencies);
    for from in starts.map(Some).chain([None]) {
        let (handed_on, filled) = rayon::join(
            || done.take(&mut computed, sink),
            || from.map_or(Ok(()), |from| pass.fill(from, between, &mut next)),
        );
        handed_on?;
        filled?;
        std::mem::swap(&mut computed, &mut next);
    }
    Ok(done)
}

/// Neighbouring frequencies.
struct FrequencyBlock {
    from: usize,
    powers: Array2<f64>,
    /// Spectra along time; no columns where they are not wanted.
    records: Array2<f64>,
    /// One a frequency; none once it was handed on.
    directions: Vec<ByDirection>,
}

impl Frequencies {
    /// Takes a block in and passes its arrays on.
    fn take(&mut self, block: &mut FrequencyBlock, sink: &dyn Sink) -> Result<()> {
        let (from, count) = (block.from, block.directions.len());
        if count == 0 {
            return Ok(());
        }
        self.directions.append(&mut block.directions);
        let powers = block.powers.slice(s![..count, ..]);
        if let Some(map) = &mut self.map {
            map.add(from, 0, powers);
        }
        if let Some(sums) = &mut self.wavenumber_energies {
            add_rows(sums, powers);
            if from == 0 {
                add_rows(&mut self.static_energies, powers.slice(s![..1, ..]));
            }
        }
        sink.put(LargeArray::SPACETIME_SPECTRUM, from, 0, powers)?;
        let records = block.records.slice(s![..count, ..]);
        if records.ncols() > 0 {
            if let Some(map) = &mut self.temporal_map {
                map.add(from, 0, records);
            }
            sink.put(LargeArray::TEMPORAL_SPECTRUM, from, 0, records)?;
        }
        Ok(())
    }
}

/// What all blocks have in common.
struct SpacetimePass<'a, T: Real> {
    plan: &'a Plan,
    transform: &'a ComplexTransform<T>,
    /// With scratch for rows that are not contiguous.
    pool: &'a ScratchPool<(ComplexScratch<T>, Vec<Complex<T>>)>,
    stored: f64,
    observer: &'a dyn Observer,
}

impl<T: Real> SpacetimePass<'_, T> {
    /// Transforms the frequencies from `from` on, in parallel.
    fn fill(
        &self,
        from: usize,
        between: &mut Intermediate<T>,
        block: &mut FrequencyBlock,
    ) -> Result<()> {
        let all = self.plan.axes.frequency.len();
        let count = self.plan.blocks.frequencies.min(all - from);
        let segments = self.plan.segments.count();
        // Several tiles per thread if the block is large enough.
        let tile = count.div_ceil(4 * rayon::current_num_threads());
        let tile = tile
            .next_multiple_of(ComplexTransform::<T>::TOGETHER)
            .min(TILE);
        let mut powers = block.powers.slice_mut(s![..count, ..]);
        let mut records = block.records.slice_mut(s![..count, ..]);
        block.from = from;
        let rows = between.rows(from * segments..(from + count) * segments)?;
        let seen: Result<Vec<Vec<ByDirection>>> = powers
            .axis_chunks_iter_mut(Axis(0), tile)
            .into_par_iter()
            .zip(records.axis_chunks_iter_mut(Axis(0), tile))
            .enumerate()
            .map_init(
                || self.pool.take(|_| true, Default::default),
                |room, (i, (powers, records))| {
                    if self.observer.cancelled() {
                        return Err(Error::Cancelled);
                    }
                    let count = powers.nrows();
                    self.observer.advance(count as u64);
                    let first = i * tile * segments;
                    let profiles = (&rows, first..first + count * segments);
                    Ok(self.frequencies(from + i * tile, profiles, room, powers, records))
                },
            )
            .collect();
        block.directions = seen?.concat();
        Ok(())
    }

    /// Frequencies from `first` on: spectra along space to `powers`, of each site to `records`.
    fn frequencies(
        &self,
        first: usize,
        (rows, profiles): (&Rows<T>, Range<usize>),
        (scratch, room): &mut (ComplexScratch<T>, Vec<Complex<T>>),
        mut powers: ArrayViewMut2<f64>,
        mut records: ArrayViewMut2<f64>,
    ) -> Vec<ByDirection> {
        let plan = self.plan;
        let segments = plan.segments.count();
        let together = ComplexTransform::<T>::TOGETHER;
        // Bands of whole rows of standard arrays are contiguous.
        let (nk, nx) = (powers.ncols(), records.ncols());
        let (Some(powers), Some(records)) = (powers.as_slice_mut(), records.as_slice_mut()) else {
            return Vec::new();
        };
        let n = plan.conventions.padded_time;
        let mean = plan.time_scale.factor / segments as f64;
        let mut directions = Vec::with_capacity(powers.len() / nk);
        for (group, from) in profiles.clone().step_by(together).enumerate() {
            let profiles = rows.view(from..profiles.end.min(from + together), room);
            let spectra = self.transform.powers(profiles, scratch).chunks_exact(nk);
            for (i, (spectrum, profile)) in spectra.zip(profiles.outer_iter()).enumerate() {
                let at = group * together + i;
                let (row, segment) = (at / segments, at % segments);
                let (is_first, is_last) = (segment == 0, segment + 1 == segments);
                let m = first + row;
                let scale = mean * fold(m, n);
                let powers = &mut powers[row * nk..][..nk];
                let along_space = scale * plan.space_scale.factor;
                let factor = if is_last { along_space } else { 1.0 };
                add(powers, spectrum.iter().copied(), is_first, factor);
                let record = &mut records[row * nx..][..nx];
                let factor = if is_last { scale * self.stored } else { 1.0 };
                if let Some(profile) = profile.to_slice() {
                    add(record, profile.iter().map(|&x| power(x)), is_first, factor);
                }
                if is_last {
                    directions.push(ByDirection::of(powers, m, n));
                    if self.stored != 1.0 {
                        powers.iter_mut().for_each(|p| *p *= self.stored);
                    }
                }
            }
        }
        directions
    }
}

/// Adds to `sums`, which hold nothing before the first time, and multiplies by `factor`.
#[inline(always)]
fn add(sums: &mut [f64], terms: impl Iterator<Item = f64>, is_first: bool, factor: f64) {
    let sums = sums.iter_mut().zip(terms);
    match is_first {
        true => sums.for_each(|(sum, term)| *sum = term * factor),
        false => sums.for_each(|(sum, term)| *sum = (*sum + term) * factor),
    }
}
