//! The pass along space: every instant's profile to its spectrum, and to the flux surrogate.

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, s};
use num_complex::Complex;

use super::flux::FluxSurrogate;
use super::plan::Plan;
use super::quality::Ends;
use crate::arrays::{LargeArray, Sink};
use crate::diagnostics::{Bins, Keep, MapBuilder, SpectrumMoments, interleaved_moments};
use crate::error::{Error, Result};
use crate::numeric::lanes::{self, widest};
use crate::observer::Observer;
use crate::prepare::Prepared;
use crate::system::scratch_pool::ScratchPool;
use crate::transform::{Real, RecordScratch, RecordTransform, fold, power};

/// What the pass leaves behind beside the arrays.
#[derive(Debug)]
pub(super) struct SpatialPassResult {
    /// Measures of each instant's spectrum; empty where none is computed.
    pub rows: Vec<SpectrumMoments>,
    /// `sum (w v)^2` of each profile.
    pub energies: Vec<f64>,
    pub ends: Vec<Ends>,
    pub first_profile: Vec<f64>,
    pub last_profile: Vec<f64>,
    /// No maps where none are wanted.
    pub field_map: Option<MapBuilder>,
    pub map: Option<MapBuilder>,
    pub flux_map: Option<MapBuilder>,
    /// Sum over times at each wavenumber, with the map, where `S(k, f)` does not have it.
    pub wavenumber_energies: Option<Vec<f64>>,
}

/// The spectrum of time `n`.
pub(super) fn reference<T: Real>(plan: &Plan, prepared: &Prepared, n: usize) -> Vec<f64> {
    let transform = RecordTransform::<T>::new(&plan.window_space, plan.conventions.padded_space);
    let mut scratch = RecordScratch::default();
    let mut profile = vec![0.0; plan.axes.n_sites];
    prepared.profiles(n..n + 1, &mut profile);
    let (transformed, _) = transform.transform([&profile[..]].into_iter(), &mut scratch);
    let bins = transformed.iter().enumerate();
    bins.map(|(m, &x)| fold(m, transform.padded()) * power(x))
        .collect()
}

/// Examines all snapshots; transforms them if a result needs it.
pub(super) fn transform_profiles<T: Real>(
    plan: &Plan,
    prepared: &Prepared,
    edge: f64,
    stored: f64,
    sink: &dyn Sink,
    observer: &dyn Observer,
) -> Result<SpatialPassResult> {
    let (nt, nx, nk) = (
        plan.axes.n_times,
        plan.axes.n_sites,
        plan.axes.wavenumber.len(),
    );
    observer.stage("along space", nt as u64);
    let transform = plan
        .transforms_space()
        .then(|| RecordTransform::<T>::new(&plan.window_space, plan.conventions.padded_space));
    let results = plan.request.results;
    let has_maps = plan.request.maps;
    let map = |wanted: bool, keep: Keep, columns: usize| {
        (wanted && has_maps).then(|| plan.map_builder((nt, columns), keep))
    };
    let spectra = if transform.is_some() { nt } else { 0 };
    let mut done = SpatialPassResult {
        rows: Vec::with_capacity(spectra),
        energies: Vec::with_capacity(spectra),
        ends: Vec::with_capacity(nt),
        first_profile: Vec::new(),
        last_profile: Vec::new(),
        field_map: map(true, Keep::Extreme, nx),
        map: map(results.spatial, Keep::Largest, nk),
        flux_map: map(results.flux_surrogate, Keep::Extreme, nk),
        wavenumber_energies: (has_maps && plan.transforms_space() && !results.spacetime)
            .then(|| vec![0.0; nk]),
    };
    let mut flux = FluxSurrogate::new(plan, stored);
    let pass = SpatialPass {
        plan,
        prepared,
        transform: transform.as_ref(),
        pool: &ScratchPool::default(),
        scales: (0..nk)
            .map(|m| plan.space_scale.factor * fold(m, plan.conventions.padded_space))
            .collect(),
        unit: stored,
        bins: plan.wavenumber_bins(),
        edge,
        observer,
    };
    let columns = if transform.is_some() { nk } else { 0 };
    let room = || SnapshotBlock {
        from: 0,
        profiles: Array2::zeros((plan.blocks.times, nx)),
        spectra: Array2::zeros((plan.blocks.times, columns)),
        seen: Vec::new(),
    };
    // While one block is handed on, the next is computed.
    let (mut computed, mut next) = (room(), room());
    let starts = (0..nt).step_by(plan.blocks.times);
    for from in starts.map(Some).chain([None]) {
        let (handed_on, filled) = rayon::join(
            || done.take(&pass, &mut computed, &mut flux, sink),
            || from.map_or(Ok(()), |from| pass.fill(from, &mut next)),
        );
        handed_on?;
        filled?;
        std::mem::swap(&mut computed, &mut next);
        prepared.release_pages();
    }
    Ok(done)
}

