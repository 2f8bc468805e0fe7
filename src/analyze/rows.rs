//! The pass along space: every instant's profile to its spectrum, and to the flux surrogate.

use std::ops::Range;

use ndarray::{ArrayView2, ArrayViewMut2};

use super::blocks::RowBlocks;
use super::flux::FluxSurrogate;
use super::plan::Plan;
use super::quality::Ends;
use super::stages::Stages;
use super::worker::AddPowers;
use crate::arrays::LargeArray;
use crate::diagnostics::{Bins, Keep, MapBuilder, SpectrumMoments, interleaved_moments};
use crate::error::Result;
use crate::numeric::lanes::{self, widest};
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
    let transform = plan.profile_transform::<T>();
    let mut scratch = RecordScratch::default();
    let mut profile = vec![0.0; plan.axes.n_sites];
    prepared.profiles(n..n + 1, &mut profile);
    let (transformed, _) = transform.transform([&profile[..]].into_iter(), &mut scratch);
    let bins = transformed.iter().enumerate();
    bins.map(|(m, &x)| fold(m, transform.padded()) * power(x))
        .collect()
}

/// Examines all snapshots; transforms them if a result needs it.
pub(super) fn transform_profiles<T: Real>(all: &Stages, edge: f64) -> Result<SpatialPassResult> {
    let (plan, prepared, stored) = (all.plan, all.prepared, all.stored);
    let axes = &plan.axes;
    let (nt, nx, nk) = (axes.n_times, axes.n_sites, axes.wavenumber.len());
    all.observer.stage("along space", nt as u64);
    let (results, has_maps) = (plan.request.results, plan.request.maps);
    let map = |wanted: bool, keep: Keep, columns: usize| {
        (wanted && has_maps).then(|| plan.map_builder((nt, columns), keep))
    };
    let is_made = plan.transforms_space();
    let [spectra, columns] = [nt, nk].map(|n| usize::from(is_made) * n);
    let scale = |m| plan.space_scale.factor * fold(m, plan.conventions.padded_space);
    let has_sums = has_maps && is_made && !results.spacetime;
    let mut done = SpatialPassResult {
        rows: Vec::with_capacity(spectra),
        energies: Vec::with_capacity(spectra),
        ends: Vec::with_capacity(nt),
        first_profile: Vec::new(),
        last_profile: Vec::new(),
        field_map: map(true, Keep::Extreme, nx),
        map: map(results.spatial, Keep::Largest, nk),
        flux_map: map(results.flux_surrogate, Keep::Extreme, nk),
        wavenumber_energies: has_sums.then(|| vec![0.0; nk]),
    };
    let mut flux = FluxSurrogate::new(plan, stored);
    let pass = SpatialPass {
        prepared,
        transform: is_made.then(|| plan.profile_transform::<T>()),
        scales: (0..nk).map(scale).collect(),
        bins: plan.wavenumber_bins(),
        edge,
    };
    let blocks = RowBlocks {
        rows: nt,
        block: plan.blocks.times,
        columns: [nx, columns],
        tile: [lanes::WIDTH, plan.tiles.times],
        observer: all.observer,
    };
    let pool = ScratchPool::default();
    blocks.each(
        |times, block| {
            blocks.fill(times, block, &pool, |times, rows, room| {
                pass.tile(times, rows, room)
            })?;
            prepared.release_pages();
            Ok(())
        },
        |from, seen, arrays| done.take(all, from, seen, arrays, &mut flux),
    )?;
    Ok(done)
}

impl SpatialPassResult {
    /// Takes a block of profiles and their spectra in and passes them on.
    fn take(
        &mut self,
        all: &Stages,
        from: usize,
        seen: Vec<SnapshotFindings>,
        [profiles, mut spectra]: [ArrayViewMut2<f64>; 2],
        flux: &mut FluxSurrogate,
    ) -> Result<()> {
        let count = seen.len();
        for (ends, spectrum) in seen {
            self.ends.push(ends);
            if let Some((row, energy)) = spectrum {
                self.rows.push(row);
                self.energies.push(energy);
            }
        }
        let stored = all.prepared.stored_profiles(from..from + count);
        let stored = stored.and_then(|s| ArrayView2::from_shape(profiles.dim(), s).ok());
        let profiles = stored.unwrap_or(profiles.view());
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
        let results = all.plan.request.results;
        if results.flux_surrogate {
            flux.take(spectra.view(), self.flux_map.as_mut(), all.sink)?;
        }
        if results.spatial {
            if all.stored != 1.0 {
                spectra.par_mapv_inplace(|p| p * all.stored);
            }
            if let Some(map) = &mut self.map {
                map.add(from, 0, spectra.view());
            }
            let array = LargeArray::SPATIAL_SPECTRUM;
            all.sink.put(array, from, 0, spectra.view())?;
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

/// Findings at one time; measures of the spectrum with its energy, where there is one.
type SnapshotFindings = (Ends, Option<(SpectrumMoments, f64)>);

/// What all blocks have in common.
struct SpatialPass<'a, T: Real> {
    prepared: &'a Prepared<'a>,
    transform: Option<RecordTransform<T>>,
    /// By which a bin's power is multiplied.
    scales: Vec<f64>,
    bins: Bins<'a>,
    edge: f64,
}

impl<T: Real> SpatialPass<'_, T> {
    /// Reads and transforms the profiles of a few times, with scratch for interleaved spectra.
    fn tile(
        &self,
        times: Range<usize>,
        [profiles, spectra]: [&mut [f64]; 2],
        (scratch, across): &mut (RecordScratch<T>, Vec<lanes::LaneBlock>),
    ) -> Vec<SnapshotFindings> {
        let (nx, nk) = (profiles.len() / times.len(), self.scales.len());
        let profiles = self.prepared.snapshots(times, profiles);
        let ends = profiles.chunks_exact(nx).map(Ends::of);
        let Some(transform) = &self.transform else {
            return ends.map(|ends| (ends, None)).collect();
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
            let transformed = ArrayView2::from_shape((nk, width), transformed);
            widest(AddPowers {
                spectra: transformed.expect("as long as its shape"),
                sums: across,
                is_first: true,
                factor: |m| self.scales[m],
            });
            apart(across, spectra);
            let rows = interleaved_moments(across, &self.bins, self.edge);
            let spectra = rows.into_iter().zip(energies.iter().copied());
            let ends = profiles.chunks_exact(nx).map(Ends::of);
            seen.extend(ends.zip(spectra.map(Some)));
        }
        seen
    }
}

/// Interleaved spectra one after the other.
fn apart(across: &[lanes::LaneBlock], spectra: &mut [f64]) {
    for (lane, spectrum) in spectra.chunks_exact_mut(across.len()).enumerate() {
        for (p, powers) in spectrum.iter_mut().zip(across) {
            *p = powers.0[lane];
        }
    }
}
