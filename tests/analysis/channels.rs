//! Channels with faults are named, and only these; energy that folds down from above the Nyquist frequency.

use ndarray::{Array2, s};
use serde_json::json;
use test_support::changed;
use test_support::fields::{TEMPORAL, analyzed, asking, noise, struck};
use wavecascade::Field;
use wavecascade::analyze::{Request, Results, Warning, analyze, channel_findings};
use wavecascade::field::OpenOptions;
use wavecascade::observer::Silent;
use wavecascade::prepare::Examined;
use wavecascade::ridges::{RidgesRequest, ridges};
use wavecascade::sheet::Describe;

const TIMES: usize = 1500;

/// A random wave that travels by three samples a site, smooth in time.
fn wave(sites: usize) -> Array2<f64> {
    let white = noise(TIMES + 3 * sites + 40, 1);
    let smooth = |n: usize| -> f64 {
        let lags = (0..40).map(|lag| (lag as f64 - 20.0) / 4.0);
        let weighted = lags
            .enumerate()
            .map(|(lag, t)| white[[n + lag, 0]] * (-0.5 * t * t).exp());
        weighted.sum::<f64>() / 2.7
    };
    let record: Vec<f64> = (0..TIMES + 3 * sites).map(smooth).collect();
    Array2::from_shape_fn((TIMES, sites), |(n, j)| record[n + 3 * (sites - 1 - j)])
}

fn field(values: Array2<f64>) -> Field {
    let mut field = Field::from_array(values);
    field.space.step = 0.5;
    field.space.unit = Some("m".into());
    field
}

fn named(warnings: &[Warning]) -> Vec<(&'static str, Vec<usize>)> {
    let sites = |warning: &Warning| serde_json::from_value(warning.numbers["sites"].clone()).ok();
    let channels = warnings.iter().filter_map(|w| Some((w.code, sites(w)?)));
    channels.collect()
}

#[test]
fn val_faults_are_named_with_their_places() {
    let mut values = wave(24);
    let alone = channel_findings(&field(values.clone()), &Silent).unwrap();
    assert_eq!(alone, []);
    let rough = noise(TIMES, 1);
    values.column_mut(3).fill(0.2);
    values.column_mut(7).mapv_inplace(|v| 1e-3 * v);
    values.column_mut(11).mapv_inplace(|v| v.clamp(-0.7, 0.7));
    values.column_mut(15).scaled_add(0.4, &rough.column(0));
    values.column_mut(20).mapv_inplace(|v| 1e3 * v);
    let found = channel_findings(&field(values.clone()), &Silent).unwrap();
    let expected = [
        ("dead-channels", vec![3]),
        ("saturated-channels", vec![11]),
        ("quiet-channels", vec![7]),
        ("loud-channels", vec![20]),
        ("noisy-channels", vec![15]),
    ];
    assert_eq!(named(&found), expected);
    assert_eq!(found[0].numbers, json!({"sites": [3], "positions": [1.5]}));
    assert_eq!(found[0].message, "site 3 at 1.5 m: constant");
    let whole = analyzed(&field(values), &Request::default()).warnings;
    assert_eq!(named(&whole), expected);
}

/// Half of the sites turned in sign, late, or louder, and one of them.
#[test]
fn val_construction_sites_out_of_step_are_named() {
    let values = wave(40);
    for (sites, code) in [(20..40, "reversed-channels"), (7..8, "reversed-channels")]
        .into_iter()
        .chain([(20..40, "late-channels"), (24..40, "gain-steps")])
    {
        let change = |n: usize, j: usize| match code {
            "late-channels" => values[[n.saturating_sub(25), j]],
            "gain-steps" => 6.0 * values[[n, j]],
            _ => -values[[n, j]],
        };
        let changed = Array2::from_shape_fn(values.dim(), |(n, j)| match sites.contains(&j) {
            true => change(n, j),
            false => values[[n, j]],
        });
        let field = field(changed);
        let found = channel_findings(&field, &Silent).unwrap();
        let waves = Examined {
            found: ridges(&[&field], &RidgesRequest::default(), &Silent).unwrap(),
            channels: found.clone(),
        };
        let are_told = !waves.describe().answer.contains("out of step");
        assert_eq!(are_told, code == "gain-steps");
        let named_sites = match code {
            "gain-steps" => vec![sites.start],
            _ => sites.clone().collect(),
        };
        assert_eq!(named(&found), [(code, named_sites)]);
        let numbers = &found[0].numbers;
        match code {
            "late-channels" => assert_eq!(numbers["samples"], json!(vec![25.0; sites.len()])),
            "gain-steps" => {
                let [ratio, error] =
                    ["ratios", "ratio_errors"].map(|name| numbers[name][0].as_f64().unwrap());
                assert!((ratio - 6.0).abs() < 0.03, "{ratio} {error}");
                assert!(error < 0.03, "{ratio} {error}");
            }
            _ => {}
        }
    }
}

