//! Spectral budgets of measured chains: results over wavenumber, frequency and scale against those
//! of the simulated chain behind the record, and the energy input.

use std::collections::BTreeMap;

use ndarray::{Array2, s};
use wavecascade::arrays::LargeArray;
use wavecascade::budget::measured::{
    Drift, MeasuredMotion, MeasuredOptions, Uncertainty, from_velocities,
};
use wavecascade::budget::{Budget, BudgetRequest, Direction, Integration, Motion, Views, budget};
use wavecascade::chain::{Accuracy, Chain, Ends, Losses, Run, Scheme, Simulation};
use wavecascade::observer::Silent;

use test_support::changed;
use test_support::fields::{chain, spring};
use test_support::measured::{
    DISPERSIVE, LOCALIZED, Normal, Spoilt, coverage, measure, simulated, step,
};

fn options(drift: Drift, uncertainty: Uncertainty) -> MeasuredOptions {
    MeasuredOptions {
        drift,
        uncertainty,
        repetitions: 32,
        ..MeasuredOptions::default()
    }
}

fn gains(share: f64) -> Uncertainty {
    changed(Uncertainty::default(), |it| it.gain = vec![share])
}

/// Request for the exact budget, with the band edges and scales of the measurement.
fn pinned(budget: &Budget) -> BudgetRequest {
    let scales = budget.scales.as_ref();
    BudgetRequest {
        band_edge_wavenumber: Some(budget.wavenumber.as_ref().unwrap().edge),
        band_edge_frequency: Some(budget.frequency.as_ref().unwrap().edge),
        scales: scales.map_or(Vec::new(), |found| {
            found.scales.iter().map(|of| of.scale).collect()
        }),
        map_scale: scales.map(|found| found.map_scale),
        ..BudgetRequest::default()
    }
}

fn column(values: &[f64]) -> Array2<f64> {
    Array2::from_shape_vec((values.len(), 1), values.to_vec()).unwrap()
}

/// Of all arrays and curves: the share within three stated errors, and the ratio of stated to true
/// errors.
fn spectral_coverages(run: &Run, measured: &MeasuredMotion) -> Vec<(String, [f64; 2])> {
    let (found, arrays, errors) = measured.budget(&BudgetRequest::default()).unwrap();
    let (truth, exact) = budget(&Motion::of(run).unwrap(), &pinned(&found)).unwrap();
    let asked: Vec<LargeArray> = errors.keys().copied().collect();
    assert!(asked.contains(&LargeArray::TRANSFER) && asked.contains(&LargeArray::SCALE_FLUX));
    let mut all: Vec<(String, [f64; 2])> = errors
        .iter()
        .map(|(name, error)| {
            let covered = coverage(&arrays[name], &exact[name], error);
            (name.name().to_owned(), covered)
        })
        .collect();
    let errors = found.errors.as_ref().unwrap();
    let (here, there) = (found.curves(), truth.curves());
    for name in [
        "total_energy",
        "integrated_flux",
        "low_wavenumber_energy",
        "band_edge_flux",
        "wavenumber_centroid",
        "low_frequency_passed",
        "integrated_scale_flux",
    ] {
        let [found, truth, error] = [&here, &there, errors].map(|curves| column(&curves[name]));
        all.push((format!("curve {name}"), coverage(&found, &truth, &error)));
    }
    all
}

