//! The program as a stranger meets it: what it writes and prints, how it fails, what it leaves.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use ndarray::{Array1, Array2, ArrayD};
use ndarray_npy::{NpzReader, WritableElement, write_npy};
use serde_json::Value;

const SIDECAR: &str =
    "dt = 0.01\ndx = 0.5\ntime_unit = \"s\"\nspace_unit = \"m\"\nunit = \"m/s\"\n";

/// A directory with a pulse that travels to +x, `wave.npy`, and its sidecar.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let place = Place::empty();
        write_npy(place.path("wave.npy"), &wave(96, 12)).unwrap();
        fs::write(place.path("wave.toml"), SIDECAR).unwrap();
        place
    }

    fn empty() -> Self {
        Place(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.path().join(name)
    }

    fn names(&self) -> BTreeSet<String> {
        names(self.0.path())
    }

    fn save<T: WritableElement>(&self, name: &str, field: &Array2<T>) {
        write_npy(self.path(name), field).unwrap();
    }

    fn command(&self, words: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Command {
        let mut command = Command::cargo_bin("cascade").unwrap();
        command.current_dir(self.0.path()).args(words);
        command
    }

    fn run(&self, words: &[&str]) -> Output {
        self.command(words).output().unwrap()
    }

    /// Runs to a good end and returns standard output.
    fn good(&self, words: &[&str]) -> String {
        let output = self.run(words);
        assert_eq!(output.status.code(), Some(0), "{words:?}: {output:?}");
        assert_eq!(text(&output.stderr), "", "{words:?}");
        text(&output.stdout)
    }

    /// Runs to a failure that leaves the place as it was, and returns standard error.
    fn bad(&self, code: i32, words: &[&str]) -> String {
        let before = self.names();
        let output = self.run(words);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{words:?}: {said}");
        assert_eq!(text(&output.stdout), "", "{words:?}");
        assert!(said.starts_with("error: "), "{words:?}: {said}");
        assert!(!said.contains("panicked"), "{words:?}: {said}");
        assert_eq!(self.names(), before, "{words:?}: {said}");
        said
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(name)).unwrap()).unwrap()
    }
}

fn wave(n_times: usize, n_sites: usize) -> Array2<f64> {
    Array2::from_shape_fn((n_times, n_sites), |(i, j)| {
        let s = i as f64 - 2.0 * j as f64 - 24.0;
        (-(s / 8.0).powi(2)).exp() * (0.7 * s).sin()
    })
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn names(directory: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(directory).unwrap();
    let name = |e: std::io::Result<fs::DirEntry>| e.unwrap().file_name().into_string().unwrap();
    entries.map(name).collect()
}

fn set(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|&n| n.to_owned()).collect()
}

fn arrays(path: &Path) -> BTreeSet<String> {
    let mut reader = NpzReader::new(fs::File::open(path).unwrap()).unwrap();
    let names = reader.names().unwrap();
    names
        .iter()
        .map(|n| n.trim_end_matches(".npy").to_owned())
        .collect()
}

fn array<T: ndarray_npy::ReadableElement>(path: &Path, name: &str) -> ArrayD<T> {
    let mut reader = NpzReader::new(fs::File::open(path).unwrap()).unwrap();
    reader.by_name(&format!("{name}.npy")).unwrap()
}

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
    let place = Place::new();
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
    let place = Place::new();
    let words = ["analyze", "wave.npy", "--figures", "none", "--sites", "2:9"];
    place.good(&words);
    let summary = place.json("wave-cascade/summary.json");
    assert_eq!(summary["schema"], "cascade.analyze/1");
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
    let place = Place::new();
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
    let place = Place::new();
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
    let place = Place::new();
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
        let all = arrays(&place.path("wave-cascade/spectra.npz"));
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
    assert_eq!(result("temporal"), along("frequency", "temporal_spectrum"));
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
    let place = Place::new();
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
    let place = Place::new();
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
fn help_and_manuals_are_there() {
    let place = Place::empty();
    let version = place.good(&["--version"]);
    assert_eq!(version, format!("cascade {}\n", env!("CARGO_PKG_VERSION")));
    for (words, holds) in [
        (&["--help"][..], "analyze"),
        (&["analyze", "--help"], "sidecar"),
        (&["analyze", "-h"], "--window-time"),
        (&["completions", "bash"], "complete"),
        (&["completions", "zsh"], "#compdef cascade"),
        (&["completions", "fish"], "complete -c cascade"),
        (&["man"], ".TH"),
        (&["man", "analyze"], "window\\-time"),
    ] {
        let said = place.good(words);
        assert!(said.contains(holds), "{words:?}: {said}");
    }
    assert!(place.bad(2, &["man", "bogus"]).contains("analyze"));
    assert!(place.bad(2, &["completions", "bogus"]).contains("zsh"));
    assert!(place.bad(2, &["analyze"]).contains("<FIELD>"));
}

