//! Coherence, phase and delay against SciPy (`data/coherence.json`, made by `data/make_coherence.py`), and
//! against records whose common part is known.

use ndarray::{Array2, s};
use serde::Deserialize;
use test_support::fields::{Congruential as Noise, averaging, stepped};
use wavecascade::Field;
use wavecascade::estimates::{Averaging, Coherence, CoherenceRequest, Tapers, coherence};
use wavecascade::observer::Silent;
use wavecascade::prepare::Window;

const DT: f64 = 0.25;

fn field(values: Array2<f64>, dx: f64) -> Field {
    stepped(values, DT, dx)
}

fn found(field: &Field, request: &CoherenceRequest) -> Coherence {
    coherence(&[field], request, &Silent).unwrap()
}

fn welch(segment: usize, overlap: usize) -> CoherenceRequest {
    CoherenceRequest {
        averaging: averaging(segment, overlap),
        ..CoherenceRequest::default()
    }
}

/// The records of `make_coherence.py`.
fn records() -> Array2<f64> {
    let (mut a, mut b) = (Noise(1), Noise(2));
    let a: Vec<f64> = (0..1003).map(|_| a.uniform()).collect();
    let b: Vec<f64> = (0..1000).map(|_| b.uniform()).collect();
    Array2::from_shape_fn((1000, 3), |(n, j)| match j {
        0 => a[n + 3],
        1 => a[n] + 0.5 * b[n],
        _ => b[n],
    })
}

#[derive(Deserialize)]
struct Expected {
    spectrum: [Vec<f64>; 3],
    coherence: [Vec<f64>; 3],
    phase: [Vec<f64>; 3],
}

#[derive(Deserialize)]
struct Reference {
    welch: Expected,
    welch_96: Expected,
    multitaper: Expected,
}

#[test]
fn val_scipy_coherence_of_welch_and_of_tapers() {
    let reference: Reference =
        serde_json::from_str(include_str!("../data/coherence.json")).unwrap();
    let tapers = Averaging {
        segment: Some(200),
        tapers: Tapers::Slepian { nw: 4.0, count: 7 },
        ..Averaging::default()
    };
    let all = records();
    for (expected, averaging, times) in [
        (&reference.welch, averaging(128, 64), 1000),
        (&reference.welch_96, averaging(128, 96), 1000),
        (&reference.multitaper, tapers, 200),
    ] {
        let field = field(all.slice(s![..times, ..]).to_owned(), 1.0);
        let request = CoherenceRequest {
            averaging,
            ..CoherenceRequest::default()
        };
        let found = found(&field, &request);
        let mut worst = [0.0f64; 3];
        for j in 0..3 {
            let largest = expected.spectrum[j].iter().fold(0.0, |m: f64, v| m.max(*v));
            assert_eq!(expected.spectrum[j].len(), found.frequency.len());
            for m in 0..found.frequency.len() {
                let spectrum = (found.spectrum[[m, j]] - expected.spectrum[j][m]) / largest;
                let coherence = found.coherence[[m, j]] - expected.coherence[j][m];
                worst[0] = worst[0].max(spectrum.abs());
                worst[1] = worst[1].max(coherence.abs());
                // The phase of nothing is rounding.
                if expected.coherence[j][m] > 1e-3 && m > 0 {
                    let difference = found.phase[[m, j]] - expected.phase[j][m];
                    worst[2] = worst[2].max((difference / 2.0).sin().abs());
                }
            }
        }
        assert!(
            worst[0] < 2e-14 && worst[1] < 1e-14 && worst[2] < 1e-13,
            "{worst:?}"
        );
    }
}

