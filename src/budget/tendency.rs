//! Wavenumber budgets of a periodic field whose equation is known.
//!
//! For `du/dt = c(u) + d(u)`, with `u^_n` the Fourier coefficients over a period (divided by the
//! number of samples) and `w_n` = 2, but 1 at n = 0 and at the largest n of an even number,
//!
//! ```text
//! E_n = w_n |u^_n|^2 / 2,  T_n = w_n Re(conj(u^_n) c^_n),  D_n = w_n Re(conj(u^_n) d^_n),
//! dE_n/dt = T_n + D_n,     Pi_n = - sum_{m <= n} T_m.
//! ```
//!
//! E sums to the mean of `u^2 / 2`. The conservative part c exchanges energy between wavenumbers,
//! `sum T = 0`; the dissipative part d removes it, `D < 0`.

use column_fft::RealToComplex;
use ndarray::{Array2, ArrayView2, Axis};
use num_complex::Complex;
use rayon::prelude::*;

use super::balance::worst_of;
use super::modes::{Basis, Modes};
use super::quadrature::{Quadrature, SMOOTH};
use super::result::{Identities, Residual};
use super::wavenumber::dot;
use crate::error::{Error, Result};
use crate::numeric::sum;

/// The tendency, the right-hand side of `du/dt = c(u) + d(u)`, on a periodic grid.
pub trait Tendency: Sync {
    /// Computes both parts at one instant; all three rows have one value per grid point.
    fn evaluate(&self, t: f64, u: &[f64], conservative: &mut [f64], dissipative: &mut [f64]);
}

/// The budget of a field with a known tendency; arrays are `(time, wavenumber)`.
#[derive(Debug, Clone)]
pub struct TendencyBudget {
    /// In rad per length; k and -k are combined.
    pub wavenumber: Vec<f64>,
    pub energy: Array2<f64>,
    pub transfer: Array2<f64>,
    /// `D`: negative where energy is dissipated.
    pub dissipation: Array2<f64>,
    /// `Pi`, positive towards larger k.
    pub flux: Array2<f64>,
    /// Integral of `T + D` from the first sample up to each sample.
    pub integrated: Array2<f64>,
    /// Largest deviation of [`TendencyBudget::integrated`] from the change of E, relative to the
    /// largest change.
    pub closure: Residual,
    pub identities: Identities,
}

/// Computes the budget of samples `u[n, j]` at times `t0 + n dt`, over one period `length` along x.
///
/// Integrals over time are those of interpolating polynomials through 8 samples.
///
/// # Errors
/// [`Error::Request`] for fewer than two times or three grid points, for values that are not finite, and
/// for a step or length that is not positive.
pub fn tendency_budget(
    u: ArrayView2<f64>,
    [t0, dt]: [f64; 2],
    length: f64,
    tendency: &dyn Tendency,
) -> Result<TendencyBudget> {
    check(u, [t0, dt], length)?;
    let (samples, n) = u.dim();
    let modes = Modes::new(Basis::Fourier, n);
    let count = modes.len();
    let rows: Vec<[Vec<f64>; 3]> = (0..samples)
        .into_par_iter()
        .map_init(
            || (modes.scratch(), vec![0.0; n], vec![0.0; n]),
            |(scratch, conservative, dissipative), i| {
                let row = u.row(i).to_vec();
                tendency.evaluate(t0 + dt * i as f64, &row, conservative, dissipative);
                let mut spectrum = |row: &[f64]| {
                    let mut out = vec![Complex::default(); count];
                    modes.of_sites(row, scratch, &mut out);
                    out
                };
                let z = spectrum(&row);
                // The transform is unitary, so division by n gives means over the grid.
                let with = |other: &[Complex<f64>], factor: f64| {
                    let pairs = z.iter().zip(other).enumerate();
                    pairs
                        .map(|(m, (z, o))| factor * modes.weight(m) * dot(*z, *o) / n as f64)
                        .collect()
                };
                let (c, d) = (spectrum(conservative), spectrum(dissipative));
                [with(&z, 0.5), with(&c, 1.0), with(&d, 1.0)]
            },
        )
        .collect();
    let array = |which: usize| Array2::from_shape_fn((samples, count), |(i, m)| rows[i][which][m]);
    let [energy, transfer, dissipation] = [0, 1, 2].map(array);
    let mut flux = -transfer.clone();
    flux.accumulate_axis_inplace(Axis(1), |before, now| *now += before);
    let rates = &transfer + &dissipation;
    let integrated = Quadrature::new(samples, SMOOTH).running(rates.view(), dt);
    let change = &energy - &energy.row(0);
    let off = largest((&change - &integrated).iter().copied());
    let scale = largest(change.iter().copied());
    let relative = |off: f64, of: f64| if off == 0.0 { 0.0 } else { off / of };
    let sums = transfer.rows().into_iter().map(|row| {
        let row = row.to_vec();
        relative(sum(&row), largest(row.iter().copied()))
    });
    let energies = u.rows().into_iter().zip(energy.rows()).map(|(u, energy)| {
        let squares = crate::numeric::sum_of_squares(&u.to_vec()) / (2 * n) as f64;
        relative(sum(&energy.to_vec()) - squares, squares)
    });
    let identities = Identities {
        transfer_rounding: 0.0,
        transfer_sum: largest(sums),
        energy_sum: largest(energies),
        loss_sum: None,
    };
    Ok(TendencyBudget {
        wavenumber: modes.wavenumbers(length / n as f64),
        closure: Residual::Closed(relative(off, scale)),
        energy,
        transfer,
        dissipation,
        flux,
        integrated,
        identities,
    })
}

/// The largest magnitude; NaN if any value is NaN.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.map(f64::abs).collect();
    worst_of(0.0, &values)
}

fn check(u: ArrayView2<f64>, [t0, dt]: [f64; 2], length: f64) -> Result<()> {
    let found = format!("{} by {}", u.nrows(), u.ncols());
    let expected = "two times and three places or more";
    Error::require(u.nrows() >= 2 && u.ncols() >= 3, "field", expected, found)?;
    if let Some(value) = u.iter().find(|value| !value.is_finite()) {
        return Err(Error::request("field", "finite values", value));
    }
    Error::require(t0.is_finite(), "t0", "a finite time", t0)?;
    for (option, value) in [("dt", dt), ("length", length)] {
        let is_one = value > 0.0 && value.is_finite();
        Error::require(is_one, option, "a positive number", value)?;
    }
    Ok(())
}

/// The transform of a row.
pub(super) fn forward(plan: &dyn RealToComplex<f64>, row: &[f64]) -> Vec<Complex<f64>> {
    let (mut input, mut output) = (plan.make_input_vec(), plan.make_output_vec());
    input.copy_from_slice(row);
    // The lengths are the plan's own, so this cannot fail.
    let _ = plan.process(&mut input, &mut output);
    output
}
