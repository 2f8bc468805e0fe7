//! Ridges of S(k, f) against lattices whose branches are known, and against DASCore's phase-shift transform
//! (`data/ridges.json`, made by `data/make_ridges.py`).

use std::f64::consts::{PI, TAU};

use ndarray::Array2;
use serde::Deserialize;
use test_support::changed;
use test_support::fields::{Congruential as Noise, option};
use wavecascade::Field;
use wavecascade::chain::{
    Accuracy, Chain, EndTime, Ends, Law, Losses, Record, Simulation, UnitCell,
};
use wavecascade::observer::Silent;
use wavecascade::prepare::Window;
use wavecascade::reference::LatticeImpact;
use wavecascade::ridges::{RidgeCut, RidgeLaw, Ridges, RidgesRequest, ridges};

/// A ring or a free chain of linear springs that starts with random velocities.
fn lattice(mass: &[f64], sites: usize, ends: Ends, step: f64, samples: usize) -> Field {
    let mut noise = Noise(17);
    let contacts = if ends == Ends::Free { sites - 1 } else { sites };
    let chain = Chain {
        mass: (0..sites).map(|j| mass[j % mass.len()]).collect(),
        coefficient: vec![1.0; contacts],
        law: Law::Spring {
            alpha: 0.0,
            beta: 0.0,
        }
        .into(),
        ends,
        precompression: 0.0,
        losses: Losses::default(),
        on_site: wavecascade::chain::OnSite::default(),
    };
    let simulation = Simulation {
        velocity: (0..sites).map(|_| noise.normal()).collect(),
        accuracy: Accuracy::Tolerance(1e-7),
        end_time: EndTime::At(step * (samples - 1) as f64),
        record: Record::default(),
        estimate_error: false,
        ..Simulation::impact(chain, 1.0, step, samples)
    };
    simulation.run(&Silent).unwrap().to_field()
}

fn found(field: &Field, request: &RidgesRequest) -> Ridges {
    ridges(&[field], request, &Silent).unwrap()
}

/// The largest distance of a point from a branch of the cell, in bins of its cut, and its root mean square.
fn distances(found: &Ridges, cell: &UnitCell) -> (f64, f64) {
    let mut all = Vec::new();
    for point in found.points() {
        let off = |k: f64| {
            let branches = cell.frequencies(k).into_iter();
            branches
                .map(|w| w / TAU - point.frequency)
                .min_by(|a, b| a.abs().total_cmp(&b.abs()))
                .unwrap()
        };
        let distance = match point.cut {
            RidgeCut::Wavenumber => off(point.wavenumber) / found.bins[0],
            RidgeCut::Frequency => {
                let h = 1e-4;
                let slope = (off(point.wavenumber + h) - off(point.wavenumber - h)) / (2.0 * h);
                off(point.wavenumber) / slope / found.bins[1]
            }
        };
        all.push(distance.abs());
    }
    let mean = all.iter().map(|d| d * d).sum::<f64>() / all.len() as f64;
    (all.iter().fold(0.0, |a, b| a.max(*b)), mean.sqrt())
}

/// A ring of equal bodies: all of its waves, at each wavenumber, to a thousandth of a bin; c/m within its error.
#[test]
fn val_monatomic_ring() {
    let field = lattice(&[1.0], 64, Ends::Periodic, 0.5, 2048);
    let request = RidgesRequest {
        window_space: Window::None,
        laws: vec![
            RidgeLaw::parse("monatomic").unwrap(),
            RidgeLaw::parse("2*w*abs(sin(k*d/2)); w=0.8, d=1.05").unwrap(),
        ],
        ..RidgesRequest::default()
    };
    let found = found(&field, &request);
    let cell = UnitCell::new(vec![1.0], vec![1.0]).unwrap();
    let (worst, mean) = distances(&found, &cell);
    let count = found.points().count();
    println!(
        "{count} points in {} branches: worst {worst}, mean {mean} bins",
        found.branches()
    );
    assert!(
        count >= 60 && found.branches() == 2,
        "{count} points, {} branches",
        found.branches()
    );
    assert!(worst < 1e-3, "{worst} bins");
    for fit in &found.fits {
        println!(
            "{}: {:?}, {} bins, {}",
            fit.name, fit.parameters, fit.deviation, fit.reduced
        );
        for parameter in &fit.parameters {
            let off = (parameter.value - 1.0).abs();
            assert!(off < 1e-3 && off < 4.0 * parameter.error, "{parameter:?}");
        }
        assert!(fit.deviation < 1e-3, "{}", fit.deviation);
    }
    // Velocities of the branch towards +x.
    for point in found
        .points()
        .filter(|p| p.wavenumber > 0.3 && p.wavenumber < 2.8)
    {
        let group = (point.wavenumber / 2.0).cos();
        assert!((point.group_velocity - group).abs() < 0.02, "{point:?}");
        let phase = 2.0 * (point.wavenumber / 2.0).sin() / point.wavenumber;
        assert!((point.phase_velocity - phase).abs() < 1e-3, "{point:?}");
    }
}

