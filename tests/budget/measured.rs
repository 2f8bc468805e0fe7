//! Measured chains: simulated velocities with added noise, drift and dead channels. The additions
//! are known, so every stated error is compared with the true one.

use ndarray::{Array2, s};
use test_support::changed;
use test_support::measured::{
    DISPERSIVE, LOCALIZED, Normal, Spoilt, coverage, measure, simulated, step,
};
use wavecascade::Error;
use wavecascade::budget::measured::{
    Drift, Estimate, Lack, MeasuredMotion, MeasuredOptions, MeasuredWarning, Noise, from_field,
    from_velocities,
};
use wavecascade::budget::{BudgetRequest, budget};
use wavecascade::chain::{Chain, Run};

/// Coverage of all arrays with stated errors, against the simulation behind the record.
fn coverages(run: &Run, measured: &MeasuredMotion) -> Vec<(&'static str, [f64; 2])> {
    let displacement = run.displacement.as_ref().unwrap();
    let (samples, m) = (run.time.len(), run.chain.n_contacts());
    let overlap = Array2::from_shape_fn((samples, m), |(i, j)| {
        run.chain
            .overlap(j, displacement.row(i).as_slice().unwrap())
    });
    let force = run.force.as_ref().unwrap();
    let flux = Array2::from_shape_fn((samples, m), |(i, j)| {
        let v = run.velocity.row(i);
        v.get(j + 1)
            .map_or(0.0, |right| 0.5 * force[[i, j]] * (v[j] + right))
    });
    let energy = Array2::from_elem((samples, 1), 0.5);
    let errors = &measured.errors;
    vec![
        (
            "overlap",
            coverage(&measured.values.overlap, &overlap, &errors.overlap),
        ),
        (
            "force",
            coverage(&measured.values.force, force, &errors.force),
        ),
        ("flux", coverage(&measured.values.flux, &flux, &errors.flux)),
        (
            "passed",
            coverage(
                &measured.values.passed,
                run.energy_passed.as_ref().unwrap(),
                &errors.passed,
            ),
        ),
        (
            "energy",
            coverage(&measured.values.energy, &energy, &errors.energy),
        ),
    ]
}

/// Coverages averaged over many records.
fn mean_coverages(
    run: &Run,
    seeds: std::ops::Range<u64>,
    record: impl Fn(u64) -> Array2<f64>,
    options: &MeasuredOptions,
) -> Vec<(&'static str, [f64; 2])> {
    let count = (seeds.end - seeds.start) as f64;
    let mut all: Vec<(&str, [f64; 2])> = Vec::new();
    for seed in seeds {
        let found = coverages(run, &measure(run, record(seed).view(), options));
        if all.is_empty() {
            all = found.iter().map(|(name, _)| (*name, [0.0; 2])).collect();
        }
        for (sum, (_, found)) in all.iter_mut().zip(&found) {
            sum.1[0] += found[0] / count;
            sum.1[1] += found[1] / count;
        }
    }
    all
}

#[test]
fn val_simulation_stated_errors_cover_the_true_ones_in_a_localized_chain() {
    stated_errors_cover_the_true_ones(LOCALIZED);
}

#[test]
fn val_simulation_stated_errors_cover_the_true_ones_in_a_dispersive_chain() {
    stated_errors_cover_the_true_ones(DISPERSIVE);
}

fn stated_errors_cover_the_true_ones(ratio: f64) {
    let spoilt = |noise, offset, drift| Spoilt {
        noise,
        offset,
        drift,
        ..Spoilt::default()
    };
    let run = simulated(40, ratio, 60.0, 1201);
    for (spoilt, drift) in [
        (spoilt(1e-4, 0.0, 0.0), Drift::None),
        (spoilt(1e-3, 0.0, 0.0), Drift::Linear),
        (spoilt(1e-2, 0.0, 0.0), Drift::None),
        (spoilt(1e-3, 3e-3, 0.0), Drift::Constant),
        (spoilt(1e-3, 1e-3, 3e-3), Drift::Linear),
    ] {
        let options = MeasuredOptions {
            drift,
            repetitions: 32,
            ..MeasuredOptions::default()
        };
        let record = |seed| spoilt.of(&run, seed);
        for (what, [within, over]) in mean_coverages(&run, 1..3, record, &options) {
            let case = format!("{ratio} {what} {within} {over} {drift:?} {}", spoilt.noise);
            assert!(within >= 0.99, "{case}");
            assert!((0.5..10.0).contains(&over), "{case}");
        }
    }
}