/// Of independent noise the mean is `1 / K`, and one cell in twenty is above the level; the first by the
/// effective number of overlapping segments, which is not their count.
#[test]
fn val_carter_levels_of_independent_noise() {
    for (length, overlap, within) in [(64, 0, 0.04), (64, 32, 0.04), (64, 48, 0.06)] {
        let mut noise = Noise(7);
        let values = Array2::from_shape_fn((1024, 400), |_| noise.gaussian());
        let request = welch(length, overlap);
        let found = found(&field(values, 1.0), &request);
        let cells = found.coherence.slice(s![2..31, 1..]);
        let mean = cells.mean().unwrap() * found.independence.effective;
        let level = found.level().unwrap();
        let above = cells.iter().filter(|g| **g > level).count() as f64 / cells.len() as f64;
        assert!((mean - 1.0).abs() < within, "{overlap}: {mean}");
        assert!((above / 0.05 - 1.0).abs() < 0.15, "{overlap}: {above}");
    }
}

/// Band-limited records that are shifted by parts of a sample, with noise: delays are found within their
/// standard errors.
#[test]
fn val_delays_are_found_within_their_errors() {
    let (n, sites) = (4096, 120);
    let mut random = Noise(3);
    let waves: Vec<[f64; 2]> = (1..1600)
        .map(|_| [random.gaussian(), random.gaussian()])
        .collect();
    let delay = |j: usize| 0.37 * j as f64 - 11.3;
    let noise = Array2::from_shape_fn((n, sites), |_| 30.0 * random.gaussian());
    let cos: Vec<[f64; 2]> = (0..n * 100)
        .map(|i| {
            let angle = std::f64::consts::TAU * i as f64 / (n * 100) as f64;
            [angle.cos(), angle.sin()]
        })
        .collect();
    // Hundredths of a sample.
    let wave = |at: usize| -> f64 {
        let term = |(m, [a, b]): (usize, &[f64; 2])| {
            let [c, s] = cos[(m + 1) * at % (n * 100)];
            a * c + b * s
        };
        waves.iter().enumerate().map(term).sum()
    };
    let values = Array2::from_shape_fn((n, sites), |(t, j)| {
        let late = (100.0 * (t as f64 - if j == 0 { 0.0 } else { delay(j) })).round();
        wave(late.rem_euclid(100.0 * n as f64) as usize) + noise[[t, j]]
    });
    let request = welch(256, 128);
    let found = found(&field(values, 1.0), &request);
    let scores: Vec<f64> = (1..sites)
        .map(|j| {
            let found = found.delays[j].unwrap();
            (found.delay - DT * delay(j)) / found.error
        })
        .collect();
    let spread = (scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64).sqrt();
    let error = found.delays[60].unwrap().error / DT;
    // Segments that a delay shifts against one another lose some of their common part.
    assert!((0.8..1.3).contains(&spread), "{spread}");
    assert!((0.001..0.1).contains(&error), "{error}");
    assert_eq!(found.delays[0].unwrap().delay, 0.0);
}

/// Waves towards +x at one speed, with noise.
#[test]
fn val_phase_velocity_of_plane_waves() {
    let (n, sites, speed, dx) = (8192, 24, 1.7, 0.05);
    for direction in [1.0, -1.0] {
        let mut random = Noise(5);
        let waves: Vec<[f64; 3]> = (1..400)
            .map(|m| {
                let f = m as f64 / 400.0 + 0.001 * random.uniform();
                [f, random.gaussian(), random.gaussian()]
            })
            .collect();
        let values = Array2::from_shape_fn((n, sites), |(t, j)| {
            let late = DT * t as f64 - direction * dx * j as f64 / speed;
            let wave = |w: &[f64; 3]| {
                let angle = std::f64::consts::TAU * w[0] * late;
                w[1] * angle.cos() + w[2] * angle.sin()
            };
            waves.iter().map(wave).sum::<f64>() + 5.0 * random.gaussian()
        });
        let request = CoherenceRequest {
            reference: 4,
            averaging: averaging(128, 64),
            ..CoherenceRequest::default()
        };
        let found = found(&field(values, dx), &request);
        let band: Vec<_> = found
            .speeds
            .iter()
            .filter(|s| (0.1..0.9).contains(&s.frequency))
            .collect();
        assert!(band.len() > 20, "{}", band.len());
        let scores: Vec<f64> = band
            .iter()
            .map(|s| (s.velocity - direction * speed) / s.velocity_error)
            .collect();
        let spread = (scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64).sqrt();
        let worst = band
            .iter()
            .map(|s| (s.velocity / speed - direction).abs())
            .fold(0.0, f64::max);
        // Errors are those of the phases where residuals are smaller.
        assert!((0.5..1.6).contains(&spread), "{spread}");
        assert!(worst < 0.05, "{worst}");
    }
}

