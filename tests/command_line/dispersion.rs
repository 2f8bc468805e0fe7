//! Branches of a chain and the ridges of its field, and the scripts that draw results with matplotlib.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use ndarray::Ix2;

use test_support::place::Place;

/// Of each wavenumber of a struck spring dimer, the strongest frequency lies on a branch.
#[test]
fn val_kittel_the_ridge_of_a_simulated_chain_lies_on_its_branches() {
    let place = Place::new();
    let scene = "simulate --law spring --sites 128 --stiffness-ratio 3 --ends periodic \
                 --end-time 400 --samples 1601 --quiet --out run.npz";
    place.says(scene);
    place
        .says("analyze run.npz --only spacetime --figures none --window-time hann --out a --quiet");
    let array = |name: &str| place.array::<f64>("a/spectra.npz", name);
    let matrix = |name: &str| array(name).into_dimensionality::<Ix2>().unwrap();
    let (k, branches) = (
        array("dispersion_wavenumber"),
        matrix("dispersion_frequency"),
    );
    assert_eq!(branches.nrows(), 2);
    let (axis, frequency) = (array("wavenumber_signed"), array("frequency"));
    let spectrum = matrix("spacetime_spectrum");
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
