//! `cascade fit` as a stranger runs it.

use test_support::place::Place;
use wavecascade::chain::scene::SceneSource;
use wavecascade::observer::Silent;

const SCENE: &str = "sites = 8\nstiffness_ratio = 2.0\nstriker_velocity = 1.0\ntangent = 0.02\n\
                     end_time = 12.0\nsamples = 200\n";

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
