//! Fields that are in order, and their analysis.

use ndarray::Array2;
use wavecascade::analyze::{Analysis, Request, Results, Welch};
use wavecascade::chain::{Chain, Ends, Law, Laws, Losses, OnSite, Run, Simulation};
use wavecascade::estimates::Averaging;
use wavecascade::field::OpenOptions;
use wavecascade::{Error, Field, analyze};

use crate::changed;

/// Spectra of sites alone.
pub const TEMPORAL: Results = Results {
    temporal: true,
    ..Results::NONE
};

/// The default request with a change.
pub fn asking(change: impl FnOnce(&mut Request)) -> Request {
    changed(Request::default(), change)
}

/// The default options of reading with a change.
pub fn reading(change: impl FnOnce(&mut OpenOptions)) -> OpenOptions {
    changed(OpenOptions::default(), change)
}

/// Averages over segments of this length and overlap.
pub fn averaging(segment: usize, overlap: usize) -> Averaging {
    Averaging {
        segment: Some(segment),
        overlap: Some(overlap),
        ..Averaging::default()
    }
}

/// The option that an error is about.
#[track_caller]
pub fn option(error: Error) -> &'static str {
    match error {
        Error::Request { option, .. } => option,
        Error::Memory { .. } => "memory",
        other => panic!("{other}"),
    }
}

pub fn analyzed(field: &Field, request: &Request) -> Analysis {
    analyze(field, request).unwrap().0
}

/// Samples that are `dt` and `dx` apart.
pub fn stepped(values: Array2<f64>, dt: f64, dx: f64) -> Field {
    let mut field = Field::from_array(values);
    (field.time.step, field.space.step) = (dt, dx);
    field
}

/// Bodies of these masses and contacts of these coefficients, without anything else.
pub fn chain(mass: Vec<f64>, coefficient: Vec<f64>, law: impl Into<Laws>, ends: Ends) -> Chain {
    Chain {
        mass,
        coefficient,
        law: law.into(),
        ends,
        precompression: 0.0,
        losses: Losses::default(),
        on_site: OnSite::default(),
    }
}

/// `d - alpha d^2 + beta d^3`.
pub const fn spring(alpha: f64, beta: f64) -> Law {
    Law::Spring { alpha, beta }
}

/// Held at both ends, at the left one by a contact of this coefficient.
pub const fn fixed(left_coefficient: f64) -> Ends {
    Ends::Fixed { left_coefficient }
}

/// Losses of all kinds: dashpot, tangent, drag.
pub const fn losses([dashpot, tangent, drag]: [f64; 3]) -> Losses {
    Losses {
        dashpot,
        tangent,
        drag,
    }
}

/// Welch's method in an analysis.
pub const fn segments(segment: usize, overlap: usize) -> Welch {
    Welch { segment, overlap }
}

pub fn struck(sites: usize, end: f64, samples: usize) -> Run {
    let simulation = Simulation::impact(Chain::dimer(sites, 4.9272), 1.0, end, samples);
    simulation.run(&wavecascade::observer::Silent).unwrap()
}

/// A pulse that travels unchanged, `delay` samples a site, and has died down at the end.
pub fn pulse(n_times: usize, n_sites: usize, delay: usize) -> Field {
    Field::from_array(Array2::from_shape_fn((n_times, n_sites), |(n, j)| {
        let t = n as f64 - (40 + delay * j) as f64;
        (-(t / 6.0).powi(2)).exp() * (1.0 + 0.4 * (1.1 * t).cos())
    }))
}

/// Numbers of a linear congruential generator, as the scripts under `tests/data` draw them.
pub struct Congruential(pub u64);

impl Congruential {
    /// In -1 to 1.
    pub fn uniform(&mut self) -> f64 {
        self.0 = (1_103_515_245 * self.0 + 12_345) % (1 << 31);
        self.0 as f64 / f64::from(1 << 30) - 1.0
    }

    /// Twelve of these, whose sum is nearly normal, with variance 4. High bits alone are random.
    pub fn gaussian(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum()
    }

    /// With variance 1.
    pub fn normal(&mut self) -> f64 {
        0.5 * self.gaussian()
    }
}

/// A field of normal noise, from a fixed generator.
pub fn noise(n_times: usize, n_sites: usize) -> Array2<f64> {
    let mut state: u64 = 7;
    let mut uniform = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    };
    Array2::from_shape_fn((n_times, n_sites), |_| {
        let (a, b) = (uniform(), uniform());
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    })
}

impl Congruential {
    /// So many of [`Self::normal`].
    pub fn normals(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.normal()).collect()
    }

    /// A field of [`Self::normal`], row by row.
    pub fn white(&mut self, n_times: usize, n_sites: usize) -> Array2<f64> {
        Array2::from_shape_fn((n_times, n_sites), |_| self.normal())
    }
}

/// Records that follow themselves: each sample has this share of the one before.
pub fn red(mut values: Array2<f64>, memory: f64) -> Array2<f64> {
    for mut record in values.columns_mut() {
        let mut last = 0.0;
        record.mapv_inplace(|v| {
            last = memory * last + v;
            last
        });
    }
    values
}

/// Sums of neighbours with these weights, of the same variance.
pub fn filtered(white: &[f64], weights: &[f64]) -> Vec<f64> {
    let size = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    let sum = |w: &[f64]| w.iter().zip(weights).map(|(a, b)| a * b).sum::<f64>() / size;
    white.windows(weights.len()).map(sum).collect()
}

/// Weights of a band about this frequency in cycles a sample, as wide as a Gaussian of this deviation.
pub fn band(frequency: f64, deviation: f64, reach: i32) -> Vec<f64> {
    let tau = std::f64::consts::TAU;
    let weight =
        |m: f64| (-0.5 * (tau * deviation * m).powi(2)).exp() * (tau * frequency * m).cos();
    (-reach..=reach).map(|m| weight(f64::from(m))).collect()
}

/// A pulse of this width in samples that passes site 0 at `start` and each further one so much later.
pub fn passing(shape: (usize, usize), start: f64, later: f64, width: f64) -> Array2<f64> {
    Array2::from_shape_fn(shape, |(n, j)| {
        let t = (n as f64 - start - later * j as f64) / width;
        (-t * t).exp()
    })
}
