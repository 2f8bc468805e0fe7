//! Values that are known are found again, with the intervals of the closed form.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use ndarray::Array2;
use wavecascade::chain::scene::SceneSource;
use wavecascade::field::Quantity;
use wavecascade::fit::{Fitted, Records};
use wavecascade::observer::{Observer, Silent};
use wavecascade::sheet::Describe;

use super::made::Measurement;

fn chain(kappa: f64, speed: f64, tangent: f64) -> String {
    format!(
        "sites = 12\nstiffness_ratio = {kappa:?}\nstriker_velocity = {speed:?}\ntangent = {tangent:?}"
    )
}

fn assert_near(found: &Fitted, name: &str, expected: f64, most: f64) {
    let value = found.value(name).unwrap();
    let off = (value.value / expected - 1.0).abs();
    assert!(off < most, "{name}: {off:e}");
}

/// Without noise the values are those of the scene that was run.
#[test]
fn val_scene_without_noise_from_five_starts() {
    let mut made = Measurement::of(&[2, 5, 8, 11], 300, 20.0);
    made.noise = 0.0;
    for quantity in [Quantity::Velocity, Quantity::Displacement, Quantity::Force] {
        made.quantity = quantity;
        let field = made.measured(&chain(2.0, 1.1, 0.02));
        let mut request = made.request(&[
            "stiffness_ratio=1.5..2.5",
            "striker_velocity=0.9..1.2",
            "tangent=0..0.05",
        ]);
        request.starts = 5;
        let scene = SceneSource::new(None, chain(1.7, 1.0, 0.01));
        let found = request.run(&field, &scene, &Silent).unwrap();
        println!(
            "{quantity:?}: {}; {} runs",
            found.describe().answer,
            found.runs
        );
        assert!(found.is_exact && found.misfit.is_none());
        assert!(found.agreeing() >= 4, "{:?}", found.searches);
        assert_near(&found, "stiffness_ratio", 2.0, 1e-7);
        assert_near(&found, "striker_velocity", 1.1, 1e-7);
        assert_near(&found, "tangent", 0.02, 1e-5);
    }
}

/// A mass between a free end and a wall, on a spring: v = v0 cos(w t), w^2 = c/m. The intervals are those of linear
/// least squares with the derivatives in closed form.
#[test]
fn val_closed_form_intervals_of_an_oscillator() {
    let scene = |c: f64, v: f64| {
        format!(
            "sites = 1\nlaw = \"spring\"\ncoefficient_cell = [{c:?}]\nstriker_velocity = {v:?}\nend_time = 20.0"
        )
    };
    let made = Measurement {
        noise: 0.05,
        ..Measurement::of(&[0], 200, 20.0)
    };
    let found = made
        .fit(
            &scene(1.44, 2.0),
            &scene(1.5, 1.9),
            &["coefficient_cell[0]", "striker_velocity"],
        )
        .unwrap();
    let (c, v) = (
        found.value("coefficient_cell[0]").unwrap(),
        found.value("striker_velocity").unwrap(),
    );
    let w = c.value.sqrt();
    let mut sums = [[0.0; 2]; 2];
    for i in 0..200 {
        let t = 20.0 * f64::from(i) / 199.0;
        let along = [-v.value * t * (w * t).sin() / (2.0 * w), (w * t).cos()];
        for a in 0..2 {
            for b in 0..2 {
                sums[a][b] += along[a] * along[b];
            }
        }
    }
    let determinant = sums[0][0] * sums[1][1] - sums[0][1] * sums[1][0];
    let errors = [sums[1][1], sums[0][0]].map(|s| found.noise * (s / determinant).sqrt());
    // Student's t of 198 degrees.
    for (value, error) in [c, v].into_iter().zip(errors) {
        let half = 0.5 * (value.high - value.low) / 1.972;
        assert!((half / error - 1.0).abs() < 2e-3, "{half:e} {error:e}");
    }
    let correlation = -sums[0][1] / (sums[0][0] * sums[1][1]).sqrt();
    assert!((found.correlation[[0, 1]] - correlation).abs() < 1e-3);
}