#[test]
fn val_what_is_quiet_by_physics_is_no_fault() {
    let none = |what: &str, field: &Field| {
        let found = channel_findings(field, &Silent).unwrap();
        assert_eq!(named(&found), [], "{what}");
    };
    // A standing wave with a node at site 8, to rounding and to a thousandth.
    for shift in [0.0, 1e-3] {
        let standing = Array2::from_shape_fn((800, 17), |(n, j)| {
            let x = std::f64::consts::PI * (j as f64 + shift) / 8.0;
            x.sin() * (0.2 * n as f64).cos() + 0.3 * (2.0 * x).sin() * (0.37 * n as f64).cos()
        });
        let inside = standing.slice(s![.., 1..16]).to_owned();
        none("standing wave", &field(inside.clone()));
        // Nothing at all moves at a node, or at a fixed end.
        let mut still = standing;
        for site in [0, 8, 16] {
            still.column_mut(site).fill(0.0);
        }
        none("nodes", &field(still));
    }
    // One standing wave of many frequencies: both sides of its nodes have opposite signs.
    let smooth = wave(1);
    let standing = Array2::from_shape_fn((TIMES, 60), |(n, j)| {
        smooth[[n, 0]] * (0.157 * (j as f64 + 0.3)).sin()
    });
    none("one mode", &field(standing));
    // A front that has reached half of the sites: nothing but zeros ahead of it.
    let front = Array2::from_shape_fn((600, 40), |(n, j)| {
        let t = n as f64 - 30.0 * j as f64;
        let smooth = (1.0 - (-t.max(0.0) / 40.0).exp()).powi(6);
        if t > 0.0 {
            smooth * (0.1 * t).cos()
        } else {
            0.0
        }
    });
    none("front", &field(front));
    // Chains, as if they were measured. Bodies in free flight do stay on their largest velocity.
    for (end, samples) in [(80.0, 1024), (12.0, 512)] {
        let run = struck(40, end, samples);
        let found = channel_findings(&field(run.velocity.clone()), &Silent).unwrap();
        let others = found.iter().filter(|w| w.code != "saturated-channels");
        assert_eq!(others.count(), 0, "{found:?}");
    }
    let root = env!("CARGO_MANIFEST_DIR");
    let shipped = format!("{root}/examples/data/lattice_impact.npy");
    none(
        "lattice",
        &Field::open(&shipped, &OpenOptions::default()).unwrap(),
    );
    none("noise", &field(noise(600, 30)));
}

