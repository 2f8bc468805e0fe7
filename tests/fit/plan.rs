//! Planned measurements: errors are those of fits, and of closed forms.

use rayon::prelude::*;
use wavecascade::chain::scene::SceneSource;
use wavecascade::field::Quantity;
use wavecascade::fit::Instruments;
use wavecascade::observer::Silent;
use wavecascade::plan::{Criterion, NoiseLevel, PlanRequest, Planned};
use wavecascade::sheet::Describe;

use super::made::Measurement;

/// Normal quantile of 95 % intervals.
const QUANTILE: f64 = 1.959_964;

fn planned(request: &PlanRequest, scene: &str) -> Planned {
    request
        .run(&SceneSource::new(None, scene), &Silent)
        .unwrap()
}

fn chain(more: &str) -> String {
    format!(
        "sites = 12\nstiffness_ratio = 2.0\nstriker_velocity = 1.0\ntangent = 0.02\nend_time = 20.0\nsamples = 300\n{more}"
    )
}

const FREE: [&str; 3] = ["stiffness_ratio", "striker_velocity", "tangent"];

/// A mass on a spring, `v = v0 cos(w t)`, `w^2 = c/m`: information by sums of the derivatives in closed form, at any
/// duration; sampled slowly, behind a filter, `v` needs twice its frequency.
#[test]
fn val_closed_form_oscillator() {
    let scene = "sites = 1\nlaw = \"spring\"\ncoefficient_cell = [1.44]\nstriker_velocity = 2.0\nend_time = 60.0\nsamples = 601\n";
    let request = PlanRequest {
        noise: NoiseLevel::Value(0.05, String::new()),
        ..PlanRequest::of(["coefficient_cell[0]", "striker_velocity"], 1)
    };
    let found = planned(&request, scene);
    let errors = |samples: usize| {
        let mut sums = [0.0; 3];
        for i in 0..samples {
            let (t, w) = (0.1 * i as f64, 1.2f64);
            // Along the logarithms.
            let along = [-0.5 * 2.0 * w * t * (w * t).sin(), 2.0 * (w * t).cos()];
            sums[0] += along[0] * along[0];
            sums[1] += along[0] * along[1];
            sums[2] += along[1] * along[1];
        }
        let determinant = sums[0] * sums[2] - sums[1] * sums[1];
        [sums[2], sums[0]].map(|s| QUANTILE * 0.05 * (s / determinant).sqrt())
    };
    for (i, time) in found.times.iter().enumerate().skip(40) {
        let expected = errors((time / 0.1).round() as usize + 1);
        for (k, expected) in expected.into_iter().enumerate() {
            let off = found.by_time[[i, k]] / expected - 1.0;
            assert!(off.abs() < 2e-5, "{time} {k}: {off:e}");
        }
    }
    // The error of the spring still falls at the end.
    assert!(found.duration > 0.95 * 60.0, "{}", found.duration);
    // 0.191 cycles; the record is 11 of them long.
    assert!(
        (2.0 * 0.18..2.0 * 0.30).contains(&found.rate),
        "{}",
        found.rate
    );
}

/// Fits of 60 noisy measurements at the planned bodies spread as is said, to the error of a spread.
#[test]
fn val_fits_spread_as_planned() {
    let request = PlanRequest {
        noise: NoiseLevel::Value(0.02, String::new()),
        ..PlanRequest::of(FREE, 3)
    };
    let found = planned(&request, &chain(""));
    let samples = 300;
    let made = Measurement::of(&found.chosen, samples, 20.0);
    let clean = made.records(&made.run(&chain("")));
    let size = (clean.iter().map(|v| v * v).sum::<f64>() / clean.len() as f64).sqrt();
    let fitted: Vec<Vec<f64>> = (0..60u64)
        .into_par_iter()
        .map(|seed| {
            let made = Measurement {
                noise: 0.02 / size,
                seed: 900 + seed,
                ..made.clone()
            };
            let fit = made.fit(&chain(""), &chain(""), &FREE).unwrap();
            FREE.iter()
                .map(|name| fit.value(name).unwrap().value)
                .collect()
        })
        .collect();
    for (k, name) in FREE.iter().enumerate() {
        let values: Vec<f64> = fitted.iter().map(|values| values[k]).collect();
        let mean = values.iter().sum::<f64>() / 60.0;
        let spread = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 59.0).sqrt();
        let last = found.by_time.nrows() - 1;
        let said = found.by_time[[last, k]] * mean / QUANTILE;
        // A spread of 60 is known to 9 %.
        assert!(
            (spread / said - 1.0).abs() < 0.25,
            "{name}: {spread} {said}"
        );
        assert!(
            (mean - found.keys[k].value).abs() < 4.0 * said / 60f64.sqrt(),
            "{name}: {mean}"
        );
    }
}

