//! What drives a chain, against DOP853 and splines of SciPy (`tests/data/make_drives.py`).

use std::fs;

use serde_json::Value;
use wavecascade::Field;
use wavecascade::chain::scene::SceneSource;
use wavecascade::chain::{Run, Waveform};
use wavecascade::field::OpenOptions;
use wavecascade::observer::Silent;
use wavecascade::report::RunFile;

fn known() -> Value {
    serde_json::from_str(&fs::read_to_string("tests/data/drives.json").unwrap()).unwrap()
}

fn run(text: &str) -> Run {
    let setup = SceneSource::new(None, text).setup().unwrap();
    setup.simulation.run(&Silent).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().unwrap().iter();
    values.map(|value| value.as_f64().unwrap()).collect()
}

#[test]
fn val_scipy_driven_chains() {
    let known = known();
    for (name, case) in known["cases"].as_object().unwrap() {
        let run = run(case["scene"].as_str().unwrap());
        let last = run.time.len() - 1;
        let row = run.velocity.row(last);
        let off = row.iter().zip(numbers(&case["velocity"]));
        let off = off.fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
        let work = run.energy_input.as_ref().unwrap()[last];
        let work_off = (work / case["work"].as_f64().unwrap() - 1.0).abs();
        let (scale, drift) = (run.report.velocity_scale, run.report.energy_drift.unwrap());
        println!(
            "{name}: {:.1e} work {work_off:.1e} drift {drift:.1e}",
            off / scale
        );
        // DOP853 steps over openings.
        let most = if name.ends_with("open chain") {
            2e-11
        } else {
            5e-13
        };
        assert!(off < most * scale, "{name}: {:e}", off / scale);
        assert!(work_off < 2e-12, "{name}: {work_off:e}");
        assert!(drift < 2e-14, "{name}: {drift:e}");
    }
}

#[test]
fn val_scipy_splines() {
    let known = known();
    let spline = Waveform::through(&numbers(&known["times"]), &numbers(&known["values"])).unwrap();
    let at = numbers(&known["at"]);
    for (order, most) in [(0, 1e-15), (1, 3e-15), (2, 2e-14)] {
        let of = [Waveform::at, Waveform::rate_at, Waveform::acceleration_at][order];
        let pairs = at.iter().zip(numbers(&known["spline"][order]));
        let off = pairs.fold(0.0f64, |m, (t, b)| m.max((of(&spline, *t) - b).abs()));
        println!("{order}: {off:e}");
        assert!(off < most, "{order}: {off:e}");
    }
}

/// Frequencies that rise, fall to 0, begin at 0 and hardly change; truth by mpmath, quadrature with 30 digits.
#[test]
fn val_mpmath_integrals_of_chirps() {
    for (band, duration, t, known) in [
        ([0.05, 0.25], 20.0, 7.3, 3.381_317_945_332_666),
        ([0.05, 0.25], 20.0, 20.0, 1.802_567_000_933_275_7),
        ([40.0, 0.0], 10.0, 3.7, 0.008_578_450_742_948_539),
        ([40.0, 0.0], 10.0, 10.0, -0.172_797_823_609_067_37),
        ([2.0, 2.001], 30.0, 29.5, 0.000_369_155_614_121_474_7),
        ([0.0, 3.0], 5.0, 4.1, 0.393_860_006_913_487_8),
    ] {
        let integral = Waveform::chirp(1.0, band, duration).integral().unwrap();
        let off = integral.at(t) - known;
        assert!(off.abs() < 2e-15, "{band:?} at {t}: off by {off:e}");
        assert_eq!(integral.at(0.0), 0.0);
        assert_eq!(integral.at(duration + 1.0), integral.at(duration));
    }
}

