//! Ridges of S(k, f) against lattices whose branches are known, and against DASCore's phase-shift transform
//! (`data/ridges.json`, made by `data/make_ridges.py`).

use std::f64::consts::{PI, TAU};

use ndarray::Array2;
use test_support::estimate::{flat, ridges};
use test_support::fields::{
    Congruential as Noise, band, chain, filtered, option, red, spring, stepped,
};
use test_support::{hold, lies, near, rms, worst};
use wavecascade::Field;
use wavecascade::arrays::LargeArray;
use wavecascade::chain::{Accuracy, EndTime, Ends, Record, Simulation, UnitCell};
use wavecascade::observer::Silent;
use wavecascade::reference::LatticeImpact;
use wavecascade::ridges::{RidgeCut, RidgePoint, Ridges};

use crate::peers::data;

/// A ring or a free chain of linear springs that starts with random velocities.
fn lattice(mass: &[f64], sites: usize, ends: Ends, samples: usize) -> Field {
    let contacts = if ends == Ends::Free { sites - 1 } else { sites };
    let masses = mass.iter().copied().cycle().take(sites).collect();
    let chain = chain(masses, vec![1.0; contacts], spring(0.0, 0.0), ends);
    let step = 0.5;
    let simulation = Simulation {
        velocity: Noise(17).normals(sites),
        accuracy: Accuracy::Tolerance(1e-7),
        end_time: EndTime::At(step * (samples - 1) as f64),
        record: Record::default(),
        estimate_error: false,
        ..Simulation::impact(chain, 1.0, step, samples)
    };
    simulation.run(&Silent).unwrap().to_field()
}

fn found(words: &str, field: &Field) -> Ridges {
    ridges(words, [field]).unwrap()
}

fn of(values: Array2<f64>) -> Ridges {
    found("", &Field::from_array(values))
}

/// How far the points are from the branches of a cell of these masses, in bins of their cut.
fn distances(found: &Ridges, mass: &[f64]) -> Vec<f64> {
    let cell = UnitCell::new(mass.to_vec(), vec![1.0; mass.len()]).unwrap();
    let distance = |point: &RidgePoint| {
        let off = |k: f64| {
            let branches = cell.frequencies(k).into_iter();
            let off = branches.map(|w| w / TAU - point.frequency);
            off.min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap()
        };
        let k = point.wavenumber;
        match point.cut {
            RidgeCut::Wavenumber => (off(k) / found.bins[0]).abs(),
            RidgeCut::Frequency => {
                let slope = (off(k + 1e-4) - off(k - 1e-4)) / 2e-4;
                (off(k) / slope / found.bins[1]).abs()
            }
        }
    };
    found.points().map(distance).collect()
}

/// A ring of equal bodies: all of its waves, at each wavenumber, to a thousandth of a bin; c/m within its error.
#[test]
fn val_monatomic_ring() {
    let words = "space-window=none laws=monatomic|2*w*abs(sin(k*d/2));w=0.8,d=1.05";
    let found = found(words, &lattice(&[1.0], 64, Ends::Periodic, 2048));
    assert!(found.points().count() >= 60 && found.branches() == 2);
    lies(worst(distances(&found, &[1.0])), 0.0..1e-3);
    for fit in &found.fits {
        for parameter in &fit.parameters {
            near(parameter.value, 1.0, 1e-3f64.min(4.0 * parameter.error));
        }
        lies(fit.deviation, 0.0..1e-3);
    }
    // Velocities of the branch towards +x.
    for point in found.points() {
        let k = point.wavenumber;
        if k > 0.3 && k < 2.8 {
            near(point.group_velocity, (k / 2.0).cos(), 0.02);
            near(point.phase_velocity, 2.0 * (k / 2.0).sin() / k, 1e-3);
        }
    }
}

/// A free chain seen through windows: both cuts, steep and flat parts, within their errors.
#[test]
fn val_monatomic_chain_in_windows() {
    let field = lattice(&[1.0], 128, Ends::Free, 4096);
    let found = found("segment=512 laws=monatomic", &field);
    let cuts = |cut| found.points().filter(|point| point.cut == cut).count();
    assert!(cuts(RidgeCut::Frequency) > 100 && cuts(RidgeCut::Wavenumber) > 10);
    // Waves of a finite chain interfere in each cell: points are as far off as their errors say.
    lies(rms(distances(&found, &[1.0])), 0.0..0.35);
    lies(found.fits[0].reduced, 0.5..1.6);
    let c = &found.fits[0].parameters[0];
    near(c.value, 1.0, 0.01f64.min(4.0 * c.error));
}

/// A ring of two masses: both branches, to a tenth of a bin, and both c/m.
#[test]
fn val_diatomic_ring() {
    let field = lattice(&[2.0, 1.0], 96, Ends::Periodic, 2048);
    let found = found("space-window=none laws=diatomic", &field);
    let distances = distances(&found, &[2.0, 1.0]);
    assert!(distances.len() > 120);
    lies(rms(distances.iter().copied()), 0.0..0.01);
    lies(worst(distances), 0.0..0.1);
    let parameters = found.fits[0].parameters.iter();
    let mut values: Vec<f64> = parameters.map(|p| p.value).collect();
    values.sort_by(f64::total_cmp);
    near(values[0], 0.5, 1e-3);
    near(values[1], 1.0, 1e-3);
}

