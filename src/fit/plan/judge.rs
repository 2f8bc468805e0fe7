//! What information says of keys: errors, a score, and what stays undetermined.

use ndarray::Array2;

use super::super::directions::{Direction, LOOSE, factored, loose};
use super::super::key::FreeKey;
use super::super::model::Model;
use super::super::result::unknowns;
use super::super::solver::{cholesky, solved};
use super::information::{roots, scaled, sum};
use super::{Criterion, NOTHING, PART, QUANTILE};

/// What information says of the keys.
pub(super) struct Judge<'a> {
    keys: &'a [FreeKey],
    criterion: Criterion,
    /// Root information of all bodies about each unknown, which makes scales alike.
    scale: Vec<f64>,
    /// By how much a value changes relative to itself with its coordinate.
    steepness: Vec<f64>,
    /// Keys that all bodies together determine.
    known: Vec<bool>,
}

impl<'a> Judge<'a> {
    pub fn new((keys, criterion): (&'a [FreeKey], Criterion), each: &[Array2<f64>]) -> Judge<'a> {
        let all: Vec<usize> = (0..each.len()).collect();
        let total = sum(each, &all);
        let steepness = |key: &FreeKey| {
            let (value, step) = (key.value_at(0.0), 1e-6);
            let slope = (key.value_at(step) - key.value_at(-step)).abs() / (2.0 * step);
            // At a bound one side is cut.
            let slope = slope.max((key.value_at(step) - value).abs() / step);
            match value {
                0.0 => slope,
                value => slope / value.abs(),
            }
        };
        let mut judge = Judge {
            keys,
            criterion,
            scale: roots(&total),
            steepness: keys.iter().map(steepness).collect(),
            known: vec![true; keys.len()],
        };
        let errors = judge.errors(&total).into_iter();
        judge.known = errors.map(f64::is_finite).collect();
        judge
    }

    /// Larger for better sensors; a direction that is not determined costs a lot, however many there are.
    pub fn score(&self, whole: &Array2<f64>) -> f64 {
        let mut scaled = scaled(whole, &self.scale);
        let rows = scaled.iter_mut().enumerate();
        rows.for_each(|(i, row)| row[i] += NOTHING);
        let Some(lower) = cholesky(&scaled) else {
            return f64::NEG_INFINITY;
        };
        let count = self.keys.len();
        match self.criterion {
            Criterion::Volume => {
                let roots = lower.iter().enumerate();
                let volume: f64 = roots.map(|(i, row)| 2.0 * row[i].ln()).sum();
                // The volume of the keys, whatever the clock is.
                let beside = scaled.get(count).map_or(0.0, |row| row[count].ln());
                volume - beside
            }
            Criterion::Worst => {
                let error =
                    |k: usize| inverse(&lower, k)[k].sqrt() / self.scale[k] * self.steepness[k];
                let known = (0..count).filter(|k| self.known[*k]);
                -known.map(error).fold(0.0, f64::max)
            }
        }
    }

    /// Halves of the 95 % intervals over the values; NaN for those that are not determined, or to no better than a factor
    /// of e.
    pub fn errors(&self, whole: &Array2<f64>) -> Vec<f64> {
        let (covariance, none) = covariance(whole);
        let error = |k: usize| {
            let half = QUANTILE * covariance[k][k].max(0.0).sqrt();
            match half > LOOSE || none.iter().any(|d| d[k].abs() > PART) {
                true => f64::NAN,
                false => half * self.steepness[k],
            }
        };
        (0..self.keys.len()).map(error).collect()
    }

    pub fn undetermined(&self, whole: &Array2<f64>, model: &Model) -> Vec<Direction> {
        let (covariance, none) = covariance(whole);
        let unknowns = unknowns(model);
        let hardly = loose(&covariance);
        let all = none.iter().chain(&hardly);
        all.map(|d| Direction::of(d, &unknowns)).collect()
    }

    pub fn shares(&self, each: &[Array2<f64>]) -> Array2<f64> {
        Array2::from_shape_fn((each.len(), self.keys.len()), |(body, k)| {
            each[body][[k, k]] / self.scale[k].powi(2)
        })
    }
}

/// A row of the inverse.
fn inverse(lower: &[Vec<f64>], k: usize) -> Vec<f64> {
    let mut unit = vec![0.0; lower.len()];
    unit[k] = 1.0;
    solved(lower, &unit)
}

/// The inverse of an information where it is one, and unit vectors of what it says nothing of.
fn covariance(whole: &Array2<f64>) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let sizes = roots(whole);
    let (lower, none) = factored(scaled(whole, &sizes), &sizes);
    let row = |k: usize| {
        let row = inverse(&lower, k).into_iter().zip(&sizes);
        row.map(|(c, size)| c / (size * sizes[k])).collect()
    };
    ((0..sizes.len()).map(row).collect(), none)
}