/// Gains, the clock, gaps and times before the start.
#[test]
fn val_scene_with_gains_and_a_shifted_clock() {
    let made = Measurement {
        noise: 0.005,
        ..Measurement::of(&[2, 5, 8, 11], 400, 24.0)
    };
    let mut records = made.records(&made.run(&chain(2.0, 1.1, 0.02)));
    for (site, gain) in [1.03, 0.98, 1.0, 0.99].into_iter().enumerate() {
        records.column_mut(site).mapv_inplace(|v| v * gain);
    }
    let mut noisy = made.with_noise(&records);
    noisy[[50, 1]] = f64::NAN;
    let mut field = made.field(noisy);
    field.time.origin = -1.7;
    let mut request = made.request(&["stiffness_ratio", "striker_velocity", "tangent"]);
    request.instruments.time_shift = true;
    request.instruments.gain_error = Some(0.03);
    let scene = SceneSource::new(None, chain(1.9, 1.05, 0.01));
    let found = request.run(&field, &scene, &Silent).unwrap();
    assert!(found.misfit.is_none(), "{}", found.describe().answer);
    assert_eq!(found.overlay.records.known(), 1599);
    for (name, expected) in [
        ("stiffness_ratio", 2.0),
        ("tangent", 0.02),
        ("gain[2]", 1.03),
        ("gain[5]", 0.98),
        ("time_shift", -1.7),
    ] {
        let value = found.value(name).unwrap();
        assert!(value.low < expected && expected < value.high, "{value:?}");
    }
}

/// Without a rate or a length, masses and coefficients are known up to a factor, and in an impact on bodies at rest two
/// factors of the speed.
#[test]
fn val_scaling_what_is_not_determined_is_said() {
    let scene = |c: f64| {
        format!("sites = 8\ncoefficient_cell = [{c:?}]\nmass_cell = [1.0]\nstriker_velocity = 1.0")
    };
    let made = Measurement::of(&[2, 5, 7], 200, 14.0);
    let found = made
        .fit(
            &scene(2.0),
            &scene(1.9),
            &["coefficient_cell[0]", "mass_cell[0]"],
        )
        .unwrap();
    assert_eq!(found.undetermined.len(), 1);
    assert_eq!(
        found.undetermined[0].words,
        "coefficient_cell[0] and mass_cell[0] only as coefficient_cell[0]/mass_cell[0]"
    );
    assert!(found.values.iter().all(|value| value.low.is_nan()));
}

/// Records at uneven times.
#[test]
fn val_scene_at_uneven_times() {
    let made = Measurement {
        noise: 0.0,
        ..Measurement::of(&[3, 7], 801, 16.0)
    };
    let all = made.records(&made.run(&chain(2.0, 1.0, 0.0)));
    let picked: Vec<usize> = (0..801).filter(|i| (i * i) % 7 < 3).collect();
    let values = Array2::from_shape_fn((2, picked.len()), |(j, i)| all[[picked[i], j]]);
    let records = Records {
        quantity: Quantity::Velocity,
        times: picked.iter().map(|i| 0.02 * *i as f64).collect(),
        bodies: vec![3, 7],
        values: values.iter().copied().collect(),
        units: [String::new(), String::new()],
    };
    let scene = SceneSource::new(None, chain(1.8, 1.0, 0.0));
    let request = made.request(&["stiffness_ratio"]);
    let found = request.of_records(records, &scene, &Silent).unwrap();
    assert_near(&found, "stiffness_ratio", 2.0, 1e-7);
}

/// Spectra of what is left are densities: their integral is the mean square, at odd and even numbers of samples.
#[test]
fn val_parseval_spectra_of_the_residual() {
    let scene = |c: f64| {
        format!("sites = 3\nlaw = \"spring\"\ncoefficient_cell = [{c:?}]\nend_time = 20.0")
    };
    for samples in [200, 201] {
        let made = Measurement {
            noise: 0.05,
            ..Measurement::of(&[0, 2], samples, 20.0)
        };
        let found = made
            .fit(&scene(1.4), &scene(1.5), &["coefficient_cell[0]"])
            .unwrap();
        let (records, left) = (&found.overlay.records, &found.overlay.residual);
        let integral = records.frequencies()[1] * records.density(left).iter().sum::<f64>();
        let mean = left.iter().map(|r| r * r).sum::<f64>() / left.len() as f64;
        assert!(
            (integral / mean - 1.0).abs() < 1e-12,
            "{samples}: {integral} {mean}"
        );
    }
}

