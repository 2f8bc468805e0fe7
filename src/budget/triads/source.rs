//! Where coefficients and their rates come from: a chain, or a field that obeys Burgers' equation.

use std::f64::consts::TAU;
use std::sync::Arc;

use column_fft::{RealToComplex, rows};
use ndarray::ArrayView2;
use num_complex::Complex;

use super::kernel::{Components, Grid};
use super::{QuadraticLaw, refuse};
use crate::budget::tendency::{Burgers, Tendency};
use crate::error::Result;

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

/// Samples of a field over one period.
pub(super) struct WaveField<'a> {
    u: ArrayView2<'a, f64>,
    time: [f64; 2],
    length: f64,
    burgers: Burgers,
    coefficients: Coefficients,
}

impl<'a> WaveField<'a> {
    pub fn new(u: ArrayView2<'a, f64>, [t0, dt]: [f64; 2], length: f64) -> Result<Self> {
        let (times, places) = u.dim();
        if times < 3 || places < 3 {
            let found = format!("{times} by {places}");
            return refuse("field", "three times and three places or more", found);
        }
        if let Some(value) = u.iter().find(|value| !value.is_finite()) {
            return refuse("field", "finite values", value);
        }
        for (option, value) in [("dt", dt), ("length", length)] {
            if !(value > 0.0 && value.is_finite()) {
                return refuse(option, "a positive number", value);
            }
        }
        Ok(WaveField {
            u,
            time: [t0, dt],
            length,
            burgers: Burgers::new(0.0, length, places)?,
            coefficients: Coefficients::new(places),
        })
    }
}

impl Source for WaveField<'_> {
    fn samples(&self) -> usize {
        self.u.nrows()
    }

    fn time(&self) -> [f64; 2] {
        self.time
    }

    fn grid(&self) -> Grid {
        let points = self.u.ncols();
        Grid {
            points,
            // Without the largest of an even number, which has no phase.
            components: (points - 1) / 2 + 1,
            wraps: false,
        }
    }

    fn law(&self) -> QuadraticLaw {
        QuadraticLaw::Burgers
    }

    fn has_more(&self) -> bool {
        false
    }

    fn components(&self, sample: usize) -> Components {
        let grid = self.grid();
        let row = self.u.row(sample).to_vec();
        let (mut conservative, mut dissipative) = (row.clone(), row.clone());
        self.burgers
            .evaluate(0.0, &row, &mut conservative, &mut dissipative);
        let mut u = self.coefficients.of(&row);
        let mut slope = self.coefficients.of(&conservative);
        u.truncate(grid.components);
        slope.truncate(grid.components);
        // Transfers have the shape of a chain's, with the slope along x in place of the rate: `Im(k1 a1 a2 a3)` summed as
        // there is `3 k1 Im(a1 a2 a3)`.
        let k = |m: usize| TAU * m as f64 / self.length;
        let along: Vec<Complex<f64>> = u
            .iter()
            .enumerate()
            .map(|(m, u)| Complex::new(0.0, k(m)) * u)
            .collect();
        let energy = u
            .iter()
            .enumerate()
            .map(|(m, u)| 0.5 * grid.weight(m) * u.norm_sqr());
        let transfer = u.iter().zip(&slope).enumerate();
        let transfer = transfer.map(|(m, (u, c))| grid.weight(m) * (u.re * c.re + u.im * c.im));
        Components {
            energy: energy.collect(),
            transfer: transfer.collect(),
            beyond: Vec::new(),
            value: parts(&u),
            rate: parts(&along),
            scale: -0.5,
        }
    }
}