/// A free chain seen through windows: both cuts, steep and flat parts, within their errors.
#[test]
fn val_monatomic_chain_in_windows() {
    let field = lattice(&[1.0], 128, Ends::Free, 0.5, 4096);
    let request = RidgesRequest {
        segment: Some(512),
        laws: vec![RidgeLaw::parse("monatomic").unwrap()],
        ..RidgesRequest::default()
    };
    let found = found(&field, &request);
    let cell = UnitCell::new(vec![1.0], vec![1.0]).unwrap();
    let (worst, mean) = distances(&found, &cell);
    let cuts = |cut| {
        found
            .ridges
            .iter()
            .filter(|r| r.cut == cut)
            .map(|r| r.points.len())
            .sum::<usize>()
    };
    println!(
        "{} and {} points in {} branches: worst {worst}, mean {mean} bins; {:?}",
        cuts(RidgeCut::Frequency),
        cuts(RidgeCut::Wavenumber),
        found.branches(),
        found
            .fits
            .iter()
            .map(|f| (&f.parameters, f.deviation, f.reduced))
            .collect::<Vec<_>>()
    );
    assert!(cuts(RidgeCut::Frequency) > 100 && cuts(RidgeCut::Wavenumber) > 10);
    // Waves of a finite chain interfere in each cell: points are as far off as their errors say.
    assert!(mean < 0.35, "{mean} bins");
    let reduced = found.fits[0].reduced;
    assert!((0.5..1.6).contains(&reduced), "{reduced}");
    let c = &found.fits[0].parameters[0];
    assert!(
        (c.value - 1.0).abs() < 0.01 && (c.value - 1.0).abs() < 4.0 * c.error,
        "{c:?}"
    );
}

/// A ring of two masses: both branches, to a tenth of a bin, and both c/m.
#[test]
fn val_diatomic_ring() {
    let field = lattice(&[2.0, 1.0], 96, Ends::Periodic, 0.5, 2048);
    let request = RidgesRequest {
        window_space: Window::None,
        laws: vec![RidgeLaw::parse("diatomic").unwrap()],
        ..RidgesRequest::default()
    };
    let found = found(&field, &request);
    let cell = UnitCell::new(vec![2.0, 1.0], vec![1.0, 1.0]).unwrap();
    let (worst, mean) = distances(&found, &cell);
    let count = found.points().count();
    println!(
        "{count} points in {} branches: worst {worst}, mean {mean} bins",
        found.branches()
    );
    let fit = &found.fits[0];
    println!("{:?}, {} bins", fit.parameters, fit.deviation);
    assert!(
        count > 120 && mean < 0.01 && worst < 0.1,
        "{count} {mean} {worst}"
    );
    let mut values: Vec<f64> = fit.parameters.iter().map(|p| p.value).collect();
    values.sort_by(f64::total_cmp);
    assert!(
        (values[0] - 0.5).abs() < 1e-3 && (values[1] - 1.0).abs() < 1e-3,
        "{values:?}"
    );
}

/// Noise has no ridges.
#[test]
fn val_noise_has_no_ridges() {
    let mut noise = Noise(5);
    let mut peaks = 0;
    for _ in 0..20 {
        let field = Field::from_array(Array2::from_shape_fn((1024, 24), |_| noise.normal()));
        let found = found(&field, &RidgesRequest::default());
        peaks += found.points().count();
        assert!(
            (found.independence.effective - 6.66).abs() < 0.1,
            "{}",
            found.independence.effective
        );
    }
    assert_eq!(peaks, 0);
}