/// Schemes of fixed steps push bodies, too, at their orders.
#[test]
fn val_convergence_of_fixed_steps_with_a_pushed_body() {
    let scene = |how: &str| {
        format!(
            "sites = 12\nsamples = 2\nlaw = \"spring\"\nalpha = 0.25\nends = \"fixed\"\nend_time = 12.0\n\
             drive = \"force\"\ndrive_site = 4\ndrive_amplitude = 0.2\ndrive_frequency = 0.08\n{how}\n"
        )
    };
    let truth = run(&scene("tolerance = 1e-11"));
    let off = |how: &str| {
        let run = run(&scene(how));
        let pairs = run.velocity.row(1).into_iter().zip(truth.velocity.row(1));
        let off = pairs.fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
        let work = run.energy_input.unwrap()[1] - truth.energy_input.as_ref().unwrap()[1];
        [off, work.abs()]
    };
    for (scheme, order) in [("velocity-verlet", 2.0), ("runge-kutta", 8.0)] {
        let at = |step: f64| off(&format!("scheme = \"{scheme}\"\nstep = {step}"));
        let (coarse, fine) = (at(0.4), at(0.2));
        let slopes = [0, 1].map(|i| (coarse[i] / fine[i]).log2());
        println!("{scheme}: {coarse:?} {fine:?} {slopes:?}");
        assert!((slopes[0] - order).abs() < 0.7, "{scheme}: {slopes:?}");
        assert!(slopes[1] > order - 1.0, "{scheme}: {slopes:?}");
    }
}

/// A ring knows no first body: one moved in the middle and one at the end do the same.
#[test]
fn val_identity_moved_bodies_of_a_ring() {
    let of = |site: usize| {
        run(&format!(
            "sites = 8\nsamples = 5\nends = \"periodic\"\nlaw = \"spring\"\nalpha = 0.25\nend_time = 9.0\n\
             drive = \"displacement\"\ndrive_site = {site}\ndrive_amplitude = 0.2\ndrive_frequency = 0.1\n"
        ))
    };
    let middle = of(3);
    for site in [0, 7] {
        let end = of(site);
        let off = end.velocity.indexed_iter().fold(0.0f64, |m, ((i, j), v)| {
            m.max((v - middle.velocity[[i, (j + 11 - site) % 8]]).abs())
        });
        assert!(off < 1e-11, "{site}: {off:e}");
    }
}

/// Noise has the power stated, in its band alone.
#[test]
fn val_definition_noise() {
    let noise = Waveform::noise(0.3, [0.1, 0.2], 3, f64::INFINITY);
    let (dt, n) = (0.5, 1 << 17);
    let values: Vec<f64> = (0..n).map(|i| noise.at(dt * f64::from(i))).collect();
    let square = values.iter().map(|v| v * v).sum::<f64>() / f64::from(n);
    assert!((square / 0.09 - 1.0).abs() < 2e-3, "{square}");
    // Sums over the band of the squares of Fourier coefficients at multiples of 1 / (n dt).
    let outside: f64 = [0.05, 0.08, 0.22, 0.4]
        .iter()
        .map(|f| {
            let angle = |i: usize| 2.0 * std::f64::consts::PI * f * dt * i as f64;
            let each = values.iter().enumerate();
            let (c, s) = each.fold((0.0, 0.0), |(c, s), (i, v)| {
                (c + v * angle(i).cos(), s + v * angle(i).sin())
            });
            (c * c + s * s).sqrt() / f64::from(n)
        })
        .fold(0.0, f64::max);
    assert!(outside < 2e-4, "{outside:e}");
}

const TABLE: &str = "# recorded\nzeit\ntime [ms], force [kN]\n";

fn rows() -> String {
    let rows = (0..40).map(|i| {
        let t = f64::from(i);
        format!("{t}, {}\n", 0.01 * (0.2 * t).sin().powi(2))
    });
    rows.collect()
}

