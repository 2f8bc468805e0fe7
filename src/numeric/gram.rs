//! Complex least squares by normal equations, which blocks of realisations are added to.

use num_complex::Complex;

/// `G_ij = sum_r conj(a_i) a_j` of the columns of a regression, the last of which is the output: the lower
/// triangle, row by row.
#[derive(Debug, Clone)]
pub(crate) struct Gram {
    /// Columns, that of the output included.
    columns: usize,
    values: Vec<Complex<f64>>,
}

/// Part of a column that the others leave, in squares, below which it is not told apart from them.
const LEAST_PIVOT: f64 = 1e-10;

impl Gram {
    pub fn zeros(unknowns: usize) -> Gram {
        let columns = unknowns + 1;
        Gram {
            columns,
            values: vec![Complex::default(); columns * (columns + 1) / 2],
        }
    }

    /// Bytes of one.
    pub fn bytes(unknowns: usize) -> u64 {
        let columns = unknowns as u64 + 1;
        8 * columns * (columns + 1)
    }

    pub fn unknowns(&self) -> usize {
        self.columns - 1
    }

    /// Adds a realisation.
    pub fn add_row(&mut self, row: &[Complex<f64>]) {
        let mut values = &mut self.values[..];
        for (i, a) in row.iter().enumerate() {
            let (line, rest) = values.split_at_mut(i + 1);
            values = rest;
            let a = a.conj();
            for (sum, b) in line.iter_mut().zip(row) {
                *sum += a * b;
            }
        }
    }

    /// Of these, each so many times.
    pub fn sum(grams: &[Gram], times: &dyn Fn(usize) -> f64) -> Gram {
        let mut all = Gram::zeros(grams[0].unknowns());
        let taken = grams.iter().enumerate().map(|(g, gram)| (gram, times(g)));
        for (gram, times) in taken.filter(|(_, times)| *times != 0.0) {
            let pairs = all.values.iter_mut().zip(&gram.values);
            pairs.for_each(|(sum, value)| *sum += value * times);
        }
        all
    }

    pub fn get(&self, i: usize, j: usize) -> Complex<f64> {
        match j <= i {
            true => self.values[i * (i + 1) / 2 + j],
            false => self.values[j * (j + 1) / 2 + i].conj(),
        }
    }

    /// Power of the output.
    pub fn output(&self) -> f64 {
        self.get(self.columns - 1, self.columns - 1).re
    }

    /// The coefficients with the least residual, by the first `unknowns` columns; 0 and not determined where a
    /// column is a combination of those before it.
    ///
    /// Columns are scaled to length 1, and the triangle is that of Cholesky.
    pub fn solve(&self, unknowns: usize) -> Solution {
        let last = self.columns - 1;
        let scale: Vec<f64> = (0..unknowns)
            .map(|i| match self.get(i, i).re {
                power if power > 0.0 => power.sqrt().recip(),
                _ => 0.0,
            })
            .collect();
        // Rows of the triangle; a row of zeros is left out.
        let mut triangle: Vec<Vec<Complex<f64>>> = Vec::with_capacity(unknowns);
        let mut pivots = vec![0.0; unknowns];
        let mut forward = vec![Complex::default(); unknowns];
        for i in 0..unknowns {
            let mut row = vec![Complex::default(); i + 1];
            let mut left = if scale[i] > 0.0 { 1.0 } else { 0.0 };
            for j in 0..i {
                if pivots[j] == 0.0 {
                    continue;
                }
                let other = &triangle[j][..j];
                let known: Complex<f64> = row.iter().zip(other).map(|(a, b)| a * b.conj()).sum();
                row[j] = (self.get(i, j) * (scale[i] * scale[j]) - known) / pivots[j];
                left -= row[j].norm_sqr();
            }
            if left > LEAST_PIVOT {
                pivots[i] = left.sqrt();
                row[i] = Complex::new(pivots[i], 0.0);
                let known: Complex<f64> = row[..i].iter().zip(&forward).map(|(a, b)| a * b).sum();
                forward[i] = (self.get(i, last) * scale[i] - known) / pivots[i];
            } else {
                row.fill(Complex::default());
            }
            triangle.push(row);
        }
        let mut coefficients = forward;
        for i in (0..unknowns).rev() {
            if pivots[i] == 0.0 {
                coefficients[i] = Complex::default();
                continue;
            }
            let mut value = coefficients[i];
            for (row, later) in triangle.iter().zip(&coefficients).skip(i + 1) {
                value -= row[i].conj() * later;
            }
            coefficients[i] = value / pivots[i];
        }
        for (value, scale) in coefficients.iter_mut().zip(&scale) {
            *value *= *scale;
        }
        Solution {
            determined: pivots.iter().filter(|pivot| **pivot > 0.0).count(),
            coefficients,
        }
    }

    /// `sum_r |y - sum_i b_i a_i|^2` of the first coefficients.
    pub fn residual(&self, coefficients: &[Complex<f64>]) -> f64 {
        let last = self.columns - 1;
        let mut sum = self.output();
        for (i, b) in coefficients.iter().enumerate() {
            let mut inner = self.get(i, last) * -2.0;
            for (j, c) in coefficients.iter().enumerate() {
                inner += self.get(i, j) * c;
            }
            sum += (b.conj() * inner).re;
        }
        sum
    }
}

/// See [`Gram::solve`].
#[derive(Debug, Clone)]
pub(crate) struct Solution {
    pub coefficients: Vec<Complex<f64>>,
    /// How many of them are.
    pub determined: usize,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Random;

    #[test]
    fn val_closed_form_coefficients_and_residual() {
        let mut numbers = Random::new(3);
        let mut random = || Complex::new(numbers.normal(), numbers.normal());
        let truth = [(); 7].map(|()| random());
        let mut gram = Gram::zeros(8);
        let mut noise = 0.0;
        for _ in 0..400 {
            let mut row = [(); 7].map(|()| random()).to_vec();
            // One column that is a combination of others.
            row.push(row[2] * 2.0 - row[5]);
            let off = random() * 1e-3;
            let y: Complex<f64> = row.iter().zip(&truth).map(|(a, b)| a * b).sum();
            noise += off.norm_sqr();
            row.push(y + off);
            gram.add_row(&row);
        }
        let found = gram.solve(8);
        assert_eq!(found.determined, 7);
        let mut pairs = found.coefficients.iter().zip(&truth);
        assert!(pairs.all(|(found, truth)| (found - truth).norm() < 5e-4));
        assert_eq!(found.coefficients[7], Complex::default());
        // A fit of 7 unknowns to 400 realisations leaves 393 / 400 of the noise.
        let left = gram.residual(&found.coefficients) / noise;
        assert!((left - 393.0 / 400.0).abs() < 0.02, "{left}");
        assert!((gram.residual(&[]) / gram.output() - 1.0).abs() < 1e-15);
    }
}