/// Two records of white noise, or of smoothed noise, have nothing in common: one pair in twenty is coherent by chance.
#[test]
fn val_construction_unrelated_records_have_no_delay() {
    for memory in [0.0, 0.9] {
        let mut found_any = 0;
        for seed in 0..100 {
            let mut random = Noise(1000 + 37 * seed);
            let mut last = [0.0; 2];
            let values = Array2::from_shape_fn((2048, 2), |(_, j)| {
                last[j] = memory * last[j] + random.gaussian();
                last[j]
            });
            let found = found(&field(values, 1.0), &CoherenceRequest::default());
            assert_eq!(found.is_coherent[1], found.coherent_sites().count() == 1);
            assert!(found.velocity.is_none());
            found_any += usize::from(found.is_coherent[1] || found.delays[1].is_some());
        }
        assert!(found_any <= 10, "{memory}: {found_any}");
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
        let mut held = 0;
        for seed in 0..100 {
            let mut random = Noise(77 + 1031 * seed);
            let mut last = 0.0;
            let mut next = || {
                last = memory * last + random.gaussian() * (1.0f64 - memory * memory).sqrt();
                last
            };
            let source: Vec<f64> = (0..2100).map(|_| next()).collect();
            let mut random = Noise(5 + 911 * seed);
            let values = Array2::from_shape_fn((2048, 2), |(n, j)| {
                source[n + late * (1 - j)] + noise * random.gaussian()
            });
            let found = found(&field(values, 1.0), &CoherenceRequest::default());
            let delay = found.delays[1].unwrap();
            assert_eq!(delay.ambiguity, None);
            let off = (delay.delay - DT * late as f64).abs();
            held += usize::from(off < delay.interval);
            assert!((delay.interval / delay.error - 1.96).abs() < 0.001);
        }
        assert!((91..=99).contains(&held), "{memory} {noise} {late}: {held}");
    }
}

/// Shots of pulses that are later than a segment by default, under a window and without one.
#[test]
fn val_construction_shots_are_whole() {
    for window in [Window::None, Window::Hann] {
        let (mut held, mut known) = (0, 0);
        for seed in 0..100 {
            let mut random = Noise(41 + 907 * seed);
            let late = 210.0 + 90.0 * random.uniform();
            let mut shot = || {
                let start = 300.0 + 10.0 * random.gaussian();
                let values = Array2::from_shape_fn((1024, 2), |(n, j)| {
                    let t = (n as f64 - start - late * j as f64) / 8.0;
                    t * (-0.5 * t * t).exp() + 0.03 * random.gaussian()
                });
                field(values, 1.0)
            };
            let shots: Vec<Field> = (0..8).map(|_| shot()).collect();
            let shots: Vec<&Field> = shots.iter().collect();
            let request = CoherenceRequest {
                averaging: Averaging {
                    tapers: Tapers::Window(window),
                    ..Averaging::default()
                },
                ..CoherenceRequest::default()
            };
            let found = coherence(&shots, &request, &Silent).unwrap();
            if let Some(delay) = found.delays[1].filter(|delay| delay.ambiguity.is_none()) {
                known += 1;
                held += usize::from((delay.delay - DT * late).abs() < delay.interval);
            }
        }
        let missed = known - held;
        assert!(
            known > 90 && (1..=8).contains(&missed),
            "{window}: {held} of {known}"
        );
    }
}

