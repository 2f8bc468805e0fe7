//! Combinations of unknowns that records say nothing about.

use ndarray::Array2;
use num_complex::Complex;
use serde::Serialize;

use super::result::Unknown;
use super::solver::{cholesky, dot};
use crate::numeric::hermitian::eigen;
use crate::sheet::{listed, number};

/// Eigenvalues of the scaled information below this share of the largest are errors of derivatives.
const NOTHING: f64 = 1e-9;

/// Standard error of a direction, in units of the coordinates (a factor e of a positive key), from which on the records
/// tell nothing of it.
pub(super) const LOOSE: f64 = 1.0;

/// Share of a direction from which on a coordinate belongs to it.
const PART: f64 = 0.05;

/// A direction along which unknowns can change while the records do not.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Direction {
    /// Names of the unknowns that change.
    pub names: Vec<String>,
    /// By how much each changes, in the logarithm of positive keys.
    pub change: Vec<f64>,
    /// What is known of them, in words.
    pub words: String,
}

/// Eigenvalues, descending, and unit eigenvectors of a symmetric matrix.
fn eigen_of(matrix: &[Vec<f64>]) -> Vec<(f64, Vec<f64>)> {
    let half = |(i, j): (usize, usize)| Complex::from(0.5 * (matrix[i][j] + matrix[j][i]));
    let found = eigen(&Array2::from_shape_fn((matrix.len(), matrix.len()), half));
    let vectors = found.vectors.iter().map(|vector| {
        // A real eigenvector up to a phase.
        let largest = vector.iter().max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let phase = largest.map_or(Complex::from(1.0), |z| {
            z.conj() / z.norm().max(f64::MIN_POSITIVE)
        });
        vector.iter().map(|z| (z * phase).re).collect()
    });
    found.values.iter().copied().zip(vectors).collect()
}

/// The unit vectors of a scaled information matrix that it says nothing of.
fn null_space(information: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let all = eigen_of(information);
    let largest = all.first().map_or(0.0, |(value, _)| *value);
    let none = all.into_iter();
    let none = none.filter(|(value, _)| *value <= NOTHING * largest);
    none.map(|(_, vector)| vector).collect()
}

/// Cholesky's factor of an information scaled by sizes, which is made one of what it says nothing of, and the unit vectors
/// of that in coordinates without the sizes.
pub(super) fn factored(mut scaled: Vec<Vec<f64>>, sizes: &[f64]) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let none = null_space(&scaled);
    for vector in &none {
        for (row, v) in scaled.iter_mut().zip(vector) {
            let cells = row.iter_mut().zip(vector);
            cells.for_each(|(cell, w)| *cell += v * w);
        }
    }
    let unit = |k: usize| (0..sizes.len()).map(|i| f64::from(i == k)).collect();
    let lower = cholesky(&scaled).unwrap_or_else(|| (0..sizes.len()).map(unit).collect());
    let unscaled = |vector: &Vec<f64>| {
        let change: Vec<f64> = vector.iter().zip(sizes).map(|(v, size)| v / size).collect();
        let length = dot(&change, &change).sqrt();
        change.iter().map(|v| v / length).collect()
    };
    let none = none.iter().map(unscaled).collect();
    (lower, none)
}

/// The directions of a covariance in which almost anything goes.
pub(super) fn loose(covariance: &[Vec<f64>]) -> Vec<Vec<f64>> {
    // The method is for positive values of one size: variances of 1 are what counts.
    let all = eigen_of(covariance).into_iter();
    let loose = all.filter(|(value, _)| *value > LOOSE * LOOSE);
    loose.map(|(_, vector)| vector).collect()
}

impl Direction {
    /// Along a change of all unknowns.
    pub(super) fn of(change: &[f64], unknowns: &[Unknown]) -> Direction {
        let largest = change.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        let parts: Vec<usize> = (0..change.len())
            .filter(|k| change[*k].abs() > PART * largest)
            .collect();
        let names: Vec<String> = parts.iter().map(|k| unknowns[*k].name()).collect();
        let words = match parts[..] {
            [_] => format!("nothing of {}", names[0]),
            [a, b] => {
                let both = [a, b].map(|k| (unknowns[k].linear(), change[k]));
                let words = pair(both, [&names[0], &names[1]]);
                format!("{} only {words}", listed(&names))
            }
            _ => {
                let count = parts.len() - 1;
                format!("{} only in {count} combinations", listed(&names))
            }
        };
        Direction {
            names,
            change: parts.iter().map(|k| change[*k]).collect(),
            words,
        }
    }
}

/// What stays of two unknowns that change together.
fn pair([(of_a, da), (of_b, db)]: [(Option<f64>, f64); 2], [a, b]: [&str; 2]) -> String {
    let ratio = db / da;
    // w . d = 0 with the larger weight 1.
    let (first, weight, second) = match db.abs() <= da.abs() {
        true => (a, -db / da, b),
        false => (b, -da / db, a),
    };
    match (of_a, of_b) {
        (None, None) if (ratio + 1.0).abs() < 0.01 => format!("as {a} {b}"),
        (None, None) if (ratio - 1.0).abs() < 0.01 => format!("as {a}/{b}"),
        (None, None) => {
            let digits = number((100.0 * weight).round() / 100.0);
            let power = digits.trim_end_matches('0').trim_end_matches('.');
            format!("as {first}^{power} {second}")
        }
        (Some(of_a), Some(of_b)) => {
            let is_first = first == a;
            let (own, other) = if is_first { (of_a, of_b) } else { (of_b, of_a) };
            format!("as {} {first} + {second}", number(weight * other / own))
        }
        _ => "together".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of y = a^0.4 b x the information is that of (0.4, 1); of (1, 1, 1) two directions are free.
    #[test]
    fn val_closed_form_products() {
        let information = vec![vec![0.16, 0.4], vec![0.4, 1.0]];
        let found = null_space(&information);
        assert_eq!(found.len(), 1);
        let direction = Direction::of(&found[0], &[Unknown::Gain(3), Unknown::Gain(5)]);
        assert_eq!(
            direction.words,
            "gain[3] and gain[5] only as gain[3]^0.4 gain[5]"
        );
        assert!((direction.change[0] / direction.change[1] + 2.5).abs() < 1e-9);
        assert_eq!(null_space(&vec![vec![1.0; 3]; 3]).len(), 2);
    }
}