/// Without noise only the sampling error remains. The stated error covers it and falls with it.
#[test]
fn val_convergence_of_clean_records() {
    let run = simulated(40, DISPERSIVE, 60.0, 2401);
    let displacement = run.displacement.as_ref().unwrap();
    let (mut errors, mut plain) = (Vec::new(), Vec::new());
    for every in [1, 2, 4] {
        let record = run.velocity.slice(s![..;every, ..]);
        let dt = step(&run) * every as f64;
        let measured =
            from_velocities(record, [0.0, dt], &run.chain, &MeasuredOptions::default()).unwrap();
        let truth = displacement.slice(s![..;every, ..]);
        let off = |found: &Array2<f64>| {
            (found - &truth)
                .iter()
                .fold(0.0, |m: f64, x| m.max(x.abs()))
        };
        errors.push(off(&measured.displacement));
        let mut trapezoid = Array2::zeros(record.dim());
        for i in 1..record.nrows() {
            let step = 0.5 * dt * (&record.row(i - 1) + &record.row(i));
            let next = &trapezoid.row(i - 1) + &step;
            trapezoid.row_mut(i).assign(&next);
        }
        plain.push(off(&trapezoid));
        let overlap = measured.values.overlap.clone();
        let exact = Array2::from_shape_fn(overlap.dim(), |(i, j)| {
            run.chain.overlap(j, truth.row(i).as_slice().unwrap())
        });
        let [within, over] = coverage(&overlap, &exact, &measured.errors.overlap);
        assert!(within > 0.999 && over > 1.0, "{within} {over}");
        // The reconstructed motion has a budget.
        let (budget, _) = budget(&measured.motion(), &BudgetRequest::default()).unwrap();
        for (j, passed) in budget.passed.iter().enumerate() {
            let expected = measured.report.contacts[j].passed.value;
            assert!((passed - expected).abs() < 1e-12, "{j}");
        }
        assert!(budget.closure.identities.transfer_sum < 1e-13);
    }
    let order = |errors: &[f64]| (errors[2] / errors[0]).log2() / 2.0;
    // The t^{5/2} singularities of velocities at opening contacts limit the order of the cubics.
    assert!((3.0..4.0).contains(&order(&errors)), "{errors:?}");
    assert!((order(&plain) - 2.0).abs() < 0.1, "{plain:?}");
    assert!(errors[0] < 0.05 * plain[0]);
}

/// White noise sigma integrates to `sigma sqrt(dt t)` from the arrival on.
#[test]
fn val_closed_form_error_of_displacements_is_a_random_walk() {
    let run = simulated(40, DISPERSIVE, 60.0, 1201);
    let (sigma, dt) = (1e-3, step(&run));
    let record = Spoilt::by(sigma).of(&run, 5);
    let options = MeasuredOptions {
        drift: Drift::None,
        repetitions: 400,
        ..MeasuredOptions::default()
    };
    let measured = measure(&run, record.view(), &options);
    for j in [10, 20, 30] {
        let found = &measured.report.sites[j];
        assert!((found.deviation / sigma - 1.0).abs() < 0.2, "{found:?}");
        let time =
            |site: usize| dt * (run.time.len() - measured.report.sites[site].rest_samples) as f64;
        let expected = sigma * (dt * (time(j) + time(j + 1))).sqrt();
        let stated = measured.errors.overlap[[run.time.len() - 1, j]];
        assert!(
            (1.0..1.25).contains(&(stated / expected)),
            "{j} {stated} {expected}"
        );
    }
}

#[test]
fn val_simulation_a_missing_site_is_found_from_its_neighbours() {
    for (ratio, dead) in [
        (LOCALIZED, vec![11]),
        (DISPERSIVE, vec![12]),
        (DISPERSIVE, vec![20, 21]),
    ] {
        let run = simulated(40, ratio, 60.0, 1201);
        for noise in [0.0, 1e-2] {
            for (seed, fill) in [(1, 0.0), (2, f64::NAN)] {
                let mut record = Spoilt::by(noise).of(&run, seed);
                for site in &dead {
                    record.column_mut(*site).fill(fill);
                }
                let options = MeasuredOptions {
                    drift: Drift::None,
                    repetitions: 32,
                    ..MeasuredOptions::default()
                };
                let measured = measure(&run, record.view(), &options);
                let found: Vec<usize> = measured.report.missing.iter().map(|m| m.site).collect();
                assert_eq!(found, dead);
                let columns = |array: &Array2<f64>| {
                    array
                        .slice(s![.., dead[0]..=dead[dead.len() - 1]])
                        .to_owned()
                };
                let [within, over] = coverage(
                    &columns(&measured.values.velocity),
                    &columns(&run.velocity),
                    &columns(&measured.errors.velocity),
                );
                assert!(within >= 0.97, "{ratio} {noise} {within}");
                assert!((0.5..8.0).contains(&over), "{ratio} {noise} {over}");
                for (what, [within, _]) in coverages(&run, &measured) {
                    assert!(within >= 0.98, "{ratio} {noise} {what} {within}");
                }
                let mut warnings = measured.report.warnings.iter();
                let missing = warnings.find(|warning| warning.code == Lack::Missing);
                assert_eq!(missing.map(|missing| &missing.at), Some(&dead));
            }
        }
    }
}

