//! A field to analyze: a pulse that travels to +x.

use std::fs;

use ndarray::Array2;

use super::place::Place;

pub const SIDECAR: &str =
    "dt = 0.01\ndx = 0.5\ntime_unit = \"s\"\nspace_unit = \"m\"\nunit = \"m/s\"\n";

/// A folder with the pulse, `wave.npy`, and its sidecar.
pub fn place() -> Place {
    let place = Place::new();
    place.save("wave.npy", &wave(96, 12));
    fs::write(place.path("wave.toml"), SIDECAR).unwrap();
    place
}

pub fn wave(n_times: usize, n_sites: usize) -> Array2<f64> {
    Array2::from_shape_fn((n_times, n_sites), |(i, j)| {
        let s = i as f64 - 2.0 * j as f64 - 24.0;
        (-(s / 8.0).powi(2)).exp() * (0.7 * s).sin()
    })
}
