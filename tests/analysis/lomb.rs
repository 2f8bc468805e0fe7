//! Spectra by least squares against astropy (`data/lomb.json`, made by `data/make_lomb.py`), and against
//! periodograms of even records.

use std::f64::consts::TAU;

use ndarray::Array2;
use serde::Deserialize;
use wavecascade::estimates::{LombAxis, LombRequest, lomb};
use wavecascade::field::OpenOptions;
use wavecascade::observer::Silent;
use wavecascade::{Error, Field};

/// Integers of a linear congruential generator, in -1 to 1.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = (1_103_515_245 * self.0 + 12_345) % (1 << 31);
        self.0 as f64 / f64::from(1 << 30) - 1.0
    }
}

#[derive(Deserialize)]
struct Expected {
    power: Vec<f64>,
    psd: Vec<f64>,
    level: f64,
    false_alarm: f64,
}

/// The record of `make_lomb.py`, twice: the second site has no gaps.
fn record() -> Field {
    let count = 180;
    let (mut jitter, mut random) = (Noise(3), Noise(4));
    let times: Vec<f64> = (0..count)
        .map(|n| 100.0 + 0.5 * (n as f64 + 0.4 * jitter.next()))
        .collect();
    let record: Vec<f64> = times
        .iter()
        .map(|t| 7.0 + random.next() + 0.5 * (TAU * 0.313 * t + 1.0).cos())
        .collect();
    let values = Array2::from_shape_fn((count, 2), |(n, j)| {
        if j == 0 && n % 6 == 4 {
            f64::NAN
        } else {
            record[n]
        }
    });
    let mut field = Field::from_array(values).with_times(Some(times.clone()));
    field.time.origin = times[0];
    field.time.step = (times[count - 1] - times[0]) / (count - 1) as f64;
    field
}

#[test]
fn val_astropy_uneven_times_with_gaps() {
    let expected: Expected = serde_json::from_str(include_str!("../data/lomb.json")).unwrap();
    let found = lomb(&record(), &LombRequest::default(), &Silent).unwrap();
    assert!(found.frequency.len() >= expected.power.len() - 1);
    let mut worst = [0.0f64; 2];
    for (m, (power, psd)) in expected
        .power
        .iter()
        .zip(&expected.psd)
        .enumerate()
        .take(found.frequency.len())
    {
        worst[0] = worst[0].max((found.power[[m, 0]] - power).abs());
        worst[1] = worst[1].max((found.density[[m, 0]] / (2.0 * found.steps[2]) - psd).abs());
    }
    let level = (found.level[0] - expected.level).abs();
    let alarm = (found.peaks[0][2] / expected.false_alarm - 1.0).abs();
    println!(
        "power {:e}, psd {:e}, level {level:e}, false alarm {alarm:e}",
        worst[0], worst[1]
    );
    assert!(worst[0] < 1e-14 && worst[1] < 1e-12 && level < 1e-15 && alarm < 1e-12);
    assert_eq!(
        (found.samples.clone(), found.missing, found.significant()),
        (vec![150, 180], 30, 2)
    );
    assert!(
        (found.peaks[1][0] - 0.313).abs() < 0.01,
        "{:?}",
        found.peaks
    );
}

/// Of even times, at the frequencies of the transform, the density is the periodogram, along time and along space.
#[test]
fn val_periodogram_of_even_records() {
    let (n, dt) = (64, 0.25);
    let mut random = Noise(8);
    let values = Array2::from_shape_fn((n, n), |_| random.next());
    for axis in [LombAxis::Time, LombAxis::Space] {
        let mut field = Field::from_array(values.clone());
        (field.time.step, field.space.step) = (dt, dt);
        // Multiples of 1 / (n dt) are not multiples of 1 / (5 T), with T = (n - 1) dt.
        let request = LombRequest {
            axis,
            oversampling: n as f64 / (n - 1) as f64,
            ..LombRequest::default()
        };
        let found = lomb(&field, &request, &Silent).unwrap();
        let density = |m: usize, record: &[f64]| {
            let term = |(j, v): (usize, &f64)| {
                let angle = TAU * (m * j % n) as f64 / n as f64;
                [v * angle.cos(), v * angle.sin()]
            };
            let sum = record
                .iter()
                .enumerate()
                .map(term)
                .fold([0.0; 2], |s, t| [s[0] + t[0], s[1] + t[1]]);
            2.0 * dt / n as f64 * (sum[0] * sum[0] + sum[1] * sum[1])
        };
        for m in 1..n / 2 {
            assert!((found.frequency[m - 1] - m as f64 / (n as f64 * dt)).abs() < 1e-12);
            let expected = match axis {
                LombAxis::Time => density(m, &values.column(5).to_vec()),
                LombAxis::Space => {
                    (0..n)
                        .map(|t| density(m, &values.row(t).to_vec()))
                        .sum::<f64>()
                        / n as f64
                }
            };
            let column = if axis == LombAxis::Time { 5 } else { 0 };
            let off = found.density[[m - 1, column]] / expected - 1.0;
            assert!(off.abs() < 1e-9, "{axis:?} {m}: {off}");
        }
    }
}

