//! `cascade triads` as a stranger runs it.

use ndarray::Array2;
use test_support::place::Place;

const SCENE: &str = "sites = 16\nlaw = \"spring\"\nalpha = 0.25\nends = \"fixed\"\nmode = 1\nmode_amplitude = 1.0\n\
                     end_time = 60.0\nsamples = 512\n";

#[test]
fn regress_triads_of_a_run() {
    let place = Place::new();
    place.write("scene.toml", SCENE);
    place.says("simulate scene.toml --out run.npz");
    let said = place.says("triads run.npz --figures png");
    assert!(said.starts_with("run.npz: "), "{said}");
    assert!(said.contains("towards larger wavenumbers"), "{said}");
    let summary = place.json("run-triads/summary.json");
    assert_eq!(summary["law"]["quadratic"], -0.25);
    assert_eq!(summary["largest_flux"]["resolved"], true);
    place.has("run-triads", "report.html triads.npz figures/triads.png");
    place.says("simulate --sites 8 --end-time 4 --samples 32 --out touch.npz");
    place.save("field.npy", &Array2::from_elem((5, 32), 1.0));
    for (line, named) in [
        ("triads field.npy", "cascade simulate"),
        ("triads run.npz --dx 2 --force", "--dx"),
        (
            "triads touch.npz",
            "touch.npz: expected contacts with a quadratic term",
        ),
    ] {
        place.refuses_for(2, line, named);
    }
}