/// Noise has no ridges.
#[test]
fn val_noise_has_no_ridges() {
    let mut noise = Noise(5);
    for _ in 0..20 {
        let found = of(noise.white(1024, 24));
        assert_eq!(found.points().count(), 0);
        near(found.independence.effective, 6.66, 0.1);
    }
}

/// Nor has noise that is correlated, along x as by a gauge of four or eight sites or from site to site, or in time; peaks by
/// themselves once in a hundred fields.
#[test]
fn val_correlated_noise_has_no_ridges() {
    let mut noise = Noise(5);
    let mut lone = 0;
    for _ in 0..10 {
        let white = noise.white(1024, 56);
        let gauge = |width: usize| {
            let sum = |n: usize, j: usize| (j..j + width).map(|j| white[[n, j]]).sum();
            Array2::from_shape_fn((1024, 48), |(n, j)| sum(n, j))
        };
        let along_x = red(white.t().to_owned(), 0.9).reversed_axes();
        for values in [gauge(4), gauge(8), red(white.clone(), 0.85), along_x] {
            let found = of(values);
            assert!(found.ridges.is_empty());
            lone += usize::from(!found.lone.is_empty());
        }
    }
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
    let found = found("", &impact.field());
    assert!(found.is_single() && found.points().count() > 20);
    for point in found.points() {
        let exact = (0.5 * point.wavenumber).sin().abs() / PI;
        near(point.frequency, exact, 2.0 * found.bins[0]);
        let errors = [
            point.frequency_error,
            point.wavenumber_error,
            point.phase_velocity_error,
            point.group_velocity_error,
        ];
        assert!(errors.iter().all(|error| error.is_nan()), "{point:?}");
    }
}

/// Speed of the waves of [`shot`].
fn speed(f: f64) -> f64 {
    2.0 + 3.0 / (1.0 + (f / 12.0).powi(2))
}

/// The record of `make_ridges.py`.
fn shot() -> Field {
    let (dt, dx) = (1.0 / 64.0, 0.05);
    let (mut noise, mut phases) = (Noise(5), Noise(9));
    let mut values = Array2::from_shape_fn((512, 48), |_| noise.uniform());
    for n in 0..184 {
        let f = 2.0 + 0.125 * f64::from(n);
        let phase = TAU * phases.uniform();
        for ((t, j), value) in values.indexed_iter_mut() {
            *value += (TAU * f * (dt * t as f64 - dx * j as f64 / speed(f)) + phase).cos();
        }
    }
    stepped(values, dt, dx)
}

/// Wavenumbers at each frequency, against the phase-shift transform and against the truth.
#[test]
fn val_dascore_phase_shift_of_a_dispersive_shot() {
    let theirs = data("ridges.json");
    let [frequency, wavenumber] = ["frequency", "wavenumber"].map(|name| flat(&theirs[name]));
    // The record holds whole periods of all its waves, which a taper would mix.
    let found = found("segment=512 window=none", &shot());
    let mut scores = Vec::new();
    let points = found.points().filter(|p| p.cut == RidgeCut::Frequency);
    for point in points.filter(|p| p.frequency > 3.0) {
        let f = point.frequency;
        let is_same = |theirs: &f64| (theirs - f).abs() < 1e-9;
        let Some(index) = frequency.iter().position(is_same) else {
            continue;
        };
        let truth = TAU * f / speed(f);
        near(point.wavenumber, wavenumber[index], 0.03 * found.bins[1]);
        near(point.wavenumber, truth, 0.03 * found.bins[1]);
        scores.push((point.wavenumber - truth) / point.wavenumber_error);
    }
    assert!(scores.len() > 120, "{}", scores.len());
    lies(rms(scores), 0.3..2.0);
}

/// Repeated records are averaged, and count as realisations.
#[test]
fn regress_records_are_averaged() {
    let field = shot();
    let [one, three] = [1, 3].map(|shots| ridges("segment=512", vec![&field; shots]).unwrap());
    let effective = [&one, &three].map(|found| found.independence.effective);
    assert_eq!(effective, [1.0, 3.0]);
    assert!(three.level < one.level);
    let f = one.points().nth(20).unwrap().frequency;
    let power = |found: &Ridges| found.points().find(|p| p.frequency == f).unwrap().power;
    near(power(&one) / power(&three), 1.0, 1e-12);
    let [one, three] =
        [&one, &three].map(|found| &found.analysis.maps[&LargeArray::SPACETIME_SPECTRUM]);
    for (a, b) in [(&one.x, &three.x), (&one.y, &three.y)] {
        near(a.low, b.low, 1e-9 * b.high.abs());
        near(a.high, b.high, 1e-9 * b.high.abs());
    }
}

