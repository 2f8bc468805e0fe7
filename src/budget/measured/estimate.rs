//! Standard errors of everything that follows from velocities with noise and drift.
//!
//! The measurement is repeated: noise of the deviation found, and offsets and slopes as uncertain as
//! they are, are added anew to the velocities, gains, coefficients and masses are drawn anew from
//! their stated uncertainties, and everything is computed again. The root mean
//! square by which the repetitions differ from the estimate is its standard error, raised by the
//! relative error of so few. Nothing is linearised, so a contact about to close (where the force
//! has no slope), sums of correlated errors and the bias that noise gives to energies are in it.
//! To that is added, as squares, a third of what half of the samples give another result by.
//!
//! Source: B. Efron, R. J. Tibshirani, *An Introduction to the Bootstrap* (1993), chapter 6
//! (the parametric bootstrap).
//!
//! The energy put into a chain, from a record with noise.
//!
//! Total energy plus losses, `H(t) = E(t) + int D dt`, is constant once the impact is over. Noise
//! makes it scatter, and raises it: energies are squares. A repetition raises it by as much again,
//! so that `H - <H_again - H>` is free of that to leading order. The estimate is its median over
//! the record, samples weighted by the inverse of their variance, but none above that of the median
//! variance: early samples, when little moves, are precise but carry little information. The
//! largest value over time would be biased by its noise. Its standard error is the scatter of the
//! same median over the repetitions, and a third of the change when only every second sample is
//! used.

use std::convert::Infallible;

use ndarray::{Array1, Array2, Zip};
use rayon::prelude::*;

use super::derive::{self, Derived, envelope};
use super::momentum::{Fits, Fitter};
use super::repetitions::Repetitions;
use super::report::Estimate;
use crate::budget::contacts::Contacts;

/// Repetitions that weights are found from.
const FEW: usize = 8;

/// Share of the difference of two samplings that is the error of the finer one, at an error of
/// second order.
pub(super) const HALVED: f64 = 1.0 / 3.0;

/// Standard errors of what follows from velocities.
#[derive(Debug, Clone, Default)]
pub struct Errors {
    /// Of velocities, `(time, site)`.
    pub velocity: Array2<f64>,
    /// Of overlaps, forces, fluxes and energies passed, `(time, contact)`.
    pub overlap: Array2<f64>,
    pub force: Array2<f64>,
    pub flux: Array2<f64>,
    pub passed: Array2<f64>,
    /// Of the total energy, `(time, 1)`.
    pub energy: Array2<f64>,
    /// Of the momentum that no force explains, `(time, site)`.
    pub(super) unbalanced: Array2<f64>,
}

impl Errors {
    fn each(&mut self) -> [&mut Array2<f64>; 7] {
        [
            &mut self.velocity,
            &mut self.overlap,
            &mut self.force,
            &mut self.flux,
            &mut self.passed,
            &mut self.energy,
            &mut self.unbalanced,
        ]
    }
}

fn each(derived: &Derived) -> [&Array2<f64>; 7] {
    [
        &derived.velocity,
        &derived.overlap,
        &derived.force,
        &derived.flux,
        &derived.passed,
        &derived.energy,
        &derived.unbalanced,
    ]
}

/// What noise, drift and uncertainties leave open.
pub(super) struct Repeated<'a> {
    pub(super) repetitions: &'a Repetitions<'a>,
    pub(super) derived: &'a Derived,
}

