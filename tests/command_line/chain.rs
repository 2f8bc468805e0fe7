//! `cascade simulate`, `scene` and `contact` as a stranger meets them.

use std::fs;
use std::io::{Read, Write};
use std::path::Path;

use wavecascade::chain::scene::{SceneSource, Setup};
use wavecascade::chain::{Ends, Law, Run};
use wavecascade::observer::Silent;
use wavecascade::report::RunFile;

use test_support::contains_all;
use test_support::place::Place;

/// A run with more options.
fn short(more: &str) -> String {
    format!("simulate --sites 12 --end-time 9 --samples 64 {more}")
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

/// Each with its description.
#[test]
fn every_key_of_a_scene_is_an_option_of_simulate() {
    let place = Place::new();
    let schema = place.says_json("scene --schema");
    let help = place.says("simulate --help scene");
    for key in schema["properties"].as_object().unwrap().keys() {
        let option = format!("--{} ", key.replace('_', "-"));
        assert!(help.contains(&option), "{key}");
    }
}
