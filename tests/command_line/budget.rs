//! `cascade budget` and `compare`, and what `cascade analyze` says of them, as a stranger meets them.

use ndarray::Ix2;
use serde_json::Value;
use test_support::contains_all;
use test_support::place::{Place, names, set};

/// With a localized and a dispersive run in it.
fn with_runs() -> Place {
    let place = Place::new();
    for (name, ratio) in [("loc.npz", "4.9272"), ("dis.npz", "2.398")] {
        let scene = "--sites 40 --end-time 38 --samples 257";
        place.says(&format!(
            "simulate -q --out {name} --stiffness-ratio {ratio} {scene}"
        ));
    }
    place
}

fn summary_in(place: &Place, name: &str) -> Value {
    place.json(&format!("{name}/summary.json"))
}

#[test]
fn a_run_to_its_budgets() {
    let place = with_runs();
    let words = "budget loc.npz --out b --between 3:17";
    let said = place.says(words);
    let first = said.lines().next().unwrap();
    assert!(first.starts_with("loc.npz: "), "{said}");
    assert!(first.contains("% of the energy passes k = "), "{said}");
    assert!(!said.contains("residual, real space"), "{said}");
    assert!(said.lines().count() <= 12, "{said}");
    let said = place.says(&format!("{words} --force --verbose"));
    for word in [
        "residual, real space",
        "residual, wavenumber",
        "frequency",
        "residual, scale",
        "b/report.html",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
    assert_eq!(
        names(&place.path("b")),
        set(&[
            "budget.npz",
            "figures",
            "plot.py",
            "report.html",
            "summary.json"
        ])
    );
    let drawn = names(&place.path("b/figures"));
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
    let towards = ["lower", "higher"][usize::from(share.unwrap() > 0.0)];
    let answer = summary["answer"].as_str().unwrap();
    contains_all(answer, &[&format!("to {towards} wavenumbers (net)")]);
    let hash = summary["provenance"]["input_blake3"].as_str();
    assert_eq!(hash.map(str::len), Some(64));
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

    let array = |name: &str| place.array::<f64>("b/budget.npz", name);
    let [time, k, f] = ["time", "wavenumber", "frequency"].map(array);
    let [kinetic, contact] = ["kinetic_energy", "contact_energy"].map(array);
    let table = |name: &str| array(name).into_dimensionality::<Ix2>().unwrap();
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

#[test]
fn choices_of_a_budget() {
    let place = with_runs();
    let chosen = "--only wavenumber --window-sites 2:9 --band-edge-wavenumber 1.5";
    let summary = place.says_json(&format!(
        "budget dis.npz --out c --from-samples --figures none --json {chosen}"
    ));
    assert_eq!(summary, summary_in(&place, "c"));
    assert_eq!(
        names(&place.path("c")),
        set(&["budget.npz", "plot.py", "summary.json"])
    );
    let closure = &summary["closure"];
    assert_eq!(closure["integration"], "samples");
    assert!(closure["scale"].is_null() && closure["reasons"]["scale"] == "not asked for");
    assert!(summary["frequency"].is_null() && summary["wavenumber"]["band_edge"] == 1.5);
    place.bad(2, &["budget", "dis.npz", "--out", "c"]);
    place.says("budget dis.npz --out c --force --from-samples -q");
}

#[test]
fn two_runs_on_one_page() {
    let place = with_runs();
    let said = place.says("compare loc.npz dis.npz --out d --from-samples");
    contains_all(&said, &["second less first", "passed the middle"]);
    assert_eq!(
        names(&place.path("d")),
        set(&["figures", "report.html", "summary.json"])
    );
    let summary = summary_in(&place, "d");
    assert_eq!(summary["schema"], "cascade.compare/2");
    let of = |which: &str| {
        let share = &summary[which]["wavenumber"]["share_passed"];
        share.as_f64().unwrap()
    };
    assert!((of("second") - of("first") - of("difference")).abs() < 1e-15);
    let page = place.read("d/report.html");
    assert!(page.contains("Two energy budgets: loc and dis"));
    // Five kinds of maps of both runs.
    assert_eq!(page.matches("class=\"picture\"").count(), 10);
}

#[test]
fn a_measured_field_with_its_chain() {
    let place = with_runs();
    let chain = "sites = 40\nstiffness_ratio = 4.9272\nend_time = 30.0\nsamples = 1501\n";
    place.write("chain.toml", chain);
    place.good(&["simulate", "chain.toml", "--out", "m.npz", "-q"]);
    let mut velocity = place.array::<f64>("m.npz", "velocity");
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
    let measured = "budget m.npy --scene chain.toml --dt 0.02";
    let said = place.says(&format!("{measured} --out m --verbose"));
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
    let array = |name: &str| place.array::<f64>("m/budget.npz", name);
    for name in ["force", "force_error"] {
        assert_eq!(array(name).shape(), [1501, 40]);
    }
    for name in [
        "transfer",
        "spectral_flux",
        "integrated_spectral_flux",
        "energy_spectrum",
        "power_flow",
        "scale_flux",
    ] {
        let error = array(&format!("{name}_error"));
        assert_eq!(array(name).shape(), error.shape(), "{name}");
        assert!(error.iter().any(|error| *error > 0.0), "{name}");
    }
    let error = |summary: &Value| {
        let error = &summary["wavenumber"]["share_passed_error"];
        error.as_f64().unwrap()
    };
    let exact = error(&summary);
    assert!((1e-4..0.02).contains(&exact), "{exact}");
    for error in [
        &summary["energy"]["errors"]["end"],
        &summary["wavenumber"]["errors"]["centroid_end"],
        &summary["frequency"]["between"][2]["low_error"],
        &summary["scale"][0]["integrated_flux_error"],
    ] {
        assert!(error.as_f64().unwrap() > 0.0, "{summary}");
    }

    // Gains that are not known to a hundredth leave no direction.
    let said = place.says(&format!("{measured} --gain-error 5% --out uncertain"));
    assert!(said.contains("no direction is resolved"), "{said}");
    let summary = summary_in(&place, "uncertain");
    assert!(error(&summary) > 5.0 * exact);
    assert_eq!(summary["wavenumber"]["direction"], "unresolved");
    place.refuses_for(2, &format!("{measured} --gain-error 1,2"), "1%");
    let said = place.refuses(2, &format!("{measured} --mass-error 0.1,0.2"));
    contains_all(&said, &["--mass-error", "40"]);

    velocity.mapv_inplace(|v| v + noise());
    ndarray_npy::write_npy(place.path("loud.npy"), &velocity).unwrap();
    let loud = measured.replace("m.npy", "loud.npy");
    place.refuses_for(1, &loud, "standard error");
    place.refuses(2, &format!("{measured} --missing 77"));
}
