//! Energy by normal mode, against closed forms, DOP853 of SciPy (`tests/data/make_fput.py`) and FPUT's report.

use std::f64::consts::PI;

use ndarray::Array2;
use test_support::changed;
use test_support::scenes::{apart, data, numbers, run};
use wavecascade::arrays::LargeArray;
use wavecascade::budget::{BudgetRequest, ModeBudget, Motion, Views, budget};
use wavecascade::chain::Run;

use crate::budget_of;

/// A request of these views.
fn views(wavenumber: bool, frequency: bool) -> BudgetRequest {
    changed(BudgetRequest::default(), |it| {
        it.views = Views {
            wavenumber,
            frequency,
            scale: false,
        }
    })
}

fn modes_of(run: &Run) -> (ModeBudget, Array2<f64>) {
    let request = changed(views(false, false), |it| it.normal_modes = true);
    let (found, arrays) = budget_of(run, &request);
    (
        found.modes.unwrap(),
        arrays[&LargeArray::MODE_ENERGY].clone(),
    )
}

/// Modes of a linear dimer with free ends keep their energies, and the entropy of six of them is ln 6.
#[test]
fn val_closed_form_linear_chain() {
    let run = run(
        "sites = 20\nlaw = \"spring\"\nends = \"free\"\nmass_ratio = 3.0\nstiffness_ratio = 2.0\nmodes = [2, 7]\n\
                   mode_energy = 0.5\nend_time = 80.0\nsamples = 30\ntolerance = 1e-11\nseed = 2\n",
    );
    let (found, energies) = modes_of(&run);
    let known = |(_, k): (usize, usize)| if (1..7).contains(&k) { 0.5 } else { 0.0 };
    assert!(apart(&energies, Array2::from_shape_fn((30, 19), known)) < 1e-10);
    assert!(apart(&found.entropy, [6f64.ln(); 30]) < 1e-9);
    assert!(apart(&found.normalized_entropy, [1.0; 30]) < 1e-9);
    assert!(apart(&found.energy, [3.0; 30]) < 1e-10);
    assert_eq!(found.equipartition, None);
    let known: f64 = (2..=19).map(|k| 1.0 / f64::from(k)).sum();
    assert!((found.equilibrium - known).abs() < 1e-15);
}

/// FPUT's chain over 180 periods of its first mode, four samples in each, and the sample after a hundred at which that mode has most
/// of the energy.
fn fput(period: f64, steps: &str) -> (ModeBudget, Array2<f64>, usize) {
    let run = run(&format!(
        "sites = 31\nlaw = 'spring'\nalpha = 0.25\nends = 'fixed'\nmode = 1\nmode_amplitude = 1.0\nrecord = ['displacement']\n\
         samples = 721\nend_time = {:?}\n{steps}",
        180.0 * period
    ));
    let (found, energies) = modes_of(&run);
    let share = |i: usize| energies[[i, 0]] / found.energy[i];
    let back = (401..721).max_by(|a, b| share(*a).total_cmp(&share(*b)));
    (found, energies, back.unwrap())
}

#[test]
fn val_scipy_fput() {
    let known = data("fput.json");
    let period = known["period"].as_f64().unwrap();
    let (found, energies, back) = fput(period, "tolerance = 1e-11");
    assert!((2.0 * PI / found.frequency[0] / period - 1.0).abs() < 1e-12);
    for (place, i) in numbers(&known["samples"]).into_iter().enumerate() {
        let i = i as usize;
        let lowest = numbers(&known["energies"][place]);
        let off = apart(energies.row(i).iter().take(lowest.len()), &lowest) / found.energy[0];
        assert!(off < 3e-9, "{i}: {off:e}");
        let entropy = known["entropy"][place].as_f64().unwrap();
        assert!((found.entropy[i] - entropy).abs() < 3e-8, "{i}: {entropy}");
    }
    // Mode 1 has 98.1 % of the energy again after 146.75 of its periods.
    let at = known["recurrence"].as_f64().unwrap();
    assert_eq!(back, (4.0 * at) as usize);
    assert!(found.equipartition.is_none());
}

/// With the step of the first computation, dt^2 = 1/8, it comes back after its 157 periods: the step adds an eighth
/// to the frequencies' third powers, so that recurrences come 7 % later than in the chain itself.
#[test]
fn val_published_fput_recurrence() {
    let steps = format!("scheme = 'velocity-verlet'\nstep = {:?}", 0.125f64.sqrt());
    let (_, _, back) = fput(PI / (PI / 64.0).sin(), &steps);
    assert!((back as f64 / 4.0 - 157.0).abs() < 1.0, "{back}");
}

/// Modes that share evenly from the start reach no equilibrium later, and a driven chain has none.
#[test]
fn equilibrium_is_told_of_chains_that_start_below_it_and_are_not_driven() {
    let of = |keys: &str| {
        let text = "sites = 12\nlaw = 'spring'\nends = 'free'\nend_time = 20.0\nsamples = 40";
        modes_of(&run(&format!("{text}\n{keys}"))).0
    };
    let even = of("modes = [1, 11]\nmode_energy = 0.1");
    assert!(even.entropy[0] > even.equilibrium);
    let driven = of("drive = 'force'\ndrive_amplitude = 0.1\ndrive_frequency = 0.1");
    assert!(driven.equilibrium.is_nan() && driven.entropy[0].is_nan());
    assert_eq!((even.equipartition, driven.equipartition), (None, None));
}

/// The energy of a bistable contact in its lower well is no square: energy by wavenumber is refused, that by frequency is not.
#[test]
fn energies_below_those_at_rest_have_no_wavenumbers() {
    let run = run(
        "sites = 8\nlaw = \"polynomial 0.6 -0.8 0.2\"\nstriker_velocity = 4.0\nend_time = 20.0\nsamples = 200\n",
    );
    let motion = Motion::of(&run).unwrap();
    assert!(budget(&motion, &views(false, true)).is_ok());
    let error = budget(&motion, &views(true, true)).unwrap_err().to_string();
    assert!(error.contains("never below that at rest"), "{error}");
}