#[test]
fn val_sites_that_are_left_out_change_no_others() {
    let values = wave(24);
    let temporal = Request {
        results: Results {
            temporal: true,
            short_time: true,
            ..Results::NONE
        },
        ..Request::default()
    };
    let without = changed(temporal.clone(), |it| it.without_sites = vec![0, 9, 23]);
    let mut faulty = values.clone();
    faulty.column_mut(9).fill(f64::NAN);
    faulty.column_mut(0).mapv_inplace(|v| 1e6 * v);
    let (all, all_spectra) = analyze(&field(values), &temporal).unwrap();
    let (some, spectra) = analyze(&field(faulty.clone()), &without).unwrap();
    let (all_spectra, spectra) = (all_spectra.temporal.unwrap(), spectra.temporal.unwrap());
    for j in 0..24 {
        let [a, b] = [&all_spectra, &spectra].map(|spectra| spectra.column(j));
        let [a_along, b_along] = [&all, &some].map(|found| found.along_space.as_ref().unwrap());
        match [0, 9, 23].contains(&j) {
            true => {
                assert!(b.iter().all(|s| s.is_nan()));
                assert!(b_along.energy[j].is_nan() && b_along.centroid[j].is_nan());
            }
            false => {
                assert_eq!(a, b);
                assert_eq!(a_along.centroid[j], b_along.centroid[j]);
            }
        }
    }
    assert_eq!(named(&some.warnings), [("sites-left-out", vec![0, 9, 23])]);
    let followed: Vec<usize> = some
        .short_time
        .unwrap()
        .spectra
        .iter()
        .map(|s| s.index)
        .collect();
    assert_eq!(followed, [1, 12, 22]);
    let refused = |request: Request| {
        let error = analyze(&field(faulty.clone()), &request).unwrap_err();
        test_support::fields::option(error)
    };
    let with_space = asking(|it| it.without_sites = vec![0, 9]);
    assert_eq!(refused(with_space), "without-sites");
    for (without_sites, reference_site, option) in [
        (vec![24], None, "without-sites"),
        ((0..24).collect(), None, "without-sites"),
        (vec![9], Some(9), "reference-site"),
    ] {
        let request = Request {
            without_sites,
            reference_site,
            ..temporal.clone()
        };
        assert_eq!(refused(request), option);
    }
}

fn aliases(values: Array2<f64>) -> bool {
    let temporal = Request {
        results: TEMPORAL,
        ..Request::default()
    };
    let found = analyzed(&field(values), &temporal).warnings;
    found.iter().any(|warning| warning.code == "aliasing-time")
}

/// A sweep to `end` times the Nyquist frequency, as sampled, and after a low-pass filter from 0.7 of it on, made
/// of samples eight times as dense.
fn sweep(end: f64, is_filtered: bool) -> Array2<f64> {
    const DENSE: usize = 8;
    let times = 2048;
    let phase = |n: f64| 0.5 * std::f64::consts::PI * end * n * n / times as f64;
    let reach = 24 * DENSE as isize;
    let weight = |lag: isize| {
        let t = lag as f64 / DENSE as f64;
        let x = 0.7 * std::f64::consts::PI * t;
        let sinc = if lag == 0 { 1.0 } else { x.sin() / x };
        let taper = (0.5 * std::f64::consts::PI * lag as f64 / reach as f64)
            .cos()
            .powi(2);
        0.7 * sinc * taper / DENSE as f64
    };
    Array2::from_shape_fn((times, 4), |(n, j)| {
        let at = n as f64 + 1.7 * j as f64;
        match is_filtered {
            false => phase(at).cos(),
            true => (-reach..=reach)
                .map(|lag| weight(lag) * phase(at + lag as f64 / DENSE as f64).cos())
                .sum(),
        }
    })
}

#[test]
fn val_a_sweep_folds_unless_it_is_filtered() {
    for end in [1.3, 1.8, 2.6] {
        assert!(aliases(sweep(end, false)), "{end}");
        assert!(!aliases(sweep(end, true)), "{end}");
    }
    assert!(!aliases(sweep(0.85, false)));
    assert!(!aliases(noise(2048, 4)));
}

/// Random smooth fields: Gaussian and power-law spectra down to nothing at the top.
#[test]
fn val_smooth_fields_are_not_said_to_fold() {
    let white = noise(700, 4 * 120);
    let mut alarms = 0;
    for trial in 0..120 {
        // Widths of 0.9 to 8 samples.
        let width = 0.9 * (8.0_f64 / 0.9).powf(trial as f64 / 119.0);
        let reach = (6.0 * width).ceil() as usize;
        let values = Array2::from_shape_fn((512, 4), |(n, j)| {
            let lags = (0..2 * reach + 1).map(|lag| (lag as f64 - reach as f64) / width);
            let column = white.column(4 * trial + j);
            let weighted = lags
                .enumerate()
                .map(|(lag, t)| column[n + lag] * (-0.5 * t * t).exp());
            weighted.sum::<f64>()
        });
        alarms += usize::from(aliases(values));
    }
    assert_eq!(alarms, 0);
}
