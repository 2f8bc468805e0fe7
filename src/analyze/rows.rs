//! The pass along space: every instant's profile to its spectrum, and to the flux surrogate.

use std::ops::Range;

use ndarray::ArrayView2;

use super::blocks::RowBlocks;
use super::flux::FluxSurrogate;
use super::plan::Plan;
use super::quality::Ends;
use super::stages::Stages;
use super::worker::Worker;
use crate::arrays::LargeArray;
use crate::diagnostics::{Bins, SpectrumMoments};
use crate::error::Result;
use crate::numeric::lanes;
use crate::prepare::Prepared;
use crate::transform::{Real, RecordTransform, fold};

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
    /// Sum over times at each wavenumber, with the map, where `S(k, f)` does not have it.
    pub wavenumber_energies: Option<Vec<f64>>,
}

/// The spectrum of time `n`.
pub(super) fn reference<T: Real>(plan: &Plan, prepared: &Prepared, n: usize) -> Vec<f64> {
    let mut profile = vec![0.0; plan.axes.n_sites];
    prepared.profiles(n..n + 1, &mut profile);
    let mut worker = Worker::<T>::default();
    let padded = plan.conventions.padded_space;
    let factor = |m| fold(m, padded);
    of_profiles(&plan.profile_transform(), &profile, factor, &mut worker);
    worker.first()
}

/// Power spectra of at most eight profiles, one after the other, times the `factor` of a bin.
fn of_profiles<T: Real>(
    transform: &RecordTransform<T>,
    profiles: &[f64],
    factor: impl Fn(usize) -> f64,
    worker: &mut Worker<T>,
) {
    let each = profiles.chunks_exact(transform.samples());
    let shape = (transform.bins(), each.len());
    worker.add(shape, None, (true, factor), |spectra, scratch| {
        transform.transform_into(each, spectra, scratch)
    });
}

/// Examines all snapshots; transforms them if a result needs it.
pub(super) fn transform_profiles<T: Real>(all: &Stages, edge: f64) -> Result<SpatialPassResult> {
    let (plan, prepared) = (all.plan, all.prepared);
    let axes = &plan.axes;
    let (nt, nx, nk) = (axes.n_times, axes.n_sites, axes.wavenumber.len());
    all.observer.stage("along space", nt as u64);
    let is_made = plan.transforms_space();
    let [spectra, columns] = [nt, nk].map(|n| usize::from(is_made) * n);
    let scale = |m| plan.space_scale.factor * fold(m, plan.conventions.padded_space);
    let has_sums = plan.request.maps && is_made && !plan.request.results.spacetime;
    let is_wanted = plan.request.results.flux_surrogate;
    let mut flux = is_wanted.then(|| FluxSurrogate::new(plan));
    let mut done = SpatialPassResult {
        rows: Vec::with_capacity(spectra),
        energies: Vec::with_capacity(spectra),
        ends: Vec::with_capacity(nt),
        first_profile: Vec::new(),
        last_profile: Vec::new(),
        wavenumber_energies: has_sums.then(|| vec![0.0; nk]),
    };
    let pass = SpatialPass {
        prepared,
        transform: is_made.then(|| plan.profile_transform::<T>()),
        scales: (0..nk).map(scale).collect(),
        stored: all.stored,
        bins: plan.wavenumber_bins(),
        edge,
    };
    let blocks = RowBlocks {
        rows: nt,
        block: plan.blocks.times,
        columns: [nx, columns],
        tile: [lanes::WIDTH, plan.tiles.times],
        pages: Some(prepared),
        observer: all.observer,
    };
    let tile = |times, arrays: [&mut [f64]; 2], worker: &mut _| pass.tile(times, arrays, worker);
    blocks.each(
        |_| Ok(()),
        tile,
        |from, seen, [profiles, spectra]| {
            let spectra = spectra.view();
            done.take(all, (from, seen), profiles.view(), spectra);
            if let Some(flux) = &mut flux {
                flux.take(spectra, all.outputs)?;
            }
            match plan.request.results.spatial {
                true => {
                    let array = LargeArray::SPATIAL_SPECTRUM;
                    all.outputs.put(array, (from, 0), spectra)
                }
                false => Ok(()),
            }
        },
    )?;
    Ok(done)
}

impl SpatialPassResult {
    /// Takes in what was found in a block, its profiles as they were read, and their spectra.
    fn take(
        &mut self,
        all: &Stages,
        (from, seen): (usize, Vec<SnapshotFindings>),
        read: ArrayView2<f64>,
        spectra: ArrayView2<f64>,
    ) {
        let count = seen.len();
        for (ends, spectrum) in seen {
            self.ends.push(ends);
            if let Some((row, energy)) = spectrum {
                self.rows.push(row);
                self.energies.push(energy);
            }
        }
        let stored = all.prepared.stored_profiles(from..from + count);
        let stored = stored.and_then(|stored| ArrayView2::from_shape(read.dim(), stored).ok());
        let profiles = stored.unwrap_or(read);
        if from == 0 {
            self.first_profile = profiles.row(0).to_vec();
        }
        self.last_profile = profiles.row(count - 1).to_vec();
        (all.outputs).show(LargeArray::SAMPLES, (from, 0), profiles);
        if let Some(sums) = &mut self.wavenumber_energies {
            add_rows(sums, spectra);
        }
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
    /// By which a bin's power is multiplied, and all once they are measured.
    scales: Vec<f64>,
    stored: f64,
    bins: Bins<'a>,
    edge: f64,
}

impl<T: Real> SpatialPass<'_, T> {
    /// Reads and transforms the profiles of a few times.
    fn tile(
        &self,
        times: Range<usize>,
        [profiles, spectra]: [&mut [f64]; 2],
        worker: &mut Worker<T>,
    ) -> Vec<SnapshotFindings> {
        let (nx, nk) = (profiles.len() / times.len(), self.scales.len());
        let profiles = self.prepared.snapshots(times, profiles);
        let ends = profiles.chunks_exact(nx).map(Ends::of);
        let Some(transform) = &self.transform else {
            return ends.map(|ends| (ends, None)).collect();
        };
        let mut found = Vec::with_capacity(ends.len());
        let profiles = profiles.chunks(lanes::WIDTH * nx);
        for (profiles, spectra) in profiles.zip(spectra.chunks_mut(lanes::WIDTH * nk)) {
            of_profiles(transform, profiles, |m| self.scales[m], worker);
            for (lane, spectrum) in spectra.chunks_exact_mut(nk).enumerate() {
                for (p, powers) in spectrum.iter_mut().zip(&worker.power) {
                    *p = powers.0[lane] * self.stored;
                }
            }
            found.extend(worker.measured(&self.bins, self.edge));
        }
        ends.zip(found.into_iter().map(Some)).collect()
    }
}
