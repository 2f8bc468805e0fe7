//! Coherence, phase and delay against SciPy, and against records whose common part is known.

use std::f64::consts::TAU;

use ndarray::{Array2, s};
use test_support::estimate::coherence;
use test_support::fields::{Congruential as Noise, band, filtered, red, stepped};
use test_support::{hold, lies, near, rms, share, worst};
use wavecascade::Field;
use wavecascade::estimates::Coherence;

use crate::peers::{DT, compare};

fn found(words: &str, values: Array2<f64>) -> Coherence {
    apart(words, values, 1.0)
}

/// Of sites that are so far apart.
fn apart(words: &str, values: Array2<f64>, dx: f64) -> Coherence {
    coherence(words, [&stepped(values, DT, dx)]).unwrap()
}

#[test]
fn val_scipy_coherence_of_welch_and_of_tapers() {
    compare("scipy coherence");
}

/// Of independent noise the mean is `1 / K`, and one cell in twenty is above the level; the first by the
/// effective number of overlapping segments, which is not their count.
#[test]
fn val_carter_levels_of_independent_noise() {
    for (overlap, within) in [(0, 0.04), (32, 0.04), (48, 0.06)] {
        let words = format!("segment=64 overlap={overlap}");
        let found = found(&words, Noise(7).white(1024, 400));
        let cells = found.coherence.slice(s![2..31, 1..]);
        let level = found.level().unwrap();
        let mean = cells.mean().unwrap() * found.independence.effective;
        near(mean, 1.0, within);
        near(share(cells.iter().map(|g| *g > level)), 0.05, 0.0075);
    }
}

/// A wave of variance 1 with ten values a sample, up to half of the Nyquist frequency.
fn fine(random: &mut Noise, samples: usize) -> Vec<f64> {
    filtered(&random.normals(10 * samples + 120), &band(0.0, 0.01, 60))
}

/// Records that are shifted by parts of a sample, with noise: delays are found within their standard errors.
#[test]
fn val_delays_are_found_within_their_errors() {
    let mut random = Noise(3);
    let wave = fine(&mut random, 4150);
    let late = |j: usize| if j == 0 { 0 } else { 4 * j as isize - 113 };
    let values = Array2::from_shape_fn((4096, 120), |(n, j)| {
        wave[(10 * n as isize + 400 - late(j)) as usize] + 0.75 * random.normal()
    });
    let delays = found("segment=256 overlap=128", values).delays;
    let scores = delays.iter().enumerate().skip(1).map(|(j, found)| {
        let found = found.unwrap();
        (found.delay - DT * 0.1 * late(j) as f64) / found.error
    });
    // Segments that a delay shifts against one another lose some of their common part.
    lies(rms(scores), 0.8..1.3);
    lies(delays[60].unwrap().error / DT, 0.001..0.1);
    assert_eq!(delays[0].unwrap().delay, 0.0);
}

/// Waves towards +x and -x at one speed, a tenth of a sample a site, with noise.
#[test]
fn val_phase_velocity_of_plane_waves() {
    let dx = 0.05;
    for direction in [1, -1] {
        let mut random = Noise(5);
        let wave = fine(&mut random, 8200);
        let values = Array2::from_shape_fn((8192, 24), |(n, j)| {
            let at = 10 * n as i32 + 40 - direction * j as i32;
            wave[at as usize] + 0.25 * random.normal()
        });
        let speeds = apart("reference=4 segment=128 overlap=64", values, dx).speeds;
        let band = speeds.iter().filter(|s| (0.1..0.5).contains(&s.frequency));
        assert!(band.clone().count() > 10);
        let truth = f64::from(direction) * dx / (0.1 * DT);
        // Errors are those of the phases where residuals are smaller.
        let scores = band.clone();
        let scores = scores.map(|s| (s.velocity - truth) / s.velocity_error);
        lies(rms(scores), 0.5..1.6);
        let off = band.map(|s| (s.velocity / truth - 1.0).abs());
        lies(worst(off), 0.0..0.05);
    }
}

/// Two records of white noise, or of smoothed noise, have nothing in common: one pair in twenty is coherent by chance.
#[test]
fn val_construction_unrelated_records_have_no_delay() {
    for memory in [0.0, 0.9] {
        hold(100, 0..=10, |seed| {
            let values = red(Noise(1000 + 37 * seed).white(2048, 2), memory);
            let found = found("", values);
            assert_eq!(found.is_coherent[1], found.coherent_sites().count() == 1);
            assert!(found.velocity.is_none());
            found.is_coherent[1] || found.delays[1].is_some()
        });
    }
}

