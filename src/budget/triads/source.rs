//! Where coefficients and their rates come from.

use std::sync::Arc;

use column_fft::{RealToComplex, rows};
use num_complex::Complex;

use super::QuadraticLaw;
use super::kernel::{Components, Grid};

/// A motion whose coefficients couple quadratically.
pub(super) trait Source: Sync {
    fn samples(&self) -> usize;
    /// First sample and step.
    fn time(&self) -> [f64; 2];
    fn grid(&self) -> Grid;
    fn law(&self) -> QuadraticLaw;
    /// Whether the law has terms beyond the quadratic one.
    fn has_more(&self) -> bool;
    fn components(&self, sample: usize) -> Components;
}

/// Fourier coefficients of a row over a period, divided by the number of places.
#[derive(Clone)]
pub(super) struct Coefficients {
    plan: Arc<dyn RealToComplex<f64>>,
}

impl Coefficients {
    pub fn new(points: usize) -> Coefficients {
        Coefficients {
            plan: rows::plan_fft_forward(points),
        }
    }

    pub fn of(&self, row: &[f64]) -> Vec<Complex<f64>> {
        let (mut input, mut output) = (self.plan.make_input_vec(), self.plan.make_output_vec());
        input.copy_from_slice(row);
        // The lengths are the plan's own, so this cannot fail.
        let _ = self.plan.process(&mut input, &mut output);
        for value in &mut output {
            *value /= row.len() as f64;
        }
        output
    }
}

/// Real and imaginary parts apart.
pub(super) fn parts(values: &[Complex<f64>]) -> [Vec<f64>; 2] {
    [
        values.iter().map(|value| value.re).collect(),
        values.iter().map(|value| value.im).collect(),
    ]
}
