//! Chains designed for a measure of their run.

use test_support::changed;
use test_support::scenes::{near, simulation, within};
use wavecascade::chain::scene::SceneSource;
use wavecascade::design::{Aim, DesignRequest, Designed, Limit};
use wavecascade::observer::Silent;
use wavecascade::sheet::Describe;

/// The least force at the last contact, of so many tries, with these keys free.
fn least(
    text: &str,
    free: &str,
    tries: usize,
    change: impl FnOnce(&mut DesignRequest),
) -> Designed {
    let request = DesignRequest {
        tries: Some(tries),
        ..DesignRequest::least(Aim::PeakForceLast, free.split(' '))
    };
    let scene = SceneSource::new(None, text);
    changed(request, change).run(&scene, &Silent).unwrap()
}

fn uniform(sites: usize) -> String {
    let ones = vec!["1.0"; sites].join(", ");
    format!("sites = {sites}\ncoefficients = [{ones}]\nend_time = 40.0\nsamples = 512\n")
}

/// Least transmission of quartz cylinders against the angle: 16.27 degrees, of the homogeneous chain's force 0.4653.
#[test]
fn val_published_angle_of_least_transmission() {
    let text = std::fs::read_to_string("examples/scenes/quartz_experiment.toml").unwrap();
    let designed = least(&text, "angle=8..30", 0, |it| it.tries = None);
    let crossed = text.replace("angle = \"8 deg\"", "angle = \"90 deg\"");
    let homogeneous = least(&crossed, "angle=89.9999..90", 10, |_| {});
    let angle = designed.after.values[0];
    let share = designed.after.measure.unwrap() / homogeneous.before.measure.unwrap();
    assert!((angle - 16.27).abs() < 0.01, "{angle}");
    assert!((share - 0.4653).abs() < 3e-4, "{share}");
}

/// One body on a linear wall: `F = v sqrt(k m)`, so that the largest force under a limit of the mass has all of it.
#[test]
fn val_closed_form_a_limit_is_kept_and_used() {
    let text = "sites = 1\nlaw = \"one-sided d\"\nmasses = [1.0]\ncoefficients = [1.0]\nend_time = 12.0\nsamples = 512\n";
    let designed = least(
        text,
        "masses[0]=0.5..4 coefficients[0]=0.5..1.5",
        1000,
        |it| {
            it.is_most = true;
            it.limits = vec![Limit::parse("total_mass=2.5").unwrap()];
        },
    );
    let force = (2.5f64 * 1.5).sqrt();
    let measure = designed.after.measure.unwrap();
    assert!(designed.after.values[0] <= 2.5 && designed.beyond > 0);
    within(measure / force, 0.99..=1.0 + 1e-9, &designed);
}

/// Values of a list are taken, descents beat random tries, and no thread changes a bit.
#[test]
fn regress_search_beats_random_tries_for_any_threads() {
    let of = |free: &str| least(&uniform(12), free, 400, |_| {});
    let free = "coefficients[]=0.2..5";
    let designed = of(free);
    let [search, random] = [&designed.search, &designed.random].map(|of| *of.last().unwrap());
    assert!(!designed.is_random);
    within(search / random, ..0.95, random);
    let answer = designed.describe().answer;
    assert!(answer.contains("less"), "{answer}");
    let one = rayon::ThreadPoolBuilder::new().num_threads(1);
    assert_eq!(one.build().unwrap().install(|| of(free)), designed);
    let again = simulation(&designed.scene);
    assert_eq!(again.chain.coefficient, designed.after.values);

    let listed = of("coefficients[]=0.5|1|4");
    for value in &listed.after.values {
        assert!([0.5, 1.0, 4.0].contains(value), "{value}");
    }
    assert!(listed.judged[1] < listed.judged[0]);
}

/// With tolerances the worst design within counts, and it is no better than the nominal one.
#[test]
fn regress_tolerances_are_judged_by_the_worst() {
    let designed = least(&uniform(8), "coefficients[]=0.2..5", 120, |it| {
        (it.tolerances, it.members) = (vec!["coefficients=10%".into()], 6);
    });
    let worst = designed.after.members.iter().copied().fold(0.0, f64::max);
    let nominal = designed.after.measure.unwrap();
    // A tenth of the coefficients changes forces by percents.
    assert!(worst > 1.001 * nominal, "{worst} {nominal}");
    near(
        designed.judged[1],
        worst.max(nominal),
        1e-6 * worst,
        &designed,
    );
    assert!(designed.judged[1] < designed.judged[0]);
}
