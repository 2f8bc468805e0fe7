//! Budgets of a measured motion, with the standard errors of all their numbers.
//!
//! Every budget is made anew from every repetition of the measurement (see [`super::estimate`]), with
//! the band edges, scales and pairs of contacts of the first. The root mean square by which a number
//! differs from that of the measurement is its standard error; the bias that noise gives to squares
//! is in it. To that is added, as squares, what a third of the displacements' error by sampling
//! changes it by: the largest within a few hundredths of the record, or from the highest frequency
//! down, since a difference that changes sign is no smaller error there.

use std::ops::Range;

use ndarray::{Array2, Axis};

use super::derive::{Derived, HALVED};
use super::estimate::{add_squares, finish_squares, raised};
use super::{MeasuredMotion, derive};
use crate::arrays::{Arrays, Collect, LargeArray, Sink};
use crate::budget::frequency::usual_pairs;
use crate::budget::{Budget, BudgetRequest, Curves, Integration, run_beside};
use crate::chain::Chain;
use crate::error::{Error, Result};
use crate::numeric::pieces;
use crate::observer::{Observer, Silent};
use crate::system::memory::available_memory;

/// Copies of the curves: repetitions computed together, the sums, and the reference.
const HELD: u64 = 7;

impl MeasuredMotion {
    /// The budgets with the standard errors of their curves; the arrays over time go to `sink`
    /// block by block, and their standard errors are returned. Energies are relative to the energy
    /// put into the chain.
    ///
    /// # Errors
    /// As [`crate::budget::run`]; [`Error::Request`] for an integration along steps, since a
    /// measurement has none; [`Error::Memory`].
    pub fn run(
        &self,
        request: &BudgetRequest,
        sink: &dyn Sink,
        observer: &dyn Observer,
    ) -> Result<(Budget, Arrays)> {
        let of_samples = request.integration == Integration::Samples;
        let expected = "that of samples: nothing was stepped";
        let found = "that inside the stepping";
        Error::require(of_samples, "integration", expected, found)?;
        let mut budget = crate::budget::run(&self.motion(), request, sink, observer)?;
        let request = pinned(request, &budget);
        let (mut curves, arrays) = crate::system::threads::in_pool(request.threads, || {
            self.errors_of(&request, observer)
        })?;
        self.add_known(&budget, &mut curves);
        let given = self.report.energy;
        if let Some(found) = &mut budget.wavenumber
            && let Some(passed) = found.passed_edge()
        {
            let bin = found.passed_bin().unwrap_or(0);
            let relative = given.error / given.value;
            found.passed_error = curves["integrated_flux"][bin].hypot(passed * relative);
        }
        budget.scale = given.value;
        budget.errors = Some(curves);
        Ok((budget, arrays))
    }

    /// The same with the arrays in memory: budget, arrays, and their standard errors.
    ///
    /// # Errors
    /// As [`MeasuredMotion::run`].
    pub fn budget(&self, request: &BudgetRequest) -> Result<(Budget, Arrays, Arrays)> {
        let collect = Collect::default();
        let (budget, errors) = self.run(request, &collect, &Silent)?;
        Ok((budget, collect.into_arrays(), errors))
    }

    fn errors_of(
        &self,
        request: &BudgetRequest,
        observer: &dyn Observer,
    ) -> Result<(Curves, Arrays)> {
        let (measurement, velocity) = (&self.measurement, &self.values.velocity);
        let (chain, dt, missing) = (&measurement.chain, measurement.dt, &measurement.missing);
        let made = |varied: &Chain, displacement: &Array2<f64>, velocity: &Array2<f64>| {
            let motion = derive::motion(varied, self.time.view(), displacement, velocity);
            let collect = Collect::default();
            let budget = run_beside(&motion, chain, request, &collect, &Silent)?;
            let mut arrays = collect.into_arrays();
            // [`MeasuredMotion::errors`] has these.
            for known in [LargeArray::ENERGY_FLUX, LargeArray::ENERGY_PASSED] {
                arrays.remove(&known);
            }
            Ok::<_, Error>((budget.curves(), arrays))
        };
        let (here, arrays) = made(chain, &self.displacement, velocity)?;
        let values: usize = arrays.values().map(Array2::len).sum();
        let needed = (values as u64).saturating_mul(8 * HELD);
        let what = "the budgets of repeated measurements";
        Error::beyond_memory(what, needed, available_memory())?;
        let zeros = arrays.iter();
        let zeros = zeros.map(|(name, array)| (*name, Array2::zeros(array.dim())));
        let mut squares: Arrays = zeros.collect();
        let mut curves = here.clone();
        for sums in curves.values_mut() {
            sums.fill(0.0);
        }
        let count = measurement.options.repetitions;
        observer.stage("errors", count as u64);
        let again = |number| {
            observer.go_on()?;
            let (varied, velocity) = measurement.again(velocity, number);
            let (displacement, velocity) = Derived::moved(&varied, dt, velocity, missing);
            made(&varied, &displacement, &velocity)
        };
        measurement.each(again, |found| {
            let (again, found) = found?;
            for (name, sum) in &mut squares {
                add_squares(sum, &found[name], &arrays[name]);
            }
            combine(&mut curves, [&again, &here], |sum, again, here| {
                sum + (again - here).powi(2)
            });
            observer.advance(1);
            Ok::<(), Error>(())
        })?;
        let half = measurement.every_other_sample(velocity);
        let half = Derived::moved(chain, 2.0 * dt, half, missing);
        let [displacement, velocity] = [(&self.displacement, half.0), (velocity, half.1)]
            .map(|(full, half)| shifted(full, &half));
        let (sampled, sampled_arrays) = made(chain, &displacement, &velocity)?;
        for (name, sum) in &mut squares {
            finish_squares(sum, count);
            add_sampling(*name, sum, &sampled_arrays[name], &arrays[name]);
        }
        let raised = raised(count);
        combine(&mut curves, [&sampled, &here], |squares, sampled, here| {
            (raised * (squares / count as f64).sqrt()).hypot(sampled - here)
        });
        Ok((curves, squares))
    }

