//! Scenes: what is typed, what it is worked out to, and the forms made from the declaration.

use std::f64::consts::PI;

use test_support::fields::fixed;
use wavecascade::chain::scene::{SceneSource, Setting, Setup, Units, properties, template};
use wavecascade::chain::{Accuracy, EndTime, Ends, Law, Record, Scheme};

fn setup(text: &str) -> Setup {
    SceneSource::new(None, text)
        .setup()
        .unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn setting(key: &str, text: &str) -> Setting {
    Setting {
        key: key.into(),
        text: text.into(),
        source: format!("--{}", key.replace('_', "-")),
    }
}

#[test]
fn the_least_scene_is_the_uniform_chain_struck_at_unit_speed() {
    let setup = setup("sites = 5");
    let s = setup.simulation;
    assert_eq!(s.chain.mass, [1.0; 5]);
    assert_eq!(s.chain.coefficient, [1.0; 5]);
    assert_eq!((s.chain.law, s.chain.ends), (Law::Hertz.into(), Ends::Wall));
    assert_eq!(s.velocity, [1.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(s.accuracy, Accuracy::Tolerance(1e-9));
    assert_eq!(s.scheme, Scheme::Nystrom);
    assert_eq!((s.end_time, s.samples), (EndTime::Arrival, 1024));
    assert_eq!(s.record, Record::ALL);
    assert_eq!((setup.units, setup.pitch), (Units::None, None));
}

#[test]
fn the_template_is_a_scene_and_so_is_every_line_of_it() {
    let template = template();
    assert_eq!(setup(&template).simulation.chain.n_sites(), 300);
    let keys = template.lines().filter(|line| {
        let key = line.trim_start_matches('#').split(" = ").next();
        !line.starts_with("# ") && key.is_some_and(|key| !key.is_empty())
    });
    let mut count = 0;
    for line in keys {
        let line = line.trim_start_matches('#');
        let parsed = SceneSource::new(None, line).scene();
        assert!(parsed.is_ok(), "{line}: {parsed:?}");
        count += 1;
    }
    assert_eq!(count, properties().len());
}

#[test]
fn stated_defaults_are_what_holds_without_them() {
    let base = "sites = 6\nstiffness_ratio = 2.0\nend_time = 4.0";
    let plain = setup(base).simulation;
    let mut tried = 0;
    for property in properties() {
        // What goes with a key that the base lacks is refused without it.
        let lone = [
            "alpha",
            "beta",
            "drive_site",
            "shape",
            "ellipse",
            "seed",
            "end_time",
        ];
        let (Some(default), false) = (&property.default, lone.contains(&property.name.as_str()))
        else {
            continue;
        };
        let text = default.to_string();
        let text = text.trim_matches('"');
        let source = SceneSource::new(None, base).with([setting(&property.name, text)]);
        assert_eq!(
            source.setup().unwrap().simulation,
            plain,
            "{}",
            property.name
        );
        tried += 1;
    }
    assert!(tried >= 15, "{tried}");
}

#[test]
fn settings_hold_over_the_text_and_later_ones_over_earlier_ones() {
    let base = SceneSource::new(None, "sites = 4\nstiffness_ratio = 2.0\nend_time = 1.0");
    let member = base.with([
        setting("stiffness_ratio", "3"),
        setting("stiffness_ratio", "5.5"),
    ]);
    let chain = member.setup().unwrap().simulation.chain;
    assert_eq!(chain.coefficient, [1.0, 5.5, 1.0, 5.5]);
    assert_eq!(base.setup().unwrap().simulation.chain.coefficient[1], 2.0);
    // The text of the member alone describes it.
    let again = SceneSource::new(None, member.setup().unwrap().text);
    assert_eq!(
        again.setup().unwrap().simulation,
        member.setup().unwrap().simulation
    );
}

#[test]
fn settings_are_typed_as_on_a_command_line() {
    let base = SceneSource::new(None, "sites = 4\nend_time = 1.0");
    let of = |key: &str, text: &str| base.with([setting(key, text)]).setup().unwrap().simulation;
    assert_eq!(of("coefficient_cell", "1,4.5").chain.coefficient[1], 4.5);
    assert_eq!(of("coefficient_cell", "[1, 4.5]").chain.coefficient[1], 4.5);
    assert_eq!(of("record", "").record, Record::default());
    assert!(of("record", "force,displacement").record.force);
    assert!(!of("record", "force").record.energy);
    assert!(!of("estimate_error", "false").estimate_error);
    assert_eq!(of("scheme", "runge-kutta").scheme, Scheme::RungeKutta);
    let both = base.with([
        setting("defect", "site=1,factor=2"),
        setting("defect", "{contact=2,value=7}"),
    ]);
    let chain = both.setup().unwrap().simulation.chain;
    assert_eq!((chain.mass[1], chain.coefficient[2]), (2.0, 7.0));
    // The number of a sweep, whatever its field.
    assert_eq!(of("samples", &format!("{}", 30.0)).samples, 30);
}

#[test]
fn val_paper_coefficients_of_the_experiment() {
    let text = r#"
        sites = 41
        material = "quartz"
        radius = "9 mm"
        length = "18 mm"
        angle = 8.0
        second_angle = "90 deg"
        striker_radius = "0.9 cm"
        striker_velocity = 0.88
    "#;
    let setup = setup(text);
    let chain = &setup.simulation.chain;
    // The stiffness ratio that Chaunsali et al. give for 8 and 90 degrees.
    let ratio = chain.coefficient[2] / chain.coefficient[1];
    assert!((ratio - 4.507).abs() < 5e-4, "{ratio}");
    assert_eq!(chain.coefficient[40], chain.coefficient[2]);
    let cylinder = PI * 9e-3 * 9e-3 * 18e-3 * 2200.0;
    let sphere = 4.0 / 3.0 * PI * 9e-3f64.powi(3) * 2200.0;
    assert!((chain.mass[1] / cylinder - 1.0).abs() < 1e-15);
    assert!((chain.mass[0] / sphere - 1.0).abs() < 1e-15);
    assert_eq!(setup.simulation.velocity[0], 0.88);
    assert_eq!((setup.units, setup.pitch), (Units::Si, Some(18e-3)));
    // Two crossed cylinders of radius R at 90 degrees touch like a sphere of radius R on a plane:
    // (4/3) E* sqrt(R) with 1/E* = 2 (1 - nu^2)/Y.
    let modulus = 72e9 / (2.0 * (1.0 - 0.17 * 0.17));
    let crossed = 4.0 / 3.0 * modulus * 9e-3f64.sqrt();
    assert!((chain.coefficient[1] / crossed - 1.0).abs() < 1e-14);
}

#[test]
fn units_are_read_as_they_are_written() {
    let numbers = setup(
        "sites = 3\nyoung = 72e9\npoisson = 0.17\ndensity = 2200\nradius = 0.009\nlength = 0.018\n\
         angle = 90\nstriker_velocity = 0.88\nend_time = 2e-3\nmemory = 1048576",
    );
    let texts = setup(
        "sites = 3\nyoung = '72 GPa'\npoisson = 0.17\ndensity = '2.2 g/cm^3'\nradius = '9mm'\n\
         length = '1.8 cm'\nangle = '90 deg'\nstriker_velocity = '88 cm/s'\nend_time = '2 ms'\n\
         memory = '1 MiB'",
    );
    assert_eq!(numbers.simulation, texts.simulation);
}

#[test]
fn patterns_follow_one_another() {
    let chain = |text: &str| {
        setup(&format!("sites = 5\nend_time = 1.0\n{text}"))
            .simulation
            .chain
    };
    let c = chain("stiffness_ratio = 3.0\nfirst_contact = 'stiff'");
    assert_eq!(c.coefficient, [3.0, 1.0, 3.0, 1.0, 3.0]);
    let c = chain("mass_ratio = 2.0");
    assert_eq!(c.mass, [1.0, 2.0, 1.0, 2.0, 1.0]);
    let c = chain("mass_cell = [1, 2, 3]");
    assert_eq!(c.mass, [1.0, 2.0, 3.0, 1.0, 2.0]);
    let c = chain("mass_taper = 0.0625");
    for (found, expected) in c.mass.iter().zip([1.0, 0.5, 0.25, 0.125, 0.0625]) {
        assert!((found / expected - 1.0f64).abs() < 1e-15, "{:?}", c.mass);
    }
    let c = chain("striker_mass = 4.0\nstriker_coefficient = 5.0\nwall_coefficient = 6.0");
    assert_eq!(c.mass, [4.0, 1.0, 1.0, 1.0, 1.0]);
    assert_eq!(c.coefficient, [5.0, 1.0, 1.0, 1.0, 6.0]);
    let c = chain("ends = 'fixed'\nstiffness_ratio = 3.0");
    assert_eq!(c.ends, fixed(3.0));
    let c = chain("[[defect]]\nsite = 4\nvalue = 9.0\n[[defect]]\nsite = 4\nfactor = 0.5");
    assert_eq!(c.mass[4], 4.5);
    let random = chain("mass_spread = 0.1\ncoefficient_spread = 0.1\nseed = 7");
    let again = chain("mass_spread = 0.1\ncoefficient_spread = 0.1\nseed = 7");
    let other = chain("mass_spread = 0.1\ncoefficient_spread = 0.1\nseed = 8");
    assert_eq!(random, again);
    assert!(random.mass != other.mass && random.mass != random.coefficient);
    assert!(random.mass.iter().all(|m| (0.9..1.1).contains(m)));
}
