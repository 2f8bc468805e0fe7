//! The measurement repeated: the same motion with other noise, drift and gains, and a chain as it
//! may as well be.

use ndarray::{Array2, ArrayViewMut1, Axis, s};
use rayon::prelude::*;

use super::MeasuredOptions;
use super::noise::Channels;
use crate::chain::{Chain, Ends};
use crate::numeric::{Random, pieces};

/// Repetitions that are computed before they are added up in order.
const BATCH: usize = 4;

/// The purposes of normal numbers; each has its own random streams.
#[derive(Debug, Clone, Copy)]
enum Of {
    Channel,
    Gain,
    Coefficient,
    Mass,
}

/// A measurement that can be repeated.
#[derive(Debug, Clone)]
pub(super) struct Measurement {
    pub(super) chain: Chain,
    pub(super) dt: f64,
    pub(super) channels: Channels,
    pub(super) missing: Vec<bool>,
    pub(super) options: MeasuredOptions,
}

impl Measurement {
    /// The chain and the velocities of a repetition; columns of missing sites are zero.
    pub(super) fn again(&self, velocity: &Array2<f64>, number: usize) -> (Chain, Array2<f64>) {
        let mut velocity = self.without_missing(velocity.clone());
        let columns = velocity.axis_iter_mut(Axis(1)).enumerate();
        for (j, column) in columns.filter(|(j, _)| !self.missing[*j]) {
            let gain = self.factor(&self.options.uncertainty.gain, Of::Gain, number, j);
            self.spoil(number, j, gain, column);
        }
        (self.chain_again(number), velocity)
    }

    /// The velocities of every other sample; columns of missing sites are zero.
    pub(super) fn every_other_sample(&self, velocity: &Array2<f64>) -> Array2<f64> {
        self.without_missing(velocity.slice(s![..;2, ..]).to_owned())
    }

    fn without_missing(&self, mut velocity: Array2<f64>) -> Array2<f64> {
        let columns = velocity.columns_mut().into_iter().zip(&self.missing);
        for (mut column, _) in columns.filter(|(_, missing)| **missing) {
            column.fill(0.0);
        }
        velocity
    }

    /// Another gain, noise and drift of channel j from where it is not at rest.
    fn spoil(&self, number: usize, j: usize, gain: f64, mut column: ArrayViewMut1<f64>) {
        let site = &self.channels.sites[j];
        let mut random = self.stream(Of::Channel, number, j);
        let (first, second) = (random.normal(), random.normal());
        let offset = site.offset_error * first;
        let along = match site.offset_error > 0.0 {
            true => site.covariance / site.offset_error,
            false => 0.0,
        };
        let rest = (site.slope_error.powi(2) - along * along).max(0.0).sqrt();
        let slope = along * first + rest * second;
        let still = site.rest_samples.saturating_sub(self.options.start);
        let deviation = self.channels.correlation.sqrt() * site.deviation;
        for (i, v) in column.iter_mut().enumerate().skip(still) {
            *v = gain * *v + (offset + slope * i as f64 + deviation * random.normal());
        }
    }

    fn chain_again(&self, number: usize) -> Chain {
        let mut chain = self.chain.clone();
        let uncertainty = &self.options.uncertainty;
        for (j, mass) in chain.mass.iter_mut().enumerate() {
            *mass *= self.factor(&uncertainty.mass, Of::Mass, number, j);
        }
        let wall = match &mut chain.ends {
            Ends::Fixed { left_coefficient } => Some(left_coefficient),
            _ => None,
        };
        let coefficients = wall.into_iter().chain(&mut chain.coefficient);
        for (i, coefficient) in coefficients.enumerate() {
            *coefficient *= self.factor(&uncertainty.coefficient, Of::Coefficient, number, i);
        }
        chain
    }

    /// `exp(u z)` with the u that a list has for the i-th.
    fn factor(&self, list: &[f64], of: Of, number: usize, i: usize) -> f64 {
        let share = match list {
            [] => return 1.0,
            [all] => *all,
            each => each[i],
        };
        (share * self.stream(of, number, i).normal()).exp()
    }

    fn stream(&self, of: Of, number: usize, i: usize) -> Random {
        let stream = (of as u64) << 60 | (number as u64) << 32 | i as u64;
        Random::new(self.options.seed ^ stream.wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    /// Does `work` for every repetition and hands the results on in order, so that sums do not depend
    /// on threads. Ends early where `keep` yields an error.
    pub(super) fn each<T: Send, E>(
        &self,
        work: impl Fn(usize) -> T + Sync,
        mut keep: impl FnMut(T) -> Result<(), E>,
    ) -> Result<(), E> {
        let count = self.options.repetitions;
        pieces(count, BATCH).try_for_each(|batch| {
            let batch: Vec<T> = batch.into_par_iter().map(&work).collect();
            batch.into_iter().try_for_each(&mut keep)
        })
    }
}
