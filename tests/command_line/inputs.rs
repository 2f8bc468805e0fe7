//! Options of fields on the command line: units, names of results, options without effect, messages.

use std::fs;

use ndarray::Array2;
use serde_json::Value;
use test_support::contains_all;
use test_support::made::{axis, open, pulse, savez, steps, values};
use test_support::place::{Place, text};

#[test]
fn steps_carry_units() {
    let place = Place::new();
    place.save("a.npy", &pulse(64, 8));
    let found = |options: &[&str], sidecar: &str| -> (Value, String) {
        place.write("a.npy.toml", sidecar);
        let words = ["analyze", "a.npy", "--figures", "none", "--force"];
        let said = place.good(&[&words[..], options].concat());
        let of_axes = said.lines().find(|line| line.starts_with("field"));
        let first = of_axes.unwrap_or_else(|| panic!("{said}")).to_owned();
        (place.json("a-cascade/summary.json")["field"].clone(), first)
    };
    let cases: [(&[&str], &str); 10] = [
        (&["--dt", "10us", "--dx", "2mm"], ""),
        (&["--dt", "10", "us", "--dx", "2", "mm"], ""),
        (&["--rate=100", "kHz", "--dx", "0.2", "cm"], ""),
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
        assert_eq!(field["dt"], 1e-5, "{options:?}");
        assert_eq!(field["dx"], 0.002, "{options:?}");
        let units = ["time", "frequency", "space", "wavenumber"].map(|of| &field["units"][of]);
        assert_eq!(units, ["s", "Hz", "m", "rad/m"], "{options:?}");
        assert!(first.contains("dt 1e-5 s, dx 0.002 m"), "{first}");
    }
    // In the unit of the axis, where one is stated.
    let (field, first) = found(&["--dt", "10us", "--t0", "-0.3s"], "time_unit = \"ms\"\n");
    assert_eq!(field["dt"], 0.01);
    assert_eq!(field["t0"], -300.0);
    assert_eq!(field["units"]["frequency"], "kHz");
    contains_all(&first, &["dt 0.01 ms, no dx: x counts sites"]);
    // Without steps, the first line says what is counted.
    let (field, first) = found(&[], "");
    let expected = "no dt: time counts samples, no dx: x counts sites";
    assert!(first.contains(expected), "{first}");
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
        contains_all(&place.bad(code, &[&base[..], words].concat()), expected);
    }
}

/// The same record with its times in s and in ms beside a scene in SI: the same energies.
#[test]
fn regress_a_field_beside_an_si_scene_is_put_into_si() {
    let place = Place::new();
    let si = "sites = 6\nmaterial = \"steel\"\nshape = \"sphere\"\nradius = \"9 mm\"\n\
              striker_velocity = \"1 m/s\"\nend_time = 1e-4\nsamples = 201\n";
    place.write("si.toml", si);
    place.good(&["simulate", "si.toml", "--out", "run.npz", "--quiet"]);
    place.save("a.npy", &values(&open(&place, "run.npz")));
    let base = "budget a.npy --scene si.toml";
    let found = |step: &str| -> Value {
        let options = "--noise 1e-6 --figures none --force --json --only wavenumber";
        let mut summary = place.says_json(&format!("{base} {options} {step}"));
        summary["provenance"].take();
        summary
    };
    let seconds = found("--dt 5e-7");
    assert_eq!(found("--dt 5e-4 --time-unit ms"), seconds);
    assert_eq!(found("--dt 0.5us --time-unit ms"), seconds);
    for (words, found) in [
        ("--dt 1 --time-unit ticks", "ticks"),
        ("--dt 1us --unit mm/s", "mm/s"),
    ] {
        let said = place.refuses(2, &format!("{base} --out new {words}"));
        contains_all(&said, &["a.npy", found]);
    }
}

#[test]
fn a_filter_says_what_it_cannot_mean() {
    let place = Place::new();
    place.save("a.npy", &pulse(64, 8));
    let warned = |words: &str| {
        let line = format!("filter a.npy --force --out b.npz {words}");
        let output = place.run(&line.split(' ').collect::<Vec<_>>());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        text(&output.stderr)
    };
    let said = warned("--speed 0.1:3");
    contains_all(&said, &["site per sample", "`--dt` and `--dx`"]);
    assert_eq!(warned("--speed 0.1:3 --dt 2s --dx 3m"), "");
    assert_eq!(warned("--frequency 0:0.2"), "");
    // What passes nothing writes nothing.
    let before = place.names();
    let output = place.run(&["filter", "a.npy", "--frequency", "9:10", "--out", "c.npz"]);
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output.stderr);
    contains_all(&said, &["nothing passes", "0.5000 cycles/sample"]);
    assert_eq!(place.names(), before);
}

#[test]
fn a_filtered_field_is_written_as_its_name_says() {
    let place = Place::new();
    place.save("a.npy", &pulse(64, 8));
    let filter =
        |out: &str| format!("filter a.npy --towards plus-x --dt 10us --unit mm/s --out {out}");
    place.says(&filter("plus.npz"));
    place.says(&filter("plus.npy"));
    let bytes = fs::read(place.path("plus.npy")).unwrap();
    assert!(bytes.starts_with(b"\x93NUMPY"));
    let [array, archive] = ["plus.npy", "plus.npz"].map(|name| open(&place, name));
    assert_eq!(values(&array), values(&archive));
    assert_eq!((&array.time, &array.space), (&archive.time, &archive.space));
    assert_eq!(array.time, axis(1e-5, Some("s")));
    assert_eq!(array.unit, archive.unit);
    // Replaced only if asked for, and only if this program wrote it.
    place.refuses(2, &filter("plus.npy"));
    place.says(&filter("plus.npy --force"));
    place.refuses_for(2, &filter("a.npy --force"), "a.npy");
    for name in ["plus.tsv", "plus.txt", "plus.h5"] {
        contains_all(&place.refuses(2, &filter(name)), &["--out", ".npz"]);
    }
    let said = place.refuses(2, "simulate --sites 3 --end-time 3 --out run.npy");
    assert!(said.contains("--out") && said.contains(".npz"), "{said}");
    // Beside a sidecar under the other name the array would have two.
    place.write("minus.toml", "dt = 1\n");
    place.refuses_for(2, &filter("minus.npy"), "minus.toml");
}