#[test]
fn regress_what_is_refused() {
    let few = Field::from_array(Array2::zeros((600, 7)));
    assert_eq!(option(ridges("", [&few]).unwrap_err()), "field");
    let field = shot();
    for (words, refused) in [
        ("segment=600", "segment"),
        ("points=4", "points"),
        ("significance=0", "significance"),
        ("memory=10000", "memory"),
        // Both constants change the curve in the same way, and there is none at all.
        ("laws=b*c*abs(k);b=1,c=4", "fit"),
        ("laws=sqrt(c-5);c=1", "fit"),
    ] {
        assert_eq!(option(ridges(words, [&field]).unwrap_err()), refused);
    }
}

#[test]
fn val_nyquist_wavenumber_is_the_end_of_the_axis() {
    let found = found("", &shot());
    let k = &found.analysis.axes.wavenumber_signed;
    near(k[0], -PI / 0.05, 1e-9);
    near(found.bins[1], k[1] - k[0], 1e-9);
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
        let weight = |i: usize| (PI * (i as f64 + 0.5) / wide as f64).sin().powi(2);
        let weights: Vec<f64> = (0..wide).map(weight).collect();
        hold(25, 23..=25, |seed| {
            let mut random = Noise(1000 + 7919 * seed);
            let source = filtered(&random.normals(times + 4 * sites + wide), &weights);
            let values = Array2::from_shape_fn((times, sites), |(t, j)| {
                source[t + 4 * (sites - 1 - j)] + noise * random.normal()
            });
            let found = found("laws=c*abs(k);c=0.27", &Field::from_array(values));
            let speed = &found.fits[0].parameters[0];
            lies(speed.error, 0.0..0.01);
            (speed.value - 0.25).abs() < 1.96 * speed.error
        });
    }
}

/// Waves of one speed, a site in three samples: the middle one of the group velocities that are chosen, over that speed.
fn middle_speed(
    (noise, sites): (f64, usize),
    weights: &[f64],
    random: &mut Noise,
    is_chosen: impl Fn(&&RidgePoint) -> bool,
) -> Option<f64> {
    let wave = filtered(&random.normals(2600), weights);
    let values = Array2::from_shape_fn((2048, sites), |(n, j)| {
        wave[n + 144 - 3 * j] + noise * random.normal()
    });
    let found = of(values);
    let points = found.points().filter(is_chosen);
    let speeds = points.map(|p| 3.0 * p.group_velocity);
    let mut speeds: Vec<f64> = speeds.filter(|v| v.is_finite()).collect();
    speeds.sort_by(f64::total_cmp);
    (speeds.len() >= 5).then(|| speeds[speeds.len() / 2])
}

/// In a band that is 3 bins wide: windows smear it, and what a cut holds lies nearer to the middle of the band. The group velocity has
/// no bias for that.
#[test]
fn val_the_speed_of_a_narrow_band_has_no_bias() {
    let (mut random, weights) = (Noise(5), band(0.06, 0.008, 100));
    let is_inside = |p: &&RidgePoint| (p.frequency - 0.06).abs() < 0.008;
    let fields =
        (0..12).filter_map(|_| middle_speed((0.005, 48), &weights, &mut random, is_inside));
    let middle: Vec<f64> = fields.collect();
    assert!(middle.len() >= 10, "{middle:?}");
    near(middle.iter().sum::<f64>() / middle.len() as f64, 1.0, 0.01);
}

/// In loud noise.
#[test]
fn val_theory_the_median_group_velocity_is_the_speed() {
    let weights: Vec<f64> = (0..9).map(|i| (0.35 * f64::from(i - 4)).cos()).collect();
    let is_known = |p: &&RidgePoint| p.group_velocity_error < 0.1 * p.group_velocity.abs();
    let fields =
        (41..61).filter_map(|seed| middle_speed((0.55, 24), &weights, &mut Noise(seed), is_known));
    let middle: Vec<f64> = fields.collect();
    assert!(middle.len() >= 10, "{middle:?}");
    middle.iter().for_each(|speed| near(*speed, 1.0, 0.1));
}

/// Two tones in noise are no ridge, and stand above it all the same: each at its frequency and wavenumber, to a bin.
#[test]
fn val_theory_tones_stand_above_the_noise() {
    let mut by_chance = 0;
    for seed in 1..11 {
        let mut noise = Noise(seed);
        let tones = [[0.0837, 0.41, 1.0], [0.211, -0.93, 0.7]];
        let values = Array2::from_shape_fn((4096, 40), |(n, j)| {
            let of = |[f, k, a]: &[f64; 3]| a * (TAU * f * n as f64 - k * j as f64).cos();
            tones.iter().map(of).sum::<f64>() + 0.2 * noise.normal()
        });
        let found = of(values);
        assert!(found.ridges.is_empty());
        by_chance += found.lone.len() - 2;
        for (at, tone) in found.lone.iter().zip(tones) {
            for axis in [0, 1] {
                let off = (at[axis] - tone[axis]).abs();
                assert!(off <= found.bins[axis], "{seed}: {at:?} {tone:?}");
            }
        }
    }
    // Noise has a peak anywhere in one spectrum of a hundred.
    assert!(by_chance <= 1, "{by_chance}");
}
