//! Measured chains: simulated velocities with added noise, drift and dead channels. The additions
//! are known, so every stated error is compared with the true one.

use ndarray::{Array2, s};
use test_support::changed;
use test_support::measured::{
    DISPERSIVE, LOCALIZED, Normal, Spoilt, coverage, measure, simulated, step,
};
use test_support::scenes::{apart, largest, near, within};
use wavecascade::budget::measured::{
    Drift, Estimate, Lack, MeasuredMotion, MeasuredOptions, Noise, from_field, from_velocities,
};
use wavecascade::budget::{BudgetRequest, budget};
use wavecascade::chain::{Chain, Run};
use wavecascade::{Error, Result};

/// A quick measurement.
pub fn quick(drift: Drift) -> MeasuredOptions {
    MeasuredOptions {
        drift,
        repetitions: 32,
        ..MeasuredOptions::default()
    }
}

/// What is measured with a chain other than that of the run.
pub fn stated(
    run: &Run,
    record: &Array2<f64>,
    chain: &Chain,
    options: &MeasuredOptions,
) -> Result<MeasuredMotion> {
    from_velocities(record.view(), [0.0, step(run)], chain, options)
}

/// The overlaps of a run.
pub fn overlaps(run: &Run) -> Array2<f64> {
    let x = run.displacement.as_ref().unwrap();
    Array2::from_shape_fn((run.time.len(), run.chain.n_contacts()), |(i, j)| {
        run.chain.overlap(j, x.row(i).as_slice().unwrap())
    })
}