#[test]
fn default_names_of_results_differ() {
    let place = Place::new();
    place.save("travel.npy", &pulse(64, 8));
    let travel = pulse(64, 8);
    savez(
        &place,
        "travel.npz",
        ("v", &travel),
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
fn options_that_contradict_the_file_are_refused() {
    let place = Place::new();
    place.save("a.npy", &pulse(64, 8));
    place.write("a.csv", "1,2\n5,1\n2,2\n");
    let run = "simulate --sites 4 --end-time 4 --samples 65 --quiet --out run.npz";
    place.says(run);
    for (words, option) in [
        ("analyze a.npy --variable v", "--variable"),
        ("analyze a.csv --variable v", "--variable"),
        ("filter a.npy --towards plus-x --variable v", "--variable"),
        ("analyze a.npy --header present", "--header"),
        ("analyze a.npy --time-column 0", "--time-column"),
        (
            "analyze a.npy --short-space-segment 4",
            "--short-time-times",
        ),
        ("analyze a.npy --short-space-hop 4", "--short-time-times"),
    ] {
        place.refuses_for(2, words, option);
    }
}

#[test]
fn messages_name_what_was_typed_and_the_file() {
    let place = Place::new();
    let simulate = |words: &str| {
        let base = "simulate --sites 4 --samples 65 --quiet";
        place.says(&format!("{base} {words}"));
    };
    simulate("--end-time 4 --out plain.npz");
    simulate(
        "--end-time 1e-4 --material steel --shape sphere --radius 9mm --striker-velocity 1 \
              --out si.npz",
    );
    place.save("still.npy", &Array2::<f64>::zeros((64, 4)));
    place.write("nan.csv", "1,2\nnan,1\n2,2\n");
    for (code, words, named, not) in [
        (
            2,
            "compare plain.npz si.npz",
            &["si.npz: ", "plain.npz"][..],
            "--second",
        ),
        (
            2,
            "attenuate --sites 5 --against stiffness_ratio=5:1:3log:2",
            &["--against"],
            "--vary",
        ),
        (
            2,
            "attenuate --sites 5 --against nonsense=1,2",
            &["--against", "nonsense"],
            "--vary",
        ),
        (
            2,
            "attenuate --sites 5 --against angle --vary nonsense=1,2",
            &["--vary", "nonsense"],
            "--against",
        ),
        (
            2,
            "attenuate --sites 5 --against sites",
            &["--against", "KEY=A:B:N"],
            "--vary",
        ),
        (
            2,
            "attenuate --ratios 2 --no-extremes",
            &["--against"],
            "--vary",
        ),
        (
            2,
            "attenuate --sites 5 --against stiffness_ratio --measured 2=still.npy",
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
        let said = place.refuses(code, words);
        contains_all(&said, named);
        assert!(!said.contains(not), "{words}: {said}");
    }
}

/// A word that is no unit is named with what to type, and so is a unit of something else; composed ones and those of
/// devices are not.
#[test]
fn regress_units_that_are_none_are_named() {
    let place = Place::new();
    place.save("a.npy", &pulse(256, 8));
    let said = |options: &str| {
        let step = ["--dx 2mm", ""][usize::from(options.contains("--dx"))];
        let words = format!("analyze a.npy --dt 10us {step} --figures none --force {options}");
        let output = place.run(&words.split_whitespace().collect::<Vec<_>>());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let warnings = place.json("a-cascade/summary.json")["warnings"].to_string();
        (text(&output.stdout) + &text(&output.stderr), warnings)
    };
    for (options, words) in [
        ("--unit banana", ["\"banana\"", "`--unit`, such as m/s"]),
        ("--unit bananas/s", ["\"bananas\"", "`--unit`, such as m/s"]),
        (
            "--unit mm",
            [
                "a unit of displacement, and not of velocity",
                "`--quantity`",
            ],
        ),
        ("--unit m/s^2", ["a unit of acceleration", "`--quantity`"]),
        (
            "--unit ms",
            ["ms is a unit of time", "`--unit`, such as m/s"],
        ),
        (
            "--unit kHz",
            ["kHz is a unit of frequency", "`--unit`, such as m/s"],
        ),
        (
            "--unit m/s --quantity strain-rate",
            ["not of strain rate", "`--quantity`"],
        ),
        (
            "--time-unit ms --space-unit foobar --dx 2",
            ["\"foobar\"", "`--space-unit`, such as m"],
        ),
        (
            "--dx 2 --space-unit ms",
            ["ms is a unit of time, and not of positions", "--layout"],
        ),
    ] {
        let (printed, warnings) = said(options);
        for word in words {
            assert!(printed.contains(word), "{options}: {printed}");
        }
        assert!(warnings.contains("-unit"), "{options}: {warnings}");
    }
    for unit in [
        "m/s",
        "(m/s)",
        "\u{b5}\u{3b5}/s --quantity strain-rate",
        "counts",
        "V",
        "a.u.",
        "v0",
        "mV/(m/s)",
    ] {
        let (printed, warnings) = said(&format!("--unit {unit}"));
        assert!(!printed.contains("--unit"), "{unit}: {printed}");
        assert!(!warnings.contains("-unit"), "{unit}: {warnings}");
    }
}
