//! Chains designed for a measure of their run.

use wavecascade::chain::scene::SceneSource;
use wavecascade::design::{Aim, DesignRequest, Designed, Limit};
use wavecascade::observer::Silent;
use wavecascade::sheet::Describe;

fn scene(text: &str) -> SceneSource {
    SceneSource::new(None, text)
}

fn found(request: &DesignRequest, text: &str) -> Designed {
    request.run(&scene(text), &Silent).unwrap()
}

fn uniform(sites: usize) -> String {
    let ones = vec!["1.0"; sites].join(", ");
    format!("sites = {sites}\ncoefficients = [{ones}]\nend_time = 40.0\nsamples = 512\n")
}

/// Least transmission of quartz cylinders against the angle: 16.27 degrees, of the homogeneous chain's force 0.4653.
#[test]
fn val_published_angle_of_least_transmission() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/examples/scenes/quartz_experiment.toml"
    );
    let text = std::fs::read_to_string(path).unwrap();
    let request = DesignRequest::least(Aim::PeakForceLast, ["angle=8..30"]);
    let designed = found(&request, &text);
    let homogeneous = found(
        &DesignRequest {
            tries: Some(10),
            ..DesignRequest::least(Aim::PeakForceLast, ["angle=89.9999..90"])
        },
        &text.replace("angle = \"8 deg\"", "angle = \"90 deg\""),
    );
    let angle = designed.after.values[0];
    let share = designed.after.measure.unwrap() / homogeneous.before.measure.unwrap();
    assert!((angle - 16.27).abs() < 0.01, "{angle}");
    assert!((share - 0.4653).abs() < 3e-4, "{share}");
}

/// One body on a linear wall: `F = v sqrt(k m)`, so that the largest force under a limit of the mass has all of it.
#[test]
fn val_closed_form_a_limit_is_kept_and_used() {
    let text = "sites = 1\nlaw = \"one-sided d\"\nmasses = [1.0]\ncoefficients = [1.0]\nend_time = 12.0\nsamples = 512\n";
    let request = DesignRequest {
        is_most: true,
        limits: vec![Limit::parse("total_mass=2.5").unwrap()],
        tries: Some(1000),
        ..DesignRequest::least(
            Aim::PeakForceLast,
            ["masses[0]=0.5..4", "coefficients[0]=0.5..1.5"],
        )
    };
    let designed = found(&request, text);
    let force = (2.5f64 * 1.5).sqrt();
    let measure = designed.after.measure.unwrap();
    assert!(designed.after.values[0] <= 2.5, "{designed:?}");
    assert!(designed.beyond > 0, "{designed:?}");
    assert!((measure / force - 1.0).abs() < 0.01, "{measure} {force}");
    assert!(measure <= force * (1.0 + 1e-9), "{measure} {force}");
}

/// Values of a list are taken, descents beat random tries, and no thread changes a bit.
#[test]
fn regress_search_beats_random_tries_for_any_threads() {
    let request = DesignRequest {
        tries: Some(400),
        ..DesignRequest::least(Aim::PeakForceLast, ["coefficients[]=0.2..5"])
    };
    let designed = found(&request, &uniform(12));
    let [search, random] = [&designed.search, &designed.random].map(|of| *of.last().unwrap());
    assert!(!designed.is_random, "{search} {random}");
    assert!(search < 0.95 * random, "{search} {random}");
    let answer = designed.describe().answer;
    assert!(answer.contains("less"), "{answer}");
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(one.install(|| found(&request, &uniform(12))), designed);
    let again = scene(&designed.scene).setup().unwrap().simulation;
    assert_eq!(again.chain.coefficient, designed.after.values);

    let listed = DesignRequest {
        free: vec!["coefficients[]=0.5|1|4".into()],
        ..request
    };
    let designed = found(&listed, &uniform(12));
    for value in &designed.after.values {
        assert!([0.5, 1.0, 4.0].contains(value), "{value}");
    }
    assert!(designed.judged[1] < designed.judged[0]);
}

/// With tolerances the worst design within counts, and it is no better than the nominal one.
#[test]
fn regress_tolerances_are_judged_by_the_worst() {
    let request = DesignRequest {
        tolerances: vec!["coefficients=10%".into()],
        members: 6,
        tries: Some(120),
        ..DesignRequest::least(Aim::PeakForceLast, ["coefficients[]=0.2..5"])
    };
    let designed = found(&request, &uniform(8));
    let worst = designed.after.members.iter().copied().fold(0.0, f64::max);
    let nominal = designed.after.measure.unwrap();
    // A tenth of the coefficients changes forces by percents.
    assert!(worst > 1.001 * nominal, "{worst} {nominal}");
    assert!(
        (designed.judged[1] - worst.max(nominal)).abs() < 1e-6 * worst,
        "{designed:?}"
    );
    assert!(designed.judged[1] < designed.judged[0]);
}
