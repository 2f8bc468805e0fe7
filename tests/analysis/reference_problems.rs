//! The reference problems are what they say: checked without any fast transform.

use std::f64::consts::PI;

use test_support::changed;
use test_support::shared::dft_dd;
use wavecascade::field::Field;
use wavecascade::reference::{
    GaussianPulse, Grid, GrowingHarmonic, LatticeImpact, LinearChirp, Tone, TravellingSine,
    WhiteNoise, bessel_j, problems,
};

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
        assert!((squares - LatticeImpact::square_sum(t)).abs() < 3e-15);
        for k in [0.0, 0.3, 1.0, 2.0, PI] {
            let transform = both_sides(&|j| row[j] * (k * j as f64).cos());
            let error = transform - LatticeImpact::transform(k, t);
            assert!(error.abs() < 2e-14, "{t} {k}: {error:e}");
        }
    }
}

/// Energy goes from one harmonic to the other and stays the same: `d a1 / dx = -s a1 a2`, `d a2 / dx = s a1^2`.
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
        let error = energy / wave.site_energy() - 1.0;
        assert!(error.abs() < 1e-5, "{site}: {error:e}");
    }
    let (a, x, h) = (0.07, 0.3, 1e-5);
    let at = |x: f64| wave.shares(a, x).map(|share| a * share);
    let ([a1, a2], [before, after]) = (at(x), [at(x - h), at(x + h)]);
    let slope = |i: usize| (after[i] - before[i]) / (2.0 * h);
    assert!((slope(0) + wave.growth * a1 * a2).abs() < 1e-9);
    assert!((slope(1) - wave.growth * a1 * a1).abs() < 1e-9);
}

#[test]
fn energies_are_as_stated() {
    for problem in problems() {
        let Some(energy) = problem.energy else {
            continue;
        };
        let cell = problem.field.time.step * problem.field.space.step;
        let squares: f64 = samples(&problem.field).iter().map(|v| v * v).sum();
        let error = squares * cell / energy - 1.0;
        assert!(error.abs() < 1e-13, "{}: {error:e}", problem.name);
    }
}

/// All of the energy is on one pair of bins, `(m, l)` and its mirror image, under the kernel
/// `exp(-2 pi i f t) exp(+i k x)`.
#[test]
fn a_travelling_sine_has_one_bin_on_its_own_side() {
    for l in [5_isize, -5] {
        let sine = TravellingSine {
            grid: GRID,
            amplitude: 3.0,
            frequency_bin: 9,
            wavenumber_bin: l,
        };
        let values = samples(&sine.field());
        let (mut re, mut im) = (0.0, 0.0);
        for (at, v) in values.iter().enumerate() {
            let (n, j) = (at / GRID.n_sites, at % GRID.n_sites);
            let t = n as f64 * GRID.dt;
            let x = j as f64 * GRID.dx;
            let phase = sine.wavenumber() * x - 2.0 * PI * sine.frequency() * t;
            re += v * phase.cos();
            im += v * phase.sin();
        }
        let whole = sine.energy() / (GRID.dt * GRID.dx);
        let share = 2.0 * (re * re + im * im) / values.len() as f64 / whole;
        assert!((share - 1.0).abs() < 1e-13, "{l}: {share}");
    }
}

#[test]
fn a_tone_between_bins_leaks_as_its_closed_form_says() {
    for cycles in [20.5, 3.25, 17.0] {
        let tone = Tone {
            grid: GRID,
            amplitude: 2.0,
            cycles,
        };
        let bins: Vec<usize> = (0..=128).collect();
        let transform = dft_dd(&record(&tone.field(), 3), &bins);
        for (bin, (re, im)) in bins.iter().zip(transform) {
            let expected = tone.transform(*bin);
            let error = (re - expected.re).hypot(im - expected.im);
            assert!(error < 1e-12, "{cycles} {bin}: {error:e}");
        }
    }
}

#[test]
fn a_gaussian_pulse_has_a_gaussian_spectrum_at_every_site() {
    let pulse = GaussianPulse {
        grid: GRID,
        amplitude: 2.0,
        width: 0.06,
        arrival: 0.8,
        speed: 10.0,
    };
    let bins: Vec<usize> = (1..128).collect();
    for site in [0, 31] {
        let transform = dft_dd(&record(&pulse.field(), site), &bins);
        for (bin, (re, im)) in bins.iter().zip(transform) {
            let frequency = *bin as f64 / GRID.duration();
            let found = 2.0 * (re * re + im * im) * GRID.dt.powi(2);
            let error = found - pulse.spectrum(frequency);
            assert!(
                error.abs() < 1e-13 * pulse.spectrum(0.0),
                "{bin}: {error:e}"
            );
        }
    }
}

#[test]
fn a_chirp_turns_as_often_as_its_frequency_says() {
    let chirp = LinearChirp {
        grid: GRID,
        amplitude: 1.0,
        start: 2.0,
        rate: 3.0,
        speed: 50.0,
    };
    let values = record(&chirp.field(), 10);
    let x = 10.0 * GRID.dx;
    let crossings = values.windows(2).filter(|v| v[0] * v[1] < 0.0).count() as f64;
    let mean = 0.5 * (chirp.frequency(0.0, x) + chirp.frequency(GRID.duration(), x));
    assert!((crossings - 2.0 * mean * GRID.duration()).abs() <= 1.0);
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
