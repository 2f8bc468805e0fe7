//! A field with a known tendency: budgets of Burgers' equation against independent references.

use ndarray::Array2;
use test_support::fields::Burgers;
use wavecascade::budget::{Tendency, TendencyBudget, tendency_budget};

const VISCOSITY: f64 = 0.1;
const LENGTH: f64 = 16.0;
const DT: f64 = 0.05;

fn of(u: &Array2<f64>) -> TendencyBudget {
    let burgers = Burgers {
        viscosity: VISCOSITY,
        length: LENGTH,
    };
    tendency_budget(u.view(), [0.0, DT], LENGTH, &burgers).unwrap()
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
    for (m, expected) in [(1, -a * a * b * k / 4.0), (2, 0.0)] {
        let off = (budget.flux[[0, m]] - expected).abs();
        assert!(off < 1e-14 * a * a * b * k, "{m}: {off:e}");
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
    let run =
        |u: &Array2<f64>, time, length| tendency_budget(u.view(), time, length, &Blows).map(|_| ());
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
    let budget = tendency_budget(still.view(), [0.0, 0.1], 1.0, &Blows).unwrap();
    assert!(budget.closure.value().is_some_and(f64::is_nan));
}
