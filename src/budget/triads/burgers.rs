//! Triads of Burgers' equation `u_t + u u_x = 0`, whose transfers `T(k | p, q) = (k / 2) Im( conj(u_k) u_p u_q )` have a
//! closed form: what the sums over pairs are checked against.

use std::f64::consts::TAU;

use ndarray::Array2;
use num_complex::Complex;

use super::kernel::{Components, Grid};
use super::source::{Coefficients, Source, parts};
use super::{QuadraticLaw, TriadsRequest, run};
use crate::budget::tendency::{Burgers, Tendency};
use crate::observer::Silent;

/// Three equal rows over one period.
struct WaveField {
    u: Vec<f64>,
    time: [f64; 2],
    length: f64,
    burgers: Burgers,
    coefficients: Coefficients,
}

impl Source for WaveField {
    fn samples(&self) -> usize {
        3
    }

    fn time(&self) -> [f64; 2] {
        self.time
    }

    fn grid(&self) -> Grid {
        let points = self.u.len();
        Grid {
            points,
            // Without the largest of an even number, which has no phase.
            components: (points - 1) / 2 + 1,
            wraps: false,
        }
    }

    fn law(&self) -> QuadraticLaw {
        QuadraticLaw {
            mass: 1.0,
            linear: 0.0,
            quadratic: 1.0,
        }
    }

    fn has_more(&self) -> bool {
        false
    }

    fn components(&self, _sample: usize) -> Components {
        let (grid, row) = (self.grid(), &self.u);
        let (mut conservative, mut dissipative) = (row.clone(), row.clone());
        self.burgers
            .evaluate(0.0, row, &mut conservative, &mut dissipative);
        let mut u = self.coefficients.of(row);
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

fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

/// `sum_j u_j exp(-i k j) / n`, term by term.
fn coefficient(u: &[f64], k: usize) -> Complex<f64> {
    let n = u.len();
    let term =
        |(j, u): (usize, &f64)| Complex::from_polar(*u, -TAU * (j * k % n) as f64 / n as f64);
    u.iter().enumerate().map(term).sum::<Complex<f64>>() / n as f64
}

/// Three equal rows of a few waves with phases of their own.
fn waves(n: usize) -> Vec<f64> {
    let place = |j: usize| TAU * j as f64 / n as f64;
    let wave = |x: f64| {
        0.3 + (x + 0.4).sin() + 0.7 * (2.0 * x - 1.1).cos() + 0.2 * (3.0 * x).sin()
            - 0.4 * (5.0 * x + 2.0).cos()
    };
    (0..n).map(|j| wave(place(j))).collect()
}

#[test]
fn val_direct_sums_of_burgers() {
    for n in [16, 21] {
        let row = waves(n);
        let (length, dt) = (4.0, 0.5);
        let request = TriadsRequest::default();
        let wave = WaveField {
            u: row.clone(),
            time: [1.0, dt],
            length,
            burgers: Burgers::new(0.0, length, n).unwrap(),
            coefficients: Coefficients::new(n),
        };
        let found = run(&wave, length / n as f64, &request, &Silent).unwrap();
        assert_eq!(found.window, [1.0, 2.0]);
        assert!(found.umklapp.is_none());
        let last = (n - 1) / 2;
        assert_eq!(found.transfer.dim(), (last + 1, last + 1));
        let a: Vec<Complex<f64>> = (0..=last).map(|k| coefficient(&row, k)).collect();
        let signed = |m: isize| match m < 0 {
            true => a[m.unsigned_abs()].conj(),
            false => a[m as usize],
        };
        let mut expected = Array2::<f64>::zeros((last + 1, last + 1));
        let most = last as isize;
        for k in -most..=most {
            for p in -most..=most {
                let q = k - p;
                if q.abs() > most {
                    continue;
                }
                let wavenumber = TAU * k as f64 / length;
                let rate = 0.5 * wavenumber * (signed(k).conj() * signed(p) * signed(q)).im;
                let larger = p.abs().max(q.abs()) as usize;
                // Two steps.
                expected[[k.unsigned_abs(), larger]] += 2.0 * dt * rate;
            }
        }
        let off = largest(&(&found.transfer - &expected)) / largest(&expected);
        assert!(off < 1e-15, "{n}: {off:e}");
        assert!(found.identities.detailed < 1e-15 && found.identities.sums < 2e-15);
        // Nothing leaves the last wavenumber.
        assert!(found.flux[last].abs() < 1e-15 * largest(&found.flux));
    }
}