/// Of 32 independent segments, where a third of the cells is above the level: some by chance.
#[test]
fn val_construction_phases_of_a_weak_coherence() {
    let (mut random, part) = (Noise(6), 0.05f64);
    let mut values = Array2::from_shape_fn((2048, 200), |_| random.gaussian());
    for mut row in values.rows_mut() {
        let common = row[0];
        let others = row.iter_mut().skip(1);
        others.for_each(|v| *v = part.sqrt() * common + (1.0 - part).sqrt() * *v);
    }
    let mut request = welch(64, 0);
    request.averaging.tapers = Tapers::Window(Window::None);
    let found = found(&field(values, 1.0), &request);
    let cells = found.phase.slice(s![1..32, 1..]);
    let cells = cells.iter().zip(found.phase_interval.slice(s![1..32, 1..]));
    let stated: Vec<bool> = cells
        .filter(|(_, half)| half.is_finite())
        .map(|(phase, half)| phase.abs() < *half)
        .collect();
    let held = stated.iter().filter(|held| **held).count() as f64 / stated.len() as f64;
    assert!(
        (0.92..0.98).contains(&held) && stated.len() > 1000,
        "{held}"
    );
}

/// The phase of a tone gives its delay up to whole periods.
#[test]
fn val_construction_the_delay_of_a_tone_states_its_period() {
    for (seed, late) in [(1, 3.0), (2, 13.7), (3, 150.2), (4, -41.0)] {
        let mut random = Noise(seed);
        let period = 17.3;
        let values = Array2::from_shape_fn((4096, 2), |(n, j)| {
            let at = n as f64 - late * j as f64;
            (std::f64::consts::TAU * at / period).sin() + 0.02 * random.gaussian()
        });
        let found = found(&field(values, 1.0), &CoherenceRequest::default());
        assert!(found.is_coherent[1]);
        let delay = found.delays[1].unwrap();
        let stated = delay.ambiguity.unwrap();
        assert!((stated / (DT * period) - 1.0).abs() < 0.01, "{stated}");
        assert!(delay.delay.abs() <= 0.51 * stated);
        let cycles = (delay.delay - DT * late) / (DT * period);
        assert!((cycles - cycles.round()).abs() < 0.01, "{late}: {delay:?}");
    }
}

/// Sites that hear one source at 25 m/s, though those above 125 Hz are more than half a wavelength apart; the interval
/// holds the velocity at 95 %.
#[test]
fn val_construction_one_velocity_of_a_wave() {
    for direction in [1, -1] {
        let mut held = 0;
        for seed in 0..60 {
            let mut random = Noise(9 + 733 * seed);
            let source: Vec<f64> = (0..2200).map(|_| random.gaussian()).collect();
            let values = Array2::from_shape_fn((2048, 8), |(n, j)| {
                let late = if direction > 0 { j } else { 7 - j };
                source[n + 100 - 4 * late] + 0.1 * random.gaussian()
            });
            let mut field = field(values, 0.1);
            field.time.step = 1e-3;
            let request = CoherenceRequest {
                reference: 2,
                ..CoherenceRequest::default()
            };
            let found = found(&field, &request);
            let velocity = found.velocity.unwrap();
            assert_eq!(velocity.sites, Some(7));
            assert!(!velocity.is_dispersive);
            let truth = 25.0 * f64::from(direction);
            assert!((velocity.velocity / truth - 1.0).abs() < 0.002);
            held += usize::from((velocity.low..velocity.high).contains(&truth));
            // Phases are continued by the delays.
            for speed in &found.speeds {
                assert!((speed.velocity / truth - 1.0).abs() < 0.3, "{speed:?}");
            }
        }
        assert!((54..=60).contains(&held), "{held}");
    }
}

