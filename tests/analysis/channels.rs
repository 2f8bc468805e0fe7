//! Channels out of step, and sites that are left out; `said.txt` has the faults that are named.

use ndarray::{Array2, s};
use test_support::changed;
use test_support::fields::{asking, noise};
use wavecascade::Field;
use wavecascade::analyze::{Request, Results, Warning, analyze, channel_findings};
use wavecascade::arrays::LargeArray;
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
        let weighted = |(lag, t): (usize, f64)| white[[n + lag, 0]] * (-0.5 * t * t).exp();
        lags.enumerate().map(weighted).sum::<f64>() / 2.7
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

/// Of half of the sites turned in sign the waves are not told; of half that are louder they are.
#[test]
fn val_construction_sites_out_of_step_are_named() {
    for (factor, code) in [(-1.0, "reversed-channels"), (6.0, "gain-steps")] {
        let mut values = wave(40);
        values.slice_mut(s![.., 20..]).mapv_inplace(|v| factor * v);
        let field = field(values);
        let channels = channel_findings(&field, &Silent).unwrap();
        let numbers = &channels[0].numbers;
        match factor > 0.0 {
            true => {
                assert_eq!(named(&channels), [(code, vec![20])]);
                let [ratio, error] = ["ratios", "ratio_errors"].map(|name| &numbers[name][0]);
                let [ratio, error] = [ratio, error].map(|it| it.as_f64().unwrap());
                let off = (ratio - factor).abs();
                assert!(off < 0.03 && error < 0.03, "{ratio} {error}");
            }
            false => assert_eq!(named(&channels), [(code, (20..40).collect())]),
        }
        let found = ridges(&[&field], &RidgesRequest::default(), &Silent).unwrap();
        let answer = Examined { found, channels }.describe().answer;
        assert_eq!(answer.contains("out of step"), factor < 0.0, "{answer}");
    }
}

/// Three neighbours that are five times as loud: one step up where they begin, one down behind them.
#[test]
fn val_construction_gain_steps_that_are_near() {
    let mut values = wave(40);
    values.slice_mut(s![.., 20..23]).mapv_inplace(|v| 5.0 * v);
    let channels = channel_findings(&field(values), &Silent).unwrap();
    assert_eq!(named(&channels), [("gain-steps", vec![20, 23])]);
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
    for j in 0..24 {
        let [a, b] =
            [&all_spectra, &spectra].map(|of| of[&LargeArray::TEMPORAL_SPECTRUM].column(j));
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
    assert_eq!(some.short_time.unwrap().rows, [1, 12, 22]);
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
