//! Trajectories of impacted dimers against double-double references of order 12.

use std::path::PathBuf;

use ndarray::{Array1, Array2};
use ndarray_npy::NpzReader;
use wavecascade::chain::{Accuracy, Chain, Record, Run, Simulation};
use wavecascade::observer::Silent;

struct Reference {
    time: Array1<f64>,
    velocity: Array2<f64>,
}

/// `None`, said loudly, where the references are not beside the checkout.
fn reference(kappa: &str) -> Option<Reference> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/data/chain_reference")
        .join(format!("N100_kappa{kappa}.npz"));
    let Ok(file) = std::fs::File::open(&path) else {
        println!("NOT TESTED: {} is missing", path.display());
        return None;
    };
    let mut npz = NpzReader::new(file).unwrap();
    Some(Reference {
        time: npz.by_name("t").unwrap(),
        velocity: npz.by_name("v").unwrap(),
    })
}

fn simulation(kappa: &str, reference: &Reference) -> Simulation {
    let chain = Chain::dimer(100, kappa.parse().unwrap());
    let end = reference.time[reference.time.len() - 1];
    let mut simulation = Simulation::impact(chain, 1.0, end, reference.time.len());
    simulation.record = Record::default();
    simulation
}

fn error(run: &Run, reference: &Reference) -> f64 {
    (&run.velocity - &reference.velocity)
        .iter()
        .fold(0.0, |worst, d| worst.max(d.abs()))
}

#[test]
fn val_reference_tolerances_are_delivered() {
    for kappa in ["1", "2.398", "4.9272", "1631", "10000", "1000000"] {
        let Some(reference) = reference(kappa) else {
            return;
        };
        for exponent in [4, 6, 8, 9, 10, 11] {
            let tolerance = 10f64.powi(-exponent);
            let mut s = simulation(kappa, &reference);
            s.accuracy = Accuracy::Tolerance(tolerance);
            let run = s.run(&Silent).unwrap();
            let delivered = error(&run, &reference);
            let estimated = run.report.error.unwrap();
            println!(
                "{kappa} {tolerance:e}: delivered {delivered:.1e}, estimated {estimated:.1e} {:?}",
                run.report.warnings
            );
            if run.report.warnings.is_empty() {
                assert!(
                    delivered <= tolerance,
                    "{kappa} {tolerance:e}: {delivered:e}"
                );
            } else {
                // Of as many steps as the largest ratio takes, rounding leaves 1.1e-11.
                let is_rounding = [kappa, &exponent.to_string()] == ["1000000", "11"];
                assert!(kappa == "2.398" || is_rounding, "{kappa} {tolerance:e}");
            }
        }
    }
}
