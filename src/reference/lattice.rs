//! The harmonic lattice, struck at one site.

use ndarray::Array2;

use crate::field::{Axis, Field};

/// An infinite chain of unit masses and unit springs whose site 0 starts with unit velocity:
/// `x_j'' = x_{j-1} - 2 x_j + x_{j+1}`, `v_j(t) = J_{2j}(2 t)`.
///
/// Sites 0 to `n_sites - 1` are sampled (site -j moves as site j). The front travels one site a
/// unit of time, its tail disperses: `omega(k) = 2 |sin(k / 2)|`. Time is in units of
/// `sqrt(m / c)` (mass over spring constant), x in lattice spacings `a`, velocity in that of the
/// impact, `v0`.
///
/// Source: Schroedinger, Ann. Phys. 349, 916 (1914).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LatticeImpact {
    pub n_times: usize,
    pub n_sites: usize,
    pub dt: f64,
}

impl LatticeImpact {
    pub fn field(&self) -> Field {
        let mut values = Array2::zeros((self.n_times, self.n_sites));
        for (n, mut row) in values.outer_iter_mut().enumerate() {
            let orders = bessel_j(2.0 * n as f64 * self.dt, 2 * self.n_sites);
            for (v, j) in row.iter_mut().zip(orders.iter().step_by(2)) {
                *v = *j;
            }
        }
        let mut field = Field::from_array(values);
        let axis = |step, unit: &str| Axis {
            origin: 0.0,
            step,
            unit: Some(unit.into()),
        };
        field.name = "lattice-impact".into();
        field.time = axis(self.dt, "sqrt(m/c)");
        field.space = axis(1.0, "a");
        field.unit = Some("v0".into());
        field
    }

    /// `sum_j v_j^2 = (1 + J_0(4 t)) / 2` over all sites of both signs: the share of the energy
    /// that is kinetic, 1 at the start, 1/2 in the end.
    pub fn square_sum(t: f64) -> f64 {
        0.5 * (1.0 + bessel_j(4.0 * t, 1)[0])
    }

    /// `sum_j v_j exp(i k j) = cos(omega(k) t)`, over all sites of both signs.
    pub fn transform(k: f64, t: f64) -> f64 {
        (2.0 * (0.5 * k).sin().abs() * t).cos()
    }
}

/// `J_0(x)` to `J_{count - 1}(x)` for finite `x >= 0`, each to 1e-15.
///
/// Downwards by `J_{n-1} = (2 n / x) J_n - J_{n+1}` from where `J_n < 1e-17` (above which 0 is
/// given), scaled so that `J_0^2 + 2 sum J_n^2 = 1`, a sum without cancellation.
///
/// Source: DLMF 3.6(iii) (Miller's algorithm), 10.6.1, 10.23.3.
pub fn bessel_j(x: f64, count: usize) -> Vec<f64> {
    let mut values = vec![0.0; count];
    let top = (x + 14.0 * x.cbrt()).ceil() as usize + 20;
    let (mut above, mut here) = (0.0, 1.0);
    let mut squares = 0.0;
    for n in (0..top).rev() {
        let below = if x > 1e-17 {
            2.0 * (n as f64 + 1.0) / x * here - above
        } else {
            f64::from(u8::from(n == 0))
        };
        (above, here) = (here, below);
        if here.abs() > 1e100 {
            for value in &mut values {
                *value *= 1e-100;
            }
            (above, here, squares) = (above * 1e-100, here * 1e-100, squares * 1e-200);
        }
        if let Some(value) = values.get_mut(n) {
            *value = here;
        }
        squares += if n == 0 {
            here * here
        } else {
            2.0 * here * here
        };
    }
    let scale = squares.sqrt().recip();
    values.iter_mut().for_each(|value| *value *= scale);
    values
}
