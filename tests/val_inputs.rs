//! Files as people write them are read as they meant them, or asked about.
//!
//! `val_numpy_*`: the text or the arrays are those of the NumPy call that is named.

#[path = "common/place.rs"]
mod place;

use std::fs;

use cascade::field::{Axis, InputFault, Layout, Note, OpenOptions, TimeColumn};
use cascade::{Error, Field};
use ndarray::{Array1, Array2};
use ndarray_npy::{NpzWriter, WritableElement};
use place::{Place, text};
use serde_json::Value;

fn open(place: &Place, name: &str) -> Field {
    Field::open(place.path(name), &OpenOptions::default()).unwrap()
}

fn fault(place: &Place, name: &str, options: &OpenOptions) -> InputFault {
    match Field::open(place.path(name), options) {
        Err(Error::Input { fault, .. }) => fault,
        other => panic!("{other:?}"),
    }
}

fn values(field: &Field) -> Array2<f64> {
    let shape = (field.n_times(), field.n_sites());
    let mut values = vec![0.0; shape.0 * shape.1];
    field.read_time_major(0..shape.0, 0..shape.1, &mut values);
    Array2::from_shape_vec(shape, values).unwrap()
}

fn in_one_line(said: &str) -> String {
    said.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn axis(step: f64, unit: Option<&str>) -> Axis {
    Axis {
        origin: 0.0,
        step,
        unit: unit.map(String::from),
    }
}

/// A pulse, without a site that rises.
fn pulse(times: usize, sites: usize) -> Array2<f64> {
    Array2::from_shape_fn((times, sites), |(n, j)| {
        let s = n as f64 - 2.0 * j as f64 - 12.0;
        (-(s / 4.0).powi(2)).exp() * (0.9 * s).sin()
    })
}

/// `numpy.savetxt(path, numpy.column_stack([t, v]))`, numbers by `%.18e`.
fn savetxt(header: &str, delimiter: &str, field: &Array2<f64>, dt: f64) -> String {
    let mut text = header.to_owned();
    for (n, row) in field.rows().into_iter().enumerate() {
        let time = n as f64 * dt;
        let numbers = std::iter::once(&time).chain(row);
        let cells: Vec<String> = numbers.map(|v| format!("{v:.18e}")).collect();
        text += &format!("{}\n", cells.join(delimiter));
    }
    text
}

#[test]
fn val_numpy_savetxt_with_a_header() {
    let place = Place::new();
    let field = pulse(40, 2);
    // header="time,x0,x1"; "# " comes before it unless comments='' is given.
    for header in [
        "# time,x0,x1\n",
        "time,x0,x1\n",
        "# time x0 x1\n",
        "time x0 x1\n",
        "# run 7\n# time\tx0\tx1\n",
        "# t (s), left, right\n",
    ] {
        for delimiter in [" ", ",", "\t"] {
            fs::write(
                place.path("a.txt"),
                savetxt(header, delimiter, &field, 1e-5),
            )
            .unwrap();
            let read = open(&place, "a.txt");
            assert_eq!(values(&read), field, "{header:?} {delimiter:?}");
            let unit = header.contains("(s)").then_some("s");
            assert_eq!(read.time, axis(1e-5, unit), "{header:?} {delimiter:?}");
            assert_eq!(read.notes, []);
        }
    }
    // Positions as names.
    let text = savetxt("# time,0.5,0.75\n", ",", &field, 1e-5);
    fs::write(place.path("a.txt"), text).unwrap();
    let space = open(&place, "a.txt").space;
    assert_eq!((space.origin, space.step), (0.5, 0.25));
}

#[test]
fn val_numpy_savetxt_without_a_header() {
    let place = Place::new();
    let field = pulse(40, 2);
    for header in ["", "# a comment\n", "clock,x0,x1\n", "# 1,2,3\n"] {
        fs::write(place.path("a.csv"), savetxt(header, ",", &field, 2.5e-4)).unwrap();
        let read = open(&place, "a.csv");
        assert_eq!(values(&read), field, "{header:?}");
        assert_eq!(read.time, axis(2.5e-4, None));
        let layout = Layout::TimeSite;
        let step = 2.5e-4;
        assert_eq!(read.notes, [Note::FirstColumn { layout, step }]);
        let options = OpenOptions {
            time_column: TimeColumn::None,
            ..OpenOptions::default()
        };
        let all = Field::open(place.path("a.csv"), &options).unwrap();
        assert_eq!((all.n_sites(), all.notes.len()), (3, 0));
    }
    let said = place.good(&["analyze", "a.csv", "--figures", "none"]);
    let said = in_one_line(&said);
    assert!(
        said.contains("read as the first column holds the times"),
        "{said}"
    );
    assert!(said.contains("--time-column none"), "{said}");
    let summary = place.json("a.csv-cascade/summary.json");
    let read_as = summary["provenance"]["read_as"][0].as_str().unwrap();
    assert!(
        read_as.contains("the first column holds the times"),
        "{read_as}"
    );
}

#[test]
fn what_may_be_a_time_column_is_asked_about() {
    let place = Place::new();
    for (table, reason) in [
        // Both columns rise evenly.
        ("0,1\n1,2\n2,3\n", "rises evenly, and so does another"),
        // Times of which one is missing.
        ("0,1\n1,5\n2,1\n3,5\n4,1\n5,5\n7,1\n8,5\n", "rises unevenly"),
    ] {
        fs::write(place.path("a.csv"), table).unwrap();
        let layout = Layout::TimeSite;
        let found = fault(&place, "a.csv", &OpenOptions::default());
        assert_eq!(found, InputFault::FirstColumn { layout, reason });
        let said = place.bad(1, &["analyze", "a.csv"]);
        for word in [
            "a.csv",
            "first column",
            "--time-column 0",
            "--time-column none",
        ] {
            assert!(said.contains(word), "{said}");
        }
    }
    // Samples that do not rise, or too few of them to tell.
    for table in [
        "0,1\n1,2\n",
        "3,1\n2,5\n1,2\n",
        "1\n2\n3\n",
        "1,2\n2,5\n3.5,1\n",
    ] {
        fs::write(place.path("a.csv"), table).unwrap();
        let field = open(&place, "a.csv");
        assert_eq!(
            (field.time, field.notes),
            (Axis::index(), vec![]),
            "{table}"
        );
    }
    // Rows that are sites begin with their positions.
    let text = "0,1,5,2\n0.5,3,1,1\n1,2,2,7\n";
    fs::write(place.path("a.csv"), text).unwrap();
    let options = OpenOptions {
        layout: Some(Layout::SiteTime),
        ..OpenOptions::default()
    };
    let field = Field::open(place.path("a.csv"), &options).unwrap();
    assert_eq!((field.n_times(), field.n_sites()), (3, 3));
    assert_eq!(field.space, axis(0.5, None));
    fs::write(place.path("a.csv"), format!("x_mm,0,2,4\n{text}")).unwrap();
    let field = Field::open(place.path("a.csv"), &options).unwrap();
    assert_eq!(
        (field.space, field.time),
        (axis(0.5, Some("mm")), axis(2.0, None))
    );
}

fn savez<T: WritableElement + Clone>(
    place: &Place,
    name: &str,
    field: (&str, &Array2<f64>),
    axes: &[(&str, Vec<T>)],
) {
    let mut archive = NpzWriter::new(fs::File::create(place.path(name)).unwrap());
    archive.add_array(field.0, field.1).unwrap();
    for (axis, values) in axes {
        archive
            .add_array(*axis, &Array1::from(values.clone()))
            .unwrap();
    }
    archive.finish().unwrap();
}

fn steps(n: usize, step: f64) -> Vec<f64> {
    (0..n).map(|i| i as f64 * step).collect()
}

#[test]
fn val_numpy_savez_with_short_names() {
    let place = Place::new();
    let field = pulse(40, 3);
    // numpy.savez(path, v=v, t=t, x=x), v as (time, site) and as (site, time).
    for turned in [false, true] {
        let stored = if turned {
            field.t().to_owned()
        } else {
            field.clone()
        };
        for names in [["v", "t", "x"], ["V", "T", "X"], ["data", "t", "x"]] {
            let axes = [(names[1], steps(40, 1e-5)), (names[2], steps(3, 0.002))];
            savez(&place, "a.npz", (names[0], &stored), &axes);
            let read = open(&place, "a.npz");
            assert_eq!(values(&read), field, "{names:?}");
            assert_eq!(
                (&read.time, &read.space),
                (&axis(1e-5, None), &axis(0.002, None))
            );
            let members = Note::Members {
                field: names[0].into(),
                time: Some(names[1].into()),
                space: Some(names[2].into()),
            };
            assert_eq!(read.notes[0], members);
            let layout = Layout::SiteTime;
            assert_eq!(
                read.notes[1..],
                [Note::Layout { layout }][..usize::from(turned)]
            );
        }
    }
    // Single precision: the step that was meant.
    let times: Vec<f32> = (0..40).map(|n| n as f32 * 1e-5).collect();
    savez(&place, "a.npz", ("v", &field), &[("t", times)]);
    assert_eq!(open(&place, "a.npz").time, axis(1e-5, None));
    // What has the name but not the length is no coordinate of it.
    savez(&place, "a.npz", ("v", &field), &[("t", steps(7, 1.0))]);
    let found = fault(&place, "a.npz", &OpenOptions::default()).to_string();
    assert!(
        found.contains("\"t\"") && found.contains("expected 40"),
        "{found}"
    );
    // A second array of two dimensions does not hide the field.
    let mut archive = NpzWriter::new(fs::File::create(place.path("a.npz")).unwrap());
    archive.add_array("u", &(&field * 2.0)).unwrap();
    archive.add_array("v", &field).unwrap();
    archive.finish().unwrap();
    assert_eq!(values(&open(&place, "a.npz")), field);
}

#[test]
fn a_wide_array_is_asked_about() {
    let place = Place::new();
    place.save("wide.npy", &pulse(80, 10).t().to_owned());
    place.save("narrow.npy", &pulse(10, 79));
    assert_eq!(open(&place, "narrow.npy").notes, []);
    let wide = Note::Wide {
        rows: 10,
        columns: 80,
    };
    assert_eq!(open(&place, "wide.npy").notes, [wide]);
    let words = [
        "analyze",
        "wide.npy",
        "--figures",
        "none",
        "--force",
        "--json",
    ];
    let warnings = |options: &[&str]| -> Vec<Value> {
        let said = place.good(&[&words[..], options].concat());
        let summary: Value = serde_json::from_str(&said).unwrap();
        summary["warnings"].as_array().unwrap().clone()
    };
    let first = &warnings(&[])[0];
    assert_eq!(first["code"], "wide-array");
    for layout in ["--layout site-time", "--layout time-site"] {
        assert!(
            first["advice"].as_str().unwrap().contains(layout),
            "{first}"
        );
    }
    for layout in ["site-time", "time-site"] {
        let others = warnings(&["--layout", layout]);
        assert!(
            others.iter().all(|w| w["code"] != "wide-array"),
            "{others:?}"
        );
    }
    // Coordinates settle it, numpy.savez(path, v=v, t=t).
    savez(
        &place,
        "a.npz",
        ("v", &pulse(80, 10).t().to_owned()),
        &[("t", steps(80, 1.0))],
    );
    assert_eq!(values(&open(&place, "a.npz")), pulse(80, 10));
    savez(
        &place,
        "a.npz",
        ("v", &pulse(10, 80)),
        &[("t", steps(10, 1.0))],
    );
    assert!(
        open(&place, "a.npz")
            .notes
            .iter()
            .all(|note| note.advice().is_none())
    );
}

#[test]
fn an_array_whose_first_site_holds_times_is_asked_about() {
    let place = Place::new();
    // numpy.save(path, numpy.column_stack([t, v]))
    let with_times = Array2::from_shape_fn((40, 4), |(n, j)| match j {
        0 => n as f64 * 1e-4,
        j => pulse(40, 3)[[n, j - 1]],
    });
    place.save("a.npy", &with_times);
    assert_eq!(
        open(&place, "a.npy").notes,
        [Note::RisingSite { step: 1e-4 }]
    );
    let said = place.good(&["analyze", "a.npy", "--figures", "none"]);
    let said = in_one_line(&said);
    assert!(said.contains("first site rises evenly by 0.0001"), "{said}");
}

#[test]
fn steps_carry_units() {
    let place = Place::new();
    place.save("a.npy", &pulse(64, 8));
    let found = |options: &[&str], sidecar: &str| -> (Value, String) {
        fs::write(place.path("a.npy.toml"), sidecar).unwrap();
        let words = ["analyze", "a.npy", "--figures", "none", "--force"];
        let said = place.good(&[&words[..], options].concat());
        let first = said.lines().next().unwrap().to_owned();
        (place.json("a-cascade/summary.json")["field"].clone(), first)
    };
    let cases: [(&[&str], &str); 8] = [
        (&["--dt", "10us", "--dx", "2mm"], ""),
        (&["--rate", "100kHz", "--dx", "0.2 cm"], ""),
        (&["--fs", "100000", "--time-unit", "sec", "--dx", "2mm"], ""),
        (&[], "dt = \"10 us\"\ndx = \"2 mm\"\n"),
        (&[], "fs = \"100 kHz\"\ndx = \"2 mm\"\n"),
        (
            &[],
            "rate = 1e5\ntime_unit = \"seconds\"\ndx = 0.002\nspace_unit = \"metres\"\n",
        ),
        (&["--dt", "10us"], "rate = \"1 Hz\"\ndx = \"2 mm\"\n"),
        (
            &["--dt", "1e-5", "--time-unit", "s", "--t0", "0ms"],
            "dx = \"2 mm\"\nfs = 3\n",
        ),
    ];
    for (options, sidecar) in cases {
        let (field, first) = found(options, sidecar);
        assert_eq!(
            (&field["dt"], &field["dx"]),
            (&1e-5.into(), &0.002.into()),
            "{options:?}"
        );
        let units = &field["units"];
        assert_eq!(
            (&units["time"], &units["frequency"]),
            (&"s".into(), &"Hz".into())
        );
        assert_eq!(
            (&units["space"], &units["wavenumber"]),
            (&"m".into(), &"rad/m".into())
        );
        assert!(first.ends_with("dt 1e-5 s, dx 0.002 m"), "{first}");
    }
    // In the unit of the axis, where one is stated.
    let (field, first) = found(&["--dt", "10us", "--t0", "-0.3s"], "time_unit = \"ms\"\n");
    assert_eq!(
        (&field["dt"], &field["t0"]),
        (&0.01.into(), &(-300.0).into())
    );
    assert_eq!(field["units"]["frequency"], "kHz");
    assert!(
        first.contains("dt 0.01 ms, no dx: x counts sites"),
        "{first}"
    );
    // Without steps, the first line says what is counted.
    let (field, first) = found(&[], "");
    assert!(
        first.contains("no dt: time counts samples, no dx: x counts sites"),
        "{first}"
    );
    assert_eq!(field["units"]["frequency"], "cycles/sample");
    for (code, words, expected) in [
        (
            2,
            &["--dt", "10 parsec"][..],
            &["--dt", "10 parsec", "ms"][..],
        ),
        (2, &["--dt", "-1us"], &["--dt", "-1us", "above 0"]),
        (2, &["--dt", "1", "--rate", "1"], &["--rate", "--dt"]),
        (2, &["--dx", "2ms"], &["--dx", "2ms", "mm"]),
        (
            1,
            &["--dt", "10us", "--time-unit", "ticks"],
            &["a.npy", "ticks", "--time-unit"],
        ),
    ] {
        let base = ["analyze", "a.npy", "--out", "new"];
        let said = place.bad(code, &[&base[..], words].concat());
        for word in expected {
            assert!(said.contains(word), "{words:?}: {said}");
        }
    }
}

/// The same record with its times in s and in ms beside a scene in SI: the same energies.
#[test]
fn regress_a_field_beside_an_si_scene_is_put_into_si() {
    let place = Place::new();
    let si = "sites = 6\nmaterial = \"steel\"\nshape = \"sphere\"\nradius = \"9 mm\"\n\
              striker_velocity = \"1 m/s\"\nend_time = 1e-4\nsamples = 201\n";
    fs::write(place.path("si.toml"), si).unwrap();
    place.good(&["simulate", "si.toml", "--out", "run.npz", "--quiet"]);
    place.save("a.npy", &values(&open(&place, "run.npz")));
    let base =
        "budget a.npy --scene si.toml --noise 1e-6 --figures none --force --json --only wavenumber";
    let base: Vec<&str> = base.split(' ').collect();
    let found = |words: &[&str]| -> Value {
        let said = place.good(&[&base[..], words].concat());
        let mut summary: Value = serde_json::from_str(&said).unwrap();
        summary["provenance"].take();
        summary
    };
    let seconds = found(&["--dt", "5e-7"]);
    assert_eq!(found(&["--dt", "5e-4", "--time-unit", "ms"]), seconds);
    assert_eq!(found(&["--dt", "0.5us", "--time-unit", "ms"]), seconds);
    for (words, found) in [
        (&["--dt", "1", "--time-unit", "ticks"][..], "ticks"),
        (&["--dt", "1us", "--unit", "mm/s"], "mm/s"),
    ] {
        let base = ["budget", "a.npy", "--scene", "si.toml", "--out", "new"];
        let said = place.bad(2, &[&base[..], words].concat());
        assert!(said.contains("a.npy") && said.contains(found), "{said}");
    }
}

#[test]
fn a_filter_says_what_it_cannot_mean() {
    let place = Place::new();
    place.save("a.npy", &pulse(64, 8));
    let warned = |words: &[&str]| {
        let base = ["filter", "a.npy", "--force", "--out", "b.npz"];
        let output = place.run(&[&base[..], words].concat());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        text(&output.stderr)
    };
    let said = warned(&["--speed", "0.1:3"]);
    assert!(
        said.contains("site per sample") && said.contains("`--dt` and `--dx`"),
        "{said}"
    );
    assert_eq!(
        warned(&["--speed", "0.1:3", "--dt", "2s", "--dx", "3m"]),
        ""
    );
    assert_eq!(warned(&["--frequency", "0:0.2"]), "");
    let said = warned(&["--frequency", "5:90"]);
    assert!(
        said.contains("nothing passes") && said.contains("0.5000 cycles/sample"),
        "{said}"
    );
    let base = [
        "filter",
        "a.npy",
        "--frequency",
        "9:10",
        "--out",
        "c.npz",
        "--json",
    ];
    let output = place.run(&base);
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(
        summary["warnings"][0]["message"]
            .as_str()
            .unwrap()
            .contains("nothing passes")
    );
}

#[test]
fn a_filtered_field_is_written_as_its_name_says() {
    let place = Place::new();
    place.save("a.npy", &pulse(64, 8));
    let base = [
        "filter",
        "a.npy",
        "--towards",
        "plus-x",
        "--dt",
        "10us",
        "--unit",
        "mm/s",
    ];
    let filter = |rest: &[&'static str]| [&base[..], rest].concat();
    place.good(&filter(&["--out", "plus.npz"]));
    place.good(&filter(&["--out", "plus.npy"]));
    let bytes = fs::read(place.path("plus.npy")).unwrap();
    assert!(bytes.starts_with(b"\x93NUMPY"));
    let [array, archive] = ["plus.npy", "plus.npz"].map(|name| open(&place, name));
    assert_eq!(values(&array), values(&archive));
    assert_eq!((&array.time, &array.space), (&archive.time, &archive.space));
    assert_eq!(
        (array.time, array.unit),
        (axis(1e-5, Some("s")), archive.unit)
    );
    // Replaced only if asked for, and only if this program wrote it.
    place.bad(2, &filter(&["--out", "plus.npy"]));
    place.good(&filter(&["--out", "plus.npy", "--force"]));
    let said = place.bad(2, &filter(&["--out", "a.npy", "--force"]));
    assert!(said.contains("a.npy"), "{said}");
    for name in ["plus.csv", "plus.txt"] {
        let said = place.bad(2, &filter(&["--out", name]));
        assert!(said.contains("--out") && said.contains(".npz"), "{said}");
    }
    let said = place.bad(
        2,
        &[
            "simulate",
            "--sites",
            "3",
            "--end-time",
            "3",
            "--out",
            "run.npy",
        ],
    );
    assert!(said.contains("--out") && said.contains(".npz"), "{said}");
    // Beside a sidecar under the other name the array would have two.
    fs::write(place.path("minus.toml"), "dt = 1\n").unwrap();
    let said = place.bad(2, &filter(&["--out", "minus.npy"]));
    assert!(said.contains("minus.toml"), "{said}");
}

#[test]
fn default_names_of_results_differ() {
    let place = Place::new();
    place.save("travel.npy", &pulse(64, 8));
    savez(
        &place,
        "travel.npz",
        ("v", &pulse(64, 8)),
        &[("t", steps(64, 1.0))],
    );
    for name in ["travel.npy", "travel.npz"] {
        place.good(&["analyze", name, "--figures", "none", "--quiet"]);
        place.good(&["filter", name, "--towards", "plus-x", "--quiet"]);
    }
    for name in [
        "travel-cascade",
        "travel.npz-cascade",
        "travel-filtered.npz",
        "travel.npz-filtered.npz",
    ] {
        assert!(place.path(name).exists(), "{name}: {:?}", place.names());
    }
}

#[test]
fn options_without_effect_are_refused() {
    let place = Place::new();
    place.save("a.npy", &pulse(64, 8));
    fs::write(place.path("a.csv"), "1,2\n5,1\n2,2\n").unwrap();
    let run = "simulate --sites 4 --end-time 4 --samples 65 --quiet --out run.npz";
    place.good(&run.split(' ').collect::<Vec<_>>());
    for (words, option) in [
        ("analyze a.npy --member v", "--member"),
        ("analyze a.csv --member v", "--member"),
        ("filter a.npy --towards plus-x --member v", "--member"),
        ("analyze a.npy --header present", "--header"),
        ("analyze a.npy --time-column 0", "--time-column"),
        (
            "analyze a.npy --short-space-segment 4",
            "--short-time-times",
        ),
        ("analyze a.npy --short-space-hop 4", "--short-time-times"),
        (
            "analyze a.npy --only temporal --short-time-sites 1",
            "--short-time-sites",
        ),
        (
            "analyze a.npy --only temporal --short-time-window none",
            "--short-time-window",
        ),
        ("analyze a.npy --only spatial --segment 16", "--segment"),
        (
            "analyze a.npy --only spatial --reference-site 1",
            "--reference-site",
        ),
        (
            "analyze a.npy --only temporal --reference-time 1",
            "--reference-time",
        ),
        (
            "analyze a.npy --only temporal --band-edge-wavenumber 1",
            "--band-edge-wavenumber",
        ),
        (
            "analyze a.npy --only temporal --direction-band 0:1",
            "--direction-band",
        ),
        (
            "analyze a.npy --only temporal --pad-space 99",
            "--pad-space",
        ),
        ("budget run.npz --only wavenumber --scales 2", "--scales"),
        (
            "budget run.npz --only wavenumber --between 0:1",
            "--between",
        ),
        (
            "compare run.npz run.npz --only scale --band-edge-frequency 1",
            "--band-edge-frequency",
        ),
        (
            "attenuate --ratios 2 --sense chain --lengths 5,10",
            "--lengths",
        ),
    ] {
        let said = place.bad(2, &words.split(' ').collect::<Vec<_>>());
        assert!(said.contains(option), "{words}: {said}");
    }
}

#[test]
fn messages_name_what_was_typed_and_the_file() {
    let place = Place::new();
    let simulate = |words: &str| {
        let base = "simulate --sites 4 --samples 65 --quiet";
        let words: Vec<&str> = base.split(' ').chain(words.split(' ')).collect();
        place.good(&words);
    };
    simulate("--end-time 4 --out plain.npz");
    simulate(
        "--end-time 1e-4 --material steel --shape sphere --radius 9mm --striker-velocity 1 \
              --out si.npz",
    );
    place.save("still.npy", &Array2::<f64>::zeros((64, 4)));
    fs::write(place.path("nan.csv"), "1,2\nnan,1\n2,2\n").unwrap();
    for (code, words, named, not) in [
        (
            2,
            "compare plain.npz si.npz",
            &["si.npz: ", "plain.npz"][..],
            "--second",
        ),
        (
            2,
            "transmit --sites 5 --over stiffness_ratio=5:1:3log:2",
            &["--over"],
            "--vary",
        ),
        (
            2,
            "transmit --sites 5 --over nonsense=1,2",
            &["--over", "nonsense"],
            "--vary",
        ),
        (
            2,
            "transmit --sites 5 --vary nonsense=1,2",
            &["--vary", "nonsense"],
            "--over",
        ),
        (
            2,
            "attenuate --ratios 2 --bodies 3 --sense chain --best-at 3 --best-over nonsense=1,2",
            &["--best-over", "nonsense"],
            "--vary",
        ),
        (
            2,
            "transmit --sites 5 --measured 2=still.npy",
            &["still.npy"],
            "--measured",
        ),
        (
            1,
            "filter nan.csv --frequency 0:1",
            &["nan.csv"],
            "--frequency",
        ),
    ] {
        let said = place.bad(code, &words.split(' ').collect::<Vec<_>>());
        for word in named {
            assert!(said.contains(word), "{words}: {said}");
        }
        assert!(!said.contains(not), "{words}: {said}");
    }
}