/// A run file carries the waveform: it gives the same run, without the table.
#[test]
fn regress_a_run_carries_the_table_of_its_drive() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("force.csv");
    fs::write(&table, TABLE.replace("zeit\n", "") + &rows()).unwrap();
    let scene = folder.path().join("scene.toml");
    let text = "sites = 6\nunits = \"si\"\ncoefficient_cell = [1e9]\nmasses = [1e-2, 1e-2, 1e-2, 1e-2, 1e-2, 1e-2]\n\
                samples = 50\nend_time = \"50 ms\"\ndrive = \"force\"\ndrive_site = 2\ndrive_file = \"force.csv\"\n";
    fs::write(&scene, text).unwrap();
    let setup = SceneSource::read(&scene).unwrap().setup().unwrap();
    assert_eq!(
        setup.description().drive.unwrap(),
        "force on site 2, 40 values from 0 to 0.039 s"
    );
    let found = setup.simulation.run(&Silent).unwrap();
    let force = setup.simulation.drive.as_ref().unwrap().waveform();
    assert!((force.at(5e-3) - 10.0 * 1f64.sin().powi(2)).abs() < 1e-9);
    assert_eq!(force.at(0.04), 0.0);
    fs::remove_file(&table).unwrap();
    for name in ["run.npz", "run.nc"] {
        let path = folder.path().join(name);
        RunFile::write(&path, false, &setup, &found, &Silent).unwrap();
        let file = RunFile::read(&path).unwrap();
        let again = file.setup.simulation.run(&Silent).unwrap();
        assert_eq!(again.velocity, found.velocity, "{name}");
        assert_eq!(file.run.drive, found.drive, "{name}");
        // Read as a plain field, too, it says which body is driven.
        let field = Field::open(&path, &OpenOptions::default()).unwrap();
        assert_eq!(field.struck, Some(2), "{name}");
    }
    let gone = SceneSource::read(&scene).unwrap().setup().unwrap_err();
    assert!(gone.to_string().contains("found nothing in"), "{gone}");
}

/// The force under the sphere of the published experiment, written to a table of microseconds and newtons, drives the cylinders
/// without the sphere as the blow did.
#[test]
fn val_identity_a_recorded_force_replays_the_blow() {
    let text = fs::read_to_string("examples/scenes/quartz_experiment.toml").unwrap();
    let struck = run(&text);
    let force = struck.force.as_ref().unwrap();
    let rows = struck.time.iter().zip(force.column(0));
    let rows: String = rows
        .map(|(t, f)| format!("{:e}, {f:e}\n", 1e6 * t))
        .collect();
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("force.csv"),
        format!("time [us], force [N]\n{rows}"),
    )
    .unwrap();
    // Without the sphere contacts count from the holder's on.
    let is_kept = |line: &&str| {
        !["#", "sites", "angle", "second_angle", "striker"]
            .iter()
            .any(|key| line.starts_with(key))
    };
    let kept: Vec<&str> = text.lines().filter(is_kept).collect();
    let scene = folder.path().join("replay.toml");
    let drive = "sites = 40\nangle = \"90 deg\"\nsecond_angle = \"8 deg\"\ndrive = \"force\"\ndrive_file = \"force.csv\"\n";
    fs::write(&scene, format!("{drive}{}", kept.join("\n"))).unwrap();
    let replayed = SceneSource::read(&scene).unwrap().setup().unwrap();
    let replayed = replayed.simulation.run(&Silent).unwrap();
    let most = struck.velocity.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let pairs = replayed.velocity.indexed_iter();
    let off = pairs.fold(0.0f64, |m, ((n, j), v)| {
        m.max((v - struck.velocity[[n, j + 1]]).abs())
    });
    assert!(off < 5e-5 * most, "{:e}", off / most);
    let sensor =
        [&struck, &replayed].map(|run| run.peak_force(run.chain.n_contacts() - 1).unwrap().value);
    assert!((sensor[0] / sensor[1] - 1.0).abs() < 1e-6, "{sensor:?}");
}
