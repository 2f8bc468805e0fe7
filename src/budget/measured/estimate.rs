//! Standard errors of everything that follows from velocities with noise and drift.
//!
//! The measurement is repeated: noise of the deviation found, and offsets and slopes as uncertain as
//! they are, are added anew to the velocities, and everything is computed again. The root mean
//! square by which the repetitions differ from the estimate is its standard error, raised by the
//! relative error of so few. Nothing is linearised, so a contact about to close (where the force
//! has no slope), sums of correlated errors and the bias that noise gives to energies are in it.
//! To that is added, as squares, a third of what half of the samples give another result by.
//!
//! Source: B. Efron, R. J. Tibshirani, *An Introduction to the Bootstrap* (1993), chapter 6
//! (the parametric bootstrap).

use ndarray::{Array1, Array2, Zip};
use rayon::prelude::*;

use super::MeasuredOptions;
use super::derive::{self, Derived, envelope};
use super::momentum::{Fit, Fits, Fitter};
use super::noise::Channels;
use super::random::Random;
use crate::budget::contacts::Contacts;
use crate::chain::Chain;

/// Repetitions that are computed before they are added up in order.
const BATCH: usize = 4;

/// Repetitions that weights are found from.
const FEW: usize = 8;

/// Share of the difference of two samplings that is the error of the finer one, at an error of
/// second order.
const HALVED: f64 = 1.0 / 3.0;

/// Standard errors of what follows from velocities.
#[derive(Debug, Clone)]
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
    fn zeros(like: &Derived) -> Errors {
        Errors {
            velocity: Array2::zeros(like.velocity.dim()),
            overlap: Array2::zeros(like.overlap.dim()),
            force: Array2::zeros(like.force.dim()),
            flux: Array2::zeros(like.flux.dim()),
            passed: Array2::zeros(like.passed.dim()),
            energy: Array2::zeros(like.energy.dim()),
            unbalanced: Array2::zeros(like.unbalanced.dim()),
        }
    }

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

/// What noise and drift leave open.
pub(super) struct Repeated<'a> {
    pub(super) chain: &'a Chain,
    pub(super) dt: f64,
    pub(super) channels: &'a Channels,
    pub(super) missing: &'a [bool],
    pub(super) options: &'a MeasuredOptions,
    pub(super) derived: &'a Derived,
}

