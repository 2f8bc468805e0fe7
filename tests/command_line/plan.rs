//! `cascade plan` as a stranger runs it.

use test_support::place::Place;

const SCENE: &str = "sites = 8\nstiffness_ratio = 2.0\nstriker_velocity = 1.0\ntangent = 0.02\n\
                     end_time = 12.0\nsamples = 200\n";

#[test]
fn regress_a_measurement_is_planned() {
    let place = Place::new();
    std::fs::write(place.path("scene.toml"), SCENE).unwrap();
    let plan = "plan scene.toml --free stiffness_ratio,tangent --sensors 2 --noise 2%";
    let said = place.says(&format!("{plan} --figures png"));
    assert!(said.starts_with("scene.toml: bodies "), "{said}");
    assert!(
        said.contains("evenly spaced") && said.lines().count() <= 14,
        "{said}"
    );
    let summary = place.json("scene-plan/summary.json");
    assert_eq!(summary["schema"], "cascade.plan/1");
    assert_eq!(summary["bodies"].as_array().unwrap().len(), 2);
    for name in ["report.html", "plan.npz", "figures/plan.png"] {
        assert!(place.path(format!("scene-plan/{name}")).exists(), "{name}");
    }
    place.says(&format!(
        "{plan} --criterion worst --quantity force --free-gains --force -q"
    ));
    for (line, named) in [
        (
            "plan scene.toml --free tangent --sensors 9 --force",
            "1 to 8",
        ),
        (
            "plan scene.toml --free tangent --sensors 2 --noise 2mm/s --force",
            "no unit",
        ),
        (
            "plan scene.toml --free tangent --sensors 2 --noise none --force",
            "as 2%",
        ),
        (
            "plan scene.toml --free tangent --sensors 2 --rate 0 --force",
            "a rate",
        ),
    ] {
        let said = place.refuses(2, line);
        assert!(said.contains(named), "{line}: {said}");
    }
}
