//! Sines, a pulse, a chirp, noise.

use std::cell::Cell;
use std::f64::consts::PI;

use num_complex::Complex;

use super::Grid;
use crate::field::Field;
use crate::numeric::{cos_turns, split_mix, unit_interval};

/// `v = A cos(k x - omega t)` on exact bins, so that no window is needed and nothing leaks.
///
/// `f = m / (N dt)` with `0 < m < N / 2`; `k = 2 pi l / (M dx)` with `0 < |l| < M / 2`.
/// `l > 0` travels towards +x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TravellingSine {
    pub grid: Grid,
    /// A, in m/s.
    pub amplitude: f64,
    /// m.
    pub frequency_bin: usize,
    /// l.
    pub wavenumber_bin: isize,
}

impl TravellingSine {
    pub fn field(&self) -> Field {
        self.grid.sample("travelling-sine", |n, j| {
            self.amplitude * cos_phase(&self.grid, self.wavenumber_bin, j, self.frequency_bin, n)
        })
    }

    /// f, in Hz.
    pub fn frequency(&self) -> f64 {
        self.frequency_bin as f64 / self.grid.duration()
    }

    /// k, in rad/m, with its sign.
    pub fn wavenumber(&self) -> f64 {
        2.0 * PI * self.wavenumber_bin as f64 / self.grid.length()
    }

    /// `sum v^2 dt dx = A^2 T L / 2`.
    pub fn energy(&self) -> f64 {
        0.5 * self.amplitude.powi(2) * self.grid.duration() * self.grid.length()
    }
}

/// `v = A cos(k x) cos(omega t)` on exact bins: half of the energy travels each way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StandingWave {
    pub grid: Grid,
    /// A, in m/s.
    pub amplitude: f64,
    /// m of `f = m / (N dt)`, `0 < m < N / 2`.
    pub frequency_bin: usize,
    /// l of `k = 2 pi l / (M dx)`, `0 < l < M / 2`.
    pub wavenumber_bin: usize,
}

impl StandingWave {
    pub fn field(&self) -> Field {
        self.grid.sample("standing-wave", |n, j| {
            let space = cos_phase(&self.grid, self.wavenumber_bin as isize, j, 0, n);
            let time = cos_phase(&self.grid, 0, j, self.frequency_bin, n);
            self.amplitude * space * time
        })
    }

    /// `sum v^2 dt dx = A^2 T L / 4`.
    pub fn energy(&self) -> f64 {
        0.25 * self.amplitude.powi(2) * self.grid.duration() * self.grid.length()
    }
}

/// `cos(2 pi (l j / M - m n / N))`, its phase reduced in integers.
fn cos_phase(grid: &Grid, l: isize, j: usize, m: usize, n: usize) -> f64 {
    let (times, sites) = (grid.n_times as u64, grid.n_sites as u64);
    let space = (l as i128 * j as i128).rem_euclid(sites.into()) as u64;
    let time = (m as u64 * n as u64) % times;
    cos_turns(space * times + (times - time) * sites, times * sites)
}

/// `v = A exp(-(t - t_a - x / c)^2 / (2 sigma^2))`, a pulse that travels unchanged.
///
/// What is said of its spectra holds where the pulse lies inside the record, several sigma from
/// its ends, and sigma is longer than 1.5 dt (then to 1e-14).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussianPulse {
    pub grid: Grid,
    /// A, in m/s.
    pub amplitude: f64,
    /// sigma, in s.
    pub width: f64,
    /// t_a: when the peak passes x = 0, in s.
    pub arrival: f64,
    /// c, in m/s, with its sign.
    pub speed: f64,
}

impl GaussianPulse {
    pub fn field(&self) -> Field {
        self.grid.sample("gaussian-pulse", |n, j| {
            let delay = self.arrival + j as f64 * self.grid.dx / self.speed;
            let age = (n as f64 * self.grid.dt - delay) / self.width;
            self.amplitude * (-0.5 * age * age).exp()
        })
    }

    /// One-sided energy spectral density at each site, in (m/s)^2 s / Hz:
    /// `4 pi A^2 sigma^2 exp(-(2 pi f sigma)^2)`.
    pub fn spectrum(&self, frequency: f64) -> f64 {
        let peak = 4.0 * PI * (self.amplitude * self.width).powi(2);
        peak * (-(2.0 * PI * frequency * self.width).powi(2)).exp()
    }

    /// `sum v^2 dt = A^2 sigma sqrt(pi)` at each site.
    pub fn site_energy(&self) -> f64 {
        self.amplitude.powi(2) * self.width * PI.sqrt()
    }