/// Options that do not fit, with what the message must name.
#[test]
fn options_that_do_not_fit_are_named_with_what_was_expected_and_found() {
    let place = Place::new();
    let cases: [(&[&str], &[&str]); 44] = [
        (&["--segment", "97"], &["--segment", "1 to 96", "97"]),
        (&["--segment", "0"], &["--segment", "1 to 96", "0"]),
        (
            &["--segment", "32", "--overlap", "32"],
            &["--overlap", "32"],
        ),
        (
            &["--segment", "32", "--overlap", "1.5"],
            &["--overlap", "share"],
        ),
        (&["--overlap", "3"], &["--segment"]),
        (&["--pad-time", "95"], &["--pad-time", "96", "95"]),
        (&["--pad-space", "11"], &["--pad-space", "12", "11"]),
        (&["--sites", "3:13"], &["--sites", "0:12", "3:13"]),
        (&["--sites", "5:5"], &["--sites", "empty"]),
        (&["--sites", "5"], &["--sites", "FIRST:END"]),
        (&["--times", "1:2"], &["--times", "0 to 0.95", "1:2"]),
        (&["--times", "0.011:0.019"], &["--times", "0.011:0.019"]),
        (&["--times=-2:-1"], &["--times", "0 to 0.95", "-2:-1"]),
        (&["--times", "0.5:0.1"], &["--times", "lower one first"]),
        (
            &["--times", "0:1", "--until-arrival"],
            &["--times", "--until-arrival"],
        ),
        (&["--arrival-threshold", "0.1"], &["--until-arrival"]),
        (
            &["--until-arrival", "--arrival-threshold", "2"],
            &["--arrival-threshold", "2"],
        ),
        (
            &["--until-arrival", "--arrival-threshold", "-2"],
            &["--arrival-threshold", "-2"],
        ),
        (
            &["--window-time", "bartlet"],
            &["--window-time", "hann", "bartlet"],
        ),
        (
            &["--window-time", "hann:3"],
            &["--window-time", "without a parameter"],
        ),
        (
            &["--window-time", "tukey:x"],
            &["--window-time", "number", "tukey:x"],
        ),
        (
            &["--window-space", "tukey:2"],
            &["--window-space", "0 to 1", "2"],
        ),
        (
            &["--window-time", "dpss:49"],
            &["--window-time", "below 48.5", "49"],
        ),
        (
            &["--window-space", "dpss:7"],
            &["--window-space", "below 6.5", "7"],
        ),
        (
            &["--window-time", "dpss:9", "--segment", "16"],
            &["--window-time", "8.5", "9"],
        ),
        (
            &["--short-time-window", "dpss:9"],
            &["--short-time-window", "8.5", "9"],
        ),
        (
            &["--band-edge-frequency", "-3"],
            &["--band-edge-frequency", "at least 0", "-3"],
        ),
        (
            &["--band-edge-wavenumber", "-1"],
            &["--band-edge-wavenumber", "at least 0", "-1"],
        ),
        (
            &["--reference-site", "12"],
            &["--reference-site", "0:12", "12"],
        ),
        (
            &["--reference-site", "1", "--sites", "2:5"],
            &["--reference-site", "2:5", "1"],
        ),
        (
            &["--reference-time", "1"],
            &["--reference-time", "0 to 0.95", "1"],
        ),
        (
            &["--direction-band", "2:1"],
            &["--direction-band", "lower one first"],
        ),
        (
            &["--short-time-sites", "0,12"],
            &["--short-time-sites", "0:12", "12"],
        ),
        (
            &["--short-time-times", "7"],
            &["--short-time-times", "0 to 0.95", "7"],
        ),
        (
            &["--short-time-segment", "97"],
            &["--short-time-segment", "1 to 96", "97"],
        ),
        (&["--short-time-hop", "0"], &["--short-time-hop", "0"]),
        (&["--short-space-hop", "0"], &["--short-space-hop", "0"]),
        (&["--threads", "0"], &["--threads", "1", "0"]),
        (&["--threads", "100000"], &["--threads", "1024", "100000"]),
        (&["--memory", "1MB"], &["memory", "976.57 KiB", "--memory"]),
        (&["--memory", "lots"], &["--memory", "2GiB", "lots"]),
        (
            &["--pad-time", "1000000000000000"],
            &["memory", "TiB", "--memory"],
        ),
        (&["--dt", "-1"], &["--dt", "above 0", "-1"]),
        (
            &["--only", "everything"],
            &["--only", "temporal", "everything"],
        ),
    ];
    for (options, expected) in cases {
        let said = place.bad(2, &[&["analyze", "wave.npy"], options].concat());
        for part in expected {
            assert!(said.contains(part), "{options:?}: {part:?} not in {said}");
        }
    }
}