#[test]
fn val_simulation_a_wrong_coefficient_of_a_localized_chain_is_found() {
    wrong_coefficients_are_found_and_right_ones_not_accused(LOCALIZED);
}

#[test]
fn val_simulation_a_wrong_coefficient_of_a_dispersive_chain_is_found() {
    wrong_coefficients_are_found_and_right_ones_not_accused(DISPERSIVE);
}

fn wrong_coefficients_are_found_and_right_ones_not_accused(ratio: f64) {
    let run = simulated(40, ratio, 60.0, 1201);
    for noise in [1e-4, 2e-4, 1e-3] {
        let record = Spoilt::by(noise).of(&run, 3);
        let options = MeasuredOptions {
            drift: Drift::None,
            repetitions: 32,
            ..MeasuredOptions::default()
        };
        let accused = |measured: &MeasuredMotion| -> Vec<usize> {
            let of = |warning: &MeasuredWarning| match warning.code {
                Lack::Coefficient => warning.at.clone(),
                Lack::MomentumOpen | Lack::Coefficients => vec![usize::MAX],
                _ => Vec::new(),
            };
            measured.report.warnings.iter().flat_map(of).collect()
        };
        let right = measure(&run, record.view(), &options);
        assert_eq!(accused(&right), Vec::<usize>::new(), "{ratio} {noise}");

        // One contact, soft or stiff, stated 5 % too soft.
        for wrong in [20, 21] {
            let mut chain = run.chain.clone();
            chain.coefficient[wrong] /= 1.05;
            let measured =
                from_velocities(record.view(), [0.0, step(&run)], &chain, &options).unwrap();
            let factor = measured.report.momentum.factors[wrong].unwrap();
            assert!(
                (factor.factor - 1.05).abs() < 3.0 * factor.error,
                "{factor:?}"
            );
            // Stiff contacts have smaller overlaps, so noise affects them more.
            let precision = noise * if wrong % 2 == 0 { 12.0 } else { 40.0 };
            assert!(
                factor.error < precision,
                "{ratio} {noise} {wrong} {factor:?}"
            );
            assert_eq!(accused(&measured).contains(&wrong), factor.is_off());
            assert!(
                factor.is_off() || noise == 1e-3,
                "{ratio} {noise} {wrong} {factor:?}"
            );
        }
        let mut chain = run.chain.clone();
        for c in &mut chain.coefficient {
            *c /= 1.05;
        }
        let measured = from_velocities(record.view(), [0.0, step(&run)], &chain, &options).unwrap();
        let common = measured.report.momentum.common;
        assert!(
            (common.factor - 1.05).abs() < 3.0 * common.error,
            "{common:?}"
        );
        assert!(common.error < 10.0 * noise && accused(&measured).contains(&usize::MAX));
    }
}

#[test]
fn val_simulation_noise_as_large_as_the_signal_is_refused() {
    let run = simulated(40, DISPERSIVE, 60.0, 1201);
    for noise in [0.3, 1.0, 10.0] {
        for drift in [Drift::None, Drift::Linear] {
            let record = Spoilt::by(noise).of(&run, 1);
            let options = changed(MeasuredOptions::default(), |it| it.drift = drift);
            let error = from_velocities(record.view(), [0.0, step(&run)], &run.chain, &options)
                .map(|m| m.report.energy)
                .unwrap_err();
            assert!(
                matches!(error, Error::Unresolved(_) | Error::Request { .. }),
                "{error}"
            );
        }
    }
    // Where the front has just arrived the force is below noise; elsewhere it is not.
    let run = simulated(40, DISPERSIVE, 30.0, 601);
    let mut record = Spoilt::by(1e-2).of(&run, 1);
    let options = changed(MeasuredOptions::default(), |it| it.drift = Drift::None);
    let measured = measure(&run, record.view(), &options);
    let drowned = |measured: &MeasuredMotion| -> Vec<usize> {
        let mut warnings = measured.report.warnings.iter();
        let found = warnings.find(|warning| warning.code == Lack::BelowNoise);
        found.map_or(Vec::new(), |found| found.at.clone())
    };
    let below = drowned(&measured);
    let truth = run.force.as_ref().unwrap();
    let largest = |j: usize| truth.column(j).iter().fold(0.0, |m: f64, f| m.max(*f));
    assert!((3..20).contains(&below.len()), "{below:?}");
    assert!(below.iter().all(|j| *j >= 15 && largest(*j) < 0.1));

    // One channel with noise above all energy. Without it, its neighbours determine its motion.
    let mut random = Normal(9);
    record.column_mut(15).mapv_inplace(|v| v + random.draw());
    let noisy = from_velocities(record.view(), [0.0, step(&run)], &run.chain, &options);
    let error = noisy.unwrap_err();
    assert!(matches!(error, Error::Unresolved(_)) && !error.is_usage());
    let missing = changed(options, |it| it.missing = vec![15]);
    let measured = measure(&run, record.view(), &missing);
    assert!(drowned(&measured).iter().all(|j| *j >= 15));
}

