//! What information says of keys: errors, a score, and what stays undetermined.

use ndarray::Array2;

use super::super::directions::{Direction, factored, loose};
use super::super::key::FreeKey;
use super::super::model::Model;
use super::super::result::coordinates;
use super::super::solver::{cholesky, solved};
use super::information::Matrix;
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
    pub fn new((keys, criterion): (&'a [FreeKey], Criterion), each: &[Matrix]) -> Judge<'a> {
        let all: Vec<usize> = (0..each.len()).collect();
        let total = Matrix::sum(each, &all);
        let steepness = |key: &FreeKey| {
            let (value, step) = (key.value_at(0.0), 1e-6);
            let slope = (key.value_at(step) - key.value_at(-step)).abs() / (2.0 * step);
            // At a bound one side is cut.
            let slope = slope.max((key.value_at(step) - value).abs() / step);
            if value == 0.0 {
                slope
            } else {
                slope / value.abs()
            }
        };
        let mut judge = Judge {
            keys,
            criterion,
            scale: total.roots(),
            steepness: keys.iter().map(steepness).collect(),
            known: vec![true; keys.len()],
        };
        judge.known = judge
            .errors(&total)
            .iter()
            .map(|error| error.is_finite())
            .collect();
        judge
    }

    /// Larger for better sensors; a direction that is not determined costs a lot, however many there are.
    pub fn score(&self, whole: &Matrix) -> f64 {
        let mut scaled = whole.scaled(&self.scale);
        scaled
            .iter_mut()
            .enumerate()
            .for_each(|(i, row)| row[i] += NOTHING);
        let Some(lower) = cholesky(&scaled) else {
            return f64::NEG_INFINITY;
        };
        let count = self.keys.len();
        match self.criterion {
            Criterion::Volume => {
                let volume: f64 = lower
                    .iter()
                    .enumerate()
                    .map(|(i, row)| 2.0 * row[i].ln())
                    .sum();
                // The volume of the keys, whatever the clock is.
                let beside = scaled.get(count).map_or(0.0, |row| row[count].ln());
                volume - beside
            }
            Criterion::Worst => {
                let error = |k: &usize| {
                    self.variance(&lower, *k).sqrt() / self.scale[*k] * self.steepness[*k]
                };
                let known = (0..count).filter(|k| self.known[*k]);
                -known.map(|k| error(&k)).fold(0.0, f64::max)
            }
        }
    }

    fn variance(&self, lower: &[Vec<f64>], k: usize) -> f64 {
        let mut unit = vec![0.0; lower.len()];
        unit[k] = 1.0;
        solved(lower, &unit)[k]
    }

    /// Halves of the 95 % intervals over the values; NaN for those that are not determined.
    pub fn errors(&self, whole: &Matrix) -> Vec<f64> {
        let (covariance, none) = covariance(whole);
        let error = |k: usize| match none.iter().any(|d| d[k].abs() > PART) {
            true => f64::NAN,
            false => QUANTILE * covariance[k][k].max(0.0).sqrt() * self.steepness[k],
        };
        (0..self.keys.len()).map(error).collect()
    }

    pub fn undetermined(&self, whole: &Matrix, model: &Model) -> Vec<Direction> {
        let (covariance, none) = covariance(whole);
        let coordinates = coordinates(model);
        let hardly = loose(&covariance);
        let all = none.iter().chain(&hardly);
        all.map(|d| Direction::of(d, &coordinates)).collect()
    }

    pub fn shares(&self, each: &[Matrix]) -> Array2<f64> {
        Array2::from_shape_fn((each.len(), self.keys.len()), |(body, k)| {
            each[body].at(k, k) / self.scale[k].powi(2)
        })
    }
}

/// The inverse of an information where it is one, and unit vectors of what it says nothing of.
fn covariance(whole: &Matrix) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let sizes = whole.roots();
    let (lower, none) = factored(whole.scaled(&sizes), &sizes);
    let row = |k: usize| {
        let mut unit = vec![0.0; sizes.len()];
        unit[k] = 1.0;
        let row = solved(&lower, &unit).into_iter().zip(&sizes);
        row.map(|(c, size)| c / (size * sizes[k])).collect()
    };
    ((0..sizes.len()).map(row).collect(), none)
}
