//! The reference problems are what they say: checked without any fast transform.

use std::f64::consts::PI;

use test_support::estimate::flat;
use test_support::made::values;
use test_support::{changed, near};
use wavecascade::reference::{Grid, GrowingHarmonic, LatticeImpact, WhiteNoise, bessel_j};

use crate::peers::data;

/// Achieved: 1.5e-16.
#[test]
fn val_mpmath_bessel() {
    let data = data("bessel.json");
    let orders = flat(&data["orders"]);
    for point in data["points"].as_array().unwrap() {
        let found = bessel_j(flat(&point["x"])[0], 401);
        for (order, expected) in orders.iter().zip(flat(&point["values"])) {
            near(found[*order as usize], expected, 3e-16);
        }
    }
}

/// `sum_j v_j exp(i k j) = cos(omega(k) t)` and `sum_j v_j^2 = (1 + J_0(4 t)) / 2`.
#[test]
fn the_struck_lattice_disperses_as_its_equation_of_motion_says() {
    let impact = LatticeImpact {
        n_times: 161,
        n_sites: 120,
        dt: 0.5,
    };
    let values = values(&impact.field());
    for n in [0, 1, 7, 80, 160] {
        let (t, row) = (impact.dt * n as f64, values.row(n));
        let both_sides = |f: &dyn Fn(usize) -> f64| f(0) + 2.0 * (1..120).map(f).sum::<f64>();
        let squares = both_sides(&|j| row[j] * row[j]);
        near(squares, 0.5 * (1.0 + bessel_j(4.0 * t, 1)[0]), 3e-15);
        for k in [0.0, 0.3, 1.0, 2.0, PI] {
            let transform = both_sides(&|j| row[j] * (k * j as f64).cos());
            near(transform, (2.0 * (0.5 * k).sin() * t).cos(), 2e-14);
        }
    }
}

/// Energy goes from one harmonic to the other and stays the same: `sum v^2 dt = A^2 sigma sqrt(pi) / 2` at each site.
#[test]
fn val_armstrong_a_growing_harmonic_keeps_its_energy() {
    let wave = changed(GrowingHarmonic::EXAMPLE, |it| it.noise = 0.0);
    let values = values(&wave.field());
    for site in [0, 40, 95] {
        let record = values.column(site);
        let energy = record.dot(&record) * wave.grid.dt;
        // What the harmonics have in common leaves 8e-6.
        let expected = 0.5 * wave.amplitude.powi(2) * wave.width * PI.sqrt();
        near(energy / expected, 1.0, 1e-5);
    }
}

#[test]
fn noise_is_white_and_comes_from_its_seed() {
    let noise = |seed| {
        let grid = Grid {
            n_times: 256,
            n_sites: 48,
            dt: 1.0 / 64.0,
            dx: 0.5,
        };
        let noise = WhiteNoise {
            grid,
            deviation: 0.5,
            seed,
        };
        values(&noise.field())
    };
    let values = noise(1);
    assert_eq!(values, noise(1));
    assert_ne!(values, noise(2));
    let values = values.as_slice().unwrap();
    let count = values.len() as f64;
    let sigmas = 4.0 / count.sqrt();
    near(values.iter().sum::<f64>() / count, 0.0, 0.5 * sigmas);
    let variance = values.iter().map(|v| v * v).sum::<f64>() / count;
    near(variance / 0.25, 1.0, 0.9 * sigmas);
    let neighbours = values.windows(2).map(|v| v[0] * v[1]).sum::<f64>() / count;
    near(neighbours / 0.25, 0.0, sigmas);
}

#[test]
fn the_shipped_field_is_the_struck_lattice() {
    let impact = LatticeImpact {
        n_times: 768,
        n_sites: 96,
        dt: 0.125,
    };
    let file = include_bytes!("../../examples/data/lattice_impact.npy");
    let stored = file[128..].chunks_exact(4);
    let exact = values(&impact.field());
    assert_eq!(stored.len(), exact.len());
    for (bytes, v) in stored.zip(exact) {
        let stored = f32::from_le_bytes(bytes.try_into().unwrap());
        near(stored.into(), v, 3.1e-8);
    }
}