/// Nor has noise that is correlated, along x as by a gauge of four or eight sites or from site to site, or in time; peaks by
/// themselves once in a hundred fields.
#[test]
fn val_correlated_noise_has_no_ridges() {
    let mut noise = Noise(5);
    let (mut ridges, mut lone) = ([0; 4], 0);
    for _ in 0..10 {
        let white = Array2::from_shape_fn((1024, 56), |_| noise.normal());
        let gauge = |width: usize| {
            Array2::from_shape_fn((1024, 48), |(n, j)| {
                (0..width).map(|i| white[[n, j + i]]).sum::<f64>()
            })
        };
        let mut red = [white.clone(), white.clone()];
        for n in 1..1024 {
            for j in 1..56 {
                red[0][[n, j]] += 0.85 * red[0][[n - 1, j]];
                red[1][[n, j]] += 0.9 * red[1][[n, j - 1]];
            }
        }
        let [in_time, along_x] = red;
        let fields = [gauge(4), gauge(8), in_time, along_x];
        for (count, values) in ridges.iter_mut().zip(fields) {
            let found = found(&Field::from_array(values), &RidgesRequest::default());
            *count += found.ridges.len();
            lone += usize::from(!found.lone.is_empty());
        }
    }
    assert_eq!(ridges, [0; 4]);
    assert!(lone <= 2, "{lone}");
}

/// The branch of a struck lattice is found, but a single transient has no errors.
#[test]
fn val_theory_a_transient_has_no_errors() {
    let impact = LatticeImpact {
        n_times: 768,
        n_sites: 96,
        dt: 0.125,
    };
    let found = found(&impact.field(), &RidgesRequest::default());
    assert!(found.is_single() && found.points().count() > 20);
    for point in found.points() {
        let exact = (0.5 * point.wavenumber).sin().abs() / PI;
        assert!(
            (point.frequency - exact).abs() < 2.0 * found.bins[0],
            "{point:?}"
        );
        let errors = [
            point.frequency_error,
            point.wavenumber_error,
            point.phase_velocity_error,
            point.group_velocity_error,
        ];
        assert!(errors.iter().all(|error| error.is_nan()), "{point:?}");
    }
}

#[derive(Deserialize)]
struct Expected {
    frequency: Vec<f64>,
    wavenumber: Vec<f64>,
}

/// The record of `make_ridges.py`.
fn shot() -> Field {
    let (nt, nx, dt, dx) = (512, 48, 1.0 / 64.0, 0.05);
    let mut noise = Noise(5);
    let mut values = Array2::from_shape_fn((nt, nx), |_| noise.uniform());
    let mut phases = Noise(9);
    for n in 0..184 {
        let f = 2.0 + 0.125 * f64::from(n);
        let (speed, phase) = (
            2.0 + 3.0 / (1.0 + (f / 12.0).powi(2)),
            TAU * phases.uniform(),
        );
        for ((t, j), value) in values.indexed_iter_mut() {
            *value += (TAU * f * (dt * t as f64 - dx * j as f64 / speed) + phase).cos();
        }
    }
    let mut field = Field::from_array(values);
    (field.time.step, field.space.step) = (dt, dx);
    field
}

/// Wavenumbers at each frequency, against the phase-shift transform and against the truth.
#[test]
fn val_dascore_phase_shift_of_a_dispersive_shot() {
    let expected: Expected = serde_json::from_str(include_str!("../data/ridges.json")).unwrap();
    let request = RidgesRequest {
        segment: Some(512),
        // The record holds whole periods of all its waves, which a taper would mix.
        window_time: Window::None,
        ..RidgesRequest::default()
    };
    let found = found(&shot(), &request);
    let mut compared = 0;
    let (mut worst, mut scores) = ([0.0f64; 2], 0.0);
    for point in found
        .points()
        .filter(|p| p.cut == RidgeCut::Frequency && p.frequency > 3.0)
    {
        let same = |f: &&f64| (**f - point.frequency).abs() < 1e-9;
        let Some(index) = expected.frequency.iter().position(|f| same(&f)) else {
            continue;
        };
        let f = point.frequency;
        let truth = TAU * f / (2.0 + 3.0 / (1.0 + (f / 12.0).powi(2)));
        let bin = found.bins[1];
        worst[0] = worst[0].max((point.wavenumber - expected.wavenumber[index]).abs() / bin);
        worst[1] = worst[1].max((point.wavenumber - truth).abs() / bin);
        scores += ((point.wavenumber - truth) / point.wavenumber_error).powi(2);
        compared += 1;
    }
    let score = (scores / f64::from(compared)).sqrt();
    println!(
        "{compared} frequencies: {} bins from DASCore, {} from the truth, {score} errors",
        worst[0], worst[1]
    );
    assert!(compared > 120, "{compared}");
    assert!(worst[0] < 0.03 && worst[1] < 0.03, "{worst:?}");
    assert!((0.3..2.0).contains(&score), "{score}");
}