impl Repeated<'_> {
    /// One more measurement of the same motion.
    fn again(&self, number: usize) -> Derived {
        let Repetitions { dt, missing, .. } = *self.repetitions;
        let (chain, velocity) = self.repetitions.again(number);
        Derived::of(&chain, dt, velocity, missing)
    }

    /// Errors of arrays, the factors of coefficients in every repetition, and the energy given.
    pub(super) fn errors(&self) -> (Errors, Fits, Estimate) {
        let Repetitions {
            chain, dt, missing, ..
        } = *self.repetitions;
        let derived = self.derived;
        let half = self.repetitions.every_other_sample();
        let half = Derived::of(chain, 2.0 * dt, half, missing);
        let time = Array1::zeros(derived.velocity.nrows());
        let motion = derive::motion(chain, time.view(), &derived.displacement, &derived.velocity);
        let contacts = Contacts::of(&motion);
        let fitter = Fitter::new(&contacts, &self.open(&half));
        let mut errors = Errors::default();
        for (sum, like) in errors.each().into_iter().zip(each(derived)) {
            *sum = Array2::zeros(like.dim());
        }
        let (mut given, mut fits) = (Vec::new(), Vec::new());
        let again = |number| {
            let again = self.again(number);
            let fit = fitter.fit(&again, 1);
            (again, fit)
        };
        let Ok(()) = self.repetitions.each(again, |(again, fit)| {
            fits.push(fit);
            let pairs = each(&again).into_iter().zip(each(self.derived));
            for (sum, (again, here)) in errors.each().into_iter().zip(pairs) {
                add_squares(sum, again, here);
            }
            given.push(again.given);
            Ok::<(), Infallible>(())
        });
        for sum in errors.each() {
            finish_squares(sum, fits.len());
        }
        self.add_sampling(&half, &contacts, &mut errors);
        let given = energy_given(&derived.given, &half.given, &given);
        let fits = Fits {
            here: fitter.fit(derived, 1),
            halved: fitter.fit(&half, 2),
            repeated: fits,
        };
        (errors, fits, given)
    }

    /// Variance of the momentum that is left open, from a few repetitions.
    fn open(&self, half: &Derived) -> Array2<f64> {
        let here = &self.derived.unbalanced;
        let off = |number| (self.again(number).unbalanced - here).mapv(|x| x * x);
        let found: Vec<Array2<f64>> = (0..FEW).into_par_iter().map(off).collect();
        let mut open = envelope(here, &half.unbalanced, HALVED);
        open.mapv_inplace(|off| off * off);
        for squares in found {
            open.scaled_add((FEW as f64).recip(), &squares);
        }
        open
    }

    fn add_sampling(&self, half: &Derived, contacts: &Contacts, errors: &mut Errors) {
        let derived = self.derived;
        let off = |full: &Array2<f64>, half: &Array2<f64>| envelope(full, half, HALVED);
        let overlap = off(&derived.overlap, &half.overlap);
        let add = |to: &mut Array2<f64>, what: &Array2<f64>| {
            to.zip_mut_with(what, |to, what| *to = to.hypot(*what));
        };
        for ((i, j), sampling) in overlap.indexed_iter() {
            let (id, r) = (j + contacts.offset, derived.overlap[[i, j]]);
            let here = contacts.contact(id).force(r);
            let over = |e: f64| {
                let up = (contacts.contact(id).force(r + e) - here).abs();
                up.max((contacts.contact(id).force(r - e) - here).abs())
            };
            // Three errors of the overlap are to be within three of the force, also where an open
            // contact may be closed, which few repetitions show.
            let open = over(3.0 * errors.overlap[[i, j]]) / 3.0;
            let v = derived.velocity.row(i);
            let speed = match contacts.sites(id) {
                [Some(left), Some(right)] => 0.5 * (v[left] + v[right]).abs(),
                _ => 0.0,
            };
            let (force, sampling) = (errors.force[[i, j]].max(open), over(*sampling));
            errors.force[[i, j]] = force.hypot(sampling);
            let flux = errors.flux[[i, j]].max(open * speed);
            errors.flux[[i, j]] = flux.hypot(sampling * speed);
        }
        add(&mut errors.overlap, &overlap);
        add(&mut errors.passed, &off(&derived.passed, &half.passed));
        add(&mut errors.energy, &off(&derived.energy, &half.energy));
        let unbalanced = off(&derived.unbalanced, &half.unbalanced);
        add(&mut errors.unbalanced, &unbalanced);
        // Only those of missing sites depend on the sampling.
        add(
            &mut errors.velocity,
            &off(&derived.velocity, &half.velocity),
        );
    }
}

/// Adds the squares of what a repetition differs by.
pub(super) fn add_squares(sum: &mut Array2<f64>, again: &Array2<f64>, here: &Array2<f64>) {
    Zip::from(sum)
        .and(again)
        .and(here)
        .for_each(|sum, a, b| *sum += (a - b).powi(2));
}

/// Standard errors from sums of squares over `count` repetitions.
pub(super) fn finish_squares(sum: &mut Array2<f64>, count: usize) {
    let raised = raised(count);
    sum.mapv_inplace(|squares| raised * (squares / count as f64).sqrt());
}

/// `1 + 1 / sqrt(2 K)`: by what K repetitions may find too little.
pub(super) fn raised(count: usize) -> f64 {
    1.0 + (2.0 * count as f64).sqrt().recip()
}

/// `here`: total energy and losses of the measurement; `half`: from every other sample; `again`: of repetitions.
fn energy_given(here: &[f64], half: &[f64], again: &[Vec<f64>]) -> Estimate {
    let count = again.len() as f64;
    let over_repetitions = |i: usize, of: &dyn Fn(f64) -> f64| -> f64 {
        again.iter().map(|again| of(again[i]) / count).sum()
    };
    let all = 0..here.len();
    let mean: Vec<f64> = all.clone().map(|i| over_repetitions(i, &|x| x)).collect();
    let spread = |i: usize| over_repetitions(i, &|x| (x - mean[i]).powi(2));
    let variance: Vec<f64> = all.map(spread).collect();
    let floor = median(&variance, &vec![1.0; here.len()]);
    let weight = |v: &f64| {
        if floor > 0.0 {
            v.max(floor).recip()
        } else {
            1.0
        }
    };
    let weights: Vec<f64> = variance.iter().map(weight).collect();
    let pairs = here.iter().zip(&mean);
    let corrected: Vec<f64> = pairs.map(|(here, mean)| 2.0 * here - mean).collect();
    let value = median(&corrected, &weights);
    let squares = again.iter().map(|again| {
        let scattered = corrected.iter().zip(again).zip(&mean);
        let scattered: Vec<f64> = scattered.map(|((c, a), m)| c + a - m).collect();
        (median(&scattered, &weights) - value).powi(2)
    });
    let error = raised(again.len()) * (squares.sum::<f64>() / count).sqrt();
    let every_other = |values: &[f64]| -> Vec<f64> { values.iter().step_by(2).copied().collect() };
    let (weights, here) = (every_other(&weights), every_other(here));
    let sampling = HALVED * (median(&here, &weights) - median(half, &weights));
    Estimate {
        value,
        error: error.hypot(sampling),
    }
}

/// The weighted median.
fn median(values: &[f64], weights: &[f64]) -> f64 {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let half = 0.5 * weights.iter().sum::<f64>();
    let mut below = 0.0;
    let middle = order.into_iter().find(|i| {
        below += weights[*i];
        below >= half
    });
    middle.map_or(f64::NAN, |i| values[i])
}
