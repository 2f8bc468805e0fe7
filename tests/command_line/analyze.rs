//! `cascade analyze` as a stranger meets it: what it writes and prints, and where.

use std::collections::BTreeSet;
use std::fs;

use serde_json::Value;
use test_support::place::{names, set, text};

const FIGURES: [&str; 8] = [
    "along-t",
    "along-x",
    "flux-surrogate",
    "short-time",
    "space-time",
    "spacetime-spectrum",
    "spatial-spectrum",
    "temporal-spectrum",
];

#[test]
fn a_run_leaves_a_result_and_names_its_report() {
    let place = test_support::pulse::place();
    let mut command = place.command(["analyze", "wave.npy", "--out", "new/result"]);
    let output = command.env("COLUMNS", "100").output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let said = text(&output.stdout);
    assert_eq!(place.names(), set(&["new", "wave.npy", "wave.toml"]));
    assert_eq!(names(&place.path("new")), set(&["result"]));
    let result = place.path("new/result");
    let expected = [
        "figures",
        "plot.py",
        "report.html",
        "spectra.npz",
        "summary.json",
    ];
    assert_eq!(names(&result), set(&expected));
    let pictures = FIGURES
        .iter()
        .flat_map(|f| [format!("{f}.png"), format!("{f}.svg")]);
    assert_eq!(names(&result.join("figures")), pictures.collect());
    for name in names(&result.join("figures")) {
        let bytes = fs::read(result.join("figures").join(&name)).unwrap();
        let magic: &[u8] = if name.ends_with("png") {
            b"\x89PNG\r\n\x1a\n"
        } else {
            b"<svg"
        };
        assert!(bytes.starts_with(magic), "{name}");
    }
    let last = said.lines().last().unwrap();
    assert!(last.ends_with("new/result/report.html"), "{last}");
    assert!(said.starts_with("wave: "), "{said}");
    assert!(said.lines().count() <= 12, "a dozen lines:\n{said}");
    assert!(
        said.lines().all(|line| line.chars().count() <= 100),
        "{said}"
    );
    assert!(!said.contains('\x1b'), "{said}");
    let words = [
        "analyze",
        "wave.npy",
        "--out",
        "new/result",
        "--force",
        "-v",
    ];
    let said = text(&place.run(&words).stdout);
    assert!(
        said.contains("dt 0.01 s, dx 0.5 m") && said.contains(" Hz,"),
        "{said}"
    );
}

#[test]
fn the_summary_says_where_it_came_from_and_what_it_read() {
    let place = test_support::pulse::place();
    let words = [
        "analyze",
        "wave.npy",
        "--figures",
        "none",
        "--sites",
        "2:9",
        "--quiet",
    ];
    place.good(&words);
    let summary = place.json("wave-cascade/summary.json");
    assert_eq!(summary["schema"], "cascade.analyze/3");
    let provenance = &summary["provenance"];
    let command = provenance["command"].as_array().unwrap();
    assert!(command[0].as_str().unwrap().ends_with("cascade"));
    assert_eq!(command[1..], words.map(Value::from));
    assert_eq!(provenance["input"], "wave.npy");
    let hash = blake3::hash(&fs::read(place.path("wave.npy")).unwrap());
    assert_eq!(provenance["input_blake3"], hash.to_hex().as_str());
    let field = &summary["field"];
    assert_eq!(field["shape"], Value::from(vec![96, 7]));
    assert_eq!(field["first"], Value::from(vec![0, 2]));
    assert_eq!((&field["dt"], &field["dx"]), (&0.01.into(), &0.5.into()));
    assert_eq!(field["x0"], 1.0);
    assert_eq!(field["units"]["frequency"], "Hz");
    assert_eq!(field["units"]["wavenumber"], "rad/m");
    for part in ["time", "space", "spacetime"] {
        assert!(
            summary["parseval"][part].as_f64().unwrap().abs() <= 1e-13,
            "{part}"
        );
    }
    assert!(summary["direction"]["toward_plus_x"].as_f64().unwrap() > 0.5);
}

#[test]
fn json_is_the_summary_and_nothing_else() {
    let place = test_support::pulse::place();
    let said = place.good(&["analyze", "wave.npy", "--json", "--figures", "none"]);
    let file = fs::read_to_string(place.path("wave-cascade/summary.json")).unwrap();
    assert_eq!(said.trim_end(), file.trim_end());
    let _: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(
        place.good(&["analyze", "wave.npy", "--quiet", "-o", "quiet"]),
        ""
    );
    assert!(place.path("quiet/report.html").exists());
}

