//! `cascade simulate`, `scene` and `contact` as a stranger meets them.

use std::collections::BTreeSet;
use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use ndarray::Array2;
use wavecascade::Field;
use wavecascade::chain::scene::{SceneSource, Setup};
use wavecascade::chain::{Ends, Law, Run};
use wavecascade::field::{OpenOptions, Quantity};
use wavecascade::observer::Silent;
use wavecascade::report::RunFile;

use test_support::contains_all;
use test_support::fields::reading;
use test_support::place::{Place, set};

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/scenes")
}

/// A run with more options.
fn short(more: &str) -> String {
    format!("simulate --sites 12 --stiffness-ratio 4.9272 --end-time 9 --samples 64 {more}")
}

#[test]
fn a_run_from_options_alone_is_read_by_its_arrays_and_by_analyze() {
    let place = Place::new();
    let said = place.says(&short("--out run.npz"));
    for words in [
        "12 sites",
        "stiffness ratio 4.9272",
        "estimated error",
        "energy drift",
        "run.npz",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert_eq!(place.names(), BTreeSet::from(["run.npz".into()]));
    let array = |name: &str| place.array::<f64>("run.npz", name);
    let time = array("time");
    assert_eq!((time.len(), time[0], time[63]), (64, 0.0, 9.0));
    for name in ["velocity", "displacement", "force", "energy_passed"] {
        assert_eq!(array(name).shape(), [64, 12], "{name}");
    }
    let (mass, coefficient) = (array("mass"), array("contact_coefficient"));
    assert_eq!((mass.len(), coefficient[1]), (12, 4.9272));

    let field = Field::open(place.path("run.npz"), &OpenOptions::default()).unwrap();
    assert_eq!(field.quantity, Quantity::Velocity);
    assert!((field.time.step - 9.0 / 63.0).abs() < 1e-15);
    let units = [field.time.unit, field.space.unit, field.unit];
    assert_eq!(units, [None, None, None]);
    place.good(&["analyze", "run.npz", "--out", "out", "--figures", "none"]);
    assert!(place.path("out/summary.json").exists());
}

#[test]
fn an_si_run_states_its_units_and_its_scene_is_no_sidecar() {
    let place = Place::new();
    fs::copy(
        examples().join("quartz_cylinders.toml"),
        place.path("quartz.toml"),
    )
    .unwrap();
    place.good(&[
        "simulate",
        "quartz.toml",
        "--end-time",
        "0.4 ms",
        "--samples",
        "200",
    ]);
    assert!(place.path("quartz.npz").exists());
    let open = |member: Option<&str>| {
        let options = reading(|it| it.variable = member.map(str::to_owned));
        Field::open(place.path("quartz.npz"), &options).unwrap()
    };
    let field = open(None);
    assert_eq!(field.quantity, Quantity::Velocity);
    assert_eq!((field.n_times(), field.n_sites()), (200, 41));
    assert_eq!(field.time.unit.as_deref(), Some("s"));
    assert!((field.time.step / (0.4e-3 / 199.0) - 1.0).abs() < 1e-12);
    assert_eq!(field.space.unit.as_deref(), Some("m"));
    assert!((field.space.step / 0.018 - 1.0).abs() < 1e-12);
    assert_eq!(field.unit.as_deref(), Some("m/s"));
    let force = open(Some("force"));
    assert_eq!(force.quantity, Quantity::Force);
    assert_eq!(force.unit.as_deref(), Some("N"));
    assert!((force.space.origin / 0.009 - 1.0).abs() < 1e-12);

    // The same scene beside any other archive of its name is no sidecar either.
    fs::copy(place.path("quartz.toml"), place.path("other.toml")).unwrap();
    let archive = fs::File::create(place.path("other.npz")).unwrap();
    let mut npz = ndarray_npy::NpzWriter::new(archive);
    npz.add_array("velocity", &Array2::<f64>::ones((9, 3)))
        .unwrap();
    npz.finish().unwrap();
    let other = Field::open(place.path("other.npz"), &OpenOptions::default()).unwrap();
    assert_eq!(other.time.unit, None);
    // A sidecar of a run has the run's whole name.
    place.write("quartz.npz.toml", "time_unit = 'h'");
    assert_eq!(open(None).time.unit.as_deref(), Some("h"));
}

#[test]
fn what_is_written_is_what_the_library_computes_and_reads_back() {
    let place = Place::new();
    let text = "sites = 9\nmass_spread = 0.2\nends = 'free'\ndrag = 0.01\ndrive = 'force'\n\
                drive_amplitude = 0.3\ndrive_frequency = 0.1\nend_time = 6.0\nsamples = 20\n\
                # a comment in \u{3ba}\n";
    place.write("scene.toml", text);
    place.says("simulate scene.toml -o deep/folder/a.npz --seed 5");
    let source = SceneSource::read(&place.path("scene.toml")).unwrap();
    let setting = wavecascade::chain::scene::Setting {
        key: "seed".into(),
        text: "5".into(),
        source: "test".into(),
    };
    let setup = source.with([setting]).setup().unwrap();
    let run = setup.simulation.run(&Silent).unwrap();
    let read = RunFile::read(&place.path("deep/folder/a.npz")).unwrap();
    assert_eq!(read.setup, setup);
    assert_eq!(read.run.report, run.report);
    assert_eq!(read.run.time, run.time);
    assert_eq!(read.run.velocity, run.velocity);
    assert_eq!(read.run.displacement, run.displacement);
    assert_eq!(read.run.force, run.force);
    assert_eq!(read.run.energy_passed, run.energy_passed);
    assert_eq!(read.run.energy_lost, run.energy_lost);
    assert_eq!(read.run.energy_input, run.energy_input);
    assert!(read.run.energy_input.is_some() && read.run.energy_lost.is_some());
    assert_eq!(read.run.chain, run.chain);
    // Without settings over it, the text is kept as it is.
    place.good(&["simulate", "scene.toml", "-o", "b.npz", "--force"]);
    let read = RunFile::read(&place.path("b.npz")).unwrap();
    assert_eq!(read.setup.text, text);
}

#[test]
fn only_what_is_recorded_is_kept() {
    let place = Place::new();
    place.says(&short("--out few.npz --record force"));
    let expected = [
        "contact_coefficient",
        "force",
        "hashes",
        "mass",
        "report",
        "scene",
        "schema",
        "time",
        "velocity",
    ];
    assert_eq!(place.arrays("few.npz"), set(&expected));
    assert_eq!(place.array::<f64>("few.npz", "force").shape(), [64, 12]);
    let none = short("--out none.npz --record");
    let none: Vec<&str> = none.split(' ').chain([""]).collect();
    place.good(&none);
    let read = RunFile::read(&place.path("none.npz")).unwrap();
    assert!(read.run.force.is_none());
}

#[test]
fn nothing_is_overwritten_unasked_and_nothing_but_a_run_ever() {
    let place = Place::new();
    place.says(&short("--out run.npz"));
    let first = fs::read(place.path("run.npz")).unwrap();
    let said = place.refuses(2, &short("--out run.npz"));
    assert!(said.contains("--force"), "{said}");
    assert_eq!(fs::read(place.path("run.npz")).unwrap(), first);
    place.says(&short("--out run.npz --force"));
    place.write("notes.npz", "mine");
    fs::create_dir(place.path("folder")).unwrap();
    for taken in ["notes.npz", "folder"] {
        let said = place.refuses(2, &short(&format!("--out {taken} --force")));
        assert!(said.contains("not replaced"), "{said}");
    }
    place.refuses(2, &short("--out .."));
    place.refuses(1, &short("--out notes.npz/run.npz"));
}

/// A run is written with its own scene alone.
#[test]
fn regress_runs_of_other_scenes_are_not_written() {
    let place = Place::new();
    place.says(&short("--out run.npz"));
    let good = RunFile::read(&place.path("run.npz")).unwrap();
    let path = place.path("changed.npz");
    let write = |change: &dyn Fn(&mut Run, &mut Setup)| {
        let (mut run, mut setup) = (good.run.clone(), good.setup.clone());
        change(&mut run, &mut setup);
        RunFile::write(&path, false, &setup, &run, &Silent)
    };
    let refused = |change: &dyn Fn(&mut Run, &mut Setup), expected: &str| {
        contains_all(&write(change).unwrap_err().to_string(), &[expected]);
    };
    let shorter = |run: &mut Run| run.time = run.time.slice(ndarray::s![..60]).to_owned();
    refused(&|run, _| shorter(run), "60 samples in place of 64");
    refused(
        &|run, _| run.chain.mass[3] = 1.5,
        "masses[3] = 1.5 in place of 1",
    );
    refused(
        &|run, _| run.chain.mass.push(1.0),
        "13 masses in place of 12",
    );
    let own = |run: &mut Run| run.chain.law = Law::toda(2.0).into();
    refused(
        &|run, _| own(run),
        "the law `toda 2` of contact 0 in place of `hertz`",
    );
    refused(
        &|run, _| run.chain.precompression = 1.0,
        "other precompression",
    );
    refused(&|run, _| run.chain.ends = Ends::Periodic, "other ends");
    let text = "sites = 12\nend_time = 9\nsamples = 64\nlaw = 'square'";
    refused(&|_, setup| setup.text = text.into(), "law: expected");
    // An array that the scene records is not there.
    write(&|run, _| run.force = None).unwrap();
    let error = RunFile::read(&path).unwrap_err().to_string();
    contains_all(&error, &["\"force\" is not there"]);
    // A field of another origin.
    let field = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data/lattice_impact.npy");
    assert!(RunFile::read(&field).is_err());
}

/// Arrays that were changed after the run was written are found, whoever wrote the file anew.
#[test]
fn regress_changed_arrays_of_runs_are_refused() {
    let place = Place::new();
    place.says(&short("--out run.npz"));
    for changed in ["velocity.npy", "displacement.npy", "nothing"] {
        let mut from =
            zip::ZipArchive::new(fs::File::open(place.path("run.npz")).unwrap()).unwrap();
        let mut to = zip::ZipWriter::new(fs::File::create(place.path("changed.npz")).unwrap());
        for i in 0..from.len() {
            let mut member = from.by_index(i).unwrap();
            let name = member.name().unwrap().into_owned();
            let mut bytes = Vec::new();
            member.read_to_end(&mut bytes).unwrap();
            if name == changed {
                let header = 10 + usize::from(bytes[8]) + 256 * usize::from(bytes[9]);
                bytes[header..].fill(0);
            }
            to.start_file(name, zip::write::SimpleFileOptions::default())
                .unwrap();
            to.write_all(&bytes).unwrap();
        }
        to.finish().unwrap();
        if changed == "nothing" {
            RunFile::read(&place.path("changed.npz")).unwrap();
            continue;
        }
        place.write(
            "next.toml",
            "sites = 12\nend_time = 1\nstate = 'changed.npz'\n",
        );
        for command in [
            "budget changed.npz",
            "simulate next.toml --out next.npz --force",
        ] {
            let said = place.refuses(1, command);
            let what = changed.trim_end_matches(".npy");
            contains_all(&said, &["changed.npz", what, "cascade simulate"]);
        }
    }
}

#[test]
fn the_examples_are_scenes_and_the_short_ones_run() {
    let place = Place::new();
    let mut count = 0;
    for entry in fs::read_dir(examples()).unwrap() {
        let path = entry.unwrap().path();
        let said = place.good(&["scene", "--check", path.to_str().unwrap()]);
        assert!(said.contains("chain") && said.contains("memory"), "{said}");
        count += 1;
        let scene = path.to_str().unwrap();
        let fewer = "--samples 32 --tolerance 1e-5 --force --out run.npz".split(' ');
        let words: Vec<&str> = ["simulate", scene].into_iter().chain(fewer).collect();
        let short = ["linear_chain", "lossy_spheres", "quartz_cylinders"];
        if short
            .iter()
            .any(|name| path.ends_with(format!("{name}.toml")))
        {
            place.good(&words);
        }
    }
    assert!(count >= 6, "{count}");
}

#[test]
fn the_scene_command_prints_a_scene_that_runs_and_a_schema() {
    let place = Place::new();
    place.write("scene.toml", place.good(&["scene"]));
    let plan = place.says_json("simulate scene.toml --plan --json");
    assert_eq!(plan["sites"], 300);
    assert_eq!(plan["stiffness_ratio"], 4.9272);
    // All samples of a run with its arrays, and the velocities of its check at some of them.
    assert_eq!(plan["memory"], 1024 * 8 * (1 + 4 * 300) + 130 * 8 * 300);
    assert_eq!(place.names().len(), 1, "a plan writes nothing");
    let schema = place.says_json("scene --schema");
    let properties = schema["properties"].as_object().unwrap();
    assert!(properties.contains_key("stiffness_ratio"));
    assert_eq!(schema["additionalProperties"], false);
    assert!(!schema.to_string().contains("null"), "TOML has no null");
    // Every key of it is an option of `simulate`, with its description.
    let own = place.good(&["simulate", "--help"]);
    assert!(own.lines().count() < 60, "{own}");
    assert!(!own.contains("--stiffness-ratio <"), "{own}");
    assert!(own.contains("cascade simulate --help scene"), "{own}");
    let help = place.good(&["simulate", "--help", "scene"]);
    for key in properties.keys() {
        assert!(
            help.contains(&format!("--{} ", key.replace('_', "-"))),
            "{key}"
        );
    }
    assert!(help.contains("Number of sites, the striker (site 0) included"));
    let page = place.good(&["man", "simulate"]);
    assert!(page.contains("stiffness\\-ratio"), "{page}");
    assert!(place.says("completions bash").contains("--stiffness-ratio"));
}

#[test]
fn json_says_what_was_done() {
    let place = Place::new();
    let said = place.says_json(&short("--json -o a.npz"));
    assert_eq!(said["schema"], "cascade.run/1");
    assert_eq!(said["file"], "a.npz");
    assert!(said["report"]["error"].as_f64().unwrap() < 1e-9);
    assert!(said["report"]["cost"]["steps"].as_u64().unwrap() > 10);
    assert_eq!(place.says(&short("--quiet -o b.npz")), "");
}

#[test]
fn val_paper_the_contact_of_8_degrees() {
    let place = Place::new();
    let scene = "sites = 20
units = \"si\"
material = \"quartz\"
radius = \"9 mm\"
length = \"18 mm\"
\
                 angle = \"8 deg\"
second_angle = \"90 deg\"
striker_radius = \"9 mm\"
\
                 striker_velocity = \"0.88 m/s\"
";
    place.write("scene.toml", scene);
    let said = place.good(&["scene", "--check", "scene.toml"]);
    // 4.507 in the paper.
    assert!(said.contains("stiffness ratio 4.506814"), "{said}");
}

/// `none` takes a key of the file away, whatever its kind, and stays the value of keys that have it.
#[test]
fn val_none_unsets_a_key_of_the_scene() {
    let place = Place::new();
    let scene = "sites = 5\nstiffness_ratio = 2.0\nend_time = 4.0\nsamples = 9\n";
    for (more, option) in [
        ("precompression = 0.1", "--precompression"),
        ("law = \"hertz\"", "--law"),
        ("mass_cell = [1, 2]", "--mass-cell"),
        ("[[defect]]\nsite = 2\nfactor = 2.0", "--defect"),
        ("tangent = 0.01\ndrag = 0.1", "--tangent none --drag"),
    ] {
        place.write("plain.toml", scene);
        place.write("more.toml", format!("{scene}{more}\n"));
        place.says("simulate plain.toml --force --quiet --out plain.npz --units none");
        place.says(&format!(
            "simulate more.toml {option} none --force --quiet --out unset.npz"
        ));
        let velocity = |run: &str| place.array::<f64>(run, "velocity");
        assert_eq!(velocity("plain.npz"), velocity("unset.npz"), "{more}");
    }
    let spheres = "sites = 5\nunits = \"si\"\nmaterial = \"steel\"\nstriker_velocity = 1.0\nradius = \"9mm\"\nshape = \"sphere\"\n";
    place.write("plain.toml", spheres);
    place.write("more.toml", format!("{spheres}wall_material = \"ptfe\"\n"));
    let plan = |words: &str| place.says(&format!("simulate {words} --plan --json"));
    assert_eq!(plan("more.toml --wall-material none"), plan("plain.toml"));
    place.refuses_for(2, "simulate plain.toml --units none --plan", "--units");
}
