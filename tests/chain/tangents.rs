//! Derivatives of runs against differences of runs.

use ndarray::Axis;
use wavecascade::chain::scene::{SceneSource, Setting};
use wavecascade::chain::{Accuracy, Direction, Simulation};
use wavecascade::fit::gradient;
use wavecascade::observer::Silent;

/// The simulation of a scene in which `@` stands for the parameter.
fn simulation(scene: &str, value: f64) -> Simulation {
    let text = scene.replace('@', &format!("{value:?}"));
    let setup = SceneSource::new(None, &text).setup();
    setup
        .unwrap_or_else(|error| panic!("{text}: {error}"))
        .simulation
}

/// Derivatives of the last velocities, by differences of fourth order of runs of the least error.
fn differences(scene: &str, value: f64) -> Vec<f64> {
    let last = |value: f64| {
        let mut simulation = simulation(scene, value);
        simulation.accuracy = Accuracy::LocalError(1e-14);
        simulation.estimate_error = false;
        let run = simulation.run(&Silent).unwrap();
        run.velocity.row(run.velocity.nrows() - 1).to_vec()
    };
    let step = 1e-4 * value;
    let at = [-2.0, -1.0, 1.0, 2.0].map(|i| last(value + i * step));
    (0..at[0].len())
        .map(|j| (8.0 * (at[2][j] - at[1][j]) - (at[3][j] - at[0][j])) / (12.0 * step))
        .collect()
}

fn tangents(scene: &str, value: f64, end: f64) -> Vec<f64> {
    let step = 2e-6 * value;
    let [below, above] = [value - step, value + step].map(|value| simulation(scene, value));
    let direction = Direction::between(&below, &above, 2.0 * step).unwrap();
    let found = simulation(scene, value).tangents(&[direction], &[end], 1e-11, &Silent);
    found.unwrap()[1].iter().copied().collect()
}

const HEAD: &str = "sites = 12\nsamples = 3\nend_time = 15.0\n";

#[test]
fn val_differences_of_runs() {
    let rows = include_str!("tangents.txt").lines().skip(1);
    for row in rows {
        let cells: Vec<&str> = row.split(" | ").collect();
        let (name, scene) = (cells[0], cells[1].replace("\\n", "\n"));
        let value: f64 = cells[2].parse().unwrap();
        let head = if scene.contains("sites") {
            HEAD.replace("sites = 12\n", "")
        } else {
            HEAD.to_owned()
        };
        let scene = head + &scene + "\n";
        let (found, known) = (tangents(&scene, value, 15.0), differences(&scene, value));
        let size = known.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let pairs = found.iter().zip(&known);
        let off = pairs.fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        println!("{name}: {:.1e}", off / size);
        // Differences themselves have errors near 1e-9.
        let most = 6e-8;
        assert!(off < most * size, "{name}: {:e}", off / size);
    }
}

/// By keys with units, through the run file; errors stated are no less than true ones.
#[test]
fn val_differences_of_a_scene() {
    let text = "sites = 20\nradius = \"9 mm\"\nlength = \"18 mm\"\nangle = \"18 deg\"\nsecond_angle = \"90 deg\"\nyoung = \"72 GPa\"\npoisson = 0.17\n\
                density = 2200\nstriker_velocity = 0.6\nend_time = \"300 us\"\nsamples = 40\ntangent = \"0.5 us\"\ntolerance = 1e-8";
    let scene = SceneSource::new(None, text);
    let keys = ["young", "tangent", "striker_velocity"].map(str::to_owned);
    let run = scene.setup().unwrap().simulation.run(&Silent).unwrap();
    let found = gradient(&scene, &keys, &run.time.to_vec(), &Silent).unwrap();
    assert_eq!(found.names(), "young [GPa], tangent [us], striker_velocity");
    for (p, (key, value, unit)) in [
        ("young", 72.0, " GPa"),
        ("tangent", 0.5, " us"),
        ("striker_velocity", 0.6, " m/s"),
    ]
    .into_iter()
    .enumerate()
    {
        let at = |value: f64| {
            let set = Setting::new(key, format!("{value:?}{unit}"), "here");
            let mut simulation = scene.with(vec![set]).setup().unwrap().simulation;
            simulation.accuracy = Accuracy::LocalError(1e-13);
            simulation.estimate_error = false;
            simulation.run(&Silent).unwrap().velocity
        };
        let step = 3e-4 * value;
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|i| at(value + i * step));
        let known = (8.0 * (c - b) - (d - a)) / (12.0 * step);
        let size = known.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let found_here = found.velocity.index_axis(Axis(0), p);
        let off = (&found_here - &known)
            .iter()
            .fold(0.0f64, |m, v| m.max(v.abs()))
            / size;
        println!("{key}: {off:.1e}, stated {:.1e}", found.error[p]);
        assert!(
            off < found.error[p].max(1e-8) && (1e-7..1e-5).contains(&found.error[p]),
            "{key}: {off:e} {:e}",
            found.error[p]
        );
    }
    for (key, part) in [
        ("sites", "sweep"),
        ("drag", "to start from"),
        ("yong", "young"),
    ] {
        let error = gradient(&scene, &[key.to_owned()], &[0.0, 1e-4], &Silent).unwrap_err();
        assert!(error.to_string().contains(part), "{key}: {error}");
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

/// What moves a kink of the drive has no derivative here; neither have fixed steps.
#[test]
fn regress_what_has_no_gradient_is_refused() {
    let text = HEAD.to_owned()
        + "stiffness_ratio = 2.0\ndrive = \"force\"\ndrive_waveform = \"half-sine\"\ndrive_amplitude = 0.1\ndrive_duration = 2.0\n";
    let refused = |more: &str, key: &str| {
        let scene = SceneSource::new(None, &(text.clone() + more));
        let error = gradient(&scene, &[key.to_owned()], &[0.0, 1.0], &Silent).unwrap_err();
        error.to_string()
    };
    let said = refused("", "drive_duration");
    assert!(said.contains("sets in or ends"), "{said}");
    let said = refused(
        "scheme = \"velocity-verlet\"\nstep = 0.01\n",
        "drive_amplitude",
    );
    assert!(said.contains("chooses its steps"), "{said}");
}
