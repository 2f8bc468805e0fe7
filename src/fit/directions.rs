//! Combinations of unknowns that records say nothing about.

use ndarray::Array2;
use num_complex::Complex;
use serde::Serialize;

use super::solver::{cholesky, dot};
use crate::numeric::hermitian::eigen;
use crate::sheet::{listed, number};

/// Eigenvalues of the scaled information below this share of the largest are errors of derivatives.
const NOTHING: f64 = 1e-9;

/// Standard error of a direction, in units of the coordinates (a factor e of a positive key), from which on the records
/// tell nothing of it.
const LOOSE: f64 = 1.0;

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

/// The name of a coordinate, and its unit in values of what it is of; `None` for a logarithm.
pub(super) struct Coordinate {
    pub name: String,
    pub linear: Option<f64>,
}

fn symmetric(matrix: &[Vec<f64>]) -> Array2<Complex<f64>> {
    let n = matrix.len();
    Array2::from_shape_fn((n, n), |(i, j)| {
        Complex::from(0.5 * (matrix[i][j] + matrix[j][i]))
    })
}

/// Eigenvalues, descending, and unit eigenvectors of a symmetric matrix.
fn eigen_of(matrix: &[Vec<f64>]) -> Vec<(f64, Vec<f64>)> {
    let found = eigen(&symmetric(matrix));
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
    let none = all
        .into_iter()
        .filter(|(value, _)| *value <= NOTHING * largest);
    none.map(|(_, vector)| vector).collect()
}

/// Cholesky's factor of an information scaled by sizes, which is made one of what it says nothing of, and the unit vectors
/// of that in coordinates without the sizes.
pub(super) fn factored(mut scaled: Vec<Vec<f64>>, sizes: &[f64]) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let none = null_space(&scaled);
    for vector in &none {
        for (row, v) in scaled.iter_mut().zip(vector) {
            row.iter_mut()
                .zip(vector)
                .for_each(|(entry, w)| *entry += v * w);
        }
    }
    let unit = |k: usize| {
        (0..sizes.len())
            .map(|i| f64::from(u8::from(i == k)))
            .collect()
    };
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
    all.filter(|(value, _)| *value > LOOSE * LOOSE)
        .map(|(_, vector)| vector)
        .collect()
}

impl Direction {
    /// Along a change of all coordinates.
    pub(super) fn of(change: &[f64], coordinates: &[Coordinate]) -> Direction {
        let largest = change.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        let parts: Vec<usize> = (0..change.len())
            .filter(|k| change[*k].abs() > PART * largest)
            .collect();
        let names: Vec<String> = parts.iter().map(|k| coordinates[*k].name.clone()).collect();
        let words = match parts[..] {
            [one] => format!("nothing of {}", coordinates[one].name),
            [a, b] => pair([a, b].map(|k| (&coordinates[k], change[k]))),
            _ => format!(
                "{} only in {} combinations",
                listed(&names),
                parts.len() - 1
            ),
        };
        Direction {
            names,
            change: parts.iter().map(|k| change[*k]).collect(),
            words,
        }
    }
}

/// What stays of two unknowns that change together.
fn pair([(a, da), (b, db)]: [(&Coordinate, f64); 2]) -> String {
    let both = format!("{} and {}", a.name, b.name);
    let is =
        |ratio: f64| a.linear.is_none() && b.linear.is_none() && (db / da + ratio).abs() < 0.01;
    if is(1.0) {
        return format!("{both} only as {} {}", a.name, b.name);
    }
    if is(-1.0) {
        return format!("{both} only as {}/{}", a.name, b.name);
    }
    // w . d = 0 with the larger weight 1.
    let ((a, wa), (b, _)) = match db.abs() <= da.abs() {
        true => ((a, -db / da), (b, 1.0)),
        false => ((b, -da / db), (a, 1.0)),
    };
    let digits = |x: f64| number((100.0 * x).round() / 100.0);
    let trimmed = |x: f64| {
        digits(x)
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned()
    };
    match (a.linear, b.linear) {
        (None, None) => format!("{both} only as {}^{} {}", a.name, trimmed(wa), b.name),
        (Some(sa), Some(sb)) => format!(
            "{both} only as {} {} + {}",
            number(wa * sb / sa),
            a.name,
            b.name
        ),
        _ => format!("{both} only together"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(names: &[&str]) -> Vec<Coordinate> {
        let of = |name: &&str| Coordinate {
            name: (*name).into(),
            linear: None,
        };
        names.iter().map(of).collect()
    }

    /// Of y = a^0.4 b x the information is that of (0.4, 1); of (1, 1, 1) two directions are free.
    #[test]
    fn val_closed_form_products() {
        let information = vec![vec![0.16, 0.4], vec![0.4, 1.0]];
        let found = null_space(&information);
        assert_eq!(found.len(), 1);
        let direction = Direction::of(&found[0], &named(&["a", "b"]));
        assert_eq!(direction.words, "a and b only as a^0.4 b");
        assert!((direction.change[0] / direction.change[1] + 2.5).abs() < 1e-9);
        assert_eq!(null_space(&vec![vec![1.0; 3]; 3]).len(), 2);
    }
}
