//! `cascade fit` as a stranger runs it.

use test_support::place::Place;
use wavecascade::chain::scene::SceneSource;
use wavecascade::observer::Silent;

const SCENE: &str = "sites = 8\nstiffness_ratio = 2.0\nstriker_velocity = 1.0\ntangent = 0.02\n\
                     end_time = 12.0\nsamples = 200\n";

#[test]
fn regress_a_run_is_fitted() {
    let place = Place::new();
    place.write("scene.toml", SCENE);
    place.says("simulate scene.toml --out run.npz");
    place.write(
        "start.toml",
        SCENE.replace("2.0", "1.9").replace("0.02", "0.01"),
    );
    let said = place.says("fit run.npz start.toml --free stiffness_ratio=1..3,tangent=0..0.1 --starts 2 --figures png");
    assert!(
        said.starts_with("run.npz: the model explains all"),
        "{said}"
    );
    assert!(said.lines().count() <= 12, "{said}");
    let summary = place.json("run.npz-fit/summary.json");
    let value = summary["values"][0]["value"].as_f64().unwrap();
    assert!((value - 2.0).abs() < 1e-6, "{value}");
    for name in ["report.html", "fit.npz", "fitted.toml", "figures/fit.png"] {
        assert!(place.path(format!("run.npz-fit/{name}")).exists(), "{name}");
    }
    place.says("simulate run.npz-fit/fitted.toml --out again.npz");
}

/// Columns are of the bodies that they name, and the scene beside them of the same name is no sidecar.
#[test]
fn regress_names_of_columns_are_bodies() {
    let place = Place::new();
    place.write("a.toml", SCENE);
    let run = SceneSource::new(None, SCENE)
        .setup()
        .unwrap()
        .simulation
        .run(&Silent)
        .unwrap();
    let mut text = "time,body 4,body 7\n".to_owned();
    for (i, time) in run.time.iter().enumerate() {
        text += &format!("{time},{},{}\n", run.velocity[[i, 4]], run.velocity[[i, 7]]);
    }
    place.write("a.csv", text);
    let said = place.says("fit a.csv a.toml --free stiffness_ratio=1..3 --starts 1 --figures none");
    assert!(said.starts_with("a.csv: the model explains all"), "{said}");
}