#[test]
#[ignore = "slow"]
fn val_simulation_spectral_errors_cover_the_true_ones() {
    let spoilt = |noise, offset, drift, gain| Spoilt {
        noise,
        offset,
        drift,
        gain,
    };
    for (spoilt, drift) in [
        (spoilt(1e-3, 0.0, 0.0, 0.0), Drift::None),
        (spoilt(1e-2, 0.0, 0.0, 0.0), Drift::None),
        (spoilt(1e-3, 1e-3, 3e-3, 0.0), Drift::Linear),
        (spoilt(1e-3, 0.0, 0.0, 0.01), Drift::None),
    ] {
        let mut all: BTreeMap<String, [f64; 2]> = BTreeMap::new();
        let seeds = 4;
        for ratio in [LOCALIZED, DISPERSIVE] {
            let run = simulated(40, ratio, 60.0, 1201);
            for seed in 0..seeds {
                let options = options(drift, gains(spoilt.gain));
                let measured = measure(&run, spoilt.of(&run, 100 + seed).view(), &options);
                for (name, [within, over]) in spectral_coverages(&run, &measured) {
                    let sum = all.entry(name).or_default();
                    sum[0] += within / (2 * seeds) as f64;
                    sum[1] += over.ln() / (2 * seeds) as f64;
                }
            }
        }
        for (name, [within, over]) in all {
            let case = format!("{name} {within} {} {drift:?} {spoilt:?}", over.exp());
            assert!(within >= 0.98, "{case}");
            assert!((0.8..10.0).contains(&over.exp()), "{case}");
        }
    }
}

/// Gains, coefficients and masses wrong by as much as their stated uncertainty: overlaps and forces
/// lie within three stated errors. Far fewer do if the values are taken as exact.
#[test]
#[ignore = "slow"]
fn val_simulation_uncertain_gains_coefficients_and_masses_enter_all_errors() {
    let run = simulated(40, DISPERSIVE, 60.0, 1201);
    let displacement = run.displacement.as_ref().unwrap();
    let overlap = Array2::from_shape_fn(run.force.as_ref().unwrap().dim(), |(i, j)| {
        run.chain
            .overlap(j, displacement.row(i).as_slice().unwrap())
    });
    let (mut known, mut unknown) = (0.0, 0.0);
    let seeds = 6;
    for seed in 0..seeds {
        let spoilt = changed(Spoilt::default(), |it| (it.noise, it.gain) = (1e-4, 0.01));
        let record = spoilt.of(&run, 40 + seed);
        for (stated, share) in [(0.01, &mut known), (0.0, &mut unknown)] {
            let measured = measure(&run, record.view(), &options(Drift::None, gains(stated)));
            let [within, _] =
                coverage(&measured.values.overlap, &overlap, &measured.errors.overlap);
            *share += within / seeds as f64;
        }
    }
    assert!((0.99..=1.0).contains(&known), "{known}");
    assert!((0.2..0.6).contains(&unknown), "{unknown}");

    // Coefficients and masses off by 3 %: the record is clean, the chain stated is not.
    let mut within: BTreeMap<&str, f64> = BTreeMap::new();
    for seed in 0..seeds {
        let mut random = Normal(900 + seed);
        let mut chain = run.chain.clone();
        for value in chain.mass.iter_mut().chain(&mut chain.coefficient) {
            *value *= (0.03 * random.draw()).exp();
        }
        for stated in [0.03, 0.0] {
            let uncertainty = Uncertainty {
                gain: Vec::new(),
                coefficient: vec![stated; 40],
                mass: vec![stated],
            };
            let noise = Spoilt::by(1e-4);
            let measured = from_velocities(
                noise.of(&run, seed).view(),
                [0.0, step(&run)],
                &chain,
                &options(Drift::None, uncertainty),
            );
            let measured = measured.unwrap();
            let force = run.force.as_ref().unwrap();
            let [forces, _] = coverage(&measured.values.force, force, &measured.errors.force);
            let (found, arrays, errors) = measured.budget(&BudgetRequest::default()).unwrap();
            let (_, exact) = budget(&Motion::of(&run).unwrap(), &pinned(&found)).unwrap();
            let name = LargeArray::ENERGY_SPECTRUM;
            let [spectra, _] = coverage(&arrays[&name], &exact[&name], &errors[&name]);
            let [a, b, c] = match stated {
                0.0 => ["force, exact", "spectrum, exact", "accused, exact"],
                _ => ["force", "spectrum", "accused"],
            };
            *within.entry(a).or_default() += forces / seeds as f64;
            *within.entry(b).or_default() += spectra / seeds as f64;
            // Coefficients wrong within their stated uncertainty raise no warning.
            let accused = measured
                .report
                .warnings
                .iter()
                .any(|warning| serde_json::to_value(warning).unwrap()["code"] == "coefficient");
            *within.entry(c).or_default() += f64::from(u8::from(accused)) / seeds as f64;
        }
    }
    assert!(within["force"] > 0.98, "{within:?}");
    assert!(within["spectrum"] > 0.98, "{within:?}");
    assert!(within["force, exact"] < 0.9 && within["spectrum, exact"] < 0.9);
    assert!(within["accused"] == 0.0 && within["accused, exact"] > 0.99);
}