/// A standing wave has no phase velocity, be it a tone or noise; a tone that travels has one.
#[test]
fn val_construction_a_standing_wave_has_no_velocity() {
    use std::f64::consts::TAU;
    for seed in 1..30 {
        let mut random = Noise(seed);
        let wave = |is_standing: bool, random: &mut Noise| {
            Array2::from_shape_fn((4096, 8), |(n, j)| {
                let (t, x) = (n as f64 * 0.05 * TAU, 0.9 * j as f64 + 0.2);
                let wave = if is_standing {
                    t.cos() * x.cos()
                } else {
                    (t - x).cos()
                };
                wave + 0.01 * random.gaussian()
            })
        };
        let standing = found(
            &field(wave(true, &mut random), 0.1),
            &CoherenceRequest::default(),
        );
        assert!(standing.coherent_sites().count() > 5);
        assert!(standing.velocity.is_none(), "{:?}", standing.velocity);
        for delay in standing.delays[1..].iter().flatten() {
            assert!(delay.ambiguity.is_some(), "{seed}: {delay:?}");
        }
        let travels = found(
            &field(wave(false, &mut random), 0.1),
            &CoherenceRequest::default(),
        );
        let velocity = travels.velocity.unwrap();
        let truth = TAU * 0.05 / DT / (0.9 / 0.1);
        assert!(
            velocity.low < truth && truth < velocity.high,
            "{truth}: {velocity:?}"
        );
        assert!(velocity.high - velocity.low < 0.1 * truth);
    }
}

#[test]
fn regress_one_transient_has_no_significance() {
    let values = Array2::from_shape_fn((2048, 6), |(n, j)| {
        let t = (n as f64 - 300.0 - 5.0 * j as f64) / 6.0;
        // An offset is no steady motion.
        (-t * t).exp() - 0.8
    });
    let request = welch(256, 128);
    let pulse = field(values, 1.0);
    let one = found(&pulse, &request);
    assert!(one.independence.is_transient());
    assert!(one.level().is_none() && one.speeds.is_empty());
    assert!(
        one.delays.iter().all(Option::is_none) && one.phase_interval.iter().all(|v| v.is_nan())
    );
    // Repeated, it has: as many as there are records.
    let shots = coherence(&[&pulse; 5], &request, &Silent).unwrap();
    assert_eq!(shots.independence.independent, Some(5.0));
    assert!((shots.level().unwrap() - (1.0 - 0.05f64.powf(0.25))).abs() < 1e-15);
}

/// 0 / 0 is no coherence of 1.
#[test]
fn regress_a_silent_reference_has_no_coherence() {
    let mut values = records();
    values.column_mut(0).fill(0.0);
    let request = welch(64, 32);
    let found = found(&field(values, 1.0), &request);
    assert!(found.coherence.iter().all(|g| g.is_nan()));
    assert!(found.above_level().is_none() && found.delays.iter().all(Option::is_none));
    assert!(found.spectrum.column(1).iter().any(|s| *s > 0.0));
}

/// A wave of a narrow band, a Gaussian of 0.02 about 0.08 cycles a sample, that passes 16 sites at 6 samples a site: segments of 256 samples
/// are shifted by up to a third. The delays have no bias, and the intervals of the speed hold in 36 of 40 fields or more.
#[test]
fn val_delays_of_a_narrow_band_have_no_bias() {
    let (times, sites, fields) = (2048, 16, 40);
    let mut noise = Noise(77);
    let (mut sum, mut count, mut hold, mut speeds) = (0.0, 0.0, 0, 0);
    for _ in 0..fields {
        // Convolved with the kernel of the band.
        let white: Vec<f64> = (0..times + 300).map(|_| noise.gaussian()).collect();
        let kernel: Vec<f64> = (-60..=60)
            .map(|m: i32| {
                let m = f64::from(m);
                (-0.5 * (std::f64::consts::TAU * 0.02 * m).powi(2)).exp()
                    * (std::f64::consts::TAU * 0.08 * m).cos()
            })
            .collect();
        let wave: Vec<f64> = white
            .windows(kernel.len())
            .map(|w| w.iter().zip(&kernel).map(|(a, b)| a * b).sum())
            .collect();
        let values = Array2::from_shape_fn((times, sites), |(n, j)| {
            wave[n + 96 - 6 * j] + 0.05 * noise.gaussian()
        });
        let request = welch(256, 128);
        let found = found(&field(values, 1.0), &request);
        for (j, delay) in found.delays.iter().enumerate().skip(6) {
            if let Some(delay) = delay.filter(|delay| delay.ambiguity.is_none()) {
                sum += delay.delay / (6.0 * DT * j as f64) - 1.0;
                count += 1.0;
            }
        }
        if let Some(velocity) = found.velocity {
            let truth = 1.0 / (6.0 * DT);
            hold += usize::from((velocity.low..=velocity.high).contains(&truth));
            speeds += 1;
        }
    }
    let bias = sum / count;
    assert!(count > 200.0 && bias.abs() < 2e-3, "{bias} of {count}");
    assert!(speeds >= 38 && hold + 4 >= speeds, "{hold} of {speeds}");
}

