//! Energy by normal mode, against closed forms, DOP853 of SciPy (`tests/data/make_fput.py`) and FPUT's report.

use std::f64::consts::PI;

use serde_json::Value;
use wavecascade::arrays::LargeArray;
use wavecascade::budget::{BudgetRequest, ModeBudget, Motion, Views, budget};
use wavecascade::chain::Run;
use wavecascade::chain::scene::SceneSource;
use wavecascade::observer::Silent;

fn run(text: &str) -> Run {
    let setup = SceneSource::new(None, text).setup().unwrap();
    setup.simulation.run(&Silent).unwrap()
}

fn modes_of(run: &Run) -> (ModeBudget, ndarray::Array2<f64>) {
    let request = BudgetRequest {
        views: Views {
            wavenumber: false,
            frequency: false,
            scale: false,
        },
        normal_modes: true,
        ..BudgetRequest::default()
    };
    let (found, arrays) = budget(&Motion::of(run).unwrap(), &request).unwrap();
    let energies = arrays.get(&LargeArray::MODE_ENERGY).unwrap().clone();
    (found.modes.unwrap(), energies)
}

fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().unwrap().iter();
    values.map(|value| value.as_f64().unwrap()).collect()
}

/// Modes of a linear dimer with free ends keep their energies, and the entropy of six of them is ln 6.
#[test]
fn val_closed_form_linear_chain() {
    let run = run(
        "sites = 20\nlaw = \"spring\"\nends = \"free\"\nmass_ratio = 3.0\nstiffness_ratio = 2.0\nmodes = [2, 7]\n\
                   mode_energy = 0.5\nend_time = 80.0\nsamples = 30\ntolerance = 1e-11\nseed = 2\n",
    );
    let (found, energies) = modes_of(&run);
    assert_eq!(energies.dim(), (30, 19));
    for i in 0..30 {
        for k in 0..19 {
            let known = if (1..7).contains(&k) { 0.5 } else { 0.0 };
            let off = (energies[[i, k]] - known).abs();
            assert!(off < 1e-10, "{i} {k}: {off:e}");
        }
        assert!((found.entropy[i] - 6f64.ln()).abs() < 1e-9, "{i}");
        assert!((found.normalized_entropy[i] - 1.0).abs() < 1e-9, "{i}");
        assert!((found.energy[i] - 3.0).abs() < 1e-10, "{i}");
    }
    assert_eq!(found.equipartition, None);
    let known: f64 = (2..=19).map(|k| 1.0 / f64::from(k)).sum();
    assert!((found.equilibrium - known).abs() < 1e-15);
}

const FPUT: &str = "sites = 31\nlaw = \"spring\"\nalpha = 0.25\nends = \"fixed\"\nmode = 1\nmode_amplitude = 1.0\nrecord = [\"displacement\"]\n";

#[test]
fn val_scipy_fput() {
    let text = std::fs::read_to_string("tests/data/fput.json").unwrap();
    let known: Value = serde_json::from_str(&text).unwrap();
    let period = known["period"].as_f64().unwrap();
    let run = run(&format!(
        "{FPUT}end_time = {:?}\nsamples = 721\ntolerance = 1e-11\n",
        180.0 * period
    ));
    let (found, energies) = modes_of(&run);
    assert!((2.0 * PI / found.frequency[0] / period - 1.0).abs() < 1e-12);
    let first = found.energy[0];
    for (place, i) in known["samples"].as_array().unwrap().iter().enumerate() {
        let i = i.as_u64().unwrap() as usize;
        for (k, energy) in numbers(&known["energies"][place]).iter().enumerate() {
            let off = (energies[[i, k]] - energy).abs() / first;
            assert!(off < 3e-9, "{i} {k}: {off:e}");
        }
        let entropy = known["entropy"][place].as_f64().unwrap();
        assert!(
            (found.entropy[i] - entropy).abs() < 3e-8,
            "{i}: {} {entropy}",
            found.entropy[i]
        );
    }
    // Mode 1 has 98.1 % of the energy again after 146.75 of its periods.
    let at = known["recurrence"].as_f64().unwrap();
    assert_eq!(recurrence(&energies, &found), (4.0 * at) as usize);
    assert!(found.equipartition.is_none());
}

/// The sample after a hundred periods at which mode 1 has most of the energy.
fn recurrence(energies: &ndarray::Array2<f64>, found: &ModeBudget) -> usize {
    let share = |i: usize| energies[[i, 0]] / found.energy[i];
    let late = 401..found.energy.len();
    late.max_by(|a, b| share(*a).total_cmp(&share(*b))).unwrap()
}

/// With the step of the first computation, dt^2 = 1/8, it comes back after its 157 periods: the step adds an eighth
/// to the frequencies' third powers, so that recurrences come 7 % later than in the chain itself.
#[test]
fn val_published_fput_recurrence() {
    let period = PI / (PI / 64.0).sin();
    let run = run(&format!(
        "{FPUT}end_time = {:?}\nsamples = 721\nscheme = \"velocity-verlet\"\nstep = {:?}\n",
        180.0 * period,
        0.125f64.sqrt()
    ));
    let (found, energies) = modes_of(&run);
    let at = recurrence(&energies, &found) as f64 / 4.0;
    println!("{at}");
    assert!((at - 157.0).abs() < 1.0, "{at}");
}

/// Modes that share evenly from the start reach no equilibrium later, and a driven chain has none.
#[test]
fn equilibrium_is_told_of_chains_that_start_below_it_and_are_not_driven() {
    let text = "sites = 12\nlaw = \"spring\"\nends = \"free\"\nend_time = 20.0\nsamples = 40\n";
    let even = run(&format!("{text}modes = [1, 11]\nmode_energy = 0.1\n"));
    let (found, _) = modes_of(&even);
    assert!(found.entropy[0] > found.equilibrium);
    assert_eq!(found.equipartition, None);
    let driven = run(&format!(
        "{text}drive = \"force\"\ndrive_amplitude = 0.1\ndrive_frequency = 0.1\n"
    ));
    let (found, _) = modes_of(&driven);
    assert!(found.equilibrium.is_nan() && found.entropy[0].is_nan());
    assert_eq!(found.equipartition, None);
}

/// The energy of a bistable contact in its lower well is no square: energy by wavenumber is refused, that by frequency is not.
#[test]
fn energies_below_those_at_rest_have_no_wavenumbers() {
    let run = run(
        "sites = 8\nlaw = \"polynomial 0.6 -0.8 0.2\"\nstriker_velocity = 4.0\nend_time = 20.0\nsamples = 200\n",
    );
    let motion = Motion::of(&run).unwrap();
    let only = |wavenumber: bool| {
        let request = BudgetRequest {
            views: Views {
                wavenumber,
                frequency: true,
                scale: false,
            },
            ..BudgetRequest::default()
        };
        budget(&motion, &request)
    };
    assert!(only(false).is_ok());
    let error = only(true).unwrap_err().to_string();
    assert!(error.contains("never below that at rest"), "{error}");
}