/// Over many records the share scatters by its stated error. A direction is given only where it is
/// significant.
#[test]
#[ignore = "slow"]
fn val_simulation_shares_scatter_as_stated() {
    let run = simulated(40, DISPERSIVE, 60.0, 1201);
    let request = BudgetRequest {
        views: Views {
            frequency: false,
            scale: false,
            ..Views::ALL
        },
        band_edge_wavenumber: Some(2.0),
        ..BudgetRequest::default()
    };
    let truth = budget(&Motion::of(&run).unwrap(), &request).unwrap().0;
    for (noise, stated) in [(1e-3, 1.0), (1e-2, 0.5)] {
        let (mut squares, mut said, seeds) = (0.0, 0, 24);
        for seed in 0..seeds {
            let spoilt = Spoilt::by(noise);
            let record = spoilt.of(&run, 500 + seed + (noise * 1e5) as u64);
            let measured = measure(&run, record.view(), &options(Drift::None, gains(0.0)));
            let found = measured.budget(&request).unwrap().0;
            let [found, truth] = [&found, &truth].map(|budget| {
                let passed = budget.wavenumber.as_ref().unwrap();
                let share = passed.passed_edge().unwrap() / budget.scale;
                let error = passed.passed_error / budget.scale;
                (share, error, budget.direction().unwrap())
            });
            let z = (found.0 - truth.0) / found.1;
            assert!(z.abs() < 3.5, "{noise} {seed} {z}");
            squares += z * z / seeds as f64;
            assert_eq!(truth.2, Direction::TowardsLowK);
            assert_eq!(
                found.2 == Direction::Unresolved,
                found.0.abs() <= 2.0 * found.1,
                "{found:?}"
            );
            said += usize::from(found.2 != Direction::Unresolved);
            // A direction, where given, is right.
            assert_ne!(found.2, Direction::TowardsHighK, "{noise} {seed} {found:?}");
        }
        assert!(
            (0.4..1.3).contains(&f64::sqrt(squares)),
            "{noise} {squares}"
        );
        if stated == 1.0 {
            assert_eq!(said, 24);
        }
    }
}