/// A site whose record is that of the reference so many samples later, in noise: intervals at 95 % hold as often.
#[test]
fn val_construction_intervals_of_delays_hold() {
    for (memory, noise, late) in [
        (0.0, 0.1, 4),
        (0.0, 0.5, 20),
        (0.0, 1.0, 0),
        (0.9, 0.3, 7),
        (-0.6, 0.3, 3),
    ] {
        hold(100, 91..=99, |seed| {
            let source = red(Noise(77 + 1031 * seed).white(2100, 1), memory);
            let source = source * (1.0f64 - memory * memory).sqrt();
            let beside = Noise(5 + 911 * seed).white(2048, 2) * noise;
            let values = Array2::from_shape_fn((2048, 2), |(n, j)| {
                source[[n + late * (1 - j), 0]] + beside[[n, j]]
            });
            let delay = found("", values).delays[1].unwrap();
            assert_eq!(delay.ambiguity, None);
            near(delay.interval / delay.error, 1.96, 0.001);
            (delay.delay - DT * late as f64).abs() < delay.interval
        });
    }
}

/// Shots of pulses that are later than a segment by default, under a window and without one.
#[test]
fn val_construction_shots_are_whole() {
    for window in ["none", "hann"] {
        let mut held = Vec::new();
        for seed in 0..100 {
            let mut random = Noise(41 + 907 * seed);
            let late = 210.0 + 90.0 * random.uniform();
            let mut shot = || {
                let start = 300.0 + 20.0 * random.normal();
                let values = Array2::from_shape_fn((1024, 2), |(n, j)| {
                    let t = (n as f64 - start - late * j as f64) / 8.0;
                    t * (-0.5 * t * t).exp() + 0.06 * random.normal()
                });
                stepped(values, DT, 1.0)
            };
            let shots: Vec<Field> = (0..8).map(|_| shot()).collect();
            let found = coherence(&format!("window={window}"), &shots).unwrap();
            let delay = found.delays[1].filter(|delay| delay.ambiguity.is_none());
            held.extend(delay.map(|found| (found.delay - DT * late).abs() < found.interval));
        }
        let missed = held.iter().filter(|held| !**held).count();
        assert!(held.len() > 90 && (1..=8).contains(&missed), "{held:?}");
    }
}

/// Of 32 independent segments, where a third of the cells is above the level: some by chance.
#[test]
fn val_construction_phases_of_a_weak_coherence() {
    let part = 0.05f64;
    let mut values = Noise(6).white(2048, 200);
    for mut row in values.rows_mut() {
        let common = part.sqrt() * row[0];
        let mut others = row.slice_mut(s![1..]);
        others.mapv_inplace(|v| common + (1.0 - part).sqrt() * v);
    }
    let found = found("segment=64 overlap=0 window=none", values);
    let phases = found.phase.slice(s![1..32, 1..]);
    let cells = phases
        .iter()
        .zip(found.phase_interval.slice(s![1..32, 1..]));
    let stated = cells.filter(|(_, half)| half.is_finite());
    assert!(stated.clone().count() > 1000);
    let held = stated.map(|(phase, half)| phase.abs() < *half);
    lies(share(held), 0.92..0.98);
}

/// The phase of a tone gives its delay up to whole periods.
#[test]
fn val_construction_the_delay_of_a_tone_states_its_period() {
    for (seed, late) in [(1, 3.0), (2, 13.7), (3, 150.2), (4, -41.0)] {
        let mut random = Noise(seed);
        let period = 17.3;
        let values = Array2::from_shape_fn((4096, 2), |(n, j)| {
            (TAU * (n as f64 - late * j as f64) / period).sin() + 0.04 * random.normal()
        });
        let found = found("", values);
        assert!(found.is_coherent[1]);
        let delay = found.delays[1].unwrap();
        let stated = delay.ambiguity.unwrap();
        near(stated / (DT * period), 1.0, 0.01);
        assert!(delay.delay.abs() <= 0.51 * stated);
        let cycles = (delay.delay - DT * late) / (DT * period);
        near(cycles, cycles.round(), 0.01);
    }
}

/// White noise that passes sites at 25 m/s, so much of it the other way, in noise of a tenth.
fn passes(seed: u64, sites: usize, [there, back]: [f64; 2]) -> Field {
    let mut random = Noise(seed);
    let source = random.white(2200, 2);
    let values = Array2::from_shape_fn((2048, sites), |(n, j)| {
        let [to, fro] = [source[[n + 100 - 4 * j, 0]], source[[n + 4 * j, 1]]];
        there * to + back * fro + 0.1 * random.normal()
    });
    stepped(values, 1e-3, 0.1)
}

/// Sites that hear one source, though those above 125 Hz are more than half a wavelength apart; the interval holds the velocity at 95 %.
#[test]
fn val_construction_one_velocity_of_a_wave() {
    for (ways, truth) in [([1.0, 0.0], 25.0), ([0.0, 1.0], -25.0)] {
        hold(60, 54..=60, |seed| {
            let field = passes(9 + 733 * seed, 8, ways);
            let found = coherence("reference=2", [&field]).unwrap();
            let velocity = found.velocity.unwrap();
            assert_eq!(velocity.sites, Some(7));
            assert!(!velocity.is_dispersive && !found.is_both_ways);
            near(velocity.velocity / truth, 1.0, 0.002);
            // Phases are continued by the delays.
            let speeds = found.speeds.iter().filter(|s| s.frequency > 20.0);
            let off = speeds.map(|s| (s.velocity / truth - 1.0).abs());
            lies(worst(off), 0.0..0.3);
            (velocity.low..velocity.high).contains(&truth)
        });
    }
}

