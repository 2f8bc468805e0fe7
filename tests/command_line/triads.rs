//! `cascade triads` as a stranger runs it.

use ndarray::Array2;
use test_support::place::Place;

const SCENE: &str = "sites = 16\nlaw = \"spring\"\nalpha = 0.25\nends = \"fixed\"\nmode = 1\nmode_amplitude = 1.0\n\
                     end_time = 60.0\nsamples = 512\n";

#[test]
fn regress_triads_of_a_run_and_of_a_field() {
    let place = Place::new();
    std::fs::write(place.path("scene.toml"), SCENE).unwrap();
    place.good(&["simulate", "scene.toml", "--out", "run.npz"]);
    let said = place.good(&["triads", "run.npz", "--figures", "png", "--verbose"]);
    assert!(said.starts_with("run.npz: "), "{said}");
    assert!(said.contains("towards larger wavenumbers"), "{said}");
    assert!(said.contains("the force has no other terms"), "{said}");
    let summary = place.json("run-triads/summary.json");
    assert_eq!(summary["law"]["name"], "chain");
    assert_eq!(summary["largest_flux"]["resolved"], true);
    for name in ["report.html", "triads.npz", "figures/triads.png"] {
        assert!(place.path(format!("run-triads/{name}")).exists());
    }

    let tau = std::f64::consts::TAU;
    let wave = |x: f64| (tau * x).sin() + 0.5 * (2.0 * tau * x).sin();
    let u = Array2::from_shape_fn((5, 32), |(i, j)| wave(j as f64 / 32.0 - 0.01 * i as f64));
    place.save("field.npy", &u);
    let words = [
        "triads",
        "field.npy",
        "--equation",
        "burgers",
        "--dt",
        "0.01",
    ];
    let said = place.good(&[&words[..], &["--figures", "none"]].concat());
    assert!(said.contains("viscosity"), "{said}");
    assert_eq!(
        place.json("field.npy-triads/summary.json")["law"]["name"],
        "burgers"
    );

    let before = place.names();
    for (words, named) in [
        (&["triads", "field.npy"][..], "--equation"),
        (
            &["triads", "run.npz", "--equation", "burgers", "--force"],
            "--equation",
        ),
        (
            &["triads", "run.npz", "--dx", "2", "--force"],
            "no options of fields",
        ),
        (
            &["triads", "run.npz", "--window-samples", "3:4", "--force"],
            "--window-samples",
        ),
    ] {
        let said = place.bad(2, words);
        assert!(said.contains(named), "{said}");
    }
    assert_eq!(place.names(), before);
}
