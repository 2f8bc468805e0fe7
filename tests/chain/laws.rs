//! Contact laws against closed forms, against each other, and as scenes name them.

use std::sync::Arc;

use test_support::contains_all;
use test_support::place::Place;
use test_support::scenes::{apart, near, rows, run, simulation};
use wavecascade::chain::scene::SceneSource;
use wavecascade::chain::{ContactLaw, Jet, Law, RunWarning};
use wavecascade::observer::Silent;
use wavecascade::report::RunFile;

#[test]
fn val_same_force_laws_that_are_one_in_other_words() {
    for [name, both, one, other, most] in rows(include_str!("same.txt")) {
        let [a, b] = [one, other].map(|keys| run(&format!("samples = 65\n{both}\n{keys}")));
        let off = apart(&a.velocity, &b.velocity);
        let (scale, drift) = (a.report.velocity_scale, a.report.energy_drift.unwrap());
        assert!(drift < 1e-7 && scale > 0.0, "{name}: {drift:e} {scale}");
        let stated = [&a, &b].map(|run| run.report.error.unwrap_or(0.0) * scale);
        let most = match most.as_str() {
            "stated" => stated[0] + stated[1],
            most => most.parse().unwrap(),
        };
        println!("{name}: {off:.1e} of {most:.1e}");
        assert!(off <= most, "{name}: {off:e} of {most:e}");
        assert_eq!(
            (a.report.warnings, b.report.warnings),
            (vec![], vec![]),
            "{name}"
        );
    }
}

/// Beyond the rows of its table a law goes on as a line, and the run says so.
#[test]
fn regress_overlaps_beyond_a_table_are_warned_of() {
    let keys = "sites = 20\nends = 'free'\nstriker_velocity = 0.7\nend_time = 30\nsamples = 65\nlaw = 'table -0.1 -0.1, 0 0, 0.1 0.1'";
    let warned = run(keys).report.warnings;
    let [
        RunWarning::OutsideLaw {
            contact: 0,
            range: [-0.1, 0.1],
            ..
        },
    ] = warned[..]
    else {
        panic!("{warned:?}")
    };
}

#[test]
fn val_forces_stiffnesses_and_energies() {
    for [law, d0, r, force, stiffness, energy, most] in rows(include_str!("laws.txt")) {
        let [d0, r, most] = [d0, r, most].map(|number| number.parse::<f64>().unwrap());
        let of = Law::parse(&law).unwrap();
        for (known, found) in [
            (force, of.force(1.0, d0, r)),
            (stiffness, of.stiffness(1.0, d0, r)),
            (energy, of.energy(1.0, d0, r)),
        ] {
            let known = known.parse().unwrap_or(found);
            near(found, known, most * known.abs(), (&law, d0, r));
        }
    }
}

/// A law of the library's user: its force alone.
#[derive(Debug)]
struct Stiffening;

impl ContactLaw for Stiffening {
    fn text(&self) -> String {
        "stiffening".into()
    }

    fn force(&self, delta: Jet) -> Jet {
        delta + delta * delta * delta
    }
}

#[test]
fn val_same_force_an_own_law() {
    let (own, known) = (
        Law::Other(Arc::new(Stiffening)),
        Law::polynomial(vec![1.0, 0.0, 1.0]),
    );
    let [a, b] = [&own, &known].map(|law| {
        let mut it = simulation("sites = 12\nends = 'free'\nstriker_velocity = 0.7\nend_time = 20\ntolerance = 1e-10\nsamples = 65");
        it.chain.law = law.clone().into();
        it.run(&Silent).unwrap().velocity
    });
    assert!(apart(&a, &b) < 1e-10);
    for (d0, r) in [(0.0, 0.4), (0.5, -0.3), (0.5, 1e-3)] {
        let of = |law: &Law| [law.stiffness(1.0, d0, r), law.energy(1.0, d0, r)];
        let pairs = of(&own).into_iter().zip(of(&known));
        assert!(pairs.into_iter().all(|(a, b)| (a / b - 1.0).abs() < 1e-14));
    }
}

/// A motion that runs away in finite time ends with an error that says where.
#[test]
fn motions_that_run_away_are_refused() {
    for keys in [
        "sites = 8\nlaw = 'spring'\nalpha = 0.25",
        "sites = 2\nlaw = 'polynomial 1 1'",
        "sites = 2\nlaw = 'd - d^3'",
    ] {
        let it = simulation(&format!(
            "ends = 'free'\nstriker_velocity = 3\nend_time = 50\nsamples = 65\n{keys}"
        ));
        contains_all(
            &it.run(&Silent).unwrap_err().to_string(),
            &["contact ", "overlap"],
        );
    }
}

/// A measured law in a table beside the scene, in units of the laboratory; the run holds its values and no file's name.
#[test]
fn a_run_names_no_files() {
    let place = Place::new();
    place.write(
        "contact.csv",
        "force [N], overlap [um]\n-2, -1000\n0, 0\n3, 1000\n",
    );
    let text = "sites = 4\nunits = \"si\"\nmasses = [1.0, 1.0, 1.0, 1.0]\nlaw_file = \"contact.csv\"\n\
                striker_velocity = 0.01\nend_time = 0.1\nsamples = 9\n";
    let read = |text: &str| {
        place.write("scene.toml", text);
        SceneSource::read(&place.path("scene.toml"))
            .unwrap()
            .setup()
    };
    let mut setup = read(text).unwrap();
    let measured = Law::table(vec![-1e-3, 0.0, 1e-3], vec![-2.0, 0.0, 3.0]).unwrap();
    assert_eq!(setup.simulation.chain.law.only(), Some(&measured));
    let run = setup.simulation.run(&Silent).unwrap();
    let path = place.path("run.npz");
    RunFile::write(&path, false, &setup, &run, &Silent).unwrap();
    std::fs::remove_file(place.path("contact.csv")).unwrap();
    let again = RunFile::read(&path).unwrap().setup.simulation;
    assert_eq!(again.chain.law.only(), Some(&measured));
    for key in [
        "law_file = \"contact.csv\"",
        "state = \"run.npz\"",
        "drive = \"force\"\ndrive_file = \"x.csv\"",
    ] {
        let text = text.replace("striker_velocity = 0.01\n", "");
        setup.text = text.replace("law_file = \"contact.csv\"", key);
        let error = RunFile::write(&path, true, &setup, &run, &Silent).unwrap_err();
        contains_all(&error.to_string(), &["a run carries the values of files"]);
    }
    let error = read(&format!("law = \"hertz\"\n{text}")).unwrap_err();
    contains_all(&error.to_string(), &["one key of `law_file` and `law`"]);
}
