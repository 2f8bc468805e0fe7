//! Hard cases of localized waves: a wave, or the correct reason why there is none.

use wavecascade::Error;
use wavecascade::localized::{Alternation, Comparison, Family, Search};
use wavecascade::observer::Silent;

fn search(last: usize) -> Search {
    Family::default().search(last).unwrap()
}

fn exact(order: usize) -> f64 {
    search(order).wave(order).unwrap().ratio
}

/// Too few points in time: an error that covers the deviation of the ratio, or no ratio.
#[test]
fn val_finer_grids_too_low_a_resolution() {
    let mut refused = 0;
    for order in [2, 5, 8, 16] {
        let exact = exact(order);
        for points in [20, 60, 100, 120, 150, 200, 260] {
            match search(order).with_most_points(points).wave(order) {
                Ok(wave) => {
                    let off = (wave.ratio / exact - 1.0).abs();
                    let stated = wave.convergence.error();
                    assert!(off <= stated, "{order}, {points}: {off:e} {stated:e}");
                }
                Err(Error::Unresolved { .. }) => refused += 1,
                Err(error) => panic!("{order}: {error}"),
            }
        }
    }
    assert!((10..28).contains(&refused), "{refused}");
}

/// Orders above 15, the last ones beyond the documented range.
#[test]
fn regress_high_orders() {
    let search = search(24);
    for order in [16, 19, 24] {
        let wave = search.wave(order).unwrap();
        assert_eq!(wave.order, order);
        let stated = wave.convergence.error();
        assert!(stated < 2e-8, "{order}: {stated:e}");
    }
}

/// Small exponents: the fast part is below the slow wave's curvature, so its maxima cannot be
/// counted. The waves lie close to the estimates of their orders, their ratios vary with the
/// exponent as those of one order do, and the waves travel.
#[test]
fn val_estimates_and_chains_small_exponents() {
    for order in 2..=3 {
        let mut last: Option<f64> = None;
        for exponent in [1.5, 1.4, 1.3, 1.2] {
            let family = Family {
                alternation: Alternation::Mass,
                exponent,
            };
            let search = family.search(order).unwrap();
            let wave = search.wave(order).unwrap();
            assert_eq!(wave.order, order);
            assert!(wave.convergence.error() < 1e-9, "{:?}", wave.convergence);
            let estimate = search.estimate(order).unwrap();
            assert!(
                (wave.ratio / estimate - 1.0).abs() < 0.25,
                "{exponent}, {order}"
            );
            if let Some(last) = last {
                let change = wave.ratio / last;
                assert!(
                    (1.01..1.4).contains(&change),
                    "{exponent}, {order}: {change}"
                );
            }
            last = Some(wave.ratio);
            if exponent == 1.2 {
                let journey = wave.journey(20, &Silent).unwrap();
                assert!(journey.arrived.shape_change < 1e-8, "{journey:?}");
                assert!(journey.arrived.leak < 1e-16);
            }
        }
    }
}

/// A row reports an order that cannot be resolved; the other rows remain.
#[test]
fn regress_unresolved_orders_do_not_end_the_list() {
    let comparison = Comparison {
        family: Family {
            alternation: Alternation::Stiffness,
            exponent: 6.0,
        },
        orders: 2..=3,
        cells: None,
        cylinders: None,
    };
    let rows = comparison.run(&Silent).unwrap();
    assert_eq!(rows.len(), 2);
    assert!(rows[0].exact.is_some() && rows[0].reason.is_none());
    let row = &rows[1];
    assert!(row.exact.is_none() && row.wave.is_none() && row.asymptotic.is_some());
    let reason = row.reason.as_ref().unwrap();
    assert!(reason.contains("expected a wave of order 3"), "{reason}");
    assert_eq!(row.differences, Default::default());
}

/// A wave travels for a while, with the errors its run states.
#[test]
fn val_chain_a_journey_keeps_the_shape() {
    for (alternation, order) in [(Alternation::Stiffness, 5), (Alternation::Mass, 2)] {
        let family = Family {
            alternation,
            exponent: 1.5,
        };
        let wave = family.search(order).unwrap().wave(order).unwrap();
        let journey = wave.journey(120, &Silent).unwrap();
        assert_eq!((journey.travels.len(), journey.order), (120, order));
        assert_eq!(journey.arrived, journey.travels[119]);
        assert!(
            journey.arrived.shape_change < 10.0 * journey.stepping_error,
            "{order}"
        );
        assert!((1e-14..3e-10).contains(&journey.stepping_error));
        for travel in &journey.travels {
            assert!(travel.leak < 1e-20 && travel.energy_drift.abs() < 1e-12);
        }
    }
    let wave = Family::default().search(1).unwrap().wave(1).unwrap();
    assert!(wave.journey(0, &Silent).unwrap_err().is_usage());
    assert!(wave.journey(1 << 40, &Silent).unwrap_err().is_usage());
}
