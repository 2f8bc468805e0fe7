//! Fields with closed forms, for tests, benches and examples.

mod lattice;

use std::f64::consts::PI;

use ndarray::Array2;

use crate::field::{Axis, Field};
use crate::numeric::next_uniform;

pub use lattice::{LatticeImpact, bessel_j};

/// Where a problem is sampled: `t_n = n dt` in s, `x_j = j dx` in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    pub n_times: usize,
    pub n_sites: usize,
    pub dt: f64,
    pub dx: f64,
}

impl Grid {
    /// The field of `velocity(n, j)` in m/s.
    pub fn sample(&self, name: &str, mut velocity: impl FnMut(usize, usize) -> f64) -> Field {
        let values = Array2::from_shape_fn((self.n_times, self.n_sites), |(n, j)| velocity(n, j));
        let mut field = Field::from_array(values);
        let axis = |step, unit: &str| Axis {
            origin: 0.0,
            step,
            unit: Some(unit.into()),
        };
        field.name = name.into();
        field.time = axis(self.dt, "s");
        field.space = axis(self.dx, "m");
        field.unit = Some("m/s".into());
        field
    }
}

/// A burst whose second harmonic grows along x, in a medium without dispersion and losses:
/// `v = a [sech(a s x) cos(2 pi f tau) + tanh(a s x) cos(4 pi f tau)]` with `tau = t - t_a - x / c` and
/// `a = A exp(-tau^2 / (2 sigma^2))`.
///
/// What the fundamental loses the harmonic gains, so that the energy at each site is the same.
///
/// Source: Armstrong, Bloembergen, Ducuing, Pershan, Phys. Rev. 127, 1918 (1962), with phases matched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrowingHarmonic {
    pub grid: Grid,
    /// A, in m/s.
    pub amplitude: f64,
    /// f, in Hz.
    pub frequency: f64,
    /// sigma, in s, several periods.
    pub width: f64,
    /// t_a: when the middle of the burst passes x = 0, in s.
    pub arrival: f64,
    /// c, in m/s.
    pub speed: f64,
    /// s: how fast the harmonic grows, in s/m^2.
    pub growth: f64,
    /// Standard deviation of white noise that is added, in m/s.
    pub noise: f64,
}

impl GrowingHarmonic {
    /// A scan of 96 sites, 8 mm apart, sampled at 100 kHz, with noise of 1 % of the amplitude. At the last
    /// site four tenths of the energy are in the harmonic.
    pub const EXAMPLE: Self = GrowingHarmonic {
        grid: Grid {
            n_times: 1024,
            n_sites: 96,
            dt: 1e-5,
            dx: 0.008,
        },
        amplitude: 0.1,
        frequency: 4000.0,
        width: 4e-4,
        arrival: 2e-3,
        speed: 200.0,
        growth: 12.0,
        noise: 1e-3,
    };

    pub fn field(&self) -> Field {
        let mut next = uniform(self.noise, 1);
        self.grid.sample("growing-harmonic", |n, j| {
            let x = j as f64 * self.grid.dx;
            let tau = n as f64 * self.grid.dt - self.arrival - x / self.speed;
            let a = self.amplitude * (-0.5 * (tau / self.width).powi(2)).exp();
            let grown = a * self.growth * x;
            let (first, second) = (grown.cosh().recip(), grown.tanh());
            let phase = 2.0 * PI * (self.frequency * tau).fract();
            a * (first * phase.cos() + second * (2.0 * phase).cos()) + next()
        })
    }
}

/// Independent samples, uniform between `-sqrt(3) sigma` and `sqrt(3) sigma`: the same bits from
/// the same seed everywhere.
///
/// The expected one-sided power spectral density is `2 sigma^2 dt` at every frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WhiteNoise {
    pub grid: Grid,
    /// sigma, in m/s.
    pub deviation: f64,
    pub seed: u64,
}

impl WhiteNoise {
    pub fn field(&self) -> Field {
        let mut next = uniform(self.deviation, self.seed);
        self.grid.sample("white-noise", |_, _| next())
    }
}

/// One sample of such noise after the other.
fn uniform(deviation: f64, mut seed: u64) -> impl FnMut() -> f64 {
    let half_range = 3.0_f64.sqrt() * deviation;
    move || half_range * (2.0 * next_uniform(&mut seed) - 1.0)
}