#[test]
fn intervals_may_be_open_and_the_wave_is_cut_where_it_arrives() {
    let place = Place::new();
    for (options, shape) in [
        (&["--times", ":"][..], [96, 12]),
        (&["--times", "0.5:"], [46, 12]),
        (&["--times=-1:0.1"], [11, 12]),
        (&["--times", "0.1:9e99"], [86, 12]),
        // At site 11 the pulse first exceeds 1 % of its peak, 0.91, at s = -16: in row 30.
        (&["--until-arrival"], [30, 12]),
    ] {
        let base = [
            "analyze",
            "wave.npy",
            "--json",
            "--force",
            "--figures",
            "none",
        ];
        let said = place.good(&[&base[..], options].concat());
        let summary: Value = serde_json::from_str(&said).unwrap();
        assert_eq!(
            summary["field"]["shape"],
            Value::from(shape.to_vec()),
            "{options:?}"
        );
    }
}

#[test]
fn inputs_that_cannot_be_read_are_named_with_advice() {
    let place = Place::new();
    let whole = fs::read(place.path("wave.npy")).unwrap();
    fs::write(place.path("cut.npy"), &whole[..whole.len() / 2]).unwrap();
    fs::write(place.path("long.npy"), [&whole[..], b"tail"].concat()).unwrap();
    fs::write(place.path("head.npy"), &whole[..40]).unwrap();
    fs::write(place.path("empty.npy"), b"").unwrap();
    fs::write(place.path("noise.npy"), b"no array at all").unwrap();
    fs::write(place.path("field.mat"), b"MATLAB 5.0 MAT-file").unwrap();
    fs::create_dir(place.path("folder")).unwrap();
    fs::write(place.path("worded.npy"), &whole).unwrap();
    fs::write(place.path("worded.toml"), "dt = 0.01\ndz = 1.0\n").unwrap();
    let mut holes = wave(96, 12);
    holes[[10, 3]] = f64::NAN;
    holes[[11, 3]] = f64::INFINITY;
    holes[[70, 5]] = f64::NAN;
    place.save("holes.npy", &holes);
    for (name, expected) in [
        ("missing.npy", "No such file"),
        ("folder", "directory"),
        ("cut.npy", "truncated"),
        ("long.npy", "bytes"),
        ("head.npy", "bytes"),
        ("empty.npy", "empty"),
        ("noise.npy", "NUMPY"),
        ("field.mat", "MATLAB"),
        ("worded.npy", "worded.toml"),
        ("worded.npy", "dz"),
        ("worded.npy", "line 2"),
        ("holes.npy", "found 3 that are not"),
        ("holes.npy", "first at time row 10, site 3; 2 of 12 sites"),
        ("holes.npy", "--gaps interpolate"),
    ] {
        for options in [&[][..], &["--json"], &["--quiet"]] {
            let said = place.bad(1, &[&["analyze", name], options].concat());
            let named = if name == "worded.npy" {
                "worded.toml"
            } else {
                name
            };
            assert!(
                said.contains(named) && said.contains(expected),
                "{name}: {said}"
            );
            assert!(said.contains("\nhelp: "), "{name}: {said}");
        }
    }
    place.good(&["analyze", "holes.npy", "--gaps", "interpolate", "-q"]);
}