    /// `sum v^2 dt dx` over all sites.
    pub fn energy(&self) -> f64 {
        self.site_energy() * self.grid.length()
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
        let noise = WhiteNoise {
            grid: self.grid,
            deviation: self.noise,
            seed: 1,
        };
        let next = noise.samples();
        self.grid.sample("growing-harmonic", |n, j| {
            let x = j as f64 * self.grid.dx;
            let tau = n as f64 * self.grid.dt - self.arrival - x / self.speed;
            let a = self.amplitude * (-0.5 * (tau / self.width).powi(2)).exp();
            let [first, second] = self.shares(a, x);
            let phase = 2.0 * PI * (self.frequency * tau).fract();
            a * (first * phase.cos() + second * (2.0 * phase).cos()) + next()
        })
    }

    /// Amplitudes of both harmonics at `x`, over that of the burst there, `a`.
    pub fn shares(&self, a: f64, x: f64) -> [f64; 2] {
        let grown = a * self.growth * x;
        [grown.cosh().recip(), grown.tanh()]
    }

    /// `sum v^2 dt = A^2 sigma sqrt(pi) / 2` at each site, without the noise.
    pub fn site_energy(&self) -> f64 {
        0.5 * self.amplitude.powi(2) * self.width * PI.sqrt()
    }
}

/// `v = A cos(2 pi (f0 s + r s^2 / 2))` with `s = t - x / c`: a ridge `f = f0 + r s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearChirp {
    pub grid: Grid,
    /// A, in m/s.
    pub amplitude: f64,
    /// f0, in Hz.
    pub start: f64,
    /// r, in Hz/s.
    pub rate: f64,
    /// c, in m/s.
    pub speed: f64,
}

impl LinearChirp {
    pub fn field(&self) -> Field {
        self.grid.sample("linear-chirp", |n, j| {
            let s = self.age(n as f64 * self.grid.dt, j as f64 * self.grid.dx);
            let turns = (self.start + 0.5 * self.rate * s) * s;
            self.amplitude * (2.0 * PI * turns.fract()).cos()
        })
    }

    /// Frequency at time `t` and position `x`, in Hz.
    pub fn frequency(&self, t: f64, x: f64) -> f64 {
        self.start + self.rate * self.age(t, x)
    }

    fn age(&self, t: f64, x: f64) -> f64 {
        t - x / self.speed
    }
}

/// `v = A cos(2 pi q t / T)` at all sites, q any number of cycles a record: it leaks unless whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    pub grid: Grid,
    /// A, in m/s.
    pub amplitude: f64,
    /// q, above 0 and below N / 2.
    pub cycles: f64,
}

impl Tone {
    pub fn field(&self) -> Field {
        self.grid.sample("tone", |n, _| {
            let length = self.grid.n_times as f64;
            let turns = (self.cycles * n as f64 % length) / length;
            self.amplitude * (2.0 * PI * turns).cos()
        })
    }

    /// The transform `sum_n v_n exp(-2 pi i p n / N)`, in m/s:
    /// `A [D(p - q) + D(p + q)] / 2` with `D(u) = exp(-i pi u (N - 1) / N) sin(pi u) / sin(pi u /
    /// N)`.
    pub fn transform(&self, bin: usize) -> Complex<f64> {
        let p = bin as f64;
        let kernels = self.kernel(p - self.cycles) + self.kernel(p + self.cycles);
        kernels * (0.5 * self.amplitude)
    }

    /// `sum v^2 dt dx = A^2 T L / 2 [1 + Re D(2 q) / N]`.
    pub fn energy(&self) -> f64 {
        let beat = self.kernel(2.0 * self.cycles).re / self.grid.n_times as f64;
        let mean_square = 0.5 * self.amplitude.powi(2) * (1.0 + beat);
        mean_square * self.grid.duration() * self.grid.length()
    }

    /// `sum_n exp(-2 pi i u n / N)`.
    fn kernel(&self, u: f64) -> Complex<f64> {
        let n = self.grid.n_times as f64;
        let below = (PI * u / n).sin();
        if below == 0.0 {
            return Complex::new(n, 0.0);
        }
        let part = PI * (u % 2.0);
        Complex::from_polar(part.sin() / below, PI * u / n - part)
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
        let next = self.samples();
        self.grid.sample("white-noise", |_, _| next())
    }

    /// One sample after the other.
    fn samples(&self) -> impl Fn() -> f64 {
        let half_range = 3.0_f64.sqrt() * self.deviation;
        let state = Cell::new(self.seed);
        move || {
            let (next, bits) = split_mix(state.get());
            state.set(next);
            half_range * (2.0 * unit_interval(bits) - 1.0)
        }
    }

    /// `2 sigma^2 dt`, in (m/s)^2 / Hz.
    pub fn density(&self) -> f64 {
        2.0 * self.deviation.powi(2) * self.grid.dt
    }
}
