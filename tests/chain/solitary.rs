//! The solitary wave of the homogeneous Hertz chain: launched, and made by an impact.
//!
//! Truth: `data/solitary_wave.json`, the solution of the travelling-wave equation
//! `psi'' = psi(xi - 1)^{3/2} - 2 psi^{3/2} + psi(xi + 1)^{3/2}` made by `data/solitary_wave.py` on
//! 2026-11-21 (Fourier modes, residual 1e-14). A wave of speed c has overlaps
//! `c^4 psi(j - c t)` and velocities `c^5 v(j - c t)`, with `v` the sum of `-psi'` over the sites
//! ahead.

use std::f64::consts::PI;

use test_support::scenes::{apart, data, largest, near};
use wavecascade::chain::{Accuracy, Chain, Record, Simulation};
use wavecascade::observer::Silent;

#[derive(serde::Deserialize)]
struct Wave {
    period: f64,
    modes: Vec<f64>,
    largest_overlap: f64,
    largest_velocity: f64,
    momentum: f64,
    speed_after_impact: f64,
}

impl Wave {
    fn load() -> Wave {
        serde_json::from_value(data("solitary_wave.json")).unwrap()
    }

    /// Overlap and its slope at `xi` for speed 1.
    fn overlap(&self, xi: f64) -> (f64, f64) {
        if xi.abs() >= 0.5 * self.period {
            return (0.0, 0.0);
        }
        let terms = self.modes.iter().enumerate();
        terms.fold((0.0, 0.0), |sum, (m, a)| {
            let k = 2.0 * PI * m as f64 / self.period;
            let (sin, cos) = (k * xi).sin_cos();
            (sum.0 + a * cos, sum.1 - a * k * sin)
        })
    }

    /// Displacement and velocity at `xi` for a speed: nothing has moved far ahead.
    fn motion(&self, speed: f64, xi: f64) -> (f64, f64) {
        let mut sum = (0.0, 0.0);
        let mut at = xi;
        while at < 0.5 * self.period {
            let (psi, slope) = self.overlap(at);
            sum.0 += psi;
            sum.1 -= slope;
            at += 1.0;
        }
        (speed.powi(4) * sum.0, speed.powi(5) * sum.1)
    }

    fn velocity(&self, xi: f64) -> f64 {
        self.motion(1.0, xi).1
    }
}

/// The longest wave of V. F. Nesterenko's continuum has `c = (4/5)^{1/2} delta^{1/4}`; the chain's
/// own is 1.2 % faster at the same overlap.
#[test]
fn val_travelling_wave_equation_its_solution_is_read_right() {
    let wave = Wave::load();
    assert!((wave.overlap(0.0).0 - wave.largest_overlap).abs() < 1e-14);
    assert!((wave.velocity(0.5) - wave.largest_velocity).abs() < 1e-13);
    let sum: f64 = (-20..20).map(|j| wave.velocity(f64::from(j) + 0.3)).sum();
    assert!((sum - wave.momentum).abs() < 1e-13);
    // psi'' from the forces, as a difference of slopes by Simpson's rule.
    let force = |xi: f64| wave.overlap(xi).0.max(0.0).powf(1.5);
    let second = |xi: f64| force(xi - 1.0) - 2.0 * force(xi) + force(xi + 1.0);
    for i in 0..12 {
        let (a, h) = (0.25 * f64::from(i), 2e-3);
        let integral = h / 3.0 * (second(a - h) + 4.0 * second(a) + second(a + h));
        let difference = wave.overlap(a + h).1 - wave.overlap(a - h).1;
        let off = (integral - difference).abs();
        assert!(off < 2e-13, "{a}: {off:e}");
    }
    let speed = wave.largest_overlap.powf(-0.25);
    assert!((speed / 0.8f64.sqrt() - 1.0124).abs() < 1e-4, "{speed}");
}