#[test]
fn figures_are_those_asked_for() {
    let place = test_support::pulse::place();
    let base = [
        "analyze",
        "wave.npy",
        "--only",
        "temporal,spatial",
        "--force",
        "--figures",
    ];
    let kinds = |figures: &str| -> BTreeSet<String> {
        place.good(&[&base[..], &[figures]].concat());
        let folder = place.path("wave-cascade/figures");
        if !folder.exists() {
            return BTreeSet::new();
        }
        let endings = names(&folder).into_iter();
        endings
            .map(|n| n.rsplit('.').next().unwrap().to_owned())
            .collect()
    };
    assert_eq!(kinds("png"), set(&["png"]));
    assert_eq!(kinds("svg,svg"), set(&["svg"]));
    assert_eq!(kinds("svg,png"), set(&["png", "svg"]));
    assert_eq!(kinds("none"), set(&[]));
    assert!(
        place
            .bad(2, &[&base[..], &["none,png"]].concat())
            .contains("--figures")
    );
}

#[test]
fn figures_follow_style_size_and_colours() {
    let place = test_support::pulse::place();
    let base = ["analyze", "wave.npy", "--only", "temporal", "--force", "-q"];
    let drawn = |options: &[&str]| {
        place.good(&[&base[..], &["--figures", "svg"], options].concat());
        let folder = place.path("wave-cascade/figures");
        fs::read_to_string(folder.join("temporal-spectrum.svg")).unwrap()
    };
    let paper = drawn(&["--style", "paper", "--figure-size", "8.6x7cm", "--db", "40"]);
    assert!(paper.contains("width=\"86.00mm\" height=\"70.00mm\""));
    assert!(paper.contains("dB re"));
    assert!(drawn(&["--colormap", "gray"]) != drawn(&[]));
    assert!(drawn(&["--decades", "3"]).contains("over 3 decades"));

    let refused = |options: &[&str]| place.bad(2, &[&base[..], options].concat());
    for [option, value] in [
        ["--style", "paper"],
        ["--figure-size", "86mm"],
        ["--dpi", "300"],
        ["--colormap", "gray"],
        ["--decades", "3"],
        ["--db", "30"],
    ] {
        let said = refused(&["--figures", "none", option, value]);
        assert!(said.contains(option), "{said}");
    }
    assert!(refused(&["--figures", "svg", "--dpi", "300"]).contains("png"));
    assert!(refused(&["--figure-size", "86mm"]).contains("pt"));
    assert!(refused(&["--figure-size", "wide"]).contains("86x60mm"));
    assert!(refused(&["--db", "40", "--decades", "4"]).contains("--decades"));
}

#[test]
fn only_what_is_asked_for_is_there() {
    const AXES: [&str; 5] = [
        "time",
        "position",
        "frequency",
        "wavenumber",
        "wavenumber_signed",
    ];
    let place = test_support::pulse::place();
    let result = |only: &str| {
        let words = [
            "analyze",
            "wave.npy",
            "--force",
            "--figures",
            "none",
            "--only",
            only,
        ];
        place.good(&words);
        let all = place.arrays("wave-cascade/spectra.npz");
        assert!(
            AXES.iter().all(|axis| all.contains(*axis)),
            "{only}: {all:?}"
        );
        all.into_iter()
            .filter(|n| !AXES.contains(&n.as_str()))
            .collect::<BTreeSet<_>>()
    };
    let along = |what: &str, spectrum: &str| {
        let of = |m: &str| format!("{what}_{m}");
        let measures = [
            "centroid",
            "bandwidth",
            "effective_bandwidth",
            "zero_share",
            "entropy",
            "participation",
            "median",
            "90",
        ];
        let mut names: BTreeSet<String> = measures.map(of).into();
        names.extend([of("energy"), spectrum.into()]);
        names.extend(["low", "high"].map(|band| format!("{band}_{what}_share")));
        names
    };
    let mut temporal = along("frequency", "temporal_spectrum");
    temporal.extend(set(&[
        "front_arrival",
        "low_frequency_share_front",
        "high_frequency_share_front",
    ]));
    assert_eq!(result("temporal"), temporal);
    assert_eq!(result("spatial"), along("wavenumber", "spatial_spectrum"));
    assert_eq!(
        result("spacetime"),
        set(&[
            "spacetime_spectrum",
            "toward_plus_x_share",
            "toward_minus_x_share"
        ])
    );
    assert_eq!(result("flux"), set(&["kinetic_flux_surrogate"]));
    assert_eq!(
        result("short-time"),
        set(&[
            "short_time_spectrum",
            "short_time_frequency",
            "short_time_time",
            "short_time_position"
        ])
    );
}