/// Snapshots of neighbouring times, and their results.
struct SnapshotBlock {
    from: usize,
    profiles: Array2<f64>,
    spectra: Array2<f64>,
    /// One a time; none once it was handed on.
    seen: Vec<SnapshotFindings>,
}

impl SpatialPassResult {
    /// Takes a block in and passes its arrays on.
    fn take<T: Real>(
        &mut self,
        pass: &SpatialPass<T>,
        block: &mut SnapshotBlock,
        flux: &mut FluxSurrogate,
        sink: &dyn Sink,
    ) -> Result<()> {
        let (plan, prepared) = (pass.plan, pass.prepared);
        let (from, count) = (block.from, block.seen.len());
        if count == 0 {
            return Ok(());
        }
        for seen in block.seen.drain(..) {
            self.ends.push(seen.ends);
            if let Some((row, energy)) = seen.spectrum {
                self.rows.push(row);
                self.energies.push(energy);
            }
        }
        let profiles = block.profiles.slice(s![..count, ..]);
        let stored = prepared.stored_profiles(from..from + count);
        let stored = stored.and_then(|s| ArrayView2::from_shape(profiles.dim(), s).ok());
        let profiles = stored.unwrap_or(profiles);
        let mut spectra = block.spectra.slice_mut(s![..count, ..]);
        if from == 0 {
            self.first_profile = profiles.row(0).to_vec();
        }
        self.last_profile = profiles.row(count - 1).to_vec();
        if let Some(map) = &mut self.field_map {
            map.add(from, 0, profiles);
        }
        if let Some(sums) = &mut self.wavenumber_energies {
            add_rows(sums, spectra.view());
        }
        if plan.request.results.flux_surrogate {
            flux.take(spectra.view(), self.flux_map.as_mut(), sink)?;
        }
        if plan.request.results.spatial {
            if pass.unit != 1.0 {
                spectra.par_mapv_inplace(|p| p * pass.unit);
            }
            if let Some(map) = &mut self.map {
                map.add(from, 0, spectra.view());
            }
            sink.put(LargeArray::SPATIAL_SPECTRUM, from, 0, spectra.view())?;
        }
        Ok(())
    }
}

/// Adds the rows one by one, so that the bits do not depend on the blocks.
pub(super) fn add_rows(sums: &mut [f64], rows: ArrayView2<f64>) {
    for row in rows.outer_iter() {
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum += value;
        }
    }
}

/// Findings at one time.
struct SnapshotFindings {
    ends: Ends,
    spectrum: Option<(SpectrumMoments, f64)>,
}

/// What all blocks have in common.
struct SpatialPass<'a, T: Real> {
    plan: &'a Plan,
    prepared: &'a Prepared<'a>,
    transform: Option<&'a RecordTransform<T>>,
    /// With scratch for interleaved spectra.
    pool: &'a ScratchPool<(RecordScratch<T>, Vec<lanes::LaneBlock>)>,
    /// By which a bin's power is multiplied.
    scales: Vec<f64>,
    /// And again, after it was measured, before it is stored.
    unit: f64,
    bins: Bins<'a>,
    edge: f64,
    observer: &'a dyn Observer,
}