/// Launched exactly, the wave travels over 200 sites as it is.
#[test]
fn val_travelling_wave_equation_launched_wave_keeps_its_shape() {
    let wave = Wave::load();
    for (tolerance, speed) in [(1e-6, 1.0), (1e-9, 1.0), (1e-11, 1.0), (1e-9, 0.5)] {
        let start = |j: usize, t: f64| wave.motion(speed, j as f64 - 12.0 - speed * t);
        let mut it = Simulation::impact(Chain::dimer(230, 1.0), 0.0, 200.0 / speed, 201);
        for j in 0..230 {
            (it.displacement[j], it.velocity[j]) = start(j, 0.0);
        }
        it.record = Record::default();
        it.accuracy = Accuracy::Tolerance(tolerance);
        let run = it.run(&Silent).unwrap();
        let known = run.velocity.indexed_iter();
        let known = known.map(|((i, j), _)| start(j, run.time[i]).1);
        let worst = apart(&run.velocity, known) / run.report.velocity_scale;
        assert!(worst <= tolerance, "{speed}, {tolerance:e}: {worst:e}");
    }
}

/// Speed and place of the wave that has the momentum and the centre of what moves from site
/// `first` on.
fn fitted(wave: &Wave, velocity: &[f64], first: usize) -> (f64, f64) {
    let momentum: f64 = velocity[first..].iter().sum();
    let speed = (momentum / wave.momentum).powf(0.2);
    let centre = |v: &dyn Fn(usize) -> f64| {
        let moments = (first..velocity.len()).map(|j| (j - first) as f64 * v(j));
        moments.sum::<f64>() / momentum
    };
    let measured = centre(&|j| velocity[j]);
    let mut place = first as f64 + measured;
    for _ in 0..20 {
        place += measured - centre(&|j| wave.motion(speed, j as f64 - place).1);
    }
    (speed, place)
}

/// The leading pulse at one sample, and how far it is from the wave of its momentum.
struct Settled {
    time: f64,
    peak: usize,
    speed: f64,
    place: f64,
    shape: f64,
}

/// An impact makes the wave and leaves the rest behind: from site 100 to 290 its shape is that of
/// the travelling-wave equation, and the speed of that shape is the one it travels at.
#[test]
fn val_travelling_wave_equation_impact_settles_into_the_wave() {
    let wave = Wave::load();
    let mut it = Simulation::impact(Chain::dimer(320, 1.0), 1.0, 350.0, 701);
    it.record = Record::default();
    it.accuracy = Accuracy::Tolerance(1e-11);
    let run = it.run(&Silent).unwrap();
    let rows = run.time.iter().zip(run.velocity.rows());
    let settled = rows.filter_map(|(time, row)| {
        let v = row.to_vec();
        let peak = (0..v.len())
            .rev()
            .max_by(|a, b| v[*a].total_cmp(&v[*b]))
            .unwrap();
        let first = peak.checked_sub(8).filter(|_| (20..=290).contains(&peak))?;
        let (speed, place) = fitted(&wave, &v, first);
        let known = (first..v.len()).map(|j| wave.motion(speed, j as f64 - place).1);
        let (time, shape) = (*time, apart(&v[first..], known));
        Some(Settled {
            time,
            peak,
            speed,
            place,
            shape,
        })
    });
    let settled: Vec<Settled> = settled.collect();
    let worst = |sites: std::ops::RangeInclusive<usize>| {
        let within = settled.iter().filter(|s| sites.contains(&s.peak));
        let off = within.clone().map(|s| s.speed - wave.speed_after_impact);
        (largest(off), largest(within.map(|s| s.shape)))
    };
    // What is left of the impact dies out by a factor of 400 each ten sites.
    let (_, shape) = worst(20..=22);
    assert!((2e-4..1e-3).contains(&shape), "{shape:e}");
    let (_, shape) = worst(40..=42);
    assert!((1e-9..1e-8).contains(&shape), "{shape:e}");
    let (speed, shape) = worst(100..=290);
    assert!(speed < 2e-14 && shape < 4e-13, "{speed:e} {shape:e}");

    let late: Vec<_> = settled.iter().filter(|s| s.peak >= 100).collect();
    assert!(late.len() > 400, "{}", late.len());
    let (first, last) = (late[0], late[late.len() - 1]);
    let travelled = (last.place - first.place) / (last.time - first.time);
    near(travelled, wave.speed_after_impact, 2e-13, "travelled");
}