#[test]
fn val_hostile_records_are_refused() {
    let run = simulated(20, DISPERSIVE, 30.0, 601);
    let options = MeasuredOptions::default();
    let time = [0.0, step(&run)];
    let refused = |record: &Array2<f64>, time, chain: &Chain, options: &MeasuredOptions| {
        from_velocities(record.view(), time, chain, options).unwrap_err()
    };
    let clean = run.velocity.clone();
    assert!(refused(&clean, time, &Chain::dimer(19, 2.0), &options).is_usage());
    assert!(refused(&clean, [0.0, 0.0], &run.chain, &options).is_usage());
    assert!(refused(&clean, [f64::NAN, 0.1], &run.chain, &options).is_usage());
    assert!(refused(&Array2::zeros((600, 20)), time, &run.chain, &options).is_usage());
    let short = clean.slice(s![..3, ..]).to_owned();
    assert!(refused(&short, time, &run.chain, &options).is_usage());
    let mut gap = clean.clone();
    gap[[100, 3]] = f64::INFINITY;
    assert!(matches!(
        refused(&gap, time, &run.chain, &options),
        Error::NonFinite {
            first: (100, 3),
            ..
        }
    ));
    let wrong: [&dyn Fn(&mut MeasuredOptions); 7] = [
        &|o| o.start = 598,
        &|o| o.start = usize::MAX,
        &|o| o.missing = vec![20],
        &|o| o.missing = vec![0],
        &|o| o.missing = (5..19).collect(),
        &|o| o.repetitions = 0,
        &|o| {
            let (deviation, offset) = (f64::NAN, 0.0);
            o.noise = Noise::Stated { deviation, offset };
        },
    ];
    for change in wrong {
        let mut wrong = options.clone();
        change(&mut wrong);
        let error = refused(&clean, time, &run.chain, &wrong);
        assert!(error.is_usage(), "{wrong:?}");
    }
    // Motion from the start in all channels leaves no quiet part.
    let mut random = Normal(2);
    let moving = clean.mapv(|_| random.draw());
    assert!(refused(&moving, time, &run.chain, &options).is_usage());
    let mut field = run.to_field();
    field.quantity = wavecascade::field::Quantity::Force;
    let error = from_field(&field, &run.chain, &options).unwrap_err();
    assert!(error.is_usage(), "{error}");
}

/// The same bits for any number of threads, by both entry points, and with an earlier start.
#[test]
fn regress_threads_entries_and_pretrigger_samples() {
    let run = simulated(20, DISPERSIVE, 30.0, 601);
    let options = |threads| changed(MeasuredOptions::default(), |it| it.threads = Some(threads));
    let field = run.to_field();
    let one = from_field(&field, &run.chain, &options(1)).unwrap();
    let two = from_field(&field, &run.chain, &options(2)).unwrap();
    let Estimate { value, error } = one.report.energy;
    assert!((value - 0.5).abs() < error + 1e-3);
    assert_eq!(one.errors.force, two.errors.force);
    assert_eq!(one.report, two.report);
    let report = serde_json::to_string(&one.report).unwrap();
    assert!(report.contains("momentum"));

    let (noise, before) = (1e-3, 200);
    let mut random = Normal(4);
    let record = Array2::from_shape_fn((601 + before, 20), |(i, j)| {
        let v = match i.checked_sub(before) {
            Some(i) => run.velocity[[i, j]],
            None => f64::from(u8::from(j == 0)),
        };
        v + noise * random.draw()
    });
    let options = MeasuredOptions {
        start: before,
        drift: Drift::Constant,
        ..MeasuredOptions::default()
    };
    let dt = step(&run);
    let late = from_velocities(
        record.view(),
        [-dt * before as f64, dt],
        &run.chain,
        &options,
    );
    let late = late.unwrap();
    assert!(late.time[0].abs() < 1e-12);
    assert!(late.report.sites[1..].iter().all(|site| !site.borrowed));
    for (what, [within, over]) in coverages(&run, &late) {
        assert!(within >= 0.98, "{what} {within} {over}");
    }
}
