//! `--dispersion`, and the scripts that draw results with matplotlib.

use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use ndarray::{Array1, Array2, Ix1, Ix2};

use test_support::place::Place;

const LATTICE: &str = "lattice_impact.npy";

/// A folder with the harmonic lattice of the examples.
fn lattice() -> Place {
    let place = Place::of(&["analyze"]);
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data");
    for name in [LATTICE, "lattice_impact.toml"] {
        fs::copy(data.join(name), place.path(name)).unwrap();
    }
    place
}

/// Wavenumbers and frequencies of the curves in an archive.
fn curves(place: &Place, out: &str) -> (Array1<f64>, Array2<f64>) {
    let archive = format!("{out}/spectra.npz");
    let k = place.array::<f64>(&archive, "dispersion_wavenumber");
    let f = place.array::<f64>(&archive, "dispersion_frequency");
    (
        k.into_dimensionality::<Ix1>().unwrap(),
        f.into_dimensionality::<Ix2>().unwrap(),
    )
}

/// An analysis of the lattice, with more options.
const QUICK: [&str; 6] = [
    LATTICE,
    "--only",
    "spacetime",
    "--figures",
    "none",
    "--quiet",
];

fn quick<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&QUICK[..], more].concat()
}

#[test]
fn val_brillouin_the_example_shows_the_curve_of_its_sidecar() {
    let place = lattice();
    place.says(&format!("{LATTICE} --only spacetime --figures svg --out a"));
    let (k, f) = curves(&place, "a");
    assert_eq!((k[0], f.nrows()), (-PI, 1));
    for (k, f) in k.iter().zip(f.row(0)) {
        assert!((f - (0.5 * k).sin().abs() / PI).abs() < 1e-12, "{k}: {f}");
    }
    let svg = place.read("a/figures/spacetime-spectrum.svg");
    assert!(svg.contains("2*sqrt(c/m)*abs(sin(k*a/2))"), "the legend");
    let page = place.read("a/report.html");
    assert!(page.contains("Dashed curves: 2*sqrt(c/m)*abs(sin(k*a/2))."));
    assert!(page.contains("\"lines\":[{\"name\":\"2*sqrt"));

    place.good(&quick(&["--dispersion", "none", "--out", "b"]));
    let arrays = place.arrays("b/spectra.npz");
    assert!(!arrays.contains("dispersion_frequency"));
}

#[test]
fn val_kittel_relations_are_formulas_lattices_and_tables() {
    let place = lattice();
    place.write("curve.csv", "k,f,omega_2\n0,0.25,\n2,0.5,3\n");
    place.good(&quick(&[
        "--dispersion",
        "diatomic:c1=1,c2=4,m1=1,m2=1",
        "--dispersion",
        "speed*k",
        "--dispersion",
        "curve.csv",
        "--dispersion-constants",
        "speed=0.5",
        "--out",
        "a",
    ]));
    let (k, f) = curves(&place, "a");
    // Two branches, one, and two.
    assert_eq!(f.nrows(), 5);
    let at = |wanted: f64| k.iter().position(|k| (k - wanted).abs() < 1e-9).unwrap();
    let (zero, edge) = (at(0.0), at(PI / 2.0));
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found}");
    near(f[(0, zero)], 0.0);
    near(f[(1, zero)], 10f64.sqrt() / TAU);
    near(f[(0, edge)], 2f64.sqrt() / TAU);
    near(f[(1, edge)], 8f64.sqrt() / TAU);
    near(f[(2, edge)], 0.5 * PI / 2.0 / TAU);
    assert!(f[(2, at(-PI / 2.0))].is_nan(), "one direction");
    near(f[(3, edge)], 0.25 + 0.125 * PI / 2.0);
    near(f[(3, at(-PI / 2.0))], 0.25 + 0.125 * PI / 2.0);
    assert!(f[(4, edge)].is_nan() && f[(3, k.len() - 1)].is_nan());
}

