//! Warnings fire where there is something to do, and nowhere else.

use ndarray::Array2;
use test_support::fields::{analyzed, noise, pulse, struck};
use wavecascade::Field;
use wavecascade::analyze::{Request, Results, Warning};

fn codes(field: &Field, request: &Request) -> Vec<&'static str> {
    analyzed(field, request)
        .warnings
        .iter()
        .map(Warning::code)
        .collect()
}

#[test]
fn no_warning_on_what_is_in_order() {
    let all = Request::default();
    assert_eq!(codes(&pulse(500, 40, 2), &all), [""; 0]);
    // It is still on its way at the end.
    assert_eq!(codes(&pulse(100, 40, 2), &all), [""; 0]);
    for shape in [(2000, 64), (300, 8), (100, 1000)] {
        assert_eq!(
            codes(&Field::from_array(noise(shape.0, shape.1)), &all),
            [""; 0],
            "{shape:?}"
        );
    }
    assert_eq!(codes(&struck(40, 80.0, 1024).to_field(), &all), [""; 0]);
}

#[test]
fn what_is_not_asked_for_is_not_warned_of() {
    // A ramp along space, a tone along time: ends of profiles do not meet.
    let ramp = Array2::from_shape_fn((256, 30), |(n, j)| {
        (j as f64 - 8.5) * (std::f64::consts::TAU * 16.0 * n as f64 / 256.0).sin()
    });
    let field = Field::from_array(ramp);
    let only = |results| Request {
        results,
        ..Request::default()
    };
    let spatial = Results {
        spatial: true,
        ..Results::NONE
    };
    let temporal = Results {
        temporal: true,
        ..Results::NONE
    };
    assert_eq!(codes(&field, &only(spatial)), ["leakage-space"]);
    assert_eq!(codes(&field, &only(temporal)), [""; 0]);
}

#[test]
fn warnings_fire_where_there_is_something_to_do() {
    let all = Request::default();
    let has = |field: &Field, code| codes(field, &all).contains(&code);
    // Half a period too many.
    let tone = Array2::from_shape_fn((256, 8), |(n, j)| (0.11 * n as f64 + 0.4 * j as f64).cos());
    assert!(has(&Field::from_array(tone), "leakage-time"));
    // A pulse with a tail of energy up to Nyquist.
    let steep = Array2::from_shape_fn((400, 8), |(n, j)| {
        let t = n as f64 - 50.3 - 7.1 * j as f64;
        (-(t / 0.8).powi(2)).exp()
    });
    assert!(has(&Field::from_array(steep), "aliasing-time"));
    // It grows until the end.
    let growing = Array2::from_shape_fn((400, 8), |(n, j)| {
        (0.02 * n as f64).exp() * (0.9 * (n + j) as f64).sin()
    });
    assert!(has(&Field::from_array(growing), "transient-cut"));
    assert!(has(
        &Field::from_array(Array2::from_elem((64, 8), 2.5)),
        "static"
    ));
    let clipped = Array2::from_shape_fn((400, 8), |(n, j)| {
        (0.11 * n as f64 + j as f64).sin().clamp(-0.5, 0.5)
    });
    assert!(has(&Field::from_array(clipped), "saturated-channels"));
}
