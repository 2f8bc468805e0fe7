//! What drives a chain, against DOP853 and splines of SciPy (`tests/data/make_drives.py`, `make_resonators.py`).

use std::f64::consts::TAU;
use std::fs;

use num_complex::Complex;
use test_support::place::Place;
use test_support::scenes::{apart, data, largest, numbers, run};
use wavecascade::Field;
use wavecascade::chain::Waveform;
use wavecascade::chain::scene::SceneSource;
use wavecascade::field::OpenOptions;
use wavecascade::observer::Silent;
use wavecascade::report::RunFile;

/// Chains that are driven, and chains of resonators: states at the end, work and losses.
#[test]
fn val_scipy_driven_chains() {
    let (driven, resonators) = (data("drives.json"), data("resonators.json"));
    let cases = [&driven["cases"], &resonators].map(|cases| cases.as_object().unwrap());
    for (name, case) in cases.into_iter().flatten() {
        let run = run(case["scene"].as_str().unwrap());
        let (end, scale) = (run.time.len() - 1, run.report.velocity_scale);
        // DOP853 steps over openings.
        let most = if name.contains("open chain") {
            2e-11
        } else {
            5e-13
        };
        for (key, array) in [
            ("displacement", &run.displacement),
            ("velocity", &Some(run.velocity.clone())),
            ("resonator_displacement", &run.resonator_displacement),
            ("resonator_velocity", &run.resonator_velocity),
        ] {
            let Some(known) = case.get(key) else { continue };
            let off = apart(array.as_ref().unwrap().row(end), numbers(known)) / scale;
            assert!(off < most, "{name}, {key}: {off:e}");
        }
        let work = run.energy_input.as_ref().map_or(0.0, |input| input[end]);
        let lost = run
            .energy_lost
            .as_ref()
            .map_or(0.0, |lost| lost.row(end).sum());
        for (key, found) in [("work", work), ("lost", lost)] {
            let known = case.get(key).map_or(found, |known| known.as_f64().unwrap());
            let off = (found - known).abs() / known.abs().max(0.5 * scale * scale);
            assert!(off < 2e-12, "{name}, {key}: {off:e}");
        }
        let (drift, stated) = (run.report.energy_drift, run.report.error);
        let good = drift < Some(3e-14) && stated < Some(1e-11);
        assert!(good, "{name}: {drift:?} {stated:?}");
    }
}