/// Of each wavenumber of a struck spring dimer, the strongest frequency lies on a branch.
#[test]
fn val_kittel_the_ridge_of_a_simulated_chain_lies_on_its_branches() {
    let place = Place::new();
    let scene = "simulate --law spring --sites 128 --stiffness-ratio 3 --ends periodic \
                 --end-time 400 --samples 1601 --quiet --out run.npz";
    place.says(scene);
    place
        .says("analyze run.npz --only spacetime --figures none --window-time hann --out a --quiet");
    let (k, branches) = curves(&place, "a");
    assert_eq!(branches.nrows(), 2);
    let archive = "a/spectra.npz";
    let axis = place.array::<f64>(archive, "wavenumber_signed");
    let frequency = place.array::<f64>(archive, "frequency");
    let spectrum = place.array::<f64>(archive, "spacetime_spectrum");
    let spectrum = spectrum.into_dimensionality::<Ix2>().unwrap();
    for (column, at) in spectrum.columns().into_iter().zip(&axis) {
        if at.abs() < 0.2 {
            continue;
        }
        let by_power = |a: &usize, b: &usize| column[*a].total_cmp(&column[*b]);
        let ridge = frequency[(0..frequency.len()).max_by(by_power).unwrap()];
        let near = k.iter().position(|k| k >= at).unwrap();
        let nearest = branches.column(near);
        let off = nearest
            .iter()
            .map(|f| (f - ridge).abs())
            .fold(1.0, f64::min);
        assert!(off < 1.5 * frequency[1], "{at}: {off}");
    }
}

/// A Python with matplotlib, if there is one.
fn python() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let named = std::env::var_os("PAGES_PYTHON").map(|path| root.join(path));
    let found = named.into_iter().chain(["python3".into()]).find(|python| {
        let import = Command::new(python)
            .args(["-c", "import numpy, matplotlib"])
            .output();
        import.is_ok_and(|output| output.status.success())
    });
    if found.is_none() {
        eprintln!("skipped: the scripts need Python with numpy and matplotlib");
    }
    found
}

#[test]
fn scripts_draw_every_kind_of_result() {
    let Some(python) = python() else { return };
    let place = Place::new();
    let run = "simulate --sites 24 --end-time 20 --samples 128 --quiet --out run.npz";
    for line in [
        run,
        "analyze run.npz --figures none --quiet --dispersion 0.5*k --out analyze",
        "budget run.npz --figures none --quiet --out budget",
        "sweep --sites 8 --end-time 8 --vary stiffness_ratio=1,2,3 --quiet --out sweep",
        "attenuate --ratios 4 --bodies 8 --sense chain --quiet --out attenuate",
        "attenuate --against stiffness_ratio=1:3:4 --no-extremes --sites 8 --quiet --out transmit",
        "localize --order 2..3 --quiet --out localize",
    ] {
        place.says(line);
    }
    for (folder, picture) in [
        ("analyze", "plot-spacetime_spectrum.png"),
        ("analyze", "plot-temporal_spectrum.png"),
        ("budget", "plot-energy_flux.png"),
        ("sweep", "plot-curves.png"),
        ("attenuate", "plot-curves.png"),
        ("transmit", "plot-curves.png"),
        ("localize", "plot-curves.png"),
    ] {
        let script = place.path(format!("{folder}/plot.py"));
        let drawn = Command::new(&python)
            .arg(&script)
            .env("MPLBACKEND", "agg")
            .output()
            .unwrap();
        let said = test_support::place::text(&drawn.stderr);
        assert!(drawn.status.success(), "{folder}: {said}");
        let picture = fs::read(place.path(format!("{folder}/{picture}"))).unwrap();
        assert!(picture.starts_with(b"\x89PNG"), "{folder}");
        assert!(picture.len() > 4000, "{folder}");
    }
    // Pictures of the script are replaced with the result.
    place.says("analyze run.npz --figures none --quiet --out analyze --force");
}