#[test]
fn a_plan_writes_nothing() {
    let place = test_support::pulse::place();
    let before = place.names();
    let said = place.good(&["analyze", "wave.npy", "--plan"]);
    for word in [
        "along time",
        "along space",
        "space-time",
        "memory",
        "threads",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
    let json = place.good(&["analyze", "wave.npy", "--plan", "--json", "--threads", "3"]);
    let plan: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        plan["arrays"]["temporal_spectrum"],
        Value::from(vec![49, 12])
    );
    assert_eq!(plan["threads"], 3);
    assert_eq!(plan["times"], Value::from(vec![0, 96]));
    assert_eq!(place.names(), before);
}

#[test]
fn a_result_is_replaced_only_by_force() {
    let place = test_support::pulse::place();
    let words = [
        "analyze",
        "wave.npy",
        "--figures",
        "none",
        "--out",
        "result",
    ];
    fs::create_dir(place.path("result")).unwrap();
    place.good(&words);
    let stamp = || fs::read_to_string(place.path("result/summary.json")).unwrap();
    let first = stamp();
    let said = place.bad(2, &words);
    assert!(
        said.contains("result is already there") && said.contains("--force"),
        "{said}"
    );
    assert_eq!(stamp(), first);
    place.good(&[&words[..], &["--force", "--only", "spatial"]].concat());
    assert_ne!(stamp(), first);
    assert_eq!(place.names(), set(&["result", "wave.npy", "wave.toml"]));

    // What no run has written is not removed, force or not.
    fs::write(place.path("result/notes.txt"), "mine").unwrap();
    for taken in ["result", "wave.npy"] {
        let said = place.bad(2, &["analyze", "wave.npy", "--force", "--out", taken]);
        assert!(
            said.contains(taken) && said.contains("not replaced"),
            "{said}"
        );
    }
    for nameless in [".", "..", "/"] {
        let said = place.bad(2, &["analyze", "wave.npy", "--force", "--out", nameless]);
        assert!(said.contains("--out"), "{said}");
    }
}

#[test]
fn pictures_end_where_they_are_told_and_say_what_they_leave_out() {
    let place = test_support::pulse::place();
    let picture = |options: &[&str]| {
        let words = [
            &["analyze", "wave.npy", "--force", "--figures", "svg"],
            options,
        ]
        .concat();
        place.good(&words);
        let read = |file: &str| fs::read_to_string(place.path("wave-cascade").join(file)).unwrap();
        let page = read("report.html");
        (read("figures/spacetime-spectrum.svg"), page)
    };
    // The pulse has energy about 11 Hz of the 50 Hz there are.
    let (figure, page) = picture(&[]);
    assert!(figure.contains("of the energy above ") && figure.contains(" Hz"));
    assert!(page.contains("At first not shown: ") && page.contains("data-home"));
    let (figure, page) = picture(&["--show-frequency", "all", "--show-wavenumber", "all"]);
    assert!(!figure.contains("not shown"));
    let spacetime = page.split("id=\"spacetime\"").nth(1).unwrap();
    let spacetime = spacetime.split("</section>").next().unwrap();
    assert!(!spacetime.contains("not shown"), "{spacetime}");
    let (figure, _) = picture(&["--show-frequency", "10Hz:20Hz", "--show-wavenumber", "4"]);
    assert!(figure.contains("of the energy below 10.4 Hz"), "{figure}");
    assert!(figure.contains("above 19.8 Hz") && figure.contains("beyond ±3.14 rad/m"));
    let [part, whole] = ["20ms:", "all"].map(|time| {
        picture(&["--show-time", time, "--show-space", "1m:4m"]);
        place.array::<f64>("wave-cascade/spectra.npz", "spacetime_spectrum")
    });
    assert_eq!(part, whole);
}

