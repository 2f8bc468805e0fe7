//! Fields for estimates, which sessions use.

use std::f64::consts::TAU;

use ndarray::Array2;
use test_support::fields::noise;
use test_support::place::Place;

/// Fields of which one thing is known each.
pub fn fields(place: &Place) {
    let random = noise(4100, 12);
    let mut low = [0.0; 2];
    let quadratic = Array2::from_shape_fn((4096, 2), |(n, j)| {
        low[j] = 0.7 * low[j] + random[[n, 0]];
        match j {
            0 => low[0],
            _ => low[1] + 0.2 * low[1] * low[1] + 0.05 * random[[n, 1]],
        }
    });
    let delayed = Array2::from_shape_fn((4096, 3), |(n, j)| match j {
        0 => random[[n + 3, 0]] + 0.2 * random[[n, 1]],
        1 => random[[n, 0]] + 0.2 * random[[n, 2]],
        _ => random[[n, 3]],
    });
    let mut walk = noise(256, 32);
    for mut row in walk.outer_iter_mut() {
        let mut sum = 0.0;
        row.mapv_inplace(|step| {
            sum += step;
            sum
        });
    }
    let wave = Array2::from_shape_fn((2048, 12), |(n, j)| {
        (0.7 * j as f64 - TAU * 0.125 * n as f64).cos() + 0.2 * random[[n, j]]
    });
    // Of speed 2 both ways.
    let waves = Array2::from_shape_fn((1024, 48), |(n, j)| {
        let wave = |m: usize| {
            let f = 0.05 + 0.002 * m as f64;
            let sign = if m.is_multiple_of(2) { 1.0 } else { -1.0 };
            let phase = 7.3 * (m * m) as f64;
            (TAU * f * (n as f64 - sign * j as f64 / 2.0) + phase).cos()
        };
        (0..200).map(wave).sum::<f64>() + random[[n + j, j % 12]]
    });
    let law = Array2::from_shape_fn((20, 128), |(i, j)| {
        let term = |m: usize| (TAU * (m * j) as f64 / 128.0 + (i * m * m) as f64).cos() / m as f64;
        (1..60).map(term).sum::<f64>()
    });
    let line = Array2::from_shape_fn((2048, 5), |(n, j)| {
        let line = (TAU * 300.0 / 2048.0 * n as f64).cos();
        random[[n, j]] + if j == 1 { line } else { 0.0 }
    });
    for (name, values) in [
        ("quadratic", quadratic),
        ("delayed", delayed),
        ("walk", walk),
        ("wave", wave),
        ("waves", waves),
        ("law", law),
        ("line", line),
    ] {
        place.save(&format!("{name}.npy"), &values);
    }
    let scene = "sites = 16\nlaw = 'spring'\nalpha = 0.25\nends = 'fixed'\nmode = 1\nmode_amplitude = 1.0\n\
                 end_time = 60.0\nsamples = 512\n";
    place.write("fput.toml", scene);
    place.says("simulate fput.toml --out fput.npz --quiet");
}
