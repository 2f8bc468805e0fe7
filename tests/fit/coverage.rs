//! Intervals hold as often as they say, and noise is rarely called a misfit.

use rayon::prelude::*;

use super::made::Measurement;

const FIELDS: u64 = 60;

fn scene(kappa: f64, speed: f64, tangent: f64) -> String {
    format!(
        "sites = 6\nstiffness_ratio = {kappa:?}\nstriker_velocity = {speed:?}\ntangent = {tangent:?}"
    )
}

/// How many of 60 fields of three values the intervals hold, and how many are called a misfit.
fn held(correlation: f64) -> (usize, usize) {
    let each = |seed: u64| {
        let mut held = 0;
        let made = Measurement {
            noise: 0.05,
            correlation,
            seed,
            ..Measurement::of(&[1, 3, 5], 120, 10.0)
        };
        let truth = [
            ("stiffness_ratio", 2.0),
            ("striker_velocity", 1.0),
            ("tangent", 0.05),
        ];
        let names = truth.map(|(name, _)| name);
        let found = made
            .fit(&scene(2.0, 1.0, 0.05), &scene(1.95, 1.02, 0.04), &names)
            .unwrap();
        for (name, value) in truth {
            let of = found.value(name).unwrap();
            held += usize::from(of.low <= value && value <= of.high);
        }
        (held, usize::from(found.misfit.is_some()))
    };
    let all = (0..FIELDS).into_par_iter().map(each);
    let (held, missed) = all.reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    (held, missed)
}

/// 180 intervals of 95 %: 171 with a standard deviation of 3.
#[test]
fn val_intervals_hold_with_white_and_coloured_noise() {
    for correlation in [0.0, 0.7] {
        let (held, missed) = held(correlation);
        assert!((163..=178).contains(&held), "{correlation}: {held}");
        assert!(missed <= 5, "{correlation}: {missed}");
    }
}
