//! Filters in frequency and wavenumber: plane waves that pass or not, and what adds up.

use std::f64::consts::TAU;

use ndarray::Array2;
use test_support::fields::{noise, stepped};
use test_support::made::values;
use test_support::{changed, worst};
use wavecascade::analyze;
use wavecascade::observer::Silent;
use wavecascade::transform::{Passband, Travelling};

const SHAPE: (usize, usize) = (120, 50);
const STEPS: (f64, f64) = (0.5, 2.0);

/// `cos(k x - omega t + phase)` of bins m and q; `q > 0` travels towards +x.
fn wave(m: i32, q: i32, phase: f64) -> Array2<f64> {
    Array2::from_shape_fn(SHAPE, |(n, j)| {
        // Whole turns are taken off while they are whole numbers.
        let turns = |bin: i32, at: usize, length: usize| {
            (i64::from(bin) * at as i64).rem_euclid(length as i64) as f64 / length as f64
        };
        let (in_space, in_time) = (turns(q, j, SHAPE.1), turns(m, n, SHAPE.0));
        (TAU * (in_space - in_time) + phase).cos()
    })
}

fn frequency(m: i32) -> f64 {
    f64::from(m) / (SHAPE.0 as f64 * STEPS.0)
}

fn wavenumber(q: i32) -> f64 {
    TAU * f64::from(q) / (SHAPE.1 as f64 * STEPS.1)
}

fn filtered(samples: &Array2<f64>, band: &Passband) -> Array2<f64> {
    let field = stepped(samples.clone(), STEPS.0, STEPS.1);
    let passed = analyze::filtered(&field, band, false, None, &Silent);
    values(&passed.unwrap().field)
}

#[track_caller]
fn same(a: &Array2<f64>, b: &Array2<f64>, bound: f64) {
    let apart = worst((a - b).iter().map(|v| v.abs()));
    assert!(apart < bound, "{apart:e}");
}

#[test]
fn val_plane_waves_pass_where_they_lie() {
    let slow = wave(6, 10, 0.3);
    let fast = wave(30, 4, 1.1);
    let back = wave(20, -9, -0.4);
    let all = &slow + &fast + &back;
    let speed = |m: i32, q: i32| TAU * frequency(m) / wavenumber(q).abs();
    let near = |x: f64| Some((0.99 * x, 1.01 * x));
    let passes = |change: &dyn Fn(&mut Passband), expected: &Array2<f64>, bound| {
        let band = changed(Passband::default(), change);
        same(&filtered(&all, &band), expected, bound);
    };
    passes(&|it| it.frequency = Some((0.0, frequency(6))), &slow, 2e-15);
    passes(&|it| it.wavenumber = near(wavenumber(4)), &fast, 2e-15);
    passes(&|it| it.speed = near(speed(20, 9)), &back, 2e-15);
    let toward = |it: &mut Passband| it.travelling = Travelling::TowardPlusX;
    passes(&toward, &(&slow + &fast), 3e-15);
}

/// Even and odd lengths; energies add, since the parts share no bin.
#[test]
fn directions_add_up_to_the_field() {
    for shape in [(120, 50), (121, 49), (64, 1), (1, 30), (251, 22)] {
        let values = 0.1 * noise(shape.0, shape.1);
        let mut sum = Array2::<f64>::zeros(shape);
        let mut energy = 0.0;
        use Travelling::{Nowhere, TowardMinusX, TowardPlusX};
        for travelling in [TowardPlusX, TowardMinusX, Nowhere] {
            let band = changed(Passband::default(), |it| it.travelling = travelling);
            let part = filtered(&values, &band);
            energy += part.iter().map(|v| v * v).sum::<f64>();
            sum += &part;
        }
        same(&sum, &values, 2e-15);
        let whole: f64 = values.iter().map(|v| v * v).sum();
        let residual = energy / whole - 1.0;
        assert!(residual.abs() < 3e-14, "{shape:?}: {residual:e}");
        let all = filtered(&values, &Passband::default());
        same(&all, &values, 1.5e-15);
    }
}

#[test]
fn bands_that_end_before_they_begin_are_refused() {
    for band in [(2.0, 1.0), (-1.0, 1.0), (f64::NAN, 1.0)] {
        let band = changed(Passband::default(), |it| it.speed = Some(band));
        assert!(band.check().is_err());
    }
}
