//! The reference problems are what they say: checked without any fast transform.

use std::f64::consts::PI;

use test_support::changed;
use wavecascade::field::Field;
use wavecascade::reference::{Grid, GrowingHarmonic, LatticeImpact, WhiteNoise, bessel_j};

const GRID: Grid = Grid {
    n_times: 256,
    n_sites: 48,
    dt: 1.0 / 64.0,
    dx: 0.5,
};

fn samples(field: &Field) -> Vec<f64> {
    let (times, sites) = (field.n_times(), field.n_sites());
    let mut values = vec![0.0; times * sites];
    field.read_time_major(0..times, 0..sites, &mut values);
    values
}

fn record(field: &Field, site: usize) -> Vec<f64> {
    let mut values = vec![0.0; field.n_times()];
    field.read_site_major(0..field.n_times(), site..site + 1, &mut values);
    values
}

/// Achieved: 1.5e-16.
#[test]
fn val_mpmath_bessel() {
    let data: serde_json::Value =
        serde_json::from_str(include_str!("../data/bessel.json")).unwrap();
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        let list = value.as_array().unwrap();
        list.iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let orders = numbers(&data["orders"]);
    for point in data["points"].as_array().unwrap() {
        let x = point["x"].as_f64().unwrap();
        let found = bessel_j(x, 401);
        for (order, expected) in orders.iter().zip(numbers(&point["values"])) {
            let error = found[*order as usize] - expected;
            assert!(error.abs() < 3e-16, "J_{order}({x}): {error:e}");
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
    let field = impact.field();
    let values = samples(&field);
    for n in [0, 1, 7, 80, 160] {
        let t = field.time.at(n);
        let row = &values[n * impact.n_sites..][..impact.n_sites];
        let both_sides = |f: &dyn Fn(usize) -> f64| {
            let right: f64 = (1..impact.n_sites).map(f).sum();
            f(0) + 2.0 * right
        };
        let squares = both_sides(&|j| row[j] * row[j]);
        assert!((squares - 0.5 * (1.0 + bessel_j(4.0 * t, 1)[0])).abs() < 3e-15);
        for k in [0.0, 0.3, 1.0, 2.0, PI] {
            let transform = both_sides(&|j| row[j] * (k * j as f64).cos());
            let error = transform - (2.0 * (0.5 * k).sin() * t).cos();
            assert!(error.abs() < 2e-14, "{t} {k}: {error:e}");
        }
    }
}

/// Energy goes from one harmonic to the other and stays the same: `sum v^2 dt = A^2 sigma sqrt(pi) / 2` at each site.
#[test]
fn val_armstrong_a_growing_harmonic_keeps_its_energy() {
    let wave = changed(GrowingHarmonic::EXAMPLE, |it| it.noise = 0.0);
    let field = wave.field();
    for site in [0, 40, 95] {
        let energy: f64 = record(&field, site)
            .iter()
            .map(|v| v * v * wave.grid.dt)
            .sum();
        // What the harmonics have in common leaves 8e-6.
        let expected = 0.5 * wave.amplitude.powi(2) * wave.width * PI.sqrt();
        let error = energy / expected - 1.0;
        assert!(error.abs() < 1e-5, "{site}: {error:e}");
    }
}

#[test]
fn noise_is_white_and_comes_from_its_seed() {
    let noise = |seed| WhiteNoise {
        grid: GRID,
        deviation: 0.5,
        seed,
    };
    let values = samples(&noise(1).field());
    assert_eq!(values, samples(&noise(1).field()));
    assert_ne!(values, samples(&noise(2).field()));
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| v * v).sum::<f64>() / count;
    let neighbours = values.windows(2).map(|v| v[0] * v[1]).sum::<f64>() / count;
    let sigmas = 4.0 / count.sqrt();
    assert!(mean.abs() < 0.5 * sigmas);
    assert!((variance / 0.25 - 1.0).abs() < 0.9 * sigmas);
    assert!((neighbours / 0.25).abs() < sigmas);
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
    let exact = samples(&impact.field());
    assert_eq!(stored.len(), exact.len());
    for (bytes, v) in stored.zip(exact) {
        let v_stored = f64::from(f32::from_le_bytes(bytes.try_into().unwrap()));
        assert!((v_stored - v).abs() < 3.1e-8);
    }
}