    /// Errors that are known otherwise: of energies and of what passed, no less than [`MeasuredMotion::errors`]
    /// has them; of losses, what another rule of quadrature finds.
    fn add_known(&self, budget: &Budget, curves: &mut Curves) {
        let last = budget.time.len() - 1;
        let off = budget.lost[last] - self.lost;
        for (name, errors) in curves {
            for (i, error) in errors.iter_mut().enumerate() {
                *error = match *name {
                    "total_energy" => error.max(self.errors.energy[[i, 0]]),
                    "passed" => error.max(self.errors.passed[[last, i]]),
                    "lost_energy" => error.hypot(off * i as f64 / last as f64),
                    "integrated_flux" | "late_flux" => error.hypot(off),
                    _ => *error,
                };
            }
        }
    }
}

/// Puts `of` this value and those of two others in place of each value.
fn combine(curves: &mut Curves, [a, b]: [&Curves; 2], of: impl Fn(f64, f64, f64) -> f64) {
    for (name, values) in curves {
        for (value, (a, b)) in values.iter_mut().zip(a[name].iter().zip(&b[name])) {
            *value = of(*value, *a, *b);
        }
    }
}

/// The request with what the first budget settled.
fn pinned(request: &BudgetRequest, budget: &Budget) -> BudgetRequest {
    let mut pinned = request.clone();
    if let Some(found) = &budget.wavenumber {
        pinned.band_edge_wavenumber = Some(found.edge).filter(|edge| edge.is_finite());
    }
    if let Some(flow) = &budget.frequency {
        pinned.band_edge_frequency = Some(flow.edge).filter(|edge| edge.is_finite());
        pinned.between = usual_pairs(budget);
        pinned.between.extend(&request.between);
    }
    match &budget.scales {
        Some(found) => {
            pinned.scales = found.scales.iter().map(|of| of.scale).collect();
            pinned.map_scale = Some(found.map_scale);
        }
        None => pinned.views.scale = false,
    }
    pinned
}

/// `full` and a third of what `half`, from every other sample, differs by; linear between these.
fn shifted(full: &Array2<f64>, half: &Array2<f64>) -> Array2<f64> {
    let last = half.nrows() - 1;
    let off = |i: usize, j: usize| HALVED * (half[[i, j]] - full[[2 * i, j]]);
    Array2::from_shape_fn(full.dim(), |(i, j)| {
        let (before, after) = (i / 2, i.div_ceil(2).min(last));
        full[[i, j]] + 0.5 * (off(before, j) + off(after, j))
    })
}

/// Parts of the record; differences due to sampling are averaged over three of them.
const PARTS: usize = 64;

/// Adds the largest difference nearby in time, or from the highest frequency down, as squares.
fn add_sampling(
    name: LargeArray,
    errors: &mut Array2<f64>,
    sampled: &Array2<f64>,
    here: &Array2<f64>,
) {
    let rows = errors.nrows();
    let part = rows.div_ceil(PARTS);
    for (j, mut column) in errors.axis_iter_mut(Axis(1)).enumerate() {
        let off = |i: usize| (sampled[[i, j]] - here[[i, j]]).abs();
        if name.axes()[0] == "frequency" {
            let mut most: f64 = 0.0;
            for i in (0..rows).rev() {
                most = most.max(off(i));
                column[i] = column[i].hypot(most);
            }
            continue;
        }
        let largest = |part: Range<usize>| part.map(off).fold(0.0, f64::max);
        let most: Vec<f64> = pieces(rows, part).map(largest).collect();
        for (i, error) in column.iter_mut().enumerate() {
            let nearby = (i / part).saturating_sub(1)..(i / part + 2).min(most.len());
            *error = error.hypot(most[nearby].iter().copied().fold(0.0, f64::max));
        }
    }
}
