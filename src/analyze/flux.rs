//! The flux surrogate, from spectra along space as they come.

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayView2, Axis, azip, s};

use super::arrays::Outputs;
use super::plan::Plan;
use crate::arrays::LargeArray;
use crate::error::Result;
use crate::transform::{Scale, Scaling};

/// `Pi_K(k, t) = - d/dt sum_{|k'| <= k} E_K(k', t)` with `E_K` the energy spectrum of `v^2 / 2`:
/// central differences, one-sided ones of second order at the ends of the record.
pub(super) struct FluxSurrogate {
    n_times: usize,
    /// From a bin of the spatial spectrum, as scaled, to half its energy.
    half_energy: f64,
    dt: f64,
    /// Cumulative energies: of the last times of the block before, then of this one.
    cumulative: Array2<f64>,
    flux: Array2<f64>,
    /// Times taken in. All but the last are passed on, and the last two are kept.
    known: usize,
}

impl FluxSurrogate {
    pub fn new(plan: &Plan) -> Self {
        let (window, padded) = (&plan.window_space, plan.conventions.padded_space);
        let energy = Scale::along_space(Scaling::Energy, window, padded, plan.axes.space.step);
        let rows = plan.blocks.times + 2;
        // Each zeroed by itself: a clone would read pages that are not there yet.
        let room = || Array2::zeros((rows, plan.axes.wavenumber.len()));
        FluxSurrogate {
            n_times: plan.axes.n_times,
            half_energy: 0.5 * energy.factor * energy.measure / plan.space_scale.factor,
            dt: plan.axes.time.step,
            cumulative: room(),
            flux: room(),
            known: 0,
        }
    }

    /// Adds the next block of spectra and passes on all times that are complete.
    pub fn take(&mut self, spectra: ArrayView2<f64>, outputs: &Outputs) -> Result<()> {
        let (kept, next) = (self.known.min(2), self.known.saturating_sub(1));
        let held = kept + spectra.nrows();
        let (half_energy, columns) = (self.half_energy, spectra.ncols());
        self.cumulative
            .slice_mut(s![kept..held, ..])
            .axis_chunks_iter_mut(Axis(0), TOGETHER)
            .into_par_iter()
            .zip(spectra.axis_chunks_iter(Axis(0), TOGETHER))
            .for_each(|(mut cumulative, spectra)| {
                // Bands of whole rows of standard arrays are contiguous.
                let (Some(sums), Some(spectra)) = (cumulative.as_slice_mut(), spectra.as_slice())
                else {
                    return;
                };
                if sums.len() == TOGETHER * columns {
                    add_up::<TOGETHER>(sums, spectra, half_energy);
                } else {
                    let rows = sums
                        .chunks_exact_mut(columns)
                        .zip(spectra.chunks_exact(columns));
                    rows.for_each(|(sums, spectra)| add_up::<1>(sums, spectra, half_energy));
                }
            });
        self.known += spectra.nrows();
        let last = self.known == self.n_times;
        let until = if last { self.known } else { self.known - 1 };
        let from = self.known - held;
        let cumulative = &self.cumulative;
        let at = |n: usize| cumulative.row(n - from);
        let (all, dt) = (self.n_times, self.dt);
        let mut flux = self.flux.slice_mut(s![..until - next, ..]);
        flux.axis_iter_mut(Axis(0))
            .into_par_iter()
            .enumerate()
            .for_each(|(i, mut row)| {
                let n = next + i;
                let (ends, step) = match (n, all) {
                    (_, 1) => return row.fill(f64::NAN),
                    (_, 2) => ([0, 1], dt),
                    (0, _) => ([1, 2], dt),
                    _ if n + 1 == all => ([n - 1, n - 2], -dt),
                    _ => ([n - 1, n + 1], 2.0 * dt),
                };
                let [first, second] = ends.map(&at);
                if all > 2 && (n == 0 || n + 1 == all) {
                    azip!((out in &mut row, a in at(n), b in first, c in second) {
                        *out = -(4.0 * (b - a) - (c - a)) / (2.0 * step);
                    });
                } else {
                    azip!((out in &mut row, a in first, b in second) *out = -(b - a) / step);
                }
            });
        let array = LargeArray::KINETIC_FLUX_SURROGATE;
        outputs.put(array, (next, 0), flux.view())?;
        let kept = s![held - self.known.min(2)..held, ..];
        let kept = self.cumulative.slice(kept).to_owned();
        self.cumulative
            .slice_mut(s![..kept.nrows(), ..])
            .assign(&kept);
        Ok(())
    }
}

/// Spectra summed in an interleaved loop, to hide the latency of additions.
const TOGETHER: usize = 4;

/// `factor sum_{k' <= k} p(k')` of each of `R` rows.
fn add_up<const R: usize>(sums: &mut [f64], spectra: &[f64], factor: f64) {
    let columns = sums.len() / R;
    let mut below = [0.0; R];
    for k in 0..columns {
        for (r, below) in below.iter_mut().enumerate() {
            *below += spectra[r * columns + k] * factor;
            sums[r * columns + k] = *below;
        }
    }
}
