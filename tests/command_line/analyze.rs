//! `cascade analyze` as a stranger meets it: what it writes and prints, and where.

use std::collections::BTreeSet;
use std::fs;

use serde_json::Value;
use test_support::place::{names, set};

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
    let said = place.good(&["analyze", "wave.npy", "--out", "new/result"]);
    assert_eq!(place.names(), set(&["new", "wave.npy", "wave.toml"]));
    assert_eq!(names(&place.path("new")), set(&["result"]));
    let result = place.path("new/result");
    let expected = ["figures", "report.html", "spectra.npz", "summary.json"];
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
    assert!(said.lines().count() <= 24, "one screen:\n{said}");
    assert!(
        said.lines().all(|line| line.chars().count() <= 100),
        "{said}"
    );
    assert!(!said.contains('\x1b'), "{said}");
    assert!(
        said.contains("dt 0.01 s, dx 0.5 m") && said.contains(" Hz,"),
        "{said}"
    );
}

#[test]
fn the_summary_says_where_it_came_from_and_what_it_read() {
    let place = test_support::pulse::place();
    let words = ["analyze", "wave.npy", "--figures", "none", "--sites", "2:9"];
    place.good(&words);
    let summary = place.json("wave-cascade/summary.json");
    assert_eq!(summary["schema"], "cascade.analyze/2");
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