/// Repeated records are averaged, and count as realisations.
#[test]
fn regress_records_are_averaged() {
    let field = shot();
    let request = RidgesRequest {
        segment: Some(512),
        ..RidgesRequest::default()
    };
    let one = found(&field, &request);
    let three = ridges(&[&field; 3], &request, &Silent).unwrap();
    assert_eq!(
        (one.independence.effective, three.independence.effective),
        (1.0, 3.0)
    );
    assert!(three.level < one.level);
    let power = |found: &Ridges, f: f64| found.points().find(|p| p.frequency == f).map(|p| p.power);
    let f = one.points().nth(20).unwrap().frequency;
    let (a, b) = (power(&one, f).unwrap(), power(&three, f).unwrap());
    assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    let map = |found: &Ridges| found.analysis.spacetime_map.clone().unwrap();
    let (one, three) = (map(&one), map(&three));
    for (a, b) in [(&one.x, &three.x), (&one.y, &three.y)] {
        assert!((a.low - b.low).abs() + (a.high - b.high).abs() < 1e-9 * b.high.abs());
    }
}

#[test]
fn regress_what_is_refused() {
    let field = shot();
    let refused = |field: &Field, change: &dyn Fn(&mut RidgesRequest)| {
        let request = changed(RidgesRequest::default(), change);
        option(ridges(&[field], &request, &Silent).unwrap_err())
    };
    let few = Field::from_array(Array2::zeros((600, 7)));
    assert_eq!(refused(&few, &|_| {}), "field");
    let with = |change: &dyn Fn(&mut RidgesRequest)| refused(&field, change);
    assert_eq!(with(&|r| r.segment = Some(600)), "segment");
    assert_eq!(with(&|r| r.fewest = 4), "points");
    assert_eq!(with(&|r| r.alpha = 0.0), "significance");
    assert_eq!(with(&|r| r.memory = Some(10_000)), "memory");
    // Both constants change the curve in the same way, and there is none at all.
    for law in ["b*c*abs(k); b=1, c=4", "sqrt(c-5); c=1"] {
        let law = RidgeLaw::parse(law).unwrap();
        assert_eq!(with(&|r| r.laws = vec![law.clone()]), "fit");
    }
}

#[test]
fn val_nyquist_wavenumber_is_the_end_of_the_axis() {
    let found = found(&shot(), &RidgesRequest::default());
    let k = &found.analysis.axes.wavenumber_signed;
    assert!((k[0] + PI / 0.05).abs() < 1e-9 && (found.bins[1] - (k[1] - k[0])).abs() < 1e-9);
}

/// Waves of one random source whose spectrum falls, in noise: the interval of the speed holds.
#[test]
fn val_construction_intervals_of_fits_hold() {
    for (noise, sites, times, wide) in [
        (0.1, 32, 4096, 24),
        (1.0, 32, 4096, 24),
        (3.0, 32, 4096, 24),
        (0.3, 24, 2048, 40),
    ] {
        let mut held = 0;
        for seed in 0..25 {
            let mut random = Noise(1000 + 7919 * seed);
            let white: Vec<f64> = (0..times + 4 * sites + wide)
                .map(|_| random.normal())
                .collect();
            let weights: Vec<f64> = (0..wide)
                .map(|i| (PI * (i as f64 + 0.5) / wide as f64).sin().powi(2))
                .collect();
            let size = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
            let source: Vec<f64> = (0..times + 4 * sites)
                .map(|t| {
                    let pairs = weights.iter().zip(&white[t..]);
                    pairs.map(|(w, v)| w * v).sum::<f64>() / size
                })
                .collect();
            let values = Array2::from_shape_fn((times, sites), |(t, j)| {
                source[t + 4 * (sites - 1 - j)] + noise * random.normal()
            });
            let request = RidgesRequest {
                laws: vec![RidgeLaw::parse("c*abs(k); c=0.27").unwrap()],
                ..RidgesRequest::default()
            };
            let found = found(&Field::from_array(values), &request);
            let speed = &found.fits[0].parameters[0];
            assert!(speed.error < 0.01, "{speed:?}");
            held += usize::from((speed.value - 0.25).abs() < 1.96 * speed.error);
        }
        println!("noise {noise}, {sites} sites: {held} of 25");
        assert!(held >= 23, "{noise} {sites}: {held}");
    }
}

