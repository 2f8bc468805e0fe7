//! Scenes: what is typed, what it is worked out to, and the forms made from the declaration.

use std::f64::consts::PI;

use test_support::scenes::{apart, parsed, rows, setup, simulation, sized};
use wavecascade::chain::scene::{SceneSource, Setting, Units, properties, template};
use wavecascade::chain::{Accuracy, EndTime, Ends, Law, Record, Scheme, Simulation};

/// A scene of four bodies with settings over it.
fn with(settings: &[(&str, &str)]) -> SceneSource {
    let base = SceneSource::new(None, "sites = 4\nstiffness_ratio = 2.0\nend_time = 1.0");
    base.with(
        settings
            .iter()
            .map(|(key, text)| Setting::new(key, *text, "here")),
    )
}

fn simulated(settings: &[(&str, &str)]) -> Simulation {
    with(settings).setup().unwrap().simulation
}

#[test]
fn the_least_scene_is_the_uniform_chain_struck_at_unit_speed() {
    let setup = setup("sites = 5");
    let s = setup.simulation;
    assert_eq!(
        (s.chain.mass, s.chain.coefficient),
        (vec![1.0; 5], vec![1.0; 5])
    );
    assert_eq!((s.chain.law, s.chain.ends), (Law::Hertz.into(), Ends::Wall));
    assert_eq!(s.velocity, [1.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(
        (s.accuracy, s.scheme),
        (Accuracy::Tolerance(1e-9), Scheme::Nystrom)
    );
    assert_eq!((s.end_time, s.samples), (EndTime::Arrival, 1024));
    assert_eq!(s.record, Record::ALL);
    assert_eq!((setup.units, setup.pitch), (Units::None, None));
}

#[test]
fn the_template_is_a_scene_and_so_is_every_line_of_it() {
    let template = template();
    assert_eq!(simulation(&template).chain.n_sites(), 300);
    let lines = template.lines().filter(|line| !line.starts_with("# "));
    let lines = lines.map(|line| line.trim_start_matches('#'));
    let keys: Vec<&str> = lines.filter(|line| !line.is_empty()).collect();
    for line in &keys {
        let parsed = SceneSource::new(None, *line).scene();
        assert!(parsed.is_ok(), "{line}: {parsed:?}");
    }
    assert_eq!(keys.len(), properties().len());
}

#[test]
fn stated_defaults_are_what_holds_without_them() {
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
    let mut tried = 0;
    for property in properties() {
        let (name, default) = (property.name.as_str(), &property.default);
        let Some(default) = default.as_ref().filter(|_| !lone.contains(&name)) else {
            continue;
        };
        let typed = default.to_string();
        let found = simulated(&[(name, typed.trim_matches('"'))]);
        assert_eq!(found, simulated(&[]), "{name}");
        tried += 1;
    }
    assert!(tried >= 15, "{tried}");
}

#[test]
fn settings_hold_over_the_text_and_later_ones_over_earlier_ones() {
    let member = with(&[("stiffness_ratio", "3"), ("stiffness_ratio", "5.5")]);
    let member = member.setup().unwrap();
    assert_eq!(member.simulation.chain.coefficient, [1.0, 5.5, 1.0, 5.5]);
    assert_eq!(simulated(&[]).chain.coefficient[1], 2.0);
    // The text of the member alone describes it.
    assert_eq!(simulation(&member.text), member.simulation);
}

#[test]
fn settings_are_typed_as_on_a_command_line() {
    for typed in ["1,4.5", "[1, 4.5]"] {
        assert_eq!(simulated(&[("mass_cell", typed)]).chain.mass[1], 4.5);
    }
    let one = |key, typed| simulated(&[(key, typed)]);
    assert_eq!(one("record", "").record, Record::default());
    assert!(one("record", "force,displacement").record.force);
    assert!(!one("record", "force").record.energy);
    assert!(!one("estimate_error", "false").estimate_error);
    assert_eq!(one("scheme", "runge-kutta").scheme, Scheme::RungeKutta);
    // The number of a sweep, whatever its field.
    assert_eq!(one("samples", &format!("{}", 30.0)).samples, 30);
    let chain = simulated(&[
        ("defect", "site=1,factor=2"),
        ("defect", "{contact=2,value=7}"),
    ])
    .chain;
    assert_eq!((chain.mass[1], chain.coefficient[2]), (2.0, 7.0));
}

#[test]
fn val_paper_coefficients_of_the_experiment() {
    let setup = setup(
        "sites = 41\nmaterial = 'quartz'\nradius = '9 mm'\nlength = '18 mm'\nangle = 8.0\nsecond_angle = '90 deg'\n\
         striker_radius = '0.9 cm'\nstriker_velocity = 0.88",
    );
    let chain = &setup.simulation.chain;
    // The stiffness ratio that Chaunsali et al. give for 8 and 90 degrees.
    let ratio = chain.coefficient[2] / chain.coefficient[1];
    assert!((ratio - 4.507).abs() < 5e-4, "{ratio}");
    assert_eq!(chain.coefficient[40], chain.coefficient[2]);
    let cylinder = PI * 9e-3 * 9e-3 * 18e-3 * 2200.0;
    let sphere = 4.0 / 3.0 * PI * 9e-3f64.powi(3) * 2200.0;
    // Two crossed cylinders of radius R at 90 degrees touch like a sphere of radius R on a plane:
    // (4/3) E* sqrt(R) with 1/E* = 2 (1 - nu^2)/Y.
    let modulus = 72e9 / (2.0 * (1.0 - 0.17 * 0.17));
    let crossed = 4.0 / 3.0 * modulus * 9e-3f64.sqrt();
    let found = [
        chain.mass[1] / cylinder,
        chain.mass[0] / sphere,
        chain.coefficient[1] / crossed,
    ];
    assert!(apart(found, [1.0; 3]) < 1e-14, "{found:?}");
    assert_eq!(setup.simulation.velocity[0], 0.88);
    assert_eq!((setup.units, setup.pitch), (Units::Si, Some(18e-3)));
}

#[test]
fn units_are_read_as_they_are_written() {
    let numbers = simulation(
        "sites = 3\nyoung = 72e9\npoisson = 0.17\ndensity = 2200\nradius = 0.009\nlength = 0.018\n\
         angle = 90\nstriker_velocity = 0.88\nend_time = 2e-3\nmemory = 1048576",
    );
    let texts = simulation(
        "sites = 3\nyoung = '72 GPa'\npoisson = 0.17\ndensity = '2.2 g/cm^3'\nradius = '9mm'\n\
         length = '1.8 cm'\nangle = '90 deg'\nstriker_velocity = '88 cm/s'\nend_time = '2 ms'\n\
         memory = '1 MiB'",
    );
    assert_eq!(numbers, texts);
}

#[test]
fn patterns_follow_one_another() {
    let five = |keys: &str| simulation(&format!("end_time = 1.0\n{}", sized(keys, 5)));
    for [keys, facts] in rows(include_str!("scenes.txt")) {
        let it = five(&keys);
        for fact in facts.split(" & ") {
            let (what, known) = fact.split_once(' ').unwrap();
            let found = match (what, it.chain.ends) {
                ("mass", _) => it.chain.mass.clone(),
                ("coefficient", _) => it.chain.coefficient.clone(),
                ("velocity", _) => it.velocity.clone(),
                ("left", Ends::Fixed { left_coefficient }) => vec![left_coefficient],
                ("frequencies", _) => {
                    let modes = it.chain.normal_modes().unwrap();
                    modes.frequency[modes.free..].to_vec()
                }
                ("law", _) => {
                    let law = it.chain.law.only().unwrap();
                    assert_eq!(law, &Law::parse(known).unwrap(), "{keys}");
                    let again = five(&format!("law = '{}'", law.text())).chain.law;
                    assert_eq!(again.only(), Some(law), "{keys}");
                    continue;
                }
                _ => panic!("{fact}"),
            };
            let off = apart(&found, parsed(known));
            assert!(off < 2e-15, "{keys}: {found:?}");
        }
    }
    let law = |keys: &str| five(keys).chain.law;
    let cell = law("laws = [\"d - 0.1*d^3\", \"hertz\"]\nends = \"fixed\"");
    assert_eq!([cell.of(3), cell.before_first()], [&Law::Hertz; 2]);
    assert_eq!(cell.text(), "d - 0.1*d^3 | hertz");
    let own = law("law = \"spring\"\n[[defect]]\ncontact = 2\nlaw = \"hertz\"");
    assert_eq!((own.of(2), own.of(1) == &Law::Hertz), (&Law::Hertz, false));
}
