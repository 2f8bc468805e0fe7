//! The second half of the space-time transform: along space at each frequency.

use std::ops::Range;
use std::sync::{PoisonError, RwLock};

use ndarray::s;
use num_complex::Complex;

use super::blocks::RowBlocks;
use super::intermediate::Intermediate;
use super::plan::Plan;
use super::rows::add_rows;
use super::stages::Stages;
use crate::arrays::LargeArray;
use crate::error::Result;
use crate::numeric::sum;
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
    /// Sum over frequencies at each wavenumber of both signs.
    pub wavenumber_energies: Vec<f64>,
    /// Of these, what stands still: energy at f = 0.
    pub static_energies: Vec<f64>,
}

/// Transforms all frequencies; the spectrum goes to the sink.
///
/// So do the spectra along time if requested: `between` holds their transforms row by row, in the
/// order of the array.
pub(super) fn transform_frequencies<T: Real>(
    all: &Stages,
    between: Intermediate<T>,
) -> Result<Frequencies> {
    let plan = all.plan;
    let (nf, nk) = (plan.axes.frequency.len(), plan.axes.wavenumber_signed.len());
    all.observer.stage("space-time", nf as u64);
    let mut done = Frequencies {
        directions: Vec::with_capacity(nf),
        wavenumber_energies: vec![0.0; nk],
        static_energies: vec![0.0; nk],
    };
    let temporal = plan.request.results.temporal;
    // Spectra along time have no columns where they are not wanted.
    let records = usize::from(temporal) * plan.axes.n_sites;
    let pass = SpacetimePass {
        plan,
        transform: ComplexTransform::<T>::new(&plan.window_space, plan.conventions.padded_space),
        stored: all.stored,
    };
    let (between, segments) = (RwLock::new(between), plan.segments.count());
    let begin = |of: Range<usize>| {
        let mut between = between.write().unwrap_or_else(PoisonError::into_inner);
        between.hold(of.start * segments..of.end * segments)
    };
    let tile = |of: Range<usize>, arrays: [&mut [f64]; 2], room: &mut _| {
        let between = between.read().unwrap_or_else(PoisonError::into_inner);
        pass.tile(of, &between, arrays, room)
    };
    let blocks = RowBlocks {
        rows: nf,
        block: plan.blocks.frequencies,
        columns: [nk, records],
        tile: [ComplexTransform::<T>::TOGETHER, TILE],
        pages: None,
        observer: all.observer,
    };
    blocks.each(begin, tile, |from, directions, [powers, records]| {
        done.directions.extend(directions);
        add_rows(&mut done.wavenumber_energies, powers.view());
        if from == 0 {
            add_rows(&mut done.static_energies, powers.slice(s![..1, ..]));
        }
        let outputs = all.outputs;
        outputs.put(LargeArray::SPACETIME_SPECTRUM, (from, 0), powers.view())?;
        if temporal {
            outputs.put(LargeArray::TEMPORAL_SPECTRUM, (from, 0), records.view())?;
        }
        Ok(())
    })?;
    Ok(done)
}

/// What all blocks have in common.
struct SpacetimePass<'a, T: Real> {
    plan: &'a Plan,
    transform: ComplexTransform<T>,
    stored: f64,
}

impl<T: Real> SpacetimePass<'_, T> {
    /// Frequencies `of`: spectra along space, and of each site; with scratch for rows that are not contiguous.
    fn tile(
        &self,
        of: Range<usize>,
        between: &Intermediate<T>,
        [powers, records]: [&mut [f64]; 2],
        (scratch, room): &mut (ComplexScratch<T>, Vec<Complex<T>>),
    ) -> Vec<ByDirection> {
        let plan = self.plan;
        let segments = plan.segments.count();
        let together = ComplexTransform::<T>::TOGETHER;
        let (nk, nx) = (powers.len() / of.len(), records.len() / of.len());
        let profiles = of.start * segments..of.end * segments;
        let n = plan.conventions.padded_time;
        let mean = plan.time_scale.factor / segments as f64;
        let mut directions = Vec::with_capacity(of.len());
        for (group, from) in profiles.clone().step_by(together).enumerate() {
            let profiles = between.view(from..profiles.end.min(from + together), room);
            let spectra = self.transform.powers(profiles, scratch).chunks_exact(nk);
            for (i, (spectrum, profile)) in spectra.zip(profiles.outer_iter()).enumerate() {
                let at = group * together + i;
                let (row, segment) = (at / segments, at % segments);
                let (is_first, is_last) = (segment == 0, segment + 1 == segments);
                let m = of.start + row;
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