impl<T: Real> SpatialPass<'_, T> {
    /// Reads and transforms the profiles from `from` on, in parallel.
    fn fill(&self, from: usize, block: &mut SnapshotBlock) -> Result<()> {
        let count = self.plan.blocks.times.min(self.plan.axes.n_times - from);
        // Several tiles per thread if the block is large enough.
        let tile = count.div_ceil(4 * rayon::current_num_threads());
        let tile = tile
            .next_multiple_of(lanes::WIDTH)
            .min(self.plan.tiles.times);
        block.from = from;
        let seen: Result<Vec<Vec<SnapshotFindings>>> = block
            .profiles
            .slice_mut(s![..count, ..])
            .axis_chunks_iter_mut(Axis(0), tile)
            .into_par_iter()
            .zip(
                block
                    .spectra
                    .slice_mut(s![..count, ..])
                    .axis_chunks_iter_mut(Axis(0), tile),
            )
            .enumerate()
            .map_init(
                || self.pool.take(|_| true, Default::default),
                |room, (i, (profiles, spectra))| {
                    if self.observer.cancelled() {
                        return Err(Error::Cancelled);
                    }
                    self.observer.advance(profiles.nrows() as u64);
                    Ok(self.tile(from + i * tile, profiles, spectra, room))
                },
            )
            .collect();
        block.seen = seen?.into_iter().flatten().collect();
        Ok(())
    }

    /// The same of a few times.
    fn tile(
        &self,
        first: usize,
        mut profiles: ArrayViewMut2<f64>,
        mut spectra: ArrayViewMut2<f64>,
        (scratch, across): &mut (RecordScratch<T>, Vec<lanes::LaneBlock>),
    ) -> Vec<SnapshotFindings> {
        let times = first..first + profiles.nrows();
        let (nx, nk) = (profiles.ncols(), spectra.ncols());
        // Bands of whole rows of a standard array are contiguous.
        let (Some(profiles), Some(spectra)) = (profiles.as_slice_mut(), spectra.as_slice_mut())
        else {
            return Vec::new();
        };
        let profiles = match self.prepared.stored_profiles(times.clone()) {
            Some(stored) => stored,
            None => {
                self.prepared.profiles(times, profiles);
                profiles
            }
        };
        let ends = profiles.chunks_exact(nx).map(Ends::of);
        let Some(transform) = self.transform else {
            return ends
                .map(|ends| SnapshotFindings {
                    ends,
                    spectrum: None,
                })
                .collect();
        };
        let mut seen = Vec::with_capacity(ends.len());
        let together = lanes::WIDTH;
        let groups = profiles
            .chunks(together * nx)
            .zip(spectra.chunks_mut(together * nk));
        for (profiles, spectra) in groups {
            let width = profiles.len() / nx;
            let (transformed, energies) = transform.transform(profiles.chunks_exact(nx), scratch);
            // Unused lanes are not read.
            across.resize(nk, lanes::LaneBlock::default());
            widest(SnapshotPowers {
                transformed,
                width,
                scales: &self.scales,
                across: &mut *across,
                spectra,
            });
            let rows = interleaved_moments(across, &self.bins, self.edge);
            let spectra = rows.into_iter().zip(energies.iter().copied());
            seen.extend(
                profiles
                    .chunks_exact(nx)
                    .zip(spectra)
                    .map(|(profile, spectrum)| SnapshotFindings {
                        ends: Ends::of(profile),
                        spectrum: Some(spectrum),
                    }),
            );
        }
        seen
    }
}

/// Spectra of a few times from batched transforms, interleaved and one after the other.
struct SnapshotPowers<'a, T> {
    transformed: &'a [Complex<T>],
    width: usize,
    scales: &'a [f64],
    across: &'a mut [lanes::LaneBlock],
    spectra: &'a mut [f64],
}

impl<T: Real> lanes::SimdKernel for SnapshotPowers<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: lanes::Lanes>(self) {
        let bins = self.transformed.chunks_exact(self.width);
        for (powers, (bins, scale)) in self.across.iter_mut().zip(bins.zip(self.scales)) {
            // Whole blocks have a length that the compiler knows.
            if let Some(bins) = bins.first_chunk::<{ lanes::WIDTH }>() {
                powers.0 = bins.map(|x| power(x) * scale);
                continue;
            }
            for (p, &x) in powers.0.iter_mut().zip(bins) {
                *p = power(x) * scale;
            }
        }
        let bins = self.across.len();
        for (lane, spectrum) in self.spectra.chunks_exact_mut(bins).enumerate() {
            for (p, powers) in spectrum.iter_mut().zip(&*self.across) {
                *p = powers.0[lane];
            }
        }
    }
}