/// Coverage of all arrays with stated errors, against the simulation behind the record.
fn coverages(run: &Run, measured: &MeasuredMotion) -> [(&'static str, [f64; 2]); 5] {
    let force = run.force.as_ref().unwrap();
    let flux = Array2::from_shape_fn(force.dim(), |(i, j)| {
        let v = run.velocity.row(i);
        v.get(j + 1)
            .map_or(0.0, |right| 0.5 * force[[i, j]] * (v[j] + right))
    });
    let energy = Array2::from_elem((run.time.len(), 1), 0.5);
    let (passed, values, errors) = (
        run.energy_passed.as_ref(),
        &measured.values,
        &measured.errors,
    );
    [
        (
            "overlap",
            coverage(&values.overlap, &overlaps(run), &errors.overlap),
        ),
        ("force", coverage(&values.force, force, &errors.force)),
        ("flux", coverage(&values.flux, &flux, &errors.flux)),
        (
            "passed",
            coverage(&values.passed, passed.unwrap(), &errors.passed),
        ),
        ("energy", coverage(&values.energy, &energy, &errors.energy)),
    ]
}

/// What is lacking of this kind.
fn lacks(measured: &MeasuredMotion, code: Lack) -> Vec<usize> {
    let warnings = measured.report.warnings.iter();
    let of = warnings.filter(|warning| warning.code == code);
    of.flat_map(|warning| warning.at.clone()).collect()
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
    let run = simulated(40, ratio, 60.0, 1201);
    for ([noise, offset, gathered], drift) in [
        ([1e-4, 0.0, 0.0], Drift::None),
        ([1e-3, 0.0, 0.0], Drift::Linear),
        ([1e-2, 0.0, 0.0], Drift::None),
        ([1e-3, 3e-3, 0.0], Drift::Constant),
        ([1e-3, 1e-3, 3e-3], Drift::Linear),
    ] {
        let spoilt = changed(Spoilt::by(noise), |it| {
            (it.offset, it.drift) = (offset, gathered)
        });
        // Averaged over two records.
        let found = [1, 2].map(|seed| {
            let record = spoilt.of(&run, seed);
            coverages(&run, &measure(&run, record.view(), &quick(drift)))
        });
        for ((what, a), (_, b)) in found[0].into_iter().zip(found[1]) {
            let [within, over] = [0, 1].map(|i| 0.5 * (a[i] + b[i]));
            let case = format!("{ratio} {what} {within} {over} {drift:?} {noise}");
            assert!(within >= 0.99 && (0.5..10.0).contains(&over), "{case}");
        }
    }
}

/// Without noise only the sampling error remains. The stated error covers it and falls with it.
#[test]
fn val_convergence_of_clean_records() {
    let run = simulated(40, DISPERSIVE, 60.0, 2401);
    let errors = [1, 2, 4].map(|every| {
        let record = run.velocity.slice(s![..;every, ..]);
        let dt = step(&run) * every as f64;
        let options = MeasuredOptions::default();
        let measured = from_velocities(record, [0.0, dt], &run.chain, &options).unwrap();
        let truth = run.displacement.as_ref().unwrap().slice(s![..;every, ..]);
        let exact = overlaps(&run).slice(s![..;every, ..]).to_owned();
        let found = &measured.values.overlap;
        let [within, over] = coverage(found, &exact, &measured.errors.overlap);
        assert!(within > 0.999 && over > 1.0, "{within} {over}");
        // The reconstructed motion has a budget.
        let (budget, _) = budget(&measured.motion(), &BudgetRequest::default()).unwrap();
        let passed = measured.report.contacts.iter().map(|of| of.passed.value);
        assert!(apart(&budget.passed, passed) < 1e-12);
        assert!(budget.closure.identities.transfer_sum < 1e-13);
        apart(&measured.displacement, truth)
    });
    println!("{errors:?}");
    // The t^{5/2} singularities of velocities at opening contacts limit the order of the cubics.
    let order = (errors[2] / errors[0]).log2() / 2.0;
    assert!((3.0..4.0).contains(&order), "{errors:?}");
}

/// White noise sigma integrates to `sigma sqrt(dt t)` from the arrival on.
#[test]
fn val_closed_form_error_of_displacements_is_a_random_walk() {
    let run = simulated(40, DISPERSIVE, 60.0, 1201);
    let (sigma, dt) = (1e-3, step(&run));
    let record = Spoilt::by(sigma).of(&run, 5);
    let options = changed(quick(Drift::None), |it| it.repetitions = 400);
    let measured = measure(&run, record.view(), &options);
    let sites = &measured.report.sites;
    for j in [10, 20, 30] {
        near(sites[j].deviation / sigma, 1.0, 0.2, &sites[j]);
        let time = |site: usize| dt * (run.time.len() - sites[site].rest_samples) as f64;
        let expected = sigma * (dt * (time(j) + time(j + 1))).sqrt();
        let stated = measured.errors.overlap[[run.time.len() - 1, j]];
        within(stated / expected, 1.0..1.25, j);
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
        for (noise, seed, fill) in [0.0, 1e-2]
            .into_iter()
            .flat_map(|noise| [(noise, 1, 0.0), (noise, 2, f64::NAN)])
        {
            let mut record = Spoilt::by(noise).of(&run, seed);
            for site in &dead {
                record.column_mut(*site).fill(fill);
            }
            let measured = measure(&run, record.view(), &quick(Drift::None));
            let found: Vec<usize> = measured.report.missing.iter().map(|m| m.site).collect();
            assert_eq!((&found, &lacks(&measured, Lack::Missing)), (&dead, &dead));
            let columns = |array: &Array2<f64>| {
                array
                    .slice(s![.., dead[0]..=dead[dead.len() - 1]])
                    .to_owned()
            };
            let [values, truth, errors] = [
                &measured.values.velocity,
                &run.velocity,
                &measured.errors.velocity,
            ]
            .map(columns);
            let [within, over] = coverage(&values, &truth, &errors);
            assert!(within >= 0.97, "{ratio} {noise} {within}");
            assert!((0.5..8.0).contains(&over), "{ratio} {noise} {over}");
            for (what, [within, _]) in coverages(&run, &measured) {
                assert!(within >= 0.98, "{ratio} {noise} {what} {within}");
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
        // All of these contacts are stated 5 % too soft.
        let wrong = |contacts: std::ops::Range<usize>| {
            let chain = changed(run.chain.clone(), |it| {
                it.coefficient[contacts].iter_mut().for_each(|c| *c /= 1.05);
            });
            stated(&run, &record, &chain, &quick(Drift::None)).unwrap()
        };
        let accused = |measured: &MeasuredMotion| lacks(measured, Lack::Coefficient);
        let all_accused = |measured: &MeasuredMotion| {
            let mut warnings = measured.report.warnings.iter();
            warnings.any(|warning| matches!(warning.code, Lack::MomentumOpen | Lack::Coefficients))
        };
        let right = wrong(0..0);
        assert!(accused(&right).is_empty() && !all_accused(&right));
        // One contact, soft or stiff.
        for contact in [20, 21] {
            let measured = wrong(contact..contact + 1);
            let factor = measured.report.momentum.factors[contact].unwrap();
            let case = format!("{ratio} {noise} {contact} {factor:?}");
            assert!((factor.factor - 1.05).abs() < 3.0 * factor.error, "{case}");
            // Stiff contacts have smaller overlaps, so noise affects them more.
            let precision = noise * if contact % 2 == 0 { 12.0 } else { 40.0 };
            assert!(factor.error < precision, "{case}");
            assert_eq!(accused(&measured).contains(&contact), factor.is_off());
            assert!(factor.is_off() || noise == 1e-3, "{case}");
        }
        let measured = wrong(0..40);
        let common = measured.report.momentum.common;
        near(common.factor, 1.05, 3.0 * common.error, common);
        assert!(common.error < 10.0 * noise && all_accused(&measured));
    }
}

#[test]
fn val_simulation_noise_as_large_as_the_signal_is_refused() {
    let plain = |drift| changed(MeasuredOptions::default(), |it| it.drift = drift);
    let run = simulated(40, DISPERSIVE, 60.0, 1201);
    for noise in [0.3, 1.0, 10.0] {
        for drift in [Drift::None, Drift::Linear] {
            let record = Spoilt::by(noise).of(&run, 1);
            let error = stated(&run, &record, &run.chain, &plain(drift)).unwrap_err();
            let told = matches!(error, Error::Unresolved(_) | Error::Request { .. });
            assert!(told, "{error}");
        }
    }
    // Where the front has just arrived the force is below noise; elsewhere it is not.
    let run = simulated(40, DISPERSIVE, 30.0, 601);
    let mut record = Spoilt::by(1e-2).of(&run, 1);
    let options = plain(Drift::None);
    let below = lacks(&measure(&run, record.view(), &options), Lack::BelowNoise);
    let force = |j: usize| largest(run.force.as_ref().unwrap().column(j));
    assert!((3..20).contains(&below.len()), "{below:?}");
    assert!(below.iter().all(|j| *j >= 15 && force(*j) < 0.1));

    // One channel with noise above all energy. Without it, its neighbours determine its motion.
    let mut random = Normal(9);
    record.column_mut(15).mapv_inplace(|v| v + random.draw());
    let error = stated(&run, &record, &run.chain, &options).unwrap_err();
    assert!(matches!(error, Error::Unresolved(_)) && !error.is_usage());
    let missing = changed(options, |it| it.missing = vec![15]);
    let below = lacks(&measure(&run, record.view(), &missing), Lack::BelowNoise);
    assert!(below.iter().all(|j| *j >= 15));
}

#[test]
fn val_hostile_records_are_refused() {
    let run = simulated(20, DISPERSIVE, 30.0, 601);
    let options = MeasuredOptions::default();
    let (time, clean) = ([0.0, step(&run)], &run.velocity);
    // Motion from the start in all channels leaves no quiet part.
    let mut random = Normal(2);
    let moving = clean.mapv(|_| random.draw());
    let short = clean.slice(s![..3, ..]).to_owned();
    for (record, time, chain) in [
        (clean, time, &Chain::dimer(19, 2.0)),
        (clean, [0.0, 0.0], &run.chain),
        (clean, [f64::NAN, 0.1], &run.chain),
        (&Array2::zeros((600, 20)), time, &run.chain),
        (&short, time, &run.chain),
        (&moving, time, &run.chain),
    ] {
        let error = from_velocities(record.view(), time, chain, &options).unwrap_err();
        assert!(error.is_usage(), "{error}");
    }
    let gap = changed(clean.clone(), |it| it[[100, 3]] = f64::INFINITY);
    let error = stated(&run, &gap, &run.chain, &options).unwrap_err();
    assert!(
        matches!(
            error,
            Error::NonFinite {
                first: (100, 3),
                ..
            }
        ),
        "{error}"
    );
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
        let wrong = changed(options.clone(), change);
        let error = stated(&run, clean, &run.chain, &wrong).unwrap_err();
        assert!(error.is_usage(), "{wrong:?}");
    }
    let force = changed(run.to_field(), |it| {
        it.quantity = wavecascade::field::Quantity::Force;
    });
    let error = from_field(&force, &run.chain, &options).unwrap_err();
    assert!(error.is_usage(), "{error}");
}

/// The same bits for any number of threads, by both entry points, and with an earlier start.
#[test]
fn regress_threads_entries_and_pretrigger_samples() {
    let run = simulated(20, DISPERSIVE, 30.0, 601);
    let [one, two] = [1, 2].map(|threads| {
        let options = changed(MeasuredOptions::default(), |it| it.threads = Some(threads));
        from_field(&run.to_field(), &run.chain, &options).unwrap()
    });
    let Estimate { value, error } = one.report.energy;
    assert!((value - 0.5).abs() < error + 1e-3);
    assert_eq!(
        (&one.errors.force, &one.report),
        (&two.errors.force, &two.report)
    );
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
    let time = [-dt * before as f64, dt];
    let late = from_velocities(record.view(), time, &run.chain, &options).unwrap();
    assert!(late.time[0].abs() < 1e-12);
    assert!(late.report.sites[1..].iter().all(|site| !site.borrowed));
    for (what, [within, over]) in coverages(&run, &late) {
        assert!(within >= 0.98, "{what} {within} {over}");
    }
}
