//! A field with a known tendency: budgets of Burgers' equation against independent references.

use std::fs::File;

use ndarray::{Array1, Array2, s};
use ndarray_npy::{NpzReader, read_npy};
use wavecascade::budget::{Burgers, Tendency, TendencyBudget, tendency_budget};

const VISCOSITY: f64 = 0.1;
const LENGTH: f64 = 16.0;
const DT: f64 = 0.05;

fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |m, x| m.max(x.abs()))
}

fn of(u: &Array2<f64>) -> TendencyBudget {
    let burgers = Burgers::new(VISCOSITY, LENGTH, u.ncols()).unwrap();
    tendency_budget(u.view(), [0.0, DT], LENGTH, &burgers).unwrap()
}

/// `ref_budget.npz` (numpy 2.4.6, 3/2-rule), of the wave computed by Chebfun's `spin`.
#[test]
fn val_numpy_budget_of_the_burgers_wave() {
    let (Some(field), Some(reference)) = (
        test_support::shared::shared_data("burgers_sine/field.npy"),
        test_support::shared::shared_data("burgers_sine/ref_budget.npz"),
    ) else {
        return;
    };
    let u: Array2<f64> = read_npy(field).unwrap();
    let mut reference = NpzReader::new(File::open(reference).unwrap()).unwrap();
    let mut array = |name: &str| -> Array2<f64> { reference.by_name(name).unwrap() };
    let budget = of(&u);
    for (found, name) in [
        (&budget.energy, "E"),
        (&budget.transfer, "T"),
        (&budget.dissipation, "D"),
        (&budget.flux, "Pi"),
    ] {
        let expected = array(name);
        assert_eq!(found.dim(), expected.dim());
        let off = largest(&(found - &expected)) / largest(&expected);
        assert!(off < 5e-15, "{name}: {off:e}");
    }
    let k: Array1<f64> = reference.by_name("k_angular").unwrap();
    for (found, expected) in budget.wavenumber.iter().zip(&k) {
        assert!((found - expected).abs() <= 1e-14 * expected);
    }

    let change: Array1<f64> = reference.by_name("dE").unwrap();
    let integrated: Array1<f64> = reference.by_name("int_T_plus_D").unwrap();
    let last = budget.integrated.row(u.nrows() - 1).to_owned();
    let scale = largest(&change);
    // The reference integrates less accurately: its own closure is 3.8e-9.
    let off = largest(&(&last - &integrated)) / scale;
    assert!((2e-9..5e-9).contains(&off), "{off:e}");
    let off = largest(&(&last - &change)) / scale;
    assert!(off < 1e-11, "{off:e}");
    let closure = budget.closure.value().unwrap();
    assert!((1e-13..1e-9).contains(&closure), "{closure:e}");
    // The initial single wave exchanges no energy.
    for row in budget.transfer.rows().into_iter().skip(1) {
        assert!(
            row.sum().abs() < 1e-13 * largest(row),
            "{}",
            row.sum() / largest(row)
        );
    }
    assert!(budget.identities.energy_sum < 1e-15);
}

/// With every other sample the closure is worse, by the order of polynomials through 8 samples.
#[test]
fn val_calculus_closure_falls_with_the_sampling_step() {
    let Some(field) = test_support::shared::shared_data("burgers_sine/field.npy") else {
        return;
    };
    let u: Array2<f64> = read_npy(field).unwrap();
    let burgers = Burgers::new(VISCOSITY, LENGTH, u.ncols()).unwrap();
    let closure = |every: usize| {
        let u = u.slice(s![..;every, ..]);
        let budget = tendency_budget(u, [0.0, DT * every as f64], LENGTH, &burgers).unwrap();
        budget.closure.value().unwrap()
    };
    let [four, eight] = [closure(4), closure(8)];
    let order = (eight / four).log2();
    assert!((6.0..10.0).contains(&order), "{four:e} {eight:e} {order}");
}

/// `u = a sin(k x) + b sin(2 k x)`: T moves `a^2 b k / 4` between the two modes, D is
/// `-2 nu k^2 E`.
#[test]
fn val_closed_form_two_waves() {
    let (n, a, b) = (32, 0.7, 0.3);
    let k = 2.0 * std::f64::consts::PI / LENGTH;
    let x = |j: usize| LENGTH * j as f64 / n as f64;
    let u = Array2::from_shape_fn((2, n), |(_, j)| {
        a * (k * x(j)).sin() + b * (2.0 * k * x(j)).sin()
    });
    let budget = of(&u);
    // -(u^2/2)_x of mode 1 is (a b / 2) k sin(k x), of mode 2 it is -(a^2 / 2) k sin(2 k x).
    let expected = [0.0, a * a * b * k / 4.0, -a * a * b * k / 4.0];
    for (found, expected) in budget.transfer.row(0).iter().zip(expected) {
        assert!(
            (found - expected).abs() < 1e-17 + 1e-14 * a * a * b * k,
            "{found}"
        );
    }
    for (m, amplitude) in [(1, a), (2, b)] {
        let energy = amplitude * amplitude / 4.0;
        assert!((budget.energy[[0, m]] - energy).abs() < 1e-16);
        let expected = -2.0 * VISCOSITY * (k * m as f64).powi(2) * energy;
        assert!((budget.dissipation[[0, m]] / expected - 1.0).abs() < 1e-14);
    }
}

struct Blows;

impl Tendency for Blows {
    fn evaluate(&self, _: f64, _: &[f64], conservative: &mut [f64], dissipative: &mut [f64]) {
        conservative.fill(f64::NAN);
        dissipative.fill(0.0);
    }
}

#[test]
fn val_hostile_fields_are_refused_and_no_number_is_made_up() {
    let still = Array2::<f64>::zeros((4, 8));
    let budget = of(&still);
    assert_eq!(budget.closure.value(), Some(0.0));
    let run = |u: &Array2<f64>, time, length| {
        let burgers = Burgers::new(VISCOSITY, 1.0, 8).unwrap();
        tendency_budget(u.view(), time, length, &burgers).map(|_| ())
    };
    assert!(run(&still, [0.0, 0.1], 1.0).is_ok());
    for (u, time, length) in [
        (Array2::zeros((1, 8)), [0.0, 0.1], 1.0),
        (Array2::zeros((4, 2)), [0.0, 0.1], 1.0),
        (Array2::from_elem((4, 8), f64::NAN), [0.0, 0.1], 1.0),
        (still.clone(), [0.0, 0.0], 1.0),
        (still.clone(), [f64::NAN, 0.1], 1.0),
        (still.clone(), [0.0, 0.1], f64::INFINITY),
    ] {
        assert!(run(&u, time, length).unwrap_err().is_usage());
    }
    assert!(Burgers::new(-1.0, 1.0, 8).unwrap_err().is_usage());
    assert!(Burgers::new(0.1, 0.0, 8).unwrap_err().is_usage());
    assert!(Burgers::new(0.1, 1.0, 2).unwrap_err().is_usage());
    let budget = tendency_budget(still.view(), [0.0, 0.1], 1.0, &Blows).unwrap();
    assert!(budget.closure.value().is_some_and(f64::is_nan));
}