/// Independent noise that runs both ways at one speed, as loud: no delay and no velocity.
#[test]
fn val_theory_equal_waves_both_ways_have_no_direction() {
    for seed in 0..20 {
        let field = passes(31 + 517 * seed, 12, [1.0, 1.0]);
        let found = coherence("", [&field]).unwrap();
        assert!(found.is_both_ways && found.velocity.is_none(), "{seed}");
        assert!(found.delays.iter().all(Option::is_none), "{seed}");
    }
}

/// A standing wave has no phase velocity; a tone that travels has one.
#[test]
fn val_construction_a_standing_wave_has_no_velocity() {
    for seed in 1..30 {
        let mut random = Noise(seed);
        let mut wave = |of: fn(f64, f64) -> f64| {
            let values = Array2::from_shape_fn((4096, 8), |(n, j)| {
                let (t, x) = (n as f64 * 0.05 * TAU, 0.9 * j as f64 + 0.2);
                of(t, x) + 0.02 * random.normal()
            });
            apart("", values, 0.1)
        };
        let standing = wave(|t, x| t.cos() * x.cos());
        assert!(standing.coherent_sites().count() > 5);
        assert!(standing.velocity.is_none(), "{:?}", standing.velocity);
        let mut delays = standing.delays[1..].iter().flatten();
        assert!(delays.all(|delay| delay.ambiguity.is_some()), "{seed}");
        let velocity = wave(|t, x| (t - x).cos()).velocity.unwrap();
        let truth = TAU * 0.05 / DT / (0.9 / 0.1);
        lies(truth, velocity.low..velocity.high);
        assert!(velocity.high - velocity.low < 0.1 * truth);
    }
}

/// A wave of a narrow band, a Gaussian of 0.02 about 0.08 cycles a sample, that passes 16 sites at 6 samples a site: segments of 256
/// samples are shifted by up to a third. The delays have no bias, and the intervals of the speed hold in 36 of 40 fields or more.
#[test]
fn val_delays_of_a_narrow_band_have_no_bias() {
    let mut noise = Noise(77);
    let (mut off, mut held) = (Vec::new(), Vec::new());
    for _ in 0..40 {
        let wave = filtered(&noise.normals(2348), &band(0.08, 0.02, 60));
        let values = Array2::from_shape_fn((2048, 16), |(n, j)| {
            wave[n + 96 - 6 * j] + 0.02 * noise.normal()
        });
        let found = found("segment=256 overlap=128", values);
        for (j, delay) in found.delays.iter().enumerate().skip(6) {
            let delay = delay.filter(|delay| delay.ambiguity.is_none());
            off.extend(delay.map(|delay| delay.delay / (6.0 * DT * j as f64) - 1.0));
        }
        let speed = found.velocity;
        held.extend(speed.map(|it| (it.low..=it.high).contains(&(1.0 / (6.0 * DT)))));
    }
    let bias = off.iter().sum::<f64>() / off.len() as f64;
    assert!(off.len() > 200 && held.len() >= 38, "{held:?}");
    near(bias, 0.0, 2e-3);
    let missed = held.iter().filter(|held| !**held).count();
    assert!(missed <= 4, "{held:?}");
}

/// Flexural waves, `omega = b k^2`, at two sites: the group delay is `d / (2 sqrt(b omega))`, less at high frequencies. Of waves with one
/// speed it depends on no frequency.
#[test]
fn val_theory_the_delay_of_flexural_waves_depends_on_frequency() {
    let (b, dx) = (3.0, 1.5);
    let mut told = 0;
    for seed in 0..20 {
        let mut random = Noise(77 + 91 * seed);
        let mut wave = |i: u32| {
            let f = 0.1 + 0.9 * (f64::from(i) + random.uniform()) / 240.0;
            [TAU * f, random.normal(), random.normal()]
        };
        let waves: Vec<[f64; 3]> = (0..240).map(&mut wave).collect();
        for is_dispersive in [true, false] {
            let values = Array2::from_shape_fn((4096, 2), |(n, j)| {
                let of = |[w, p, q]: &[f64; 3]| {
                    let k = [w / 4.0, (w / b).sqrt()][usize::from(is_dispersive)];
                    let (sin, cos) = (w * DT * n as f64 - k * dx * j as f64).sin_cos();
                    p * cos + q * sin
                };
                waves.iter().map(of).sum::<f64>() + random.normal()
            });
            let delay = apart("", values, dx).delays[1].unwrap();
            if let Some([low, high]) = delay.by_frequency {
                assert!(is_dispersive && low[1] > high[1], "{seed}: {delay:?}");
                for [frequency, delay] in [low, high] {
                    let theory = dx / (2.0 * (b * TAU * frequency).sqrt());
                    near(delay / theory, 1.0, 0.25);
                }
                told += 1;
            }
        }
    }
    assert!(told >= 15, "{told}");
}
