//! `cascade plan` and `cascade compare FIELD RUN` as a stranger runs them.

use test_support::place::Place;

const SCENE: &str = "sites = 8\nstiffness_ratio = 2.0\nstriker_velocity = 1.0\ntangent = 0.02\n\
                     end_time = 12.0\nsamples = 200\n";

#[test]
fn regress_a_measurement_is_planned() {
    let place = Place::new();
    place.write("scene.toml", SCENE);
    let plan = "plan scene.toml --free stiffness_ratio,tangent --sensors 2 --noise 2%";
    let said = place.says(&format!("{plan} --figures png"));
    assert!(said.starts_with("scene.toml: bodies "), "{said}");
    assert!(said.contains("evenly spaced"), "{said}");
    assert!(said.lines().count() <= 14, "{said}");
    let summary = place.json("scene-plan/summary.json");
    assert_eq!(summary["schema"], "cascade.plan/1");
    assert_eq!(summary["bodies"].as_array().unwrap().len(), 2);
    place.has("scene-plan", "report.html plan.npz figures/plan.png");
    place.says(&format!(
        "{plan} --criterion worst --quantity force --free-gains --force -q"
    ));
}

#[test]
fn regress_a_field_is_compared_with_a_run() {
    let place = Place::new();
    place.write("scene.toml", SCENE);
    place.write("other.toml", SCENE.replace("2.0", "2.1"));
    place.says("simulate scene.toml --out run.npz");
    place.says("simulate other.toml --out other.npz");
    place.says("convert run.npz field.csv");
    let said = place.says("compare field.csv run.npz --out same --figures png");
    assert!(said.contains("agree to the error of runs"), "{said}");
    let said = place.says("compare field.csv other.toml --out parts");
    assert!(
        said.contains("measurement and run differ") && said.lines().count() <= 12,
        "{said}"
    );
    assert_eq!(
        place.json("parts/summary.json")["schema"],
        "cascade.compare-field/1"
    );
    assert!(place.path("parts/compare-field.npz").exists());
    place.says("compare field.csv other.npz --out parts --force -q");
}