#[test]
fn places_that_cannot_be_written_are_named_with_advice() {
    let place = Place::new();
    for out in ["wave.npy/result", "wave.npy/deep/result", "/proc/result"] {
        let said = place.bad(1, &["analyze", "wave.npy", "--out", out]);
        assert!(
            said.contains(out.rsplit_once('/').unwrap().0),
            "{out}: {said}"
        );
        assert!(said.contains("--out"), "{out}: {said}");
    }
    // Directories made on the way go again.
    place.bad(1, &["analyze", "missing.npy", "--out", "a/b/result"]);
    place.bad(
        2,
        &[
            "analyze",
            "wave.npy",
            "--out",
            "a/b/result",
            "--pad-time",
            "2",
        ],
    );
}

#[test]
fn fields_of_a_few_samples_and_of_zeros_are_analysed() {
    let place = Place::empty();
    let noise = |(i, j): (usize, usize)| (1.0 + i as f64 * 1.7 + j as f64 * 2.3).sin();
    for shape in [(1, 1), (1, 5), (5, 1), (2, 1), (1, 2), (2, 2), (3, 3)] {
        place.save("small.npy", &Array2::from_shape_fn(shape, noise));
        well_formed(&place, "small.npy");
    }
    place.save("zeros.npy", &Array2::<f64>::zeros((16, 8)));
    let summary = well_formed(&place, "zeros.npy");
    assert!(summary["direction"]["undirected"].is_null());
    assert!(summary["low_high"]["frequency"]["edge"].is_null());
}

/// Runs with figures: a summary without NaN, pictures that open.
fn well_formed(place: &Place, name: &str) -> Value {
    let said = place.good(&["analyze", name, "--force", "--out", "out"]);
    assert!(!said.contains("NaN") && !said.contains("inf"), "{said}");
    let json = fs::read_to_string(place.path("out/summary.json")).unwrap();
    assert!(
        !json.contains("NaN") && !json.contains("Infinity"),
        "{json}"
    );
    let figures = names(&place.path("out/figures"));
    assert!(figures.len() >= 14, "{figures:?}");
    for figure in figures {
        let bytes = fs::read(place.path("out/figures").join(&figure)).unwrap();
        if figure.ends_with("png") {
            let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes))
                .read_info()
                .unwrap();
            let mut pixels = vec![0; decoder.output_buffer_size().unwrap()];
            decoder.next_frame(&mut pixels).unwrap();
        } else {
            let svg = text(&bytes);
            assert!(svg.trim_end().ends_with("</svg>"), "{figure}");
            assert!(!svg.contains("NaN") && !svg.contains("\"inf"), "{figure}");
        }
    }
    serde_json::from_str(&json).unwrap()
}

#[test]
fn single_precision_is_stored_as_such() {
    let place = Place::new();
    let base = ["analyze", "wave.npy", "--figures", "none", "-q", "--out"];
    place.good(&[&base[..], &["double"]].concat());
    place.good(&[&base[..], &["single", "--precision", "f32"]].concat());
    let (double, single) = (
        place.path("double/spectra.npz"),
        place.path("single/spectra.npz"),
    );
    assert_eq!(arrays(&double), arrays(&single));
    for name in arrays(&single) {
        let (a, b) = (array::<f64>(&double, &name), array::<f32>(&single, &name));
        assert_eq!(a.shape(), b.shape(), "{name}");
    }
    let (a, b) = ("temporal_spectrum", 1e-6);
    close(&array(&double, a), &array(&single, a), b);
    close(
        &array(&double, "spacetime_spectrum"),
        &array(&single, "spacetime_spectrum"),
        1e-6,
    );
    assert_eq!(
        place.json("single/summary.json")["accuracy"]["precision"],
        "f32"
    );
}

