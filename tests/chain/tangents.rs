//! Derivatives of runs against differences of runs.

use ndarray::{Array2, Axis};
use test_support::contains_all;
use test_support::scenes::{apart, largest, rows, simulation};
use wavecascade::chain::scene::{SceneSource, Setting};
use wavecascade::chain::{Accuracy, Direction, Simulation};
use wavecascade::fit::gradient;
use wavecascade::observer::Silent;

/// Derivatives of the velocities, by differences of fourth order of runs of the least error.
fn differences(of: impl Fn(f64) -> Simulation, value: f64, step: f64) -> Array2<f64> {
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|i| {
        let mut it = of(value + i * step);
        it.accuracy = Accuracy::LocalError(1e-14);
        it.estimate_error = false;
        it.run(&Silent).unwrap().velocity
    });
    (8.0 * (c - b) - (d - a)) / (12.0 * step)
}

const HEAD: &str = "samples = 3\nend_time = 15.0\n";

#[test]
fn val_differences_of_runs() {
    for [name, keys, value] in rows(include_str!("tangents.txt")) {
        let value: f64 = value.parse().unwrap();
        let sites = if keys.contains("sites") {
            ""
        } else {
            "sites = 12\n"
        };
        // `@` stands for the parameter.
        let of = |value: f64| {
            simulation(&format!(
                "{HEAD}{sites}{}",
                keys.replace('@', &format!("{value:?}"))
            ))
        };
        let step = 2e-6 * value;
        let direction =
            Direction::between(&of(value - step), &of(value + step), 2.0 * step).unwrap();
        let found = of(value).tangents(&[direction], &[15.0], 1e-11, &Silent);
        let known = differences(of, value, 1e-4 * value);
        let off = apart(&found.unwrap()[1], known.row(2)) / largest(known.row(2));
        // Differences themselves have errors near 1e-9.
        assert!(off < 6e-8, "{name}: {off:e}");
    }
}

/// By keys with units, through the run file; errors stated are no less than true ones.
#[test]
fn val_differences_of_a_scene() {
    let text = "sites = 20\nradius = \"9 mm\"\nlength = \"18 mm\"\nangle = \"18 deg\"\nsecond_angle = \"90 deg\"\nyoung = \"72 GPa\"\npoisson = 0.17\n\
                density = 2200\nstriker_velocity = 0.6\nend_time = \"300 us\"\nsamples = 40\ntangent = \"0.5 us\"\ntolerance = 1e-8";
    let scene = SceneSource::new(None, text);
    let keys = ["young", "tangent", "striker_velocity"].map(str::to_owned);
    let time = simulation(text).run(&Silent).unwrap().time.to_vec();
    let found = gradient(&scene, &keys, &time, &Silent).unwrap();
    assert_eq!(found.names(), "young [GPa], tangent [us], striker_velocity");
    for (p, (value, unit)) in [(72.0, " GPa"), (0.5, " us"), (0.6, " m/s")]
        .into_iter()
        .enumerate()
    {
        let of = |value: f64| {
            let set = Setting::new(&keys[p], format!("{value:?}{unit}"), "here");
            scene.with([set]).setup().unwrap().simulation
        };
        let known = differences(of, value, 3e-4 * value);
        let off = apart(found.velocity.index_axis(Axis(0), p), &known) / largest(&known);
        let stated = found.error[p];
        assert!(off < stated.max(1e-8), "{}: {off:e} {stated:e}", keys[p]);
        assert!((1e-7..1e-5).contains(&stated), "{}: {stated:e}", keys[p]);
    }
}

/// Where nothing is amplified, no less than what is known is stated.
#[test]
fn regress_the_least_error_is_stated() {
    let scene = "sites = 2\nsamples = 3\nend_time = 1.0\nlaw = \"spring\"\ntolerance = 1e-11\nstriker_velocity = 1.0\n";
    let scene = SceneSource::new(None, scene);
    let keys = ["striker_velocity".to_owned()];
    let found = gradient(&scene, &keys, &[0.0, 0.5, 1.0], &Silent).unwrap();
    assert_eq!(found.error, [1e-7]);
}

/// What moves a kink of the drive has no derivative here; neither have fixed steps, nor keys that are not numbers or not there.
#[test]
fn regress_what_has_no_gradient_is_refused() {
    let drive = "drive = 'force'\ndrive_waveform = 'half-sine'\ndrive_amplitude = 0.1\ndrive_duration = 2.0\n";
    for (more, key, words) in [
        ("", "drive_duration", "sets in or ends"),
        (
            "scheme = 'velocity-verlet'\nstep = 0.01\n",
            "drive_amplitude",
            "chooses its steps",
        ),
        ("", "sites", "sweep"),
        ("", "drag", "to start from"),
        ("", "yong", "young"),
    ] {
        let text = format!("{HEAD}sites = 12\nstiffness_ratio = 2.0\n{drive}{more}");
        let scene = SceneSource::new(None, text);
        let error = gradient(&scene, &[key.to_owned()], &[0.0, 1.0], &Silent).unwrap_err();
        contains_all(&error.to_string(), &[words]);
    }
}
