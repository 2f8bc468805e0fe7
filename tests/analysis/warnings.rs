//! Warnings fire where there is something to do, and nowhere else.

use ndarray::Array2;
use serde_json::json;
use test_support::changed;
use test_support::fields::{TEMPORAL, analyzed, asking, noise, pulse, struck};
use wavecascade::Field;
use wavecascade::analyze::{Request, Results};

fn codes(field: &Field, request: &Request) -> Vec<&'static str> {
    analyzed(field, request)
        .warnings
        .iter()
        .map(|warning| warning.code)
        .collect()
}

/// A floor of white noise fills the top of the axis without anything folding down; a wave there does not
/// fill the rest.
#[test]
fn val_a_floor_of_noise_is_no_aliasing() {
    let signal = pulse(4000, 48, 2);
    let mut values = Array2::zeros((4000, 48));
    signal.read_time_major(0..4000, 0..48, values.as_slice_mut().unwrap());
    let floor = &values + &(0.03 * noise(4000, 48));
    let found = codes(&Field::from_array(floor), &Request::default());
    assert!(
        !found.iter().any(|code| code.starts_with("aliasing")),
        "{found:?}"
    );

    let high = Array2::from_shape_fn((4000, 48), |(n, _)| 0.05 * (3.0 * n as f64).sin());
    let found = codes(&Field::from_array(values + high), &Request::default());
    assert!(found.contains(&"aliasing-time"), "{found:?}");
}

#[test]
fn no_warning_on_what_is_in_order() {
    let all = Request::default();
    assert_eq!(codes(&pulse(500, 40, 2), &all), [""; 0]);
    // It is still on its way at the end.
    assert_eq!(codes(&pulse(100, 40, 2), &all), [""; 0]);
    assert_eq!(codes(&struck(40, 80.0, 1024).to_field(), &all), [""; 0]);
}

#[test]
fn what_is_not_asked_for_is_not_warned_of() {
    // A ramp along space, a tone along time: ends of profiles do not meet.
    let ramp = Array2::from_shape_fn((256, 30), |(n, j)| {
        (j as f64 - 8.5) * (std::f64::consts::TAU * 16.0 * n as f64 / 256.0).sin()
    });
    let field = Field::from_array(ramp);
    let only = |results| asking(|it| it.results = results);
    let spatial = changed(Results::NONE, |it| it.spatial = true);
    assert_eq!(codes(&field, &only(spatial)), ["leakage-space"]);
    assert_eq!(codes(&field, &only(TEMPORAL)), [""; 0]);
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

#[test]
fn val_times_of_zeros_are_named() {
    let of = |rows: &[std::ops::Range<usize>]| {
        let mut field = noise(600, 8);
        for rows in rows {
            field.slice_mut(ndarray::s![rows.clone(), ..]).fill(0.0);
        }
        let warnings = analyzed(&Field::from_array(field), &Request::default()).warnings;
        let told = warnings.into_iter().find(|w| w.code == "zero-times");
        told.map(|told| told.numbers)
    };
    let expected = json!({"times": 90, "first": 100, "last": 409});
    assert_eq!(of(&[100..180, 400..410]), Some(expected));
    // At rest before and after; a single crossing of zero.
    assert_eq!(of(&[0..50, 300..301, 590..600]), None);
}

#[test]
fn val_white_noise_of_any_shape_is_in_order() {
    let all = Request::default();
    for shape in [
        (600, 1),
        (20, 1),
        (40, 3),
        (64, 5),
        (128, 4),
        (1000, 6),
        (20, 2),
        (2000, 3),
        (2000, 64),
        (100, 1000),
    ] {
        let field = Field::from_array(noise(shape.0, shape.1));
        assert_eq!(codes(&field, &all), [""; 0], "{shape:?}");
    }
}

/// Velocities of a struck chain as a plain array: neighbours differ as much as its ends.
#[test]
fn regress_ends_of_a_chain_are_no_jump() {
    for time in [30.0, 80.0] {
        let velocity = struck(40, time, 1024).velocity.clone();
        let found = codes(&Field::from_array(velocity), &Request::default());
        assert!(!found.contains(&"leakage-space"), "{found:?}");
    }
}

#[test]
fn val_a_single_site_has_no_direction() {
    let one = analyzed(&Field::from_array(noise(600, 1)), &Request::default());
    let direction = one.direction.unwrap();
    assert!(direction.undirected.is_nan() && direction.toward_plus_x.is_nan());
    assert!(one.direction_by_frequency.is_none());
}