/// Noise exceeds the level in about one record in twenty; Baluev's bound is a bound.
#[test]
fn val_level_of_noise() {
    let mut random = Noise(6);
    let mut gaussian = move || (0..12).map(|_| random.next()).sum::<f64>();
    let values = Array2::from_shape_fn((100, 600), |_| gaussian());
    let times = (0..100)
        .map(|n| n as f64 + 0.3 * (1.7 * n as f64).sin())
        .collect();
    let found = lomb(
        &Field::from_array(values).with_times(Some(times)),
        &LombRequest::default(),
        &Silent,
    )
    .unwrap();
    let share = found.significant() as f64 / 600.0;
    println!("{share} of records above a level of 0.05");
    assert!((0.015..0.065).contains(&share), "{share}");
}

#[test]
fn regress_uneven_times_of_a_table_are_kept() {
    let folder = std::env::temp_dir().join(format!("lomb-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("uneven.csv");
    let times: Vec<f64> = (0..40)
        .map(|n| 2.0 + n as f64 + if n > 20 { 50.0 } else { 0.2 * (n % 3) as f64 })
        .collect();
    let rows = times
        .iter()
        .map(|t| format!("{t},{},{}\n", (0.9 * t).cos(), (0.4 * t).sin()));
    std::fs::write(&path, format!("time,a,b\n{}", rows.collect::<String>())).unwrap();
    assert!(matches!(
        Field::open(&path, &OpenOptions::default()),
        Err(Error::Input { .. })
    ));
    let options = OpenOptions {
        uneven: true,
        ..OpenOptions::default()
    };
    let field = Field::open(&path, &options).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(field.is_uneven());
    assert_eq!((field.times(), field.n_sites()), (times, 2));
    let found = lomb(
        &field,
        &LombRequest {
            highest: Some(0.3),
            ..LombRequest::default()
        },
        &Silent,
    )
    .unwrap();
    for (peak, expected) in found.peaks.iter().zip([0.9 / TAU, 0.4 / TAU]) {
        assert!(
            (peak[0] - expected).abs() < 2e-3 && peak[1] > 0.97,
            "{peak:?}"
        );
    }
}

#[test]
fn regress_what_is_refused_and_what_has_no_variance() {
    let option = |field: &Field, request: &LombRequest| match lomb(field, request, &Silent) {
        Err(Error::Request { option, .. }) => option,
        other => panic!("{:?}", other.map(|found| found.peaks)),
    };
    let base = LombRequest::default();
    let field = record();
    assert_eq!(
        option(&Field::from_array(Array2::zeros((7, 2))), &base),
        "field"
    );
    assert_eq!(
        option(
            &field,
            &LombRequest {
                alpha: 1.0,
                ..base.clone()
            }
        ),
        "significance"
    );
    assert_eq!(
        option(
            &field,
            &LombRequest {
                oversampling: 0.5,
                ..base.clone()
            }
        ),
        "oversampling"
    );
    assert_eq!(
        option(
            &field,
            &LombRequest {
                highest: Some(-1.0),
                ..base.clone()
            }
        ),
        "highest"
    );
    let tight = LombRequest {
        memory: Some(1000),
        ..base.clone()
    };
    assert!(matches!(
        lomb(&field, &tight, &Silent),
        Err(Error::Memory { .. })
    ));
    let mut values = Array2::from_elem((64, 2), 0.1);
    values.column_mut(1).fill(f64::NAN);
    let still = lomb(&Field::from_array(values), &base, &Silent).unwrap();
    assert!(still.power.iter().all(|p| p.is_nan()) && still.significant() == 0);
}

#[test]
fn regress_threads_do_not_matter() {
    let of = |axis, threads| {
        let request = LombRequest {
            axis,
            threads: Some(threads),
            ..LombRequest::default()
        };
        let found = lomb(&record(), &request, &Silent);
        found.map(|found| found.density.mapv(f64::to_bits))
    };
    assert_eq!(
        of(LombAxis::Time, 1).unwrap(),
        of(LombAxis::Time, 3).unwrap()
    );
    // Two sites are too few along space.
    assert!(of(LombAxis::Space, 1).is_err());
}
