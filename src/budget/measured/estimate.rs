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

use super::derive::{self, Derived, HALVED, MotionArrays, envelope};
use super::momentum::{Fits, Fitter};
use super::repetitions::Measurement;
use super::report::Estimate;
use crate::budget::contacts::Contacts;

/// Repetitions that weights are found from.
const FEW: usize = 8;

impl Measurement {
    /// What follows from one more measurement of the same motion.
    fn derived_again(&self, derived: &Derived, number: usize) -> Derived {
        let (chain, velocity) = self.again(&derived.values.velocity, number);
        Derived::of(&chain, self.dt, velocity, &self.missing)
    }

    /// Errors of arrays, the factors of coefficients in every repetition, and the energy given.
    pub(super) fn errors(&self, derived: &Derived) -> (MotionArrays, Fits, Estimate) {
        let half = self.every_other_sample(&derived.values.velocity);
        let half = Derived::of(&self.chain, 2.0 * self.dt, half, &self.missing);
        let time = Array1::zeros(derived.displacement.nrows());
        let (x, v) = (&derived.displacement, &derived.values.velocity);
        let motion = derive::motion(&self.chain, time.view(), x, v);
        let contacts = Contacts::of(&motion);
        let fitter = Fitter::new(&contacts, &self.open(derived, &half));
        let mut errors = MotionArrays::default();
        errors.combine(&derived.values, &half.values, |sum, like, _| {
            *sum = Array2::zeros(like.dim());
        });
        let (mut given, mut fits) = (Vec::new(), Vec::new());
        let again = |number| {
            let again = self.derived_again(derived, number);
            let fit = fitter.fit(&again, 1);
            (again, fit)
        };
        let Ok(()) = self.each(again, |(again, fit)| {
            fits.push(fit);
            errors.combine(&again.values, &derived.values, add_squares);
            given.push(again.given);
            Ok::<(), Infallible>(())
        });
        errors.combine(&derived.values, &half.values, |sum, _, _| {
            finish_squares(sum, fits.len());
        });
        add_sampling([derived, &half], &contacts, &mut errors);
        let given = energy_given(&derived.given, &half.given, &given);
        let fits = Fits {
            here: fitter.fit(derived, 1),
            halved: fitter.fit(&half, 2),
            repeated: fits,
        };
        (errors, fits, given)
    }

    /// Variance of the momentum that is left open, from a few repetitions.
    fn open(&self, derived: &Derived, half: &Derived) -> Array2<f64> {
        let here = &derived.values.unbalanced;
        let again = |number| self.derived_again(derived, number).values.unbalanced;
        let off = |number| (again(number) - here).mapv(|x| x * x);
        let found: Vec<Array2<f64>> = (0..FEW).into_par_iter().map(off).collect();
        let mut open = envelope(here, &half.values.unbalanced);
        open.mapv_inplace(|off| off * off);
        for squares in found {
            open.scaled_add((FEW as f64).recip(), &squares);
        }
        open
    }
}

/// Adds what the sampling makes wrong; that of overlaps goes through the law into forces and fluxes.
fn add_sampling([derived, half]: [&Derived; 2], contacts: &Contacts, errors: &mut MotionArrays) {
    let values = &derived.values;
    let overlap = envelope(&values.overlap, &half.values.overlap);
    for ((i, j), sampling) in overlap.indexed_iter() {
        let (id, r) = (j + contacts.offset, values.overlap[[i, j]]);
        let here = contacts.each[id].force(r);
        let over = |e: f64| {
            let up = (contacts.each[id].force(r + e) - here).abs();
            up.max((contacts.each[id].force(r - e) - here).abs())
        };
        // Three errors of the overlap are to be within three of the force, also where an open
        // contact may be closed, which few repetitions show.
        let open = over(3.0 * errors.overlap[[i, j]]) / 3.0;
        let v = values.velocity.row(i);
        let speed = match contacts.each[id].sites {
            [Some(left), Some(right)] => 0.5 * (v[left] + v[right]).abs(),
            _ => 0.0,
        };
        let sampling = over(*sampling);
        let (force, flux) = (&mut errors.force[[i, j]], &mut errors.flux[[i, j]]);
        *force = force.max(open).hypot(sampling);
        *flux = flux.max(open * speed).hypot(sampling * speed);
    }
    let (half, of) = (&half.values, envelope);
    for (error, off) in [
        (&mut errors.overlap, overlap),
        (&mut errors.passed, of(&values.passed, &half.passed)),
        (&mut errors.energy, of(&values.energy, &half.energy)),
        (
            &mut errors.unbalanced,
            of(&values.unbalanced, &half.unbalanced),
        ),
        // Only those of missing sites depend on the sampling.
        (&mut errors.velocity, of(&values.velocity, &half.velocity)),
    ] {
        error.zip_mut_with(&off, |error, off| *error = error.hypot(*off));
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
    let weight = |v: &f64| match floor > 0.0 {
        true => v.max(floor).recip(),
        false => 1.0,
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
