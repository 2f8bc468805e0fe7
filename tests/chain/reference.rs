//! Chains against programs of other methods in twice the precision.
//!
//! `data/dimer_14.622.npz` and `data/flights.json` are of `data/chain_reference.py`: Stoermer extrapolation of order 22 in
//! double-double arithmetic, local error 1e-24; from 1e-22 to 1e-24 the velocities of the dimer change by 6e-17. The same program
//! repeats the trajectories of a third one, of order 12 in double-double arithmetic, to 7e-15 at six stiffness ratios
//! (`data/chain_reference.py check`); these lie beside the repository.

use std::path::PathBuf;

use ndarray::{Array1, Array2};
use ndarray_npy::NpzReader;
use test_support::scenes::{apart, data, data_file, near, numbers, simulation};
use test_support::shared::shared_data;
use wavecascade::chain::{Accuracy, Chain, Record, Run, RunWarning, Scheme, Simulation};
use wavecascade::observer::Silent;

/// Runs of an impacted dimer at the samples of a reference, and how far they are from it.
fn compared(path: PathBuf, kappa: f64) -> impl FnMut(Scheme, i32) -> (f64, Run) {
    let mut npz = NpzReader::new(std::fs::File::open(path).unwrap()).unwrap();
    let time: Array1<f64> = npz.by_name("t").unwrap();
    let velocity: Array2<f64> = npz.by_name("v").unwrap();
    let (samples, sites) = velocity.dim();
    let mut it = Simulation::impact(Chain::dimer(sites, kappa), 1.0, time[samples - 1], samples);
    it.record = Record::default();
    move |scheme, exponent| {
        it.scheme = scheme;
        it.accuracy = Accuracy::Tolerance(10f64.powi(-exponent));
        let run = it.run(&Silent).unwrap();
        let worst = apart(&run.velocity, &velocity);
        println!(
            "{kappa} {scheme:?} 1e-{exponent}: {worst:.1e} {:?}",
            run.report
        );
        (worst, run)
    }
}

#[test]
fn val_double_double_dimer_14_622_tolerances_are_delivered() {
    let mut delivered = compared(data_file("dimer_14.622.npz"), 14.622);
    for exponent in 4..=10 {
        let (worst, run) = delivered(Scheme::Nystrom, exponent);
        assert!(run.report.warnings.is_empty() && worst <= 10f64.powi(-exponent));
        // Nor are the steps needlessly short.
        assert!(exponent > 4 || worst > 1e-9, "{worst:e}");
    }
    // The chain amplifies rounding to this, and the run says so.
    let (worst, run) = delivered(Scheme::Nystrom, 11);
    near(worst, 0.0, 1.2e-11, "1e-11");
    assert_eq!(run.report.warnings.len(), 1);
    let (worst, run) = delivered(Scheme::RungeKutta, 8);
    assert!(worst <= 1e-8 && run.report.warnings.is_empty(), "{worst:e}");
}

#[test]
fn val_reference_tolerances_are_delivered() {
    for kappa in ["1", "2.398", "4.9272", "1631", "10000", "1000000"] {
        let name = format!("chain_reference/N100_kappa{kappa}.npz");
        let Some(path) = shared_data(&name) else {
            return;
        };
        let mut delivered = compared(path, kappa.parse().unwrap());
        for exponent in [4, 6, 8, 9, 10, 11] {
            let (worst, run) = delivered(Scheme::Nystrom, exponent);
            // Of as many steps as the largest ratio takes, rounding leaves 1.1e-11.
            let is_rounding = kappa == "2.398" || (kappa == "1000000" && exponent == 11);
            match run.report.warnings.is_empty() {
                true => near(worst, 0.0, 10f64.powi(-exponent), kappa),
                false => assert!(is_rounding, "{kappa} 1e-{exponent}"),
            }
        }
    }
}

/// Bodies that fly and collide many times: two runs agree to a half or a third of the error that rounding leaves, which
/// the stated one holds. Below it no tolerance is assured.
#[test]
fn val_double_double_flights_have_the_stated_error() {
    let known = data("flights.json");
    let cases = known["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 2);
    for case in cases {
        let with = |tolerance: &str| {
            let it = simulation(&format!(
                "ends = 'free'\nsites = {}\nmasses = {}\ncoefficients = {}\nvelocities = {}\nend_time = {}\nsamples = {}\n\
                 tolerance = {tolerance}",
                numbers(&case["mass"]).len(),
                case["mass"],
                case["coefficient"],
                case["velocity"],
                case["end_time"],
                case["samples"]
            ));
            it.run(&Silent).unwrap()
        };
        let run = with(&case["tolerance"].to_string());
        let sample = case["sample"].as_u64().unwrap() as usize;
        let worst = apart(run.velocity.row(sample), numbers(&case["expected"]));
        let stated = run.report.error.unwrap();
        let share = worst / run.report.velocity_scale / stated;
        assert!((0.05..1.0).contains(&share), "{worst:e} {stated:e}");
        assert!(run.report.warnings.is_empty(), "{:?}", run.report);
        let report = with("1e-13").report;
        assert!(report.error.unwrap() > 1e-13);
        let warnings = &report.warnings[..];
        let told = matches!(warnings, [RunWarning::Rounding { .. }]);
        assert!(told, "{warnings:?}");
    }
}