/// Cancels once so many searches have ended, and counts how often it is asked: of a run at least once.
struct Impatient {
    most: u64,
    ended: AtomicU64,
    asked: AtomicU64,
}

impl Impatient {
    fn after(most: u64) -> Impatient {
        let [ended, asked] = [AtomicU64::new(0), AtomicU64::new(0)];
        Impatient { most, ended, asked }
    }
}

impl Observer for Impatient {
    fn stage(&self, _: &'static str, _: u64) {}

    fn advance(&self, units: u64) {
        self.ended.fetch_add(units, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed);
        self.ended.load(Ordering::Relaxed) >= self.most
    }
}

/// Cancels once causes are tried.
#[derive(Default)]
struct UntilCauses(AtomicBool);

impl Observer for UntilCauses {
    fn stage(&self, name: &'static str, _: u64) {
        self.0.fetch_or(name == "causes", Ordering::Relaxed);
    }

    fn advance(&self, _: u64) {}

    fn cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// A fit that was stopped goes on where it was, with the same bits and fewer runs; another one is refused there.
#[test]
fn regress_a_stopped_fit_resumes() {
    let made = Measurement::of(&[2, 7], 200, 14.0);
    let field = made.measured(&chain(2.0, 1.0, 0.01));
    let scene = SceneSource::new(None, chain(1.8, 1.0, 0.02));
    let mut request = made.request(&["stiffness_ratio=1..3", "tangent=0..0.1"]);
    request.starts = 4;
    let patient = Impatient::after(u64::MAX);
    let whole = request.run(&field, &scene, &patient).unwrap();
    let place = test_support::place::Place::new();
    request.resume = Some(place.path("journal"));
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let stopped = one.install(|| request.run(&field, &scene, &Impatient::after(1)));
    assert!(matches!(
        stopped,
        Err(wavecascade::Error::Paused { known: 1.., .. })
    ));
    let kept = std::fs::read_to_string(place.path("journal/members.jsonl")).unwrap();
    assert!((1..4).contains(&kept.lines().count()), "{kept}");
    let resumed = request.run(&field, &scene, &Silent).unwrap();
    let short = Impatient::after(u64::MAX);
    let again = request.run(&field, &scene, &short).unwrap();
    let [short, long] = [short, patient].map(|observer| observer.asked.into_inner());
    assert!(2 * short < long, "{short} of {long}");
    // The sheet has every number, those of the runs among them.
    let numbers = |fitted: &Fitted| serde_json::to_string(&fitted.describe().numbers).unwrap();
    for other in [&resumed, &again] {
        assert_eq!(numbers(other), numbers(&whole));
        assert_eq!(other.overlay.residual, whole.overlay.residual);
    }
    // Searches that have ended are kept while causes are tried, too.
    let scene = SceneSource::new(None, chain(1.8, 1.0, 0.02).replace("= 12", "= 9"));
    request.resume = Some(place.path("misfit"));
    let stopped = request.run(&field, &scene, &UntilCauses::default());
    let Err(wavecascade::Error::Paused { known, members }) = stopped else {
        panic!("{stopped:?}");
    };
    assert_eq!((known, members), (4, 4));
    request.resume = Some(place.path("journal"));
    let scene = SceneSource::new(None, chain(1.8, 1.0, 0.02));
    // Other records, and other starts.
    let others = Measurement { seed: 2, ..made }.measured(&chain(2.0, 1.0, 0.01));
    for (field, seed) in [(&others, request.seed), (&field, 1)] {
        request.seed = seed;
        let error = request.run(field, &scene, &Silent).unwrap_err().to_string();
        assert!(error.contains("holds another fit"), "{error}");
    }
}