#[test]
fn display_limits_that_show_nothing_are_refused() {
    let place = test_support::pulse::place();
    for (options, named) in [
        (&["--show-frequency", "60Hz"][..], "within 0:50"),
        (&["--show-frequency", "20:10"], "lower one first"),
        (&["--show-frequency", "20 mm"], "HIGH, LOW:HIGH or all"),
        (&["--show-wavenumber", "7rad/m"], "within 0:6.28"),
        (&["--show-time", "2s:3s"], "within 0:0.95"),
        (&["--show-space", "0:9"], "within 0:5.5"),
        (
            &["--show-time", "all", "--figures", "none"],
            "--figures none",
        ),
        (&["--show-frequency", "9", "--only", "flux"], "--only"),
        (&["--show-wavenumber", "2", "--only", "temporal"], "--only"),
    ] {
        let said = place.bad(2, &[&["analyze", "wave.npy"], options].concat());
        assert!(said.contains(named) && said.contains(options[0]), "{said}");
    }
    place.save("bare.npy", &test_support::pulse::wave(32, 8));
    let said = place.bad(2, &["analyze", "bare.npy", "--show-frequency", "2kHz"]);
    assert!(said.contains("the axis has no unit"), "{said}");
}

/// Cells within six decades of the largest reach over half of both axes.
#[test]
fn pictures_of_the_shipped_scenes_are_filled() {
    let scenes = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/scenes");
    let place = test_support::place::Place::new();
    for scene in ["dimer", "quartz_cylinders"] {
        let path = scenes.join(format!("{scene}.toml"));
        place.good(&[
            "simulate",
            path.to_str().unwrap(),
            "--out",
            "run.npz",
            "--force",
        ]);
        let options = wavecascade::field::OpenOptions::default();
        let field = wavecascade::Field::open(place.path("run.npz"), &options).unwrap();
        let request = wavecascade::analyze::Request::default();
        let (analysis, _) = wavecascade::analyze(&field, &request).unwrap();
        let map = analysis.spacetime_map.as_ref().unwrap().shown();
        let level = 1e-6 * map.values.iter().copied().fold(0.0, f32::max);
        let (rows, columns) = map.values.dim();
        let loud = map
            .values
            .indexed_iter()
            .filter(|(_, value)| **value > level);
        let (mut top, mut left, mut right) = (0, columns, 0);
        for ((row, column), _) in loud {
            top = top.max(row + 1);
            (left, right) = (left.min(column), right.max(column + 1));
        }
        assert!(2 * top > rows, "{scene}: {top} of {rows}");
        assert!(
            2 * (right - left) > columns,
            "{scene}: {left}..{right} of {columns}"
        );
        assert!(rows > 60 && columns > 20, "{scene}: {rows} x {columns}");
    }
}

/// The commands that an analysis names at its end, with its options of reading; some need one more word.
#[test]
fn regress_what_is_left_open_is_named_with_commands_that_run() {
    let place = test_support::place::Place::new();
    place.save("noise.npy", &test_support::fields::noise(1024, 20));
    let words = [
        "analyze",
        "noise.npy",
        "--rate",
        "1kHz",
        "--figures",
        "none",
        "--verbose",
    ];
    let mut command = place.command(words);
    let output = command.env("COLUMNS", "200").output().unwrap();
    let said = text(&output.stdout);
    let named = "cascade COMMAND noise.npy --rate 1kHz\n";
    assert!(said.contains(named), "{said}");
    for name in [
        "(ridges, spectrum --along both)",
        "(spectrum)",
        "(coherence)",
        "(bicoherence)",
    ] {
        assert!(said.contains(name), "{name}\n{said}");
    }
    for name in ["ridges", "spectrum", "coherence", "bicoherence"] {
        let words = [
            name,
            "noise.npy",
            "--rate",
            "1kHz",
            "--figures",
            "none",
            "--quiet",
        ];
        assert_eq!(place.run(&words).status.code(), Some(0), "{name}");
    }
    // One pulse has no intervals: repeated records are named.
    let place = test_support::pulse::place();
    let words = ["analyze", "wave.npy", "--figures", "none", "--verbose"];
    let said = place.good(&words);
    assert!(
        said.contains("repeated") && !said.contains("coherence wave.npy"),
        "{said}"
    );
}