impl Repeated<'_> {
    /// One more measurement of the same motion.
    fn again(&self, number: usize) -> Derived {
        let samples = self.derived.velocity.nrows();
        let mut velocity = self.derived.velocity.clone();
        let root = self.channels.correlation.sqrt();
        for (j, site) in self.channels.sites.iter().enumerate() {
            // Each channel of each repetition has numbers of its own.
            let stream = (number as u64) << 32 | j as u64;
            let mut random =
                Random::new(self.options.seed ^ stream.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            if self.missing[j] {
                velocity.column_mut(j).fill(0.0);
                continue;
            }
            let (first, second) = (random.normal(), random.normal());
            let offset = site.offset_error * first;
            let along = if site.offset_error > 0.0 {
                site.covariance / site.offset_error
            } else {
                0.0
            };
            let rest = (site.slope_error.powi(2) - along * along).max(0.0).sqrt();
            let slope = along * first + rest * second;
            let still = site.rest_samples.saturating_sub(self.options.start);
            let deviation = root * site.deviation;
            for (i, v) in velocity
                .column_mut(j)
                .iter_mut()
                .enumerate()
                .take(samples)
                .skip(still)
            {
                *v += offset + slope * i as f64 + deviation * random.normal();
            }
        }
        Derived::of(self.chain, self.dt, velocity, self.missing)
    }

    /// Errors of arrays, and the factors of coefficients in every repetition.
    pub(super) fn errors(&self) -> (Errors, Fits) {
        let count = self.options.repetitions;
        let (chain, derived) = (self.chain, self.derived);
        let half = Derived::halved(chain, self.dt, &self.without_missing(), self.missing);
        let time = Array1::zeros(derived.velocity.nrows());
        let motion = derive::motion(chain, time.view(), &derived.displacement, &derived.velocity);
        let contacts = Contacts::of(&motion);
        let fitter = Fitter::new(&contacts, &self.open(&half));
        let mut errors = Errors::zeros(self.derived);
        let mut fits = Vec::with_capacity(count);
        for first in (0..count).step_by(BATCH) {
            let batch: Vec<(Derived, Fit)> = (first..(first + BATCH).min(count))
                .into_par_iter()
                .map(|number| {
                    let again = self.again(number);
                    let fit = fitter.fit(&again, 1);
                    (again, fit)
                })
                .collect();
            for (again, fit) in batch {
                fits.push(fit);
                let pairs = each(&again).into_iter().zip(each(self.derived));
                for (sum, (again, here)) in errors.each().into_iter().zip(pairs) {
                    Zip::from(sum)
                        .and(again)
                        .and(here)
                        .for_each(|sum, a, b| *sum += (a - b).powi(2));
                }
            }
        }
        let raised = raised(count);
        for sum in errors.each() {
            sum.mapv_inplace(|squares| raised * (squares / count as f64).sqrt());
        }
        self.add_sampling(&half, &contacts, &mut errors);
        let fits = Fits {
            here: fitter.fit(derived, 1),
            halved: fitter.fit(&half, 2),
            repeated: fits,
        };
        (errors, fits)
    }

    /// Variance of the momentum that is left open, from a few repetitions.
    fn open(&self, half: &Derived) -> Array2<f64> {
        let found: Vec<Array2<f64>> = (0..FEW)
            .into_par_iter()
            .map(|number| {
                (self.again(number).unbalanced - &self.derived.unbalanced).mapv(|x| x * x)
            })
            .collect();
        let mut open = envelope(&self.derived.unbalanced, &half.unbalanced, HALVED);
        open.mapv_inplace(|off| off * off);
        for squares in found {
            open.scaled_add((FEW as f64).recip(), &squares);
        }
        open
    }

    fn add_sampling(&self, half: &Derived, contacts: &Contacts, errors: &mut Errors) {
        let (chain, derived) = (self.chain, self.derived);
        let off = |full: &Array2<f64>, half: &Array2<f64>| envelope(full, half, HALVED);
        let overlap = off(&derived.overlap, &half.overlap);
        let add = |to: &mut Array2<f64>, what: &Array2<f64>| {
            Zip::from(to)
                .and(what)
                .for_each(|to, what| *to = to.hypot(*what));
        };
        for ((i, j), sampling) in overlap.indexed_iter() {
            let (id, r) = (j + contacts.offset, derived.overlap[[i, j]]);
            let here = contacts.force(id, r);
            let over = |e: f64| {
                let up = (contacts.force(id, r + e) - here).abs();
                up.max((contacts.force(id, r - e) - here).abs())
            };
            // Three errors of the overlap are to be within three of the force, also where an open
            // contact may be closed, which few repetitions tell.
            let open = over(3.0 * errors.overlap[[i, j]]) / 3.0;
            let speed = derived.speed(chain, i, j).abs();
            let (force, sampling) = (errors.force[[i, j]].max(open), over(*sampling));
            errors.force[[i, j]] = force.hypot(sampling);
            let flux = errors.flux[[i, j]].max(open * speed);
            errors.flux[[i, j]] = flux.hypot(sampling * speed);
        }
        add(&mut errors.overlap, &overlap);
        add(&mut errors.passed, &off(&derived.passed, &half.passed));
        add(&mut errors.energy, &off(&derived.energy, &half.energy));
        add(
            &mut errors.unbalanced,
            &off(&derived.unbalanced, &half.unbalanced),
        );
        let velocity = off(&derived.velocity, &half.velocity);
        // Only those of missing sites depend on the sampling.
        add(&mut errors.velocity, &velocity);
    }

    fn without_missing(&self) -> Array2<f64> {
        let mut velocity = self.derived.velocity.clone();
        for (j, _) in self
            .missing
            .iter()
            .enumerate()
            .filter(|(_, missing)| **missing)
        {
            velocity.column_mut(j).fill(0.0);
        }
        velocity
    }
}

/// `1 + 1 / sqrt(2 K)`: by what K repetitions may find too little.
pub(super) fn raised(count: usize) -> f64 {
    1.0 + (2.0 * count as f64).sqrt().recip()
}