fn close(a: &ArrayD<f64>, b: &ArrayD<f32>, tolerance: f64) {
    let peak = a.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    assert!(peak > 0.0);
    for (x, y) in a.iter().zip(b) {
        assert!((x - f64::from(*y)).abs() <= tolerance * peak);
    }
}

#[test]
fn the_layout_only_names_the_axes() {
    let place = Place::new();
    place.save(
        "turned.npy",
        &wave(96, 12).t().as_standard_layout().into_owned(),
    );
    fs::copy(place.path("wave.toml"), place.path("turned.toml")).unwrap();
    let base = ["--figures", "none", "-q"];
    place.good(&[&["analyze", "wave.npy"], &base[..]].concat());
    place.good(
        &[
            &["analyze", "turned.npy", "--layout", "site-time"],
            &base[..],
        ]
        .concat(),
    );
    assert_eq!(
        fs::read(place.path("wave-cascade/spectra.npz")).unwrap(),
        fs::read(place.path("turned-cascade/spectra.npz")).unwrap()
    );
    // An option goes over the sidecar.
    let wrong = format!("{SIDECAR}layout = \"time-site\"\n");
    fs::write(place.path("turned.toml"), wrong).unwrap();
    let words = [
        "analyze",
        "turned.npy",
        "--layout",
        "site-time",
        "--dt",
        "0.5",
        "--json",
    ];
    let said = place.good(&[&words[..], &["--force", "--figures", "none"]].concat());
    let summary: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(summary["field"]["shape"], Value::from(vec![96, 12]));
    assert_eq!(summary["field"]["dt"], 0.5);
}

#[test]
fn an_axis_without_a_unit_says_so() {
    let place = Place::new();
    fs::remove_file(place.path("wave.toml")).unwrap();
    let units = |options: &[&str]| {
        let base = ["analyze", "wave.npy", "--json", "--force"];
        let said = place.good(&[&base[..], options].concat());
        let summary: Value = serde_json::from_str(&said).unwrap();
        let page = fs::read_to_string(place.path("wave-cascade/report.html")).unwrap();
        let of = |axis: &str| summary["field"]["units"][axis].as_str().map(str::to_owned);
        (
            of("frequency").unwrap(),
            of("wavenumber").unwrap(),
            page.contains("time (samples)"),
        )
    };
    assert_eq!(
        units(&[]),
        ("cycles/sample".into(), "rad/site".into(), true)
    );
    let stepped = (
        "cycles/unit of time".into(),
        "rad/unit of length".into(),
        false,
    );
    assert_eq!(units(&["--dt", "0.01", "--dx", "2"]), stepped);
    let named = ["--dt", "10", "--time-unit", "ms", "--space-unit", "mm"];
    assert_eq!(units(&named), ("cycles/ms".into(), "rad/mm".into(), false));
}

