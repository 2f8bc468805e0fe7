//! `cascade budget` and `compare`, and what `cascade analyze` says of them, as a stranger meets them.

use std::fs;
use std::path::PathBuf;

use ndarray::{Array1, Array2};
use ndarray_npy::NpzReader;
use serde_json::Value;
use test_support::contains_all;
use test_support::place::Place;
use wavecascade_formats::{Container, Format, Options};

/// With a localized and a dispersive run in it.
fn with_runs() -> Place {
    let place = Place::new();
    for (name, ratio) in [("loc.npz", "4.9272"), ("dis.npz", "2.398")] {
        let scene = ["--sites", "40", "--end-time", "38", "--samples", "257"];
        let run = [
            &["simulate", "-q", "--out", name, "--stiffness-ratio", ratio],
            &scene[..],
        ];
        place.good(&run.concat());
    }
    place
}

fn container(place: &Place, name: &str) -> Container {
    let bytes = fs::read(place.path(name)).unwrap();
    let format = Format::detect(name, &bytes).unwrap();
    wavecascade_formats::open(format, std::sync::Arc::new(bytes), &Options::default()).unwrap()
}

fn summary_in(place: &Place, name: &str) -> Value {
    let text = fs::read_to_string(place.path(name).join("summary.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn names_in(path: PathBuf) -> Vec<String> {
    let entries = fs::read_dir(path).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_run_to_its_budgets() {
    let place = with_runs();
    let words = ["budget", "loc.npz", "--out", "b", "--between", "3:17"];
    let said = place.good(&words);
    let first = said.lines().next().unwrap();
    assert!(first.starts_with("loc.npz: "), "{said}");
    assert!(first.contains("% of the energy passes k = "), "{said}");
    assert!(!said.contains("gain 1/2"), "{said}");
    assert!(said.lines().count() <= 12, "{said}");
    let said = place.good(&[&words[..], &["--force", "--verbose"]].concat());
    for word in [
        "gain 1/2",
        "residual, real space",
        "residual, wavenumber",
        "frequency",
        "residual, scale",
        "b/report.html",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
    assert_eq!(
        names_in(place.path("b")),
        [
            "budget.npz",
            "figures",
            "plot.py",
            "report.html",
            "summary.json"
        ]
    );
    let drawn = names_in(place.path("b").join("figures"));
    for name in [
        "energies",
        "energy-flux",
        "energy-passed",
        "power-flow",
        "energy-spectrum",
        "spectral-flux",
        "scale-flux",
        "views",
    ] {
        assert!(drawn.contains(&format!("{name}.png")), "{drawn:?}");
    }
    let summary = summary_in(&place, "b");
    assert_eq!(summary["schema"], "cascade.budget/2");
    // The first line says which way, as the number has it.
    let share = summary["wavenumber"]["largest_passage"]["share"].as_f64();
    let towards = if share.unwrap() > 0.0 {
        "higher"
    } else {
        "lower"
    };
    let answer = summary["answer"].as_str().unwrap();
    contains_all(&answer, &[&format!("to {towards} wavenumbers (net)")]);
    assert_eq!(
        summary["provenance"]["input_blake3"].as_str().map(str::len),
        Some(64)
    );
    let closure = &summary["closure"];
    assert_eq!(closure["integration"], "stepping");
    for (name, limit) in [
        ("real_space", 1e-10),
        ("wavenumber", 1e-11),
        ("frequency", 1e-9),
        ("scale", 1e-10),
    ] {
        let residual = closure[name].as_f64().unwrap();
        assert!(residual > 0.0 && residual < limit, "{name} {residual:e}");
    }
    assert!(closure.get("reasons").is_none());
    assert!(closure["departure"].as_f64().unwrap() < 1e-8);
    let between = summary["frequency"]["between"].as_array().unwrap();
    assert_eq!(between[3]["contacts"], serde_json::json!([3, 17]));
    for between in summary["frequency"]["between"].as_array().unwrap() {
        let of = |name: &str| between[name].as_f64().unwrap();
        assert!((of("low") + of("high") + of("behind")).abs() < 1e-15);
    }
    for scale in summary["scale"].as_array().unwrap() {
        let of = |name: &str| scale[name].as_f64().unwrap();
        assert!((of("sigma") - of("scale") / 12f64.sqrt()).abs() < 1e-12);
        assert!(of("cutoff_wavenumber") > 0.0 && scale["filter"] == "gaussian");
    }

    let mut arrays = NpzReader::new(fs::File::open(place.path("b/budget.npz")).unwrap()).unwrap();
    let mut line = |name: &str| -> Array1<f64> { arrays.by_name(name).unwrap() };
    let (time, k, f) = (line("time"), line("wavenumber"), line("frequency"));
    let (kinetic, contact) = (line("kinetic_energy"), line("contact_energy"));
    let mut table = |name: &str| -> Array2<f64> { arrays.by_name(name).unwrap() };
    let spectrum = table("energy_spectrum");
    assert_eq!(spectrum.dim(), (time.len(), k.len()));
    for (i, row) in spectrum.rows().into_iter().enumerate() {
        assert!((row.sum() - kinetic[i] - contact[i]).abs() < 1e-14);
    }
    for (name, shape) in [
        ("transfer", (257, 21)),
        ("spectral_flux", (257, 21)),
        ("integrated_spectral_flux", (257, 21)),
        ("site_energy", (257, 40)),
        ("energy_flux", (257, 40)),
        ("energy_passed", (257, 40)),
        ("power_flow", (f.len(), 40)),
        ("scale_flux", (257, 40)),
    ] {
        assert_eq!(table(name).dim(), shape, "{name}");
    }
    // df times the sum is what passed by the end.
    let (flow, passed) = (table("power_flow"), table("energy_passed"));
    let cumulative = table("cumulative_power_flow");
    for j in 0..39 {
        let sum = flow.column(j).sum() * f[1];
        assert!((sum - passed[[256, j]]).abs() < 1e-3, "{j}");
        assert!((cumulative[[f.len() - 1, j]] - sum).abs() < 1e-13, "{j}");
    }
}

/// Every array of the archive is in the NetCDF file, bit for bit, with coordinates, and the script reads it.
#[test]
fn regress_budgets_are_the_same_in_both_formats() {
    let place = with_runs();
    let options = ["--from-samples", "--figures", "none", "--quiet"];
    place.good(&[&["budget", "dis.npz", "--out", "zip"][..], &options].concat());
    let words = ["budget", "dis.npz", "--out", "nc", "--format", "netcdf"];
    place.good(&[&words[..], &options].concat());
    assert_eq!(
        names_in(place.path("nc")),
        ["budget.nc", "plot.py", "summary.json"]
    );
    let script = place.read("nc/plot.py");
    assert!(script.contains("budget.nc"), "{script}");
    assert!(!script.contains(".npz"), "{script}");
    let found = container(&place, "nc/budget.nc");
    let names = place.arrays("zip/budget.npz");
    assert!(names.len() >= 30, "{names:?}");
    assert_eq!(found.variables.len(), names.len());
    for name in &names {
        let expected = place.array::<f64>("zip/budget.npz", name);
        let i = found.find(name).unwrap_or_else(|| panic!("{name}"));
        let numbers = found.numbers(i).unwrap();
        assert!(
            numbers
                .iter()
                .map(|v| v.to_bits())
                .eq(expected.iter().map(|v| v.to_bits())),
            "{name}"
        );
        let variable = &found.variables[i];
        let shape: Vec<usize> = variable.shape().iter().map(|&len| len as usize).collect();
        assert_eq!(shape, expected.shape(), "{name}");
        assert!(
            variable.dimensions.iter().all(|d| d.coordinate.is_some()),
            "{name}: {:?}",
            variable.dimensions
        );
        assert!(variable.attributes.text("long_name").is_some(), "{name}");
    }
    let summary = summary_in(&place, "nc");
    assert_eq!(found.attributes.text("schema"), summary["schema"].as_str());
    assert_eq!(found.attributes.text("input"), Some("dis.npz"));
    assert_eq!(
        found.attributes.number("closure_wavenumber"),
        summary["closure"]["wavenumber"].as_f64()
    );
    assert_eq!(
        found.attributes.number("wavenumber_band_edge"),
        summary["wavenumber"]["band_edge"].as_f64()
    );
    // A result in either format is one that can be replaced.
    place.good(
        &[
            &["budget", "dis.npz", "--out", "nc", "--force"][..],
            &options,
        ]
        .concat(),
    );
    assert_eq!(
        names_in(place.path("nc")),
        ["budget.npz", "plot.py", "summary.json"]
    );
}

#[test]
fn choices_of_a_budget() {
    let place = with_runs();
    let text = place.says("budget dis.npz --out c --from-samples --only wavenumber --figures none --json --window-sites 2:9 --band-edge-wavenumber 1.5");
    let summary: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(summary, summary_in(&place, "c"));
    assert_eq!(
        names_in(place.path("c")),
        ["budget.npz", "plot.py", "summary.json"]
    );
    let closure = &summary["closure"];
    assert_eq!(closure["integration"], "samples");
    assert!(closure["scale"].is_null() && closure["reasons"]["scale"] == "not asked for");
    assert!(summary["frequency"].is_null() && summary["wavenumber"]["band_edge"] == 1.5);
    place.bad(2, &["budget", "dis.npz", "--out", "c"]);
    place.says("budget dis.npz --out c --force --from-samples -q");

    place.refuses_for(2, "budget dis.npz --filter sharp", "gaussian");
    place.bad(2, &["budget", "dis.npz", "--scales", "-2"]);
    for scale in ["30", "39", "80", "1e12", "1e-300"] {
        let said = place.bad(2, &["budget", "dis.npz", "--scales", &format!("4,{scale}")]);
        assert!(said.contains("scale"), "{said}");
    }
    place.bad(2, &["budget", "dis.npz", "--between", "3:99"]);
    place.bad(2, &["budget", "dis.npz", "--between", "3"]);
    place.bad(2, &["budget", "dis.npz", "--window-samples", "5:9999"]);
    place.bad(1, &["budget", "absent.npz"]);
    place.write("text.npz", "no archive");
    place.refuses_for(2, "budget text.npz", "--scene");
    place.says("simulate -q --out v.npz --sites 8 --end-time 9 --record force");
    place.refuses_for(2, "budget v.npz", "displacements");
}

#[test]
fn a_run_against_a_field_says_which_comes_first() {
    let place = with_runs();
    place.save("field.npy", &ndarray::Array2::from_elem((5, 32), 1.0));
    let said = place.refuses(2, "compare loc.npz field.npy");
    assert!(said.contains("a measured field stands first"), "{said}");
}

#[test]
fn two_runs_on_one_page() {
    let place = with_runs();
    let said = place.says("compare loc.npz dis.npz --out d --from-samples");
    contains_all(&said, &["second less first", "passed the middle"]);
    assert_eq!(
        names_in(place.path("d")),
        ["figures", "report.html", "summary.json"]
    );
    let summary = summary_in(&place, "d");
    assert_eq!(summary["schema"], "cascade.compare/2");
    let of = |which: &str| {
        summary[which]["wavenumber"]["share_passed"]
            .as_f64()
            .unwrap()
    };
    let difference = summary["difference"]["wavenumber"]["share_passed"]
        .as_f64()
        .unwrap();
    assert!((of("second") - of("first") - difference).abs() < 1e-15);
    let page = place.read("d/report.html");
    assert!(page.contains("Two energy budgets: loc and dis"));
    // Five kinds of maps of both runs.
    assert_eq!(page.matches("class=\"picture\"").count(), 10);
    place.bad(2, &["compare", "loc.npz"]);
    place.bad(1, &["compare", "loc.npz", "absent.npz"]);
}

#[test]
fn an_analysis_of_a_run_names_its_budget_and_has_none_of_its_own() {
    let place = with_runs();
    let said = place.good(&["analyze", "loc.npz", "--out", "a", "--figures", "none"]);
    let last = said.trim_end().lines().next_back().unwrap();
    assert!(last.contains("cascade budget loc.npz"), "{said}");
    assert!(summary_in(&place, "a").get("closure").is_none());
    assert!(!place.path("a/budget.npz").exists());
    place.refuses_for(2, "analyze loc.npz --only budget", "budget");

    // A field carries no chain.
    let field = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/examples/data/lattice_impact.npy"
    );
    let said = place.good(&["analyze", field, "--out", "f", "--figures", "none"]);
    assert!(!said.contains("cascade budget"), "{said}");
}

#[test]
fn a_measured_field_with_its_chain() {
    let place = with_runs();
    let chain = "sites = 40\nstiffness_ratio = 4.9272\nend_time = 30.0\nsamples = 1501\n";
    place.write("chain.toml", chain);
    place.good(&["simulate", "chain.toml", "--out", "m.npz", "-q"]);
    let mut run = NpzReader::new(fs::File::open(place.path("m.npz")).unwrap()).unwrap();
    let mut velocity: Array2<f64> = run.by_name("velocity").unwrap();
    // Twelve draws of a linear congruence are as good as normal here.
    let mut state = 1u64;
    let mut noise = || -> f64 {
        (0..12).fold(-6.0, |sum, _| {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            sum + (state >> 11) as f64 / (1u64 << 53) as f64
        })
    };
    velocity.mapv_inplace(|v| v + 1e-3 * noise());
    ndarray_npy::write_npy(place.path("m.npy"), &velocity).unwrap();
    let measured = ["budget", "m.npy", "--scene", "chain.toml", "--dt", "0.02"];
    let said = place.good(&[&measured[..], &["--out", "m", "--verbose"]].concat());
    contains_all(&said, &["energy given", "warning"]);
    // No number of the energies, bands and shares without its error.
    for line in ["energy  ", "wavenumber  ", "frequency  "] {
        let line = said.lines().find(|said| said.starts_with(line));
        assert!(line.unwrap().contains('\u{b1}'), "{said}");
    }
    let summary = summary_in(&place, "m");
    let of = |name: &str| summary["measured"]["energy"][name].as_f64().unwrap();
    let (value, error) = (of("value"), of("error"));
    assert!((value - 0.5).abs() < 3.0 * error, "{value} {error}");
    assert!(error < 0.01, "{value} {error}");
    let mut arrays = NpzReader::new(fs::File::open(place.path("m/budget.npz")).unwrap()).unwrap();
    let force: Array2<f64> = arrays.by_name("force").unwrap();
    let error: Array2<f64> = arrays.by_name("force_error").unwrap();
    assert_eq!((force.dim(), error.dim()), ((1501, 40), (1501, 40)));
    for name in [
        "transfer",
        "spectral_flux",
        "integrated_spectral_flux",
        "energy_spectrum",
        "power_flow",
        "scale_flux",
    ] {
        let array: Array2<f64> = arrays.by_name(name).unwrap();
        let error: Array2<f64> = arrays.by_name(&format!("{name}_error")).unwrap();
        assert_eq!(array.dim(), error.dim(), "{name}");
        assert!(error.iter().any(|error| *error > 0.0), "{name}");
    }
    let error = |summary: &Value| {
        summary["wavenumber"]["share_passed_error"]
            .as_f64()
            .unwrap()
    };
    let exact = error(&summary);
    assert!((1e-4..0.02).contains(&exact), "{exact}");
    for (name, at) in [("energy", "end"), ("wavenumber", "centroid_end")] {
        assert!(
            summary[name]["errors"][at].as_f64().unwrap() > 0.0,
            "{name}"
        );
    }
    assert!(
        summary["frequency"]["between"][2]["low_error"]
            .as_f64()
            .unwrap()
            > 0.0
    );
    assert!(
        summary["scale"][0]["integrated_flux_error"]
            .as_f64()
            .unwrap()
            > 0.0
    );

    // Gains that are not known to a hundredth leave no direction.
    let uncertain = ["--gain-error", "5%", "--out", "uncertain"];
    let said = place.good(&[&measured[..], &uncertain].concat());
    assert!(said.contains("no direction is resolved"), "{said}");
    let summary = summary_in(&place, "uncertain");
    assert!(error(&summary) > 5.0 * exact);
    assert_eq!(summary["wavenumber"]["direction"], "unresolved");
    let said = place.bad(2, &[&measured[..], &["--gain-error", "1,2"]].concat());
    assert!(said.contains("1%"), "{said}");
    let said = place.bad(2, &[&measured[..], &["--mass-error", "0.1,0.2"]].concat());
    assert!(
        said.contains("--mass-error") && said.contains("40"),
        "{said}"
    );
    place.refuses_for(2, "budget loc.npz --coefficient-error 0.1", "--scene");

    place.refuses_for(2, "budget m.npy --scene chain.toml", "dt");
    place.refuses_for(2, "budget loc.npz --dt 0.1", "--scene");
    velocity.mapv_inplace(|v| v + noise());
    ndarray_npy::write_npy(place.path("loud.npy"), &velocity).unwrap();
    let loud = [
        "budget",
        "loud.npy",
        "--scene",
        "chain.toml",
        "--dt",
        "0.02",
    ];
    let said = place.bad(1, &loud);
    assert!(said.contains("standard error"), "{said}");
    place.bad(2, &[&measured[..], &["--missing", "77"]].concat());
}
