//! Fields with closed forms: one table for tests, benches and examples.
//!
//! Each problem is a small struct of its parameters: `field` samples it, the other methods say
//! what is known of it. [`problems`] lists one of each kind.

mod lattice;
mod waves;

use ndarray::Array2;

use crate::field::{Axis, Field};

pub use lattice::{LatticeImpact, bessel_j};
pub use waves::{
    GaussianPulse, GrowingHarmonic, LinearChirp, StandingWave, Tone, TravellingSine, WhiteNoise,
};

/// Where a problem is sampled: `t_n = n dt` in s, `x_j = j dx` in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    pub n_times: usize,
    pub n_sites: usize,
    pub dt: f64,
    pub dx: f64,
}

impl Grid {
    /// `n_times dt`, in s.
    pub fn duration(&self) -> f64 {
        self.n_times as f64 * self.dt
    }

    /// `n_sites dx`, in m.
    pub fn length(&self) -> f64 {
        self.n_sites as f64 * self.dx
    }

    /// The field of `velocity(n, j)` in m/s.
    pub fn sample(&self, name: &str, velocity: impl Fn(usize, usize) -> f64) -> Field {
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

/// A sampled problem with what every analysis of it must find.
#[derive(Debug, Clone)]
pub struct Problem {
    pub name: &'static str,
    pub field: Field,
    /// `sum v^2 dt dx`, where it has a closed form.
    pub energy: Option<f64>,
    /// Shares of the energy towards +x, towards -x and undirected, where they are exact.
    pub direction: Option<[f64; 3]>,
}

/// One problem of each kind that is linear, on 256 times and 64 sites (the lattice: 64 times).
pub fn problems() -> Vec<Problem> {
    let grid = Grid {
        n_times: 256,
        n_sites: 64,
        dt: 1.0 / 64.0,
        dx: 0.25,
    };
    let sine = |wavenumber_bin| TravellingSine {
        grid,
        amplitude: 1.5,
        frequency_bin: 20,
        wavenumber_bin,
    };
    let standing = StandingWave {
        grid,
        amplitude: 2.0,
        frequency_bin: 12,
        wavenumber_bin: 5,
    };
    let pulse = GaussianPulse {
        grid,
        amplitude: 1.0,
        width: 0.0625,
        arrival: 1.0,
        speed: 8.0,
    };
    let chirp = LinearChirp {
        grid,
        amplitude: 1.0,
        start: 2.0,
        rate: 3.0,
        speed: 64.0,
    };
    let tone = Tone {
        grid,
        amplitude: 1.0,
        cycles: 20.5,
    };
    let noise = WhiteNoise {
        grid,
        deviation: 1.0,
        seed: 1,
    };
    let impact = LatticeImpact {
        n_times: 64,
        n_sites: 64,
        dt: 0.5,
    };
    let [there, back] = [7, -7].map(sine);
    let problems = [
        ("sine towards +x", there.field(), Some(there.energy())),
        ("sine towards -x", back.field(), Some(back.energy())),
        ("standing wave", standing.field(), Some(standing.energy())),
        ("Gaussian pulse", pulse.field(), Some(pulse.energy())),
        ("linear chirp", chirp.field(), None),
        ("tone between bins", tone.field(), Some(tone.energy())),
        ("white noise", noise.field(), None),
        ("lattice impact", impact.field(), None),
    ];
    let direction = |name: &str| match name {
        "sine towards +x" => Some([1.0, 0.0, 0.0]),
        "sine towards -x" => Some([0.0, 1.0, 0.0]),
        "standing wave" => Some([0.5, 0.5, 0.0]),
        "tone between bins" => Some([0.0, 0.0, 1.0]),
        _ => None,
    };
    let problem = |(name, field, energy)| Problem {
        name,
        field,
        energy,
        direction: direction(name),
    };
    problems.into_iter().map(problem).collect()
}