/// Waves of one speed in a band that is 3 bins wide: windows smear it, and what a cut holds lies nearer to the middle of the band. The group
/// velocity has no bias for that.
#[test]
fn val_the_speed_of_a_narrow_band_has_no_bias() {
    let (times, sites, fields) = (2048usize, 48usize, 12);
    let mut noise = Noise(5);
    let mut all = Vec::new();
    for _ in 0..fields {
        let white: Vec<f64> = (0..times + 500).map(|_| noise.normal()).collect();
        let kernel: Vec<f64> = (-100..=100)
            .map(|m: i32| {
                let m = f64::from(m);
                (-0.5 * (TAU * 0.008 * m).powi(2)).exp() * (TAU * 0.06 * m).cos()
            })
            .collect();
        let wave: Vec<f64> = white
            .windows(kernel.len())
            .map(|w| w.iter().zip(&kernel).map(|(a, b)| a * b).sum())
            .collect();
        let values = Array2::from_shape_fn((times, sites), |(n, j)| {
            wave[n + 144 - 3 * j] + 0.02 * noise.normal()
        });
        let found = found(&Field::from_array(values), &RidgesRequest::default());
        let inside = found
            .points()
            .filter(|p| (p.frequency - 0.06).abs() < 0.008);
        all.extend(
            inside
                .map(|p| p.group_velocity * 3.0)
                .filter(|v| v.is_finite()),
        );
    }
    assert!(all.len() > 60, "{}", all.len());
    all.sort_by(f64::total_cmp);
    let middle = all[all.len() / 2];
    assert!((middle - 1.0).abs() < 0.01, "{middle}");
}

/// Two tones in noise are no ridge, and stand above it all the same: each at its frequency and wavenumber, to a bin.
#[test]
fn val_theory_tones_stand_above_the_noise() {
    let (times, sites) = (4096, 40);
    let mut by_chance = 0;
    for seed in 1..11 {
        let mut noise = Noise(seed);
        let tones = [[0.0837, 0.41, 1.0], [0.211, -0.93, 0.7]];
        let values = Array2::from_shape_fn((times, sites), |(n, j)| {
            let of = |[f, k, a]: &[f64; 3]| a * (TAU * f * n as f64 - k * j as f64).cos();
            tones.iter().map(of).sum::<f64>() + 0.2 * noise.normal()
        });
        let found = found(&Field::from_array(values), &RidgesRequest::default());
        assert!(found.ridges.is_empty());
        by_chance += found.lone.len() - 2;
        for ([frequency, wavenumber], [f, k, _]) in found.lone.iter().zip(tones) {
            assert!(
                (frequency - f).abs() <= found.bins[0],
                "{seed}: {frequency} {f}"
            );
            assert!(
                (wavenumber - k).abs() <= found.bins[1],
                "{seed}: {wavenumber} {k}"
            );
        }
    }
    // Noise has a peak anywhere in one spectrum of a hundred.
    assert!(by_chance <= 1, "{by_chance}");
}

/// Waves of one speed, a site in three samples, in loud noise: the median of the group velocities is that speed.
#[test]
fn val_theory_the_median_group_velocity_is_the_speed() {
    let mut tested = 0;
    for seed in 1..21 {
        let mut noise = Noise(40 + seed);
        let white: Vec<f64> = (0..2600).map(|_| noise.normal()).collect();
        let wave: Vec<f64> = white
            .windows(9)
            .map(|w| {
                (0..9)
                    .map(|i| w[i] * (0.35 * (i as f64 - 4.0)).cos())
                    .sum::<f64>()
                    / 2.0
            })
            .collect();
        let values = Array2::from_shape_fn((2048, 24), |(n, j)| {
            wave[n + 200 - 3 * j] + 0.6 * noise.normal()
        });
        let found = found(&Field::from_array(values), &RidgesRequest::default());
        let known = found
            .points()
            .filter(|p| p.group_velocity_error < 0.1 * p.group_velocity.abs());
        let mut speeds: Vec<f64> = known.map(|p| p.group_velocity).collect();
        speeds.sort_by(f64::total_cmp);
        if speeds.len() >= 5 {
            let middle = speeds[speeds.len() / 2];
            assert!((3.0 * middle - 1.0).abs() < 0.1, "{seed}: {middle}");
            tested += 1;
        }
    }
    assert!(tested >= 10, "{tested}");
}