/// Energy input by a striker, and with losses: at no time is all of it in the chain.
#[test]
fn val_simulation_the_energy_given_is_that_of_the_blow() {
    // The striker is not a site of the measured chain.
    let whole = simulated(41, DISPERSIVE, 60.0, 1201);
    let chain = Chain {
        mass: whole.chain.mass[1..].to_vec(),
        coefficient: whole.chain.coefficient[1..].to_vec(),
        ..whole.chain.clone()
    };
    let last = whole.velocity.nrows() - 1;
    let truth = 0.5 - 0.5 * whole.chain.mass[0] * whole.velocity[[last, 0]].powi(2);
    let record = Spoilt::by(1e-3).of(&whole, 3);
    let measured = from_velocities(
        record.slice(s![.., 1..]),
        [0.0, step(&whole)],
        &chain,
        &options(Drift::None, gains(0.0)),
    );
    let energy = measured.unwrap().report.energy;
    assert!(
        (energy.value - truth).abs() < 3.0 * energy.error,
        "{energy:?} {truth}"
    );
    assert!(energy.error < 2e-3, "{energy:?}");

    let mut simulation = Simulation::impact(
        Chain {
            losses: changed(Losses::default(), |it| it.drag = 0.02),
            ..Chain::dimer(40, DISPERSIVE)
        },
        1.0,
        60.0,
        1201,
    );
    simulation.accuracy = Accuracy::LocalError(1e-10);
    simulation.scheme = Scheme::RungeKutta;
    simulation.estimate_error = false;
    let run = simulation.run(&Silent).unwrap();
    let record = Spoilt::by(1e-3).of(&run, 4);
    let measured = measure(&run, record.view(), &options(Drift::None, gains(0.0)));
    let energy = measured.report.energy;
    let left = measured.values.energy[[1200, 0]];
    assert!(left < 0.2, "{left}");
    assert!(
        (energy.value - 0.5).abs() < 3.0 * energy.error,
        "{energy:?}"
    );
    assert!(energy.error < 2e-3, "{energy:?}");
    // The errors include the quadrature error of the losses.
    let (found, _, _) = measured.budget(&BudgetRequest::default()).unwrap();
    let (lost, error) = (found.lost[1200], found.errors.unwrap()["lost_energy"][1200]);
    let truth = run.energy_lost.as_ref().unwrap().row(1200).sum();
    assert!((lost - truth).abs() < 3.0 * error, "{lost} {truth} {error}");
    assert!(error < 5e-3, "{lost} {truth} {error}");
}

/// A linear dimer has branches. Their energies have errors, also with uncertain masses.
#[test]
fn val_simulation_branches_of_uncertain_chains() {
    let n = 32;
    let chain = chain(
        (0..n).map(|j| [1.0, 2.0][j % 2]).collect(),
        vec![1.0; n],
        spring(0.0, 0.0),
        Ends::Periodic,
    );
    let mut simulation = Simulation::impact(chain, 1.0, 30.0, 601);
    simulation.estimate_error = false;
    let run = simulation.run(&Silent).unwrap();
    let record = Spoilt::by(1e-3).of(&run, 8);
    let options = MeasuredOptions {
        noise: wavecascade::budget::measured::Noise::Stated {
            deviation: 1e-3,
            offset: 0.0,
        },
        ..options(
            Drift::None,
            changed(Uncertainty::default(), |it| it.mass = vec![0.02]),
        )
    };
    let measured = measure(&run, record.view(), &options);
    let request = BudgetRequest::default();
    let (found, arrays, errors) = measured.budget(&request).unwrap();
    let (_, exact) = budget(&Motion::of(&run).unwrap(), &pinned(&found)).unwrap();
    for name in [LargeArray::ACOUSTIC_SPECTRUM, LargeArray::OPTICAL_SPECTRUM] {
        let [within, over] = coverage(&arrays[&name], &exact[&name], &errors[&name]);
        assert!(within > 0.99 && over > 0.8, "{within} {over}");
    }
    let errors = found.errors.as_ref().unwrap();
    assert!(errors["optical_energy"].iter().all(|error| *error > 0.0));
    // A linear chain: noise alone gives no direction.
    assert_eq!(found.direction().unwrap(), Direction::Unresolved);

    let refused = measured.budget(&changed(request, |it| {
        it.integration = Integration::Stepping
    }));
    assert!(refused.unwrap_err().is_usage());
    let mut wrong = [-0.1, 1.0, f64::NAN, 0.0, 0.0].map(gains);
    wrong[3].mass = vec![0.1; 3];
    wrong[4].coefficient = vec![0.1; n + 1];
    for uncertainty in wrong {
        let options = changed(options.clone(), |it| it.uncertainty = uncertainty);
        let refused = from_velocities(record.view(), [0.0, step(&run)], &run.chain, &options);
        assert!(refused.unwrap_err().is_usage());
    }
}