/// Independent noise that runs both ways at one speed, as loud: no delay and no velocity. Of one way there is a velocity.
#[test]
fn val_theory_equal_waves_both_ways_have_no_direction() {
    for seed in 0..20 {
        let mut random = Noise(31 + 517 * seed);
        let source: Vec<[f64; 2]> = (0..2400)
            .map(|_| [random.gaussian(), random.gaussian()])
            .collect();
        for back in [0.0, 1.0] {
            let values = Array2::from_shape_fn((2048, 12), |(n, j)| {
                let [there, other] = [source[n + 100 - 4 * j][0], source[n + 4 * j][1]];
                there + back * other + 0.1 * random.gaussian()
            });
            let mut field = field(values, 0.1);
            field.time.step = 1e-3;
            let found = found(&field, &CoherenceRequest::default());
            assert_eq!(found.is_both_ways, back > 0.0, "{seed}");
            assert_eq!(
                found.velocity.is_none(),
                back > 0.0,
                "{seed}: {:?}",
                found.velocity
            );
            assert_eq!(found.delays.iter().all(Option::is_none), back > 0.0);
        }
    }
}

/// Flexural waves, `omega = b k^2`, at two sites: the group delay is `d / (2 sqrt(b omega))`, less at high frequencies. Of waves with one
/// speed it depends on no frequency.
#[test]
fn val_theory_the_delay_of_flexural_waves_depends_on_frequency() {
    use std::f64::consts::TAU;
    let (b, apart) = (3.0, 1.5);
    let mut told = 0;
    for seed in 0..20 {
        let mut random = Noise(77 + 91 * seed);
        let waves: Vec<[f64; 3]> = (0..240)
            .map(|i| {
                let f = 0.1 + 0.9 * (f64::from(i) + random.uniform()) / 240.0;
                [TAU * f, random.gaussian(), random.gaussian()]
            })
            .collect();
        for is_dispersive in [true, false] {
            let values = Array2::from_shape_fn((4096, 2), |(n, j)| {
                let of = |[w, p, q]: &[f64; 3]| {
                    let k = match is_dispersive {
                        true => (w / b).sqrt(),
                        false => w / 4.0,
                    };
                    let angle = w * DT * n as f64 - k * apart * j as f64;
                    p * angle.cos() + q * angle.sin()
                };
                waves.iter().map(of).sum::<f64>() + random.gaussian()
            });
            let found = found(&field(values, apart), &CoherenceRequest::default());
            let delay = found.delays[1].unwrap();
            match delay.by_frequency {
                Some([low, high]) if is_dispersive => {
                    told += 1;
                    for [frequency, delay] in [low, high] {
                        let theory = apart / (2.0 * (b * TAU * frequency).sqrt());
                        assert!(
                            (delay / theory - 1.0).abs() < 0.25,
                            "{seed}: {frequency} {delay} {theory}"
                        );
                    }
                    assert!(low[1] > high[1]);
                }
                None => {}
                said => panic!("{seed}: {said:?}"),
            }
        }
    }
    assert!(told >= 15, "{told}");
}