#[test]
fn arrays_read_back_with_their_axes() {
    let place = Place::new();
    place.good(&[
        "analyze",
        "wave.npy",
        "--figures",
        "none",
        "-q",
        "--scaling",
        "density",
    ]);
    let npz = place.path("wave-cascade/spectra.npz");
    let frequency: ArrayD<f64> = array(&npz, "frequency");
    let spectrum: ArrayD<f64> = array(&npz, "temporal_spectrum");
    assert_eq!(spectrum.shape(), [49, 12]);
    assert_eq!(frequency.len(), 49);
    let df = frequency[[1]] - frequency[[0]];
    let field = wave(96, 12);
    for (site, record) in field.columns().into_iter().enumerate() {
        let mean_square = record.iter().map(|v| v * v).sum::<f64>() / 96.0;
        let bins: Array1<f64> = (0..49).map(|m| spectrum[[m, site]]).collect();
        assert!((bins.sum() * df / mean_square - 1.0).abs() < 1e-13);
    }
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::io::{BufRead, BufReader, Read};
    use std::process::{Child, Command, Stdio};
    use std::time::{Duration, Instant};

    fn program() -> PathBuf {
        PathBuf::from(env!("CARGO_BIN_EXE_cascade"))
    }

    fn shell(place: &Place, script: &str) -> Output {
        Command::new("sh")
            .args(["-c", script, "sh"])
            .arg(program())
            .current_dir(place.0.path())
            .output()
            .unwrap()
    }

    #[test]
    fn a_reader_that_goes_away_is_no_failure() {
        let place = Place::new();
        let words = ["analyze", "wave.npy", "--json", "--figures", "none"];
        for words in [&words[..], &["man", "analyze"], &["completions", "zsh"]] {
            let mut child = Command::new(program())
                .args(words)
                .current_dir(place.0.path())
                .stdout(Stdio::piped())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap();
            drop(child.stdout.take());
            let output = child.wait_with_output().unwrap();
            assert_eq!(
                (output.status.code(), text(&output.stderr)),
                (Some(0), String::new())
            );
        }
        assert!(place.path("wave-cascade/summary.json").exists());
        let closed = shell(
            &place,
            "\"$1\" analyze wave.npy -o b --figures none >&- 2>&-",
        );
        assert_eq!(closed.status.code(), Some(0));
        assert!(place.path("b/summary.json").exists());
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn output_that_cannot_be_written_is_a_failure() {
        let place = Place::new();
        let full = shell(&place, "\"$1\" analyze wave.npy --figures none >/dev/full");
        assert_eq!(full.status.code(), Some(1));
        assert!(text(&full.stderr).contains("standard output"), "{full:?}");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_name_that_is_no_text_is_still_a_name() {
        use std::os::unix::ffi::OsStrExt;
        let place = Place::new();
        let name = OsStr::from_bytes(b"wave\xff.npy");
        fs::rename(place.path("wave.npy"), place.path(name)).unwrap();
        let words = [
            OsStr::new("analyze"),
            name,
            OsStr::new("--out"),
            OsStr::new("result"),
        ];
        place.command(words).assert().success();
    }

    #[test]
    fn a_full_disk_leaves_nothing() {
        let place = Place::new();
        let before = place.names();
        let limited = "trap '' XFSZ; ulimit -f 8; exec \"$1\" analyze wave.npy --out a/full";
        let output = shell(&place, limited);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(
            said.contains("full") && said.contains("free some space"),
            "{said}"
        );
        assert_eq!(place.names(), before);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_file_system_leaves_nothing() {
        let place = Place::new();
        fs::create_dir(place.path("disk")).unwrap();
        let mount = "mount -t tmpfs -o size=256k none disk";
        let privileged = |script: &str| {
            Command::new("unshare")
                .args(["-rm", "sh", "-c", script, "sh"])
                .arg(program())
                .current_dir(place.0.path())
                .output()
        };
        if !privileged(mount).is_ok_and(|output| output.status.success()) {
            eprintln!("SKIPPED: this machine does not let a test mount a file system");
            return;
        }
        for figures in ["none", "png"] {
            let options = format!("--memory 1GB --pad-time 3000 --figures {figures}");
            let script = format!(
                "{mount} && \"$1\" analyze wave.npy --out disk/full {options}; \
                                  echo \"$?\"; ls -A disk"
            );
            let output = privileged(&script).unwrap();
            let said = text(&output.stderr);
            assert_eq!(text(&output.stdout), "1\n", "{said}");
            assert!(said.contains("No space left"), "{said}");
            assert!(said.contains("free some space"), "{said}");
        }
    }

    /// A field of zeros but for one sample, without its blocks on the disk.
    fn sparse(place: &Place, name: &str, n_times: u64, n_sites: u64) {
        use std::io::{Seek, SeekFrom, Write};
        let mut header = format!(
            "{{'descr': '<f8', 'fortran_order': False, 'shape': ({n_times}, {n_sites}), }}"
        );
        while (header.len() + 11) % 64 != 0 {
            header.push(' ');
        }
        header.push('\n');
        let mut file = fs::File::create(place.path(name)).unwrap();
        file.write_all(b"\x93NUMPY\x01\x00").unwrap();
        file.write_all(&(header.len() as u16).to_le_bytes())
            .unwrap();
        file.write_all(header.as_bytes()).unwrap();
        file.write_all(&1f64.to_le_bytes()).unwrap();
        let end = 10 + header.len() as u64 + 8 * n_times * n_sites;
        file.seek(SeekFrom::Start(end - 8)).unwrap();
        file.write_all(&1f64.to_le_bytes()).unwrap();
    }

    fn start(place: &Place, words: &[&str]) -> Child {
        Command::new(program())
            .args(words)
            .current_dir(place.0.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    }

    fn signal(child: &Child, name: &str) {
        let sent = Command::new("kill")
            .args(["-s", name, &child.id().to_string()])
            .status();
        assert!(sent.unwrap().success());
    }

    fn partial(place: &Place) -> Option<String> {
        place
            .names()
            .into_iter()
            .find(|name| name.contains(".partial-"))
    }

    fn wait_for(child: &mut Child, mut seen: impl FnMut() -> bool) {
        let started = Instant::now();
        while !seen() {
            assert!(child.try_wait().unwrap().is_none(), "it ended too soon");
            assert!(started.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Sends `name` and expects the end that an interrupt has, soon, with nothing left.
    fn ends(place: &Place, mut child: Child, name: &str, before: &BTreeSet<String>) {
        let sent = Instant::now();
        signal(&child, name);
        let status = child.wait().unwrap();
        assert!(
            sent.elapsed() < Duration::from_secs(2),
            "{name}: {:?}",
            sent.elapsed()
        );
        let mut said = String::new();
        child
            .stderr
            .take()
            .unwrap()
            .read_to_string(&mut said)
            .unwrap();
        assert_eq!(status.code(), Some(130), "{name}: {said}");
        assert_eq!(said, "error: cancelled; nothing was written\n");
        assert_eq!(&place.names(), before, "{name}");
    }

    #[test]
    fn an_interrupt_ends_a_run_soon_and_leaves_nothing() {
        let place = Place::empty();
        sparse(&place, "long.npy", 40_000, 400);
        let before = place.names();
        let words = [
            "analyze",
            "long.npy",
            "--out",
            "new/long",
            "--window-time",
            "hann",
        ];
        for (name, wait) in [("INT", 0), ("TERM", 100), ("INT", 300)] {
            let mut child = start(&place, &words);
            let written = || {
                place.path("new").exists()
                    && names(&place.path("new"))
                        .iter()
                        .any(|n| place.path("new").join(n).join("spectra.npz").exists())
            };
            wait_for(&mut child, written);
            std::thread::sleep(Duration::from_millis(wait));
            ends(&place, child, name, &before);
        }
    }

    /// Pages of the field count as memory that is allowed; those of the program come on top.
    #[test]
    #[cfg(target_os = "linux")]
    fn a_field_larger_than_memory_keeps_to_it() {
        const ALLOWED: u64 = 100_000_000;
        const PROGRAM: u64 = 14 << 20;
        let place = Place::empty();
        sparse(&place, "large.npy", 8192, 2048);
        let words = "analyze large.npy --only temporal --figures none --threads 2 --memory 100MB";
        let mut child = start(&place, &words.split(' ').collect::<Vec<_>>());
        let status = format!("/proc/{}/status", child.id());
        let mut peak = 0;
        while child.try_wait().unwrap().is_none() {
            let said = fs::read_to_string(&status).unwrap_or_default();
            let line = said.lines().find_map(|line| line.strip_prefix("VmHWM:"));
            let kib = line.and_then(|rest| rest.trim().strip_suffix(" kB"));
            peak = kib.map_or(peak, |kib| 1024 * kib.parse::<u64>().unwrap());
            std::thread::sleep(Duration::from_millis(2));
        }
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!((ALLOWED / 2..ALLOWED + PROGRAM).contains(&peak), "{peak}");
    }

    /// What is read must be what is hashed.
    #[test]
    fn a_field_that_changes_while_it_is_read_gives_no_result() {
        use std::os::unix::fs::FileExt;

        let place = Place::empty();
        sparse(&place, "other.npy", 40_000, 400);
        let changes: [fn(&Place); 3] = [
            |place| fs::rename(place.path("other.npy"), place.path("long.npy")).unwrap(),
            |place| {
                let file = fs::File::options().write(true).open(place.path("long.npy"));
                file.unwrap().write_all_at(b"change", 1000).unwrap();
            },
            |place| fs::remove_file(place.path("long.npy")).unwrap(),
        ];
        let said = [
            "expected the file that was opened, found another in its place",
            "expected no modification since it was opened, found one",
            "cannot read",
        ];
        for (change, said) in changes.into_iter().zip(said) {
            sparse(&place, "long.npy", 40_000, 400);
            let mut child = start(&place, &["analyze", "long.npy", "--out", "result"]);
            wait_for(&mut child, || {
                let folder = partial(&place);
                folder.is_some_and(|name| place.path(&name).join("spectra.npz").exists())
            });
            change(&place);
            let output = child.wait_with_output().unwrap();
            let found = text(&output.stderr);
            assert_eq!(output.status.code(), Some(1), "{found}");
            assert!(
                found.contains("long.npy") && found.contains(said),
                "{found}"
            );
            let left = place.names();
            assert!(left.iter().all(|name| name.ends_with(".npy")), "{left:?}");
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn an_interrupt_while_the_input_is_hashed_ends_at_once() {
        let place = Place::empty();
        // 40 GiB of nothing take seconds to hash, and no disk.
        sparse(&place, "huge.npy", 5 << 20, 1 << 10);
        let before = place.names();
        for name in ["INT", "TERM"] {
            let mut child = start(&place, &["analyze", "huge.npy", "--memory", "1TB"]);
            let listens = format!("/proc/{}/task", child.id());
            wait_for(&mut child, || {
                fs::read_dir(&listens).is_ok_and(|t| t.count() > 2)
            });
            ends(&place, child, name, &before);
        }
    }

    #[test]
    fn what_a_killed_run_leaves_disturbs_no_other() {
        let place = Place::new();
        sparse(&place, "long.npy", 40_000, 400);
        let mut child = start(&place, &["analyze", "long.npy", "--out", "result"]);
        wait_for(&mut child, || partial(&place).is_some());
        signal(&child, "KILL");
        child.wait().unwrap();
        let left = partial(&place);
        place.good(&[
            "analyze",
            "wave.npy",
            "--out",
            "result",
            "--figures",
            "none",
        ]);
        place.good(&[
            "analyze",
            "wave.npy",
            "--out",
            "result",
            "--figures",
            "none",
            "--force",
        ]);
        assert_eq!(partial(&place), left);
        assert!(place.path("result/summary.json").exists());
    }

    /// On a terminal a bar may come; it goes again, and lines keep to the width.
    #[test]
    #[cfg(target_os = "linux")]
    fn on_a_terminal_the_bar_goes_away_again() {
        let place = Place::new();
        sparse(&place, "long.npy", 20_000, 60);
        let script = |columns: u32, command: &str| {
            let line = format!(
                "stty cols {columns} rows 40; {} {command}",
                program().display()
            );
            Command::new("script")
                .args(["-qec", &line, "/dev/null"])
                .stdin(Stdio::null())
                .current_dir(place.0.path())
                .output()
        };
        let Ok(short) = script(80, "analyze wave.npy --figures none") else {
            eprintln!("SKIPPED: this machine has no `script` to make a terminal with");
            return;
        };
        let said = text(&short.stdout);
        assert!(short.status.success(), "{said}");
        assert!(!said.contains('%') || said.contains("90 %"), "{said}");
        assert!(
            said.lines()
                .all(|line| line.trim_end().chars().count() <= 80),
            "{said}"
        );
        assert!(
            !said.contains("left"),
            "a run this short shows no bar: {said:?}"
        );
        let long = script(120, "analyze long.npy --figures none").unwrap();
        let said = text(&long.stdout);
        assert!(long.status.success(), "{said}");
        let last = said.lines().last().unwrap();
        assert!(last.contains("done in") && !last.contains('█'), "{last:?}");
    }

    #[test]
    fn without_a_terminal_there_is_no_bar() {
        let place = Place::new();
        sparse(&place, "long.npy", 20_000, 60);
        let child = start(&place, &["analyze", "long.npy", "--figures", "none"]);
        let output = child.wait_with_output().unwrap();
        assert_eq!(text(&output.stderr), "");
        assert!(!text(&output.stdout).contains('\x1b'));
        let lines = BufReader::new(&output.stdout[..]).lines();
        assert!(lines.map(Result::unwrap).all(|l| l.chars().count() <= 100));
    }
}