#[test]
fn val_scipy_splines() {
    let known = data("drives.json");
    let spline = Waveform::through(&numbers(&known["times"]), &numbers(&known["values"])).unwrap();
    for (order, most) in [(0, 1e-15), (1, 3e-15), (2, 2e-14)] {
        let of = [Waveform::at, Waveform::rate_at, Waveform::acceleration_at][order];
        let found = numbers(&known["at"]).into_iter().map(|t| of(&spline, t));
        let off = apart(found, numbers(&known["spline"][order]));
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

/// A ring knows no first body: one moved in the middle and one at the end do the same.
#[test]
fn val_identity_moved_bodies_of_a_ring() {
    let of = |site: usize| {
        run(&format!(
            "sites = 8\nsamples = 5\nends = \"periodic\"\nlaw = \"spring\"\nalpha = 0.25\nend_time = 9.0\n\
             drive = \"displacement\"\ndrive_site = {site}\ndrive_amplitude = 0.2\ndrive_frequency = 0.1\n"
        ))
        .velocity
    };
    let middle = of(3);
    for site in [0, 7] {
        let turned = ndarray::indices((5, 8))
            .into_iter()
            .map(|(i, j)| middle[[i, (j + 11 - site) % 8]]);
        let off = apart(of(site), turned);
        assert!(off < 1e-11, "{site}: {off:e}");
    }
}

/// Noise has the power stated, in its band alone.
#[test]
fn val_definition_noise() {
    let noise = Waveform::noise(0.3, [0.1, 0.2], 3, f64::INFINITY);
    let (dt, n) = (0.5, 1 << 17);
    let values = Vec::from_iter((0..n).map(|i| noise.at(dt * f64::from(i))));
    let square = values.iter().map(|v| v * v).sum::<f64>() / f64::from(n);
    assert!((square / 0.09 - 1.0).abs() < 2e-3, "{square}");
    // Fourier coefficients outside of the band, at multiples of 1 / (n dt).
    let outside = [0.05, 0.08, 0.22, 0.4].map(|f| {
        let terms = values.iter().enumerate();
        let terms = terms.map(|(i, v)| Complex::from_polar(*v, TAU * f * dt * i as f64));
        terms.sum::<Complex<f64>>().norm() / f64::from(n)
    });
    assert!(largest(outside) < 2e-4, "{outside:?}");
}

/// A run file carries the waveform: it gives the same run, without the table.
#[test]
fn regress_a_run_carries_the_table_of_its_drive() {
    let place = Place::new();
    let rows = (0..40).map(|i| format!("{i}, {}\n", 0.01 * (0.2 * f64::from(i)).sin().powi(2)));
    let rows: String = rows.collect();
    place.write(
        "force.csv",
        format!("# recorded\ntime [ms], force [kN]\n{rows}"),
    );
    let text = "sites = 6\nunits = \"si\"\ncoefficient_cell = [1e9]\nmasses = [1e-2, 1e-2, 1e-2, 1e-2, 1e-2, 1e-2]\n\
                samples = 50\nend_time = \"50 ms\"\ndrive = \"force\"\ndrive_site = 2\ndrive_file = \"force.csv\"\n";
    place.write("scene.toml", text);
    let read = || {
        SceneSource::read(&place.path("scene.toml"))
            .unwrap()
            .setup()
    };
    let setup = read().unwrap();
    let said = setup.description().drive.unwrap();
    assert_eq!(said, "force on site 2, 40 values from 0 to 0.039 s");
    let found = setup.simulation.run(&Silent).unwrap();
    let force = setup.simulation.drive.as_ref().unwrap().waveform();
    assert!((force.at(5e-3) - 10.0 * 1f64.sin().powi(2)).abs() < 1e-9);
    assert_eq!(force.at(0.04), 0.0);
    fs::remove_file(place.path("force.csv")).unwrap();
    for name in ["run.npz", "run.nc"] {
        let path = place.path(name);
        RunFile::write(&path, false, &setup, &found, &Silent).unwrap();
        let file = RunFile::read(&path).unwrap();
        let again = file.setup.simulation.run(&Silent).unwrap();
        assert_eq!(again.velocity, found.velocity, "{name}");
        assert_eq!(file.run.drive, found.drive, "{name}");
        // Read as a plain field, too, it says which body is driven.
        let field = Field::open(&path, &OpenOptions::default()).unwrap();
        assert_eq!(field.struck, Some(2), "{name}");
    }
    let gone = read().unwrap_err();
    assert!(gone.to_string().contains("found nothing in"), "{gone}");
}

/// The force under the sphere of the published experiment, written to a table of microseconds and newtons, drives the cylinders
/// without the sphere as the blow did.
#[test]
fn val_identity_a_recorded_force_replays_the_blow() {
    let text = fs::read_to_string("examples/scenes/quartz_experiment.toml").unwrap();
    let struck = run(&text);
    let rows = struck
        .time
        .iter()
        .zip(struck.force.as_ref().unwrap().column(0));
    let rows: String = rows
        .map(|(t, f)| format!("{:e}, {f:e}\n", 1e6 * t))
        .collect();
    let place = Place::new();
    place.write("force.csv", format!("time [us], force [N]\n{rows}"));
    // Without the sphere contacts count from the holder's on.
    let of_sphere = ["#", "sites", "angle", "second_angle", "striker"];
    let is_kept = |line: &&str| !of_sphere.iter().any(|key| line.starts_with(key));
    let kept: Vec<&str> = text.lines().filter(is_kept).collect();
    let drive = "sites = 40\nangle = \"90 deg\"\nsecond_angle = \"8 deg\"\ndrive = \"force\"\ndrive_file = \"force.csv\"\n";
    place.write("replay.toml", format!("{drive}{}", kept.join("\n")));
    let replayed = SceneSource::read(&place.path("replay.toml")).unwrap();
    let replayed = replayed.setup().unwrap();
    let replayed = replayed.simulation.run(&Silent).unwrap();
    let most = largest(&struck.velocity);
    let off = apart(
        &replayed.velocity,
        struck.velocity.slice(ndarray::s![.., 1..]),
    );
    assert!(off < 5e-5 * most, "{:e}", off / most);
    let sensor =
        [&struck, &replayed].map(|run| run.peak_force(run.chain.n_contacts() - 1).unwrap().value);
    assert!((sensor[0] / sensor[1] - 1.0).abs() < 1e-6, "{sensor:?}");
}
