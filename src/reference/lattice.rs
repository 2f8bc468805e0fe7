//! The harmonic lattice, struck at one site.

use super::Grid;
use crate::field::Field;

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
        let orders = |n: usize| bessel_j(2.0 * n as f64 * self.dt, 2 * self.n_sites);
        let orders: Vec<Vec<f64>> = (0..self.n_times).map(orders).collect();
        let grid = Grid {
            n_times: self.n_times,
            n_sites: self.n_sites,
            dt: self.dt,
            dx: 1.0,
        };
        let mut field = grid.sample("lattice-impact", |n, j| orders[n][2 * j]);
        field.time.unit = Some("sqrt(m/c)".into());
        field.space.unit = Some("a".into());
        field.unit = Some("v0".into());
        field
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
        let below = match x > 1e-17 {
            true => 2.0 * (n as f64 + 1.0) / x * here - above,
            false => f64::from(u8::from(n == 0)),
        };
        (above, here) = (here, below);
        if here.abs() > 1e100 {
            values.iter_mut().for_each(|value| *value *= 1e-100);
            (above, here, squares) = (above * 1e-100, here * 1e-100, squares * 1e-200);
        }
        if let Some(value) = values.get_mut(n) {
            *value = here;
        }
        let both = if n == 0 { 1.0 } else { 2.0 };
        squares += both * here * here;
    }
    let scale = squares.sqrt().recip();
    values.iter_mut().for_each(|value| *value *= scale);
    values
}