/// The planned bodies are the best of all, by errors of plans of each choice alone; gains and the clock cost something.
#[test]
fn val_identity_no_other_choice_is_better() {
    let worst = |found: &Planned| {
        let last = found.by_time.nrows() - 1;
        (0..3).map(|k| found.by_time[[last, k]]).fold(0.0, f64::max)
    };
    let mut request = PlanRequest {
        criterion: Criterion::Worst,
        bodies: Some((2..12).collect()),
        ..PlanRequest::of(FREE, 2)
    };
    request.noise = NoiseLevel::Value(0.01, String::new());
    let best = planned(&request, &chain(""));
    assert!(best.is_exact && best.chosen.len() == 2);
    let alone = |bodies: Vec<usize>| PlanRequest {
        bodies: Some(bodies),
        ..request.clone()
    };
    for other in [vec![2, 3], vec![4, 9], vec![10, 11], best.chosen.clone()] {
        let found = planned(&alone(other.clone()), &chain(""));
        assert!(worst(&found) >= worst(&best) * (1.0 - 1e-9), "{other:?}");
    }
    let harder = PlanRequest {
        instruments: Instruments {
            time_shift: true,
            gain_error: Some(0.02),
            ..Instruments::default()
        },
        ..alone(best.chosen.clone())
    };
    // What the clock and gains cost each key.
    let (easy, hard) = (&best.by_time, &planned(&harder, &chain("")).by_time);
    for (k, expected) in [1.299, 1.617, 1.051].into_iter().enumerate() {
        let ratio = hard[[299, k]] / easy[[299, k]];
        assert!((ratio / expected - 1.0).abs() < 0.01, "{k}: {ratio}");
    }
}

/// Masses and coefficients are known up to a factor only; more sensors than bodies are refused.
#[test]
fn val_scaling_what_stays_undetermined_is_said() {
    let scene = "sites = 8\ncoefficient_cell = [2.0]\nmass_cell = [1.0]\nstriker_velocity = 1.0\nend_time = 14.0\nsamples = 200\n";
    let request = PlanRequest::of(["coefficient_cell[0]", "mass_cell[0]"], 2);
    let found = planned(&request, scene);
    assert_eq!(
        found.undetermined[0].words,
        "coefficient_cell[0] and mass_cell[0] only as coefficient_cell[0]/mass_cell[0]"
    );
    assert!(found.keys.iter().all(|key| key.planned.is_nan()));
    // Noise of a thousand times the records tells nothing, and says so.
    let loud = PlanRequest {
        noise: NoiseLevel::Share(1000.0),
        ..PlanRequest::of(["coefficient_cell[0]"], 2)
    };
    let answer = planned(&loud, scene).describe().answer;
    assert!(
        answer.contains("coefficient_cell[0] not at all"),
        "{answer}"
    );
    // Wrong options are rows of `command_line/refusals.txt`.
    let strained = PlanRequest {
        quantity: Quantity::StrainRate,
        ..request
    };
    let error = strained.run(&SceneSource::new(None, scene), &Silent);
    let error = error.unwrap_err();
    assert!(error.is_usage() && error.to_string().contains("strain"));
    assert!(NoiseLevel::parse("-1%").is_err() && NoiseLevel::parse("2 mm/s %").is_err());
}
